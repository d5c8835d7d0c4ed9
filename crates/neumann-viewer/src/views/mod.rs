//! Views: what can stand in place of the picture, the picture itself being the first.
//!
//! | to add one | |
//! |---|---|
//! | a file or a folder here | a struct that is a [`View`], and its [`Row`] |
//! | a row of [`VIEWS`] | key, help page, button, state files and `Esc` follow from it |
//!
//! A view owns what it looks at. Of the window it is given a [`Stage`], and of the renderer what
//! its row [`Needs`]. What the film is, and which part of the series is chosen, is not its own: a
//! *part* (`neumann_core::film::View`) is shown by a *view*.

pub mod agree;
pub mod bias;
mod column;
pub mod energy;
pub mod entry;
mod held;
pub mod hemisphere;
pub mod inspect;
pub mod layers;
pub mod lobe;
mod method_menu;
pub mod photons;
pub mod picture;
mod plate;
pub mod quantity;
pub mod race;
pub mod techniques;
mod turning;

use std::any::Any;

use egui::{Pos2, Rect, Ui};
use neumann_core::scene::OpeningProgress;
use neumann_picture::png_file::Pixels8;

use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::keys::{Action, HelpLine};
use crate::notices::Notices;
use crate::panels::Page;
use crate::pick::Picked;
use crate::probe::{self, Reading};
use crate::session::Session;
use crate::setup::Setup;

/// All views. The first one is what all others give way to.
pub static VIEWS: &[&Row] = &[
    &picture::ROW,
    &quantity::ALBEDO,
    &quantity::NORMAL,
    &quantity::DEPTH,
    &quantity::ERROR,
    &quantity::SAMPLES,
    &techniques::ROW,
    &photons::ROW,
    &inspect::ROW,
    &hemisphere::ROW,
    &layers::ROW,
    &lobe::ROW,
    &race::ROW,
    &agree::ROW,
    &bias::ROW,
    &energy::ROW,
];

/// Draw calls that a view may make, numbered from 0 on.
pub const N_DRAWS: usize = 1;

/// What menus, keys and files need to know of a view.
pub struct Row {
    /// Its name in state files.
    pub id: &'static str,
    /// The page of the panel that it is chosen on: by a button of its own, or, on the Display page,
    /// as one of the choice "Show", which a key steps through.
    pub page: Page,
    /// What it is called on its button.
    pub title: &'static str,
    /// What it shows, in a sentence.
    pub about: &'static str,
    /// Its line on the help page, with the key that shows it or goes back to the picture.
    pub key: Option<HelpLine>,
    /// What the renderer does for it while it is shown.
    pub needs: Needs,
    /// Why it cannot be shown of this method and scene, in a sentence; `None` if it can.
    pub refusal: fn(&Setup) -> Option<String>,
    /// Makes it.
    pub build: fn() -> Box<dyn View>,
}

/// The views of the choice "Show", the picture first.
pub fn choice() -> impl Iterator<Item = &'static Row> {
    let rows = VIEWS.iter().copied();
    rows.filter(|row| row.page == Page::Display)
}

/// What the renderer does for a view while it is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// It keeps the techniques of a method apart.
    pub techniques: bool,
    /// It draws the photons of methods that have some.
    pub photons: bool,
    /// It keeps what the camera sees first.
    pub features: bool,
    /// It keeps classes of paths apart; the view says which.
    pub classes: bool,
    /// It keeps the film as it is, and leaves the threads to the view.
    pub rest: bool,
}

impl Needs {
    /// Nothing but the film.
    pub const NOTHING: Self = Self {
        techniques: false,
        photons: false,
        features: false,
        classes: false,
        rest: false,
    };
}

/// What a view does. Only `draw` is asked of all.
pub trait View: Any {
    /// It is shown from now on.
    fn open(&mut self, _settings: &ViewSettings) {}

    /// It is shown no longer, and gives back what takes memory.
    fn close(&mut self) {}

    /// Once a frame, before it is drawn: takes over what is new. False if there is no point in it
    /// any more; the picture is shown then.
    fn attend(&mut self, _session: &Session, _settings: &ViewSettings) -> bool {
        true
    }

    /// Draws it, and lets the pointer act on it. Yields where the pointer is, if it can be probed
    /// there.
    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2>;

    /// What is under the pointer.
    fn probe(&self, _at: Pos2, _stage: &Stage<'_>) -> Option<Reading> {
        None
    }

    /// Iterations that it shows, where the film rests for it.
    fn n_iterations(&self) -> u32 {
        0
    }

    /// What is saved or copied while it is shown; `None` before there is anything.
    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown>;

    /// What a key asks for, where that means something of its own in this view. False if it does
    /// not.
    fn perform(&mut self, _action: Action) -> bool {
        false
    }

    /// `Esc`: one step back within it. False if there is none; the picture is shown then.
    fn step_back(&mut self) -> bool {
        false
    }
}

/// What a view is drawn on, and what it may act upon.
pub struct Stage<'a> {
    /// Where.
    pub rect: Rect,
    /// What is rendered, and the film of it.
    pub session: &'a mut Session,
    /// Part of the series, exposure, tone, magnification.
    pub settings: &'a mut ViewSettings,
    /// Where the picture stands, for the keys that magnify it.
    pub placement: &'a mut Option<Placement>,
    /// What the caption of the view covers, if it has one.
    pub caption: Rect,
    /// What was picked on it in this frame.
    pub picked: Option<Picked>,
    /// What there is to say.
    pub notices: &'a mut Notices,
    /// How far a scene is that is being opened.
    pub opening: Option<&'a OpeningProgress>,
}

