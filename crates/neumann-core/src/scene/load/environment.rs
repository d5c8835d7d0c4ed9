//! Environment maps: Radiance HDR and OpenEXR, and the scene's own wish for one.
//!
//! A glTF scene asks for light from infinitely far away in
//! `scenes[i].extras.neumann.environment`, either
//! `{"uri": "sky.hdr", "intensity": 1.0, "rotationDegrees": 0.0}` or
//! `{"color": [r, g, b], "intensity": 1.0}`.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read as read_exr_image};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, Limits};

use super::error::{Fault, quoted};
use super::factor::{Factors, LARGEST};
use super::json::Item;
use super::notes::Notes;
use super::picture::{LARGEST_SIDE, quietly};
use super::source::Source;
use crate::radiometry::Rgb;
use crate::scene::description::EnvironmentDescription;

/// More texels than this are refused: 16384 by 8192, the usual largest map.
const MOST_TEXELS: u64 = 1 << 27;

/// Reads what the scene's extras ask for, if they do.
pub(super) fn of_scene(
    scene: &Item<'_>,
    source: &mut Source<'_>,
    notes: &mut Notes,
) -> Result<Option<EnvironmentDescription>, Fault> {
    let neumann = scene
        .child_if_object("extras")
        .and_then(|extras| extras.child_if_object("neumann"));
    let Some(item) = neumann.and_then(|neumann| neumann.child_if_object("environment")) else {
        return Ok(None);
    };
    let mut environment = match item.text("uri")? {
        Some(uri) => {
            let field = item.path("uri");
            let bytes = source.fetch(uri, &field)?;
            let name = if uri.starts_with("data:") {
                "environment"
            } else {
                uri
            };
            let decoded = decode(name, &bytes).map_err(|fault| Fault { field, ..fault })?;
            if decoded.n_mended > 0 {
                notes.warn(format!(
                    "environment {}: {} texels were negative or not finite",
                    quoted(uri),
                    decoded.n_mended
                ));
            }
            decoded.environment
        }
        None => {
            let mut factors = Factors::of("environment", "color", notes);
            let color = factors.color(&item, "color", Rgb::WHITE, &(0.0..=LARGEST))?;
            EnvironmentDescription::uniform(color)
        }
    };
    let mut factors = Factors::of("environment", &environment.name, notes);
    environment.intensity = factors.number(&item, "intensity", 1.0, 0.0..=LARGEST)?;
    environment.rotation = factors
        .number(&item, "rotationDegrees", 0.0, -LARGEST..=LARGEST)?
        .to_radians();
    Ok(Some(environment))
}

/// An environment map, and how many of its texels were no radiance.
#[derive(Debug)]
pub(super) struct Decoded {
    pub(super) environment: EnvironmentDescription,
    pub(super) n_mended: usize,
}

/// Decodes a map whose format its first bytes tell.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<Decoded, Fault> {
    let decoded = if bytes.starts_with(b"#?") {
        quietly(|| decode_hdr(bytes))
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        quietly(|| decode_exr(bytes))
    } else {
        Err("is neither a Radiance HDR nor an OpenEXR image".to_owned())
    };
    let mut texels = decoded.map_err(|problem| {
        Fault::new(
            "",
            problem,
            "use a lat-long map as .hdr or .exr, or fetch it again",
        )
    })?;
    let n_mended = mend(&mut texels.texels);
    Ok(Decoded {
        environment: EnvironmentDescription {
            name: name.to_owned(),
            width: texels.width,
            height: texels.height,
            texels: texels.texels,
            intensity: 1.0,
            rotation: 0.0,
        },
        n_mended,
    })
}

/// `texels[y * width + x]`.
struct Texels {
    width: usize,
    height: usize,
    texels: Vec<Rgb>,
}

fn decode_hdr(bytes: &[u8]) -> Result<Texels, String> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(u64::from(width), u64::from(height))?;
    let mut decoder = decoder;
    decoder.set_limits(Limits::no_limits()).map_err(broken)?;
    let pixels = DynamicImage::from_decoder(decoder)
        .map_err(broken)?
        .into_rgb32f()
        .into_raw();
    let (texels, _) = pixels.as_chunks::<3>();
    Ok(Texels {
        width: width as usize,
        height: height as usize,
        texels: texels.iter().map(|&rgb| Rgb::from(rgb)).collect(),
    })
}

/// The first layer that has R, G and B, else the first with Y alone.
fn decode_exr(bytes: &[u8]) -> Result<Texels, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    for header in &meta.headers {
        check_size(
            header.layer_size.width() as u64,
            header.layer_size.height() as u64,
        )?;
    }
    let color = read_exr_image()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| Texels::black(size.width(), size.height()),
            |image: &mut Texels, at, (r, g, b): (f32, f32, f32)| {
                image.set(at.x(), at.y(), Rgb::new(r, g, b));
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes));
    let color_error = match color {
        Ok(image) => return Ok(image.layer_data.channel_data.pixels),
        Err(error) => error,
    };
    read_exr_image()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required("Y")
        .collect_pixels(
            |size, _| Texels::black(size.width(), size.height()),
            |image: &mut Texels, at, (y,): (f32,)| image.set(at.x(), at.y(), Rgb::splat(y)),
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map(|image| image.layer_data.channel_data.pixels)
        .map_err(|_| broken(color_error))
}

impl Texels {
    fn black(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            texels: vec![Rgb::BLACK; width * height],
        }
    }

    fn set(&mut self, x: usize, y: usize, color: Rgb) {
        self.texels[y * self.width + x] = color;
    }
}

fn check_size(width: u64, height: u64) -> Result<(), String> {
    let side = u64::from(LARGEST_SIDE);
    if width == 0 || height == 0 {
        Err("has no texels".to_owned())
    } else if width > side || height > side || width * height > MOST_TEXELS {
        Err(format!(
            "is {width} by {height}; at most {side} by {} is read",
            MOST_TEXELS / side
        ))
    } else {
        Ok(())
    }
}

/// Makes every texel finite and not negative; tells how many were not.
///
/// A sun beyond the range of half floats is stored as infinity: it becomes the
/// brightest finite value of the map.
fn mend(texels: &mut [Rgb]) -> usize {
    let is_odd = |texel: &Rgb| !texel.is_radiance();
    let n_odd = texels.iter().filter(|texel| is_odd(texel)).count();
    if n_odd > 0 {
        let brightest = texels
            .iter()
            .flat_map(|texel| texel.to_array())
            .filter(|value| value.is_finite())
            .fold(0.0, f32::max);
        for texel in texels.iter_mut().filter(|texel| is_odd(texel)) {
            // `max` also takes 0 for what is not a number.
            *texel = texel.map(|value| value.max(0.0).min(brightest));
        }
    }
    n_odd
}

fn broken(error: impl std::fmt::Display) -> String {
    format!("cannot be decoded ({error})")
}
