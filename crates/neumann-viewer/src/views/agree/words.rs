//! What is said on the map: the caption, the facts, and what is under the pointer.

use std::sync::PoisonError;

use neumann_core::film::View as Part;
use neumann_picture::agreement::{CHANNELS, Estimate, Grain, Score, Term, count, score_text};
use neumann_picture::figures::significant;

use super::{AgreeView, Found};

/// What the map is of.
pub(super) fn caption(part: Part, chosen: Part, is_paused: bool) -> String {
    let whole = if part == chosen {
        ""
    } else {
        " (partial sums are not compared)"
    };
    let paused = if is_paused { ", paused (Space)" } else { "" };
    format!("Agreement about {part}{whole}{paused}")
}

/// How many iterations there are, and what follows for the part that is shown; in short, too.
pub(super) fn facts(found: &Found, part: Part) -> [String; 2] {
    let n = found.n_batches * found.n_iterations as usize;
    let iterations = count(n, "iteration");
    let verdict = AgreeView::term(found, part).map_or("no light", |term| verdict(found, term));
    [
        format!("{iterations} by each method: {verdict}"),
        format!("{iterations}: {verdict}"),
    ]
}

/// Whether a term has anything but noise.
pub(super) fn verdict(found: &Found, term: &Term) -> &'static str {
    match Verdict::of(found, term) {
        Verdict::None => "not judged yet",
        Verdict::Noise => "noise alone",
        Verdict::Bias => "the methods differ",
    }
}

/// What is said of a term.
pub(super) enum Verdict {
    /// Nothing yet.
    None,
    /// No score is beyond the limit.
    Noise,
    /// Some are.
    Bias,
}

impl Verdict {
    pub(super) fn of(found: &Found, term: &Term) -> Self {
        if !found.agreement.is_judged() || term.n_judged() == 0 {
            Self::None
        } else if term.n_beyond == 0 {
            Self::Noise
        } else {
            Self::Bias
        }
    }
}

/// What is known of the pixel at a place, or of the block around it.
pub(super) fn under(
    found: &Found,
    part: Part,
    grain: Grain,
    (x, y): (usize, usize),
) -> Vec<String> {
    let sides = found.sides.read().unwrap_or_else(PoisonError::into_inner);
    let batches = [&sides[0].batches, &sides[1].batches];
    let Some(term) = AgreeView::term(found, part) else {
        return Vec::new();
    };
    let Some(view) = batches[0].views().iter().position(|view| *view == part) else {
        return Vec::new();
    };
    let cells = found.agreement.cells;
    let (what, score, estimates) = match grain {
        Grain::Pixels => {
            let pixel = y * cells.size().0 + x;
            let estimates = batches.map(|b| b.pixel(view, pixel));
            let [a, b] = estimates;
            ("pixel".to_owned(), Some(Score::of(a, b, 0)), estimates)
        }
        Grain::Blocks => {
            let limit = found.agreement.limit;
            let is_beyond = |cell: &usize| term.scores[*cell].is_some_and(|s| s.is_beyond(limit));
            let around = || cells.around(x, y);
            let cell = around().find(is_beyond).or_else(|| around().next());
            let cell = cell.unwrap_or(0);
            let [width, height] = {
                let cell = cells.cell(cell);
                [cell.x, cell.y].map(|[from, to]| to - from)
            };
            let score = term.scores[cell];
            let what = format!("block {width}×{height}");
            match score {
                Some(Score { channel, .. }) => (
                    format!("{what}, {}", CHANNELS[channel]),
                    score,
                    batches.map(|b| b.estimate(view, cell, channel)),
                ),
                None => (what, None, batches.map(|b| b.luminance(view, cell))),
            }
        }
    };
    let score = match score {
        Some(_) => format!("{what}: {} deviations", score_text(score)),
        None => format!("{what}: not judged, light is rare"),
    };
    let of = |i: usize| {
        let Estimate {
            mean,
            standard_error,
            ..
        } = estimates[i];
        format!(
            "{} {} ± {}",
            found.names[i],
            significant(mean, 4),
            significant(standard_error, 2)
        )
    };
    vec![score, of(0), of(1)]
}
