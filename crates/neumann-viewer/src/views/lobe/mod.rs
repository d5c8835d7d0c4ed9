//! Lobes: the BSDF of a material from four viewing directions side by side.
//!
//! Which surface is chosen by a pixel of the small picture or from the list of materials. While the
//! view is open a thread of its own looks at it. [`LobeView`] owns what is looked at and how;
//! `worker` looks, `panel` draws one viewing direction with its `polar` plot, `controls` chooses,
//! `curve` draws the albedo.

mod controls;
mod curve;
mod panel;
mod polar;
mod worker;

use std::sync::Arc;

use egui::{Key, Pos2, Rect, ScrollArea, Stroke, Ui, UiBuilder, Vec2, pos2, vec2};
use neumann_core::render::lobe::{ANGLES, Lobes, Surface};
use neumann_picture::lobe::{Plot, Turn};
use neumann_picture::sheet::{LobeSheet, lobe_sheet};

use self::panel::Panel;
use self::worker::{Wanted, Worker};
use super::picture;
use super::{Needs, Row, Shown, Stage, View};
use crate::display::{ViewSettings, ground};
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::session::Session;
use crate::setup::name_or;
use crate::theme::{self, GRID, Palette};

pub use self::worker::Choice;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Lobes",
    about: "The BSDF of a material from four viewing directions: polar plots, lobes in space, \
            sampled directions, albedo and reciprocity",
    key: Some(keys::line(
        keys::DISPLAY,
        "O",
        "lobes of a material",
        &[keys::on(keys::NONE, Key::O, Action::View(ID))],
    )),
    needs: Needs::NOTHING,
    refusal: |_| None,
    build: || Box::new(LobeView::default()),
};

const ID: &str = "lobe";
/// A stage as wide as this has picture and controls beside the panels; else they are above.
const WIDE: f32 = 680.0;
/// Width of what stands beside the panels: at least, at most, and as a share of the stage.
const SIDE: (f32, f32, f32) = (190.0, 260.0, 0.24);
/// Height of what stands above them.
const STRIP: f32 = 128.0;
/// The least width of a panel.
const PANEL: f32 = 150.0;

/// A material, and how it is looked at.
pub struct LobeView {
    /// Whose lobes.
    pub choice: Option<Choice>,
    /// Angles of the viewer, degrees.
    pub angles: [f32; 4],
    /// From the other side of the surface than it is seen from.
    pub is_other_side: bool,
    /// What is plotted, and how.
    pub plot: Plot,
    /// From where lobes in space are seen.
    pub turn: Turn,
    worker: Option<Worker>,
    found: Option<worker::Found>,
    panels: Vec<Panel>,
    /// The list of materials is open below this place.
    menu: Option<Rect>,
    n_materials: usize,
}

impl Default for LobeView {
    fn default() -> Self {
        Self {
            choice: None,
            angles: ANGLES,
            is_other_side: false,
            plot: Plot::default(),
            turn: Turn::default(),
            worker: None,
            found: None,
            panels: Vec::new(),
            menu: None,
            n_materials: 0,
        }
    }
}

impl LobeView {
    /// What has been found, if there is a surface.
    #[must_use]
    pub fn found(&self) -> Option<&Arc<Lobes>> {
        let (_, lobes) = self.found.as_ref()?.as_ref().ok()?;
        Some(lobes)
    }

    /// Whose it is.
    #[must_use]
    pub fn surface(&self) -> Option<&Surface> {
        let (surface, _) = self.found.as_ref()?.as_ref().ok()?;
        Some(surface)
    }

