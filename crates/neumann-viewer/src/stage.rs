//! The picture and everything on it: caption, probe, pixel values, wipe, and the hand on the camera.

use egui::{
    Align2, Context, CursorIcon, Key, PointerButton, Pos2, Rect, Response, Role, Sense, Ui, Vec2,
    WidgetInfo, pos2,
};
use glam::{Vec2 as Plane, Vec3};
use neumann_core::endpoint::Camera;
use neumann_core::film::View;
use neumann_core::transport::Tracer;

use crate::app::App;
use crate::blind_spots;
use crate::display::image_area::{self, Pictures, Placement};
use crate::display::{Slot, ground, legend, values};
use crate::formula::Formula;
use crate::probe::Reading;
use crate::theme::{self, GRID, Palette};

/// Draw calls that the stage makes.
pub const N_DRAWS: usize = 1;

/// Draws the picture into `rect` and lets the pointer act on it.
pub fn show(ui: &mut Ui, rect: Rect, app: &mut App) {
    let p = Palette::of(ui);
    let size = shown_size(app);
    let placement = Placement::new(rect, ui.pixels_per_point(), size, &app.viewing.settings);
    let response = ui.interact(rect, ui.scope_id().with("picture"), Sense::click_and_drag());
    let caption = app.viewing.settings.part.caption();
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("picture: {caption}")));
    take_pointer(ui, &response, rect, &placement, app);
    // The pointer may just have moved the picture.
    let placement = Placement::new(rect, ui.pixels_per_point(), size, &app.viewing.settings);
    app.viewing.placement = Some(placement);
    app.session
        .picture
        .compose(&app.session.link, app.viewing.settings.part);
    let covered = if app.session.picture.is_there() {
        placement.visible
    } else {
        Rect::NOTHING
    };
    fill_around(ui, rect, covered, p.ground);
    if !app.session.picture.is_there() {
        show_waiting(ui, rect, app);
        return;
    }
    let pictures = pictures(app);
    let painter = ui.painter().with_clip_rect(rect);
    image_area::draw(
        &painter,
        &placement,
        &app.viewing.settings,
        &app.session.picture.planes,
        pictures,
        0,
    );
    if placement.magnification > 16.0 && pictures == Pictures::One(Slot::Live) {
        let exposure = app.viewing.settings.exposure_ev.exp2();
        app.session.link.read(|published| {
            values::show(
                &painter,
                &placement,
                &published.film,
                app.viewing.settings.part,
                exposure,
            );
        });
    }
    if let Pictures::Wipe(..) = pictures {
        wipe(ui, rect, &placement, app);
    }
    caption_of(&painter, rect, app, &p);
    probe(ui, rect, &response, &placement, app, &p);
    if app.viewing.settings.is_false_colour || app.viewing.settings.is_difference {
        legend::show(&painter, rect, &app.viewing.settings, &p);
    }
}

/// What stands where no picture is yet: what is being done, and a bar of how far it is.
fn show_waiting(ui: &Ui, rect: Rect, app: &App) {
    let p = Palette::of(ui);
    let painter = ui.painter();
    let text = match (app.loading(), &app.session.setup.open) {
        (Some(loading), _) => {
            let bar = Rect::from_center_size(
                rect.center() + egui::vec2(0.0, 3.0 * GRID),
                egui::vec2(30.0 * GRID, 3.0),
            );
            let mut done = bar;
            done.set_width(bar.width() * loading.progress.share());
            painter.rect_filled(bar, 0, p.line);
            painter.rect_filled(done, 0, p.fill);
            loading.progress.step().what()
        }
        (None, Some(_)) => "starting",
        (None, None) => "no scene",
    };
    let at = rect.center();
    painter.text(at, Align2::CENTER_CENTER, text, theme::body(), p.weak);
}

