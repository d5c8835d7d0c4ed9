//! Noise and bias in words: one line, and a table of the terms.

use neumann_core::film::View;

use super::{EDGES, PartError, Radii, Split};
use crate::agreement::count;
use crate::figures::significant;

/// What was measured of a method.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// What it is called.
    pub name: &'a str,
    /// Its radii.
    pub radii: &'a Radii,
    /// Iterations of a render.
    pub n_iterations: u32,
    /// Renders at each radius.
    pub n_renders: usize,
    /// The errors of the parts that have light.
    pub parts: &'a [PartError],
}

/// What the table says of a part.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub term: String,
    /// Its mean luminance.
    pub mean: String,
    /// Its relative error, and the two parts of that.
    pub error: String,
    /// What chance makes.
    pub noise: String,
    /// What the radius makes.
    pub bias: String,
    /// Noise, bias and error with half the radius.
    pub at_half: [String; 3],
    /// Which one is larger: `noise`, `bias`, or neither.
    pub larger: &'static str,
}

impl Row {
    /// That of a part.
    #[must_use]
    pub fn of(part: &PartError) -> Self {
        let Split { noise, bias } = part.here;
        let half = part.at_half;
        Self {
            term: part.view.to_string(),
            mean: significant(part.mean, 5),
            error: percent(part.here.error()),
            noise: percent(noise),
            bias: bias_of(part),
            at_half: [half.noise, half.bias, half.error()].map(percent),
            larger: match (part.has_bias(), bias > noise) {
                (true, true) => "bias",
                (_, false) if noise > 0.0 => "noise",
                _ => "neither",
            },
        }
    }
}

impl Report<'_> {
    /// How it was made.
    #[must_use]
    pub fn heading(&self) -> String {
        let [first, last] = self.radii.radius.map(|r| significant(r, 3));
        let radius = if first == last {
            format!("radius {first} m")
        } else {
            format!("radius {first} m, at last {last} m")
        };
        format!(
            "{} · {} of {} at each of two radii · {radius}",
            self.name,
            count(self.n_renders, "render"),
            count(self.n_iterations as usize, "iteration")
        )
    }

    /// The whole of a part in one line.
    #[must_use]
    pub fn line(&self, view: View) -> String {
        self.sentences(view).join(" ").trim_end().to_owned()
    }

    /// The same in two sentences: what the error is, and what half the radius would make of it.
    #[must_use]
    pub fn sentences(&self, view: View) -> [String; 2] {
        let Some(part) = self.parts.iter().find(|part| part.view == view) else {
            let nothing = format!("{} found no light in {view}.", self.name);
            return [nothing, String::new()];
        };
        let row = Row::of(part);
        let bias = if part.has_bias() {
            format!("radius bias {}", row.bias)
        } else {
            format!("no radius bias that is seen ({})", row.bias)
        };
        let [noise, half, error] = &row.at_half;
        let then = match part.at_half.error() / part.here.error() {
            times if times < 0.98 => "becomes smaller,",
            times if times > 1.02 => "becomes larger,",
            _ => "stays the same,",
        };
        let now = format!(
            "{} after {}, {view}: relative error {}, of it noise {} and {bias}.",
            self.name,
            count(self.n_iterations as usize, "iteration"),
            row.error,
            row.noise,
        );
        let then =
            format!("With half the radius noise {noise}, bias {half}: the error {then} {error}.");
        [now, then]
    }

    /// What is to be known of these numbers.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        vec![
            "Of one render, root mean squares over the pixels, as shares of the mean of the term."
                .to_owned(),
            format!(
                "The bias is taken to go with the square of the radius. Within a radius of an edge \
                 of light or of a surface it is up to {EDGES} times as large."
            ),
        ]
    }

    /// The line, the table and the notes.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines = vec![self.heading(), String::new(), self.line(View::Total)];
        lines.push(String::new());
        let row = |cells: [&str; 8]| {
            let [
                term,
                mean,
                error,
                noise,
                bias,
                half_noise,
                half_bias,
                half_error,
            ] = cells;
            format!(
                "{term:<4}  {mean:<10}  {error:<8}  {noise:<8}  {bias:<24}  {half_noise:<18}  \
                 {half_bias:<8}  {half_error}"
            )
        };
        lines.push(row([
            "term",
            "mean",
            "error",
            "noise",
            "radius bias",
            "half radius: noise",
            "bias",
            "error",
        ]));
        for part in self.parts {
            let Row {
                term,
                mean,
                error,
                noise,
                bias,
                at_half: [half_noise, half_bias, half_error],
                ..
            } = &Row::of(part);
            lines.push(row([
                term, mean, error, noise, bias, half_noise, half_bias, half_error,
            ]));
        }
        lines.push(String::new());
        lines.extend(self.notes());
        lines.join("\n")
    }
}

fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}

/// A bias with what it may be.
fn bias_of(part: &PartError) -> String {
    let [least, most] = part.bias_range.map(|share| significant(100.0 * share, 2));
    if part.has_bias() {
        format!("{} ({least} to {most})", percent(part.here.bias))
    } else if part.bias_range[1] == 0.0 {
        percent(0.0)
    } else {
        format!("below {most} %")
    }
}
