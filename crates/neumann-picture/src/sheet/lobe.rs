//! A BSDF on one page: a column for each viewing direction with a polar plot, the lobe in space and
//! the density with drawn directions; below them the albedo over the angle.

use neumann_core::render::lobe::{Lobes, Viewed};

use super::canvas::{Canvas, Rect};
use super::text::{Align, Face, Style, Typesetter};
use super::{BRIGHT, FRAME, GROUND, GUTTER, HEADING, MARGIN, NOTE, SUBTITLE, TITLE, UNIT, WORDS};
use crate::figures::significant;
use crate::lobe::{
    AlbedoChart, Disk, Plot, PolarChart, SolidStyle, Turn, draw, figures, reciprocity,
};
use crate::png_file::Pixels8;
use crate::race::colours;

/// What is laid out.
pub struct LobeSheet<'a> {
    /// Name of the scene, and which surface it is.
    pub heading: [&'a str; 2],
    /// What was found.
    pub lobes: &'a Lobes,
    /// What is plotted, and how.
    pub plot: Plot,
    /// From where lobes in space are seen.
    pub turn: Turn,
}

/// Width of a column.
const COLUMN: usize = 38 * UNIT;
const LINE: usize = 3 * UNIT;
/// Height of the lobe in space.
const SOLID: usize = 30 * UNIT;
/// Height of the chart of albedo.
const CHART: usize = 24 * UNIT;
const TICK: Style = Style {
    face: Face::Regular,
    size: 13.0,
    colour: super::QUIET,
};
const NAME: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BRIGHT,
};
const GRID: [u8; 3] = [0x2e; 3];
const VIEWER: [u8; 3] = [229, 168, 60];
const RED_GREEN_BLUE: [[u8; 3]; 3] = [[213, 94, 0], [0, 158, 115], [86, 180, 233]];

/// Lays out a page.
#[must_use]
pub fn lobe_sheet(sheet: &LobeSheet<'_>) -> Pixels8 {
    let views = &sheet.lobes.views;
    let is_whole = views.iter().any(|view| view.drawn.is_transmissive);
    let n_lines = views.iter().map(|v| figures(v).len()).max().unwrap_or(0);
    let room = (views.len() * (COLUMN + GUTTER)).max(2 * COLUMN) - GUTTER;
    let polar = if is_whole { COLUMN } else { COLUMN / 2 };
    let disk = COLUMN * 2 / 3;
    let disk = if is_whole { COLUMN / 2 } else { disk };
    let top = MARGIN + HEADING + 2 * UNIT;
    let tops = Tops {
        polar: top + LINE,
        solid: top + LINE + polar + 5 * UNIT,
        disk: top + LINE + polar + SOLID + 6 * UNIT,
        figures: top + LINE + polar + SOLID + disk + 12 * UNIT,
    };
    let chart = tops.figures + n_lines * LINE + 4 * UNIT;
    let height = chart + CHART + 10 * UNIT + MARGIN;
    let mut page = Page {
        canvas: Canvas::new(2 * MARGIN + room, height, GROUND),
        typesetter: Typesetter::new(),
        sheet,
        is_whole,
        disk,
    };
    page.heading(MARGIN + room);
    for (i, view) in views.iter().enumerate() {
        page.column(view, MARGIN + i * (COLUMN + GUTTER), top, &tops);
    }
    page.albedo(Rect {
        x: MARGIN,
        y: chart,
        width: room,
        height: CHART,
    });
    page.canvas.into_pixels()
}

/// Where the parts of a column begin.
struct Tops {
    polar: usize,
    solid: usize,
    disk: usize,
    figures: usize,
}

struct Page<'a> {
    canvas: Canvas,
    typesetter: Typesetter,
    sheet: &'a LobeSheet<'a>,
    is_whole: bool,
    /// Diameter of a disk.
    disk: usize,
}