/// Fills what the picture leaves of the stage.
fn fill_around(ui: &Ui, rect: Rect, covered: Rect, color: egui::Color32) {
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

/// Moves the camera while keys for flying are held.
pub fn fly(ctx: &Context, app: &mut App) {
    if ctx.text_edit_focused() || app.session.setup.camera.is_none() {
        return;
    }
    let step = ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return Vec3::ZERO;
        }
        let held = |plus, minus| {
            // A press and its release within one frame count as a step too.
            let is_on = |key| i.key_down(key) || i.key_pressed(key);
            f32::from(i8::from(is_on(plus)) - i8::from(is_on(minus)))
        };
        let direction = Vec3::new(
            held(Key::D, Key::A),
            held(Key::PageUp, Key::PageDown),
            held(Key::W, Key::S),
        );
        let speed = if i.modifiers.shift { 2.0 } else { 0.5 };
        direction * speed * i.stable_dt.min(0.1)
    });
    if step == Vec3::ZERO {
        return;
    }
    if let Some(control) = &mut app.session.setup.camera {
        control.fly(step * control.radius());
        app.session.setup.is_changed = true;
        ctx.request_repaint();
    }
}

/// Size at which the film stands on the screen: what was asked for, or, while the
/// picture is of something older, its own.
fn shown_size(app: &App) -> (usize, usize) {
    if app.session.is_current()
        && app.session.setup.size != (0, 0)
        && app.session.link.started().is_some()
    {
        return app
            .session
            .link
            .started()
            .map_or(app.session.setup.size, |job| {
                (job.settings.width, job.settings.height)
            });
    }
    let (w, h) = app.session.picture.size;
    (
        w * app.session.picture.divisor,
        h * app.session.picture.divisor,
    )
}

fn pictures(app: &App) -> Pictures {
    if app.viewing.settings.is_difference && app.session.picture.reference.is_some() {
        Pictures::Difference(Slot::Live, Slot::Reference)
    } else if app.viewing.settings.is_wiping && app.session.picture.held[0].is_some() {
        let right = if app.session.picture.held[1].is_some() {
            Slot::HeldB
        } else {
            Slot::Live
        };
        Pictures::Wipe(Slot::HeldA, right)
    } else {
        Pictures::One(Slot::Live)
    }
}

fn take_pointer(ui: &Ui, response: &Response, rect: Rect, placement: &Placement, app: &mut App) {
    let ctx = ui.ctx();
    let (modifiers, magnify) = ctx.input(|i| (i.modifiers, i.zoom_delta()));
    let pointer = response.hover_pos();
    if let Some(at) = pointer
        && (magnify - 1.0).abs() > 1e-3
    {
        let anchor = placement.fraction(at).unwrap_or([0.5, 0.5]);
        image_area::zoom(&mut app.viewing.settings, placement, magnify, anchor);
        return;
    }
    if response.double_clicked() {
        app.viewing.settings.zoom = None;
    }
    if response.clicked() && modifiers.alt {
        focus_at(response.interact_pointer_pos(), placement, app);
        return;
    }
    let drag = response.drag_delta();
    if response.dragged_by(PointerButton::Secondary) {
        let moved = drag / placement.film.size();
        let center = &mut app.viewing.settings.center;
        *center = [
            (center[0] - moved.x).clamp(0.0, 1.0),
            (center[1] - moved.y).clamp(0.0, 1.0),
        ];
        return;
    }
    let Some(control) = &mut app.session.setup.camera else {
        return;
    };
    let unit = rect.height().max(1.0);
    let is_panning = response.dragged_by(PointerButton::Middle)
        || (response.dragged_by(PointerButton::Primary) && modifiers.shift);
    if is_panning && drag != Vec2::ZERO {
        let height = placement.film.height().max(1.0);
        control.pan(Plane::new(drag.x, drag.y) / height);
        app.session.setup.is_changed = true;
        ctx.set_cursor_icon(CursorIcon::Move);
    } else if response.dragged_by(PointerButton::Primary) && drag != Vec2::ZERO {
        control.orbit(Plane::new(drag.x, drag.y) * (std::f32::consts::PI / unit));
        app.session.setup.is_changed = true;
        ctx.set_cursor_icon(CursorIcon::Grabbing);
    }
    let wheel = ctx.input(|i| i.smooth_scroll_delta().y);
    if pointer.is_some() && wheel.abs() > 0.0 {
        control.dolly((-wheel * 0.002).exp());
        app.session.setup.is_changed = true;
    }
}

