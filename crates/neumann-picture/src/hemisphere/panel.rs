//! One picture over the hemisphere, in colours.

use neumann_core::film::View;
use neumann_core::radiometry::Rgb;
use neumann_core::render::Hemisphere;
use neumann_core::render::hemisphere::{Estimator, Integrand, Point};

use crate::figures::significant;
use crate::tone::Display;

/// Of the pixels that are not black, so many may be brighter than white.
const CLIPPED: f64 = 0.01;
/// Corners of the outline of a disk.
const N_CORNERS: usize = 96;

/// How the values of a picture are shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PanelScale {
    /// As the picture of the scene shows radiance.
    AsPicture,
    /// From black to the value that is white, in its unit.
    White(f32),
    /// All are 0.
    Black,
}

/// One picture over the hemisphere.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What it shows.
    pub integrand: Integrand,
    /// How its values are shown.
    pub scale: PanelScale,
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// sRGB, row 0 on top; black outside of the disks.
    pub pixels: Vec<[u8; 3]>,
}

impl Panel {
    /// How its values are shown, in words.
    #[must_use]
    pub fn note(&self) -> String {
        match self.scale {
            PanelScale::AsPicture => "as the picture".to_owned(),
            PanelScale::White(white) => {
                let white = significant(f64::from(white), 2);
                let note = format!("white: {white} {}", unit(self.integrand));
                note.trim_end().to_owned()
            }
            PanelScale::Black => "0 everywhere".to_owned(),
        }
    }

    /// Draws a picture: incident radiance of a part of the series as `display` shows the scene, any
    /// other between black and its largest values.
    #[must_use]
    pub fn new(
        hemisphere: &Hemisphere,
        integrand: Integrand,
        part: View,
        display: &Display,
    ) -> Self {
        let values = hemisphere.picture(integrand, part);
        let scale = match integrand {
            Integrand::Incident => PanelScale::AsPicture,
            Integrand::Cosine => PanelScale::White(1.0),
            _ => white(&values).map_or(PanelScale::Black, PanelScale::White),
        };
        let plain = Display::default();
        let pixels = values.iter().map(|value| match scale {
            PanelScale::AsPicture => display.srgb8(*value),
            PanelScale::White(white) => plain.srgb8(*value / white),
            PanelScale::Black => [0; 3],
        });
        Self {
            integrand,
            scale,
            size: hemisphere.map().size(),
            pixels: pixels.collect(),
        }
    }
}

/// A value that few are above; `None` if all are black.
fn white(values: &[Rgb]) -> Option<f32> {
    let lit = values.iter().map(|v| v.max_channel()).filter(|v| *v > 0.0);
    let mut lit: Vec<f32> = lit.collect();
    lit.sort_by(f32::total_cmp);
    let last = lit.len().saturating_sub(1);
    let index = (last as f64 * (1.0 - CLIPPED)).round() as usize;
    lit.get(index).copied()
}

/// Its formula; `_` is before an index.
#[must_use]
pub fn formula(integrand: Integrand) -> &'static str {
    match integrand {
        Integrand::Incident => "L_{i}",
        Integrand::Bsdf => "f",
        Integrand::Cosine => "cos θ",
        Integrand::Product => "L_{i} f cos θ",
        Integrand::Density(Estimator::Bsdf) => "p_{bsdf}",
        Integrand::Density(Estimator::Light) => "p_{light}",
        Integrand::Density(Estimator::Mis) => "½ (p_{bsdf} + p_{light})",
    }
}

/// The unit of its values.
fn unit(integrand: Integrand) -> &'static str {
    match integrand {
        Integrand::Incident => "W m⁻² sr⁻¹",
        Integrand::Cosine => "",
        Integrand::Product => "W m⁻² sr⁻²",
        Integrand::Bsdf | Integrand::Density(_) => "sr⁻¹",
    }
}

/// What it shows, in a sentence.
#[must_use]
pub fn about(integrand: Integrand) -> &'static str {
    match integrand {
        Integrand::Incident => {
            "Incident radiance: what arrives at the point from each direction, of the chosen term."
        }
        Integrand::Bsdf => "The BSDF: how much of it the surface sends to the viewer.",
        Integrand::Cosine => "The cosine with the normal: how much of a beam the surface catches.",
        Integrand::Product => "The product: what each direction brings. Summed up it is the pixel.",
        Integrand::Density(Estimator::Bsdf) => {
            "How densely BSDF sampling draws directions; dots are the first that it has drawn."
        }
        Integrand::Density(Estimator::Light) => {
            "How densely light sampling aims at directions, whatever is in between; dots are the \
             first that it has aimed at."
        }
        Integrand::Density(Estimator::Mis) => {
            "How densely both ways together draw directions, half of them each."
        }
    }
}

/// True if points of a kind belong to a picture: lights to what arrives, lobes to the BSDF, both to
/// the product.
#[must_use]
pub fn shows(integrand: Integrand, point: &Point) -> bool {
    match integrand {
        Integrand::Incident => point.is_light,
        Integrand::Bsdf => !point.is_light,
        Integrand::Product => true,
        Integrand::Cosine | Integrand::Density(_) => false,
    }
}

/// The outlines of the disks of a map, in pixels of its pictures.
#[must_use]
pub fn outline(hemisphere: &Hemisphere) -> Vec<Vec<[f32; 2]>> {
    let map = hemisphere.map();
    let radius = 0.5 * map.size().1 as f32;
    let disks = (0..map.n_disks()).map(|disk| {
        let middle = [radius * (2 * disk + 1) as f32, radius];
        ring(middle, radius)
    });
    disks.collect()
}

/// A closed ring.
#[must_use]
pub fn ring(middle: [f32; 2], radius: f32) -> Vec<[f32; 2]> {
    let corner = |i: usize| {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / N_CORNERS as f32).sin_cos();
        [middle[0] + radius * cos, middle[1] + radius * sin]
    };
    (0..=N_CORNERS).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use neumann_core::radiometry::Rgb;

    use super::white;

    #[test]
    fn few_pixels_are_brighter_than_white() {
        let mut values: Vec<Rgb> = (1..=1000).map(|i| Rgb::splat(i as f32)).collect();
        values.extend([Rgb::BLACK; 500]);
        let brightest = white(&values).expect("some are not black");
        assert!((brightest - 990.0).abs() < 2.0, "{brightest}");
        assert_eq!(white(&[Rgb::BLACK]), None);
    }
}
