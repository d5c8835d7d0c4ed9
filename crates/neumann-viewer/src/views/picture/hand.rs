//! The hand on the camera: what the pointer does on the picture.

use egui::{CursorIcon, PointerButton, Pos2, Response, Ui, Vec2};
use glam::Vec2 as Plane;
use neumann_core::transport::Tracer;

use crate::display::image_area::{self, Placement};
use crate::pick;
use crate::views::Stage;

/// Moves camera and picture as the pointer asks.
pub(super) fn take_pointer(
    ui: &Ui,
    response: &Response,
    placement: &Placement,
    stage: &mut Stage<'_>,
) {
    let ctx = ui.ctx();
    let (modifiers, magnify) = ctx.input(|i| (i.modifiers, i.zoom_delta()));
    let pointer = response.hover_pos();
    if let Some(at) = pointer
        && (magnify - 1.0).abs() > 1e-3
    {
        let anchor = placement.fraction(at).unwrap_or([0.5, 0.5]);
        image_area::zoom(stage.settings, placement, magnify, anchor);
        return;
    }
    if stage.settings.drawing.is_some() {
        draw_region(ui, response, placement, stage);
        return;
    }
    if response.double_clicked() {
        stage.settings.zoom = None;
    }
    if response.clicked() && modifiers.command {
        focus_at(response.interact_pointer_pos(), placement, stage);
        return;
    }
    if response.clicked() && modifiers.shift {
        let at = response.interact_pointer_pos();
        let fraction = at.and_then(|at| placement.fraction(at));
        stage.picked = fraction.and_then(|f| pick::at(&stage.session.setup, placement, f));
        return;
    }
    let drag = response.drag_delta();
    if response.dragged_by(PointerButton::Secondary) {
        let moved = drag / placement.film.size();
        let center = &mut stage.settings.center;
        *center = [
            (center[0] - moved.x).clamp(0.0, 1.0),
            (center[1] - moved.y).clamp(0.0, 1.0),
        ];
        return;
    }
    let setup = &mut stage.session.setup;
    let Some(control) = &mut setup.camera else {
        return;
    };
    let unit = stage.rect.height().max(1.0);
    let is_panning = response.dragged_by(PointerButton::Middle)
        || (response.dragged_by(PointerButton::Primary) && modifiers.shift);
    if is_panning && drag != Vec2::ZERO {
        let height = placement.film.height().max(1.0);
        control.pan(Plane::new(drag.x, drag.y) / height);
        setup.is_changed = true;
        ctx.set_cursor_icon(CursorIcon::Move);
    } else if response.dragged_by(PointerButton::Primary) && drag != Vec2::ZERO {
        control.orbit(Plane::new(drag.x, drag.y) * (std::f32::consts::PI / unit));
        setup.is_changed = true;
        ctx.set_cursor_icon(CursorIcon::Grabbing);
    }
    let wheel = ctx.input(|i| i.smooth_scroll_delta().y);
    if pointer.is_some() && wheel.abs() > 0.0 {
        control.dolly((-wheel * 0.002).exp());
        setup.is_changed = true;
    }
}

/// Draws the rectangle of a region; it is rendered alone once the pointer lets go.
fn draw_region(ui: &Ui, response: &Response, placement: &Placement, stage: &mut Stage<'_>) {
    let ctx = ui.ctx();
    if response.hovered() || response.dragged() {
        ctx.set_cursor_icon(CursorIcon::Crosshair);
    }
    let share = |at: Pos2| <[f32; 2]>::from((at - placement.film.min) / placement.film.size());
    let Some(drawing) = &mut stage.settings.drawing else {
        return;
    };
    if response.drag_started_by(PointerButton::Primary) {
        let pressed = ctx.input(|i| i.pointer.press_origin());
        drawing.corners = pressed.map(|at| [share(at); 2]);
    }
    if let (Some(corners), Some(at)) = (&mut drawing.corners, response.interact_pointer_pos()) {
        corners[1] = share(at);
    }
    if response.drag_stopped_by(PointerButton::Primary) {
        let setup = &mut stage.session.setup;
        if let Some(region) = drawing.region(setup.size) {
            setup.choose_region(Some(region));
            stage.settings.drawing = None;
        } else {
            drawing.corners = None;
        }
        ctx.request_repaint();
    }
}

/// Focuses the lens on what is seen at a place of the screen.
fn focus_at(at: Option<Pos2>, placement: &Placement, stage: &mut Stage<'_>) {
    let setup = &mut stage.session.setup;
    let fraction = at.and_then(|at| placement.fraction(at));
    let sight = fraction.and_then(|fraction| pick::sight(setup, placement, fraction));
    let (Some((camera, ray)), Some(open), Some(control)) = (sight, &setup.open, &mut setup.camera)
    else {
        return;
    };
    let Some(vertex) = Tracer::new(&open.scene).vertex(&ray) else {
        stage.notices.failure("Nothing to focus on there");
        return;
    };
    let mut lens = control.lens();
    lens.focus_distance = (vertex.point.position - camera.position()).dot(camera.forward());
    if lens.aperture <= 0.0 {
        // A pinhole has no focus; give it a lens that shows it.
        lens.aperture = 0.02 * lens.focus_distance;
    }
    control.set_lens(lens);
    setup.is_changed = true;
}
