//! Lights that are taken as one.

use std::collections::BTreeSet;

use super::PathClasses;
use crate::scene::Scene;
use crate::transport::Source;

/// Sources of light that are taken as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LightGroup {
    /// Its name.
    pub name: String,
    /// What is in it.
    pub sources: Vec<Source>,
}

/// Why light groups cannot be had.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LightGroupError {
    /// No light is called so.
    #[error("no light of the scene is called '{name}'; its lights are {known}")]
    Unknown {
        /// The name.
        name: String,
        /// Names that there are.
        known: String,
    },
    /// A part of the text is not what it should be.
    #[error("'{0}' is no light group; write NAME=LIGHT,LIGHT;NAME=LIGHT or 'each'")]
    Malformed(String),
    /// A light is in two groups.
    #[error("the light '{0}' is in two groups")]
    Twice(String),
}

impl LightGroup {
    /// What asks for a group for each light.
    pub const EACH: &str = "each";
    /// The name of the light that is in no group.
    pub const OTHERS: &str = "others";

    /// The lights of a scene by their names, a group each: surfaces by their materials, lights of
    /// no extent by their own, then `environment`. Those of one name are one. Those without a name
    /// are called `material 3` or `light 2`, counted from 1.
    #[must_use]
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut groups: Vec<Self> = Vec::new();
        let mut add = |name: String, source| match groups.iter_mut().find(|g| g.name == name) {
            Some(group) => group.sources.push(source),
            None => groups.push(Self {
                name,
                sources: vec![source],
            }),
        };
        let named = |name: &str, kind: &str, number: u32| match name {
            "" => format!("{kind} {}", number + 1),
            name => name.to_owned(),
        };
        let meshes = scene.geometry().meshes();
        let used: BTreeSet<u32> = meshes.iter().map(|mesh| mesh.material).collect();
        for number in used {
            let material = &scene.materials()[number as usize];
            if !material.emission().0.is_black() {
                let name = &material.parameters().name;
                add(named(name, "material", number), Source::Material(number));
            }
        }
        for (light, number) in scene.appearance().lights.iter().zip(0..) {
            add(
                named(&light.name, "light", number),
                Source::Punctual(number),
            );
        }
        if scene.appearance().environment.is_some() {
            add("environment".to_owned(), Source::Environment);
        }
        groups
    }

    /// Reads `each`, or groups of lights by name: `key=lamp,candle;sky=environment`.
    ///
    /// Of more than [`PathClasses::MAX_GROUPS`] lights, `each` yields the first and leaves the
    /// rest to [`Self::OTHERS`].
    ///
    /// # Errors
    /// [`LightGroupError`].
    pub fn parse(text: &str, scene: &Scene) -> Result<Vec<Self>, LightGroupError> {
        let mut all = Self::all(scene);
        if text.trim() == Self::EACH {
            all.truncate(PathClasses::MAX_GROUPS);
            return Ok(all);
        }
        let mut groups: Vec<Self> = Vec::new();
        for part in text.split(';') {
            let malformed = || LightGroupError::Malformed(part.trim().to_owned());
            let (name, lights) = part.split_once('=').ok_or_else(malformed)?;
            let name = name.trim();
            let is_known = groups.iter().any(|group| group.name == name);
            if name.is_empty() || name == Self::OTHERS || is_known {
                return Err(malformed());
            }
            let mut sources = Vec::new();
            for light in lights.split(',').map(str::trim) {
                let found = all.iter().find(|group| group.name == light);
                let found = found.ok_or_else(|| LightGroupError::Unknown {
                    name: light.to_owned(),
                    known: names(&all),
                })?;
                sources.extend(&found.sources);
                let is_taken = |group: &Self| group.sources.contains(&found.sources[0]);
                if groups.iter().any(is_taken) {
                    return Err(LightGroupError::Twice(light.to_owned()));
                }
            }
            groups.push(Self {
                name: name.to_owned(),
                sources,
            });
        }
        Ok(groups)
    }
}

fn names(groups: &[LightGroup]) -> String {
    let names: Vec<String> = groups.iter().map(|g| format!("'{}'", g.name)).collect();
    match names.len() {
        0 => "none".to_owned(),
        _ => names.join(", "),
    }
}
