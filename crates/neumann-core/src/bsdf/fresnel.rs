//! How much light a smooth interface reflects.

use crate::radiometry::Rgb;

/// What a smooth dielectric interface does to a direction.
#[derive(Clone, Copy, Debug)]
pub struct Interface {
    /// Share of unpolarised light reflected, in [0, 1].
    pub reflectance: f32,
    /// Cosine of the refracted direction with the normal, on its own side, not negative;
    /// 0 under total internal reflection.
    pub cos_refracted: f32,
}

/// Fresnel's equations for unpolarised light (\[PBR4\] 9.3.5).
///
/// `cos` in [0, 1] is that of the incident direction; `eta` the index of the other side over the
/// index of this side.
#[inline]
#[must_use]
pub fn dielectric(cos: f32, eta: f32) -> Interface {
    let sin2_refracted = (1.0 - cos * cos).max(0.0) / (eta * eta);
    if sin2_refracted >= 1.0 {
        return Interface {
            reflectance: 1.0,
            cos_refracted: 0.0,
        };
    }
    let cos_refracted = (1.0 - sin2_refracted).sqrt();
    let parallel = (eta * cos - cos_refracted) / (eta * cos + cos_refracted);
    let perpendicular = (cos - eta * cos_refracted) / (cos + eta * cos_refracted);
    Interface {
        reflectance: 0.5 * (parallel * parallel + perpendicular * perpendicular),
        cos_refracted,
    }
}

/// Reflectance of a thin pane, light going back and forth inside it, from that of one face:
/// the geometric series `R + T²R + T²R³ + … = 2R / (1 + R)`.
#[inline]
#[must_use]
pub fn pane(reflectance: f32) -> f32 {
    2.0 * reflectance / (1.0 + reflectance)
}

/// `(1 - cos)⁵`, the weight of `f90` in [`schlick`].
#[inline]
#[must_use]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Schlick's approximation (1994), from `f0` at normal to `f90` at grazing incidence.
#[inline]
#[must_use]
pub fn schlick(f0: Rgb, f90: Rgb, cos: f32) -> Rgb {
    f0.lerp(f90, schlick_weight(cos))
}

/// Reflectance at normal incidence of a dielectric against air.
#[inline]
#[must_use]
pub fn f0_from_ior(ior: f32) -> f32 {
    let r = (ior - 1.0) / (ior + 1.0);
    r * r
}

#[cfg(test)]
mod tests {
    use super::dielectric;

    #[test]
    fn glass_reflects_four_percent_and_all_beyond_the_critical_angle() {
        assert!((dielectric(1.0, 1.5).reflectance - 0.04).abs() < 1e-6);
        assert!((dielectric(0.0, 1.5).reflectance - 1.0).abs() < 1e-6);
        // sin of the critical angle from glass to air is 1 / 1.5.
        let critical = (1.0f32 - 1.0 / 2.25).sqrt();
        assert!(dielectric(critical - 1e-3, 1.0 / 1.5).reflectance >= 1.0);
        assert!(dielectric(critical + 1e-2, 1.0 / 1.5).reflectance < 1.0);
    }

    #[test]
    fn both_sides_reflect_the_same() {
        let outside = dielectric(0.6, 1.5);
        let inside = dielectric(outside.cos_refracted, 1.0 / 1.5);
        assert!((outside.reflectance - inside.reflectance).abs() < 1e-5);
        assert!((inside.cos_refracted - 0.6).abs() < 1e-5);
    }
}
