//! The list of layers: expressions, then lights with their sliders.

use egui::{Align2, Color32, FontId, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo, pos2};
use neumann_core::expression::{Expression, PRESETS};
use neumann_core::film::PathClasses;
use neumann_core::radiometry::Rgb;
use neumann_picture::inspection::percent;

use super::LayersView;
use crate::display::layers::{LayerSettings, ShownLayer};
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{
    Slider, button, button_width, cut_line, focus_ring, heading, hint, hue_row, paragraph, rule,
    settled, text_field,
};

/// Height of a row with its picture.
const ROW: f32 = 46.0;
/// Brightness, at most.
const BRIGHTEST: f64 = 8.0;

pub(super) fn contents(
    ui: &mut Ui,
    view: &mut LayersView,
    session: &Session,
    settings: &mut LayerSettings,
) {
    heading(ui, "Light path expressions");
    expressions(ui, view, settings);
    add_field(ui, view, session, settings);
    rule(ui);
    heading(ui, "Lights");
    lights(ui, view, settings);
}

fn expressions(ui: &mut Ui, view: &LayersView, settings: &mut LayerSettings) {
    let mut removed = None;
    for (i, text) in settings.expressions.iter().enumerate() {
        let which = ShownLayer::Expression(i);
        let read = view
            .asked
            .as_ref()
            .and_then(|asked| asked.expressions.get(i));
        let named = match read {
            Some(Ok(number)) => view.asked.as_ref().and_then(|asked| {
                let expression = asked.classes.expressions.get(*number)?;
                Some((expression.name().to_owned(), expression.text().to_owned()))
            }),
            _ => None,
        };
        let (name, remark) = named.unwrap_or_else(|| (text.clone(), String::new()));
        let remark = if remark == name {
            String::new()
        } else {
            remark
        };
        let is_chosen = settings.shown == which;
        let about = "Shows the paths of this expression alone, whatever term is chosen.";
        if row(ui, view, which, (&name, &remark), is_chosen, about).clicked() {
            settings.shown = which;
        }
        if let Some(Err(error)) = read {
            paragraph(ui, error);
        }
        if is_chosen {
            let about = "Takes the expression from the list. (Delete)";
            let is_pressed = ui.memory(|memory| memory.focused().is_none())
                && ui.input(|input| input.key_pressed(egui::Key::Delete));
            let button = button(ui, "Remove expression").on_hover_text(about);
            if button.clicked() || is_pressed {
                removed = Some(i);
            }
        }
    }
    if let Some(i) = removed {
        settings.expressions.remove(i);
        settings.shown = match settings.expressions.len() {
            0 => ShownLayer::Mix,
            n => ShownLayer::Expression(i.min(n - 1)),
        };
    }
}

/// A field for another expression, and those that have names.
fn add_field(ui: &mut Ui, view: &mut LayersView, session: &Session, settings: &mut LayerSettings) {
    let mut added = None;
    ui.horizontal(|ui| {
        let room = ui.available_width() - button_width(ui, "Add") - button_width(ui, "Kinds");
        ui.scope(|ui| {
            ui.set_width((room - 2.0 * GRID).max(6.0 * GRID));
            let field = text_field(ui, "glints = L S+ D E", &mut view.field).on_hover_text(
                "A light path expression, with a name before it if you like: L is the light, E \
                 the eye; D, G, S are diffuse, glossy and specular bounces, . any of them; * + ? \
                 say how often.",
            );
            let enters = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if enters {
                added = Some(view.field.clone());
            }
        });
        let about = "Keeps the paths of this expression apart, too.";
        if button(ui, "Add").on_hover_text(about).clicked() {
            added = Some(view.field.clone());
        }
        ui.menu_button("Kinds", |ui| {
            for (name, text) in PRESETS {
                let about = "Keeps paths of this kind apart, too.";
                let entry = ui.button(format!("{name}   {text}"));
                if entry.on_hover_text(about).clicked() {
                    added = Some(name.to_owned());
                    ui.close();
                }
            }
        })
        .response
        .on_hover_text("Kinds of paths that are worth a name.");
    });
    if let Some(text) = added.filter(|text| !text.trim().is_empty()) {
        view.complaint = add(&text, session, settings).err();
        if view.complaint.is_none() {
            view.field.clear();
        }
    }
    if let Some(complaint) = &view.complaint {
        paragraph(ui, complaint);
    }
}

/// Adds an expression to the list, and shows it.
fn add(text: &str, session: &Session, settings: &mut LayerSettings) -> Result<(), String> {
    let job = session.link.started().ok_or("There is no scene yet.")?;
    let of = |text: &String| Expression::new(text, &job.scene);
    let new = of(&text.to_owned()).map_err(|error| error.to_string())?;
    let mut all: Vec<Expression> = settings.expressions.iter().flat_map(of).collect();
    if let Some(at) = all.iter().position(|e| e.to_string() == new.to_string()) {
        settings.shown = ShownLayer::Expression(at);
        return Ok(());
    }
    let name = new.to_string();
    all.push(new);
    let classes = PathClasses {
        expressions: all,
        ..PathClasses::default()
    };
    classes.check().map_err(|error| error.to_string())?;
    settings.expressions.push(name);
    settings.shown = ShownLayer::Expression(settings.expressions.len() - 1);
    Ok(())
}

