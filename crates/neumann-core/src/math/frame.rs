//! Orthonormal frames whose z axis is a normal.
//!
//! Built without branches or square roots after Duff et al. 2017, "Building an
//! Orthonormal Basis, Revisited".

use glam::Vec3;

/// A right-handed orthonormal frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// First tangent, world space.
    pub x: Vec3,
    /// Second tangent, world space.
    pub y: Vec3,
    /// Normal, world space.
    pub z: Vec3,
}

impl Frame {
    /// A frame about the unit vector `z`; the turn about it is arbitrary but continuous almost
    /// everywhere.
    #[inline]
    #[must_use]
    pub fn from_z(z: Vec3) -> Self {
        let sign = 1f32.copysign(z.z);
        let a = -1.0 / (sign + z.z);
        let b = z.x * z.y * a;
        Self {
            x: Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
            y: Vec3::new(b, sign + z.y * z.y * a, -z.y),
            z,
        }
    }

    /// World direction to local coordinates.
    #[inline]
    #[must_use]
    pub fn local_from_world(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    /// Local coordinates to world direction.
    #[inline]
    #[must_use]
    pub fn world_from_local(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::Frame;

    #[test]
    fn frames_are_orthonormal_and_invert() {
        for z in [
            Vec3::Z,
            -Vec3::Z,
            Vec3::X,
            Vec3::new(1.0, -2.0, 3.0).normalize(),
            Vec3::new(1e-4, 1e-4, -1.0).normalize(),
        ] {
            let frame = Frame::from_z(z);
            assert!(frame.x.cross(frame.y).abs_diff_eq(z, 1e-6));
            let v = Vec3::new(0.3, -0.5, 0.8);
            let back = frame.local_from_world(frame.world_from_local(v));
            assert!(back.abs_diff_eq(v, 1e-6));
        }
    }
}