    /// Why there is nothing to be found.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        Some(self.found.as_ref()?.as_ref().err()?.to_string())
    }

    /// The number of the material that is looked at.
    fn material(&self) -> Option<usize> {
        match self.choice? {
            Choice::Material(material) => Some(material),
            Choice::Pixel(_) => Some(self.surface()?.material),
        }
    }

    /// The material so many places further in the list.
    fn step(&mut self, by: i32) {
        if self.n_materials > 0 {
            let now = self.material().unwrap_or_default() as i64;
            let next = (now + i64::from(by)).rem_euclid(self.n_materials as i64);
            self.choice = Some(Choice::Material(next as usize));
        }
    }

    fn pixel(&self) -> Option<[usize; 2]> {
        match self.choice? {
            Choice::Pixel(pixel) => Some(pixel),
            Choice::Material(_) => None,
        }
    }

    /// The small picture, where a click chooses a surface.
    fn draw_picture(&mut self, ui: &Ui, stage: &mut Stage<'_>, rect: Rect) -> Option<Pos2> {
        let p = Palette::of(ui);
        stage.rect = rect;
        let name = "picture: a click shows the lobes of a surface";
        let size = stage.session.shown_size();
        // Arrows begin in the middle.
        let from = self.pixel().unwrap_or([size.0 / 2, size.1 / 2]);
        let (pixel, shown) = picture::with_pixel(ui, stage, Some(from), name);
        if pixel.is_some_and(|pixel| pixel != from) {
            self.choice = pixel.map(Choice::Pixel);
        }
        let (response, placement) = shown?;
        if let Some([x, y]) = self.pixel() {
            let film = placement.film;
            let share = |at: usize, n: usize| (at as f32 + 0.5) / n.max(1) as f32;
            let share = vec2(share(x, placement.size.0), share(y, placement.size.1));
            let at = film.min + share * film.size();
            let painter = ui.painter().with_clip_rect(rect);
            for (width, color) in [(4.0, p.ground), (1.5, p.strong)] {
                painter.circle_stroke(at, 6.0, Stroke::new(width, color));
            }
        }
        response.hover_pos()
    }

    /// Panels in rows of as many as fit, and below them what else there is.
    fn draw_panels(&mut self, ui: &mut Ui, rect: Rect, with_curve: bool) {
        let builder = UiBuilder::new().max_rect(rect).id_salt("lobe panels");
        ui.scope_builder(builder, |ui| {
            let scroll = ScrollArea::vertical().id_salt("lobes").auto_shrink(false);
            scroll.show(ui, |ui| {
                ui.set_width(rect.width() - GRID);
                let Some(lobes) = self.found().cloned() else {
                    let words = self.failure().map_or_else(
                        || "Looking at the surface …".to_owned(),
                        |failure| format!("There are no lobes: {failure}."),
                    );
                    crate::widgets::paragraph(ui, &words);
                    return;
                };
                panel::follow(&mut self.panels, &lobes);
                let room = ui.available_width();
                let gap = 2.0 * GRID;
                let n_columns = match ((room + gap) / (PANEL + gap)) as usize {
                    0 | 1 => 1,
                    2 | 3 => 2,
                    _ => 4,
                };
                let width = ((room + gap) / n_columns as f32 - gap).floor();
                let is_whole = lobes.views.iter().any(|v| v.drawn.is_transmissive);
                let heights = panel::Heights::new(width, rect.height(), is_whole);
                let size = vec2(width, heights.total());
                let n_rows = lobes.views.len().div_ceil(n_columns);
                let all = vec2(room, (size.y + GRID) * n_rows as f32);
                let (all, _) = ui.allocate_exact_size(all, egui::Sense::hover());
                for i in 0..lobes.views.len() {
                    let (column, row) = ((i % n_columns) as f32, (i / n_columns) as f32);
                    let at = all.min + vec2(column * (width + gap), row * (size.y + GRID));
                    let place = Rect::from_min_size(at, size);
                    panel::show(ui, place, self, &lobes, i, (heights, is_whole));
                }
                if with_curve {
                    curve::show(ui, &lobes);
                }
            });
        });
    }
}

