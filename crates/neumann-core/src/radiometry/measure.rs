//! The two densities of a direction and the term that joins them.
//!
//! A direction may be chosen per solid angle (`pdf_w`, 1/sr) or as a point on a
//! surface per area (`pdf_a`, 1/m²). With `cos` the cosine at the surface that
//! is reached and `distance_squared` the distance to it,
//! `pdf_a = pdf_w · cos / distance²` ([Veach 1997] eq. 8.10).

/// Density per area at the point reached, from the density per solid angle at the start.
#[inline]
#[must_use]
pub fn pdf_a_from_pdf_w(pdf_w: f32, cos_at_point: f32, distance_squared: f32) -> f32 {
    pdf_w * cos_at_point / distance_squared
}

/// Density per solid angle at the start, from the density per area at the point reached.
///
/// Infinite at a grazing angle, where a point light's worth of area is seen edge on.
#[inline]
#[must_use]
pub fn pdf_w_from_pdf_a(pdf_a: f32, cos_at_point: f32, distance_squared: f32) -> f32 {
    pdf_a * distance_squared / cos_at_point
}

#[cfg(test)]
mod tests {
    use super::{pdf_a_from_pdf_w, pdf_w_from_pdf_a};

    #[test]
    fn measures_invert_each_other() {
        let pdf_a = pdf_a_from_pdf_w(0.3, 0.7, 4.0);
        assert!((pdf_w_from_pdf_a(pdf_a, 0.7, 4.0) - 0.3).abs() < 1e-6);
    }
}
