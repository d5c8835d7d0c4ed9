//! How the film is looked at: everything here changes without rendering anew.

mod gpu;
pub mod ground;
pub mod image_area;
pub mod layers;
pub mod legend;
mod planes;
pub mod values;

pub use gpu::{Draw, FilmGpu, Look, MAX_DRAWS, Mode, SharedPlanes, Variant};
pub use planes::{Plane, Planes, Slot, mean_of};

use neumann_core::film::View as Part;
use neumann_core::radiometry::Rgb;
use neumann_picture::false_colour::{ColourMap, diverging};
use neumann_picture::sheet::Scale;
use neumann_picture::tone::{Display, ToneCurve};

use self::layers::LayerSettings;
use crate::region::Drawing;
use crate::widgets::significant;

/// What a difference is taken to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The picture less the reference.
    Reference,
    /// What is held as A less what is held as B.
    Held,
}

/// How the film is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewSettings {
    /// Which part of the series.
    pub part: Part,
    /// Exposure, stops.
    pub exposure_ev: f32,
    /// Exposure follows the picture.
    pub is_auto: bool,
    /// Tone curve.
    pub tone: ToneCurve,
    /// Luminance as colours instead of the picture.
    pub is_false_colour: bool,
    /// The colours for it.
    pub map: ColourMap,
    /// Stops that the colours span.
    pub map_stops: f32,
    /// Physical pixels per pixel of the film; `None` shows the whole picture.
    pub zoom: Option<f32>,
    /// What is in the middle when magnified, as a share of width and height.
    pub center: [f32; 2],
    /// The wipe between A and B.
    pub is_wiping: bool,
    /// Its place across the picture, 0 to 1.
    pub wipe: f32,
    /// A difference instead of the picture.
    pub difference: Option<Against>,
    /// What the pixel under the pointer holds stands on the picture.
    pub is_probing: bool,
    /// The next drag draws a region.
    pub drawing: Option<Drawing>,
    /// Layers beside the bounces.
    pub layers: LayerSettings,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            part: Part::Total,
            exposure_ev: 0.0,
            is_auto: false,
            tone: ToneCurve::None,
            is_false_colour: false,
            map: ColourMap::Viridis,
            map_stops: 10.0,
            zoom: None,
            center: [0.5, 0.5],
            is_wiping: false,
            wipe: 0.5,
            difference: None,
            is_probing: true,
            drawing: None,
            layers: LayerSettings::default(),
        }
    }
}

/// Largest magnification, physical pixels per pixel of the film.
pub const MAX_ZOOM: f32 = 128.0;

impl ViewSettings {
    /// Exposure and tone curve, as files and thumbnails use them.
    #[must_use]
    pub fn display(&self) -> Display {
        Display {
            exposure_ev: self.exposure_ev,
            tone: self.tone,
        }
    }

    /// Base-2 logarithms of the luminances at the ends of the false colours: the brightest is two
    /// stops above what the exposure brings to white.
    #[must_use]
    pub fn map_range(&self) -> [f32; 2] {
        let top = 2.0 - self.exposure_ev;
        [top - self.map_stops, top]
    }

    /// Luminance at the end of the scale of differences.
    #[must_use]
    pub fn difference_range(&self) -> f32 {
        0.25 * (-self.exposure_ev).exp2()
    }

    /// A radiance as the screen shows it, sRGB codes.
    #[must_use]
    pub fn code(&self, radiance: Rgb) -> [u8; 3] {
        if !self.is_false_colour {
            return self.display().srgb8(radiance);
        }
        let [low, high] = self.map_range();
        let stops = radiance.luminance().max(1e-30).log2();
        self.map.rgb(in_steps((stops - low) / (high - low)))
    }

