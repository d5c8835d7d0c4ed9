//! The figures of a pixel, from top to bottom: a sentence, its bounces, its techniques, what single
//! iterations bring, its paths, and the vertices of the chosen one.

use egui::{Align2, Color32, Painter, Rect, Response, Role, Sense, Ui, Vec2, WidgetInfo, pos2};
use neumann_core::expression::PRESETS;
use neumann_core::film::View as Part;
use neumann_core::render::{Inspection, Job, Measured, Replayed};
use neumann_core::transport::{Lobe, PathVertex, VertexKind};
use neumann_picture::inspection::{self, percent};

use super::InspectView;
use super::drawing::hues;
use crate::display::ViewSettings;
use crate::formula::Formula;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::views::column;
use crate::views::techniques::{description, label};
use crate::widgets::{fact, focus_ring, fold, hint, paragraph, significant, text_field};

/// Height of a row of figures.
const ROW: f32 = 20.0;
/// Height of the distribution.
const PLOT: f32 = 64.0;
/// Rows of the list, at most.
const N_ROWS: usize = 200;

/// Draws the column into `rect`.
pub(super) fn show(
    ui: &mut Ui,
    rect: Rect,
    view: &mut InspectView,
    session: &Session,
    settings: &mut ViewSettings,
) {
    column::show(ui, rect, "inspector", |ui| {
        if let Some(job) = session.link.started() {
            ui.spacing_mut().item_spacing.y = 2.0;
            figures(ui, view, session, job, settings);
        }
    });
}

fn figures(
    ui: &mut Ui,
    view: &mut InspectView,
    session: &Session,
    job: &Job,
    settings: &mut ViewSettings,
) {
    let found = std::sync::Arc::clone(&view.found);
    let [x, y] = view.pixel.unwrap_or_default();
    let n = found.n_iterations();
    let of = if n == 1 {
        "1 iteration".to_owned()
    } else {
        format!("{n} iterations")
    };
    fact(ui, &format!("Pixel {x}, {y}"), &of);
    if job.pixel_of([x, y]).is_none() {
        paragraph(
            ui,
            "This pixel lies outside of the region that is rendered.",
        );
        return;
    }
    if n == 0 {
        paragraph(ui, "Walking its paths once more …");
        return;
    }
    let sentence = inspection::sentence(&found, &job.scene);
    let text = egui::RichText::new(sentence).font(theme::body());
    ui.add(egui::Label::new(text).wrap());
    bounces(ui, &found, settings);
    techniques(ui, view, &found);
    if fold(ui, "Single iterations", false) {
        distribution(ui, &found);
    }
    fireflies(ui, view, session);
    paths(ui, view, &found, job);
}

/// A share of the pixel as a bar with its interval, a name before it and a figure behind.
struct Bar<'a> {
    share: f64,
    /// Half the width of the interval, as a share.
    interval: f64,
    figure: String,
    spoken: String,
    is_chosen: bool,
    about: &'a str,
}

impl<'a> Bar<'a> {
    fn new(of: &Measured, total: f64, is_chosen: bool, name: &str, about: &'a str) -> Self {
        let share = f64::from(of.mean.luminance()) / total;
        let interval = of.interval.unwrap_or(0.0) / total;
        let figure = format!("{} ± {}", percent(share), percent(interval));
        Self {
            spoken: format!("{name}: {figure}"),
            figure,
            share,
            interval,
            is_chosen,
            about,
        }
    }

    fn show(self, ui: &mut Ui, name: impl FnOnce(&Painter, egui::Pos2, Color32)) -> Response {
        let p = Palette::of(ui);
        let size = Vec2::new(ui.available_width(), ROW);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let wide = rect.expand2(Vec2::new(GRID / 2.0, 0.0));
        if self.is_chosen || response.hovered() {
            let fill = if self.is_chosen { p.chosen } else { p.raised };
            ui.painter().rect_filled(wide, 4, fill);
        }
        let painter = ui.painter_at(wide);
        name(&painter, rect.left_center(), p.text);
        let figure = painter.layout_no_wrap(self.figure, theme::small(), p.weak);
        let track = Rect::from_min_max(
            pos2(rect.left() + 9.0 * GRID, rect.center().y - 3.0),
            pos2(rect.right() - 13.0 * GRID, rect.center().y + 3.0),
        );
        if track.width() > 2.0 * GRID {
            painter.rect_filled(track, 2, p.line);
            let at = |share: f64| track.left() + track.width() * share.clamp(0.0, 1.0) as f32;
            let done = Rect::from_min_max(track.min, pos2(at(self.share), track.bottom()));
            painter.rect_filled(done, 2, p.fill);
            let ends = [self.share - self.interval, self.share + self.interval].map(at);
            painter.hline(ends[0]..=ends[1], track.center().y, (1.5, p.text));
        }
        let at = pos2(
            rect.right() - figure.size().x,
            rect.center().y - 0.5 * figure.size().y,
        );
        painter.galley(at, figure, p.weak);
        focus_ring(ui, &response, wide, 4);
        let (is_chosen, spoken) = (self.is_chosen, self.spoken);
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, &spoken));
        response.on_hover_text(self.about)
    }
}

