//! Directions about a surface point on a picture that keeps solid angles.
//!
//! A hemisphere is a disk: the direction with angle θ to the normal is at `√(1 - cos θ)` of its
//! radius (Lambert's azimuthal equal-area projection), so that every pixel stands for as many
//! steradians. The viewer is below: the direction that light is mirrored into is straight above the
//! viewer's. Where light passes through the surface, a second disk on the right has the directions
//! behind it, seen as through glass.

use glam::Vec3;

use crate::math::Frame;

/// A picture of directions.
#[derive(Clone, Copy, Debug)]
pub struct DirectionMap {
    frame: Frame,
    edge: usize,
    n_disks: usize,
}

impl DirectionMap {
    /// Of the side of `normal`, and of the other one too if `is_whole`; `wo` is the direction to
    /// the viewer. `edge` pixels are the diameter of a disk.
    #[must_use]
    pub fn new(normal: Vec3, wo: Vec3, edge: usize, is_whole: bool) -> Self {
        let away = normal * normal.dot(wo) - wo;
        let y = if away.length_squared() > 1e-6 {
            away.normalize()
        } else {
            Frame::from_z(normal).y
        };
        Self {
            frame: Frame {
                x: y.cross(normal),
                y,
                z: normal,
            },
            edge: edge.max(1),
            n_disks: if is_whole { 2 } else { 1 },
        }
    }

    /// Pixels per row, and rows.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        (self.n_disks * self.edge, self.edge)
    }

    /// One for a hemisphere, two for the sphere.
    #[must_use]
    pub fn n_disks(&self) -> usize {
        self.n_disks
    }

    /// What a pixel stands for, steradians.
    #[must_use]
    pub fn solid_angle(&self) -> f32 {
        // π (edge/2)² pixels are 2π.
        8.0 / (self.edge * self.edge) as f32
    }

    /// The direction at a place of the picture, pixels from its upper left corner; `None` outside
    /// of its disks.
    #[must_use]
    pub fn direction(&self, [x, y]: [f32; 2]) -> Option<Vec3> {
        let edge = self.edge as f32;
        let is_behind = x >= edge;
        let px = 2.0 * (x - if is_behind { edge } else { 0.0 }) / edge - 1.0;
        let py = 1.0 - 2.0 * y / edge;
        let squared = px * px + py * py;
        if squared >= 1.0 {
            return None;
        }
        let stretch = (2.0 - squared).sqrt();
        let z = (1.0 - squared) * if is_behind { -1.0 } else { 1.0 };
        let local = Vec3::new(px * stretch, py * stretch, z);
        Some(self.frame.world_from_local(local).normalize())
    }

    /// The place of a direction; `None` if it is behind the surface, and that is not shown.
    #[must_use]
    pub fn place(&self, direction: Vec3) -> Option<[f32; 2]> {
        let local = self.frame.local_from_world(direction);
        let is_behind = local.z < 0.0;
        if is_behind && self.n_disks == 1 {
            return None;
        }
        let stretch = (1.0 + local.z.abs()).sqrt();
        let (px, py) = (local.x / stretch, local.y / stretch);
        let edge = self.edge as f32;
        let left = if is_behind { edge } else { 0.0 };
        Some([left + 0.5 * (px + 1.0) * edge, 0.5 * (1.0 - py) * edge])
    }

    /// Cosine of a direction with the normal, not negative.
    #[must_use]
    pub fn cos(&self, direction: Vec3) -> f32 {
        self.frame.z.dot(direction).abs()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::DirectionMap;

    fn map(is_whole: bool) -> DirectionMap {
        let (normal, wo) = (Vec3::new(1.0, 2.0, -2.0) / 3.0, Vec3::new(0.6, 0.8, 0.0));
        DirectionMap::new(normal, wo, 64, is_whole)
    }

    #[test]
    fn directions_have_one_place() {
        let map = map(true);
        let (width, height) = map.size();
        let mut n = 0;
        for i in 0..width * height {
            let place = [(i % width) as f32 + 0.3, (i / width) as f32 + 0.6];
            let Some(direction) = map.direction(place) else {
                continue;
            };
            n += 1;
            let [x, y] = map.place(direction).expect("the sphere is shown whole");
            let apart = (x - place[0]).hypot(y - place[1]);
            assert!(apart < 1e-2, "{place:?} {x} {y}");
        }
        assert!(n > 6000, "{n}");
    }

    /// `∫ dω = 2π` and `∫ cos dω = π` over a hemisphere, and none of it lies behind.
    #[test]
    fn pixels_stand_for_as_many_steradians() {
        let map = map(false);
        let (width, height) = map.size();
        let (mut sum, mut of_cos) = (0.0, 0.0);
        for i in 0..width * height {
            let place = [(i % width) as f32 + 0.5, (i / width) as f32 + 0.5];
            if let Some(direction) = map.direction(place) {
                assert!(direction.dot(Vec3::new(1.0, 2.0, -2.0)) > 0.0);
                sum += map.solid_angle();
                of_cos += map.solid_angle() * map.cos(direction);
            }
        }
        let pi = std::f32::consts::PI;
        assert!((sum / (2.0 * pi) - 1.0).abs() < 5e-3, "{sum}");
        assert!((of_cos / pi - 1.0).abs() < 5e-3, "{of_cos}");
    }

    #[test]
    fn the_viewer_is_below_and_what_is_mirrored_above() {
        let wo = Vec3::new(0.6, 0.8, 0.0);
        let map = DirectionMap::new(Vec3::Y, wo, 64, false);
        let [x, y] = map.place(wo).expect("before the surface");
        assert!((x - 32.0).abs() < 1e-3 && y > 40.0, "{x} {y}");
        let [x, y] = map
            .place(Vec3::new(-0.6, 0.8, 0.0))
            .expect("before the surface");
        assert!((x - 32.0).abs() < 1e-3 && y < 24.0, "{x} {y}");
        // Looking down -x at a floor, right is towards -z.
        let [x, _] = map.place(Vec3::NEG_Z).expect("along the surface");
        assert!(x > 60.0, "{x}");
        assert!(map.place(Vec3::NEG_Y).is_none());
    }
}
