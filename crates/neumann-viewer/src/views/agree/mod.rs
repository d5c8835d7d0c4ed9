//! Where two methods agree, bounce by bounce: both render in turn while one looks, noise is grey,
//! and a bias lights up.
//!
//! While the view is open the film rests. [`AgreeView`] owns who is compared and what is looked at;
//! `worker` renders and compares on a thread of its own, `column` says what follows, `words` what
//! is under the pointer. Films of more than 512×512 pixels are compared in a smaller size; memory
//! stays below 16 MB for each part of the series, and all of it is given back in the end.

mod column;
mod words;
mod worker;

use std::sync::Arc;

use egui::{Context, Key, Pos2, TextureHandle, Ui};
use neumann_core::film::View as Part;
use neumann_picture::agreement::{Grain, Term, map, scale};
use neumann_picture::race::Entrant;
use neumann_picture::sheet::{AgreementSheet, agreement_sheet};

use super::column::Width;
use super::entry::{self, Entry};
use super::held::{Follower, PERIOD, within_memory};
use super::method_menu::{MethodMenu, Rules};
use super::plate::{self, Painting};
use super::{Needs, Row, Shown, Stage, View, picture};
use crate::display::ViewSettings;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::session::Session;

pub use worker::Found;

use worker::Wanted;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Agreement map",
    about: "Two methods render the scene in turn: where they differ, noise is grey and bias lights \
            up, bounce by bounce",
    key: Some(keys::line(
        keys::DISPLAY,
        "Y",
        "agreement of two methods",
        &[keys::on(keys::NONE, Key::Y, Action::View(ID))],
    )),
    needs: Needs {
        rest: true,
        ..Needs::NOTHING
    },
    refusal: |setup| {
        let text = "There is no scene yet to compare methods on";
        setup.open.is_none().then(|| text.to_owned())
    },
    build: || Box::new(AgreeView::default()),
};

const ID: &str = "agree";
/// Iterations that a batch may have.
const LENGTHS: [u32; 3] = [1, 4, 16];
/// Width of what stands beside the map.
const COLUMN: Width = Width {
    most: 400.0,
    least: 230.0,
    share: 0.4,
};
/// What its menus allow.
const RULES: Rules = Rules {
    least: 2,
    may_repeat: true,
    why_removed: "",
};

/// The agreement map: who is compared, and what of it is looked at.
pub struct AgreeView {
    /// The two methods.
    pub entries: Vec<Entry>,
    /// What has a colour of its own on the map.
    pub grain: Grain,
    /// Iterations of a batch.
    pub n_iterations: u32,
    /// What was found last.
    pub found: Option<Arc<Found>>,
    menu: MethodMenu,
    work: Follower<Wanted, Option<Arc<Found>>>,
    painted: Option<Painted>,
    is_paused: bool,
    is_opening: bool,
}

impl Default for AgreeView {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            grain: Grain::default(),
            n_iterations: LENGTHS[0],
            found: None,
            menu: MethodMenu::default(),
            work: Follower::default(),
            painted: None,
            is_paused: false,
            is_opening: false,
        }
    }
}

/// A map on a texture.
struct Painted {
    of: Arc<Found>,
    part: Part,
    grain: Grain,
    texture: TextureHandle,
}

impl AgreeView {
    /// The scores of a part, if it has any light.
    fn term(found: &Found, part: Part) -> Option<&Term> {
        let mut terms = found.agreement.terms.iter();
        terms.find(|term| term.view == part)
    }

    /// What is to be compared, of what the window is to render.
    fn wanted(&self, session: &Session) -> Option<Wanted> {
        let job = session.link.started()?;
        let entrants = [0, 1].map(|i| Some(self.entries.get(i)?.entrant(&session.setup)));
        let [Some(a), Some(b)]: [Option<Entrant>; 2] = entrants else {
            return None;
        };
        // The method that the picture is rendered by is of no account.
        let common = within_memory(&a.settings(&job.settings));
        Some(Wanted {
            scene: Arc::clone(&job.scene),
            common,
            entrants: [a, b],
            n_iterations: self.n_iterations,
        })
    }

