//! The sensor: perspective (pinhole or thin lens) and orthographic.
//!
//! The value of pixel j is `∫ W_j L`, with importance normalised so that a pixel
//! seeing radiance 1 everywhere has value 1 ([Veach 1997] 8.3.2). Importance is given
//! for the whole film, that is `W_j` of the one pixel that the raster position falls in.

use std::f32::consts::PI;

use glam::{BVec3, Vec2, Vec3};

use super::{Aim, Spread, StartDensities};
use crate::math::Ray;
use crate::math::ray::LENS;
use crate::radiometry::Rgb;
use crate::sampling::warp;
use crate::scene::description::{CameraDescription, Lens, Projection};

/// A camera together with the raster of its film; raster (0, 0) is the top left corner of pixel (0,
/// 0).
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    position: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half extents of the film: at distance 1 for perspective, in metres for orthographic.
    half: Vec2,
    /// Where the middle of the film is on that of the whole picture, in the same measure.
    shift: Vec2,
    projection: Projection,
    lens: Option<Lens>,
    width: f32,
    height: f32,
    /// Pixels per unit of the film; y runs down.
    pixels_per_film: Vec2,
    /// Area of the film, and of the lens or 1.
    film_area: f32,
    lens_area: f32,
}

/// A ray through a point of the raster.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray; its sample of the pixel weighs 1.
    pub ray: Ray,
    /// Densities with which it was started, over the whole film.
    pub densities: StartDensities,
    /// How the rays fan out from this point of the lens (or in this direction).
    pub spread: Spread,
    /// Cosine between the ray and the axis.
    pub cos: f32,
    /// True if no light could meet the camera by chance: a pinhole, or a single direction.
    pub is_delta: bool,
}

/// Where light has met the lens by chance.
#[derive(Clone, Copy, Debug)]
pub struct LensHit {
    /// The raster position that it falls on.
    pub raster: Vec2,
    /// Importance of the ray, multiplied by the number of pixels: a path that carries flux Φ here
    /// adds Φ times this to its pixel.
    pub importance: f32,
    /// Distance along the ray, metres.
    pub distance: f32,
    /// Cosine between the ray and the axis.
    pub cos: f32,
    /// Densities with which the camera would have started the ray the other way.
    pub start: StartDensities,
}

impl Camera {
    /// A camera for a film of `width × height` pixels.
    ///
    /// A perspective camera keeps its vertical angle of view. The view of an orthographic one is
    /// cropped to the shape of the film: a wider film shows the whole width of the view. Where the
    /// film shows a part of the picture, all this holds of the whole.
    #[must_use]
    pub fn new(description: &CameraDescription, width: usize, height: usize) -> Self {
        let m = description.world_from_camera;
        let forward = (-m.z_axis.truncate()).normalize_or(Vec3::NEG_Z);
        let up_hint = m.y_axis.truncate().normalize_or(Vec3::Y);
        // A mirroring or shearing transform still yields a right-handed camera.
        let right = forward
            .cross(up_hint)
            .normalize_or(forward.any_orthonormal_vector());
        let size = [width, height];
        let whole = description.crop.map_or(size, |crop| crop.of);
        let [w, h] = whole.map(|n| n as f32);
        let half_height = match description.projection {
            Projection::Perspective { yfov } => (0.5 * yfov).tan(),
            Projection::Orthographic { ymag } => {
                let view = description
                    .aspect_ratio
                    .filter(|a| a.is_finite() && *a > 0.0);
                ymag.abs() * view.map_or(1.0, |view| (view * h / w).min(1.0))
            }
        };
        let half = Vec2::new(half_height * w / h, half_height);
        let (half, shift) = match description.crop {
            None => (half, Vec2::ZERO),
            Some(crop) => {
                // The middle of the part, from that of the whole, in halves of the whole.
                let middle = [0, 1].map(|i| (2 * crop.at[i] + crop.size[i]) as f32);
                let middle = Vec2::new(middle[0] / w - 1.0, 1.0 - middle[1] / h);
                let share = Vec2::new(crop.size[0] as f32 / w, crop.size[1] as f32 / h);
                (half * share, half * middle)
            }
        };
        let [w, h] = size.map(|n| n as f32);
        let lens = description
            .lens
            .filter(|l| l.aperture > 0.0 && l.focus_distance > 0.0);
        Self {
            position: m.w_axis.truncate(),
            right,
            up: right.cross(forward),
            forward,
            half,
            shift,
            projection: description.projection,
            lens,
            width: w,
            height: h,
            pixels_per_film: Vec2::new(0.5 * w / half.x, -0.5 * h / half.y),
            film_area: 4.0 * half.x * half.y,
            lens_area: lens.map_or(1.0, |l| 0.25 * PI * l.aperture * l.aperture),
        }
    }

