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
//! | `L'lamp'`, `L'environment'` | light of a material or light of this name, or the environment |
//! | `X*`, `X+`, `X?`, `X{2}`, `X{2,5}`, `X{2,}` | so often |
//! | `[DG]`, `[^S]` | one of these, none of these |
//! | <code>X&#124;Y</code>, `(X Y)` | one or the other, taken as one |
//!
//! Spaces mean nothing, but that the name of a light, or of a lobe's material, follows without one.
//! A name may stand before an expression: `haze=L .* G E`. Some have names already: [`PRESETS`].
//!
//! An expression begins with `L` and ends with `E`, or the other way round. It is read from where
//! it begins; several may stand side by side with `|` between them.

mod automaton;
mod parse;
mod states;

use std::fmt;

use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::{Bounce, Lobe, Scattered, Source};

use self::states::States;

/// A kind of path.
#[derive(Clone, Debug)]
pub struct Expression {
    name: String,
    text: String,
    /// The lights of the expressions that stand side by side.
    lights: Vec<Light>,
    states: States,
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

/// Where light comes from.
#[derive(Clone, Debug, PartialEq)]
enum Light {
    Any,
    /// One of these.
    Sources(Vec<Source>),
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

    /// Reads an expression, a name of its own before it and `=` between them if it is to have one,
    /// or the name of one of [`PRESETS`]. Names within it are those of the scene's materials and
    /// lights.
    ///
    /// # Errors
    /// [`ExpressionError`] says what is wrong and where.
    pub fn new(text: &str, scene: &Scene) -> Result<Self, ExpressionError> {
        let names = Names {
            materials: &|name| materials(scene, name),
            lights: &|name| punctual_lights(scene, name),
        };
        parse::expression(text, &names)
    }

    /// Its name, or what was written where it has none.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// As it was written, without its name.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// True of a path with these bounces, from the eye on, and light from this source.
    #[must_use]
    pub fn matches(&self, bounces: &[Bounce], source: Option<Source>) -> bool {
        self.states.accepted(bounces.iter()) & self.lit_by(source) != 0
    }

    /// The share, per channel, that it takes of what a path brings with these bounces, from the eye
    /// on, and light from this source. Of two lobes at a bounce it may take one. Expressions that
    /// have no path in common, and together all of them, take shares that add up to 1.
    #[must_use]
    pub fn share(&self, row: &[Scattered], source: Option<Source>) -> Rgb {
        let alternatives = self.lit_by(source);
        if alternatives == 0 {
            return Rgb::BLACK;
        }
        self.states.share(row.iter(), alternatives)
    }

    /// The expressions side by side that a light fits, a bit for each.
    fn lit_by(&self, source: Option<Source>) -> u64 {
        let fits = |light: &Light| match light {
            Light::Any => true,
            Light::Sources(all) => source.is_some_and(|source| all.contains(&source)),
        };
        let lights = self.lights.iter().enumerate();
        lights.fold(0, |bits, (i, light)| bits | u64::from(fits(light)) << i)
    }
}

/// As it is written in a list: with its name, if it has one.
impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.name != self.text {
            write!(f, "{}=", self.name)?;
        }
        write!(f, "{}", self.text)
    }
}

/// What expressions may name.
struct Names<'a> {
    /// The materials of a name.
    materials: &'a dyn Fn(&str) -> Vec<u32>,
    /// The lights of no extent of a name.
    lights: &'a dyn Fn(&str) -> Vec<u32>,
}

/// The materials of a name.
fn materials(scene: &Scene, name: &str) -> Vec<u32> {
    let all = scene.materials().iter().zip(0..);
    let named = all.filter(|(material, _)| material.parameters().name == name);
    named.map(|(_, index)| index).collect()
}

/// The lights of a name.
fn punctual_lights(scene: &Scene, name: &str) -> Vec<u32> {
    let all = scene.appearance().lights.iter().zip(0..);
    let named = all.filter(|(light, _)| light.name == name);
    named.map(|(_, index)| index).collect()
}

#[cfg(test)]
mod tests;
