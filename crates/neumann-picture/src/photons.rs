//! Photons as pixels, coloured by their bounce or by their power, and what explains the colours.
//!
//! By bounce, a pixel has the mean colour of its `n` photons, times `1 - 2^(-n/2 · 2^EV)`: one
//! photon shows, and where many lie it is brighter. By power, it has the power of its photons in
//! their own colours: what [`PowerScale`] calls white is 1 at an exposure of 0, and then exposure
//! and tone curve act as on radiance.

use std::fmt;
use std::str::FromStr;

use neumann_core::film::View;
use neumann_core::photons::{PhotonPicture, PhotonStack};
use neumann_core::radiometry::Rgb;

use crate::png_file::Pixels8;
use crate::tone::{Display, quantise, srgb_from_linear};

/// What the colour of a photon says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PhotonColours {
    /// How often it was scattered.
    #[default]
    Bounce,
    /// What power it carries.
    Power,
}

impl PhotonColours {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 2] = [Self::Bounce, Self::Power];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bounce => "bounce",
            Self::Power => "power",
        }
    }
}

impl fmt::Display for PhotonColours {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The text does not say what photons are coloured by.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("photons are not coloured by '{0}'; use bounce or power")]
pub struct PhotonColoursError(String);

impl FromStr for PhotonColours {
    type Err = PhotonColoursError;

    fn from_str(text: &str) -> Result<Self, PhotonColoursError> {
        Self::ALL
            .into_iter()
            .find(|colours| colours.name() == text)
            .ok_or_else(|| PhotonColoursError(text.to_owned()))
    }
}

/// How photons are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonLook {
    /// What they are coloured by.
    pub colours: PhotonColours,
    /// Those of which terms are shown.
    pub part: View,
    /// Terms before the tail.
    pub n_layers: usize,
    /// Exposure; and the tone curve of powers.
    pub display: Display,
}

impl PhotonLook {
    /// True if photons of a bounce are shown.
    #[must_use]
    pub fn shows(&self, bounce: u32) -> bool {
        let bounce = bounce as usize;
        match self.part {
            View::Total => true,
            View::Term(k) => bounce == k,
            View::Upto(k) => bounce <= k,
            View::Tail => bounce >= self.n_layers,
        }
    }

    /// One line on what is shown.
    #[must_use]
    pub fn caption(&self) -> String {
        let by = format!("photons by {}", self.colours);
        match self.part {
            View::Total => by,
            View::Term(0) | View::Upto(0) => "no photons: emitted light has none".to_owned(),
            View::Term(k) | View::Upto(k @ 1) => format!("{by}: of bounce {k}"),
            View::Upto(k) => format!("{by}: of bounces 1 to {k}"),
            View::Tail => format!("{by}: of bounce {} and more", self.n_layers),
        }
    }

    /// The picture, without a legend.
    #[must_use]
    pub fn pixels(&self, photons: &PhotonPicture, scale: PowerScale) -> Pixels8 {
        let codes = Codes::new();
        let colour = |pixel| {
            let stacks = photons.of_pixel(pixel).iter();
            let mut shown = stacks.filter(|stack| self.shows(stack.bounce)).peekable();
            if shown.peek().is_none() {
                return [0; 3];
            }
            match self.colours {
                PhotonColours::Bounce => codes.of(self.by_bounce(shown)),
                PhotonColours::Power => {
                    let power = shown.fold(Rgb::BLACK, |sum, stack| sum + stack.power);
                    codes.of(self.display.linear(power / scale.white))
                }
            }
        };
        let (width, height) = (photons.width(), photons.height());
        Pixels8 {
            width,
            height,
            pixels: (0..width * height).map(colour).collect(),
        }
    }