    /// True if its lens has a size, so that light can meet it by chance.
    #[inline]
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.lens.is_some() && matches!(self.projection, Projection::Perspective { .. })
    }

    /// View direction, unit.
    #[must_use]
    pub fn forward(&self) -> Vec3 {
        self.forward
    }

    /// Width and height of the raster, pixels.
    #[must_use]
    pub fn raster_size(&self) -> (f32, f32) {
        (self.width, self.height)
    }

    /// Position of the lens (or of the middle of an orthographic film).
    #[must_use]
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// The ray through `raster`, from the point of the lens that `u` in [0, 1)² chooses.
    #[inline]
    #[must_use]
    pub fn ray(&self, raster: Vec2, u: [f32; 2]) -> CameraRay {
        let film = self.film_from_raster(raster);
        match self.projection {
            Projection::Orthographic { .. } => CameraRay {
                ray: Ray::new(
                    self.position + self.right * film.x + self.up * film.y,
                    self.forward,
                )
                .leaving(LENS),
                densities: StartDensities {
                    pdf_a: 1.0 / self.film_area,
                    pdf_w: 1.0,
                },
                spread: Spread::Parallel {
                    pdf_a: 1.0 / self.film_area,
                },
                cos: 1.0,
                is_delta: true,
            },
            Projection::Perspective { .. } => {
                let through = self.right * film.x + self.up * film.y + self.forward;
                let (origin, towards) = match self.lens {
                    None => (self.position, through),
                    Some(lens) => {
                        let p = warp::disk(u) * (0.5 * lens.aperture);
                        let origin = self.position + self.right * p.x + self.up * p.y;
                        let focus = self.position + through * lens.focus_distance;
                        (origin, focus - origin)
                    }
                };
                let direction = towards.normalize();
                let cos = direction.dot(self.forward);
                let pdf_w = self.pdf_w(cos);
                CameraRay {
                    ray: Ray::new(origin, direction).leaving(LENS),
                    densities: StartDensities {
                        pdf_a: 1.0 / self.lens_area,
                        pdf_w,
                    },
                    spread: Spread::Point { pdf_w },
                    cos,
                    is_delta: self.lens.is_none(),
                }
            }
        }
    }

    /// Aims at the camera from `x`: at the point of the lens that `u` in [0, 1)² chooses. Yields
    /// the raster position that the light falls on; `None` if it misses the film.
    ///
    /// `value` of the aim is importance arriving at x, already multiplied by the number of
    /// pixels: light of one path adds `f · cos · value / pdf_w` times its throughput to that
    /// pixel.
    #[inline(always)]
    #[must_use]
    pub fn aim(&self, x: Vec3, u: [f32; 2]) -> Option<(Aim, Vec2)> {
        let n_pixels = self.width * self.height;
        if let Projection::Orthographic { .. } = self.projection {
            let from_film = x - self.position;
            let distance = from_film.dot(self.forward);
            let film = Vec2::new(from_film.dot(self.right), from_film.dot(self.up));
            let raster = self.raster_from_film(film)?;
            let pdf_a = 1.0 / self.film_area;
            return (distance > 0.0).then_some((
                Aim {
                    wi: -self.forward,
                    distance,
                    value: Rgb::splat(n_pixels * pdf_a),
                    pdf_w: 1.0,
                    is_delta: true,
                    cos_at_endpoint: 1.0,
                    surface: None,
                    start: StartDensities { pdf_a, pdf_w: 1.0 },
                    spread: Spread::Parallel { pdf_a },
                    start_over_aim: 1.0,
                    opacity: 1.0,
                    light: u32::MAX,
                },
                raster,
            ));
        }
        let on_lens = self.lens_point(u);
        let origin = self.position + self.right * on_lens.x + self.up * on_lens.y;
        let to_x = x - origin;
        // Most points are outside of the picture, which is told before anything else is asked.
        let raster = self.raster_of(on_lens, to_x)?;
        let distance = to_x.length();
        let direction = to_x / distance;
        let cos = direction.dot(self.forward);
        if cos <= 1e-6 || !distance.is_finite() {
            return None;
        }
        let pdf_w_start = self.pdf_w(cos);
        let pdf_a = 1.0 / self.lens_area;
        // W_e cos = pixels · pdf_a · pdf_w, so that a camera sample weighs 1 ([PBR4] 5.4.1
        // online).
        let importance = n_pixels * pdf_w_start * pdf_a / cos;
        let is_pinhole = self.lens.is_none();
        let d2 = distance * distance;
        let aim = Aim {
            wi: -direction,
            distance,
            value: Rgb::splat(if is_pinhole {
                importance * cos / d2
            } else {
                importance
            }),
            pdf_w: if is_pinhole { 1.0 } else { pdf_a * d2 / cos },
            is_delta: is_pinhole,
            cos_at_endpoint: cos,
            surface: None,
            start: StartDensities {
                pdf_a,
                pdf_w: pdf_w_start,
            },
            spread: Spread::Point { pdf_w: pdf_w_start },
            start_over_aim: 1.0,
            opacity: 1.0,
            light: u32::MAX,
        };
        Some((aim, raster))
    }

    /// Looks into `direction` (unit, away from the camera), to infinity: yields the ray from the
    /// point of the lens that `u` chooses, its raster position, and the importance over the density
    /// of that point, per steradian and multiplied by the number of pixels. `None` if the direction
    /// is outside of the picture, and for an orthographic camera, which sees single directions
    /// only.
    #[must_use]
    pub fn look(&self, direction: Vec3, u: [f32; 2]) -> Option<(Ray, Vec2, f32)> {
        if matches!(self.projection, Projection::Orthographic { .. }) {
            return None;
        }
        let cos = direction.dot(self.forward);
        if cos <= 1e-6 {
            return None;
        }
        let on_lens = self.lens_point(u);
        let raster = self.raster_of(on_lens, direction)?;
        let origin = self.position + self.right * on_lens.x + self.up * on_lens.y;
        let importance = self.width * self.height * self.pdf_w(cos);
        let ray = Ray::new(origin, direction).leaving(LENS);
        Some((ray, raster, importance))
    }

    /// Where a ray that light travels along meets a lens of finite size, before `t_max`, from the
    /// front.
    #[must_use]
    pub fn hit_lens(&self, ray: &Ray, t_max: f32) -> Option<LensHit> {
        let lens = self.lens.filter(|_| self.has_lens())?;
        let cos = -ray.direction().dot(self.forward);
        if cos <= 1e-6 {
            return None;
        }
        let distance = (ray.origin() - self.position).dot(self.forward) / cos;
        if distance <= 0.0 || distance >= t_max {
            return None;
        }
        let from_middle = ray.at(distance) - self.position;
        let on_lens = Vec2::new(from_middle.dot(self.right), from_middle.dot(self.up));
        if on_lens.length() > 0.5 * lens.aperture {
            return None;
        }
        let raster = self.raster_of(on_lens, -ray.direction())?;
        let start = StartDensities {
            pdf_a: 1.0 / self.lens_area,
            pdf_w: self.pdf_w(cos),
        };
        Some(LensHit {
            raster,
            importance: self.width * self.height * start.pdf_w * start.pdf_a / cos,
            distance,
            cos,
            start,
        })
    }

    /// The raster position at which a point is seen from the middle of the lens, which may lie
    /// beside the film; `None` for points behind the camera.
    #[must_use]
    pub fn seen_at(&self, x: Vec3) -> Option<Vec2> {
        let from = x - self.position;
        let film = Vec2::new(from.dot(self.right), from.dot(self.up));
        let film = match self.projection {
            Projection::Orthographic { .. } => film,
            Projection::Perspective { .. } => {
                let depth = from.dot(self.forward);
                if depth <= 1e-6 * from.length() {
                    return None;
                }
                film / depth
            }
        };
        let middle = Vec2::new(0.5 * self.width, 0.5 * self.height);
        let raster = (film - self.shift) * self.pixels_per_film + middle;
        raster.is_finite().then_some(raster)
    }

    #[inline]
    fn lens_point(&self, u: [f32; 2]) -> Vec2 {
        match self.lens {
            None => Vec2::ZERO,
            Some(lens) => warp::disk(u) * (0.5 * lens.aperture),
        }
    }

    /// Raster positions (minimum and maximum) of all rays that could meet a box given by its
    /// minimum and maximum; `None` where the box reaches so near to the camera, or behind it, that
    /// there are no bounds.
    #[must_use]
    pub fn raster_bounds(&self, [min, max]: [Vec3; 2]) -> Option<[Vec2; 2]> {
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        let (mut nearest, mut farthest) = (f32::INFINITY, 0f32);
        for i in 0..8 {
            let corner = Vec3::select(BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), min, max);
            let from = corner - self.position;
            let mut film = Vec2::new(from.dot(self.right), from.dot(self.up));
            if let Projection::Perspective { .. } = self.projection {
                let depth = from.dot(self.forward);
                // Room for the rounding of positions.
                if depth <= 1e-3 * corner.abs().max(self.position.abs()).max_element() {
                    return None;
                }
                (nearest, farthest) = (nearest.min(depth), farthest.max(depth));
                film /= depth;
            }
            (low, high) = (low.min(film), high.max(film));
        }
        if let Some(lens) = self.lens.filter(|_| self.has_lens()) {
            // A ray from p on the lens meets depth z where that through the middle would on a film
            // moved by p/z - p/f.
            let moved = |depth: f32| (1.0 / depth - 1.0 / lens.focus_distance).abs();
            let reach = 0.5 * lens.aperture * moved(nearest).max(moved(farthest));
            (low, high) = (low - reach, high + reach);
        }
        let middle = Vec2::new(0.5 * self.width, 0.5 * self.height);
        let [a, b] = [low, high].map(|film| (film - self.shift) * self.pixels_per_film + middle);
        (a.is_finite() && b.is_finite()).then(|| [a.min(b) - 1.0, a.max(b) + 1.0])
    }

    /// Density of the direction for a raster position uniform over the film, 1/sr: `1 / (A cos³)`
    /// with A the area of the film at distance 1. A lens does not change it: shifting the origin
    /// shears the film but keeps directions to the plane of focus one to one.
    #[inline]
    fn pdf_w(&self, cos: f32) -> f32 {
        1.0 / (self.film_area * cos * cos * cos)
    }

    #[inline]
    fn film_from_raster(&self, raster: Vec2) -> Vec2 {
        Vec2::new(
            (2.0 * raster.x / self.width - 1.0) * self.half.x,
            (1.0 - 2.0 * raster.y / self.height) * self.half.y,
        ) + self.shift
    }

    #[inline]
    fn raster_from_film(&self, film: Vec2) -> Option<Vec2> {
        let middle = Vec2::new(0.5 * self.width, 0.5 * self.height);
        let raster = (film - self.shift) * self.pixels_per_film + middle;
        let is_inside =
            raster.x >= 0.0 && raster.y >= 0.0 && raster.x < self.width && raster.y < self.height;
        is_inside.then_some(raster)
    }

    /// The raster position whose ray from `on_lens` has the given direction, which need not be
    /// unit.
    #[inline]
    fn raster_of(&self, on_lens: Vec2, direction: Vec3) -> Option<Vec2> {
        let depth = direction.dot(self.forward);
        let slope = Vec2::new(direction.dot(self.right), direction.dot(self.up)) / depth;
        let film = match self.lens {
            None => slope,
            Some(lens) => slope + on_lens / lens.focus_distance,
        };
        self.raster_from_film(film)
    }
}

