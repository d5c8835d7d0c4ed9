//! Sun and clear sky by \[Preetham 1999\]: "A Practical Analytic Model for Daylight".
//!
//! The sky is the distribution of Perez with the paper's coefficients (A.2),
//! scaled by luminance and chromaticity of the zenith. The sun has its true
//! size; its illuminance outside of the atmosphere is \[Darula 2005\]'s 133.8 klx,
//! dimmed by air and aerosols (A.1) at one wavelength a channel. Ozone, vapour
//! and mixed gases would take a few per cent and are left out. Below the
//! horizon is an even grey ground of albedo 0.2, lit by both.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

use crate::radiometry::Rgb;
use crate::scene::description::SunDescription;

/// Haziness of the air: 2 is very clear, 10 is hazy.
const TURBIDITY: f32 = 3.0;
/// Angle between the zenith and the sun.
const SUN_ZENITH: f32 = 45.0 * PI / 180.0;
/// Turn of the sun from +Z towards -X: in front on the left, as the studio's key light.
const SUN_AZIMUTH: f32 = 38.0 * PI / 180.0;
/// Half of 0.533 degrees.
const SUN_RADIUS: f32 = 0.2665 * PI / 180.0;
/// Illuminance across the sun's rays outside of the atmosphere, klx.
const SOLAR_ILLUMINANCE: f32 = 133.8;
/// Wavelengths that stand for red, green and blue, micrometres.
const WAVELENGTHS: [f32; 3] = [0.612, 0.549, 0.465];
/// Albedo of the ground (the customary value for land).
const GROUND_ALBEDO: f32 = 0.2;
/// Radiance for a luminance of 1 kcd/m²: makes the brightest white surface have radiance 1.
const SCALE: f32 = 0.0255;

/// The model with its angles and turbidity put in.
pub(super) struct Daylight {
    towards_sun: Vec3,
    /// Perez' A to E for Y, x and y.
    perez: [[f32; 5]; 3],
    /// Y (kcd/m²), x and y at the zenith, over what the distribution is there.
    zenith: [f32; 3],
    /// Illuminance across the sun's rays on the ground, klx in each channel.
    sun: Rgb,
    /// Luminance of the ground, kcd/m² in each channel.
    ground: Rgb,
}

impl Daylight {
    pub(super) fn new() -> Self {
        let t = TURBIDITY;
        let line = |[slope, start]: [f32; 2]| slope * t + start;
        let perez = [
            [
                [0.1787, -1.4630],
                [-0.3554, 0.4275],
                [-0.0227, 5.3251],
                [0.1206, -2.5771],
                [-0.0670, 0.3703],
            ],
            [
                [-0.0193, -0.2592],
                [-0.0665, 0.0008],
                [-0.0004, 0.2125],
                [-0.0641, -0.8989],
                [-0.0033, 0.0452],
            ],
            [
                [-0.0167, -0.2608],
                [-0.0950, 0.0092],
                [-0.0079, 0.2102],
                [-0.0441, -1.6537],
                [-0.0109, 0.0529],
            ],
        ]
        .map(|coefficients| coefficients.map(line));
        let zenith = [
            zenith_luminance(),
            zenith_chromaticity([
                [0.00166, -0.00375, 0.00209, 0.0],
                [-0.02903, 0.06377, -0.03202, 0.00394],
                [0.11693, -0.21196, 0.06052, 0.25886],
            ]),
            zenith_chromaticity([
                [0.00275, -0.00610, 0.00317, 0.0],
                [-0.04214, 0.08970, -0.04153, 0.00516],
                [0.15346, -0.26756, 0.06670, 0.26688],
            ]),
        ];
        let (sin, cos) = SUN_ZENITH.sin_cos();
        let mut daylight = Self {
            towards_sun: Vec3::new(-sin * SUN_AZIMUTH.sin(), cos, sin * SUN_AZIMUTH.cos()),
            perez,
            zenith: std::array::from_fn(|i| zenith[i] / distribution(&perez[i], 1.0, SUN_ZENITH)),
            sun: sun_illuminance(),
            ground: Rgb::BLACK,
        };
        daylight.ground = daylight.level_illuminance() * (GROUND_ALBEDO / PI);
        daylight
    }

    /// Radiance from `direction`, unit, without the sun's disk.
    pub(super) fn radiance(&self, direction: Vec3) -> Rgb {
        let luminance = if direction.y > 0.0 {
            self.sky(direction)
        } else {
            self.ground
        };
        luminance * SCALE
    }

    pub(super) fn sun(&self) -> SunDescription {
        let solid_angle = 4.0 * PI * (0.5 * SUN_RADIUS).sin().powi(2);
        SunDescription {
            direction: self.towards_sun,
            angular_radius: SUN_RADIUS,
            radiance: self.sun * (SCALE / solid_angle),
        }
    }

    /// Luminance of the sky, kcd/m² in each channel; (4) and A.2.
    fn sky(&self, direction: Vec3) -> Rgb {
        // Unlike acos, exact next to the sun as well.
        let gamma = 2.0
            * (0.5 * (direction - self.towards_sun).length())
                .min(1.0)
                .asin();
        let [luminance, x, y] = std::array::from_fn(|i| {
            self.zenith[i] * distribution(&self.perez[i], direction.y, gamma)
        });
        rgb_from_chromaticity(luminance, x, y)
    }

