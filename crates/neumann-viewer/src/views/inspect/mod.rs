//! Why a pixel is as bright as it is: its bounces, techniques, ways and paths, and the paths drawn
//! over the picture.
//!
//! While the view is open a thread of its own replays the iterations that the film has, pixel by
//! pixel. [`InspectView`] owns what is looked at; `worker` replays, `column` lays out the figures,
//! `drawing` draws paths, `outside` shows them from another side.

mod column;
mod drawing;
mod fireflies;
mod list;
mod outside;
mod worker;

use std::sync::Arc;

use egui::{Key, Pos2, Rect, StrokeKind, Ui, Vec2};
use neumann_core::render::{Inspection, Job, Replayed};
use neumann_picture::inspection;
use neumann_picture::sheet::{PictureSheet, picture_sheet};

use self::drawing::Marks;
use self::fireflies::Fireflies;
use self::list::List;
use self::outside::Outside;
use self::worker::Worker;
use super::{Needs, Row, Shown, Stage, View};
use super::{picture, plate};
use crate::display::ViewSettings;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::probe::Reading;
use crate::region;
use crate::session::Session;
use crate::theme::{GRID, Palette};

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Inspect a pixel",
    about: "Why a pixel is as bright as it is: its bounces, techniques and paths. Click a pixel",
    key: Some(keys::line(
        keys::DISPLAY,
        "Q",
        "question a pixel: its paths",
        &[keys::on(keys::NONE, Key::Q, Action::View(ID))],
    )),
    needs: Needs::NOTHING,
    refusal: |_| None,
    build: || Box::new(InspectView::default()),
};

const ID: &str = "inspect";

/// The inspector: which pixel, and what of it is looked at.
#[derive(Default)]
pub struct InspectView {
    /// Column and row in the whole picture.
    pub pixel: Option<[usize; 2]>,
    /// The paths that are listed, and which of them is chosen.
    pub list: List,
    worker: Option<Worker>,
    found: Arc<Inspection>,
    outside: Outside,
    fireflies: Fireflies,
}

impl InspectView {
    /// What has been found so far.
    #[must_use]
    pub fn found(&self) -> &Inspection {
        &self.found
    }

    /// Looks at another pixel.
    pub fn inspect(&mut self, pixel: [usize; 2]) {
        if self.pixel != Some(pixel) {
            self.pixel = Some(pixel);
            self.forget();
        }
    }

    /// Looks at a pixel that stands out, and at the path that has made it so.
    pub fn inspect_firefly(&mut self, pixel: [usize; 2]) {
        self.pixel = Some(pixel);
        self.forget();
        self.list.follows_first = true;
    }

    fn forget(&mut self) {
        self.worker = None;
        self.found = Arc::default();
        self.list.forget();
    }

    /// The paths that are listed.
    pub fn listed(&self) -> impl Iterator<Item = &Replayed> {
        self.list.rows(&self.found).map(|((_, path), _)| path)
    }

    /// The path that is chosen.
    #[must_use]
    pub fn chosen(&self) -> Option<&Replayed> {
        self.list.chosen(&self.found)
    }
}

impl View for InspectView {
    fn close(&mut self) {
        self.forget();
        self.fireflies = Fireflies::default();
    }

