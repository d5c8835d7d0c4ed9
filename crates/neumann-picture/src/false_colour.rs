//! False colour: numbers as colours that everybody can tell apart.
//!
//! Viridis, inferno and magma by Stéfan van der Walt and Nathaniel Smith, and
//! cividis by Jamie Nuñez, Christopher Anderton and Ryan Renslow (PLOS ONE
//! 13(7), 2018), all CC0, as 33 of their 256 colours with straight lines
//! between them; within 2 codes of the originals (cividis 6, where it bends).
//! Each is monotone in lightness and made for readers with colour-vision
//! deficiencies. Differences with a sign go from blue through grey to orange in
//! Oklab (Björn Ottosson, 2020), a pair that the common deficiencies keep apart.

use std::fmt;
use std::str::FromStr;

/// A map from [0, 1] to colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ColourMap {
    /// Dark blue, green, yellow.
    #[default]
    Viridis,
    /// Black, red, pale yellow.
    Inferno,
    /// Black, purple, pale cream.
    Magma,
    /// Dark blue, grey, yellow: the same to readers with red-green deficiencies.
    Cividis,
}

impl ColourMap {
    /// All maps, in the order of menus.
    pub const ALL: [Self; 4] = [Self::Viridis, Self::Inferno, Self::Magma, Self::Cividis];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::Inferno => "inferno",
            Self::Magma => "magma",
            Self::Cividis => "cividis",
        }
    }

    /// Its colours in words, from low to high.
    #[must_use]
    pub const fn about(self) -> &'static str {
        match self {
            Self::Viridis => "violet, green, yellow",
            Self::Inferno => "black, red, yellow, white",
            Self::Magma => "black, violet, pink, white",
            Self::Cividis => "blue, grey, yellow; for all kinds of colour vision",
        }
    }

    /// The colour at `t`, sRGB codes; outside of [0, 1] that of the nearer end, and of 0 for NaN.
    #[must_use]
    pub fn rgb(self, t: f32) -> [u8; 3] {
        let table = self.table();
        let x = if t > 0.0 { t.min(1.0) } else { 0.0 } * (table.len() - 1) as f32;
        let i = (x as usize).min(table.len() - 2);
        let f = x - i as f32;
        let (a, b) = (channels(table[i]), channels(table[i + 1]));
        std::array::from_fn(|k| {
            (f32::from(a[k]) + (f32::from(b[k]) - f32::from(a[k])) * f + 0.5) as u8
        })
    }

    fn table(self) -> &'static [u32; 33] {
        match self {
            Self::Viridis => &VIRIDIS,
            Self::Inferno => &INFERNO,
            Self::Magma => &MAGMA,
            Self::Cividis => &CIVIDIS,
        }
    }
}

impl fmt::Display for ColourMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The text is not the name of a colour map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is not a colour map; use viridis, inferno, magma or cividis")]
pub struct ColourMapError(String);

impl FromStr for ColourMap {
    type Err = ColourMapError;

    fn from_str(text: &str) -> Result<Self, ColourMapError> {
        Self::ALL
            .into_iter()
            .find(|map| map.name() == text)
            .ok_or_else(|| ColourMapError(text.to_owned()))
    }
}

/// The colour of a signed difference, sRGB codes: −1 blue, 0 a dark neutral grey, 1 orange.
///
/// Lightness and chroma grow with the magnitude alone. NaN is shown as 0.
#[must_use]
pub fn diverging(t: f32) -> [u8; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(-1.0, 1.0) };
    let magnitude = t.abs();
    let lightness = 0.25 + 0.5 * magnitude;
    let chroma = 0.13 * magnitude;
    let hue: f32 = if t < 0.0 { 250.0 } else { 60.0 };
    let (sin, cos) = hue.to_radians().sin_cos();
    srgb8_from_oklab([lightness, chroma * cos, chroma * sin])
}