    /// The colour of photons of one pixel, display-linear.
    fn by_bounce<'s>(&self, stacks: impl Iterator<Item = &'s PhotonStack>) -> Rgb {
        let (mut sum, mut n) = (Rgb::BLACK, 0.0);
        for stack in stacks {
            sum += bounce_colour(stack.bounce) * stack.n as f32;
            n += stack.n as f32;
        }
        let exposed = n * self.display.exposure_ev.exp2();
        sum * ((1.0 - (-0.5 * exposed).exp2()) / n)
    }

    /// The rows of the legend of bounces: those that are seen, the last one for all beyond.
    #[must_use]
    pub fn bounce_keys(&self, photons: &PhotonPicture) -> Vec<BounceKey> {
        let by_bounce = photons.by_bounce();
        let total = photons.n_seen().max(1) as f64;
        let rest = COLOURS.len() as u32 + 1;
        let mut keys: Vec<BounceKey> = Vec::new();
        for stack in by_bounce.iter().filter(|stack| stack.n > 0) {
            let bounce = stack.bounce.min(rest);
            let (share, is_shown) = (f64::from(stack.n) / total, self.shows(stack.bounce));
            match keys.last_mut().filter(|key| key.bounce == bounce) {
                Some(key) => {
                    key.share += share;
                    key.is_shown |= is_shown;
                    key.has_more = true;
                }
                None => keys.push(BounceKey {
                    colour: codes_of(bounce_colour(bounce)),
                    bounce,
                    has_more: false,
                    share,
                    is_shown,
                }),
            }
        }
        keys
    }

    /// The steps of the legend of powers, brightest first: the colour of a grey power, sRGB codes,
    /// and that power in words.
    #[must_use]
    pub fn power_keys(&self, scale: PowerScale) -> Vec<([u8; 3], String)> {
        let brightest = scale.white * (-self.display.exposure_ev).exp2();
        let steps = [1.0, 0.5, 0.25, 0.125, 0.0].into_iter().enumerate();
        steps
            .map(|(i, step)| {
                let power = brightest * step;
                let colour = self.display.srgb8(Rgb::splat(power / scale.white));
                let sign = if i == 0 { "≥ " } else { "" };
                (colour, format!("{sign}{}", watts(power)))
            })
            .collect()
    }
}

/// A row of the legend of bounces.
#[derive(Clone, Debug, PartialEq)]
pub struct BounceKey {
    /// Its colour, sRGB codes.
    pub colour: [u8; 3],
    /// The bounce k.
    pub bounce: u32,
    /// Whether it stands for higher ones, too.
    pub has_more: bool,
    /// Its share of the photons that are seen.
    pub share: f64,
    /// Whether the chosen part of the series has it.
    pub is_shown: bool,
}

impl BounceKey {
    /// Its name: the bounce, with a plus where it stands for higher ones, too.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}{}", self.bounce, if self.has_more { "+" } else { "" })
    }
}

/// Which power is white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerScale {
    /// W of a pixel, in each channel.
    pub white: f32,
}

impl PowerScale {
    /// The scale by which nineteen of twenty pixels that have photons are below white, or nearly:
    /// it is one of 1, 1.5, 2, 3, 5 and 7 times a power of ten, so that it holds still while
    /// photons change.
    #[must_use]
    pub fn of(photons: &PhotonPicture) -> Self {
        let n_pixels = photons.width() * photons.height();
        let step = n_pixels.div_ceil(MOST_SAMPLES).max(1);
        // So that it does not stay in a few columns.
        let step = if photons.width().is_multiple_of(step) {
            step + 1
        } else {
            step
        };
        let powers = (0..n_pixels).step_by(step).filter_map(|pixel| {
            let stacks = photons.of_pixel(pixel).iter();
            let power = stacks.fold(Rgb::BLACK, |sum, stack| sum + stack.power);
            Some(power.max_channel()).filter(|power| *power > 0.0)
        });
        let mut powers: Vec<f32> = powers.collect();
        let Some(last) = powers.len().checked_sub(1) else {
            return Self { white: 1.0 };
        };
        let (_, power, _) = powers.select_nth_unstable_by(last * 19 / 20, f32::total_cmp);
        Self {
            white: round_number(*power),
        }
    }
}

/// Pixels that a scale is found from.
const MOST_SAMPLES: usize = 1 << 16;

/// The first of 1, 1.5, 2, 3, 5 and 7 times a power of ten that is not below a value, roughly.
fn round_number(value: f32) -> f32 {
    let value = f64::from(value).clamp(1e-30, 1e30);
    let decade = 10f64.powf(value.log10().floor());
    let steps = [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0];
    let step = steps.into_iter().find(|step| step * decade >= 0.97 * value);
    (step.unwrap_or(10.0) * decade) as f32
}

/// What is known of the photons, one fact a line.
#[must_use]
pub fn facts(photons: &PhotonPicture) -> [String; 4] {
    [
        format!("{} light paths", grouped(photons.n_paths() as u64)),
        format!("{} photons in all", grouped(photons.n_photons() as u64)),
        format!("{} photons seen", grouped(photons.n_seen())),
        format!("radius {} m", figures(f64::from(photons.radius()), 3)),
    ]
}

