//! What stands beside the map: what is looked at, the line, the table of the terms.

use egui::{Role, Ui, WidgetInfo, pos2};
use neumann_core::film::View as Part;
use neumann_picture::radius_bias::{Half, Row};

use super::{BiasView, LENGTHS, measured};
use crate::formula::Formula;
use crate::theme::{self, GRID, Palette};
use crate::views::Stage;
use crate::views::column::{lengths, table_heading, table_row};
use crate::widgets::{choice_row, paragraph};

/// Where the columns of the table end, as shares of the width.
const ENDS: [f32; 3] = [0.38, 0.58, 1.0];

/// Draws the column.
pub(super) fn contents(ui: &mut Ui, view: &mut BiasView, stage: &mut Stage<'_>) {
    ui.spacing_mut().item_spacing.y = 3.0;
    const HALVES: [&str; 2] = [
        "What chance makes: renders that differ in their seed alone spread by so much.",
        "What the radius makes, by how the picture differs from one at half of it.",
    ];
    let chosen = Half::ALL.iter().position(|half| *half == view.half);
    let labels = Half::ALL.map(Half::name);
    let about = |i: usize| HALVES[i].to_owned();
    if let Some(i) = choice_row(ui, "Map", &labels, about, chosen.unwrap_or(0)) {
        view.half = Half::ALL[i];
    }
    let about = |n: u32| {
        format!("The error is that of a picture after {n} iterations. A change begins anew.")
    };
    let name = "Iterations a render";
    lengths(ui, name, &LENGTHS, about, &mut view.n_iterations);
    ui.add_space(GRID / 2.0);
    let part = measured(stage.settings.part);
    let Some(found) = view.found() else {
        paragraph(ui, &view.waiting());
        return;
    };
    let said = found.parts.iter().find(|(view, ..)| *view == part);
    for line in said.iter().flat_map(|(.., said)| said) {
        paragraph(ui, line);
    }
    ui.add_space(GRID / 2.0);
    table(ui, &found.parts, stage);
    ui.add_space(GRID / 2.0);
    for note in &found.notes {
        paragraph(ui, note);
    }
}

/// A row for each part: a click shows its map.
fn table(ui: &mut Ui, parts: &[(Part, Row, [String; 2])], stage: &mut Stage<'_>) {
    let p = Palette::of(ui);
    table_heading(ui, &ENDS, &["error", "noise", "radius bias"]);
    for (part, row, [line, then]) in parts {
        let is_chosen = measured(stage.settings.part) == *part;
        let cells = [&row.error, &row.noise, &row.bias].map(String::as_str);
        let response = table_row(ui, is_chosen, &ENDS, &cells, |painter, left, middle| {
            let name = Formula::name(painter, *part, theme::BODY, p.text);
            name.paint(painter, pos2(left, middle - 0.5 * name.size.y));
        });
        if response.clicked() {
            stage.settings.part = *part;
        }
        let label = format!("{}: mostly {}", row.term, row.larger);
        let spoken = format!("{label}\n{line} {then}\nA click shows its map.");
        response.widget_info(|| WidgetInfo::selected(Role::RadioButton, true, is_chosen, &label));
        response.on_hover_text(spoken);
    }
}
