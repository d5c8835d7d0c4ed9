//! Texture references of materials: which image, which coordinates, which sampler.
//!
//! `KHR_texture_transform` is read here, from the texture info itself, so it
//! works on every texture alike. Its matrix is translation · rotation · scale,
//! the rotation counter-clockwise as seen with v pointing down:
//! `(u, v) -> (u cos + v sin, -u sin + v cos)`.

use glam::Mat3;

use super::error::{Fault, quoted};
use super::json::{Document, Item};
use super::mesh::MOST_UV_SETS;
use super::notes::Notes;
use crate::scene::description::{Filter, TextureDescription, Wrap};

const BASISU: &str = "KHR_texture_basisu";

/// Reads the texture info at `item[key]`; `owner` is named in warnings.
///
/// The result's `image` is still the file's index into `images`.
pub(super) fn read(
    document: &Document,
    item: &Item<'_>,
    key: &str,
    owner: &str,
    notes: &mut Notes,
) -> Result<Option<TextureDescription>, Fault> {
    let Some(info) = item.child(key)? else {
        return Ok(None);
    };
    let Some(index) = document.reference(&info, "index", "textures")? else {
        return Err(Fault::broken(info.path("index"), "is missing"));
    };
    let texture = document.item("textures", index)?;
    let Some(image) = image_index(document, &texture, owner, notes)? else {
        return Ok(None);
    };
    let mut uv_set = info.index("texCoord")?.unwrap_or(0);
    let mut image_from_mesh_uv = Mat3::IDENTITY;
    if let Some(transform) = info.extension("KHR_texture_transform")? {
        uv_set = transform.index("texCoord")?.unwrap_or(uv_set);
        image_from_mesh_uv = read_transform(&transform)?;
        if !image_from_mesh_uv.is_finite() {
            notes.warn(format!(
                "{owner}: {} is not finite and ignored",
                transform.at()
            ));
            image_from_mesh_uv = Mat3::IDENTITY;
        }
    }
    if uv_set >= MOST_UV_SETS {
        notes.warn(format!(
            "{owner}: {} reads TEXCOORD_{uv_set}, beyond the {MOST_UV_SETS} sets that are read; \
             the texture is left out",
            info.at()
        ));
        return Ok(None);
    }
    let sampler = match document.reference(&texture, "sampler", "samplers")? {
        Some(sampler) => Some(document.item("samplers", sampler)?),
        None => None,
    };
    let constant = |key| match &sampler {
        Some(sampler) => sampler.index(key),
        None => Ok(None),
    };
    Ok(Some(TextureDescription {
        image,
        uv_set,
        image_from_mesh_uv,
        wrap_u: wrap(constant("wrapS")?),
        wrap_v: wrap(constant("wrapT")?),
        filter: match constant("magFilter")? {
            Some(9728) => Filter::Nearest,
            _ => Filter::Linear,
        },
    }))
}

/// The image of a texture: WebP if offered, else the plain one.
fn image_index(
    document: &Document,
    texture: &Item<'_>,
    owner: &str,
    notes: &mut Notes,
) -> Result<Option<usize>, Fault> {
    if let Some(webp) = texture.extension("EXT_texture_webp")?
        && let Some(image) = document.reference(&webp, "source", "images")?
    {
        return Ok(Some(image));
    }
    if let Some(image) = document.reference(texture, "source", "images")? {
        return Ok(Some(image));
    }
    let why = match texture.extension(BASISU)? {
        Some(_) => format!("has only a {BASISU} image, which cannot be read"),
        None => "has no image that can be read".to_owned(),
    };
    let name = texture.name().map_or(String::new(), quoted);
    notes.warn(format!(
        "{owner}: {} {name} {why}; the texture is left out",
        texture.at()
    ));
    Ok(None)
}

fn read_transform(item: &Item<'_>) -> Result<Mat3, Fault> {
    let [offset_u, offset_v] = item.numbers("offset")?.unwrap_or([0.0; 2]);
    let [scale_u, scale_v] = item.numbers("scale")?.unwrap_or([1.0; 2]);
    let (sin, cos) = item.number("rotation")?.unwrap_or(0.0).sin_cos();
    Ok(Mat3::from_cols_array(&[
        scale_u * cos,
        scale_u * -sin,
        0.0,
        scale_v * sin,
        scale_v * cos,
        0.0,
        offset_u,
        offset_v,
        1.0,
    ]))
}

fn wrap(constant: Option<usize>) -> Wrap {
    match constant {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::super::json::Document;
    use super::super::notes::Notes;
    use super::read;
    use crate::scene::description::{Filter, Wrap};

    #[test]
    fn transform_sampler_and_override_are_read() {
        let text = r#"{
            "images":[{},{}],
            "samplers":[{"wrapS":33071,"wrapT":33648,"magFilter":9728}],
            "textures":[{"source":0,"sampler":0,"extensions":{"EXT_texture_webp":{"source":1}}},
                        {"extensions":{"KHR_texture_basisu":{"source":0}}}],
            "a":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":
                {"offset":[0.5,0.25],"rotation":1.5707963,"scale":[2,3],"texCoord":2}}},
            "b":{"index":1},"c":{"index":0,"texCoord":4000000000},"d":{"index":7}}"#;
        let document = Document::parse(text.as_bytes()).unwrap();
        let mut notes = Notes::default();
        let mut texture = |key| read(&document, &document.root(), key, "x", &mut notes);
        let a = texture("a").unwrap().unwrap();
        assert_eq!((a.image, a.uv_set), (1, 2));
        assert_eq!(
            (a.wrap_u, a.wrap_v),
            (Wrap::ClampToEdge, Wrap::MirroredRepeat)
        );
        assert_eq!(a.filter, Filter::Nearest);
        // Counter-clockwise where v points down: +u goes to -v, +v to +u.
        let uv = a.image_from_mesh_uv.transform_point2(Vec2::new(1.0, 0.0));
        assert!(uv.distance(Vec2::new(0.5, 0.25 - 2.0)) < 1e-6, "{uv}");
        let uv = a.image_from_mesh_uv.transform_point2(Vec2::new(0.0, 1.0));
        assert!(uv.distance(Vec2::new(0.5 + 3.0, 0.25)) < 1e-6, "{uv}");
        assert!(texture("b").unwrap().is_none());
        assert!(texture("c").unwrap().is_none());
        assert!(texture("d").is_err());
        assert_eq!(notes.into_warnings().len(), 2);
    }
}
