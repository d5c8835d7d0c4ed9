//! The reflection equation at a surface point on one page: what stands below the integral, the
//! densities with their samples, and how the estimators come together.

use neumann_core::film::View;
use neumann_core::radiometry::Rgb;
use neumann_core::render::Hemisphere;
use neumann_core::render::hemisphere::{Estimator, Integrand};

use super::canvas::{Canvas, Rect};
use super::label::formula as formula_of_part;
use super::text::{Align, Face, Style, Typesetter};
use super::{
    BRIGHT, FRAME, GROUND, GUTTER, HEADING, MARGIN, NOTE, OPERATOR, SUBTITLE, TITLE, UNIT, WORDS,
};
use crate::figures::significant;
use crate::hemisphere::{
    Convergence, DENSITIES, EQUATION, INTEGRANDS, Panel, colour, figures, formula, points, shows,
    with_interval,
};
use crate::png_file::Pixels8;
use crate::tone::Display;

/// What is laid out.
pub struct HemisphereSheet<'a> {
    /// A name, such as that of the scene, and which point it is.
    pub heading: [&'a str; 2],
    /// What was found.
    pub hemisphere: &'a Hemisphere,
    /// The pixel itself: by what it was rendered, its mean luminance, and half its interval.
    pub reference: Option<(&'a str, f64, Option<f64>)>,
    /// The part of the series that arrives.
    pub part: View,
    /// How incident radiance is shown.
    pub display: Display,
}

/// Diameter of a disk.
const DISK: usize = 26 * UNIT;
const LINE: usize = 3 * UNIT;
/// What stands below a disk.
const LABEL: usize = 8 * UNIT;
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

/// Lays out a page.
#[must_use]
pub fn hemisphere_sheet(sheet: &HemisphereSheet<'_>) -> Pixels8 {
    let hemisphere = sheet.hemisphere;
    let width = DISK * hemisphere.map().n_disks();
    let pitch = width + GUTTER;
    let row = DISK + LABEL;
    let n_columns = INTEGRANDS.len() + 1;
    let room = n_columns * pitch - GUTTER;
    let top = MARGIN + HEADING;
    let second = top + row + 2 * UNIT;
    let n_lines = 6;
    let page = (2 * MARGIN + room, second + row + n_lines * LINE + MARGIN);
    let mut page = Page {
        canvas: Canvas::new(page.0, page.1, GROUND),
        typesetter: Typesetter::new(),
        sheet,
        width,
        right: MARGIN + room,
    };
    page.heading();
    for (i, integrand) in INTEGRANDS.into_iter().enumerate() {
        let at = (MARGIN + i * pitch, top);
        page.panel(integrand, at);
        let sign = ["×", "×", "=", "→"][i];
        let beside = (at.0 + width + GUTTER / 2, top + DISK / 2 + UNIT);
        page.write(sign, beside, Align::Centre, &OPERATOR);
    }
    page.outgoing((MARGIN + INTEGRANDS.len() * pitch, top));
    for (i, density) in DENSITIES.into_iter().enumerate() {
        page.panel(density, (MARGIN + i * pitch, second));
    }
    let left = MARGIN + DENSITIES.len() * pitch;
    page.convergence(Rect {
        x: left,
        y: second,
        width: page.right - left,
        height: DISK,
    });
    page.figures(second + row);
    page.canvas.into_pixels()
}

struct Page<'a> {
    canvas: Canvas,
    typesetter: Typesetter,
    sheet: &'a HemisphereSheet<'a>,
    /// Of a picture.
    width: usize,
    right: usize,
}