#[cfg(test)]
mod tests {
    use glam::{Mat4, Vec2, Vec3};

    use super::Camera;
    use crate::scene::description::{CameraDescription, Lens, Projection};

    fn camera(lens: Option<Lens>, projection: Projection) -> Camera {
        let description = CameraDescription {
            name: String::new(),
            world_from_camera: Mat4::from_translation(Vec3::new(1.0, 2.0, 3.0))
                * Mat4::from_rotation_y(0.4),
            aspect_ratio: None,
            projection,
            lens,
            crop: None,
        };
        Camera::new(&description, 64, 48)
    }

    #[test]
    fn points_are_seen_where_their_rays_start() {
        for projection in [
            Projection::Perspective { yfov: 0.8 },
            Projection::Orthographic { ymag: 2.0 },
        ] {
            let camera = camera(None, projection);
            for raster in [
                Vec2::new(3.0, 40.0),
                Vec2::new(63.5, 0.5),
                Vec2::new(90.0, -20.0),
            ] {
                let ray = camera.ray(raster, [0.5, 0.5]).ray;
                let seen = camera.seen_at(ray.at(2.5)).unwrap();
                assert!((seen - raster).length() < 1e-3, "{seen} for {raster}");
            }
        }
        let perspective = camera(None, Projection::Perspective { yfov: 0.8 });
        let behind = perspective.position() - perspective.forward();
        assert_eq!(perspective.seen_at(behind), None);
    }

