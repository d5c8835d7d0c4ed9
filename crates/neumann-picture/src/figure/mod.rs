//! Vector figures (SVG) for print: black on white, with the geometry of the charts on sheets and in
//! the window.

mod energy;
mod race;

use svg::Document;
use svg::node::element::{Circle, Element, Line, Polyline, Rectangle, TSpan, Title};
use svg::node::{Blob, Node, Text as Words};

use crate::sheet::board::{Board, DASH};
use crate::sheet::curves::Look;
use crate::sheet::text::{Align, Face, Level, SCRIPT_SIZE, Style, runs};

pub use energy::energy_figure;
pub use race::race_figure;

const BLACK: [u8; 3] = [0; 3];
const GREY: [u8; 3] = [0x55; 3];
/// Distance of everything from the edge.
const MARGIN: f32 = 24.0;
/// Between two lines of text.
const LINE: f32 = 18.0;

const TITLE: Style = Style {
    face: Face::SemiBold,
    size: 18.0,
    colour: BLACK,
};
const WORDS: Style = Style {
    face: Face::Regular,
    size: 14.0,
    colour: BLACK,
};
const NOTE: Style = Style {
    face: Face::Regular,
    size: 13.0,
    colour: GREY,
};
/// In print.
const LOOK: Look = Look {
    words: WORDS,
    number: NOTE,
    note: NOTE,
    grid: [0xdd; 3],
    frame: BLACK,
    is_dark: false,
};

/// A figure under construction.
struct Figure {
    document: Document,
    height: f32,
}

impl Figure {
    /// An empty figure of that width with a heading, and where what follows it may begin.
    fn new(width: f32, [title, subtitle]: [&str; 2]) -> (Self, f32) {
        let mut figure = Self {
            document: Document::new().set("width", width),
            height: 0.0,
        };
        figure.document.append(Title::new(printable(title)));
        let ground = Rectangle::new().set("width", "100%").set("height", "100%");
        figure.document.append(ground.set("fill", "#ffffff"));
        let mut y = MARGIN + 14.0;
        figure.write(title, (MARGIN, y), Align::Left, &TITLE);
        y += LINE + 2.0;
        figure.write(subtitle, (MARGIN, y), Align::Left, &NOTE);
        (figure, y)
    }

    /// The figure as text, so high.
    fn finish(self, width: f32, height: f32) -> String {
        debug_assert!(self.height <= height, "nothing is cut off");
        let document = self.document.set("height", height);
        let document = document.set("viewBox", (0.0, 0.0, width, height));
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{document}\n")
    }

    fn reach(&mut self, y: f32) {
        self.height = self.height.max(y);
    }

    /// A bar with square ends.
    fn bar(&mut self, [from, to]: [(f32, f32); 2], width: f32, colour: [u8; 3]) {
        let bar = stroke(Line::new(), width, colour)
            .set("x1", short(from.0))
            .set("y1", short(from.1))
            .set("x2", short(to.0))
            .set("y2", short(to.1));
        self.reach(from.1.max(to.1));
        self.document.append(bar);
    }
}

impl Board for Figure {
    fn way(&mut self, points: &[(f32, f32)], width: f32, colour: [u8; 3]) {
        let places = points
            .iter()
            .map(|(x, y)| format!("{},{}", short(*x), short(*y)));
        let places = places.collect::<Vec<_>>().join(" ");
        let way = Polyline::new().set("points", places).set("fill", "none");
        let way = way
            .set("stroke", hex(colour))
            .set("stroke-width", short(width));
        self.reach(points.iter().fold(0.0, |most, (_, y)| y.max(most)));
        self.document.append(way.set("stroke-linejoin", "round"));
    }

    fn dashes(&mut self, [from, to]: [(f32, f32); 2], width: f32, colour: [u8; 3]) {
        let dashes = stroke(Line::new(), width, colour)
            .set("x1", short(from.0))
            .set("y1", short(from.1))
            .set("x2", short(to.0))
            .set("y2", short(to.1))
            .set("stroke-dasharray", DASH);
        self.document.append(dashes);
    }

    fn dot(&mut self, (x, y): (f32, f32), diameter: f32, colour: [u8; 3]) {
        let dot = Circle::new()
            .set("cx", short(x))
            .set("cy", short(y))
            .set("r", short(0.5 * diameter))
            .set("fill", hex(colour));
        self.reach(y);
        self.document.append(dot);
    }

    fn write(&mut self, line: &str, (x, y): (f32, f32), align: Align, style: &Style) {
        let mut text = Element::new("text");
        text.assign("x", short(x));
        text.assign("y", short(y));
        text.assign("font-family", "Inter, Helvetica, Arial, sans-serif");
        text.assign("font-size", style.size);
        text.assign("fill", hex(style.colour));
        if matches!(style.face, Face::SemiBold) {
            text.assign("font-weight", 600);
        }
        match align {
            Align::Left => {}
            Align::Centre => text.assign("text-anchor", "middle"),
            Align::Right => text.assign("text-anchor", "end"),
        }
        // Line breaks between elements would be spaces within a word.
        let mut content = String::new();
        let mut height = 0.0;
        for (words, level) in runs(line) {
            let words = printable(words);
            let rise = level.rise() * style.size;
            if level == Level::Base && height == rise {
                content += &Words::new(words).to_string();
                continue;
            }
            // Renderers drop a space at an end.
            let words = words.replace(' ', "\u{a0}");
            let mut script = TSpan::new(words).set("dy", short(height - rise));
            if level != Level::Base {
                script = script.set("font-size", short(SCRIPT_SIZE * style.size));
            }
            content += &script.to_string();
            height = rise;
        }
        text.append(Blob::new(content));
        self.reach(y);
        self.document.append(text);
    }
}