fn lights(ui: &mut Ui, view: &LayersView, settings: &mut LayerSettings) {
    let about = "All light, each source with its brightness and colour below, of the term that is \
                 chosen.";
    let is_chosen = settings.shown == ShownLayer::Mix;
    let name = ("All light, mixed", "");
    if row(ui, view, ShownLayer::Mix, name, is_chosen, about).clicked() {
        settings.shown = ShownLayer::Mix;
    }
    if settled(ui, "mixed", !settings.mix.is_empty()) {
        let about = "Gives every light its brightness and colour back.";
        if button(ui, "As rendered").on_hover_text(about).clicked() {
            settings.mix.clear();
        }
    }
    let Some(film) = &view.film else {
        hint(ui, "Keeping the light of each source apart …");
        return;
    };
    for (group, name) in film.group_names().enumerate() {
        if !film.is_lit(group) {
            continue;
        }
        let which = ShownLayer::Light(group);
        let about = "Shows the light of this source alone, of the term that is chosen.";
        let is_chosen = settings.shown == which;
        if row(ui, view, which, (name, ""), is_chosen, about).clicked() {
            settings.shown = which;
        }
        ui.push_id(("light", group), |ui| mix(ui, name, settings));
    }
    let field = text_field(ui, "Groups: each, or key=lamp,candle", &mut settings.lights);
    field.on_hover_text(
        "Which lights are taken as one: 'each' for none, or groups by name, such as \
         key=lamp,candle;sky=environment. Lights in no group are others.",
    );
    if let Some(complaint) = view
        .asked
        .as_ref()
        .and_then(|asked| asked.complaint.as_ref())
    {
        paragraph(ui, complaint);
    }
}

/// Brightness and colour of a light.
fn mix(ui: &mut Ui, name: &str, settings: &mut LayerSettings) {
    let mut factor = settings.factor(name);
    let strength = f64::from(factor.max_channel());
    let mut brightness = strength;
    let slider = Slider::new("Brightness", 0.0, BRIGHTEST)
        .unit("×")
        .default(1.0)
        .about("Factor on the light of this source. Nothing is rendered anew.");
    let is_dragged = slider.show(ui, &mut brightness).changed();
    if is_dragged {
        factor = if strength > 0.0 {
            factor * (brightness / strength) as f32
        } else {
            Rgb::splat(brightness as f32)
        };
    }
    let about = "Colour of the light of this source. Nothing is rendered anew.";
    let is_coloured = hue_row(ui, "Colour", name, &mut factor, about);
    if !(is_dragged || is_coloured) {
        return;
    }
    if factor == Rgb::WHITE {
        settings.mix.remove(name);
    } else {
        settings.mix.insert(name.to_owned(), factor);
    }
}

/// A layer of the list: its picture, its name with a remark below, and its share.
fn row(
    ui: &mut Ui,
    view: &LayersView,
    which: ShownLayer,
    (name, remark): (&str, &str),
    is_chosen: bool,
    about: &str,
) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let wide = rect.expand2(Vec2::new(GRID / 2.0, 0.0));
    if is_chosen || response.hovered() {
        let fill = if is_chosen { p.chosen } else { p.raised };
        ui.painter().rect_filled(wide, 4, fill);
    }
    let painter = ui.painter_at(wide);
    let frame = Rect::from_min_size(rect.min + Vec2::splat(3.0), Vec2::new(56.0, ROW - 6.0));
    painter.rect_filled(frame, 2, Color32::BLACK);
    let small = view.small(which);
    if let Some(small) = small {
        let height = frame.height().min(frame.width() / small.aspect);
        let size = Vec2::new(height * small.aspect, height);
        let place = Rect::from_center_size(frame.center(), size);
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(small.texture.id(), place, whole, Color32::WHITE);
    }
    let share = small.map_or_else(String::new, |small| percent(small.share));
    let figure = painter.layout_no_wrap(share.clone(), theme::small(), p.weak);
    let right = rect.right() - figure.size().x;
    let at = pos2(right, rect.center().y - 0.5 * figure.size().y);
    painter.galley(at, figure, p.weak);
    let left = frame.right() + GRID;
    let line = |align: Align2, y: f32, text: &str, font: FontId, color: Color32| {
        let text = cut_line(&painter, text.to_owned(), font, color, right - GRID - left);
        let at = align.anchor_size(pos2(left, y), text.size());
        painter.galley(at.min, text, color);
    };
    let middle = rect.center().y;
    if remark.is_empty() {
        line(Align2::LEFT_CENTER, middle, name, theme::body(), p.text);
    } else {
        line(
            Align2::LEFT_BOTTOM,
            middle - 1.0,
            name,
            theme::body(),
            p.text,
        );
        line(
            Align2::LEFT_TOP,
            middle + 2.0,
            remark,
            theme::small(),
            p.weak,
        );
    }
    focus_ring(ui, &response, wide, 4);
    let spoken = format!("{name}, {share}");
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, &spoken));
    if is_chosen && view.reveals {
        response.scroll_to_me(Some(egui::Align::Center));
    }
    response.on_hover_text(format!("{name}\n{about}"))
}
