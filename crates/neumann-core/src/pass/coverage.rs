//! Which tiles of the picture show anything but what is infinitely far away.

use crate::endpoint::Camera;
use crate::film::TileGrid;
use crate::scene::Scene;

/// Nodes of the tree whose children's boxes are looked at: more would be told apart no finer by
/// most pictures.
const N_NODES: usize = 256;

/// The tiles whose camera rays may meet a surface.
#[derive(Debug)]
pub(crate) struct Coverage {
    is_covered: Vec<bool>,
}

impl Coverage {
    /// Covers every tile that the box of something in the scene reaches into.
    pub(crate) fn new(scene: &Scene, camera: &Camera, grid: TileGrid) -> Self {
        let mut coverage = Self {
            is_covered: vec![false; grid.n_tiles()],
        };
        for bounds in scene.bvh().boxes(N_NODES) {
            match camera.raster_bounds(bounds) {
                Some([low, high]) => {
                    for tile in grid.tiles_within(low, high) {
                        coverage.is_covered[tile] = true;
                    }
                }
                None => {
                    coverage.is_covered.fill(true);
                    break;
                }
            }
        }
        coverage
    }

    /// True if a camera ray through the tile may meet a surface.
    #[inline]
    pub(crate) fn is_covered(&self, tile: usize) -> bool {
        self.is_covered[tile]
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::Coverage;
    use crate::endpoint::Camera;
    use crate::film::TileGrid;
    use crate::scene::Scene;
    use crate::scene::builtin::BUILTINS;
    use crate::scene::description::{CameraDescription, Lens, Projection};

    const SIZE: (usize, usize) = (100, 70);

    /// Cameras that see a box of the world at various sizes, with and without a lens.
    fn cameras([min, max]: [Vec3; 2]) -> Vec<Camera> {
        let (middle, radius) = (0.5 * (min + max), 0.5 * (max - min).length());
        let mut cameras = Vec::new();
        for direction in [Vec3::Z, Vec3::new(1.0, 0.6, -0.7), Vec3::new(0.1, 1.0, 0.0)] {
            for distance in [0.5, 1.5, 4.0] {
                let eye = middle + direction.normalize() * radius * distance;
                let lens = Lens {
                    aperture: 0.6 * radius,
                    focus_distance: 0.7 * radius * distance,
                };
                for (projection, lens) in [
                    (Projection::Perspective { yfov: 0.8 }, None),
                    (Projection::Perspective { yfov: 0.8 }, Some(lens)),
                    (
                        Projection::Orthographic {
                            ymag: radius * distance,
                        },
                        None,
                    ),
                ] {
                    let description = CameraDescription {
                        name: String::new(),
                        world_from_camera: CameraDescription::looking_at(eye, middle, Vec3::Y),
                        aspect_ratio: None,
                        projection,
                        lens,
                        crop: None,
                    };
                    cameras.push(Camera::new(&description, SIZE.0, SIZE.1));
                }
            }
        }
        cameras
    }

    #[test]
    fn rays_through_other_tiles_meet_nothing() {
        let (mut n_uncovered, mut n_covered) = (0, 0);
        for builtin in BUILTINS {
            let scene = Scene::build(&builtin.load().unwrap());
            let boxes = scene.bvh().boxes(1);
            let bounds = boxes
                .iter()
                .copied()
                .reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
            let grid = TileGrid::new(SIZE.0, SIZE.1);
            for camera in cameras(bounds.unwrap()) {
                let coverage = Coverage::new(&scene, &camera, grid);
                for tile in 0..grid.n_tiles() {
                    n_covered += u32::from(coverage.is_covered(tile));
                    if coverage.is_covered(tile) {
                        continue;
                    }
                    n_uncovered += 1;
                    let bounds = grid.bounds(tile);
                    for y in bounds.start[1]..bounds.end[1] {
                        for x in bounds.start[0]..bounds.end[0] {
                            // Both ends of the pixel, from all around the lens.
                            for i in 0..9 {
                                let shift = [0.0, 0.999][i % 2];
                                let u = [i % 3, i / 3].map(|k| 0.4995 * k as f32);
                                let raster = Vec2::new(x as f32, y as f32) + shift;
                                let ray = camera.ray(raster, u).ray;
                                let hit = scene.bvh().closest_hit(&ray);
                                assert!(hit.is_none(), "{}, {x} {y}", builtin.name);
                            }
                        }
                    }
                }
            }
        }
        assert!(
            n_uncovered > 1000 && n_covered > 1000,
            "{n_uncovered}, {n_covered}"
        );
    }
}