/// A power with its unit: `1.5 mW`.
#[must_use]
pub fn watts(power: f32) -> String {
    let power = f64::from(power);
    let prefixes = [
        (1e6, "MW"),
        (1e3, "kW"),
        (1.0, "W"),
        (1e-3, "mW"),
        (1e-6, "µW"),
    ];
    // What rounds to 1000 of a unit is 1 of the next.
    let fits = |(size, _): &(f64, &str)| power >= 0.9995 * size;
    let (size, unit) = match prefixes.into_iter().find(fits) {
        Some(prefix) => prefix,
        None if power > 0.0 => (1e-9, "nW"),
        None => return "0".to_owned(),
    };
    format!("{} {unit}", figures(power / size, 3))
}

/// A number to so many figures, without zeros at its end.
fn figures(value: f64, n: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let places = (n - 1 - value.abs().log10().floor() as i32).clamp(0, 12);
    let text = format!("{value:.*}", places as usize);
    if text.contains('.') {
        let text = text.trim_end_matches('0');
        return text.trim_end_matches('.').to_owned();
    }
    text
}

/// A whole number with commas between its thousands.
#[must_use]
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Colours that can be told apart without seeing red from green: Okabe and Ito 2008, linear.
const COLOURS: [[f32; 3]; 7] = [
    [0.791, 0.342, 0.000],
    [0.093, 0.456, 0.815],
    [0.000, 0.342, 0.171],
    [0.871, 0.776, 0.054],
    [0.000, 0.168, 0.445],
    [0.665, 0.112, 0.000],
    [0.604, 0.191, 0.386],
];
/// That of all bounces beyond.
const REST: [f32; 3] = [0.4; 3];

/// The colour of a bounce, linear.
fn bounce_colour(bounce: u32) -> Rgb {
    let index = bounce.max(1) as usize - 1;
    Rgb::from(COLOURS.get(index).copied().unwrap_or(REST))
}

fn codes_of(linear: Rgb) -> [u8; 3] {
    linear.to_array().map(|v| quantise(srgb_from_linear(v)))
}

/// sRGB codes of linear values, from a table: a window makes many pixels at once.
struct Codes(Vec<u8>);

impl Codes {
    const N: usize = 1 << 13;

    fn new() -> Self {
        let linear = (0..=Self::N).map(|i| i as f32 / Self::N as f32);
        Self(linear.map(|v| quantise(srgb_from_linear(v))).collect())
    }

    /// Of values in [0, 1].
    fn of(&self, linear: Rgb) -> [u8; 3] {
        linear.to_array().map(|v| {
            let index = (v * Self::N as f32 + 0.5) as usize;
            self.0[index.min(Self::N)]
        })
    }
}

#[cfg(test)]
mod tests {
    use neumann_core::film::View;

    use super::{PhotonColours, PhotonLook, figures, grouped, round_number, watts};

    #[test]
    fn numbers_read_well() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(65_536), "65,536");
        assert_eq!(grouped(12_000_000), "12,000,000");
        for (power, text) in [
            (0.0, "0"),
            (1.5e-3, "1.5 mW"),
            (7e-7, "700 nW"),
            (2e-6, "2 µW"),
            (9.999e-4, "1 mW"),
            (0.75, "750 mW"),
            (12.345, "12.3 W"),
            (4e7, "40 MW"),
        ] {
            assert_eq!(watts(power), text);
        }
        assert_eq!(figures(0.012_345, 3), "0.0123");
        assert_eq!(figures(1200.0, 3), "1200");
    }

    #[test]
    fn scales_are_round_and_not_far_below_what_they_hold() {
        for i in 1..2000 {
            let value = 1.01f32.powi(i - 1000);
            let round = round_number(value);
            assert!(
                round >= 0.96 * value && round <= 1.65 * value,
                "{value}: {round}"
            );
        }
        assert!(round_number(0.0) > 0.0 && round_number(f32::INFINITY).is_finite());
    }

    #[test]
    fn parts_of_the_series_choose_bounces() {
        let shown = |part| {
            let look = PhotonLook {
                part,
                n_layers: 4,
                ..PhotonLook::default()
            };
            (1..8).filter(|k| look.shows(*k)).collect::<Vec<_>>()
        };
        assert_eq!(shown(View::Total), [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(shown(View::Term(2)), [2]);
        assert_eq!(shown(View::Upto(2)), [1, 2]);
        assert_eq!(shown(View::Tail), [4, 5, 6, 7]);
        assert_eq!(shown(View::Term(0)), [0u32; 0]);
    }

    #[test]
    fn names_read_back() {
        for colours in PhotonColours::ALL {
            assert_eq!(colours.to_string().parse(), Ok(colours));
        }
        assert!("radius".parse::<PhotonColours>().is_err());
    }
}
