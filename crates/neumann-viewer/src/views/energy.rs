//! The series as a quantity: what each term is worth on a logarithmic axis, with its error, and how
//! the terms decay.

use egui::{
    Align2, Color32, Key, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2,
};
use neumann_core::film::View as Part;
use neumann_picture::energy::{Chart, DEVIATIONS, Energy, Ink, Line, TermEnergy};
use neumann_picture::figures::significant;
use neumann_picture::png_file::Pixels8;
use neumann_picture::sheet::{self, PictureSheet, picture_sheet};

use super::{Needs, Row, Shown, Stage, View};
use crate::display::{ViewSettings, ground};
use crate::formula::Formula;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::focus_ring;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Energy of the terms",
    about: "What each bounce is worth, and how fast that decays",
    key: Some(keys::line(
        keys::DISPLAY,
        "J",
        "energy of the terms, in a chart",
        &[keys::on(keys::NONE, Key::J, Action::View(ID))],
    )),
    needs: Needs::NOTHING,
    refusal: |_| None,
    build: || Box::new(EnergyView::default()),
};

const ID: &str = "energy";
/// Size of the chart that is saved, pixels.
const SAVED: [usize; 2] = [960, 480];

/// The chart: what was read of the film last.
#[derive(Default)]
pub struct EnergyView {
    /// The terms and their decay; `None` before there is a picture.
    pub energy: Option<Energy>,
    read: Option<u64>,
}

impl View for EnergyView {
    fn close(&mut self) {
        *self = Self::default();
    }

