//! What a pixel holds beside radiance, as a picture: albedo, normal, depth, error and samples.
//!
//! Albedo, normal and depth are those of the first surface that the camera sees, and have no noise.
//! A normal `n` has the colour `(n + 1) / 2`, as normal maps have it. Depths and errors span a
//! colour map by their logarithms, numbers of samples evenly.

use glam::Vec3;
use neumann_core::film::{Features, Film, SampleMap};
use neumann_core::radiometry::Rgb;

use crate::false_colour::ColourMap;
use crate::figures::significant;
use crate::png_file::Pixels8;
use crate::sheet::Scale;
use crate::tone::{Display, quantise};

/// A quantity that every pixel has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Share of light that the first surface reflects or lets pass.
    Albedo,
    /// Where the first surface faces.
    Normal,
    /// How far away the first surface is.
    Depth,
    /// How uncertain the pixel is.
    Error,
    /// How many paths it has had.
    Samples,
}

impl Quantity {
    /// All of them, in the order of menus.
    pub const ALL: [Self; 5] = [
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::Error,
        Self::Samples,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Error => "error",
            Self::Samples => "samples",
        }
    }

    /// One line on what it is.
    #[must_use]
    pub const fn caption(self) -> &'static str {
        match self {
            Self::Albedo => "albedo: share of light that the first surface reflects or lets pass",
            Self::Normal => "normal: where the first surface faces, in world space",
            Self::Depth => "depth: distance of the first surface, along the view axis",
            Self::Error => "error: standard error of each pixel of L, luminance",
            Self::Samples => "samples: camera paths of each pixel so far",
        }
    }

    /// True if it is of what the camera sees first ([`Features`]).
    #[must_use]
    pub const fn is_feature(self) -> bool {
        matches!(self, Self::Albedo | Self::Normal | Self::Depth)
    }
}

/// The values of a quantity, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityPlane {
    /// Pixels per row, and rows.
    pub size: (usize, usize),
    /// `values[y * width + x]`
    values: Values,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Albedo(Vec<Rgb>),
    /// Zero where there is no surface.
    Normal(Vec<Vec3>),
    /// Metres; infinite where there is no surface.
    Depth(Vec<f32>),
    /// Standard error and mean of the luminance of L.
    Error(Vec<[f32; 2]>),
    Samples(Vec<u32>),
}

/// How a quantity is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityLook {
    /// The colours of numbers.
    pub map: ColourMap,
    /// Stops that the colours of an error span,
    pub stops: f32,
    /// up to the radiance that this exposure brings to white.
    pub exposure_ev: f32,
}

impl QuantityPlane {
    /// A quantity of what the camera sees first; `None` for any other.
    #[must_use]
    pub fn of_features(quantity: Quantity, features: &Features) -> Option<Self> {
        let values = match quantity {
            Quantity::Albedo => Values::Albedo(features.albedo.clone()),
            Quantity::Normal => Values::Normal(features.normal.clone()),
            Quantity::Depth => Values::Depth(features.depth.clone()),
            Quantity::Error | Quantity::Samples => return None,
        };
        let width = features.width.max(1);
        Some(Self {
            size: (width, features.depth.len() / width),
            values,
        })
    }

    /// The standard errors of a film; `None` while they are not known.
    #[must_use]
    pub fn of_errors(film: &Film) -> Option<Self> {
        film.estimated_error()?;
        let luminance = film.total().into_iter().map(Rgb::luminance);
        let pixels = luminance.enumerate();
        let values = pixels.map(|(pixel, mean)| [film.luminance_error(pixel), mean]);
        Some(Self {
            size: (film.width(), film.height()),
            values: Values::Error(values.collect()),
        })
    }

    /// Errors of the luminance that are known otherwise, each with the mean of its pixel.
    #[must_use]
    pub fn of_known_errors(size: (usize, usize), errors: Vec<[f32; 2]>) -> Self {
        Self {
            size,
            values: Values::Error(errors),
        }
    }

    /// The largest error; 0 of anything else.
    #[must_use]
    pub fn largest_error(&self) -> f32 {
        match &self.values {
            Values::Error(all) => all.iter().map(|[error, _]| *error).fold(0.0, f32::max),
            _ => 0.0,
        }
    }

