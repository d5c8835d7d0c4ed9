//! The picture: a part of the film, with caption, pixel values, wipe, and the hand on the camera.

mod caption;
mod hand;
mod wipe;

use egui::{Align2, Color32, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2};
use neumann_core::radiometry::Rgb;
use neumann_picture::Image;
use neumann_picture::png_file::Pixels8;

use super::{Needs, Row, Shown, Stage, View};
use crate::display::image_area::{self, Pictures, Placement};
use crate::display::{Slot, ViewSettings, ground, legend, values};
use crate::probe::Reading;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};

/// Its row.
pub static ROW: Row = Row {
    id: "picture",
    title: "Picture",
    about: "Any part of the series, as the film has it.",
    key: None,
    needs: Needs::NOTHING,
    refusal: |_| None,
    build: || Box::new(PictureView),
};

/// The picture owns nothing: all that it shows is the session's.
pub struct PictureView;

impl View for PictureView {
    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let rect = stage.rect;
        let caption = stage.settings.part.caption();
        let (response, placement) = take_pointer(ui, stage, &format!("picture: {caption}"));
        let session = &mut *stage.session;
        session.picture.compose(&session.link, stage.settings.part);
        let covered = if session.picture.is_there() {
            placement.visible
        } else {
            Rect::NOTHING
        };
        fill_around(ui, rect, covered, p.ground);
        if !session.picture.is_there() {
            show_waiting(ui, stage);
            return None;
        }
        let settings = &mut *stage.settings;
        let pictures = pictures(session, settings);
        let painter = ui.painter().with_clip_rect(rect);
        let planes = &session.picture.planes;
        image_area::draw(&painter, &placement, settings, planes, pictures, 0);
        if placement.magnification > 16.0 && pictures == Pictures::One(Slot::Live) {
            let exposure = settings.exposure_ev.exp2();
            session.link.read(|published| {
                let film = &published.film;
                values::show(&painter, &placement, film, settings.part, exposure);
            });
        }
        if let Pictures::Wipe(..) = pictures {
            wipe::show(ui, rect, &placement, session, settings);
        }
        caption::show(&painter, rect, session, settings, &p);
        if settings.is_false_colour || settings.is_difference {
            legend::show(&painter, rect, settings, &p);
        }
        response.hover_pos()
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let fraction = stage.placement.as_ref()?.fraction(at)?;
        Some(stage.session.link.read(|published| {
            let divisor = published.divisor.max(1);
            Reading::of_film(&published.film, stage.settings.part, fraction, divisor)
        }))
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        if !session.picture.is_there() {
            return None;
        }
        let image = session.link.read(|published| {
            let film = &published.film;
            let mut pixels = vec![Rgb::BLACK; film.width() * film.height()];
            film.compose(settings.part, &mut pixels);
            Image {
                width: film.width(),
                height: film.height(),
                pixels,
                ..Image::default()
            }
        });
        let display = settings.display();
        Some(Shown {
            name: settings.part.to_string(),
            pixels: Box::new(move || Pixels8::of(&image, &display)),
        })
    }
}

/// Places the film on the stage, and lets the pointer act on it and on the camera; `name` is for
/// whoever does not see it. Yields what the pointer does, and where the film stands.
pub(super) fn take_pointer(ui: &Ui, stage: &mut Stage<'_>, name: &str) -> (Response, Placement) {
    let rect = stage.rect;
    let size = shown_size(stage.session);
    let place = |ui: &Ui, settings: &ViewSettings| {
        Placement::new(rect, ui.pixels_per_point(), size, settings)
    };
    let placement = place(ui, stage.settings);
    let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
    hand::take_pointer(ui, &response, &placement, stage);
    // The pointer may just have moved the picture.
    let placement = place(ui, stage.settings);
    *stage.placement = Some(placement);
    (response, placement)
}

/// What stands where no picture is yet: what is being done, and a bar of how far it is.
fn show_waiting(ui: &Ui, stage: &Stage<'_>) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    let rect = stage.rect;
    let text = match (stage.opening, &stage.session.setup.open) {
        (Some(progress), _) => {
            let bar = Rect::from_center_size(
                rect.center() + egui::vec2(0.0, 3.0 * GRID),
                egui::vec2(30.0 * GRID, 3.0),
            );
            let mut done = bar;
            done.set_width(bar.width() * progress.share());
            painter.rect_filled(bar, 0, p.line);
            painter.rect_filled(done, 0, p.fill);
            progress.step().what()
        }
        (None, Some(_)) => "starting",
        (None, None) => "no scene",
    };
    let at = rect.center();
    painter.text(at, Align2::CENTER_CENTER, text, theme::body(), p.weak);
}

/// Fills what the picture leaves of the stage.
pub(super) fn fill_around(ui: &Ui, rect: Rect, covered: Rect, color: Color32) {
    if !covered.is_positive() {
        ground::fill(ui, rect, color);
        return;
    }
    let (a, b) = (covered.min, covered.max);
    for part in [
        Rect::from_min_max(rect.min, pos2(rect.right(), a.y)),
        Rect::from_min_max(pos2(rect.left(), b.y), rect.max),
        Rect::from_min_max(pos2(rect.left(), a.y), pos2(a.x, b.y)),
        Rect::from_min_max(pos2(b.x, a.y), pos2(rect.right(), b.y)),
    ] {
        if part.is_positive() {
            ground::fill(ui, part, color);
        }
    }
}

/// Size at which the film stands on the screen: what was asked for, or, while the picture is of
/// something older, its own.
fn shown_size(session: &Session) -> (usize, usize) {
    if session.is_current()
        && session.setup.size != (0, 0)
        && let Some(job) = session.link.started()
    {
        return (job.settings.width, job.settings.height);
    }
    let (w, h) = session.picture.size;
    (w * session.picture.divisor, h * session.picture.divisor)
}

fn pictures(session: &Session, settings: &ViewSettings) -> Pictures {
    let picture = &session.picture;
    if settings.is_difference && picture.reference.is_some() {
        Pictures::Difference(Slot::Live, Slot::Reference)
    } else if settings.is_wiping && picture.held[0].is_some() {
        let right = if picture.held[1].is_some() {
            Slot::HeldB
        } else {
            Slot::Live
        };
        Pictures::Wipe(Slot::HeldA, right)
    } else {
        Pictures::One(Slot::Live)
    }
}
