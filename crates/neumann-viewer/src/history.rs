//! Undo and redo of what is rendered: camera, materials, lights, environment, method.
//!
//! Nobody has to tell the history what is edited: it compares what is rendered with what it knows,
//! and what is other makes a step as soon as the hand rests. So a drag, a flight or a turn of the
//! wheel is one step, whatever control it was of. What is looked at (exposure, term, magnification)
//! and the size of the film are no part of it.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use egui::{Context, Vec2};
use neumann_core::integrator::METHODS;
use neumann_core::scene::description::{EnvironmentDescription, MaterialDescription};
use neumann_core::scene::{Appearance, Level, Scene};

use crate::setup::{Setup, Snapshot, name_or};

/// What has been edited since the scene was opened.
#[derive(Debug, Default)]
pub struct History {
    /// As it was when the hand rested last; `None` without a scene.
    rested: Option<Snapshot>,
    /// The scene that `rested` was taken of, or one that looks the same.
    seen: Option<Arc<Scene>>,
    undo: VecDeque<Step>,
    redo: Vec<Step>,
    /// When the wheel turned last, seconds of egui's clock.
    wheel: f64,
}

/// What a step changed, in words, and how it was on its other side.
#[derive(Debug)]
struct Step {
    what: String,
    other: Snapshot,
}

/// So many steps can be undone.
pub const MOST_STEPS: usize = 100;

/// A wheel that has rested this long has come to its end, seconds.
const WHEEL_REST: f64 = 0.4;

impl History {
    /// A scene has been opened: nothing has been edited yet.
    pub fn begin(&mut self, setup: &Setup) {
        *self = Self {
            rested: setup.snapshot(),
            seen: setup.open.as_ref().map(|open| Arc::clone(&open.scene)),
            wheel: self.wheel,
            ..Self::default()
        };
    }

    /// Once a frame, after all that may have edited something.
    pub fn follow(&mut self, ctx: &Context, setup: &Setup) {
        let (now, is_turning, is_held) = ctx.input(|i| {
            let is_turning = i.smooth_scroll_delta() != Vec2::ZERO;
            let is_held = i.pointer.any_down() || !i.keys_down.is_empty();
            (i.time, is_turning, is_held)
        });
        if is_turning {
            self.wheel = now;
        }
        if is_held || !self.may_differ(setup) {
            return;
        }
        let rest = self.wheel + WHEEL_REST - now;
        if rest > 0.0 {
            ctx.request_repaint_after(Duration::from_secs_f64(rest));
        } else {
            self.settle(setup);
        }
    }

    /// What would be undone, in words.
    #[must_use]
    pub fn to_undo(&self) -> Option<&str> {
        self.undo.back().map(|step| step.what.as_str())
    }

    /// What would be redone, in words.
    #[must_use]
    pub fn to_redo(&self) -> Option<&str> {
        self.redo.last().map(|step| step.what.as_str())
    }

    /// Undoes the last step; yields what that was.
    pub fn undo(&mut self, setup: &mut Setup) -> Option<String> {
        self.settle(setup);
        let step = self.undo.pop_back()?;
        let undone = self.swap(step, setup);
        let what = undone.what.clone();
        self.redo.push(undone);
        Some(what)
    }

    /// Does again what was undone last; yields what that was.
    pub fn redo(&mut self, setup: &mut Setup) -> Option<String> {
        self.settle(setup);
        let step = self.redo.pop()?;
        let redone = self.swap(step, setup);
        let what = redone.what.clone();
        self.undo.push_back(redone);
        Some(what)
    }

    /// Goes to the other side of a step; yields the way back.
    fn swap(&mut self, step: Step, setup: &mut Setup) -> Step {
        setup.restore(&step.other);
        self.seen = setup.open.as_ref().map(|open| Arc::clone(&open.scene));
        let before = self.rested.replace(step.other.clone());
        Step {
            what: step.what,
            other: before.unwrap_or(step.other),
        }
    }

    /// False where nothing can have been edited; costs little.
    fn may_differ(&self, setup: &Setup) -> bool {
        let (Some(rested), Some(open)) = (&self.rested, &setup.open) else {
            return false;
        };
        let is_seen = self
            .seen
            .as_ref()
            .is_some_and(|seen| Arc::ptr_eq(seen, &open.scene));
        !is_seen || !rested.has_rest_of(setup)
    }

    /// Makes a step of what has been edited.
    fn settle(&mut self, setup: &Setup) {
        if !self.may_differ(setup) {
            return;
        }
        let (Some(rested), Some(mut now)) = (&self.rested, setup.snapshot()) else {
            return;
        };
        let edits = appearance_edits(&rested.appearance, &now.appearance);
        if edits.is_empty() && rested.sky == now.sky {
            // A better tree, perhaps, or a drag that came back.
            now.appearance = Arc::clone(&rested.appearance);
        }
        let mut all = edits;
        all.extend(other_edits(rested, &now));
        self.seen = setup.open.as_ref().map(|open| Arc::clone(&open.scene));
        let before = self.rested.replace(now);
        let (Some(what), Some(other)) = (in_words(&all), before) else {
            return;
        };
        self.undo.push_back(Step { what, other });
        let excess = self.undo.len().saturating_sub(MOST_STEPS);
        self.undo.drain(..excess);
        self.redo.clear();
    }
}