/// What is saved or copied of a view.
pub struct Shown {
    /// What it is, for the name of a file.
    pub name: String,
    /// Makes the pixels, on any thread.
    pub pixels: Box<dyn FnOnce() -> Pixels8 + Send>,
}

/// All views of a window, and which one is shown.
pub struct Views {
    all: Vec<Box<dyn View>>,
    /// Index into [`VIEWS`].
    shown: usize,
}

impl Default for Views {
    fn default() -> Self {
        Self {
            all: VIEWS.iter().map(|row| (row.build)()).collect(),
            shown: 0,
        }
    }
}

impl Views {
    /// The view that is shown.
    #[must_use]
    pub fn shown(&self) -> &'static Row {
        VIEWS[self.shown]
    }

    /// A view by its type.
    #[must_use]
    pub fn get<V: View>(&self) -> Option<&V> {
        let mut all = self.all.iter();
        all.find_map(|view| (view.as_ref() as &dyn Any).downcast_ref())
    }

    /// The same, to be changed.
    #[must_use]
    pub fn get_mut<V: View>(&mut self) -> Option<&mut V> {
        let mut all = self.all.iter_mut();
        all.find_map(|view| (view.as_mut() as &mut dyn Any).downcast_mut())
    }

    /// Shows a view, by its id.
    ///
    /// # Errors
    /// Says why it cannot be shown.
    pub fn show(&mut self, id: &str, setup: &Setup, settings: &ViewSettings) -> Result<(), String> {
        let index = VIEWS.iter().position(|row| row.id == id);
        let index = index.ok_or_else(|| format!("there is no view '{id}'"))?;
        if let Some(refusal) = (VIEWS[index].refusal)(setup) {
            return Err(refusal);
        }
        if index != self.shown {
            self.close();
            self.shown = index;
            self.all[index].open(settings);
        }
        Ok(())
    }

    /// Shows a view, or goes back to the picture if it is shown.
    ///
    /// # Errors
    /// As [`Self::show`].
    pub fn toggle(
        &mut self,
        id: &str,
        setup: &Setup,
        settings: &ViewSettings,
    ) -> Result<(), String> {
        if self.shown().id == id {
            self.close();
            return Ok(());
        }
        self.show(id, setup, settings)
    }

    /// The view so many places further in the choice "Show".
    #[must_use]
    pub fn further(&self, step: i32) -> &'static Row {
        let all: Vec<&Row> = choice().collect();
        let now = all.iter().position(|row| row.id == self.shown().id);
        let next = now.unwrap_or(0) as i64 + i64::from(step);
        all[next.rem_euclid(all.len() as i64) as usize]
    }

    /// Goes back to the picture.
    pub fn close(&mut self) {
        if self.shown != 0 {
            self.all[self.shown].close();
            self.shown = 0;
        }
    }

    /// What a key asks for, where the view that is shown does something of its own then.
    pub fn perform(&mut self, action: Action) -> bool {
        self.all[self.shown].perform(action)
    }

    /// One step back, at last to the picture; false if that is shown.
    pub fn step_back(&mut self) -> bool {
        if self.shown == 0 {
            return false;
        }
        if !self.all[self.shown].step_back() {
            self.close();
        }
        true
    }

    /// Once a frame: goes back to the picture where the view has become pointless, sees that the
    /// renderer does what it needs, and lets it take over what is new.
    pub fn attend(&mut self, session: &mut Session, settings: &ViewSettings) {
        if (self.shown().refusal)(&session.setup).is_some() {
            self.close();
        }
        session.provide(self.shown().needs);
        if !self.all[self.shown].attend(session, settings) {
            self.close();
            session.provide(self.shown().needs);
        }
    }

    /// Draws the view that is shown, and what is under the pointer.
    pub fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) {
        let view = &mut self.all[self.shown];
        let probed = view.draw(ui, stage);
        let probed = probed.filter(|_| stage.settings.is_probing);
        if let Some(at) = probed
            && let Some(reading) = view.probe(at, stage)
        {
            let room = probe::Room {
                stage: stage.rect,
                picture: stage.placement.map_or(stage.rect, |placed| placed.visible),
                caption: stage.caption,
            };
            probe::show(ui, &room, at, &reading, stage.settings.part);
        }
    }

    /// Iterations that are shown while the film rests; `None` while it does not.
    #[must_use]
    pub fn n_iterations(&self) -> Option<u32> {
        let rests = self.shown().needs.rest;
        rests.then(|| self.all[self.shown].n_iterations())
    }

    /// What is saved or copied now.
    #[must_use]
    pub fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        self.all[self.shown].image(session, settings)
    }
}

#[cfg(test)]
mod tests {
    use super::VIEWS;

    #[test]
    fn rows_can_be_told_apart() {
        assert_eq!(VIEWS[0].id, "picture", "what the others give way to");
        for (i, row) in VIEWS.iter().enumerate() {
            let others = &VIEWS[i + 1..];
            assert!(others.iter().all(|other| other.id != row.id), "{}", row.id);
            assert!(!row.title.is_empty() && !row.about.is_empty(), "{}", row.id);
        }
    }
}