impl Page<'_> {
    fn write(&mut self, text: &str, (x, y): (usize, usize), align: Align, style: &Style) {
        let at = (x as f32, y as f32);
        self.typesetter
            .write(&mut self.canvas, text, at, align, style);
    }

    fn heading(&mut self) {
        let right = self.right;
        let baseline = MARGIN + 3 * UNIT;
        let equation = self.typesetter.width(EQUATION, &TITLE);
        let room = (right - MARGIN) as f32 - equation - GUTTER as f32;
        let [title, subtitle] = self.sheet.heading;
        let title = self.typesetter.shortened(title, &TITLE, room);
        self.write(&title, (MARGIN, baseline), Align::Left, &TITLE);
        self.write(EQUATION, (right, baseline), Align::Right, &TITLE);
        let room = (right - MARGIN) as f32;
        let subtitle = self.typesetter.shortened(subtitle, &SUBTITLE, room);
        let at = (MARGIN, baseline + 4 * UNIT);
        self.write(&subtitle, at, Align::Left, &SUBTITLE);
    }

    /// Fills the disks of a map, whose upper left corner is at a place.
    fn disks(&mut self, (x, y): (usize, usize), colour: impl Fn(f32, f32) -> [u8; 3]) {
        let radius = 0.5 * DISK as f32;
        for row in 0..DISK {
            for column in 0..self.width {
                let (px, py) = (column as f32 + 0.5, row as f32 + 0.5);
                let disk = column / DISK;
                let middle = radius * (2 * disk + 1) as f32;
                let coverage = radius - (px - middle).hypot(py - radius) + 0.5;
                if coverage > 0.0 {
                    let colour = colour(px / DISK as f32, py / DISK as f32);
                    let at = ((x + column) as i32, (y + row) as i32);
                    self.canvas.cover(at.0, at.1, coverage, colour);
                }
            }
        }
    }

    fn panel(&mut self, integrand: Integrand, (x, y): (usize, usize)) {
        let hemisphere = self.sheet.hemisphere;
        let panel = Panel::new(hemisphere, integrand, self.sheet.part, &self.sheet.display);
        let (columns, edge) = panel.size;
        let pixel = |px: f32, py: f32| {
            let at = |p: f32, n: usize| ((p * edge as f32) as usize).min(n - 1);
            panel.pixels[at(py, edge) * columns + at(px, columns)]
        };
        self.disks((x, y), pixel);
        let scale = DISK as f32 / edge as f32;
        let place = |direction| {
            let [px, py] = hemisphere.map().place(direction)?;
            Some((x as f32 + px * scale, y as f32 + py * scale))
        };
        if let Integrand::Density(estimator) = integrand {
            let colour = colour(estimator, true);
            let dots: Vec<_> = hemisphere.dots(estimator).filter_map(place).collect();
            for dot in dots {
                self.canvas.line([dot, dot], 4.0, GROUND);
                self.canvas.line([dot, dot], 2.5, colour);
            }
        }
        let points = hemisphere.points().iter();
        let shown = points.filter(|point| shows(integrand, point));
        let places: Vec<_> = shown.filter_map(|point| place(point.direction)).collect();
        for at in places {
            self.ring(at, 6.0);
        }
        let baseline = y + DISK + LINE;
        self.write(formula(integrand), (x, baseline), Align::Left, &NAME);
        let mut note = panel.note();
        if integrand == Integrand::Incident && self.sheet.part != View::Total {
            let part = formula_of_part(self.sheet.part, hemisphere.n_layers());
            note = format!("{part} alone, {note}");
        }
        self.write(&note, (x, baseline + LINE), Align::Left, &NOTE);
    }

    fn ring(&mut self, (x, y): (f32, f32), radius: f32) {
        let corners = crate::hemisphere::ring([x, y], radius);
        for (width, colour) in [(4.0, GROUND), (2.0, BRIGHT)] {
            for ends in corners.windows(2) {
                let ends = [(ends[0][0], ends[0][1]), (ends[1][0], ends[1][1])];
                self.canvas.line(ends, width, colour);
            }
        }
    }

    /// What leaves towards the viewer: one colour.
    fn outgoing(&mut self, (x, y): (usize, usize)) {
        let hemisphere = self.sheet.hemisphere;
        let integral = hemisphere.estimate_by(Estimator::Mis).measured();
        let value: Rgb = hemisphere.emitted() + integral.mean;
        let colour = self.sheet.display.srgb8(value);
        let left = self.width.saturating_sub(DISK) / 2;
        let width = std::mem::replace(&mut self.width, DISK);
        self.disks((x + left, y), |_, _| colour);
        self.width = width;
        let baseline = y + DISK + LINE;
        self.write("L_{o}", (x, baseline), Align::Left, &NAME);
        let emitted = significant(f64::from(hemisphere.emitted().luminance()), 3);
        let note = format!("{emitted} + {}", with_interval(&integral));
        self.write(&note, (x, baseline + LINE), Align::Left, &NOTE);
    }

    /// Means with their bands over the number of paths.
    fn convergence(&mut self, rect: Rect) {
        let Some(chart) = Convergence::new(self.sheet.hemisphere) else {
            return;
        };
        let frame = Rect {
            x: rect.x + 7 * UNIT,
            width: rect.width - 7 * UNIT,
            ..rect
        };
        let at = |x: f64, y: f64| {
            (
                frame.x as f32 + x as f32 * frame.width as f32,
                frame.y as f32 + (1.0 - y.clamp(0.0, 1.0) as f32) * frame.height as f32,
            )
        };
        for line in &chart.lines {
            let colour = colour(line.estimator, true);
            for pair in line.band.windows(2) {
                self.band(pair[0], pair[1], colour, at);
            }
        }
        for line in &chart.lines {
            let colour = colour(line.estimator, true);
            for pair in line.mean.windows(2) {
                let is_inside = |p: &[f64; 2]| (0.0..=1.0).contains(&p[1]);
                if pair.iter().all(is_inside) {
                    let ends = [at(pair[0][0], pair[0][1]), at(pair[1][0], pair[1][1])];
                    self.canvas.line(ends, 2.0, colour);
                }
            }
        }
        let emitted = f64::from(self.sheet.hemisphere.emitted().luminance());
        let reference = self.sheet.reference.map(|(_, mean, _)| mean - emitted);
        let up = reference.map(|mean| chart.up(mean));
        if let Some(up) = up.filter(|up| (0.0..=1.0).contains(up)) {
            self.canvas.line([at(0.0, up), at(1.0, up)], 1.0, BRIGHT);
        }
        for ends in [[at(0.0, 0.0), at(1.0, 0.0)], [at(0.0, 0.0), at(0.0, 1.0)]] {
            self.canvas.line(ends, 1.0, FRAME);
        }
        let left = frame.x - UNIT;
        for (value, y) in chart
            .values
            .iter()
            .zip([frame.y + frame.height, frame.y + 10])
        {
            let text = significant(*value, 3);
            self.write(&text, (left, y), Align::Right, &TICK);
        }
        for (place, label) in &chart.ticks {
            let (x, y) = at(*place, 0.0);
            let place = (x as usize, y as usize + 2 * UNIT);
            self.write(label, place, Align::Centre, &TICK);
        }
        let below = (frame.x, frame.y + frame.height + 5 * UNIT);
        let words = "mean over paths; bands hold the truth 95 times of 100";
        let words = self.typesetter.shortened(words, &NOTE, frame.width as f32);
        self.write(&words, below, Align::Left, &NOTE);
    }

    /// The part of a band between two places.
    fn band(
        &mut self,
        [x0, low0, high0]: [f64; 3],
        [x1, low1, high1]: [f64; 3],
        colour: [u8; 3],
        at: impl Fn(f64, f64) -> (f32, f32),
    ) {
        let (from, to) = (at(x0, 0.0).0, at(x1, 0.0).0);
        for x in from.floor() as i32..to.floor() as i32 {
            let share = f64::from((x as f32 - from) / (to - from)).clamp(0.0, 1.0);
            let between = |a: f64, b: f64| at(0.0, a + share * (b - a)).1 as i32;
            for y in between(high0, high1)..between(low0, low1) {
                self.canvas.cover(x, y, 0.22, colour);
            }
        }
    }

    /// All that says how large the integral is.
    fn figures(&mut self, top: usize) {
        let hemisphere = self.sheet.hemisphere;
        let left = MARGIN + 2 * UNIT;
        let column = MARGIN + 22 * UNIT;
        let mut rows: Vec<(String, String, Option<[u8; 3]>)> = figures(hemisphere)
            .into_iter()
            .enumerate()
            .map(|(i, figure)| {
                let colour = Estimator::ALL.get(i).map(|e| colour(*e, true));
                (figure.name.to_owned(), figure.text, colour)
            })
            .collect();
        if let Some((name, mean, interval)) = self.sheet.reference {
            let emitted = f64::from(hemisphere.emitted().luminance());
            let mut text = significant(mean - emitted, 4);
            if let Some(interval) = interval {
                text = format!("{text} ± {}", significant(interval, 2));
            }
            rows.push((format!("{name}, less L_{{e}}"), text, Some(BRIGHT)));
        }
        for (i, (name, text, colour)) in rows.iter().enumerate() {
            let y = top + (i + 1) * LINE;
            if let Some(colour) = colour {
                let dot = (MARGIN as f32 + 5.0, y as f32 - 5.0);
                self.canvas.line([dot, dot], 9.0, *colour);
            }
            self.write(name, (left, y), Align::Left, &WORDS);
            self.write(text, (column + 6 * UNIT, y), Align::Left, &WORDS);
        }
        if let Some(words) = points(hemisphere) {
            let room = (self.right - MARGIN) as f32;
            let words = self.typesetter.shortened(&words, &NOTE, room);
            let at = (MARGIN, top + (rows.len() + 1) * LINE);
            self.write(&words, at, Align::Left, &NOTE);
        }
    }
}
