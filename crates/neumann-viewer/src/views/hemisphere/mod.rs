//! The reflection equation at the surface point that a pixel shows.
//!
//! While the view is open a thread of its own looks around there. [`HemisphereView`] owns what is
//! looked at; `worker` looks, `disks` draws pictures over the hemisphere, `column` lays them out
//! with the estimates.

mod column;
mod disks;
mod worker;

use std::sync::Arc;

use egui::{Key, Pos2, Stroke, Ui};
use neumann_core::film::{Film, View as Part};
use neumann_core::radiometry::Rgb;
use neumann_core::render::Hemisphere;
use neumann_picture::sheet::{HemisphereSheet, hemisphere_sheet};

use self::disks::Disks;
use self::worker::{Found, Worker};
use super::column::Width;
use super::picture;
use super::{Needs, Row, Shown, Stage, View};
use crate::display::ViewSettings;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::session::Session;
use crate::theme::Palette;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Hemisphere at a point",
    about: "The reflection equation at the point that a pixel shows: what arrives, the BSDF, the \
            cosine and their product over the hemisphere, and three estimates of the integral. \
            Click a pixel",
    key: Some(keys::line(
        keys::DISPLAY,
        "U",
        "the hemisphere over a point",
        &[keys::on(keys::NONE, Key::U, Action::View(ID))],
    )),
    needs: Needs::NOTHING,
    refusal: |_| None,
    build: || Box::new(HemisphereView::default()),
};

const ID: &str = "hemisphere";
/// Width of what stands beside the picture.
const COLUMN: Width = Width {
    most: 640.0,
    least: 230.0,
    share: 0.56,
};

/// A surface point, and what is known of its surroundings.
#[derive(Default)]
pub struct HemisphereView {
    /// Column and row in the whole picture.
    pub pixel: Option<[usize; 2]>,
    worker: Option<Worker>,
    found: Option<Found>,
    disks: Disks,
}

impl HemisphereView {
    /// What has been found so far, if there is a surface.
    #[must_use]
    pub fn found(&self) -> Option<&Arc<Hemisphere>> {
        self.found.as_ref()?.as_ref().ok()
    }

    /// Why there is nothing to be found.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let error = self.found.as_ref()?.as_ref().err()?;
        Some(error.to_string())
    }

    /// Looks at another pixel.
    pub fn look_at(&mut self, pixel: [usize; 2]) {
        if self.pixel != Some(pixel) {
            self.pixel = Some(pixel);
            self.forget();
        }
    }

    fn forget(&mut self) {
        self.worker = None;
        self.found = None;
        self.disks.forget();
    }

    /// Luminance that the film has at the pixel, once it is as fine as it will be.
    fn of_film(&self, session: &Session) -> Option<f64> {
        let job = session.link.started()?;
        let [x, y] = job.pixel_of(self.pixel?)?;
        let of_pixel = |film: &Film, divisor: usize| {
            let index = y as usize * film.width() + x as usize;
            // On the ladder the film has fewer pixels.
            let is_fine = divisor == 1 && index < film.n_pixels();
            let layers = (0..=film.n_layers()).filter(|_| is_fine);
            let sum = layers.fold(Rgb::BLACK, |sum, layer| sum + film.layer_at(layer, index));
            is_fine.then(|| f64::from(sum.luminance()))
        };
        let link = &session.link;
        let read = session
            .picture
            .read_film(link, |film, divisor, _| of_pixel(film, divisor));
        read.flatten()
    }

    /// The picture with the pixel on it.
    fn draw_picture(&mut self, ui: &Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let rect = stage.rect;
        let name = match self.pixel {
            Some([x, y]) => format!("picture, looking around at pixel {x}, {y}"),
            None => "picture".to_owned(),
        };
        let (pixel, shown) = picture::with_pixel(ui, stage, self.pixel, &name);
        if let Some(pixel) = pixel {
            self.look_at(pixel);
        }
        let (response, placement) = shown?;
        let painter = ui.painter().with_clip_rect(rect);
        if let Some([x, y]) = self.pixel {
            let film = placement.film;
            let share = |at: usize, n: usize| (at as f32 + 0.5) / n.max(1) as f32;
            let share = egui::vec2(share(x, placement.size.0), share(y, placement.size.1));
            let at = film.min + share * film.size();
            for (width, color) in [(4.0, p.ground), (1.5, p.strong)] {
                painter.circle_stroke(at, 7.0, Stroke::new(width, color));
            }
        }
        response.hover_pos()
    }
}

impl View for HemisphereView {
    fn close(&mut self) {
        self.forget();
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
        let size = session.shown_size();
        let is_within = |p: [usize; 2]| p[0] < size.0 && p[1] < size.1;
        let is_gone = |p| session.is_settled() && !is_within(p);
        if self.pixel.is_none_or(is_gone) && size.0 > 0 {
            self.look_at([size.0 / 2, size.1 / 2]);
        }
        let (Some(pixel), Some(job)) = (self.pixel, session.link.started()) else {
            return true;
        };
        let generation = session.link.generation();
        let is_old = |worker: &Worker| worker.generation != generation;
        if self.worker.as_ref().is_some_and(is_old) {
            self.forget();
        }
        if !session.is_current() {
            return true;
        }
        if self.worker.is_none()
            && let Some(pixel) = job.pixel_of(pixel)
        {
            self.worker = Worker::start(job, generation, pixel);
        }
        if let Some(found) = self.worker.as_ref().and_then(Worker::take_news) {
            self.found = Some(found);
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let [left, right] = super::column::split(stage.rect, COLUMN);
        stage.rect = left;
        let hovered = self.draw_picture(ui, stage);
        column::show(ui, right, self, stage.session, stage.settings);
        if self.worker.as_ref().is_some_and(Worker::is_busy) {
            ui.ctx().request_repaint_after(worker::NEWS_PERIOD);
        }
        hovered
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let fraction = stage.placement.as_ref()?.fraction(at)?;
        Some(picture::read(stage.session, stage.settings, fraction))
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let hemisphere = Arc::clone(self.found()?);
        let [x, y] = self.pixel?;
        let scene = session.link.started()?.scene.name().to_owned();
        let point = format!(
            "the point that pixel {x}, {y} shows · {} directions a pixel",
            hemisphere.n_passes()
        );
        let reference = self.of_film(session);
        let (part, display): (Part, _) = (settings.part, settings.display());
        Some(Shown {
            name: format!("hemisphere-{x}-{y}"),
            pixels: Box::new(move || {
                hemisphere_sheet(&HemisphereSheet {
                    heading: [&scene, &point],
                    hemisphere: &hemisphere,
                    reference: reference.map(|mean| ("the film's pixel", mean, None)),
                    part,
                    display,
                })
            }),
        })
    }
}
