//! The bar on top: scene, methods, and the commonest commands.

use egui::{
    Align, Align2, Area, Frame, Id, Layout, Margin, Order, Rect, Stroke, Ui, UiBuilder, Vec2, pos2,
};
use neumann_core::integrator::{METHODS, Method};

use crate::keys::Action;
use crate::panels::Page;
use crate::session::Session;
use crate::setup::Setup;
use crate::shell::Shell;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{Icon, icon_button, row_button, segmented_width, segments};

/// Draws the bar into `rect`.
pub fn show(ui: &mut Ui, rect: Rect, session: &mut Session, shell: &mut Shell) {
    let p = Palette::of(ui);
    theme::fill_panel(ui, rect);
    ui.painter()
        .hline(rect.x_range(), rect.bottom() - 0.5, (1.0, p.line));
    let inner = rect.shrink2(Vec2::new(GRID, 0.0));
    let icons = commands(ui, inner, session.link.is_paused(), shell);
    let scene = scene_button(ui, inner, &session.setup, &mut shell.page);
    let room = Rect::from_min_max(
        pos2(scene.right() + GRID, rect.top()),
        pos2(icons.left() - GRID, rect.bottom()),
    );
    methods(ui, rect, room, &mut session.setup, &mut shell.is_menu_open);
}

/// Draws the method alone into `rect`, for whoever sits far away.
pub fn present(ui: &mut Ui, rect: Rect, method: &Method, bias: Option<&str>) {
    let p = Palette::of(ui);
    theme::fill_panel(ui, rect);
    ui.painter()
        .hline(rect.x_range(), rect.bottom() - 0.5, (1.0, p.line));
    let painter = ui.painter_at(rect);
    let mut x = rect.left() + 2.0 * GRID;
    let mut write = |text: &str, font, color| {
        let galley = painter.layout_no_wrap(text.to_owned(), font, color);
        let at = pos2(x, rect.center().y - galley.size().y / 2.0);
        x += galley.size().x + 1.5 * GRID;
        painter.galley(at, galley, color);
    };
    write(method.name, theme::sized(PRESENTED), p.text);
    write(method.id, theme::sized(PRESENTED), p.weak);
    if bias.is_some() {
        write("biased", theme::sized(PRESENTED), p.amber);
    }
    let response = ui.interact(rect, ui.scope_id().with("method"), egui::Sense::hover());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Label, true, format!("method: {}", method.name))
    });
}

/// Size of the method's name when it is presented, points.
const PRESENTED: f32 = 18.0;

fn scene_button(ui: &mut Ui, rect: Rect, setup: &Setup, page: &mut Page) -> Rect {
    let p = Palette::of(ui);
    let name = setup
        .open
        .as_ref()
        .map_or("No scene", |open| open.short_name());
    let mut job =
        egui::text::LayoutJob::simple_singleline(name.to_owned(), theme::semibold(), p.text);
    job.wrap = egui::text::TextWrapping::truncate_at_width(160.0);
    let galley = ui.painter().layout_job(job);
    let size = Vec2::new(galley.size().x + 5.0 * GRID, 28.0);
    let spot = Rect::from_min_size(pos2(rect.left(), rect.center().y - size.y / 2.0), size);
    let response = ui.interact(spot, ui.scope_id().with("scene"), egui::Sense::click());
    if response.hovered() {
        ui.painter().rect_filled(spot, 4, p.hovered);
    }
    let at = pos2(spot.left() + GRID, spot.center().y - galley.size().y / 2.0);
    ui.painter().galley(at, galley, p.text);
    let tip = pos2(spot.right() - 1.75 * GRID, spot.center().y);
    Icon::Down.paint(ui.painter(), tip, p.weak);
    crate::widgets::focus_ring(ui, &response, spot, 4);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Button, true, format!("scene: {name}"))
    });
    if response.clicked() {
        *page = Page::Scene;
    }
    response.on_hover_text("The open scene. A click shows the Scene page, where others are.");
    spot
}