    /// Illuminance of a level surface by sun and sky, klx in each channel.
    fn level_illuminance(&self) -> Rgb {
        const N: usize = 32;
        let mut sky = Rgb::BLACK;
        for row in 0..N {
            // Even in the square of the cosine, so that each cell counts alike.
            let cos = ((row as f32 + 0.5) / N as f32).sqrt();
            let sin = (1.0 - cos * cos).sqrt();
            for column in 0..N {
                let (sin_phi, cos_phi) = (2.0 * PI * (column as f32 + 0.5) / N as f32).sin_cos();
                sky += self.sky(Vec3::new(sin * sin_phi, cos, sin * cos_phi));
            }
        }
        sky * (PI / (N * N) as f32) + self.sun * self.towards_sun.y
    }
}

/// Perez' distribution at a zenith angle of cosine `cos_theta`, `gamma` from the sun; (3).
fn distribution([a, b, c, d, e]: &[f32; 5], cos_theta: f32, gamma: f32) -> f32 {
    let cos_gamma = gamma.cos();
    (1.0 + a * (b / cos_theta.max(1e-3)).exp())
        * (1.0 + c * (d * gamma).exp() + e * cos_gamma * cos_gamma)
}

/// Luminance of the zenith, kcd/m²; A.2.
fn zenith_luminance() -> f32 {
    let chi = (4.0 / 9.0 - TURBIDITY / 120.0) * (2.0 * FRAC_PI_2 - 2.0 * SUN_ZENITH);
    (4.0453 * TURBIDITY - 4.9710) * chi.tan() - 0.2155 * TURBIDITY + 2.4192
}

/// Chromaticity x or y of the zenith; A.2.
fn zenith_chromaticity(rows: [[f32; 4]; 3]) -> f32 {
    let polynomial = |row: [f32; 4]| {
        row.into_iter()
            .fold(0.0, |sum, coefficient| sum * SUN_ZENITH + coefficient)
    };
    let [squared, linear, constant] = rows.map(polynomial);
    (squared * TURBIDITY + linear) * TURBIDITY + constant
}

/// Illuminance across the sun's rays under the atmosphere, klx in each channel; A.1.
fn sun_illuminance() -> Rgb {
    let degrees = SUN_ZENITH.to_degrees();
    let air_mass = 1.0 / (SUN_ZENITH.cos() + 0.15 * (93.885 - degrees).powf(-1.253));
    let turbidity_coefficient = 0.04608 * TURBIDITY - 0.04586;
    let transmittance = WAVELENGTHS.map(|wavelength| {
        let air = 0.008_735 * wavelength.powf(-4.08);
        let aerosols = turbidity_coefficient * wavelength.powf(-1.3);
        (-(air + aerosols) * air_mass).exp()
    });
    Rgb::from(transmittance) * SOLAR_ILLUMINANCE
}

/// Linear Rec. 709 from CIE xyY (IEC 61966-2-1); what is out of gamut is cut off.
fn rgb_from_chromaticity(luminance: f32, x: f32, y: f32) -> Rgb {
    let cie_x = luminance * x / y;
    let cie_z = luminance * (1.0 - x - y) / y;
    Rgb::new(
        3.2406 * cie_x - 1.5372 * luminance - 0.4986 * cie_z,
        -0.9689 * cie_x + 1.8758 * luminance + 0.0415 * cie_z,
        0.0557 * cie_x - 0.2040 * luminance + 1.0570 * cie_z,
    )
    .map(|channel| channel.max(0.0))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::{Daylight, SUN_ZENITH};

    #[test]
    fn the_sky_is_blue_and_brighter_towards_the_sun() {
        let daylight = Daylight::new();
        let zenith = daylight.sky(Vec3::Y);
        assert!(zenith.b > 1.3 * zenith.r, "{zenith:?}");
        // The zenith is what the model says it is: xyY there and back.
        assert!((zenith.luminance() / super::zenith_luminance() - 1.0).abs() < 1e-3);
        let away = Vec3::new(
            -daylight.towards_sun.x,
            SUN_ZENITH.cos(),
            -daylight.towards_sun.z,
        );
        let near = daylight.sky(daylight.towards_sun).luminance();
        assert!(near > 3.0 * daylight.sky(away).luminance());
    }

    /// Level ground has some 60 klx of sun on a clear day; the model's sky adds 28.9 klx,
    /// integrated elsewhere.
    #[test]
    fn illuminances_are_those_of_a_clear_day() {
        let daylight = Daylight::new();
        let sun = daylight.sun.luminance() * daylight.towards_sun.y;
        let sky = daylight.level_illuminance().luminance() - sun;
        assert!((55.0..70.0).contains(&sun), "{sun}");
        assert!((sky / 28.9 - 1.0).abs() < 0.02, "{sky}");
        assert!(daylight.sun.r > daylight.sun.b, "the sun is warm");
    }
}