/// Bounce by bounce; a click chooses the term.
fn bounces(ui: &mut Ui, found: &Inspection, settings: &mut ViewSettings) {
    if !fold(ui, "Bounces", true) {
        return;
    }
    let total = f64::from(found.total().mean.luminance()).max(1e-30);
    for (k, of) in found.bounces().enumerate().filter(|(_, of)| of.n_paths > 0) {
        let part = Part::Term(k);
        let is_chosen = settings.part == part;
        let about = "The share of this bounce, with an interval that holds the truth 95 times of \
                     100. A click shows this term alone, and lists its paths.";
        let bar = Bar::new(&of, total, is_chosen, &part.to_string(), about);
        let name = |painter: &Painter, at: egui::Pos2, color: Color32| {
            let formula = Formula::name(painter, part, theme::BODY, color);
            let top = at - Vec2::new(0.0, 0.5 * formula.size.y);
            formula.paint(painter, top);
        };
        if bar.show(ui, name).clicked() {
            settings.part = if is_chosen { Part::Total } else { part };
        }
    }
}

/// Technique by technique; a click lists the paths of one.
fn techniques(ui: &mut Ui, view: &mut InspectView, found: &Inspection) {
    let total = f64::from(found.total().mean.luminance()).max(1e-30);
    if !fold(ui, "Techniques", false) {
        return;
    }
    for (strategy, of) in found.techniques() {
        let is_chosen = view.list.technique == Some(strategy);
        let name = label(strategy);
        let about = format!("{}. A click lists its paths alone.", description(strategy));
        let bar = Bar::new(&of, total, is_chosen, &name, &about);
        let paint = |painter: &Painter, at: egui::Pos2, color: Color32| {
            painter.text(at, Align2::LEFT_CENTER, &name, theme::small(), color);
        };
        if bar.show(ui, paint).clicked() {
            view.list.technique = (!is_chosen).then_some(strategy);
        }
    }
}

/// Pixels that stand out.
fn fireflies(ui: &mut Ui, view: &mut InspectView, session: &Session) {
    if fold(ui, "Fireflies", false)
        && let Some(pixel) = view.fireflies.show(ui, session, view.pixel)
    {
        view.inspect_firefly(pixel);
    }
}

/// How many iterations bring how much.
fn distribution(ui: &mut Ui, found: &Inspection) {
    let p = Palette::of(ui);
    let n = f64::from(found.n_iterations().max(1));
    let zeros = f64::from(found.n_zeros()) / n;
    let bins: Vec<_> = found.samples().collect();
    let size = Vec2::new(ui.available_width(), PLOT);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let largest = bins
        .iter()
        .map(|bin| bin.n)
        .max()
        .unwrap_or(1)
        .max(found.n_zeros())
        .max(1);
    let base = rect.bottom() - 16.0;
    let bar = |left: f32, width: f32, n: u32, color: Color32| {
        let height = (base - rect.top() - 2.0) * n as f32 / largest as f32;
        let area = Rect::from_min_max(
            pos2(left, base - height.max(if n > 0 { 1.0 } else { 0.0 })),
            pos2(left + (width - 1.0).max(1.0), base),
        );
        painter.rect_filled(area, 0, color);
    };
    // Zeros have no place on a logarithmic axis.
    let zero_width = 14.0;
    bar(rect.left(), zero_width, found.n_zeros(), p.amber);
    let left = rect.left() + zero_width + GRID;
    let pitch = (rect.right() - left) / bins.len().max(1) as f32;
    for (i, bin) in bins.iter().enumerate() {
        bar(left + i as f32 * pitch, pitch, bin.n, p.fill);
    }
    painter.hline(rect.x_range(), base, (1.0, p.line));
    let below = base + 2.0;
    let text = |x: f32, align: Align2, text: String| {
        painter.text(pos2(x, below), align, text, theme::sized(10.0), p.weak);
    };
    text(
        rect.left() + 0.5 * zero_width,
        Align2::CENTER_TOP,
        "0".to_owned(),
    );
    if let (Some(first), Some(last)) = (bins.first(), bins.last()) {
        text(left, Align2::LEFT_TOP, significant(first.range[0], 2));
        text(
            rect.right(),
            Align2::RIGHT_TOP,
            significant(last.range[1], 2),
        );
        text(
            0.5 * (left + rect.right()),
            Align2::CENTER_TOP,
            "luminance, log".to_owned(),
        );
    }
    let words = format!("{} of the iterations bring nothing", percent(zeros));
    response
        .widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("Distribution: {words}")));
    response.on_hover_text(format!(
        "How often a single iteration brings how much, on a logarithmic axis. {words}."
    ));
}