fn commands(ui: &mut Ui, rect: Rect, is_paused: bool, shell: &mut Shell) -> Rect {
    const N: f32 = 6.0;
    let width = N * 28.0 + (N - 1.0) * 4.0;
    let spot = Rect::from_min_max(pos2(rect.right() - width, rect.top()), rect.max);
    let pause = if is_paused {
        let about = "Goes on with the samples that are there.";
        (
            Icon::Play,
            "Resume rendering",
            "Space",
            about,
            Action::Pause,
        )
    } else {
        let about = "Keeps all samples; another press goes on with them.";
        (
            Icon::Pause,
            "Pause rendering",
            "Space",
            about,
            Action::Pause,
        )
    };
    let buttons = [
        pause,
        (
            Icon::Restart,
            "Restart rendering",
            "R",
            "Begins anew, without the samples so far.",
            Action::Restart,
        ),
        (
            Icon::Save,
            "Save picture",
            "Ctrl S",
            "Writes what is shown to a PNG file.",
            Action::SavePng,
        ),
        (
            Icon::Theme,
            "Change theme",
            "Ctrl T",
            "Changes between the light and the dark window.",
            Action::Theme,
        ),
        (
            Icon::Panel,
            "Hide panels",
            "Tab",
            "Leaves the window to the picture alone.",
            Action::Panels,
        ),
        (
            Icon::Help,
            "Show help",
            "?",
            "Shows what every key does.",
            Action::Help,
        ),
    ];
    let builder = UiBuilder::new()
        .max_rect(spot)
        .layout(Layout::left_to_right(Align::Center))
        .id_salt("commands");
    let mut chosen = None;
    ui.scope_builder(builder, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (icon, name, keys, about, action) in buttons {
            if icon_button(ui, icon, name, keys, about).clicked() {
                chosen = Some(action);
            }
        }
    });
    if let Some(action) = chosen {
        shell.act(ui.ctx(), action);
    }
    spot
}

fn methods(ui: &mut Ui, bar: Rect, room: Rect, setup: &mut Setup, is_menu_open: &mut bool) {
    let titles: Vec<&str> = METHODS.iter().map(|m| m.id).collect();
    let width = segmented_width(ui, &titles);
    if width <= room.width() {
        // In the middle of the window if it fits there, else in the middle of the room.
        let centered = bar.center().x - width / 2.0;
        let left = if centered >= room.left() && centered + width <= room.right() {
            centered
        } else {
            room.center().x - width / 2.0
        };
        let spot = Rect::from_min_size(
            pos2(left.round(), bar.center().y - 14.0),
            Vec2::new(width, 28.0),
        );
        let clicked = ui
            .scope_builder(UiBuilder::new().max_rect(spot).id_salt("methods"), |ui| {
                segments(ui, "method", &titles, about_method, setup.method)
            })
            .inner;
        if let Some(index) = clicked {
            setup.choose_method(index);
        }
        *is_menu_open = false;
        return;
    }
    menu(ui, room, setup, is_menu_open);
}

/// What the method of that number is, for whoever knows it by its id.
fn about_method(index: usize) -> String {
    let method = METHODS[index];
    format!("{}. {}", method.name, method.about)
}

/// Where there is no room for all methods in a row.
fn menu(ui: &mut Ui, room: Rect, setup: &mut Setup, is_open: &mut bool) {
    let p = Palette::of(ui);
    let title = setup.method().id;
    let spot = Rect::from_center_size(room.center(), Vec2::new(room.width().min(160.0), 28.0));
    let response = ui.interact(
        spot,
        ui.scope_id().with("method menu"),
        egui::Sense::click(),
    );
    let fill = if response.hovered() {
        p.hovered
    } else {
        p.raised
    };
    ui.painter().rect_filled(spot, 4, fill);
    let font = theme::body();
    ui.painter()
        .text(spot.center(), Align2::CENTER_CENTER, title, font, p.text);
    let tip = pos2(spot.right() - 2.0 * GRID, spot.center().y);
    Icon::Down.paint(ui.painter(), tip, p.weak);
    crate::widgets::focus_ring(ui, &response, spot, 4);
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::Role::Button, true, format!("method: {title}"))
    });
    if response.clicked() {
        *is_open = !*is_open;
    }
    let response = response.on_hover_text("The method. A click shows all of them.");
    if !*is_open {
        return;
    }
    let area = Area::new(Id::unique("methods"))
        .order(Order::Foreground)
        .fixed_pos(pos2(spot.center().x - 180.0, spot.bottom() + 4.0))
        .show(ui.ctx(), |ui| {
            Frame::new()
                .fill(p.panel)
                .stroke(Stroke::new(1.0, p.line))
                .corner_radius(6)
                .inner_margin(Margin::symmetric(16, 8))
                .show(ui, |ui| {
                    ui.set_width(328.0);
                    for (i, method) in METHODS.iter().enumerate() {
                        let is_chosen = i == setup.method;
                        let row = row_button(ui, method.id, method.name, is_chosen);
                        if row.on_hover_text(about_method(i)).clicked() {
                            setup.choose_method(i);
                            *is_open = false;
                        }
                    }
                });
        });
    if area.response.clicked_elsewhere() && !response.clicked() {
        *is_open = false;
    }
}