/// Focuses the lens on what is seen at a place of the screen.
fn focus_at(at: Option<Pos2>, placement: &Placement, app: &mut App) {
    let (Some(fraction), Some(open), Some(control)) = (
        at.and_then(|at| placement.fraction(at)),
        &app.session.setup.open,
        &mut app.session.setup.camera,
    ) else {
        return;
    };
    let (w, h) = placement.size;
    let camera = Camera::new(control.camera(), w, h);
    let raster = Plane::new(fraction[0] * w as f32, fraction[1] * h as f32);
    // The middle of the lens.
    let ray = camera.ray(raster, [0.5, 0.5]).ray;
    let Some(vertex) = Tracer::new(&open.scene).vertex(&ray) else {
        app.shell.notices.failure("Nothing to focus on there");
        return;
    };
    let mut lens = control.lens();
    lens.focus_distance = (vertex.point.position - camera.position()).dot(camera.forward());
    if lens.aperture <= 0.0 {
        // A pinhole has no focus; give it a lens that shows it.
        lens.aperture = 0.02 * lens.focus_distance;
    }
    control.set_lens(lens);
    app.session.setup.is_changed = true;
}

fn wipe(ui: &Ui, rect: Rect, placement: &Placement, app: &mut App) {
    let p = Palette::of(ui);
    let film = placement.film;
    let x = film.left() + film.width() * app.viewing.settings.wipe;
    let grip = Rect::from_min_max(
        pos2(x - 6.0, placement.visible.top()),
        pos2(x + 6.0, placement.visible.bottom()),
    );
    let response = ui
        .interact(grip, ui.scope_id().with("wipe"), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    response.widget_info(|| {
        WidgetInfo::slider(
            true,
            f64::from(app.viewing.settings.wipe),
            "wipe between A and B",
        )
    });
    if let Some(at) = response.interact_pointer_pos() {
        app.viewing.settings.wipe = ((at.x - film.left()) / film.width()).clamp(0.0, 1.0);
    }
    let painter = ui.painter().with_clip_rect(rect);
    painter.vline(x.round() + 0.5, grip.y_range(), (1.0, p.amber));
    let live = app.session.label(app.viewing.settings.part);
    let labels = [
        app.session.picture.held[0]
            .as_ref()
            .map_or("", |h| h.label.as_str()),
        app.session.picture.held[1]
            .as_ref()
            .map_or(live.as_str(), |h| h.label.as_str()),
    ];
    let y = placement.visible.bottom() - GRID;
    for (label, at, align) in [
        (
            format!("A  {}", labels[0]),
            pos2(x - GRID, y),
            Align2::RIGHT_BOTTOM,
        ),
        (
            format!("B  {}", labels[1]),
            pos2(x + GRID, y),
            Align2::LEFT_BOTTOM,
        ),
    ] {
        let galley = painter.layout_no_wrap(label, theme::small(), p.text);
        let spot = align.anchor_size(at, galley.size());
        painter.rect_filled(spot.expand2(Vec2::new(6.0, 3.0)), 4, plate(&p));
        painter.galley(spot.min, galley, p.text);
    }
}

/// Ground that lets text be read over any picture.
pub(crate) fn plate(p: &Palette) -> egui::Color32 {
    p.ground.gamma_multiply(0.78)
}

fn caption_of(painter: &egui::Painter, rect: Rect, app: &App, p: &Palette) {
    let view = app.viewing.settings.part;
    let (formula, text) =
        if app.viewing.settings.is_difference && app.session.picture.reference.is_some() {
            (None, "difference to the reference, in luminance".to_owned())
        } else if view.layers(app.session.picture.n_layers).is_none() {
            (
                Some(view),
                "not kept apart; raise the number of terms".to_owned(),
            )
        } else {
            (Some(view), view.caption())
        };
    let at = rect.min + Vec2::new(2.0 * GRID, 1.5 * GRID);
    let formula = formula.map(|view: View| Formula::full(painter, view, theme::CAPTION, p.text));
    let below = formula
        .as_ref()
        .map_or(0.0, |f| theme::CAPTION * 1.15 + f.size.y * 0.22);
    let galley = painter.layout_no_wrap(text, theme::body(), p.text);
    let note = blind_spots_of(app).map(|note| {
        let room = rect.width() - 6.0 * GRID;
        painter.layout(note, theme::small(), p.weak, room)
    });
    let width = formula
        .as_ref()
        .map_or(0.0, |f| f.size.x)
        .max(galley.size().x)
        .max(note.as_ref().map_or(0.0, |n| n.size().x));
    let note_top = below + galley.size().y + 2.0;
    let height = note
        .as_ref()
        .map_or(note_top - 2.0, |n| note_top + n.size().y);
    let spot = Rect::from_min_size(at, Vec2::new(width, height));
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, plate(p));
    if let Some(formula) = formula {
        formula.paint(painter, at);
    }
    painter.galley(at + Vec2::new(0.0, below), galley, p.text);
    if let Some(note) = note {
        painter.galley(at + Vec2::new(0.0, note_top), note, p.weak);
    }
}