    fn paint(&mut self, ctx: &Context, part: Part) {
        let Some(found) = &self.found else {
            self.painted = None;
            return;
        };
        let is_painted = |painted: &Painted| {
            Arc::ptr_eq(&painted.of, found) && painted.part == part && painted.grain == self.grain
        };
        if self.painted.as_ref().is_some_and(is_painted) {
            return;
        }
        let Some(term) = Self::term(found, part) else {
            self.painted = None;
            return;
        };
        let old = self.painted.take().map(|painted| painted.texture);
        let pixels = map(&found.agreement, term, self.grain);
        self.painted = Some(Painted {
            texture: plate::texture(ctx, ID, old, pixels),
            of: Arc::clone(found),
            part,
            grain: self.grain,
        });
    }

    /// Why there is no map.
    fn waiting(&self) -> &'static str {
        match (&self.found, self.is_paused) {
            (Some(_), _) => "no light here, by either method",
            (None, true) => "paused (Space)",
            (None, false) => "the first batches …",
        }
    }

    fn draw_map(&mut self, ui: &Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let part = Found::part(stage.settings.part);
        self.paint(ui.ctx(), part);
        let caption = words::caption(part, stage.settings.part, self.is_paused);
        let facts = self.found.as_ref().map(|found| words::facts(found, part));
        let spoken = facts.as_ref().map_or(self.waiting(), |[fact, _]| fact);
        let name = format!("{caption}; {spoken}");
        let size = stage.session.shown_size();
        let (response, placement) = picture::take_pointer(ui, stage, size, &name);
        let (Some(painted), Some(facts)) = (&self.painted, facts) else {
            plate::wait(ui, stage.rect, self.waiting());
            return None;
        };
        let agreement = &painted.of.agreement;
        let limit = match self.grain {
            Grain::Blocks => agreement.limit,
            Grain::Pixels => agreement.pixel_limit,
        };
        let painting = Painting {
            texture: &painted.texture,
            region: painted.of.region.as_ref(),
            caption: &caption,
            facts,
            scale: &scale(limit),
        };
        plate::paint(ui, stage, &placement, painting);
        response.hover_pos()
    }
}

impl View for AgreeView {
    fn open(&mut self, _settings: &ViewSettings) {
        self.is_opening = true;
    }

    fn close(&mut self) {
        *self = Self {
            entries: std::mem::take(&mut self.entries),
            grain: self.grain,
            n_iterations: self.n_iterations,
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
        let setup = &session.setup;
        let is_in = |e: &Entry| e.method(setup) == setup.method;
        let is_opening = std::mem::take(&mut self.is_opening);
        if is_opening && !self.entries.iter().any(is_in) || self.entries.len() != 2 {
            let partner = entry::partner(setup.method);
            self.entries = [setup.method, partner].map(Entry::OfPage).into();
        }
        self.is_paused = session.link.is_paused();
        let (wanted, is_first) = (self.wanted(session), self.found.is_none());
        let work = &mut self.work;
        if let Some(found) = work.attend(ID, wanted, session, is_first, worker::hold) {
            self.found = found;
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let [left, right] = super::column::split(stage.rect, COLUMN);
        stage.rect = left;
        let hovered = self.draw_map(ui, stage);
        super::column::show(ui, right, ID, |ui| column::contents(ui, self, stage));
        let setup = &stage.session.setup;
        self.menu.show(ui, &mut self.entries, &RULES, setup);
        if self.work.is_busy() {
            ui.ctx().request_repaint_after(PERIOD);
        }
        hovered
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let painted = self.painted.as_ref()?;
        let found = &painted.of;
        let size = found.agreement.cells.size();
        plate::under(at, stage, found.region.as_ref(), size, |at| {
            words::under(found, painted.part, self.grain, at)
        })
    }

    fn n_iterations(&self) -> u32 {
        self.found
            .as_ref()
            .map_or(0, |found| found.n_batches as u32 * found.n_iterations)
    }

    fn image(&self, session: &Session, _settings: &ViewSettings) -> Option<Shown> {
        let found = Arc::clone(self.found.as_ref()?);
        let open = session.setup.open.as_ref();
        let scene = open.map_or("scene", |open| open.short_name()).to_owned();
        let n_layers = session.link.started()?.settings.n_layers;
        let grain = self.grain;
        Some(Shown {
            name: ID.to_owned(),
            pixels: Box::new(move || {
                agreement_sheet(&AgreementSheet {
                    heading: [&scene, &found.heading],
                    names: found.names.each_ref().map(String::as_str),
                    n_layers,
                    agreement: &found.agreement,
                    grain,
                    lines: &found.verdict,
                })
            }),
        })
    }

    fn step_back(&mut self) -> bool {
        self.menu.close()
    }
}
