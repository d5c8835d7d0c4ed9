//! A photographer's studio: soft boxes about a grey ground that rises into grey walls.
//!
//! The key light stands in front on the left, above; a dimmer one fills from
//! the right, one hangs overhead, and a narrow one behind draws the outline.
//! All of them end above the horizon: whoever looks down sees nothing but ground.
//! "In front" is +Z, from where glTF models are looked at. Everything is
//! neutral, so that colours are the file's own.

use glam::Vec3;

/// A rectangle of even radiance at infinity, with soft edges.
struct SoftBox {
    /// Where its middle is; not unit.
    towards: Vec3,
    /// What is up for it, roughly.
    up: Vec3,
    /// Half its width and height, as tangents of angles.
    half_size: [f32; 2],
    /// Half the width of its edges.
    softness: f32,
    /// Added to what is behind it.
    radiance: f32,
}

/// Makes the brightest white surface have radiance 1.
const SCALE: f32 = 0.655;
/// Radiance of the ground straight below, and what it gains towards the horizon.
const GROUND: [f32; 2] = [0.21, 0.11];
/// Radiance of the walls at the horizon, and what they gain towards the zenith.
const WALLS: [f32; 2] = [0.32, 0.10];

const BOXES: [SoftBox; 4] = [
    SoftBox {
        towards: Vec3::new(-0.70, 0.62, 0.90),
        up: Vec3::Y,
        half_size: [0.50, 0.42],
        softness: 0.05,
        radiance: 4.6,
    },
    SoftBox {
        towards: Vec3::new(0.95, 0.48, 0.38),
        up: Vec3::Y,
        half_size: [0.30, 0.36],
        softness: 0.05,
        radiance: 2.0,
    },
    SoftBox {
        towards: Vec3::new(0.0, 1.0, -0.25),
        up: Vec3::NEG_Z,
        half_size: [0.70, 0.40],
        softness: 0.06,
        radiance: 1.3,
    },
    SoftBox {
        towards: Vec3::new(0.55, 0.60, -0.90),
        up: Vec3::Y,
        half_size: [0.14, 0.42],
        softness: 0.04,
        radiance: 3.0,
    },
];

/// Radiance from `direction`, unit.
pub(super) fn radiance(direction: Vec3) -> f32 {
    let height = direction.y;
    // Both curves meet at the horizon.
    let background = if height < 0.0 {
        GROUND[0] + GROUND[1] * (2.5 * height).exp()
    } else {
        WALLS[0] + WALLS[1] * height
    };
    let boxes: f32 = BOXES.iter().map(|b| b.radiance(direction)).sum();
    SCALE * (background + boxes)
}

impl SoftBox {
    fn radiance(&self, direction: Vec3) -> f32 {
        let z = self.towards.normalize();
        let x = self.up.cross(z).normalize();
        let y = z.cross(x);
        let depth = direction.dot(z);
        if depth <= 0.0 {
            return 0.0;
        }
        let share = |axis: Vec3, half: f32| {
            let beyond = (direction.dot(axis) / depth).abs() - half;
            let t = (0.5 - 0.5 * beyond / self.softness).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        self.radiance * share(x, self.half_size[0]) * share(y, self.half_size[1])
    }
}
