//! Layers beside the bounces: of classes of paths, and of the light of each source.
//!
//! What a class is, an expression says. The light of each source is kept apart by bounce as well,
//! so that every part of the series can be seen in other light without rendering it anew: light
//! transport is linear in what is emitted.

use std::collections::HashSet;
use std::sync::Arc;

use super::{LightGroup, View};
use crate::expression::Expression;
use crate::radiometry::Rgb;
use crate::transport::{Scattered, Source};

/// Which layers are kept.
#[derive(Clone, Debug, Default)]
pub struct PathClasses {
    /// A layer each.
    pub expressions: Vec<Expression>,
    /// A layer of each bounce for each, and for the light that is in none of them.
    pub groups: Vec<LightGroup>,
}

/// Why layers cannot be kept.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClassError {
    /// There are too many.
    #[error(
        "{n} {what} are more layers than the film keeps beside the bounces; use {most} at most"
    )]
    TooMany {
        /// How many there are.
        n: usize,
        /// What they are.
        what: &'static str,
        /// How many there may be.
        most: usize,
    },
    /// Two have one name.
    #[error("two layers are called '{0}'; give one of them another name, NAME=EXPRESSION")]
    OneName(String),
}

impl PathClasses {
    /// Expressions at once.
    pub const MAX_EXPRESSIONS: usize = 32;
    /// Groups of lights at once.
    pub const MAX_GROUPS: usize = 16;

    /// Checks that the layers can be kept.
    ///
    /// # Errors
    /// [`ClassError`].
    pub fn check(&self) -> Result<(), ClassError> {
        let too_many = |n, what, most| Err(ClassError::TooMany { n, what, most });
        let (expressions, groups) = (&self.expressions, &self.groups);
        if expressions.len() > Self::MAX_EXPRESSIONS {
            return too_many(
                expressions.len(),
                "light path expressions",
                Self::MAX_EXPRESSIONS,
            );
        }
        if groups.len() > Self::MAX_GROUPS {
            return too_many(groups.len(), "light groups", Self::MAX_GROUPS);
        }
        let mut names = HashSet::new();
        match expressions.iter().find(|e| !names.insert(e.name())) {
            Some(twice) => Err(ClassError::OneName(twice.name().to_owned())),
            None => Ok(()),
        }
    }

    /// True if there is nothing to keep.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.expressions.is_empty() && self.groups.is_empty()
    }

    /// Number of groups, with that of all other light.
    fn n_groups(&self) -> usize {
        match self.groups.len() {
            0 => 0,
            n => n + 1,
        }
    }

    fn group_of(&self, source: Option<Source>) -> usize {
        let is_in = |group: &LightGroup| source.is_some_and(|s| group.sources.contains(&s));
        let found = self.groups.iter().position(is_in);
        found.unwrap_or(self.groups.len())
    }
}

/// The layers, each a mean of iterations.
#[derive(Clone, Debug)]
pub struct ClassFilm {
    classes: Arc<PathClasses>,
    width: usize,
    height: usize,
    n_layers: usize,
    n_expressions: usize,
    n_groups: usize,
    n_iterations: u32,
    /// Expressions, then the layers of each group, tail last: sums of all iterations,
    /// `[y * width + x]`; `None` while black.
    planes: Vec<Option<Vec<Rgb>>>,
}

/// What a contribution adds to a layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClassRecord {
    pixel: u32,
    plane: u32,
    value: Rgb,
}

/// Where records come from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClassShape {
    width: usize,
    n_layers: usize,
}

impl ClassShape {
    /// What a path of a bounce adds to a pixel that has this row of events, from the eye on, and
    /// light from this source.
    pub(crate) fn record(
        self,
        classes: &PathClasses,
        [x, y]: [u32; 2],
        (bounce, row, source): (u32, &[Scattered], Option<Source>),
        value: Rgb,
        records: &mut Vec<ClassRecord>,
    ) {
        let pixel = y * self.width as u32 + x;
        let mut add = |plane: usize, value: Rgb| {
            if value.is_black() {
                return;
            }
            let plane = plane as u32;
            // What comes to one pixel comes in a row.
            let of_pixel = records.iter_mut().rev().take_while(|r| r.pixel == pixel);
            match of_pixel.into_iter().find(|r| r.plane == plane) {
                Some(record) => record.value += value,
                None => records.push(ClassRecord {
                    pixel,
                    plane,
                    value,
                }),
            }
        };
        for (i, expression) in classes.expressions.iter().enumerate() {
            add(i, value * expression.share(row, source));
        }
        if classes.n_groups() > 0 {
            let layer = (bounce as usize).min(self.n_layers);
            let group = classes.group_of(source);
            let first = classes.expressions.len();
            add(first + group * (self.n_layers + 1) + layer, value);
        }
    }
}

