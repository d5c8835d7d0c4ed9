//! How much of the error of a method with a radius is noise, and how much the bias of the radius,
//! per pixel and bounce by bounce, while one looks.
//!
//! While the view is open the film rests, and the method of the picture renders at its radius and
//! at half of it. [`BiasView`] owns what is looked at, `worker` renders and measures on a thread of
//! its own, `column` says what follows. Films of more than 512×512 pixels are measured in a
//! smaller size; memory stays below 20 MB for each part of the series, and all of it is given back.

mod column;
mod worker;

use std::sync::{Arc, PoisonError};

use egui::{Context, Key, Pos2, TextureHandle, Ui};
use neumann_core::film::View as Part;
use neumann_picture::agreement::count;
use neumann_picture::false_colour::ColourMap;
use neumann_picture::figures::significant;
use neumann_picture::quantity::QuantityPlane;
use neumann_picture::radius_bias::{Half, common_look, has_radius, planes};
use neumann_picture::sheet::{RadiusBiasSheet, Scale, radius_bias_sheet};

use super::column::Width;
use super::held::{Follower, PERIOD, within_memory};
use super::plate::{self, Painting};
use super::{Needs, Row, Shown, Stage, View, picture};
use crate::display::ViewSettings;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::session::Session;

pub use worker::{Finding, Found};

use worker::Wanted;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Noise and bias",
    about: "How much of the error is noise, and how much the bias of the radius, by renders at two \
            radii",
    key: Some(keys::line(
        keys::DISPLAY,
        "Shift B",
        "noise, and the bias of a radius",
        &[keys::on(keys::SHIFT, Key::B, Action::View(ID))],
    )),
    needs: Needs {
        rest: true,
        ..Needs::NOTHING
    },
    refusal: |setup| {
        let method = setup.method();
        (!has_radius(method)).then(|| {
            let name = method.name;
            format!("{name} has no radius: choose pm, ppm or vcm to see the bias of one")
        })
    },
    build: || Box::new(BiasView::default()),
};

const ID: &str = "bias";
/// Iterations that a render may have.
const LENGTHS: [u32; 4] = [1, 4, 16, 64];
/// Width of what stands beside the map.
const COLUMN: Width = Width {
    most: 400.0,
    least: 230.0,
    share: 0.4,
};

/// Noise and bias: what of them is looked at.
pub struct BiasView {
    /// What the map shows.
    pub half: Half,
    /// Iterations of a render.
    pub n_iterations: u32,
    /// What was found last.
    pub found: Option<Arc<Finding>>,
    work: Follower<Wanted, Option<Arc<Finding>>>,
    painted: Option<Painted>,
    is_paused: bool,
}

impl Default for BiasView {
    fn default() -> Self {
        Self {
            half: Half::Bias,
            n_iterations: LENGTHS[1],
            found: None,
            work: Follower::default(),
            painted: None,
            is_paused: false,
        }
    }
}

/// A map on a texture.
struct Painted {
    of: Arc<Finding>,
    part: Part,
    half: Half,
    map: ColourMap,
    planes: Arc<[QuantityPlane; 2]>,
    scale: Scale,
    texture: TextureHandle,
}

/// The part that is measured where a part is chosen: partial sums are not.
fn measured(chosen: Part) -> Part {
    match chosen {
        Part::Upto(_) => Part::Total,
        part => part,
    }
}

impl BiasView {
    /// What was found last, if anything was.
    #[must_use]
    pub fn found(&self) -> Option<&Found> {
        self.found.as_deref()?.as_ref().ok()
    }

    fn wanted(&self, session: &Session) -> Option<Wanted> {
        let job = session.link.started()?;
        Some(Wanted {
            scene: Arc::clone(&job.scene),
            settings: within_memory(&job.settings),
            n_iterations: self.n_iterations,
        })
    }

    /// Paints the map, unless the thread is just taking in a render.
    fn paint(&mut self, ctx: &Context, part: Part, map: ColourMap) {
        let (Some(finding), Some(found)) = (&self.found, self.found()) else {
            self.painted = None;
            return;
        };
        let half = self.half;
        let is_painted = |painted: &Painted| {
            Arc::ptr_eq(&painted.of, finding)
                && (painted.part, painted.half, painted.map) == (part, half, map)
        };
        if self.painted.as_ref().is_some_and(is_painted) {
            return;
        }
        if !found.parts.iter().any(|(view, ..)| *view == part) {
            self.painted = None;
            return;
        }
        let Ok(held) = found.held.try_read() else {
            ctx.request_repaint_after(PERIOD);
            return;
        };
        let Some(view) = held.views().iter().position(|view| *view == part) else {
            return;
        };
        let planes = Arc::new(planes(&held, view));
        drop(held);
        let look = common_look(&planes, map);
        let shown = &planes[usize::from(half == Half::Bias)];
        let finding = Arc::clone(finding);
        let (scale, pixels) = (shown.scale(&look), shown.pixels(&look));
        let old = self.painted.take().map(|painted| painted.texture);
        self.painted = Some(Painted {
            of: finding,
            part,
            half,
            map,
            texture: plate::texture(ctx, ID, old, pixels),
            planes,
            scale,
        });
    }

