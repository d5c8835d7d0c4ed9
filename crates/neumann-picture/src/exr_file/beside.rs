//! What a file holds beside the film: what the camera sees first, classes of paths, and the light
//! of each source.

use exr::meta::header::LayerAttributes;
use neumann_core::film::{ClassFilm, Features, View};
use neumann_core::radiometry::Rgb;

use super::metadata::{PREFIX, text, text_of};
use super::planes::Planes;

/// What is written beside a film.
#[derive(Clone, Copy, Debug, Default)]
pub struct Beside<'a> {
    /// What the camera sees first: layers `albedo`, `normal` and `depth`.
    pub features: Option<&'a Features>,
    /// Classes of paths, `expression.NAME`, and the light of each source, `light.NAME` with its
    /// bounces, `light.NAME.T1`.
    pub classes: Option<&'a ClassFilm>,
    /// Factors on the light of each source, which the layer `mix` is made with; none if empty.
    pub mix: &'a [Rgb],
}

impl<'a> From<Option<&'a Features>> for Beside<'a> {
    fn from(features: Option<&'a Features>) -> Self {
        Self {
            features,
            ..Self::default()
        }
    }
}

/// Entries of the header.
const EXPRESSIONS: &str = "expressions";
const LIGHTS: &str = "lights";
const ITERATIONS: &str = "class_iterations";

/// Whether a file with such a header has layers of classes.
pub(super) fn has_classes(attributes: &LayerAttributes) -> bool {
    let name = text_of(&format!("{PREFIX}{ITERATIONS}"));
    attributes.other.contains_key(&name)
}

impl Beside<'_> {
    pub(super) fn put(&self, planes: &mut Planes, attributes: &mut LayerAttributes) {
        if let Some(features) = self.features {
            planes.rgb("albedo", &features.albedo);
            planes.xyz("normal", &features.normal);
            planes.plane("depth", "Z", &features.depth, |z| *z);
        }
        if let Some(classes) = self.classes {
            self.put_classes(classes, planes, attributes);
        }
    }

    fn put_classes(
        &self,
        classes: &ClassFilm,
        planes: &mut Planes,
        attributes: &mut LayerAttributes,
    ) {
        let expressions = &classes.classes().expressions;
        for (number, expression) in expressions.iter().enumerate() {
            let layer = format!("expression.{}", layer_name(expression.name()));
            planes.rgb(&layer, &classes.expression(number));
        }
        for (group, name) in classes.group_names().enumerate() {
            if !classes.is_lit(group) {
                continue;
            }
            let layer = format!("light.{}", layer_name(name));
            let terms = (0..classes.n_layers()).map(View::Term);
            for view in [View::Total].into_iter().chain(terms).chain([View::Tail]) {
                let name = match view {
                    View::Total => layer.clone(),
                    part => format!("{layer}.{part}"),
                };
                if let Some(pixels) = classes.group(group, view) {
                    planes.rgb(&name, &pixels);
                }
            }
        }
        if let Some(mixed) = classes
            .mixed(View::Total, self.mix)
            .filter(|_| !self.mix.is_empty())
        {
            planes.rgb("mix", &mixed);
        }
        let mut put = |name: &str, value: String| {
            let name = text_of(&format!("{PREFIX}{name}"));
            attributes.other.insert(name, text(&value));
        };
        let lines = |names: Vec<String>| names.join("\n");
        put(
            EXPRESSIONS,
            lines(expressions.iter().map(ToString::to_string).collect()),
        );
        put(
            LIGHTS,
            lines(classes.group_names().map(str::to_owned).collect()),
        );
        put(ITERATIONS, classes.n_iterations().to_string());
    }
}

/// A name as a part of a channel's.
fn layer_name(name: &str) -> String {
    let plain = |c: char| if c.is_control() { ' ' } else { c };
    name.chars().map(plain).collect()
}
