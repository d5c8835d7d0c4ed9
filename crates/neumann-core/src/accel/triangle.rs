//! A watertight ray-triangle test (Woop, Benthin and Wald 2013).
//!
//! Corners are sheared into a frame in which the ray runs along +z from the
//! origin, so that two triangles that share an edge compute the same edge function
//! for it and no ray slips between them.

use glam::Vec3;

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    /// Origin with its axes permuted so that the ray runs mostly along the last.
    origin: Vec3,
    axes: [usize; 3],
    shear: Vec3,
}

/// Corners of a triangle; the fourth number of each is padding.
pub(super) type Corners = [[f32; 4]; 3];

/// Corners as the test wants them.
pub(super) fn corners(corners: &[Vec3; 3]) -> Corners {
    corners.map(|v| [v.x, v.y, v.z, 0.0])
}

/// Where a triangle was met.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleHit {
    /// Distance along the ray.
    pub(super) t: f32,
    /// Barycentric coordinates of v1 and v2.
    pub(super) barycentrics: [f32; 2],
}

impl ShearedRay {
    #[inline]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let magnitude = direction.abs();
        let z = if magnitude.x > magnitude.y {
            if magnitude.x > magnitude.z { 0 } else { 2 }
        } else if magnitude.y > magnitude.z {
            1
        } else {
            2
        };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            std::mem::swap(&mut x, &mut y);
        }
        let scale = 1.0 / direction[z];
        Self {
            origin: Vec3::new(origin[x], origin[y], origin[z]),
            axes: [x, y, z],
            shear: Vec3::new(direction[x] * scale, direction[y] * scale, scale),
        }
    }

    /// The hit with `0 < t <= t_max`, if any.
    #[inline]
    pub(super) fn intersect(&self, corners: &Corners, t_max: f32) -> Option<TriangleHit> {
        // The mask tells the compiler that no index is out of bounds.
        let [x, y, z] = self.axes.map(|axis| axis & 3);
        let relative = |v: &[f32; 4]| Vec3::new(v[x], v[y], v[z]) - self.origin;
        let [a, b, c] = [
            relative(&corners[0]),
            relative(&corners[1]),
            relative(&corners[2]),
        ];
        let (ax, ay) = (a.x - self.shear.x * a.z, a.y - self.shear.y * a.z);
        let (bx, by) = (b.x - self.shear.x * b.z, b.y - self.shear.y * b.z);
        let (cx, cy) = (c.x - self.shear.x * c.z, c.y - self.shear.y * c.z);
        let mut u = cx * by - cy * bx;
        let mut v = ax * cy - ay * cx;
        let mut w = bx * ay - by * ax;
        if u == 0.0 || v == 0.0 || w == 0.0 {
            // An edge is hit as exactly as single precision can tell: decide in double.
            let d = |p: f32, q: f32, r: f32, s: f32| {
                (f64::from(p) * f64::from(q) - f64::from(r) * f64::from(s)) as f32
            };
            u = d(cx, by, cy, bx);
            v = d(ax, cy, ay, cx);
            w = d(bx, ay, by, ax);
        }
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let determinant = u + v + w;
        if determinant == 0.0 {
            return None;
        }
        let scaled_t = self.shear.z * (u * a.z + v * b.z + w * c.z);
        let inverse = 1.0 / determinant;
        let t = scaled_t * inverse;
        (t > 0.0 && t <= t_max).then_some(TriangleHit {
            t,
            barycentrics: [v * inverse, w * inverse],
        })
    }
}
