//! How the brightness of a picture is spread, and what of it the screen cannot tell apart.
//!
//! Brightness is in stops (EV) about middle grey, 0.18, after exposure: `log2(L · 2^EV / 0.18)`.

use std::ops::RangeInclusive;

use neumann_core::radiometry::Rgb;

use crate::tone::Display;

/// What is counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// Luminance.
    #[default]
    Luminance,
    /// Red, green and blue, each by itself.
    Rgb,
}

/// Stops that are counted; what lies beyond stands at the ends.
pub const RANGE: RangeInclusive<f32> = -12.0..=8.0;
/// Bars to a stop.
const FINENESS: f32 = 4.0;
const MIDDLE_GREY: f32 = 0.18;

/// How many pixels are how bright.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// For luminance, or for red, green and blue: shares of the pixels, from dark to bright. Black
    /// pixels have no place.
    pub bars: Vec<Vec<f32>>,
    /// Share of the pixels that are too dark for the window,
    pub too_dark: f32,
    /// and too bright for it.
    pub too_bright: f32,
}

/// Exposure, and what the screen can tell apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Exposure, stops.
    pub exposure_ev: f32,
    /// Stops about middle grey, after exposure: whatever is darker or brighter looks alike.
    pub ends: [f32; 2],
}

impl Window {
    /// That of a tone curve: between the last grey that is black and the first that is white.
    #[must_use]
    pub fn of_display(display: &Display) -> Self {
        let curve = Display {
            exposure_ev: 0.0,
            ..*display
        };
        let code = |stops: f32| curve.srgb8(Rgb::splat(MIDDLE_GREY * stops.exp2()))[0];
        let end = |is_beyond: &dyn Fn(u8) -> bool| {
            let (mut low, mut high) = (-24.0f32, 24.0f32);
            for _ in 0..20 {
                let middle = 0.5 * (low + high);
                if is_beyond(code(middle)) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            0.5 * (low + high)
        };
        Self {
            exposure_ev: display.exposure_ev,
            ends: [end(&|code| code > 0), end(&|code| code == 255)],
        }
    }

    /// That of a colour map, between base-2 logarithms of luminance.
    #[must_use]
    pub fn of_map(range: [f32; 2], exposure_ev: f32) -> Self {
        Self {
            exposure_ev,
            ends: range.map(|end| end + exposure_ev - MIDDLE_GREY.log2()),
        }
    }
}

impl Histogram {
    /// Of some pixels.
    #[must_use]
    pub fn of(pixels: &[Rgb], channels: Channels, window: &Window) -> Self {
        let (first, last) = (*RANGE.start(), *RANGE.end());
        let n_bars = ((last - first) * FINENESS) as usize;
        let n_channels = match channels {
            Channels::Luminance => 1,
            Channels::Rgb => 3,
        };
        let mut bars = vec![vec![0.0f32; n_bars]; n_channels];
        let (mut n_dark, mut n_bright) = (0u32, 0u32);
        let shift = window.exposure_ev - MIDDLE_GREY.log2();
        let [dark, bright] = window.ends;
        for pixel in pixels {
            let [r, g, b] = pixel.to_array();
            let values = match channels {
                Channels::Luminance => [pixel.luminance(); 3],
                Channels::Rgb => [r, g, b],
            };
            let stops = values.map(|value| value.log2() + shift);
            let is_below = |stops: &f32| stops.is_nan() || *stops < dark;
            n_dark += u32::from(stops.iter().all(is_below));
            n_bright += u32::from(stops.iter().any(|stops| *stops > bright));
            for (bars, stops) in bars.iter_mut().zip(stops) {
                if stops.is_finite() {
                    let bar = ((stops - first) * FINENESS).max(0.0) as usize;
                    bars[bar.min(n_bars - 1)] += 1.0;
                }
            }
        }
        let n = pixels.len().max(1) as f32;
        for bar in bars.iter_mut().flatten() {
            *bar /= n;
        }
        Self {
            bars,
            too_dark: n_dark as f32 / n,
            too_bright: n_bright as f32 / n,
        }
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::radiometry::Rgb;

    use super::{Channels, Histogram, Window};
    use crate::tone::{Display, ToneCurve};

    #[test]
    fn the_window_ends_where_codes_do() {
        for tone in ToneCurve::ALL {
            let display = Display {
                exposure_ev: 1.5,
                tone,
            };
            let window = Window::of_display(&display);
            let code = |stops: f32| {
                let radiance = 0.18 * (stops - display.exposure_ev).exp2();
                display.srgb8(Rgb::splat(radiance))[0]
            };
            let [dark, bright] = window.ends;
            assert_eq!(code(dark - 0.01), 0, "{tone}");
            assert!(code(dark + 0.01) > 0, "{tone}");
            assert!(code(bright - 0.01) < 255, "{tone}");
            assert_eq!(code(bright + 0.01), 255, "{tone}");
        }
    }

    #[test]
    fn pixels_stand_where_their_brightness_is() {
        let grey = |value: f32| Rgb::splat(value);
        let pixels = [grey(0.09), grey(0.09), grey(0.0), grey(9.0)];
        let display = Display {
            exposure_ev: 1.0,
            tone: ToneCurve::None,
        };
        let window = Window::of_display(&display);
        let histogram = Histogram::of(&pixels, Channels::Luminance, &window);
        assert_eq!((histogram.too_dark, histogram.too_bright), (0.25, 0.25));
        // Half of the pixels are middle grey after exposure; rounding may go either way.
        let bars = &histogram.bars[0];
        assert_eq!(bars[47] + bars[48], 0.5);
        assert_eq!(bars.iter().sum::<f32>(), 0.75, "black has no place");
    }

    #[test]
    fn channels_are_counted_apart_and_one_that_is_too_bright_counts() {
        let pixels = [Rgb::new(4.0, 0.01, 0.0), Rgb::splat(0.18)];
        let window = Window::of_display(&Display::default());
        let luminance = Histogram::of(&pixels, Channels::Luminance, &window);
        let apart = Histogram::of(&pixels, Channels::Rgb, &window);
        assert_eq!((luminance.too_bright, apart.too_bright), (0.0, 0.5));
        assert_eq!(apart.too_dark, 0.0, "red can be told apart");
        let sums: Vec<f32> = apart.bars.iter().map(|bars| bars.iter().sum()).collect();
        assert_eq!(sums, [1.0, 1.0, 0.5]);
    }

    #[test]
    fn a_colour_map_has_a_window_of_its_own() {
        let window = Window::of_map([-3.0, 2.0], 1.0);
        let histogram =
            |value: f32| Histogram::of(&[Rgb::splat(value)], Channels::Luminance, &window);
        assert_eq!(histogram(0.12).too_dark, 1.0);
        assert_eq!(histogram(0.13).too_dark, 0.0);
        assert_eq!(histogram(3.9).too_bright, 0.0);
        assert_eq!(histogram(4.1).too_bright, 1.0);
    }
}