impl View for LobeView {
    fn close(&mut self) {
        *self = Self {
            choice: self.choice,
            angles: self.angles,
            is_other_side: self.is_other_side,
            plot: self.plot,
            turn: self.turn,
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
        let size = session.shown_size();
        let Some(job) = session.link.started() else {
            return true;
        };
        self.n_materials = job.scene.materials().len();
        let is_there = match self.choice {
            Some(Choice::Pixel([x, y])) => x < size.0 && y < size.1,
            Some(Choice::Material(material)) => material < self.n_materials,
            None => false,
        };
        let is_gone = self.choice.is_none() || session.is_settled();
        if !is_there && is_gone && size.0 > 0 {
            self.choice = Some(Choice::Pixel([size.0 / 2, size.1 / 2]));
        }
        let Some(choice) = self.choice.filter(|_| session.is_current()) else {
            return true;
        };
        let wanted = Wanted {
            generation: session.link.generation(),
            choice,
            is_other_side: self.is_other_side,
            angles: self.angles,
        };
        if self.worker.as_ref().is_none_or(|w| w.wanted != wanted) {
            let known = self.worker.take().and_then(|worker| worker.known(&wanted));
            self.worker = Worker::start(job, wanted, known);
        }
        if let Some(found) = self.worker.as_ref().and_then(Worker::take_news) {
            self.found = Some(found);
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let whole = stage.rect;
        let (least, most, share) = SIDE;
        let is_wide = whole.width() >= WIDE;
        let (picture, controls, panels) = if is_wide {
            let width = (share * whole.width()).clamp(least, most);
            let height = (0.62 * width).min(0.3 * whole.height());
            let side = Rect::from_min_size(whole.min, vec2(width, whole.height()));
            let picture = Rect::from_min_size(side.min, vec2(width, height));
            let controls = Rect::from_min_max(pos2(side.left(), picture.bottom()), side.max);
            let panels = Rect::from_min_max(pos2(side.right(), whole.top()), whole.max);
            (picture, controls, panels)
        } else {
            let strip = Rect::from_min_size(whole.min, vec2(whole.width(), STRIP));
            let width = 0.36 * whole.width();
            let picture = Rect::from_min_size(strip.min, vec2(width, STRIP));
            let controls = Rect::from_min_max(pos2(picture.right(), strip.top()), strip.max);
            let panels = Rect::from_min_max(pos2(whole.left(), strip.bottom()), whole.max);
            (picture, controls, panels)
        };
        let hovered = self.draw_picture(ui, stage, picture);
        ground::fill(ui, panels, p.ground);
        theme::fill_panel(ui, controls);
        controls::show(ui, controls, self, stage.session, is_wide);
        self.draw_panels(ui, panels.shrink2(Vec2::new(2.0 * GRID, GRID)), !is_wide);
        controls::menu(ui, self, stage.session);
        if self.worker.as_ref().is_some_and(Worker::is_busy) {
            ui.ctx().request_repaint_after(worker::NEWS_PERIOD);
        }
        hovered
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let fraction = stage.placement.as_ref()?.fraction(at)?;
        Some(picture::read(stage.session, stage.settings, fraction))
    }

    fn image(&self, session: &Session, _settings: &ViewSettings) -> Option<Shown> {
        let (lobes, surface) = (Arc::clone(self.found()?), self.surface()?);
        // The curve comes last.
        if lobes.albedo.is_empty() {
            return None;
        }
        let scene = &session.link.started()?.scene;
        let name = name_of(session, surface.material);
        let mut what = format!("material {name}");
        if let Some([x, y]) = self.pixel() {
            what += &format!(" at pixel {x}, {y}");
        }
        if surface.is_behind {
            what += ", from behind";
        }
        let (plot, turn, scene) = (self.plot, self.turn, scene.name().to_owned());
        Some(Shown {
            name: format!("lobe-{name}"),
            pixels: Box::new(move || {
                lobe_sheet(&LobeSheet {
                    heading: [&scene, &what],
                    lobes: &lobes,
                    plot,
                    turn,
                })
            }),
        })
    }

    /// Arrows step through the materials.
    fn perform(&mut self, action: Action) -> bool {
        let Action::Step(by) = action else {
            return false;
        };
        self.step(by);
        true
    }

    fn step_back(&mut self) -> bool {
        self.menu.take().is_some()
    }
}

/// What a material is called.
fn name_of(session: &Session, material: usize) -> String {
    let job = session.link.started();
    let found = job.and_then(|job| job.scene.materials().get(material));
    let name = found.map_or("", |material| &material.parameters().name);
    name_or(name, "Material", material)
}
