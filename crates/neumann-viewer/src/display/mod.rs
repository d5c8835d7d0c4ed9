//! How the film is looked at: everything here changes without rendering anew.

mod gpu;
pub mod ground;
pub mod image_area;
pub mod legend;
mod planes;
pub mod values;

pub use gpu::{Draw, FilmGpu, Look, MAX_DRAWS, Mode, SharedPlanes, Variant};
pub use planes::{Plane, Planes, Slot, mean_of};

use neumann_core::film::View as Part;
use neumann_picture::false_colour::ColourMap;
use neumann_picture::tone::{Display, ToneCurve};

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
    /// The difference from the reference instead of the picture.
    pub is_difference: bool,
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
            is_difference: false,
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