fn srgb8_from_oklab([l, a, b]: [f32; 3]) -> [u8; 3] {
    let cube = |v: f32| v * v * v;
    let long = cube(l + 0.396_337_78 * a + 0.215_803_76 * b);
    let medium = cube(l - 0.105_561_346 * a - 0.063_854_17 * b);
    let short = cube(l - 0.089_484_18 * a - 1.291_485_5 * b);
    // As differences, so that a colour without chroma is exactly grey.
    let linear = [
        long + 3.307_711_6 * (long - medium) + 0.230_969_94 * (short - long),
        long + 2.609_757_4 * (medium - long) - 0.341_319_4 * (short - long),
        long - 0.703_418_6 * (medium - long) + 1.707_614_7 * (short - long),
    ];
    linear.map(|v| (crate::tone::srgb_from_linear(v.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8)
}

fn channels(code: u32) -> [u8; 3] {
    let [_, r, g, b] = code.to_be_bytes();
    [r, g, b]
}

#[rustfmt::skip]
const VIRIDIS: [u32; 33] = [
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453681, 0x424086, 0x3f4989,
    0x3b528b, 0x375a8d, 0x33638d, 0x2f6a8e, 0x2c728e, 0x297a8e, 0x26818e, 0x23898e,
    0x21908c, 0x1f988b, 0x1f9f88, 0x21a685, 0x28ae80, 0x31b57b, 0x3ebc74, 0x4cc26c,
    0x5dc963, 0x6ece58, 0x82d34c, 0x96d83f, 0xabdc32, 0xc0df24, 0xd5e21a, 0xeae51a,
    0xfde725,
];
#[rustfmt::skip]
const INFERNO: [u32; 33] = [
    0x000004, 0x040312, 0x0b0724, 0x150b37, 0x210c4a, 0x2e0a5a, 0x3c0965, 0x4a0c6b,
    0x57106d, 0x63146e, 0x70196e, 0x7d1e6d, 0x89226a, 0x962766, 0xa32b61, 0xaf315c,
    0xbb3755, 0xc63e4d, 0xd14644, 0xdb4f3b, 0xe35932, 0xeb6528, 0xf1711e, 0xf67f14,
    0xf98d0a, 0xfb9c06, 0xfcab0f, 0xfbba1f, 0xf9ca32, 0xf5d949, 0xf2e865, 0xf3f586,
    0xfcffa4,
];
#[rustfmt::skip]
const MAGMA: [u32; 33] = [
    0x000004, 0x030311, 0x0a0822, 0x130d33, 0x1d1146, 0x28115a, 0x36106a, 0x430f76,
    0x50127c, 0x5d177f, 0x691c81, 0x762181, 0x822681, 0x8f2a81, 0x9c2e7f, 0xa9327d,
    0xb63779, 0xc33b75, 0xcf4170, 0xdb486a, 0xe65163, 0xee5c5e, 0xf5695c, 0xf9785d,
    0xfb8761, 0xfd9668, 0xfea571, 0xfeb47b, 0xfec387, 0xfed194, 0xfde0a2, 0xfceeb0,
    0xfcfdbf,
];
#[rustfmt::skip]
const CIVIDIS: [u32; 33] = [
    0x00224e, 0x00285b, 0x002e6a, 0x043371, 0x1a386f, 0x273e6e, 0x32436d, 0x3b496c,
    0x434e6c, 0x4b546c, 0x52596d, 0x5a5f6e, 0x61656f, 0x686a71, 0x6f7073, 0x757676,
    0x7c7b78, 0x848179, 0x8b8778, 0x938d78, 0x9b9376, 0xa39a75, 0xaba072, 0xb3a670,
    0xbbad6c, 0xc3b469, 0xccba64, 0xd4c15f, 0xddc958, 0xe6d051, 0xefd748, 0xf8df3c,
    0xfee838,
];

#[cfg(test)]
mod tests {
    use super::{ColourMap, diverging};
    use crate::tone::linear_from_srgb;

    fn luminance([r, g, b]: [u8; 3]) -> f32 {
        let linear = |c: u8| linear_from_srgb(f32::from(c) / 255.0);
        0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b)
    }

    #[test]
    fn lightness_grows_along_every_map() {
        for map in ColourMap::ALL {
            let mut before = -1.0;
            for i in 0..=32 {
                let now = luminance(map.rgb(i as f32 / 32.0));
                assert!(now > before, "{map} at {i}");
                before = now;
            }
        }
    }

    #[test]
    fn ends_and_middle_are_those_of_the_originals() {
        assert_eq!(ColourMap::Viridis.rgb(0.0), [0x44, 0x01, 0x54]);
        assert_eq!(ColourMap::Viridis.rgb(0.5), [0x21, 0x90, 0x8c]);
        assert_eq!(ColourMap::Inferno.rgb(1.0), [0xfc, 0xff, 0xa4]);
        assert_eq!(ColourMap::Magma.rgb(7.0), [0xfc, 0xfd, 0xbf]);
        assert_eq!(ColourMap::Cividis.rgb(f32::NAN), [0x00, 0x22, 0x4e]);
    }

    #[test]
    fn differences_are_neutral_at_zero_and_coloured_by_their_sign() {
        let [r, g, b] = diverging(0.0);
        assert!(r == g && g == b);
        assert_eq!(diverging(f32::NAN), [r, g, b]);
        let (plus, minus) = (diverging(1.0), diverging(-1.0));
        assert!(plus[0] > plus[2] + 80, "orange: {plus:?}");
        assert!(minus[2] > minus[0] + 80, "blue: {minus:?}");
        for i in 1..=10 {
            let (a, b) = ((i - 1) as f32 / 10.0, i as f32 / 10.0);
            assert!(luminance(diverging(b)) > luminance(diverging(a)));
            assert!(luminance(diverging(-b)) > luminance(diverging(-a)));
        }
    }

    #[test]
    fn names_read_back() {
        for map in ColourMap::ALL {
            assert_eq!(map.to_string().parse(), Ok(map));
        }
        assert!("jet".parse::<ColourMap>().is_err());
    }
}