/// The paths that bring most, and the chosen one vertex by vertex.
fn paths(ui: &mut Ui, view: &mut InspectView, found: &Inspection, job: &Job) {
    if !fold(ui, "Paths", true) {
        return;
    }
    ui.horizontal(|ui| {
        let room = ui.available_width() - 64.0;
        ui.scope(|ui| {
            ui.set_width(room);
            text_field(ui, "Only: L S+ D E", &mut view.list.only).on_hover_text(
                "A light path expression: L is the light, E the eye; D, G, S are diffuse, glossy \
                 and specular bounces, . any of them; * + ? say how often. Empty for all paths.",
            );
        });
        ui.menu_button("Kinds", |ui| {
            for (name, text) in PRESETS {
                let button = ui.button(format!("{name}   {text}"));
                if button
                    .on_hover_text("Lists the paths of this kind alone.")
                    .clicked()
                {
                    text.clone_into(&mut view.list.only);
                    ui.close();
                }
            }
            let button = ui.button("all paths");
            if button.on_hover_text("Lists all paths.").clicked() {
                view.list.only.clear();
                ui.close();
            }
        })
        .response
        .on_hover_text("Kinds of paths that are worth a name.");
    });
    if let Some(error) = view.list.error() {
        paragraph(ui, &error.to_string());
    } else if let Some(share) = view.list.share() {
        hint(ui, &format!("{} of this pixel", percent(share)));
    }
    let total =
        f64::from(found.total().mean.luminance()).max(1e-30) * f64::from(found.n_iterations());
    let mut clicked = None;
    for (path, is_chosen) in view.list.rows(found).take(N_ROWS) {
        let response = row(ui, path, total, is_chosen);
        if is_chosen && view.list.reveals {
            response.scroll_to_me(Some(egui::Align::Center));
        }
        if response.clicked() {
            clicked = Some(path.clone());
        }
        if is_chosen {
            vertices(ui, &path.1, job, view.list.vertex);
        }
    }
    view.list.reveals = false;
    if let Some(path) = clicked {
        view.list.toggle(&path);
    }
    let n = found.n_paths();
    match view.list.len() {
        0 => paragraph(ui, "No path of this kind is among those that are kept."),
        listed if listed > N_ROWS => {
            hint(ui, &format!("{N_ROWS} of {listed} listed, of {n} in all"));
        }
        listed => hint(ui, &format!("{listed} listed, of {n} in all")),
    }
}

/// One path: its share, and what happens on it.
fn row(ui: &mut Ui, (iteration, path): &(u32, Replayed), total: f64, is_chosen: bool) -> Response {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let wide = rect.expand2(Vec2::new(GRID / 2.0, 0.0));
    if is_chosen || response.hovered() {
        let fill = if is_chosen { p.chosen } else { p.raised };
        ui.painter().rect_filled(wide, 4, fill);
    }
    let painter = ui.painter_at(rect);
    let share = percent(f64::from(path.value().luminance()) / total);
    let at = pos2(rect.left() + 6.5 * GRID, rect.center().y);
    painter.text(at, Align2::RIGHT_CENTER, &share, theme::small(), p.weak);
    let words = inspection::path(path);
    let font = theme::small();
    let mut job = egui::text::LayoutJob::simple_singleline(words.clone(), font, p.text);
    job.wrap = egui::text::TextWrapping::truncate_at_width(rect.right() - at.x - GRID);
    let galley = painter.layout_job(job);
    let top = pos2(at.x + GRID, rect.center().y - 0.5 * galley.size().y);
    painter.galley(top, galley, p.text);
    focus_ring(ui, &response, wide, 4);
    let spoken = format!("path {words}, {share}");
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, &spoken));
    let contribution = &path.contribution;
    response.on_hover_text(format!(
        "{words}\n{}, weight {}, iteration {iteration}",
        label(contribution.strategy),
        significant(f64::from(contribution.mis_weight), 3),
    ))
}