fn stroke(line: Line, width: f32, colour: [u8; 3]) -> Line {
    line.set("stroke", hex(colour))
        .set("stroke-width", short(width))
}

fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Hundredths of a pixel are enough.
fn short(value: f32) -> f32 {
    (value * 100.0).round() / 100.0
}

/// Without characters that no XML may hold.
fn printable(text: &str) -> String {
    let is_kept = |c: &char| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}');
    text.chars().filter(is_kept).collect()
}

#[cfg(test)]
mod tests {
    use svg::parser::Event;

    use super::{energy_figure, race_figure};
    use crate::compare::compare;
    use crate::energy::Energy;
    use crate::race::Point;
    use crate::{Image, tone::Display};

    /// The names of all elements and the text within; all that is opened is closed in its order.
    fn elements(svg: &str) -> (Vec<String>, String) {
        let (mut open, mut names, mut text) = (Vec::new(), Vec::new(), String::new());
        for event in svg::read(svg).unwrap() {
            match event {
                Event::Error(error) => panic!("{error}"),
                Event::Tag(name, svg::node::element::tag::Type::Start, _) => {
                    open.push(name);
                    names.push(name.to_owned());
                }
                Event::Tag(name, svg::node::element::tag::Type::End, _) => {
                    assert_eq!(open.pop(), Some(name));
                }
                Event::Tag(name, ..) => names.push(name.to_owned()),
                Event::Text(words) => text += words,
                _ => {}
            }
        }
        assert!(open.is_empty(), "{open:?}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        (names, text)
    }

    fn count(names: &[String], name: &str) -> usize {
        names.iter().filter(|other| *other == name).count()
    }

    /// A curve with the slope of an unbiased method.
    fn curve(n: u32, error: f64) -> Vec<Point> {
        let black = Image {
            width: 1,
            height: 1,
            pixels: vec![Default::default()],
            ..Image::default()
        };
        let points = (0..n).map(|i| {
            let seconds = f64::from(1 << i);
            let mut comparison = compare(&black, &black, &Display::default()).unwrap();
            comparison.rel_mse = error / seconds;
            comparison.flip = 0.3 * (error / seconds).sqrt();
            Point {
                seconds,
                n_iterations: 1 << i,
                comparison,
            }
        });
        points.collect()
    }

    #[test]
    fn curves_have_a_dot_for_each_point_and_a_guide_for_each_chart() {
        let (a, b) = (curve(5, 0.1), curve(4, 0.02));
        let racers = [("pt-nee", &*a), ("a<b>&c", &*b)];
        let svg = race_figure(["a \"scene\" & more\u{1}", "how"], &racers);
        let (names, text) = elements(&svg);
        // Both charts, and the legend.
        assert_eq!(count(&names, "circle"), 2 * (5 + 4) + 2);
        assert_eq!(svg.matches("stroke-dasharray").count(), 2);
        for words in [
            "relMSE over",
            "FLIP over",
            "slope",
            "pt-nee",
            "a&lt;b&gt;&amp;c",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(text.contains("a \"scene\" &amp; more") && !text.contains('\u{1}'));
        let nothing = race_figure(["a", "b"], &[("pt-nee", &[])]);
        assert_eq!(count(&elements(&nothing).0, "circle"), 1);
    }

    #[test]
    fn terms_have_bars_as_high_as_their_shares() {
        let shares = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.03125];
        let energy = Energy::of(&shares, &[Some(0.1); 6], 100, 16);
        let svg = energy_figure(["a", "b"], &energy);
        let (names, text) = elements(&svg);
        assert!(text.contains("Each bounce keeps 50 %") && text.contains("share of L"));
        let heights: Vec<f64> = svg::read(&svg)
            .unwrap()
            .filter_map(|event| match event {
                Event::Tag("line", _, attributes)
                    if !attributes.contains_key("stroke-dasharray") =>
                {
                    let y = |name: &str| attributes[name].parse::<f64>().unwrap();
                    Some(y("y1") - y("y2"))
                }
                _ => None,
            })
            .collect();
        assert_eq!(heights.len(), 6, "a bar a term");
        // On a logarithmic axis each is as much lower than the one before.
        let steps: Vec<f64> = heights.windows(2).map(|h| h[0] - h[1]).collect();
        assert!(steps[0] > 10.0 && steps[4].abs() < 0.1, "{steps:?}");
        assert!(steps[..4].iter().all(|step| (step - steps[0]).abs() < 0.1));
        assert_eq!(
            count(&names, "tspan"),
            1 + 1 + 3 * 3 + 4,
            "scripts of the formulas"
        );
        let dark = Energy::of(&[0.0; 3], &[None; 3], 100, 16);
        assert_eq!(
            count(&elements(&energy_figure(["a", "b"], &dark)).0, "line"),
            0
        );
    }
}