    fn attend(&mut self, session: &Session, settings: &ViewSettings) -> bool {
        let size = session.shown_size();
        let is_within = |p: [usize; 2]| p[0] < size.0 && p[1] < size.1;
        let is_gone = |p| session.is_settled() && !is_within(p);
        if self.pixel.is_none_or(is_gone) && size.0 > 0 {
            self.inspect([size.0 / 2, size.1 / 2]);
        }
        let (Some(pixel), Some(job)) = (self.pixel, session.link.started()) else {
            return true;
        };
        let generation = session.link.generation();
        if self
            .worker
            .as_ref()
            .is_some_and(|of| of.generation != generation)
        {
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
        if let Some(worker) = &self.worker {
            worker.go_up_to(session.picture.stats.n_iterations);
            if let Some(found) = worker.take_news(&self.found) {
                self.found = found;
            }
        }
        self.list.follow(&self.found, job, settings.part);
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let [left, right] = super::column::split(stage.rect, super::column::FIGURES);
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
        let job = session
            .link
            .started()
            .filter(|_| session.picture.is_there())?;
        let [x, y] = self.pixel?;
        let picture = picture::shown_image(session, settings);
        let (width, height) = (job.settings.width, job.settings.height);
        let frame = Rect::from_min_size(Pos2::ZERO, Vec2::new(width as f32, height as f32));
        let mut marks = Marks::new(frame, &Palette::of_theme(true));
        self.add_paths(&mut marks, &drawing::through_camera(job, frame), job);
        let strokes = marks.strokes();
        let sentence = inspection::sentence(&self.found, &job.scene);
        let heading = [
            job.scene.name().to_owned(),
            format!(
                "why pixel {x}, {y} is as bright as it is, by {}",
                job.settings.method.id
            ),
        ];
        Some(Shown {
            name: format!("pixel-{x}-{y}"),
            pixels: Box::new(move || {
                picture_sheet(&PictureSheet {
                    heading,
                    picture: (picture.pixels)(),
                    wipe: None,
                    strokes,
                    scale: None,
                    lines: vec![sentence],
                })
            }),
        })
    }

    fn perform(&mut self, action: Action) -> bool {
        match action {
            Action::Step(step) => self.list.step_vertex(&self.found, step),
            Action::Row(is_up) => self.list.step_path(&self.found, if is_up { -1 } else { 1 }),
            _ => return false,
        }
        true
    }

    fn step_back(&mut self) -> bool {
        self.list.choose_none()
    }
}

impl InspectView {
    /// The picture with the pixel and its paths on it.
    fn draw_picture(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let rect = stage.rect;
        let name = match self.pixel {
            Some([x, y]) => format!("picture, pixel {x}, {y} inspected"),
            None => "picture".to_owned(),
        };
        let (pixel, shown) = picture::with_pixel(ui, stage, self.pixel, &name);
        if let Some(pixel) = pixel {
            self.inspect(pixel);
        }
        let (response, placement) = shown?;
        let painter = ui.painter().with_clip_rect(rect);
        let (Some(pixel), Some(job)) = (self.pixel, stage.session.link.started()) else {
            return response.hover_pos();
        };
        let part = region::rect(&placement, job.settings.camera.crop.as_ref());
        let through = drawing::through_camera(job, part);
        let mut marks = Marks::new(placement.visible, &p);
        self.add_paths(&mut marks, &through, job);
        marks.paint(&painter.with_clip_rect(placement.visible));
        drawing::mark_pixel(&painter, &placement, pixel, &p);
        let size = Vec2::new(outside::width(rect), outside::height(rect));
        let corner = rect.left_bottom() + Vec2::new(GRID, -GRID - size.y);
        self.draw_outside(ui, Rect::from_min_size(corner, size), job);
        response.hover_pos()
    }

    /// Those that are listed, faint ones first, and the chosen one over them.
    fn add_paths(&self, marks: &mut Marks, through: &drawing::Through<'_>, job: &Job) {
        let reach = 2.0 * job.scene.lights().bounds().radius;
        let first = self.list.first(&self.found);
        let brightest = first.map_or(0.0, |path| path.value().luminance());
        let chosen = self.chosen();
        for path in self.list.drawn(&self.found).rev() {
            let share = (path.value().luminance() / brightest).max(0.0).sqrt();
            let strength = if chosen.is_some() { 0.25 } else { 0.8 };
            marks.add_path(through, path, reach, strength * (0.1 + 0.9 * share));
        }
        if let Some(path) = chosen {
            marks.add_path(through, path, reach, 1.0);
            marks.add_vertices(through, path, reach, self.list.vertex);
        }
    }

    fn draw_outside(&mut self, ui: &Ui, rect: Rect, job: &Job) {
        let p = Palette::of(ui);
        self.outside.take_pointer(ui, rect, &job.scene);
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 4, plate::ground(&p));
        let through = self.outside.through(rect, job);
        self.outside.draw_scene(&painter, &through, &p);
        let mut marks = Marks::new(rect, &p);
        self.add_paths(&mut marks, &through, job);
        self.outside.add_camera(&mut marks, &through, job);
        marks.paint(&painter);
        painter.rect_stroke(rect, 4, (1.0, p.line), StrokeKind::Inside);
    }
}
