//! The GGX distribution of microfacet normals, isotropic.
//!
//! Walter et al. 2007 for D; Heitz 2014 for the masking; visible normals drawn
//! after Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical
//! Caps". Local directions; functions expect them on the upper side (z > 0).

use std::f32::consts::PI;

use glam::Vec3;

/// GGX with one roughness parameter alpha.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// Width of the distribution, alpha; the square of glTF's roughness.
    pub alpha: f32,
}

/// Below this alpha a surface is treated as perfectly smooth: its lobe is narrower
/// than single precision can evaluate (\[PBR4\] 9.6 draws the line at the same place).
pub const SMOOTH_ALPHA: f32 = 1e-3;

/// What a pair of directions is to mirror-like facets.
#[derive(Clone, Copy, Debug)]
pub struct Reflected {
    /// Cosine of either direction with the facets that reflect one into the other.
    pub cos_m: f32,
    /// The BSDF over Fresnel's term, `D G2 / (4 cos_o cos_i)`, 1/sr.
    pub value: f32,
    /// Density of the direction that visible facets reflect `wo` to, 1/sr: `D G1(wo) (wo·m) /
    /// cos_o`, times the Jacobian `1 / (4 wo·m)` of reflection.
    pub pdf_w: f32,
}

impl Ggx {
    /// True where the surface counts as perfectly smooth.
    #[inline]
    #[must_use]
    pub fn is_smooth(self) -> bool {
        self.alpha < SMOOTH_ALPHA
    }

    /// Density of normals per projected area, `D(m)`, 1/sr.
    #[inline]
    #[must_use]
    pub fn d(self, m: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        // m.x² + m.y² + m.z² a² loses nothing to cancellation near the pole.
        let s = (m.x * m.x + m.y * m.y) / a2 + m.z * m.z;
        1.0 / (PI * a2 * s * s)
    }

    /// Smith's auxiliary function Λ(w).
    #[inline]
    #[must_use]
    pub fn lambda(self, w: Vec3) -> f32 {
        let cos2 = w.z * w.z;
        let tan2 = (w.x * w.x + w.y * w.y) / cos2.max(1e-20);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// Share of facets facing `w` that are not hidden from it.
    #[inline]
    #[must_use]
    pub fn g1(self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// Share of facets visible from both directions, height-correlated, one side.
    #[inline]
    #[must_use]
    pub fn g2(self, wo: Vec3, wi: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(wo) + self.lambda(wi))
    }

    /// A reflection from `wo` to `wi`, both on the upper side.
    #[inline]
    #[must_use]
    pub fn reflected(self, wo: Vec3, wi: Vec3) -> Reflected {
        let m = (wo + wi).normalize();
        let (lambda_o, lambda_i) = (self.lambda(wo), self.lambda(wi));
        let facets = self.d(m) / (4.0 * wo.z);
        Reflected {
            cos_m: wo.dot(m),
            value: facets / ((1.0 + lambda_o + lambda_i) * wi.z),
            pdf_w: facets / (1.0 + lambda_o),
        }
    }

    /// Draws a normal visible from `wo` (z > 0).
    #[inline]
    #[must_use]
    pub fn sample_visible(self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let a = self.alpha;
        let stretched = Vec3::new(a * wo.x, a * wo.y, wo.z).normalize();
        let (sin, cos) = (2.0 * PI * u[0]).sin_cos();
        let z = (1.0 - u[1]).mul_add(1.0 + stretched.z, -stretched.z);
        let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let half = Vec3::new(r * cos, r * sin, z) + stretched;
        Vec3::new(a * half.x, a * half.y, half.z.max(1e-12)).normalize()
    }

    /// Density of [`Self::sample_visible`] per solid angle of the normal, 1/sr.
    #[inline]
    #[must_use]
    pub fn pdf_w_visible(self, wo: Vec3, m: Vec3) -> f32 {
        self.g1(wo) * self.d(m) * wo.dot(m).max(0.0) / wo.z.max(1e-20)
    }
}