    #[test]
    fn a_film_of_another_shape_crops_an_orthographic_view() {
        let extent = |width, height| {
            let description = CameraDescription {
                name: String::new(),
                world_from_camera: Mat4::IDENTITY,
                aspect_ratio: Some(2.0),
                projection: Projection::Orthographic { ymag: 3.0 },
                lens: None,
                crop: None,
            };
            let camera = Camera::new(&description, width, height);
            let origin = |x, y| camera.ray(Vec2::new(x, y), [0.5, 0.5]).ray.origin();
            let corners = [origin(0.0, 0.0), origin(width as f32, height as f32)];
            let size = (corners[1] - corners[0]).abs();
            [size.x, size.y]
        };
        assert_eq!(extent(40, 20), [12.0, 6.0], "its own shape");
        assert_eq!(extent(64, 16), [12.0, 3.0], "wider: all of the width");
        assert_eq!(extent(20, 20), [6.0, 6.0], "narrower: all of the height");
    }

    #[test]
    fn aiming_back_finds_the_raster_position() {
        let lens = Some(Lens {
            aperture: 0.1,
            focus_distance: 2.0,
        });
        let perspective = Projection::Perspective { yfov: 0.9 };
        for camera in [
            camera(None, perspective),
            camera(lens, perspective),
            camera(None, Projection::Orthographic { ymag: 2.0 }),
        ] {
            for (i, raster) in [Vec2::new(3.3, 40.2), Vec2::new(60.0, 1.0)]
                .iter()
                .enumerate()
            {
                let u = [0.2 + 0.3 * i as f32, 0.7];
                let start = camera.ray(*raster, u);
                let (aim, found) = camera.aim(start.ray.at(3.7), u).unwrap();
                assert!((found - *raster).length() < 1e-3, "{found} {raster}");
                assert!((aim.wi + start.ray.direction()).length() < 1e-5);
                let ratio = aim.start.pdf_w / start.densities.pdf_w;
                assert!((ratio - 1.0).abs() < 1e-4);
            }
        }
    }
}
