//! Materials, as glTF writes them.
//!
//! The core material of glTF has a dielectric coat; pure Lambert takes it off
//! with `KHR_materials_specular`. Emission is radiance, W m^-2 sr^-1: glTF wants
//! a colour within [0, 1] and a strength, so the greatest channel becomes the
//! strength.

use serde_json::{Map, Value, json};

use crate::rounded;

/// Linear RGB, Rec. 709 primaries.
pub(crate) type Rgb = [f64; 3];

/// A named material; the constructors are all the kinds that the scenes use.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    name: String,
    base_color: Rgb,
    metallic: f64,
    roughness: f64,
    emission: Rgb,
    extensions: Map<String, Value>,
}

impl Material {
    /// A perfectly diffuse surface, without any coat.
    pub(crate) fn lambert(name: &str, albedo: Rgb) -> Self {
        let coatless = json!({ "specularFactor": 0.0 });
        Self::new(name, albedo, 0.0, 1.0).with("KHR_materials_specular", coatless)
    }

    /// A black surface that emits `radiance` from its front.
    pub(crate) fn emitter(name: &str, radiance: Rgb) -> Self {
        Self::lambert(name, [0.0; 3]).emitting(radiance)
    }

    /// The default dielectric of glTF: diffuse under a coat of index 1.5.
    pub(crate) fn plastic(name: &str, albedo: Rgb, roughness: f64) -> Self {
        Self::new(name, albedo, 0.0, roughness)
    }

    /// A metal; roughness 0 is a perfect mirror.
    pub(crate) fn metal(name: &str, color: Rgb, roughness: f64) -> Self {
        Self::new(name, color, 1.0, roughness)
    }

    /// A smooth, clear dielectric with an inside.
    pub(crate) fn glass(name: &str, ior: f64) -> Self {
        Self::new(name, [1.0; 3], 0.0, 0.0)
            .with("KHR_materials_ior", json!({ "ior": ior }))
            .with(
                "KHR_materials_transmission",
                json!({ "transmissionFactor": 1.0 }),
            )
            .with("KHR_materials_volume", json!({ "thicknessFactor": 1.0 }))
    }

    /// The same dielectric, of which `distance` metres let `color` through.
    pub(crate) fn attenuating(self, color: Rgb, distance: f64) -> Self {
        let volume = json!({
            "attenuationColor": color.map(rounded),
            "attenuationDistance": rounded(distance),
            "thicknessFactor": 1.0,
        });
        self.with("KHR_materials_volume", volume)
    }

    /// The same surface, emitting `radiance` from its front as well.
    pub(crate) fn emitting(mut self, radiance: Rgb) -> Self {
        let strength = radiance.into_iter().fold(0.0, f64::max);
        self.emission = radiance.map(|channel| channel / strength);
        if strength == 1.0 {
            return self;
        }
        let strength = json!({ "emissiveStrength": rounded(strength) });
        self.with("KHR_materials_emissive_strength", strength)
    }

    /// The names of the extensions in use.
    pub(crate) fn extensions(&self) -> impl Iterator<Item = &String> {
        self.extensions.keys()
    }

    /// The name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// An element of the glTF array `materials`.
    pub(crate) fn to_json(&self) -> Value {
        let [r, g, b] = self.base_color.map(rounded);
        let mut material = json!({
            "name": self.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0],
                "metallicFactor": rounded(self.metallic),
                "roughnessFactor": rounded(self.roughness),
            },
        });
        if self.emission != [0.0; 3] {
            material["emissiveFactor"] = json!(self.emission.map(rounded));
        }
        if !self.extensions.is_empty() {
            material["extensions"] = Value::Object(self.extensions.clone());
        }
        material
    }

    fn new(name: &str, base_color: Rgb, metallic: f64, roughness: f64) -> Self {
        Self {
            name: name.to_owned(),
            base_color,
            metallic,
            roughness,
            emission: [0.0; 3],
            extensions: Map::new(),
        }
    }

    fn with(mut self, extension: &str, value: Value) -> Self {
        self.extensions.insert(extension.to_owned(), value);
        self
    }
}
