//! What `neumann agree` says as JSON.

use neumann_picture::agreement::{CHANNELS, Report, ratio};
use serde_json::{Value, json};

/// The table and its verdict as one object.
pub(super) fn json(scene: &str, report: &Report<'_>) -> Value {
    let agreement = report.agreement;
    let methods = report.sides.iter().map(|side| {
        json!({
            "method": side.name,
            "batches": side.batches.n(),
            "iterations": side.n_iterations,
            "seconds": side.seconds,
            "bias": side.settings.method.bias,
            "blind_spots": side.settings.method.blind_spots,
        })
    });
    let terms = agreement.terms.iter().map(|term| {
        json!({
            "term": term.view.to_string(),
            "mean": term.means,
            "ratio": ratio(term),
            "seen_from": term.seen_from,
            "score": term.whole().map(|score| score.deviations),
            "largest": term.largest().map(|(cell, score)| {
                let cell = agreement.cells.cell(cell);
                json!({
                    "score": score.deviations,
                    "channel": CHANNELS[score.channel],
                    "columns": cell.x,
                    "rows": cell.y,
                })
            }),
            "judged": term.n_judged(),
            "rare": term.n_rare,
            "beyond": term.n_beyond,
            "black": term.n_beyond_black,
        })
    });
    json!({
        "scene": scene,
        "methods": methods.collect::<Value>(),
        "agree": agreement.holds(),
        "level": agreement.level,
        "scores": agreement.n_scores,
        "limit": agreement.limit,
        "terms": terms.collect::<Value>(),
    })
}