    /// The numbers of samples.
    #[must_use]
    pub fn of_samples(samples: &SampleMap) -> Self {
        let (width, height) = samples.size();
        let pixels = (0..width * height).map(|i| samples.at(i % width, i / width));
        Self {
            size: (width, height),
            values: Values::Samples(pixels.collect()),
        }
    }

    /// What its colours stand for.
    #[must_use]
    pub fn scale(&self, look: &QuantityLook) -> Scale {
        match &self.values {
            Values::Albedo(_) => even(
                "share",
                |t| Display::default().srgb8(Rgb::splat(t)),
                |t| mark(t.into()),
            ),
            Values::Normal(_) => directions(),
            Values::Depth(depths) => {
                let [near, far] = range_of(depths);
                even(
                    "m",
                    |t| look.map.rgb(1.0 - t),
                    |t| mark((near + (far - near) * t).exp2().into()),
                )
            }
            Values::Error(_) => {
                let [low, high] = look.error_range();
                even(
                    "W m⁻² sr⁻¹",
                    |t| look.map.rgb(t),
                    |t| mark((low + (high - low) * t).exp2().into()),
                )
            }
            Values::Samples(counts) => {
                let most = counts.iter().copied().max().unwrap_or(0);
                even(
                    "paths",
                    |t| look.map.rgb(t),
                    |t| mark((t * most as f32).round().into()),
                )
            }
        }
    }

    /// The pixels as they are shown.
    #[must_use]
    pub fn pixels(&self, look: &QuantityLook) -> Pixels8 {
        let (width, height) = self.size;
        let pixels = match &self.values {
            Values::Albedo(all) => {
                let display = Display::default();
                all.iter().map(|albedo| display.srgb8(*albedo)).collect()
            }
            Values::Normal(all) => all.iter().map(|normal| colour_of(*normal)).collect(),
            Values::Depth(all) => {
                let [near, far] = range_of(all);
                let span = (far - near).max(1e-6);
                let colour = |depth: &f32| {
                    let is_there = depth.is_finite();
                    let t = 1.0 - (depth.log2() - near) / span;
                    if is_there { look.map.rgb(t) } else { [0; 3] }
                };
                all.iter().map(colour).collect()
            }
            Values::Error(all) => {
                let [low, high] = look.error_range();
                let place = |error: f32| (error.max(1e-30).log2() - low) / (high - low);
                let colour = |[error, _]: &[f32; 2]| look.map.rgb(place(*error));
                all.iter().map(colour).collect()
            }
            Values::Samples(all) => {
                let most = all.iter().copied().max().unwrap_or(0).max(1);
                let colour = |n: &u32| look.map.rgb(*n as f32 / most as f32);
                all.iter().map(colour).collect()
            }
        };
        Pixels8 {
            width,
            height,
            pixels,
        }
    }

    /// What the pixel at `x`, `y` holds, in words.
    #[must_use]
    pub fn words(&self, x: usize, y: usize) -> Vec<String> {
        const NOTHING: &str = "no surface there";
        let pixel = y * self.size.0 + x;
        match &self.values {
            Values::Albedo(all) => vec![format!("albedo  {}", three(all[pixel].to_array()))],
            Values::Normal(all) if all[pixel] == Vec3::ZERO => vec![NOTHING.to_owned()],
            Values::Normal(all) => vec![format!("normal  {}", three(all[pixel].to_array()))],
            Values::Depth(all) if !all[pixel].is_finite() => vec![NOTHING.to_owned()],
            Values::Depth(all) => vec![format!("depth  {} m", number(all[pixel].into()))],
            Values::Error(all) => {
                let [error, mean] = all[pixel].map(f64::from);
                let mut lines = vec![format!("± {} W m⁻² sr⁻¹", number(error))];
                if mean > 0.0 {
                    lines.push(format!("{} % of L", number(100.0 * error / mean)));
                }
                lines
            }
            Values::Samples(all) => vec![match all[pixel] {
                0 => "no camera path".to_owned(),
                1 => "1 camera path".to_owned(),
                n => format!("{n} camera paths"),
            }],
        }
    }

