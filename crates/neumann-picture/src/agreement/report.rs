//! An agreement in words: the table, and what follows from it.

use super::{Agreement, FEWEST, Score, Side, Term};
use crate::figures::significant;

/// The channels of a [`Score`], by number.
pub const CHANNELS: [&str; 3] = ["red", "green", "blue"];

const RARE_LIGHT: &str = "Light that a method finds hardly ever makes it too dark for long: with \
    more iterations such a difference goes away, and a bias does not.";

/// Two methods and their scores.
#[derive(Clone, Copy, Debug)]
pub struct Report<'a> {
    /// The methods.
    pub sides: &'a [Side; 2],
    /// How far they are apart.
    pub agreement: &'a Agreement,
}

/// What the table says of a term.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub term: String,
    /// Its mean luminance by each method.
    pub means: [String; 2],
    /// The first over the second.
    pub ratio: String,
    /// The share from which on a difference is seen.
    pub seen_from: String,
    /// The score of the whole picture.
    pub score: String,
    /// The largest one of all cells.
    pub largest: String,
    /// Cells beyond the limit, of those that are judged.
    pub beyond: String,
}

impl Row {
    /// That of a term.
    #[must_use]
    pub fn of(term: &Term) -> Self {
        Self {
            term: term.view.to_string(),
            means: term.means.map(|mean| significant(mean, 5)),
            ratio: ratio(term).map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.5}")),
            seen_from: format!("{} %", significant(100.0 * term.seen_from, 2)),
            score: score_text(term.whole()),
            largest: score_text(term.largest().map(|(_, score)| score)),
            beyond: format!("{} of {}", term.n_beyond, term.n_judged()),
        }
    }
}

impl Report<'_> {
    /// What the methods are called; one that stands against itself is told from itself.
    #[must_use]
    pub fn names(&self) -> [String; 2] {
        let [a, b] = self.sides;
        let again = if a.name == b.name { " again" } else { "" };
        [a.name.clone(), format!("{}{again}", b.name)]
    }

    /// How it was made.
    #[must_use]
    pub fn heading(&self) -> String {
        let (width, height) = self.agreement.cells.size();
        let names = self.names();
        let batches = |i: usize| {
            let side = &self.sides[i];
            format!(
                "{} ({} batches of {}, {:.1} s)",
                names[i],
                side.batches.n(),
                count(side.n_iterations as usize, "iteration"),
                side.seconds
            )
        };
        format!("{} against {} · {width}×{height}", batches(0), batches(1))
    }

    /// The table, with what it means.
    #[must_use]
    pub fn text(&self) -> String {
        let names = self.names();
        let widths = names.each_ref().map(|name| name.chars().count().max(10));
        let mut lines = vec![self.heading(), String::new()];
        let pad = |text: &str, width: usize| format!("{text:width$}");
        lines.push(format!(
            "term  {}  {}  ratio     seen from  score    largest  cells beyond",
            pad(&names[0], widths[0]),
            pad(&names[1], widths[1])
        ));
        for term in &self.agreement.terms {
            let row = Row::of(term);
            lines.push(format!(
                "{:<4}  {}  {}  {:<8}  {:<9}  {:<7}  {:<7}  {}",
                row.term,
                pad(&row.means[0], widths[0]),
                pad(&row.means[1], widths[1]),
                row.ratio,
                row.seen_from,
                row.score,
                row.largest,
                row.beyond,
            ));
        }
        lines.push(String::new());
        lines.push(
            "Scores are in standard deviations, above 0 where the first method is brighter: of the \
             whole\npicture, and the largest of all its cells. A difference of a whole term is \
             seen from that share on."
                .to_owned(),
        );
        let n_rare: usize = self.agreement.terms.iter().map(|term| term.n_rare).sum();
        if n_rare > 0 {
            lines.push(format!(
                "Not judged: {}, where some batches found no light. More iterations help.",
                count(n_rare, "cell")
            ));
        }
        lines.push(String::new());
        lines.extend(self.verdict());
        lines.join("\n")
    }

    /// What follows, in sentences.
    #[must_use]
    pub fn verdict(&self) -> Vec<String> {
        let agreement = self.agreement;
        let mut lines = vec![self.conclusion()];
        for term in agreement.terms.iter().filter(|term| term.n_beyond > 0) {
            lines.push(self.finding(term));
        }
        if !agreement.holds() {
            lines.push(RARE_LIGHT.to_owned());
        }
        for (i, side) in self.sides.iter().enumerate() {
            let method = side.settings.method;
            let is_new = i == 0 || self.sides[0].settings.method != method;
            if let Some(bias) = method.bias.filter(|_| is_new) {
                lines.push(format!("{} is biased: {bias}.", method.id));
            }
            if !agreement.holds() && is_new && !method.blind_spots.is_empty() {
                lines.push(format!("{} cannot see: {}", method.id, method.blind_spots));
            }
        }
        lines
    }

    fn conclusion(&self) -> String {
        let agreement = self.agreement;
        if !agreement.is_judged() {
            return format!("No verdict yet: it takes {FEWEST} batches by each method.");
        }
        let n = agreement.n_scores;
        let terms = agreement.terms.iter().filter(|term| term.n_beyond > 0);
        let terms: Vec<String> = terms.map(|term| term.view.to_string()).collect();
        let rate = format!(
            "{} deviations (false-alarm rate {} %)",
            significant(agreement.limit, 3),
            significant(100.0 * agreement.level, 2)
        );
        match (n, &terms[..]) {
            (0, _) => "Nothing was compared: light comes too seldom.".to_owned(),
            (_, []) => format!("The two agree: none of {n} scores is beyond {rate}."),
            (_, [.., last]) => {
                let others = &terms[..terms.len() - 1];
                let names = if others.is_empty() {
                    last.clone()
                } else {
                    format!("{} and {last}", others.join(", "))
                };
                format!("They disagree at {names}: of {n} scores, some are beyond {rate}.")
            }
        }
    }

    /// Where a term differs most.
    fn finding(&self, term: &Term) -> String {
        let Some((cell, score)) = term.largest() else {
            return String::new();
        };
        let [a, b] = self.names();
        let way = if score.deviations > 0.0 {
            "brighter"
        } else {
            "darker"
        };
        let place = if cell == 0 {
            "over the whole picture".to_owned()
        } else {
            let cell = self.agreement.cells.cell(cell);
            format!(
                "at columns {} to {}, rows {} to {}",
                cell.x[0],
                cell.x[1] - 1,
                cell.y[0],
                cell.y[1] - 1
            )
        };
        let mut line = format!(
            "{}: {a} is {way} than {b}, most surely {place}, in {} ({}).",
            term.view,
            CHANNELS[score.channel],
            score_text(Some(score))
        );
        for (name, n) in [&a, &b].into_iter().zip(term.n_beyond_black) {
            if n > 0 {
                line += &format!(
                    " In {} of {} cells {name} found no light at all.",
                    n, term.n_beyond
                );
            }
        }
        line
    }
}

/// Mean by the first method over that by the second; `None` where one of the two is black.
#[must_use]
pub fn ratio(term: &Term) -> Option<f64> {
    let [a, b] = term.means;
    (a > 0.0 && b > 0.0).then_some(a / b)
}

/// A score as a number; a dash where there is none.
#[must_use]
pub fn score_text(score: Option<Score>) -> String {
    match score {
        None => "–".to_owned(),
        Some(score) => {
            let sign = if score.deviations < 0.0 { "−" } else { "" };
            format!("{sign}{:.1}", score.deviations.abs())
        }
    }
}

/// So many of something.
#[must_use]
pub fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}
