//! Kinds of paths: light path expressions.
//!
//! Heckbert's notation (P. Heckbert, Adaptive Radiosity Textures for Bidirectional Ray Tracing,
//! SIGGRAPH 1990) is a regular expression over what happens to light between its source `L` and the
//! eye `E`. Here it reads
//!
//! | written | it stands for |
//! |---|---|
//! | `D`, `G`, `S` | scattered by a diffuse, glossy or specular lobe |
//! | `Dr`, `Dt` and so on | the same, reflected or transmitted only |
//! | `R`, `T`, `.` | reflected, transmitted, or scattered at all, by any lobe |
//! | `'red wall'`, `S'glass'` | scattered by a material of this name, by its specular lobe |
//! | `L'lamp'`, `L'environment'` | light from a material of this name, or from the environment |
//! | `X*`, `X+`, `X?`, `X{2}`, `X{2,5}`, `X{2,}` | so often |
//! | `[DG]`, `[^S]` | one of these, none of these |
//! | <code>X&#124;Y</code>, `(X Y)` | one or the other, taken as one |
//!
//! Spaces mean nothing, but that the name of a light, or of a lobe's material, follows without one.
//! An expression begins with `L` and ends with `E`, or the other way round. It is read from where
//! it begins; several may stand side by side with `|` between them.

mod automaton;
mod parse;

use std::fmt;

use crate::scene::Scene;
use crate::transport::{Bounce, Lobe};

use self::automaton::Automaton;

/// A kind of path.
#[derive(Clone, Debug)]
pub struct Expression {
    text: String,
    alternatives: Vec<Alternative>,
}

/// Expressions that are worth a name, with what they show.
pub const PRESETS: [(&str, &str); 6] = [
    ("emission", "L E"),
    ("direct", "L . E"),
    ("indirect diffuse", "L .+ D E"),
    ("caustics", "L .* [GS] D E"),
    ("specular-diffuse-specular", "L .* S D S .* E"),
    ("glossy", "L .* G .* E"),
];

/// One of the expressions that stand side by side.
#[derive(Clone, Debug)]
struct Alternative {
    light: Light,
    /// True if the automaton takes the bounce next to the light first.
    is_from_light: bool,
    automaton: Automaton,
}

/// Where light comes from.
#[derive(Clone, Debug, PartialEq)]
enum Light {
    Any,
    Environment,
    /// Materials.
    Emitters(Vec<u32>),
}

/// What may happen at a bounce.
#[derive(Clone, Debug, PartialEq)]
struct Pattern {
    /// Its lobe is one of these,
    lobes: [bool; 3],
    /// it reflects, or transmits,
    directions: [bool; 2],
    /// and the material is one of these.
    materials: Option<Vec<u32>>,
}

impl Pattern {
    const ANY: Self = Self {
        lobes: [true; 3],
        directions: [true; 2],
        materials: None,
    };

    fn fits(&self, bounce: &Bounce) -> bool {
        let lobe = match bounce.lobe {
            Lobe::Diffuse => 0,
            Lobe::Glossy => 1,
            Lobe::Specular => 2,
        };
        let is_among =
            |materials: &Vec<u32>| bounce.material.is_some_and(|m| materials.contains(&m));
        self.lobes[lobe]
            && self.directions[usize::from(bounce.is_transmission)]
            && self.materials.as_ref().is_none_or(is_among)
    }
}

/// Why a text is no expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    text: String,
    /// The character that is wrong, from 0.
    at: usize,
    what: String,
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { text, at, what } = self;
        write!(f, "{text:?}, character {}: {what}", at + 1)
    }
}

impl ExpressionError {
    /// The text, and below it a caret under what is wrong.
    #[must_use]
    pub fn marked(&self) -> String {
        let Self { text, at, .. } = self;
        format!("{text}\n{:at$}^", "")
    }
}

impl std::error::Error for ExpressionError {}

impl Expression {
    /// Characters, at most.
    pub const MAX_LENGTH: usize = 500;

    /// Reads an expression; names are those of the scene's materials.
    ///
    /// # Errors
    /// [`ExpressionError`] says what is wrong and where.
    pub fn new(text: &str, scene: &Scene) -> Result<Self, ExpressionError> {
        parse::expression(text, &|name| materials(scene, name))
    }

    /// As it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// True of a path with these bounces, from the eye on, of light that a material or, if there is
    /// none, no surface emits.
    ///
    /// Light that no surface emits is taken for the environment's.
    #[must_use]
    pub fn matches(&self, bounces: &[Bounce], emitter: Option<u32>) -> bool {
        self.alternatives.iter().any(|alternative| {
            let is_lit = match &alternative.light {
                Light::Any => true,
                Light::Environment => emitter.is_none(),
                Light::Emitters(all) => emitter.is_some_and(|one| all.contains(&one)),
            };
            let automaton = &alternative.automaton;
            is_lit
                && if alternative.is_from_light {
                    automaton.accepts(bounces.iter().rev())
                } else {
                    automaton.accepts(bounces.iter())
                }
        })
    }
}

/// The materials of a name.
fn materials(scene: &Scene, name: &str) -> Vec<u32> {
    let all = scene.materials().iter().zip(0..);
    let named = all.filter(|(material, _)| material.parameters().name == name);
    named.map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests;
