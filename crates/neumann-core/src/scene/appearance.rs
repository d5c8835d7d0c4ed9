//! The part of a scene that can be edited while its geometry stays.

use std::sync::Arc;

use super::description::{
    EnvironmentDescription, LightDescription, MaterialDescription, SceneDescription,
};
use crate::radiometry::Rgb;

/// Materials, lights and environment of a scene, and how bright each light is.
#[derive(Clone, Debug)]
pub struct Appearance {
    /// Materials; those with emission are lights. The last one is the default of meshes without
    /// one.
    pub materials: Vec<MaterialDescription>,
    /// Punctual lights.
    pub lights: Vec<LightDescription>,
    /// Light from infinitely far away.
    pub environment: Option<Arc<EnvironmentDescription>>,
    /// Level of each material's emission.
    pub material_levels: Vec<Level>,
    /// Level of each punctual light.
    pub light_levels: Vec<Level>,
    /// Level of the environment.
    pub environment_level: Level,
    /// Multiplies the radiance of the environment, linear.
    pub environment_tint: Rgb,
    /// What the camera makes of the backs of single-sided surfaces.
    pub backs: Backs,
}

/// What the camera makes of a single-sided surface that it sees from behind, on the first segment
/// of a path only: to everything else such a surface is solid from both sides, so that two
/// surfaces see each other or do not. Surfaces that transmit light are solid to the camera, too,
/// since their backs are met from within a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backs {
    /// It is there.
    #[default]
    Solid,
    /// The camera looks through it, as through a cut-out. If it is unlit, light passes it either
    /// way: it is drawn, not built, such as the hull that gives a model its outline.
    SeeThrough,
}

impl Backs {
    /// All of them, the default first.
    pub const ALL: [Self; 2] = [Self::Solid, Self::SeeThrough];

    /// What the command calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::SeeThrough => "see-through",
        }
    }

    /// The one that is called so.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|backs| backs.name() == name)
    }
}

/// Whether a light is on, and how bright.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Off is black.
    pub is_on: bool,
    /// Multiplies what the file says.
    pub brightness: f32,
}

impl Default for Level {
    fn default() -> Self {
        Self {
            is_on: true,
            brightness: 1.0,
        }
    }
}

impl Level {
    /// The factor it amounts to.
    #[must_use]
    pub fn factor(self) -> f32 {
        if self.is_on {
            self.brightness.max(0.0)
        } else {
            0.0
        }
    }
}

impl Appearance {
    /// What a file describes, every light at its own level.
    #[must_use]
    pub fn new(description: &SceneDescription) -> Self {
        let mut materials = description.materials.clone();
        materials.push(MaterialDescription {
            name: "default".to_owned(),
            ..MaterialDescription::default()
        });
        Self {
            material_levels: vec![Level::default(); materials.len()],
            light_levels: vec![Level::default(); description.lights.len()],
            environment_level: Level::default(),
            environment_tint: Rgb::WHITE,
            backs: Backs::default(),
            lights: description.lights.clone(),
            environment: description.environment.clone().map(Arc::new),
            materials,
        }
    }
}