/// The vertices of the chosen path, from the eye to the light.
fn vertices(ui: &mut Ui, path: &Replayed, job: &Job, looked_at: usize) {
    let contribution = &path.contribution;
    let weight = significant(f64::from(contribution.mis_weight), 3);
    let value = path.value();
    let number = |v: f32| significant(f64::from(v), 3);
    let unweighted = (contribution.value * path.share).luminance();
    hint(
        ui,
        &format!("{} with weight {weight}", label(contribution.strategy)),
    );
    hint(
        ui,
        &format!(
            "{}  {}  {} W m⁻² sr⁻¹",
            number(value.r),
            number(value.g),
            number(value.b)
        ),
    );
    hint(
        ui,
        &format!("luminance {} without its weight", number(unweighted)),
    );
    paragraph(ui, &inspection::rarity(path, &job.scene));
    let n_eye = path.camera.len();
    let hues = hues(&Palette::of(ui));
    for (i, vertex) in path.vertices().into_iter().enumerate() {
        let hue = hues[usize::from(i >= n_eye)];
        line(ui, &title(vertex, job), hue, i == looked_at);
        if i == looked_at {
            for text in details(vertex) {
                detail(ui, &text);
            }
        }
    }
    ui.add_space(GRID / 2.0);
}

fn line(ui: &mut Ui, text: &str, hue: Color32, is_looked_at: bool) {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW - 2.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(rect);
    let center = rect.left_center() + Vec2::new(GRID, 0.0);
    painter.circle_filled(center, 3.5, hue);
    let color = if is_looked_at { p.text } else { p.weak };
    let at = center + Vec2::new(1.5 * GRID, 0.0);
    painter.text(at, Align2::LEFT_CENTER, text, theme::small(), color);
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

fn detail(ui: &mut Ui, text: &str) {
    let p = Palette::of(ui);
    let size = Vec2::new(ui.available_width(), ROW - 4.0);
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    let at = rect.left_center() + Vec2::new(2.5 * GRID, 0.0);
    let painter = ui.painter_at(rect);
    painter.text(at, Align2::LEFT_CENTER, text, theme::small(), p.weak);
    response.widget_info(|| WidgetInfo::labeled(Role::Label, true, text));
}

fn title(vertex: &PathVertex, job: &Job) -> String {
    match vertex.kind {
        VertexKind::Lens => "the eye".to_owned(),
        VertexKind::FarLight => "light from far away".to_owned(),
        VertexKind::Light | VertexKind::Surface => {
            let lobe = vertex.event.map(|event| event.lobe).or(vertex.lobe());
            let what = match (vertex.kind, lobe) {
                (VertexKind::Light, _) | (_, None) => "light",
                (_, Some(Lobe::Diffuse)) => "diffuse",
                (_, Some(Lobe::Glossy)) => "glossy",
                (_, Some(Lobe::Specular)) => "specular",
            };
            let through = vertex.event.is_some_and(|event| event.is_transmission);
            let through = if through { ", transmitted" } else { "" };
            match inspection::material(&job.scene, vertex.material) {
                Some(name) => format!("{what}{through}: {name}"),
                None => format!("{what}{through}"),
            }
        }
    }
}

/// What is known of a vertex.
fn details(vertex: &PathVertex) -> Vec<String> {
    let number = |v: f32| significant(f64::from(v), 4);
    let three = |v: [f32; 3]| v.map(number).join("  ");
    let mut lines = vec![
        format!("at {} m", three(vertex.position.to_array())),
        format!("throughput {}", three(vertex.throughput.to_array())),
    ];
    if let Some(event) = &vertex.event {
        lines.push(format!("f cos {}", three(event.f_cos.to_array())));
        let [pdf, reverse] = [event.pdf_w, event.pdf_w_reverse].map(number);
        lines.push(format!("density {pdf}, the other way {reverse} sr⁻¹"));
        if event.survival < 1.0 {
            lines.push(format!(
                "goes on with probability {}",
                number(event.survival)
            ));
        }
    }
    lines
}
