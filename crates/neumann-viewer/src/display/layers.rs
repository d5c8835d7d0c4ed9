//! Which layers beside the bounces are looked at, and in what light.

use std::collections::BTreeMap;

use neumann_core::film::ClassFilm;
use neumann_core::radiometry::Rgb;
use neumann_picture::state::LayersState;

/// Layers beside the bounces, as they are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerSettings {
    /// Light path expressions, a layer each.
    pub expressions: Vec<String>,
    /// Groups of lights, as [`parse`](neumann_core::film::LightGroup::parse) reads them.
    pub lights: String,
    /// Factors on the light of groups, by their names; those that are left out keep theirs.
    pub mix: BTreeMap<String, Rgb>,
    /// What is shown of them.
    pub shown: ShownLayer,
}

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShownLayer {
    /// All light, mixed.
    #[default]
    Mix,
    /// An expression, by its place in the list.
    Expression(usize),
    /// A group of lights alone, with its factor.
    Light(usize),
}

impl Default for LayerSettings {
    fn default() -> Self {
        let LayersState {
            expressions,
            lights,
            ..
        } = LayersState::default();
        Self {
            expressions,
            lights,
            mix: BTreeMap::new(),
            shown: ShownLayer::Mix,
        }
    }
}

impl LayerSettings {
    /// The factor on the light of a group.
    #[must_use]
    pub fn factor(&self, group: &str) -> Rgb {
        self.mix.get(group).copied().unwrap_or(Rgb::WHITE)
    }

    /// Those of all groups; none if all keep their light.
    #[must_use]
    pub fn factors(&self, film: &ClassFilm) -> Vec<Rgb> {
        let factors: Vec<Rgb> = film.group_names().map(|name| self.factor(name)).collect();
        if factors.iter().all(|factor| *factor == Rgb::WHITE) {
            return Vec::new();
        }
        factors
    }
}
