//! What stands beside the map: the methods, what is looked at, the table of the terms, and what
//! follows from it.

use egui::{Align2, Color32, Role, Sense, Ui, Vec2, WidgetInfo, pos2};
use neumann_picture::agreement::{FULL_COLOUR, Grain, Row, Term, colour};

use super::words::{self, Verdict};
use super::{AgreeView, Found, LENGTHS};
use crate::formula::Formula;
use crate::theme::{self, GRID, Palette};
use crate::views::column::{lengths, table_heading, table_row};
use crate::views::{Stage, method_menu};
use crate::widgets::{choice_row, paragraph};

/// Where its columns end, as shares of the width.
const ENDS: [f32; 3] = [0.5, 0.7, 1.0];

/// Draws the column.
pub(super) fn contents(ui: &mut Ui, view: &mut AgreeView, stage: &mut Stage<'_>) {
    ui.spacing_mut().item_spacing.y = 3.0;
    methods(ui, view, stage);
    const GRAINS: [&str; 2] = [
        "A block beyond the limit has a colour. The verdict is by blocks.",
        "Each pixel has the colour of its own score, beyond a limit of its own. Pixels are shown, \
         not judged.",
    ];
    let grains = [Grain::Blocks, Grain::Pixels];
    let chosen = grains.iter().position(|grain| *grain == view.grain);
    let about = |i: usize| GRAINS[i].to_owned();
    let labels = ["blocks", "pixels"];
    if let Some(i) = choice_row(ui, "Coloured", &labels, about, chosen.unwrap_or(0)) {
        view.grain = grains[i];
    }
    let about = |n: u32| {
        format!(
            "{n} iterations make a batch. A radius that shrinks does so within a batch; longer \
             batches judge rarer light. A change begins anew."
        )
    };
    let name = "Iterations a batch";
    lengths(ui, name, &LENGTHS, about, &mut view.n_iterations);
    ui.add_space(GRID / 2.0);
    let Some(found) = view.found.clone() else {
        paragraph(ui, "The first batches are rendered …");
        return;
    };
    table(ui, &found, stage);
    ui.add_space(GRID / 2.0);
    for line in &found.verdict {
        paragraph(ui, line);
    }
}

/// The two methods, each with the mark of the colour that it is brighter in.
fn methods(ui: &mut Ui, view: &mut AgreeView, stage: &Stage<'_>) {
    for i in 0..view.entries.len() {
        let name = view.entries[i].entrant(&stage.session.setup).name;
        let size = Vec2::new(ui.available_width(), 26.0);
        let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
        let sign = if i == 0 { FULL_COLOUR } else { -FULL_COLOUR };
        let mark = |ui: &Ui, at| {
            let [r, g, b] = colour(sign);
            ui.painter()
                .circle_filled(at, 4.5, Color32::from_rgb(r, g, b));
        };
        let (response, spot) = method_menu::name_button(ui, rect, i, [&name, "method"], mark);
        if response.clicked() {
            view.menu.toggle(i, spot, name);
        }
        let shade = if i == 0 { "Orange" } else { "Blue" };
        response.on_hover_text(format!(
            "{shade} is where this method is brighter. A click shows other methods."
        ));
    }
}

/// A row for each term: a click shows its map.
fn table(ui: &mut Ui, found: &Found, stage: &mut Stage<'_>) {
    table_heading(ui, &ENDS, &["ratio", "score", "beyond"]);
    for term in &found.agreement.terms {
        row(ui, found, term, stage);
    }
}

fn row(ui: &mut Ui, found: &Found, term: &Term, stage: &mut Stage<'_>) {
    let p = Palette::of(ui);
    let is_chosen = Found::part(stage.settings.part) == term.view;
    let said = Row::of(term);
    // A mark that can be told apart without its colour.
    let (mark, color) = match Verdict::of(found, term) {
        Verdict::None => ("?", p.weak),
        Verdict::Noise => ("≈", p.weak),
        Verdict::Bias => ("≠", p.amber),
    };
    let cells = [&said.ratio, &said.score, &said.beyond].map(String::as_str);
    let response = table_row(ui, is_chosen, &ENDS, &cells, |painter, left, middle| {
        let at = pos2(left, middle);
        painter.text(at, Align2::LEFT_CENTER, mark, theme::semibold(), color);
        let name = Formula::name(painter, term.view, theme::BODY, p.text);
        name.paint(painter, pos2(left + 16.0, middle - 0.5 * name.size.y));
    });
    if response.clicked() {
        stage.settings.part = term.view;
    }
    let verdict = words::verdict(found, term);
    let label = format!("{}: {verdict}", said.term);
    response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, &label));
    let [a, b] = &found.names;
    response.on_hover_text(format!(
        "{label}\nMean {} by {a}, {} by {b}, ratio {}. A difference is seen from {} on. Score of \
         the whole picture {}, the largest of its cells {}; {} cells beyond the limit.\nA click \
         shows its map.",
        said.means[0],
        said.means[1],
        said.ratio,
        said.seen_from,
        said.score,
        said.largest,
        said.beyond
    ));
}