    /// The whole of it in a line.
    #[must_use]
    pub fn fact(&self) -> String {
        match &self.values {
            Values::Albedo(_) => "red, green and blue as linear shares".to_owned(),
            Values::Normal(_) => "red, green and blue are x, y and z, from −1 to 1".to_owned(),
            Values::Depth(all) => {
                let [near, far] = range_of(all).map(|v| number(v.exp2().into()));
                let is_any = all.iter().any(|depth| depth.is_finite());
                if is_any {
                    format!("{near} m to {far} m; black where there is nothing")
                } else {
                    "there is nothing".to_owned()
                }
            }
            Values::Error(all) => {
                let sum = all.iter().fold([0.0f64; 2], |sum, [error, mean]| {
                    [
                        sum[0] + f64::from(*error).powi(2),
                        sum[1] + f64::from(*mean),
                    ]
                });
                let n = all.len().max(1) as f64;
                let error = (sum[0] / n).sqrt();
                let share = 100.0 * error / (sum[1] / n).max(f64::MIN_POSITIVE);
                let [error, share] = [error, share].map(number);
                format!("root mean square {error} W m⁻² sr⁻¹, {share} % of the mean")
            }
            Values::Samples(all) => {
                let least = all.iter().copied().min().unwrap_or(0);
                match all.iter().copied().max().unwrap_or(0) {
                    0 => "no path begins at the camera".to_owned(),
                    most if least == most => format!("{most} in every pixel"),
                    most => format!("{least} to {most} in a pixel"),
                }
            }
        }
    }
}

impl QuantityLook {
    /// Base-2 logarithms of the errors at the ends of the colours.
    fn error_range(&self) -> [f32; 2] {
        let high = -self.exposure_ev;
        [high - self.stops, high]
    }
}

/// Base-2 logarithms of the least and the greatest depth.
fn range_of(depths: &[f32]) -> [f32; 2] {
    let known = depths.iter().filter(|d| d.is_finite() && **d > 0.0);
    let range = known.fold([f32::INFINITY, 0.0f32], |[a, b], d| [a.min(*d), b.max(*d)]);
    if range[1] > 0.0 {
        range.map(f32::log2)
    } else {
        [0.0; 2]
    }
}

/// Zero, which no normal is, is black.
fn colour_of(normal: Vec3) -> [u8; 3] {
    if normal == Vec3::ZERO {
        return [0; 3];
    }
    (0.5 * normal + 0.5).to_array().map(quantise)
}

/// A scale with a mark at every quarter.
fn even(unit: &str, colour: impl Fn(f32) -> [u8; 3], mark: impl Fn(f32) -> String) -> Scale {
    let steps = (0..=255u8).map(|i| f32::from(i) / 255.0);
    let quarters = (0..=4u8).map(|i| f32::from(i) / 4.0);
    let mut marks: Vec<(f32, String)> = quarters.map(|t| (t, mark(t))).collect();
    marks.dedup_by(|a, b| a.1 == b.1);
    Scale {
        unit: unit.to_owned(),
        colours: steps.map(colour).collect(),
        marks,
    }
}

/// The colours of the six directions of the axes.
fn directions() -> Scale {
    let axes = [
        ("−z", Vec3::NEG_Z),
        ("+z", Vec3::Z),
        ("−y", Vec3::NEG_Y),
        ("+y", Vec3::Y),
        ("−x", Vec3::NEG_X),
        ("+x", Vec3::X),
    ];
    const EACH: usize = 42;
    let place = |i: usize| (i as f32 + 0.5) / axes.len() as f32;
    Scale {
        unit: "faces".to_owned(),
        colours: axes
            .iter()
            .flat_map(|(_, axis)| [colour_of(*axis); EACH])
            .collect(),
        marks: axes
            .iter()
            .enumerate()
            .map(|(i, (name, _))| (place(i), (*name).to_owned()))
            .collect(),
    }
}

fn three(values: [f32; 3]) -> String {
    values.map(|v| number(v.into())).join("  ")
}

/// On a scale there is less room.
fn mark(value: f64) -> String {
    significant(value, 3)
}

fn number(value: f64) -> String {
    significant(value, 4)
}