/// What the method on screen cannot see of this view, if the picture is of it.
fn blind_spots_of(app: &App) -> Option<String> {
    let open = app.session.setup.open.as_ref()?;
    if app.viewing.settings.is_difference || !app.session.is_current() {
        return None;
    }
    let (view, n_layers) = (app.viewing.settings.part, app.session.picture.n_layers);
    blind_spots::note(
        app.session.setup.method().sight,
        open.scene.appearance(),
        view,
        n_layers,
    )
}

fn probe(ui: &Ui, rect: Rect, response: &Response, placement: &Placement, app: &App, p: &Palette) {
    let Some(fraction) = response.hover_pos().and_then(|at| placement.fraction(at)) else {
        return;
    };
    let reading = app.session.link.read(|published| {
        Reading::new(
            &published.film,
            app.viewing.settings.part,
            fraction,
            published.divisor.max(1),
        )
    });
    let painter = ui.painter().with_clip_rect(rect);
    let lines: Vec<_> = reading
        .lines()
        .into_iter()
        .map(|line| painter.layout_no_wrap(line, theme::small(), p.text))
        .collect();
    let width = lines.iter().map(|l| l.size().x).fold(152.0, f32::max);
    const LINE: f32 = 17.0;
    const BARS: f32 = 40.0;
    let corner = pos2(rect.right() - 2.0 * GRID, rect.top() + 1.5 * GRID);
    let height = lines.len() as f32 * LINE + BARS;
    let spot = Rect::from_min_max(
        pos2(corner.x - width, corner.y),
        pos2(corner.x, corner.y + height),
    );
    painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, plate(p));
    for (i, line) in lines.into_iter().enumerate() {
        let at = pos2(corner.x - line.size().x, corner.y + i as f32 * LINE);
        painter.galley(at, line, p.text);
    }
    bounce_bars(&painter, spot, &reading, app, p);
}

/// Luminance of each bounce at the pixel, as bars under the probe's numbers.
fn bounce_bars(painter: &egui::Painter, spot: Rect, reading: &Reading, app: &App, p: &Palette) {
    let n = reading.bounces.len().max(1);
    let largest = reading.bounces.iter().copied().fold(1e-20, f32::max);
    let area = Rect::from_min_max(
        pos2(spot.left(), spot.bottom() - 34.0),
        spot.max - Vec2::new(0.0, 10.0),
    );
    let pitch = area.width() / n as f32;
    let shown = app.viewing.settings.part.layers(n - 1).unwrap_or(0..0);
    for (k, value) in reading.bounces.iter().enumerate() {
        let height = (value / largest).clamp(0.0, 1.0) * area.height();
        let x = area.left() + k as f32 * pitch;
        let bar = Rect::from_min_max(
            pos2(x + 1.0, area.bottom() - height.max(1.0)),
            pos2(x + pitch - 1.0, area.bottom()),
        );
        let color = if shown.contains(&k) { p.amber } else { p.fill };
        painter.rect_filled(bar, 0, color);
        let name = if k + 1 == n {
            "t".to_owned()
        } else {
            k.to_string()
        };
        let at = pos2(bar.center().x, area.bottom() + 1.0);
        painter.text(at, Align2::CENTER_TOP, name, theme::sized(9.0), p.weak);
    }
}
