//! The picture: a part of the film, with caption, pixel values, wipe, and the hand on the camera.

mod caption;
mod frame;
mod hand;
mod probed;
mod shown;
mod wipe;

use egui::{
    Align2, Color32, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, WidgetInfo, pos2,
};

pub use self::probed::read;
pub(super) use self::shown::image as shown_image;

use self::caption::Caption;
use super::{Needs, Row, Shown, Stage, View, plate};
use crate::compared::Compared;
use crate::display::image_area::{self, Pictures, Placement};
use crate::display::{Against, Slot, ViewSettings, ground, legend, values};
use crate::panels::Page;
use crate::probe::Reading;
use crate::region;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};

/// Its row.
pub static ROW: Row = Row {
    id: "picture",
    page: Page::Display,
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
        let compared = Compared::of(stage.session, stage.settings);
        let caption = Caption::of(stage.session, stage.settings, &compared);
        let size = compared.sides().map(|[a, _]| a.size);
        let size = size.unwrap_or_else(|| stage.session.shown_size());
        let (response, placement) = take_pointer(ui, stage, size, &caption.spoken());
        let session = &mut *stage.session;
        session.picture.compose(&session.link, stage.settings.part);
        if matches!(stage.settings.difference, Some(Against::Reference)) {
            session.picture.compose_reference(stage.settings.part);
        }
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
        let pictures = pictures(&compared);
        let painter = ui.painter().with_clip_rect(rect);
        let planes = &session.picture.planes;
        image_area::draw(&painter, &placement, settings, planes, pictures, 0);
        if placement.magnification > 16.0 && pictures == Pictures::One(Slot::Live) {
            let exposure = settings.exposure_ev.exp2();
            session.picture.read_film(&session.link, |film, _, region| {
                let place = region::rect(&placement, region.map(|(_, region)| region));
                values::show(
                    &painter,
                    place,
                    placement.visible,
                    film,
                    settings.part,
                    exposure,
                );
            });
        }
        if let Compared::Wipe(sides) = &compared {
            wipe::show(ui, rect, &placement, sides, settings);
        }
        frame::show(&painter, &placement, session, settings, &p);
        stage.caption = caption.show(&painter, rect, placement.visible.min, &p);
        let is_difference = matches!(compared, Compared::Difference(_));
        if settings.is_false_colour || is_difference {
            let area = plate::legend_area(rect, placement.visible.right());
            legend::show(&painter, area, &settings.scale(is_difference), &p);
        }
        response.hover_pos()
    }

    fn probe(&self, at: Pos2, stage: &Stage<'_>) -> Option<Reading> {
        let fraction = stage.placement.as_ref()?.fraction(at)?;
        Some(read(stage.session, stage.settings, fraction))
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let is_there = session.picture.is_there();
        is_there.then(|| shown::image(session, settings))
    }
}

/// Places a picture of `size` pixels on the stage, and lets the pointer act on it and on the
/// camera; `name` is for whoever does not see it. Yields what the pointer does, and where the
/// picture stands.
pub(super) fn take_pointer(
    ui: &Ui,
    stage: &mut Stage<'_>,
    size: (usize, usize),
    name: &str,
) -> (Response, Placement) {
    let rect = stage.rect;
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

/// `Shift` and an arrow: the pixel beside a chosen one, that way; `None` without a press.
fn stepped_pixel(ui: &Ui, from: [usize; 2], size: (usize, usize)) -> Option<[usize; 2]> {
    if ui.memory(|memory| memory.focused().is_some()) {
        return None;
    }
    let presses = |key| {
        let count =
            |input: &mut egui::InputState| input.count_and_consume_key(egui::Modifiers::SHIFT, key);
        ui.input_mut(count) as i64
    };
    let x = presses(egui::Key::ArrowRight) - presses(egui::Key::ArrowLeft);
    let y = presses(egui::Key::ArrowDown) - presses(egui::Key::ArrowUp);
    let step =
        |at: usize, by: i64, n: usize| (at as i64 + by).clamp(0, n.max(1) as i64 - 1) as usize;
    let is_pressed = (x, y) != (0, 0);
    is_pressed.then(|| [step(from[0], x, size.0), step(from[1], y, size.1)])
}

/// Draws the picture for a view that asks about one of its pixels, which `Shift` and arrows move
/// and a click chooses. Yields the pixel that is chosen now, and what the pointer does and where
/// the picture stands, once it is there.
pub(super) fn with_pixel(
    ui: &Ui,
    stage: &mut Stage<'_>,
    mut pixel: Option<[usize; 2]>,
    name: &str,
) -> (Option<[usize; 2]>, Option<(Response, Placement)>) {
    let size = stage.session.shown_size();
    pixel = pixel.map(|pixel| stepped_pixel(ui, pixel, size).unwrap_or(pixel));
    let (response, placement) = take_pointer(ui, stage, size, name);
    if response.clicked_by(PointerButton::Primary)
        && ui.input(|input| input.modifiers.is_none())
        && let Some(at) = response.interact_pointer_pos()
        && let Some(fraction) = placement.fraction(at)
    {
        pixel = Some(Placement::pixel(fraction, size).into());
    }
    let is_there = draw_live(ui, stage, &placement);
    (pixel, is_there.then_some((response, placement)))
}

/// Draws the picture as it is rendered. False if there is none yet.
pub(super) fn draw_live(ui: &Ui, stage: &mut Stage<'_>, placement: &Placement) -> bool {
    let (rect, session) = (stage.rect, &mut *stage.session);
    session.picture.compose(&session.link, stage.settings.part);
    let is_there = session.picture.is_there();
    let covered = if is_there {
        placement.visible
    } else {
        Rect::NOTHING
    };
    fill_around(ui, rect, covered, Palette::of(ui).ground);
    if is_there {
        let painter = ui.painter().with_clip_rect(rect);
        let planes = &session.picture.planes;
        let pictures = Pictures::One(Slot::Live);
        image_area::draw(&painter, placement, stage.settings, planes, pictures, 0);
    }
    is_there
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

fn pictures(compared: &Compared) -> Pictures {
    match compared {
        Compared::Wipe([a, b]) => Pictures::Wipe(a.slot, b.slot),
        Compared::Difference([a, b]) => Pictures::Difference(a.slot, b.slot),
        Compared::Nothing | Compared::Refused(_) => Pictures::One(Slot::Live),
    }
}