/// The text is not the name of a quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no quantity of pixels; use albedo, normal, depth, error or samples")]
pub struct QuantityError(String);

impl std::str::FromStr for Quantity {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let named = Self::ALL.into_iter().find(|q| q.name() == text);
        named.ok_or_else(|| QuantityError(text.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use neumann_core::film::{Features, Film};
    use neumann_core::radiometry::Rgb;

    use super::{Quantity, QuantityLook, QuantityPlane};
    use crate::false_colour::ColourMap;

    const LOOK: QuantityLook = QuantityLook {
        map: ColourMap::Viridis,
        stops: 10.0,
        exposure_ev: 0.0,
    };

    fn features() -> Features {
        Features {
            width: 3,
            albedo: vec![Rgb::new(0.25, 0.5, 1.0), Rgb::WHITE, Rgb::BLACK],
            normal: vec![Vec3::X, Vec3::NEG_Y, Vec3::ZERO],
            depth: vec![2.0, 8.0, f32::INFINITY],
        }
    }

    fn plane(quantity: Quantity) -> QuantityPlane {
        QuantityPlane::of_features(quantity, &features()).expect("a feature")
    }

    #[test]
    fn what_is_seen_first_is_coloured_and_told() {
        let albedo = plane(Quantity::Albedo);
        assert_eq!(albedo.words(0, 0), ["albedo  0.25  0.5  1"]);
        assert_eq!(albedo.pixels(&LOOK).pixels[1], [255; 3]);
        let normal = plane(Quantity::Normal);
        let colours = normal.pixels(&LOOK).pixels;
        assert_eq!(colours, [[255, 128, 128], [128, 0, 128], [0; 3]]);
        assert_eq!(normal.words(1, 0), ["normal  0  -1  0"]);
        assert_eq!(normal.words(2, 0), ["no surface there"]);
        let depth = plane(Quantity::Depth);
        let colours = depth.pixels(&LOOK).pixels;
        let [near, far] = [1.0, 0.0].map(|t| ColourMap::Viridis.rgb(t));
        assert_eq!(colours, [near, far, [0; 3]]);
        assert_eq!(depth.words(1, 0), ["depth  8 m"]);
        let marks = depth.scale(&LOOK).marks;
        assert_eq!(marks[0], (0.0, "2".to_owned()));
        assert_eq!(marks[2], (0.5, "4".to_owned()));
        assert_eq!(depth.fact(), "2 m to 8 m; black where there is nothing");
    }

    #[test]
    fn the_legend_of_normals_has_the_colours_of_the_axes() {
        let scale = plane(Quantity::Normal).scale(&LOOK);
        let colour = |name: &str| {
            let mark = scale.marks.iter().find(|mark| mark.1 == name);
            let place = mark.expect("a mark").0;
            scale.colours[(place * scale.colours.len() as f32) as usize]
        };
        assert_eq!(colour("+x"), [255, 128, 128]);
        assert_eq!(colour("−z"), [128, 128, 0]);
    }

    #[test]
    fn errors_are_those_of_the_film() {
        let film = |n| {
            let layers = vec![vec![Rgb::BLACK; 2], vec![Rgb::splat(2.0); 2]];
            let variance = [Rgb::splat(0.25), Rgb::splat(0.0625)];
            Film::from_parts((2, 1), n, layers, vec![Rgb::splat(2.0); 2], &variance, 0)
                .expect("planes of one size")
        };
        assert_eq!(QuantityPlane::of_errors(&film(1)), None);
        let plane = QuantityPlane::of_errors(&film(8)).expect("known");
        assert_eq!(plane.words(0, 0), ["± 0.5 W m⁻² sr⁻¹", "25 % of L"]);
        let colours = plane.pixels(&LOOK).pixels;
        assert_eq!(
            colours[0],
            ColourMap::Viridis.rgb(0.9),
            "a stop below white"
        );
        assert_eq!(colours[1], ColourMap::Viridis.rgb(0.8));
    }

    #[test]
    fn names_read_back() {
        for quantity in Quantity::ALL {
            assert_eq!(quantity.name().parse(), Ok(quantity));
        }
        assert!("colour".parse::<Quantity>().is_err());
    }
}
