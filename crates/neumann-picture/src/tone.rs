//! From linear radiance to the screen: exposure, tone curve, sRGB, eight bits.
//!
//! `code = round(255 · sRGB(curve(L · 2^EV)))`
//!
//! A curve takes scene-linear Rec. 709 values to display-linear ones in [0, 1].
//! Sources: \[Reinhard 2002\] (3), here per channel; \[Hill\], the fit of the ACES
//! RRT and ODT in the `BakingLab` of MJP and Stephen Hill; \[Sobotka\] `AgX`, with the
//! polynomial of Benjamin Wrensch, "Minimal `AgX` implementation" (2023);
//! \[Khronos\] PBR Neutral tone mapper, specification of 2024.
//!
//! Greys stay greys to the last bit: every matrix here is applied as "own
//! channel plus multiples of differences between channels", so its rows add
//! up to one exactly, and channels of the same value go through the same
//! operations.

mod curves;

use std::fmt;
use std::str::FromStr;

use neumann_core::radiometry::Rgb;

/// How radiance beyond the range of the screen is brought into it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ToneCurve {
    /// Cut off at 1.
    #[default]
    None,
    /// `x / (1 + x)` in each channel.
    Reinhard,
    /// The film look of the Academy's reference transform.
    Aces,
    /// Film-like, bright colours go to white.
    Agx,
    /// True colours up to 0.8, highlights compressed.
    Neutral,
}

impl ToneCurve {
    /// All curves, in the order of menus.
    pub const ALL: [Self; 5] = [
        Self::None,
        Self::Reinhard,
        Self::Aces,
        Self::Agx,
        Self::Neutral,
    ];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
            Self::Agx => "agx",
            Self::Neutral => "neutral",
        }
    }

    /// Takes exposed scene-linear values to display-linear ones in [0, 1]; whatever is
    /// not a number becomes black.
    #[must_use]
    pub fn apply(self, exposed: Rgb) -> Rgb {
        // Negative values occur in differences, and NaN compares as false.
        let x = exposed.map(|v| if v > 0.0 { v.min(LARGEST) } else { 0.0 });
        let y = match self {
            Self::None => x,
            Self::Reinhard => x.map(curves::reinhard),
            Self::Aces => curves::aces(x),
            Self::Agx => curves::agx(x),
            Self::Neutral => curves::neutral(x),
        };
        y.map(|v| v.clamp(0.0, 1.0))
    }
}

/// Anything brighter is as bright as this: keeps infinities out of the curves.
const LARGEST: f32 = 1e9;

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The text is not the name of a tone curve.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not a tone curve; use none, reinhard, aces, agx or neutral")]
pub struct ToneCurveError(String);

impl FromStr for ToneCurve {
    type Err = ToneCurveError;

    fn from_str(text: &str) -> Result<Self, ToneCurveError> {
        Self::ALL
            .into_iter()
            .find(|curve| curve.name() == text)
            .ok_or_else(|| ToneCurveError(text.to_owned()))
    }
}

/// How radiance is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Exposure, in stops: radiance is multiplied by 2 to this power.
    pub exposure_ev: f32,
    /// Tone curve.
    pub tone: ToneCurve,
}

impl Display {
    /// Radiance as a display-linear colour in [0, 1].
    #[must_use]
    pub fn linear(&self, radiance: Rgb) -> Rgb {
        self.tone.apply(radiance * self.exposure_ev.exp2())
    }

    /// Radiance as an sRGB colour in [0, 1], not yet rounded to eight bits.
    #[must_use]
    pub fn srgb(&self, radiance: Rgb) -> Rgb {
        self.linear(radiance).map(srgb_from_linear)
    }

    /// Radiance as eight-bit sRGB.
    #[must_use]
    pub fn srgb8(&self, radiance: Rgb) -> [u8; 3] {
        self.srgb(radiance).to_array().map(quantise)
    }
}

