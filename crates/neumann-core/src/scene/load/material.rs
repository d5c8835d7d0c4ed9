//! Materials, with the extensions that this program honours.

use super::error::{Fault, quoted};
use super::factor::{Factors, LARGEST};
use super::json::{Document, Item};
use super::notes::Notes;
use super::texture;
use crate::radiometry::Rgb;
use crate::scene::description::{
    AlphaMode, MaterialDescription, TextureDescription, VolumeDescription,
};

/// `KHR_materials_ior` says 0 for an infinite index; this one is near enough
/// (it reflects 0.9996 at normal incidence) and can be divided by.
const INFINITE_IOR: f32 = 1e4;

/// Reads all materials; their textures still carry the file's image indices.
pub(super) fn read(
    document: &Document,
    notes: &mut Notes,
) -> Result<Vec<MaterialDescription>, Fault> {
    (0..document.count("materials"))
        .map(|index| {
            let item = document.item("materials", index)?;
            let name = item
                .name()
                .map_or_else(|| format!("material {index}"), str::to_owned);
            let reader = Reader {
                document,
                factors: Factors::of("material", &name, notes),
            };
            reader.read(&item, name)
        })
        .collect()
}

/// Every texture of a material.
pub(super) fn textures(material: &mut MaterialDescription) -> [&mut Option<TextureDescription>; 7] {
    [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.normal_texture,
        &mut material.emission_texture,
        &mut material.specular_texture,
        &mut material.specular_color_texture,
        &mut material.transmission_texture,
    ]
}

/// Reads one material.
struct Reader<'a> {
    document: &'a Document,
    factors: Factors<'a>,
}