impl Page<'_> {
    fn write(&mut self, text: &str, (x, y): (usize, usize), align: Align, style: &Style) {
        let at = (x as f32, y as f32);
        self.typesetter
            .write(&mut self.canvas, text, at, align, style);
    }

    fn heading(&mut self, right: usize) {
        let baseline = MARGIN + 3 * UNIT;
        let Plot { plotted, radius } = self.sheet.plot;
        let what = format!("{}, {}", plotted.name(), radius.name());
        let room = (right - MARGIN) as f32 - self.typesetter.width(&what, &TITLE);
        let [title, subtitle] = self.sheet.heading;
        let title = self
            .typesetter
            .shortened(title, &TITLE, room - GUTTER as f32);
        self.write(&title, (MARGIN, baseline), Align::Left, &TITLE);
        self.write(&what, (right, baseline), Align::Right, &TITLE);
        let room = (right - MARGIN) as f32;
        let subtitle = self.typesetter.shortened(subtitle, &SUBTITLE, room);
        let at = (MARGIN, baseline + 4 * UNIT);
        self.write(&subtitle, at, Align::Left, &SUBTITLE);
    }

    fn column(&mut self, view: &Viewed, x: usize, top: usize, tops: &Tops) {
        let name = format!("θ_{{o}} = {}°", significant(f64::from(view.angle), 3));
        self.write(&name, (x, top), Align::Left, &NAME);
        self.polar(view, (x, tops.polar));
        let turn = self.sheet.turn;
        let style = SolidStyle {
            ground: GROUND,
            line: [0x60; 3],
            viewer: VIEWER,
            arrow: BRIGHT,
        };
        let picture = draw(view, self.sheet.plot, turn, (COLUMN, SOLID), &style);
        self.canvas.paste(x, tops.solid, &picture);
        self.disks(view, (x, tops.disk));
        for (i, figure) in figures(view).into_iter().enumerate() {
            let y = tops.figures + i * LINE;
            self.write(figure.name, (x, y), Align::Left, &NOTE);
            let right = x + COLUMN * 2 / 3;
            self.write(&figure.text, (right, y), Align::Right, &WORDS);
        }
    }

    fn path(&mut self, places: &[(f32, f32)], width: f32, colour: [u8; 3]) {
        for ends in places.windows(2) {
            self.canvas.line([ends[0], ends[1]], width, colour);
        }
    }

    fn polar(&mut self, view: &Viewed, (x, y): (usize, usize)) {
        let chart = PolarChart::new(view, self.sheet.plot);
        let radius = 0.5 * COLUMN as f32;
        let side = view.wo.z < 0.0;
        // From behind, the half that is shown is the lower one.
        let middle = if self.is_whole || !side { radius } else { 0.0 };
        let origin = (x as f32 + radius, y as f32 + middle);
        let at = |[px, py]: [f32; 2]| (origin.0 + radius * px, origin.1 - radius * py);
        let arc = |of: f32| -> Vec<(f32, f32)> {
            let n = 96;
            let turn = |i: usize| std::f32::consts::TAU * i as f32 / n as f32;
            let all = (0..=n).map(|i| turn(i).sin_cos());
            let all = all.map(|(sin, cos)| [of * cos, of * sin]);
            let is_shown = |[_, up]: &[f32; 2]| self.is_whole || (*up < 1e-3) == side;
            all.filter(is_shown).map(at).collect()
        };
        let rings: Vec<_> = chart.rings.iter().map(|ring| arc(ring.radius)).collect();
        for ring in rings {
            for ends in ring.windows(2) {
                // Half a ring begins and ends at the surface.
                if (ends[0].0 - ends[1].0).hypot(ends[0].1 - ends[1].1) < 0.2 * radius {
                    self.canvas.line([ends[0], ends[1]], 1.0, GRID);
                }
            }
        }
        self.canvas
            .line([at([-1.0, 0.0]), at([1.0, 0.0])], 1.0, FRAME);
        let up = if view.wo.z < 0.0 { -1.0 } else { 1.0 };
        self.canvas
            .line([at([0.0, 0.0]), at([0.0, up])], 1.0, FRAME);
        self.canvas
            .line([at([0.0, 0.0]), at(chart.viewer)], 1.5, VIEWER);
        let [values, densities, _, _] = colours(true);
        for line in &chart.densities {
            let places: Vec<_> = line.iter().map(|p| at(*p)).collect();
            self.dashes(&places, densities);
        }
        for line in &chart.curves {
            let places: Vec<_> = line.iter().map(|p| at(*p)).collect();
            self.path(&places, 2.0, values);
        }
        for arrow in &chart.arrows {
            self.arrow([at([0.0, 0.0]), at(arrow.tip)]);
        }
        // From the outermost inwards, as far as numbers do not cover each other.
        let mut free = f32::INFINITY;
        for ring in chart.rings.iter().rev() {
            let place = at([ring.radius, 0.0]);
            if place.0 < free {
                free = place.0 - self.typesetter.width(&ring.label, &TICK) - UNIT as f32;
                let down = if side { -4.0 } else { 15.0 };
                let place = (place.0 as usize, (place.1 + down).max(0.0) as usize);
                self.write(&ring.label, place, Align::Right, &TICK);
            }
        }
    }

    /// A line of which every second piece of the same length is drawn.
    fn dashes(&mut self, places: &[(f32, f32)], colour: [u8; 3]) {
        let mut gone = 0.0f32;
        for ends in places.windows(2) {
            let length = (ends[0].0 - ends[1].0).hypot(ends[0].1 - ends[1].1);
            if (gone / 5.0) as i32 % 2 == 0 {
                self.canvas.line([ends[0], ends[1]], 1.5, colour);
            }
            gone += length;
        }
    }

    fn arrow(&mut self, [from, to]: [(f32, f32); 2]) {
        self.canvas.line([from, to], 2.5, BRIGHT);
        let length = (to.0 - from.0).hypot(to.1 - from.1).max(1e-3);
        let along = ((to.0 - from.0) / length, (to.1 - from.1) / length);
        let head = 8f32.min(length);
        for turn in [-0.5, 0.5] {
            let barb = (
                to.0 - head * (along.0 + turn * along.1),
                to.1 - head * (along.1 - turn * along.0),
            );
            self.canvas.line([to, barb], 2.5, BRIGHT);
        }
    }

    fn disks(&mut self, view: &Viewed, (x, y): (usize, usize)) {
        let disk = Disk::new(view, self.sheet.plot.radius);
        let (columns, rows) = disk.size;
        let diameter = self.disk;
        let scale = diameter as f32 / rows as f32;
        let radius = 0.5 * diameter as f32;
        let width = diameter * columns / rows;
        for row in 0..diameter {
            for column in 0..width {
                let (px, py) = (column as f32 + 0.5, row as f32 + 0.5);
                let middle = radius * (2 * (column / diameter) + 1) as f32;
                let coverage = radius - (px - middle).hypot(py - radius) + 0.5;
                if coverage > 0.0 {
                    let from = |p: f32, n: usize| ((p / scale) as usize).min(n - 1);
                    let colour = disk.pixels[from(py, rows) * columns + from(px, columns)];
                    let at = ((x + column) as i32, (y + row) as i32);
                    self.canvas.cover(at.0, at.1, coverage, colour);
                }
            }
        }
        let at = |[px, py]: [f32; 2]| (x as f32 + px * scale, y as f32 + py * scale);
        for dot in disk.dots.iter().map(|dot| at(*dot)) {
            self.canvas.line([dot, dot], 3.2, GROUND);
            self.canvas.line([dot, dot], 2.0, BRIGHT);
        }
        for point in disk.points.iter().map(|point| at(*point)) {
            let corners = crate::hemisphere::ring([point.0, point.1], 6.0);
            let corners: Vec<_> = corners.into_iter().map(|[x, y]| (x, y)).collect();
            self.path(&corners, 4.0, GROUND);
            self.path(&corners, 2.0, BRIGHT);
        }
        let below = (x, y + diameter + LINE);
        self.write(&disk.note(), below, Align::Left, &NOTE);
    }

    fn albedo(&mut self, rect: Rect) {
        let chart = AlbedoChart::new(self.sheet.lobes);
        let title = "albedo over the angle to the normal";
        self.write(title, (rect.x, rect.y), Align::Left, &WORDS);
        let plot = Rect {
            x: rect.x + 5 * UNIT,
            y: rect.y + 2 * UNIT,
            width: rect.width - 5 * UNIT,
            height: rect.height,
        };
        let at = |[x, y]: [f32; 2]| {
            (
                plot.x as f32 + x * plot.width as f32,
                plot.y as f32 + (1.0 - y.clamp(0.0, 1.02)) * plot.height as f32,
            )
        };
        for value in [0.0f32, 0.5, 1.0] {
            let ends = [at([0.0, value]), at([1.0, value])];
            self.canvas.line(ends, 1.0, GRID);
            let place = (plot.x - UNIT, ends[0].1 as usize + 5);
            let label = significant(f64::from(value), 2);
            self.write(&label, place, Align::Right, &TICK);
        }
        for (place, label) in &chart.ticks {
            let ends = [at([*place, 0.0]), at([*place, 1.0])];
            self.canvas.line(ends, 1.0, GRID);
            let below = (ends[0].0 as usize, ends[0].1 as usize + 2 * UNIT + 2);
            self.write(label, below, Align::Centre, &TICK);
        }
        for [place, low, high] in &chart.sampled {
            let ends = [at([*place, *low]), at([*place, *high])];
            self.canvas.line(ends, 3.0, FRAME);
        }
        let channels = chart.channels.iter().zip(RED_GREEN_BLUE);
        let channels = channels.filter(|_| chart.is_coloured);
        for (line, colour) in channels.chain([(&chart.all, BRIGHT)]) {
            let places: Vec<_> = line.iter().map(|p| at(*p)).collect();
            self.path(&places, 2.0, colour);
        }
        let specular: Vec<_> = chart.specular.iter().map(|p| at(*p)).collect();
        self.dashes(&specular, BRIGHT);
        let mut words = "luminance".to_owned();
        if chart.is_coloured {
            words += ", red, green and blue";
        }
        if !chart.specular.is_empty() {
            words += "; dashes: what mirror-like lobes scatter";
        }
        let below = plot.y + plot.height + 5 * UNIT;
        self.write(&words, (plot.x, below), Align::Left, &NOTE);
        let words = reciprocity(self.sheet.lobes);
        let room = plot.width as f32;
        let words = self.typesetter.shortened(&words, &NOTE, room);
        self.write(&words, (plot.x, below + LINE), Align::Left, &NOTE);
    }
}