    /// A difference of two radiances as the screen shows it, sRGB codes.
    #[must_use]
    pub fn difference_code(&self, left: Rgb, right: Rgb) -> [u8; 3] {
        let apart = left.luminance() - right.luminance();
        let t = in_steps(0.5 + 0.5 * apart / self.difference_range());
        diverging(2.0 * t - 1.0)
    }

    /// What the colours of a difference, or false colours, stand for.
    #[must_use]
    pub fn scale(&self, is_difference: bool) -> Scale {
        let steps = (0..=255u8).map(|i| f32::from(i) / 255.0);
        let unit = "W m⁻² sr⁻¹".to_owned();
        if is_difference {
            let end = f64::from(self.difference_range());
            let mark = |t: f32| {
                let value = significant(end * f64::from(t), 2);
                let sign = if t > 0.0 { "+" } else { "" };
                (0.5 + 0.5 * t, format!("{sign}{value}"))
            };
            return Scale {
                unit,
                colours: steps.map(|t| diverging(2.0 * t - 1.0)).collect(),
                marks: [-1.0, -0.5, 0.0, 0.5, 1.0].map(mark).into(),
            };
        }
        let [low, high] = self.map_range();
        let mark = |i: u8| {
            let t = f32::from(i) / 4.0;
            let value = f64::from(low + (high - low) * t).exp2();
            (t, significant(value, 2))
        };
        Scale {
            unit,
            colours: steps.map(|t| self.map.rgb(t)).collect(),
            marks: (0..=4).map(mark).collect(),
        }
    }

    /// What the shader needs to know, for a whole picture.
    #[must_use]
    pub fn look(&self) -> Look {
        let [low, high] = self.map_range();
        let map = ColourMap::ALL.iter().position(|m| *m == self.map);
        Look {
            left: [0.0, 0.0, 1.0, 1.0],
            right: [0.0, 0.0, 1.0, 1.0],
            scale: [1.0, 1.0, self.exposure_ev.exp2(), 2.0],
            range: [low, high, self.difference_range(), 0.0],
            map: [map.unwrap_or(0) as i32, 0, 0, 0],
        }
    }

    /// By which pipeline one picture is shown.
    #[must_use]
    pub fn variant(&self, is_smooth: bool) -> Variant {
        let tone = ToneCurve::ALL.iter().position(|t| *t == self.tone);
        Variant {
            // False colours know no tone curve.
            tone: tone.filter(|_| !self.is_false_colour).unwrap_or(0),
            mode: if self.is_false_colour {
                Mode::FalseColour
            } else {
                Mode::Picture
            },
            is_wiping: false,
            is_smooth,
        }
    }

    /// Shows the row's term or sum with that number; the last place of the terms is the tail, that
    /// of the sums L.
    pub fn choose(&mut self, is_sum: bool, place: usize, n_layers: usize) {
        self.part = match (is_sum, place < n_layers) {
            (false, true) => Part::Term(place),
            (false, false) => Part::Tail,
            (true, true) => Part::Upto(place),
            (true, false) => Part::Total,
        };
    }

    /// Row (true: sums) and place of the part on the filmstrip.
    #[must_use]
    pub fn place(&self, n_layers: usize) -> (bool, usize) {
        match self.part {
            Part::Term(k) => (false, k.min(n_layers)),
            Part::Tail => (false, n_layers),
            Part::Upto(k) => (true, k.min(n_layers)),
            Part::Total => (true, n_layers),
        }
    }
}

/// The nearest of the 256 places of a colour map that the shader knows.
fn in_steps(t: f32) -> f32 {
    (t.clamp(0.0, 1.0) * 255.0).round() / 255.0
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View as Part;

    use super::ViewSettings;

    #[test]
    fn places_read_back() {
        let mut settings = ViewSettings::default();
        for part in [Part::Total, Part::Tail, Part::Term(3), Part::Upto(0)] {
            settings.part = part;
            let (is_sum, place) = settings.place(8);
            settings.choose(is_sum, place, 8);
            assert_eq!(settings.part, part);
        }
    }
}