impl Reader<'_> {
    fn read(mut self, item: &Item<'_>, name: String) -> Result<MaterialDescription, Fault> {
        let mut material = MaterialDescription {
            name,
            is_double_sided: item.flag("doubleSided")?.unwrap_or(false),
            is_unlit: item.extension("KHR_materials_unlit")?.is_some(),
            alpha_mode: self.alpha_mode(item)?,
            ..MaterialDescription::default()
        };
        if let Some(pbr) = item.child("pbrMetallicRoughness")? {
            self.metallic_roughness(&pbr, &mut material)?;
        }
        if let Some(normal) = item.child("normalTexture")? {
            material.normal_texture = self.texture(item, "normalTexture")?;
            material.normal_scale =
                self.factors
                    .number(&normal, "scale", 1.0, -LARGEST..=LARGEST)?;
        }
        self.emission(item, &mut material)?;
        self.dielectric(item, &mut material)?;
        Ok(material)
    }

    fn texture(&mut self, item: &Item<'_>, key: &str) -> Result<Option<TextureDescription>, Fault> {
        let Factors { owner, notes } = &mut self.factors;
        texture::read(self.document, item, key, owner, notes)
    }

    fn alpha_mode(&mut self, item: &Item<'_>) -> Result<AlphaMode, Fault> {
        match item.text("alphaMode")? {
            None | Some("OPAQUE") => Ok(AlphaMode::Opaque),
            Some("BLEND") => Ok(AlphaMode::Blend),
            Some("MASK") => Ok(AlphaMode::Mask {
                cutoff: self
                    .factors
                    .number(item, "alphaCutoff", 0.5, 0.0..=LARGEST)?,
            }),
            Some(other) => Err(Fault::broken(
                item.path("alphaMode"),
                format!("is {}; modes are OPAQUE, MASK and BLEND", quoted(other)),
            )),
        }
    }

    fn metallic_roughness(
        &mut self,
        pbr: &Item<'_>,
        material: &mut MaterialDescription,
    ) -> Result<(), Fault> {
        let factors = &mut self.factors;
        let [r, g, b, a] = factors.numbers(pbr, "baseColorFactor", [1.0; 4], &(0.0..=1.0))?;
        material.base_color = Rgb::new(r, g, b);
        material.alpha = a;
        material.metallic = factors.number(pbr, "metallicFactor", 1.0, 0.0..=1.0)?;
        material.roughness = factors.number(pbr, "roughnessFactor", 1.0, 0.0..=1.0)?;
        material.base_color_texture = self.texture(pbr, "baseColorTexture")?;
        material.metallic_roughness_texture = self.texture(pbr, "metallicRoughnessTexture")?;
        Ok(())
    }

    /// `emissiveFactor` is to be at most 1, yet larger ones are common and
    /// mean what they say.
    fn emission(
        &mut self,
        item: &Item<'_>,
        material: &mut MaterialDescription,
    ) -> Result<(), Fault> {
        let positive = 0.0..=LARGEST;
        let factor = self
            .factors
            .color(item, "emissiveFactor", Rgb::BLACK, &positive)?;
        let strength = match item.extension("KHR_materials_emissive_strength")? {
            Some(extension) => {
                self.factors
                    .number(&extension, "emissiveStrength", 1.0, positive)?
            }
            None => 1.0,
        };
        material.emission = factor * strength;
        material.emission_texture = self.texture(item, "emissiveTexture")?;
        Ok(())
    }

    fn dielectric(
        &mut self,
        item: &Item<'_>,
        material: &mut MaterialDescription,
    ) -> Result<(), Fault> {
        if let Some(ior) = item.extension("KHR_materials_ior")? {
            material.ior = match ior.number("ior")? {
                Some(0.0) => INFINITE_IOR,
                _ => self.factors.number(&ior, "ior", 1.5, 1.0..=INFINITE_IOR)?,
            };
        }
        if let Some(specular) = item.extension("KHR_materials_specular")? {
            material.specular = self
                .factors
                .number(&specular, "specularFactor", 1.0, 0.0..=1.0)?;
            material.specular_color = self.factors.color(
                &specular,
                "specularColorFactor",
                Rgb::WHITE,
                &(0.0..=LARGEST),
            )?;
            material.specular_texture = self.texture(&specular, "specularTexture")?;
            material.specular_color_texture = self.texture(&specular, "specularColorTexture")?;
        }
        if let Some(transmission) = item.extension("KHR_materials_transmission")? {
            material.transmission =
                self.factors
                    .number(&transmission, "transmissionFactor", 0.0, 0.0..=1.0)?;
            material.transmission_texture = self.texture(&transmission, "transmissionTexture")?;
        }
        if let Some(volume) = item.extension("KHR_materials_volume")? {
            material.volume = self.volume(&volume)?;
        }
        Ok(())
    }

    /// `thicknessTexture` is left out: the geometry itself says how thick it is.
    fn volume(&mut self, volume: &Item<'_>) -> Result<Option<VolumeDescription>, Fault> {
        let thickness = self
            .factors
            .number(volume, "thicknessFactor", 0.0, 0.0..=f32::MAX)?;
        let attenuation_color =
            self.factors
                .color(volume, "attenuationColor", Rgb::WHITE, &(0.0..=1.0))?;
        let mut attenuation_distance = volume
            .number("attenuationDistance")?
            .unwrap_or(f32::INFINITY);
        if attenuation_distance <= 0.0 || attenuation_distance.is_nan() {
            self.factors.notes.warn(format!(
                "{}: {} is {attenuation_distance}, not above 0; the volume is clear",
                self.factors.owner,
                volume.path("attenuationDistance")
            ));
            attenuation_distance = f32::INFINITY;
        }
        Ok((thickness > 0.0).then_some(VolumeDescription {
            attenuation_color,
            attenuation_distance,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::super::json::Document;
    use super::super::notes::Notes;
    use super::read;
    use crate::radiometry::Rgb;
    use crate::scene::description::{AlphaMode, MaterialDescription};

    fn one(text: &str) -> (MaterialDescription, Vec<String>) {
        let text = format!("{{\"materials\":[{text}]}}");
        let document = Document::parse(text.as_bytes()).unwrap();
        let mut notes = Notes::default();
        let material = read(&document, &mut notes).unwrap().remove(0);
        (material, notes.into_warnings())
    }

    #[test]
    fn an_empty_material_is_the_default() {
        let (material, warnings) = one("{}");
        let expected = MaterialDescription {
            name: "material 0".to_owned(),
            ..MaterialDescription::default()
        };
        assert_eq!(material, expected);
        assert!(warnings.is_empty());
    }

    #[test]
    fn odd_factors_are_clamped_with_a_warning() {
        let (material, warnings) = one(r#"{"name":"odd","emissiveFactor":[-1,17,0],
                "pbrMetallicRoughness":{"roughnessFactor":3,"metallicFactor":-1e39},
                "extensions":{"KHR_materials_ior":{"ior":0.5},
                    "KHR_materials_volume":{"thicknessFactor":1,"attenuationDistance":0}}}"#);
        assert_eq!(material.roughness, 1.0);
        assert_eq!(material.metallic, 0.0);
        assert_eq!(material.emission, Rgb::new(0.0, 17.0, 0.0));
        assert_eq!(material.ior, 1.0);
        assert!(material.volume.unwrap().attenuation_distance.is_infinite());
        assert_eq!(warnings.len(), 5);
        assert!(warnings.iter().all(|w| w.starts_with("material \"odd\"")));
        assert!(warnings.iter().any(|w| w.contains("roughnessFactor is 3")));
    }

    #[test]
    fn extensions_are_read() {
        let (material, warnings) = one(
            r#"{"alphaMode":"MASK","doubleSided":true,"emissiveFactor":[1,0.5,0],
                "extensions":{"KHR_materials_unlit":{},
                    "KHR_materials_emissive_strength":{"emissiveStrength":10},
                    "KHR_materials_ior":{"ior":0},
                    "KHR_materials_transmission":{"transmissionFactor":0.5},
                    "KHR_materials_specular":{"specularFactor":0,"specularColorFactor":[2,1,1]},
                    "KHR_materials_volume":{"attenuationColor":[1,0,0]}}}"#,
        );
        assert!(warnings.is_empty());
        assert!(material.is_unlit && material.is_double_sided);
        assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
        assert_eq!(material.emission, Rgb::new(10.0, 5.0, 0.0));
        assert_eq!(material.ior, 1e4);
        assert_eq!(material.transmission, 0.5);
        assert_eq!(material.specular, 0.0);
        assert_eq!(material.specular_color.r, 2.0);
        assert_eq!(material.volume, None);
    }
}