/// Several edits in one sentence; `None` if there is none.
fn in_words(edits: &[String]) -> Option<String> {
    match edits {
        [] => None,
        [one] => Some(one.clone()),
        [one, other] => Some(format!("{one} and {other}")),
        [one, others @ ..] => Some(format!("{one} and {} more", others.len())),
    }
}

/// What is other about camera, method and depth.
fn other_edits(before: &Snapshot, after: &Snapshot) -> Vec<String> {
    let mut edits = Vec::new();
    let mut note = |is_other: bool, what: &str| {
        if is_other {
            edits.push(what.to_owned());
        }
    };
    if before.of_file == after.of_file {
        let cameras = [before, after].map(|side| side.camera.as_ref());
        if let [Some(before), Some(after)] = cameras {
            let is_moved = before.camera().world_from_camera != after.camera().world_from_camera;
            note(is_moved, "camera move");
            let is_other = before.camera().projection != after.camera().projection;
            note(is_other, "field of view");
            note(before.camera().lens != after.camera().lens, "lens");
        }
    } else {
        note(true, "choice of camera");
    }
    note(before.max_bounces != after.max_bounces, "longest path");
    note(before.n_layers != after.n_layers, "terms kept apart");
    note(before.seed != after.seed, "seed");
    if before.method != after.method {
        note(true, &format!("choice of {}", METHODS[after.method].id));
    }
    for (method, values) in METHODS.iter().zip(before.values.iter().zip(&after.values)) {
        for parameter in method.parameters {
            let [was, is] = [values.0, values.1].map(|values| values.value(parameter.name));
            note(was != is, &format!("{} of {}", parameter.title, method.id));
        }
    }
    edits
}

/// What is other about materials, lights and environment.
fn appearance_edits(before: &Appearance, after: &Appearance) -> Vec<String> {
    let mut edits = Vec::new();
    let materials = before.materials.iter().zip(&after.materials);
    for (i, (was, is)) in materials.enumerate().filter(|(_, (was, is))| was != is) {
        let name = name_or(&is.name, "Material", i);
        edits.push(match fields(was, is)[..] {
            [field] => format!("{field} of {name}"),
            _ => format!("material {name}"),
        });
    }
    let levels = before.material_levels.iter().zip(&after.material_levels);
    for (i, (was, is)) in levels.enumerate() {
        let name = || name_or(&after.materials[i].name, "Material", i);
        edits.extend(level_edit(*was, *is, name));
    }
    let lights = before.lights.iter().zip(&after.lights);
    for (i, (was, is)) in lights.enumerate() {
        if was != is {
            edits.push(format!("colour of {}", name_or(&is.name, "Light", i)));
        }
    }
    let levels = before.light_levels.iter().zip(&after.light_levels);
    for (i, (was, is)) in levels.enumerate() {
        let name = || name_or(&after.lights[i].name, "Light", i);
        edits.extend(level_edit(*was, *is, name));
    }
    match [before, after].map(|side| side.environment.as_ref()) {
        [None, None] => {}
        [Some(was), Some(is)] if is_same_sky(was, is) => {
            if was.rotation.to_bits() != is.rotation.to_bits() {
                edits.push("rotation of the environment".to_owned());
            }
        }
        _ => edits.push("choice of the environment".to_owned()),
    }
    let name = || "the environment".to_owned();
    let levels = [before, after].map(|side| side.environment_level);
    edits.extend(level_edit(levels[0], levels[1], name));
    if before.environment_tint != after.environment_tint {
        edits.push("colour of the environment".to_owned());
    }
    if before.backs != after.backs {
        edits.push("look through backs".to_owned());
    }
    edits
}

fn level_edit(was: Level, is: Level, name: impl Fn() -> String) -> Option<String> {
    if was.is_on != is.is_on {
        let word = if is.is_on { "on" } else { "off" };
        Some(format!("{} switched {word}", name()))
    } else {
        (was != is).then(|| format!("brightness of {}", name()))
    }
}

/// True if the two differ in their turn at most.
fn is_same_sky(a: &Arc<EnvironmentDescription>, b: &Arc<EnvironmentDescription>) -> bool {
    let plain = |e: &EnvironmentDescription| (e.width, e.height, e.intensity.to_bits(), e.sun);
    Arc::ptr_eq(a, b) || (a.name == b.name && plain(a) == plain(b))
}

/// The fields of a material that can be edited, where two differ.
fn fields(a: &MaterialDescription, b: &MaterialDescription) -> Vec<&'static str> {
    let all = [
        ("base colour", a.base_color != b.base_color),
        ("roughness", a.roughness != b.roughness),
        ("metallic", a.metallic != b.metallic),
        ("specular", a.specular != b.specular),
        ("transmission", a.transmission != b.transmission),
        ("index of refraction", a.ior != b.ior),
        ("specular colour", a.specular_color != b.specular_color),
        ("volume colour", a.volume != b.volume),
        ("emission", a.emission != b.emission),
    ];
    let other = all.into_iter().filter(|(_, is_other)| *is_other);
    other.map(|(field, _)| field).collect()
}
