//! What is asked of the renderer.

use std::sync::Arc;

use neumann_core::expression::Expression;
use neumann_core::film::{LightGroup, PathClasses};
use neumann_core::scene::Scene;

use crate::display::layers::LayerSettings;

/// Layers that are asked for, read for a scene.
pub(super) struct Asked {
    texts: Vec<String>,
    lights: String,
    scene: Arc<Scene>,
    /// Of each expression, its number among those that are kept, or why it is none.
    pub(super) expressions: Vec<Result<usize, String>>,
    /// Why lights are not grouped as asked for.
    pub(super) complaint: Option<String>,
    pub(super) classes: Arc<PathClasses>,
}

impl Asked {
    pub(super) fn new(settings: &LayerSettings, scene: &Arc<Scene>) -> Self {
        let mut classes = PathClasses::default();
        let expressions = settings.expressions.iter().map(|text| {
            let expression = Expression::new(text, scene).map_err(|error| error.to_string())?;
            classes.expressions.push(expression);
            let number = classes.expressions.len() - 1;
            classes.check().map_err(|error| {
                classes.expressions.pop();
                error.to_string()
            })?;
            Ok(number)
        });
        let expressions = expressions.collect();
        let groups = LightGroup::parse(&settings.lights, scene);
        let complaint = groups.as_ref().err().map(ToString::to_string);
        let each = || LightGroup::parse(LightGroup::EACH, scene).unwrap_or_default();
        classes.groups = groups.unwrap_or_else(|_| each());
        Self {
            texts: settings.expressions.clone(),
            lights: settings.lights.clone(),
            scene: Arc::clone(scene),
            expressions,
            complaint,
            classes: Arc::new(classes),
        }
    }

    /// True if it is what is asked for of this scene.
    pub(super) fn is_of(&self, settings: &LayerSettings, scene: &Arc<Scene>) -> bool {
        self.texts == settings.expressions
            && self.lights == settings.lights
            && Arc::ptr_eq(&self.scene, scene)
    }
}
