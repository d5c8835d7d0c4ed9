//! Environment maps: Radiance HDR and OpenEXR, and the scene's own wish for one.
//!
//! A glTF scene asks for light from infinitely far away in
//! `scenes[i].extras.neumann.environment`, either
//! `{"uri": "sky.hdr", "intensity": 1.0, "rotationDegrees": 0.0}` or
//! `{"color": [r, g, b], "intensity": 1.0}`.

use super::error::{Fault, quoted};
use super::factor::{Factors, LARGEST};
use super::json::Item;
use super::notes::Notes;
use super::source::Source;
use crate::decode::{DecodeError, Radiances, StoredRadiances, radiance_hdr};
use crate::memory::Share;
use crate::radiometry::Rgb;
use crate::scene::description::EnvironmentDescription;

/// Wider or higher maps are refused.
const LARGEST_SIDE: usize = 1 << 16;

/// What the density over a map takes beside each of its texels, once there is a light of it:
/// two tables of single precision.
const TABLE_BYTES: u64 = 8;

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
            for warning in &decoded.warnings {
                notes.warn(format!("environment {}: {warning}", quoted(uri)));
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

/// An environment map, and what is odd about its file.
#[derive(Debug)]
pub(super) struct Decoded {
    pub(super) environment: EnvironmentDescription,
    pub(super) warnings: Vec<String>,
}

/// Decodes a map whose format its first bytes tell.
pub(super) fn decode(name: &str, bytes: &[u8]) -> Result<Decoded, Fault> {
    let mut memory = Share::default();
    let decoded = if radiance_hdr::is_hdr(bytes) {
        decode_hdr(bytes, &mut memory)
    } else {
        decode_exr(bytes, &mut memory)
    };
    let (width, height, mut texels) = decoded
        .map_err(|error| Fault::undecoded("", "", error, "use a lat-long map as .hdr or .exr"))?;
    let mut warnings = Vec::new();
    let n_mended = texels.mend();
    if n_mended > 0 {
        warnings.push(format!(
            "{n_mended} texels were negative or not finite; 0 or the brightest value stands in"
        ));
    }
    if width != 2 * height && width * height > 1 {
        warnings.push(format!(
            "is {width} by {height}, but a lat-long map is twice as wide as high; it is stretched"
        ));
    }
    Ok(Decoded {
        environment: EnvironmentDescription {
            name: name.to_owned(),
            width,
            height,
            texels: Radiances::new(texels, memory),
            intensity: 1.0,
            rotation: 0.0,
            sun: None,
        },
        warnings,
    })
}

type Texels = (usize, usize, StoredRadiances);

fn decode_hdr(bytes: &[u8], memory: &mut Share) -> Result<Texels, DecodeError> {
    let header = radiance_hdr::header(bytes)?;
    check_size(header.width, header.height, memory)?;
    let texels = radiance_hdr::decode(bytes, memory)?;
    Ok((header.width, header.height, texels))
}

#[cfg(feature = "pictures")]
fn decode_exr(bytes: &[u8], memory: &mut Share) -> Result<Texels, DecodeError> {
    use crate::decode::openexr;

    if !bytes.starts_with(&openexr::MAGIC) {
        let problem = "is neither a Radiance HDR nor an OpenEXR image";
        return Err(DecodeError::Content(problem.to_owned()));
    }
    let file = openexr::File::open(std::io::Cursor::new(bytes), bytes.len() as u64)?;
    let (width, height) = (file.width, file.height);
    if file.is_cube {
        let problem = "holds the six sides of a cube, which cannot be read as an environment";
        return Err(DecodeError::Content(problem.to_owned()));
    }
    check_size(width, height, memory)?;
    let layer = file.layer(None)?;
    let mut pictures = file.read(&[layer], memory)?;
    let texels = pictures.pop().unwrap_or(StoredRadiances::Float(Vec::new()));
    Ok((width, height, texels))
}

#[cfg(not(feature = "pictures"))]
fn decode_exr(_: &[u8], _: &mut Share) -> Result<Texels, DecodeError> {
    Err(DecodeError::NoDecoder)
}

/// Checks the sides, and pays for the density.
fn check_size(width: usize, height: usize, memory: &mut Share) -> Result<(), DecodeError> {
    if width == 0 || height == 0 {
        Err(DecodeError::Content("has no texels".to_owned()))
    } else if width.max(height) > LARGEST_SIDE {
        Err(DecodeError::Content(format!(
            "is {width} by {height}; at most {LARGEST_SIDE} each way are read"
        )))
    } else {
        memory.grow(TABLE_BYTES * width as u64 * height as u64)?;
        Ok(())
    }
}