/// The sRGB encoding of a linear value in [0, 1] (IEC 61966-2-1).
#[must_use]
pub fn srgb_from_linear(x: f32) -> f32 {
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// The linear value of an sRGB code in [0, 1] (IEC 61966-2-1).
#[must_use]
pub fn linear_from_srgb(x: f32) -> f32 {
    if x <= 0.040_45 {
        x / 12.92
    } else {
        ((x + 0.055) / 1.055).powf(2.4)
    }
}

/// A value in [0, 1] as one of 256 codes; out-of-range values go to the nearest code.
pub(crate) fn quantise(x: f32) -> u8 {
    (x * 255.0 + 0.5) as u8
}

/// Exposure, in stops, that shows a picture at a comfortable brightness.
///
/// The log-average luminance between the 5th and the 95th percentile of the lit
/// pixels is brought to middle grey, 0.18 (\[Reinhard 2002\] (1), with the
/// percentiles in place of its small offset, so that neither a lamp in view nor a
/// black ground moves it). 0 for a black picture.
#[must_use]
pub fn auto_exposure(pixels: &[Rgb]) -> f32 {
    // A quarter of a million values are plenty for a mean.
    let stride = (pixels.len() / 262_144).max(1);
    let mut luminances: Vec<f32> = pixels
        .iter()
        .step_by(stride)
        .map(|p| p.luminance())
        .filter(|l| l.is_finite() && *l > 1e-12)
        .collect();
    if luminances.is_empty() {
        return 0.0;
    }
    luminances.sort_unstable_by(f32::total_cmp);
    let n = luminances.len();
    let middle = &luminances[n / 20..(n - n / 20).max(n / 20 + 1)];
    let log_sum: f64 = middle.iter().map(|l| f64::from(*l).log2()).sum();
    let ev = 0.18f64.log2() - log_sum / middle.len() as f64;
    ev.clamp(-24.0, 24.0) as f32
}

#[cfg(test)]
mod tests {
    use super::{Display, ToneCurve, auto_exposure, linear_from_srgb};
    use neumann_core::radiometry::Rgb;

    #[test]
    fn greys_stay_exactly_neutral_under_every_curve() {
        for tone in ToneCurve::ALL {
            for i in 0..4000 {
                let grey = Rgb::splat((i as f32 / 200.0 - 14.0).exp2());
                let out = tone.apply(grey);
                assert!(out.r == out.g && out.g == out.b, "{tone} {grey:?} {out:?}");
                let [r, g, b] = Display {
                    exposure_ev: 0.37,
                    tone,
                }
                .srgb8(grey);
                assert!(r == g && g == b, "{tone} {grey:?}");
            }
        }
    }

    #[test]
    fn curves_rise_from_black_towards_white() {
        for tone in ToneCurve::ALL {
            let mut before = -1.0;
            for i in 0..=600 {
                let x = i as f32 / 100.0;
                let y = tone.apply(Rgb::splat(x)).g;
                assert!(y >= before - 2e-4, "{tone} falls at {x}: {before} {y}");
                before = y;
            }
            assert!(tone.apply(Rgb::BLACK).max_channel() < 1e-3, "{tone}");
            let far = tone.apply(Rgb::splat(1e5)).g;
            assert!(far > 0.97, "{tone} {far}");
        }
    }

    #[test]
    fn known_values() {
        assert!((ToneCurve::Reinhard.apply(Rgb::splat(1.0)).r - 0.5).abs() < 1e-6);
        // ACES fit at 0.18: (0.18 * (0.18 + 0.0245786) - 0.000090537) / (0.18 * (0.983729 * 0.18 +
        // 0.432951) + 0.238081)
        assert!((ToneCurve::Aces.apply(Rgb::splat(0.18)).r - 0.105_57).abs() < 1e-4);
        // AgX puts middle grey, 0.606 of its range of stops, at code 0.4968 of a display of
        // exponent 2.2.
        let agx = ToneCurve::Agx.apply(Rgb::splat(0.18)).r.powf(1.0 / 2.2);
        assert!((agx - 0.4968).abs() < 1e-3, "{agx}");
        // PBR Neutral takes 0.04 off everything, and bends from 0.76 on.
        assert!((ToneCurve::Neutral.apply(Rgb::splat(0.5)).r - 0.46).abs() < 1e-6);
    }

    #[test]
    fn neutral_keeps_hue_and_none_only_cuts() {
        let display = Display::default();
        assert_eq!(
            display.srgb8(Rgb::new(0.214_041_14, 0.0, 7.0)),
            [128, 0, 255]
        );
        let base = ToneCurve::Neutral.apply(Rgb::new(0.5, 0.3, 0.2));
        assert!((base.r - base.g - 0.2).abs() < 1e-6 && (base.g - base.b - 0.1).abs() < 1e-6);
    }

    #[test]
    fn odd_values_do_no_harm() {
        for tone in ToneCurve::ALL {
            let display = Display {
                exposure_ev: 3.0,
                tone,
            };
            assert_eq!(
                display.srgb8(Rgb::splat(f32::NAN)),
                display.srgb8(Rgb::BLACK)
            );
            assert!(display.srgb8(Rgb::splat(f32::INFINITY))[0] > 245, "{tone}");
            assert_eq!(display.srgb8(Rgb::splat(-5.0)), display.srgb8(Rgb::BLACK));
        }
    }

    #[test]
    fn every_code_survives_the_round_trip() {
        for code in 0..=255u8 {
            let linear = linear_from_srgb(f32::from(code) / 255.0);
            assert_eq!(Display::default().srgb8(Rgb::splat(linear))[1], code);
        }
    }

    #[test]
    fn names_read_back() {
        for tone in ToneCurve::ALL {
            assert_eq!(tone.to_string().parse(), Ok(tone));
        }
        assert!("filmic".parse::<ToneCurve>().is_err());
    }

    #[test]
    fn exposure_brings_the_middle_to_middle_grey() {
        assert!((auto_exposure(&[Rgb::splat(0.18); 100])).abs() < 1e-5);
        assert!((auto_exposure(&[Rgb::splat(0.09); 100]) - 1.0).abs() < 1e-5);
        // A small bright lamp and black surroundings change nothing.
        let mut pixels = vec![Rgb::splat(0.36); 1000];
        pixels[..20].fill(Rgb::splat(1e4));
        pixels.extend([Rgb::BLACK; 500]);
        assert!((auto_exposure(&pixels) + 1.0).abs() < 1e-4);
        assert_eq!(auto_exposure(&[Rgb::BLACK; 7]), 0.0);
        assert_eq!(auto_exposure(&[]), 0.0);
    }
}