impl ClassFilm {
    /// Black layers for a film of `width × height` pixels that keeps `n_layers` bounces apart.
    #[must_use]
    pub fn new(width: usize, height: usize, n_layers: usize, classes: Arc<PathClasses>) -> Self {
        let (n_expressions, n_groups) = (classes.expressions.len(), classes.n_groups());
        Self {
            classes,
            width,
            height,
            n_layers,
            n_expressions,
            n_groups,
            n_iterations: 0,
            planes: vec![None; n_expressions + n_groups * (n_layers + 1)],
        }
    }

    pub(crate) fn shape(&self) -> ClassShape {
        ClassShape {
            width: self.width,
            n_layers: self.n_layers,
        }
    }

    pub(crate) fn take(&mut self, records: &[ClassRecord]) {
        let n = self.width * self.height;
        for record in records {
            let plane =
                self.planes[record.plane as usize].get_or_insert_with(|| vec![Rgb::BLACK; n]);
            plane[record.pixel as usize] += record.value;
        }
    }

    pub(crate) fn end_iteration(&mut self) {
        self.n_iterations += 1;
    }

    /// The same without an iteration.
    pub(crate) fn emptied(&self) -> Self {
        Self {
            n_iterations: 0,
            planes: vec![None; self.planes.len()],
            ..self.clone()
        }
    }

    /// Which layers they are.
    #[must_use]
    pub fn classes(&self) -> &Arc<PathClasses> {
        &self.classes
    }

    /// The names of the groups of lights, that of all other light last.
    pub fn group_names(&self) -> impl Iterator<Item = &str> {
        let names = self.classes.groups.iter().map(|group| group.name.as_str());
        names.chain([LightGroup::OTHERS]).take(self.n_groups)
    }

    /// Pixels per row.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Number of bounce layers, the tail not counted.
    #[must_use]
    pub fn n_layers(&self) -> usize {
        self.n_layers
    }

    /// Number of expressions.
    #[must_use]
    pub fn n_expressions(&self) -> usize {
        self.n_expressions
    }

    /// Number of groups of lights; the last one is that of all light that is in no other. 0 where
    /// light is not kept apart.
    #[must_use]
    pub fn n_groups(&self) -> usize {
        self.n_groups
    }

    /// Iterations that it is the mean of.
    #[must_use]
    pub fn n_iterations(&self) -> u32 {
        self.n_iterations
    }

    /// Memory of the layers that are not black, bytes: 12 for each pixel and layer.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let n_lit = self.planes.iter().flatten().count();
        n_lit * self.width * self.height * size_of::<Rgb>()
    }

    /// The layer of an expression, `[y * width + x]`, row 0 on top.
    #[must_use]
    pub fn expression(&self, number: usize) -> Vec<Rgb> {
        let mut pixels = vec![Rgb::BLACK; self.width * self.height];
        if number < self.n_expressions {
            self.add_plane(number, Rgb::WHITE, &mut pixels);
        }
        pixels
    }

    /// The light of a group in a part of the series; `None` if the film does not keep the part
    /// apart, or no such group.
    #[must_use]
    pub fn group(&self, number: usize, part: View) -> Option<Vec<Rgb>> {
        let mut weights = vec![Rgb::BLACK; self.n_groups];
        *weights.get_mut(number)? = Rgb::WHITE;
        self.mixed(part, &weights)
    }

    /// A part of the series where the light of each group is multiplied; groups that have no factor
    /// keep theirs. `None` if the film does not keep the part apart.
    #[must_use]
    pub fn mixed(&self, part: View, factors: &[Rgb]) -> Option<Vec<Rgb>> {
        let layers = part.layers(self.n_layers)?;
        let mut pixels = vec![Rgb::BLACK; self.width * self.height];
        for group in 0..self.n_groups {
            let factor = factors.get(group).copied().unwrap_or(Rgb::WHITE);
            for layer in layers.clone() {
                let plane = self.n_expressions + group * (self.n_layers + 1) + layer;
                self.add_plane(plane, factor, &mut pixels);
            }
        }
        Some(pixels)
    }

    /// True if the group has any light.
    #[must_use]
    pub fn is_lit(&self, group: usize) -> bool {
        let first = self.n_expressions + group * (self.n_layers + 1);
        let planes = self.planes.get(first..=first + self.n_layers);
        planes.is_some_and(|planes| planes.iter().any(Option::is_some))
    }

    fn add_plane(&self, plane: usize, factor: Rgb, pixels: &mut [Rgb]) {
        let Some(plane) = &self.planes[plane] else {
            return;
        };
        if factor.is_black() {
            return;
        }
        let factor = factor / self.n_iterations.max(1) as f32;
        for (pixel, value) in pixels.iter_mut().zip(plane) {
            *pixel += *value * factor;
        }
    }
}