    /// Why there is no map.
    fn waiting(&self) -> String {
        match self.found.as_deref() {
            Some(Err(error)) => error.clone(),
            Some(Ok(_)) => "no light here".to_owned(),
            None if self.is_paused => "paused (Space)".to_owned(),
            None => "the first renders …".to_owned(),
        }
    }

    fn draw_map(&mut self, ui: &Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let part = measured(stage.settings.part);
        self.paint(ui.ctx(), part, stage.settings.map);
        let paused = if self.is_paused {
            ", paused (Space)"
        } else {
            ""
        };
        let what = match self.half {
            Half::Noise => "Noise",
            Half::Bias => "Radius bias",
        };
        let caption = format!("{what} of {part}{paused}");
        let facts = self.found().map(|found| {
            let renders = count(found.n_renders, "render");
            let said = found.parts.iter().find(|(view, ..)| *view == part);
            let row = said.map(|(_, row, _)| format!("noise {}, bias {}", row.noise, row.bias));
            let row = row.unwrap_or_else(|| "no light".to_owned());
            [
                format!("{renders} at each radius: {row}"),
                format!("{renders}: {row}"),
            ]
        });
        let waiting = self.waiting();
        let spoken = facts.as_ref().map_or(&waiting, |[fact, _]| fact);
        let name = format!("{caption}; {spoken}");
        let size = stage.session.shown_size();
        let (response, placement) = picture::take_pointer(ui, stage, size, &name);
        let (Some(painted), Some(facts)) = (&self.painted, facts) else {
            plate::wait(ui, stage.rect, &waiting);
            return None;
        };
        let region = painted
            .of
            .as_ref()
            .as_ref()
            .ok()
            .and_then(|found| found.region.as_ref());
        let painting = Painting {
            texture: &painted.texture,
            region,
            caption: &caption,
            facts,
            scale: &painted.scale,
        };
        plate::paint(ui, stage, &placement, painting);
        response.hover_pos()
    }
}

impl View for BiasView {
    fn close(&mut self) {
        *self = Self {
            half: self.half,
            n_iterations: self.n_iterations,
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
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
        if self.work.is_busy() {
            ui.ctx().request_repaint_after(PERIOD);
        }
        hovered
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let painted = self.painted.as_ref()?;
        let found = painted.of.as_ref().as_ref().ok()?;
        let size = painted.planes[0].size;
        plate::under(at, stage, found.region.as_ref(), size, |(x, y)| {
            let mut lines = Vec::new();
            for (half, plane) in Half::ALL.into_iter().zip(painted.planes.iter()) {
                // Its second line would be a share of L.
                let words = plane.words(x, y).into_iter().next().unwrap_or_default();
                lines.push(format!("{} {words}", half.name()));
            }
            let held = found.held.read().unwrap_or_else(PoisonError::into_inner);
            if let Some(view) = held.views().iter().position(|view| *view == painted.part) {
                let pixel = y * size.0 + x;
                let [wide, bias] = held.pixel(view, pixel);
                let number = |value, figures| significant(value, figures);
                lines.push(format!("mean {} W m⁻² sr⁻¹", number(wide.mean, 4)));
                let error = number(bias.standard_error, 2);
                let sign = if bias.mean < 0.0 { "−" } else { "" };
                let mean = number(bias.mean.abs(), 3);
                lines.push(format!("bias {sign}{mean} ± {error} here"));
            }
            lines
        })
    }

    fn n_iterations(&self) -> u32 {
        self.found()
            .map_or(0, |found| found.n_renders as u32 * found.n_iterations)
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let painted = self.painted.as_ref()?;
        let found = painted.of.as_ref().as_ref().ok()?;
        let open = session.setup.open.as_ref();
        let scene = open.map_or("scene", |open| open.short_name()).to_owned();
        let heading = [scene, found.heading.clone()];
        let said = found.parts.iter().find(|(view, ..)| *view == painted.part);
        let mut lines: Vec<String> = said.map(|(.., said)| said.to_vec()).unwrap_or_default();
        lines.extend(found.notes.iter().cloned());
        let (planes, map) = (Arc::clone(&painted.planes), settings.map);
        Some(Shown {
            name: format!("{ID}-{}", painted.part),
            pixels: Box::new(move || {
                radius_bias_sheet(&RadiusBiasSheet {
                    heading,
                    planes: &planes,
                    map,
                    lines,
                })
            }),
        })
    }
}