    fn attend(&mut self, session: &Session, _settings: &ViewSettings) -> bool {
        let picture = &session.picture;
        if picture.is_there() && self.read != Some(picture.version) {
            self.read = Some(picture.version);
            let n_pixels = picture.size.0 * picture.size.1;
            let job = session.link.started();
            let max_bounces = job.map_or(u32::MAX, |job| job.settings.max_bounces);
            let (shares, errors) = (&picture.shares, &picture.layer_errors);
            self.energy = Some(Energy::of(shares, errors, n_pixels, max_bounces));
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let rect = stage.rect;
        ground::fill(ui, rect, p.ground);
        let energy = self.energy.as_ref();
        let Some(energy) = energy.filter(|energy| Chart::new(energy, [1.0; 2]).is_some()) else {
            let text = "no light yet …";
            let painter = ui.painter();
            painter.text(
                rect.center(),
                Align2::CENTER_CENTER,
                text,
                theme::body(),
                p.weak,
            );
            return None;
        };
        let left = rect.left() + 2.0 * GRID;
        let room = rect.width() - 4.0 * GRID;
        let painter = ui.painter().with_clip_rect(rect);
        let title = "What each term is worth, as a share of L";
        let title = painter.layout(title.to_owned(), theme::semibold(), p.text, room);
        let said = painter.layout(energy.sentence(), theme::body(), p.weak, room);
        let mut top = rect.top() + 1.5 * GRID;
        for galley in [title, said] {
            let height = galley.size().y;
            painter.galley(pos2(left, top), galley, p.text);
            top += height + 2.0;
        }
        let plot = Rect::from_min_max(
            pos2(left + 6.0 * GRID, top + GRID),
            rect.max - vec2(2.0 * GRID, 4.0 * GRID),
        );
        if plot.height() < 40.0 || plot.width() < 80.0 {
            return None;
        }
        let chart = Chart::new(energy, plot.size().into())?;
        painter.rect_filled(plot, 2, p.panel);
        axis(ui, plot, &chart, &p);
        for line in chart.lines() {
            paint(ui, plot, &line, &p);
        }
        names(ui, plot, &chart, stage.settings, &p);
        None
    }

    fn image(&self, session: &Session, _settings: &ViewSettings) -> Option<Shown> {
        let energy = self.energy.as_ref()?;
        let p = Palette::of_theme(true);
        let [width, height] = SAVED;
        let chart = Chart::new(energy, [width as f32, height as f32])?;
        let lines = chart.grid().chain(chart.lines());
        let strokes = lines.flat_map(|line| strokes(&line, &p)).collect();
        let metadata = session.metadata()?;
        let mut lines = vec![energy.sentence()];
        lines.extend(energy.terms.iter().map(words));
        let ground = [p.panel.r(), p.panel.g(), p.panel.b()];
        Some(Shown {
            name: "energy".to_owned(),
            pixels: Box::new(move || {
                picture_sheet(&PictureSheet {
                    heading: [metadata.scene.clone(), metadata.summary()],
                    picture: Pixels8 {
                        width,
                        height,
                        pixels: vec![ground; width * height],
                    },
                    wipe: None,
                    strokes,
                    scale: None,
                    lines,
                })
            }),
        })
    }
}

/// A term in words.
fn words(term: &TermEnergy) -> String {
    let percent = |share: f64, figures| significant(100.0 * share, figures);
    let error = term.error.map_or_else(
        || "error not known".to_owned(),
        |error| format!("± {} %", percent(DEVIATIONS * error, 2)),
    );
    format!("{}  {} %  {error}", term.part, percent(term.share, 4))
}

/// The colour of what is drawn.
fn color(ink: Ink, p: &Palette) -> Color32 {
    match ink {
        Ink::Grid => p.line,
        Ink::Bar => p.fill,
        Ink::Tail => p.chosen,
        Ink::Interval => p.strong,
        Ink::Fit => p.amber,
    }
}

/// Dash and gap of the fit.
const DASHES: [f32; 2] = [7.0, 5.0];

/// Draws a line into a plot.
fn paint(ui: &Ui, plot: Rect, line: &Line, p: &Palette) {
    let stroke = Stroke::new(line.width, color(line.ink, p));
    let ends = line.ends.map(|[x, y]| plot.min + vec2(x, y));
    if line.ink == Ink::Fit {
        let [dash, gap] = DASHES;
        ui.painter()
            .extend(Shape::dashed_line(&ends, stroke, dash, gap));
    } else {
        ui.painter().line_segment(ends, stroke);
    }
}

/// A line as it is drawn on a sheet.
fn strokes(line: &Line, p: &Palette) -> Vec<sheet::Stroke> {
    let [r, g, b, _] = color(line.ink, p).to_array();
    let stroke = |ends, width| sheet::Stroke {
        ends,
        width,
        colour: [r, g, b],
        opacity: 1.0,
    };
    let [from, to] = line.ends;
    if matches!(line.ink, Ink::Bar | Ink::Tail) {
        // Strokes have round ends; a bar is many thin ones side by side.
        let n = line.width.max(1.0) as usize;
        let x = |i: usize| from[0] - 0.5 * line.width + i as f32 + 0.5;
        let thin = |i| stroke([[x(i), from[1]], [x(i), to[1]]], 1.0);
        return (0..n).map(thin).collect();
    }
    vec![stroke(line.ends, line.width)]
}

/// The axis: lines, and numbers beside them.
fn axis(ui: &Ui, plot: Rect, chart: &Chart<'_>, p: &Palette) {
    for line in chart.grid() {
        paint(ui, plot, &line, p);
    }
    for (y, text) in chart.labels() {
        let at = pos2(plot.left() - 6.0, plot.top() + y);
        ui.painter()
            .text(at, Align2::RIGHT_CENTER, text, theme::small(), p.weak);
    }
}

/// The names of the terms under their bars; a click shows one.
fn names(ui: &Ui, plot: Rect, chart: &Chart<'_>, settings: &mut ViewSettings, p: &Palette) {
    // Where bars are narrow, every second one is named, or every fourth.
    let step = (30.0 / chart.pitch()).ceil().max(1.0) as usize;
    let step = step.next_power_of_two();
    for (i, term) in chart.energy.terms.iter().enumerate() {
        let x = plot.left() + chart.x(i as f32);
        let column = Rect::from_min_max(
            pos2(x - 0.5 * chart.pitch(), plot.top()),
            pos2(x + 0.5 * chart.pitch(), plot.bottom() + 3.0 * GRID),
        );
        let id = ui.scope_id().with(("term", i));
        let response = ui.interact(column, id, Sense::click());
        let is_chosen = settings.part == term.part;
        if response.clicked() {
            settings.part = if is_chosen { Part::Total } else { term.part };
        }
        if i % step == 0 || term.part == Part::Tail {
            let color = if is_chosen { p.amber } else { p.text };
            let name = Formula::name(ui.painter(), term.part, theme::BODY, color);
            let at = pos2(x - 0.5 * name.size.x, plot.bottom() + 4.0);
            name.paint(ui.painter(), at);
        }
        focus_ring(ui, &response, column, 2);
        let spoken = words(term);
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, &spoken));
        response.on_hover_text(format!("{spoken}\nA click shows this term."));
    }
}
