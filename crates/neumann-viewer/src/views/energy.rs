//! The series as a quantity: what each term is worth on a logarithmic axis, with its error, and how
//! the terms decay.

use egui::{Align2, Key, Pos2, Rect, Role, Sense, Shape, Stroke, Ui, WidgetInfo, pos2, vec2};
use neumann_core::film::View as Part;
use neumann_picture::axis::Axis;
use neumann_picture::energy::{Energy, TermEnergy};
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
/// Deviations of the interval that is drawn.
const DEVIATIONS: f64 = 1.96;
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
        let Some((energy, axis)) = self.energy.as_ref().and_then(with_axis) else {
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
        painter.rect_filled(plot, 2, p.panel);
        ticks(ui, plot, &axis, &p);
        let chart = Chart {
            energy,
            axis: &axis,
            plot,
        };
        for line in chart.lines() {
            line.paint(ui, &p);
        }
        names(ui, &chart, stage.settings, &p);
        None
    }

    fn image(&self, session: &Session, _settings: &ViewSettings) -> Option<Shown> {
        let (energy, axis) = self.energy.as_ref().and_then(with_axis)?;
        let p = Palette::of_theme(true);
        let [width, height] = SAVED;
        let plot = Rect::from_min_size(Pos2::ZERO, vec2(width as f32, height as f32));
        let chart = Chart {
            energy,
            axis: &axis,
            plot,
        };
        let grid = axis.ticks.iter().map(|tick| {
            let y = plot.bottom() - tick.at as f32 * plot.height();
            Line::new([pos2(0.0, y), pos2(plot.right(), y)], 1.0, Ink::Grid)
        });
        let strokes = grid
            .chain(chart.lines())
            .flat_map(|line| line.strokes(&p))
            .collect();
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

/// An axis that holds all terms of which something is known.
fn with_axis(energy: &Energy) -> Option<(&Energy, Axis)> {
    let shares = energy.terms.iter().map(|term| term.share);
    Some((energy, Axis::around(shares)?))
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

/// The terms as bars in a rectangle.
struct Chart<'a> {
    energy: &'a Energy,
    axis: &'a Axis,
    plot: Rect,
}

impl Chart<'_> {
    fn pitch(&self) -> f32 {
        self.plot.width() / self.energy.terms.len().max(1) as f32
    }

    /// The middle of a term's place.
    fn x(&self, term: f32) -> f32 {
        self.plot.left() + (term + 0.5) * self.pitch()
    }

    /// The height of a share, within the plot.
    fn y(&self, share: f64) -> f32 {
        let place = self.axis.place(share).unwrap_or(0.0).clamp(0.0, 1.0);
        self.plot.bottom() - place as f32 * self.plot.height()
    }

    /// Bars with their intervals, and the fit.
    fn lines(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        let base = self.plot.bottom();
        let half = (0.3 * self.pitch()).min(14.0);
        for (i, term) in self.energy.terms.iter().enumerate() {
            if term.share <= 0.0 {
                continue;
            }
            let (x, y) = (self.x(i as f32), self.y(term.share));
            // The tail is a sum of terms.
            let ink = if term.part == Part::Tail {
                Ink::Tail
            } else {
                Ink::Bar
            };
            lines.push(Line::new([pos2(x, base), pos2(x, y)], 2.0 * half, ink));
            if let Some(error) = term.error {
                let [low, high] = [-1.0, 1.0].map(|s| self.y(term.share + s * DEVIATIONS * error));
                lines.push(Line::new([pos2(x, low), pos2(x, high)], 1.5, Ink::Interval));
                for y in [low, high] {
                    let ends = [pos2(x - 4.0, y), pos2(x + 4.0, y)];
                    lines.push(Line::new(ends, 1.5, Ink::Interval));
                }
            }
        }
        if let Some(decay) = self.energy.decay {
            let at = |k: f32| pos2(self.x(k), self.y(decay.share(f64::from(k))));
            lines.push(Line::new(
                [at(decay.first as f32), at(decay.last as f32)],
                2.0,
                Ink::Fit,
            ));
        }
        lines
    }
}

/// What a line is drawn in.
#[derive(Clone, Copy, PartialEq)]
enum Ink {
    Grid,
    Bar,
    Tail,
    Interval,
    Fit,
}

impl Ink {
    fn color(self, p: &Palette) -> egui::Color32 {
        match self {
            Self::Grid => p.line,
            Self::Bar => p.fill,
            Self::Tail => p.chosen,
            Self::Interval => p.strong,
            Self::Fit => p.amber,
        }
    }
}

/// A line of the chart, on the screen and on a sheet.
struct Line {
    ends: [Pos2; 2],
    width: f32,
    ink: Ink,
}

/// Dash and gap of the fit.
const DASHES: [f32; 2] = [7.0, 5.0];

impl Line {
    fn new(ends: [Pos2; 2], width: f32, ink: Ink) -> Self {
        Self { ends, width, ink }
    }

    fn paint(&self, ui: &Ui, p: &Palette) {
        let stroke = Stroke::new(self.width, self.ink.color(p));
        if self.ink == Ink::Fit {
            let [dash, gap] = DASHES;
            ui.painter()
                .extend(Shape::dashed_line(&self.ends, stroke, dash, gap));
        } else {
            ui.painter().line_segment(self.ends, stroke);
        }
    }

    fn strokes(&self, p: &Palette) -> Vec<sheet::Stroke> {
        let [r, g, b, _] = self.ink.color(p).to_array();
        let stroke = |ends: [Pos2; 2], width| sheet::Stroke {
            ends: ends.map(|at| [at.x, at.y]),
            width,
            colour: [r, g, b],
            opacity: 1.0,
        };
        let [from, to] = self.ends;
        if matches!(self.ink, Ink::Bar | Ink::Tail) {
            // Strokes have round ends; a bar is many thin ones side by side.
            let n = self.width.max(1.0) as usize;
            let x = |i: usize| from.x - 0.5 * self.width + i as f32 + 0.5;
            let thin = |i| stroke([pos2(x(i), from.y), pos2(x(i), to.y)], 1.0);
            return (0..n).map(thin).collect();
        }
        vec![stroke(self.ends, self.width)]
    }
}

fn ticks(ui: &Ui, plot: Rect, axis: &Axis, p: &Palette) {
    let painter = ui.painter();
    let mut free = f32::INFINITY;
    for tick in &axis.ticks {
        let y = plot.bottom() - tick.at as f32 * plot.height();
        painter.hline(plot.x_range(), y, (1.0, p.line));
        if y + 6.0 < free && !tick.label.is_empty() {
            free = y - 8.0;
            let share: f64 = tick.label.parse().unwrap_or_default();
            let text = format!("{} %", significant(100.0 * share, 1));
            let at = pos2(plot.left() - 6.0, y);
            painter.text(at, Align2::RIGHT_CENTER, text, theme::small(), p.weak);
        }
    }
}

/// The names of the terms under their bars; a click shows one.
fn names(ui: &Ui, chart: &Chart<'_>, settings: &mut ViewSettings, p: &Palette) {
    let plot = chart.plot;
    // Where bars are narrow, every second one is named, or every fourth.
    let step = (30.0 / chart.pitch()).ceil().max(1.0) as usize;
    let step = step.next_power_of_two();
    for (i, term) in chart.energy.terms.iter().enumerate() {
        let x = chart.x(i as f32);
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
