//! The bottom line: how rendering is going.

use egui::{Align2, FontId, Rect, Ui, Vec2, pos2};
use neumann_core::render::StopRule;
use neumann_core::scene::OpeningProgress;

use crate::picture::Picture;
use crate::theme::{self, GRID, Palette};
use crate::widgets::significant;

/// What the bottom line says beside the statistics.
pub struct Status<'a> {
    /// The film as of this frame.
    pub picture: &'a Picture,
    /// When rendering is done.
    pub stop: StopRule,
    /// Rendering is paused.
    pub is_paused: bool,
    /// The picture is not yet of what has been asked for.
    pub is_waiting: bool,
    /// Iterations of a film of another size, and those that the picture has, which stays meanwhile.
    pub catching_up: Option<(u32, u32)>,
    /// The film would fit the window better in another size.
    pub can_fit: bool,
    /// How far a scene is that is being opened.
    pub opening: Option<&'a OpeningProgress>,
    /// Why the picture is biased, if it is.
    pub bias: Option<&'a str>,
}

/// Draws the line into `rect`.
pub fn show(ui: &mut Ui, rect: Rect, status: &Status<'_>) {
    let p = Palette::of(ui);
    let painter = ui.painter_at(rect);
    theme::fill_panel(ui, rect);
    painter.hline(rect.x_range(), rect.top() + 0.5, (1.0, p.line));
    let right = badge(ui, rect, status.bias);
    let mut spoken = String::new();
    let mut x = rect.left() + 2.0 * GRID;
    for (name, value, unit) in facts(status) {
        let mut width = 0.0;
        let pieces = [(&name, p.weak), (&value, p.text), (&unit, p.weak)];
        let galleys: Vec<_> = pieces
            .into_iter()
            .filter(|(text, _)| !text.is_empty())
            .map(|(text, color)| {
                let galley = painter.layout_no_wrap(text.clone(), font(), color);
                width += galley.size().x + 4.0;
                galley
            })
            .collect();
        if x + width > right {
            break;
        }
        for galley in galleys {
            let at = pos2(x, rect.center().y - galley.size().y / 2.0);
            x += galley.size().x + 4.0;
            painter.galley(at, galley, p.text);
        }
        x += 1.5 * GRID;
        for part in [name, value, unit] {
            if !part.is_empty() {
                spoken.push_str(&part);
                spoken.push(' ');
            }
        }
    }
    if let Some(done) = progress(status) {
        let line = Rect::from_min_size(rect.min, Vec2::new(rect.width() * done, 2.0));
        painter.rect_filled(line, 0, p.fill);
    }
    let response = ui.interact(rect, ui.scope_id().with("status"), egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Status, true, spoken.trim_end()));
}

fn font() -> FontId {
    theme::small()
}

/// Name, value and unit of everything the line says, most important first.
fn facts(status: &Status<'_>) -> Vec<(String, String, String)> {
    let fact = |name: &str, value: String, unit: &str| (name.to_owned(), value, unit.to_owned());
    let mut facts = Vec::new();
    let picture = status.picture;
    if let Some(opening) = status.opening {
        facts.push(fact("opening", opening.step().what().to_owned(), ""));
    }
    if !picture.is_there() {
        return facts;
    }
    let stats = &picture.stats;
    if status.is_paused {
        facts.push(fact("", "paused".to_owned(), ""));
    } else if let Some((n, of)) = status.catching_up {
        facts.push(fact("new size", format!("{n} of {of}"), ""));
    } else if stats.is_done && !status.is_waiting {
        facts.push(fact("", "done".to_owned(), ""));
    } else if status.is_waiting {
        facts.push(fact("", "starting".to_owned(), ""));
    } else if picture.divisor > 1 {
        facts.push(fact("", format!("1/{} resolution", picture.divisor), ""));
    }
    let iteration = match status.stop {
        StopRule::Iterations(n) if stats.n_iterations <= n => {
            format!("{} of {n}", stats.n_iterations)
        }
        _ => stats.n_iterations.to_string(),
    };
    facts.push(fact("iteration", iteration, ""));
    facts.push(fact("", format!("{:.1}", stats.seconds), "s"));
    facts.push(fact("", with_prefix(stats.samples_per_second), "samples/s"));
    facts.push(fact("", with_prefix(stats.rays_per_second), "rays/s"));
    facts.push(match stats.estimated_error {
        Some(error) => fact("estimated error", significant(100.0 * error, 2), "%"),
        None => fact("estimated error", "–".to_owned(), ""),
    });
    if let Some(photons) = stats.photons {
        if photons.radius > 0.0 {
            let radius = significant(f64::from(photons.radius), 3);
            facts.push(fact("radius", radius, "m"));
        }
        let stored = with_prefix(photons.n_vertices as f64);
        let megabytes = significant(photons.bytes as f64 / 1e6, 2);
        facts.push(fact("photons", stored, &format!("({megabytes} MB)")));
    }
    facts.push(fact("refused", stats.n_refused.to_string(), ""));
    let size = format!("{} × {}", picture.size.0, picture.size.1);
    let unit = if status.can_fit { "scaled" } else { "" };
    facts.push(fact("", size, unit));
    facts
}

fn progress(status: &Status<'_>) -> Option<f32> {
    if let Some(opening) = status.opening {
        return Some(opening.share());
    }
    let stats = &status.picture.stats;
    let done = match status.stop {
        StopRule::Never => return None,
        StopRule::Iterations(n) => f64::from(stats.n_iterations) / f64::from(n.max(1)),
        StopRule::Seconds(s) => stats.seconds / s.max(1e-9),
    };
    let is_full = status.picture.divisor == 1 && status.picture.is_there();
    Some(if is_full {
        done.clamp(0.0, 1.0) as f32
    } else {
        0.0
    })
}

/// Draws the bias badge; yields the right end of what is left of the line.
fn badge(ui: &Ui, rect: Rect, bias: Option<&str>) -> f32 {
    let p = Palette::of(ui);
    let edge = rect.right() - 2.0 * GRID;
    let Some(bias) = bias else { return edge };
    let font = FontId::new(theme::SMALL, theme::semibold().family);
    let galley = ui
        .painter()
        .layout_no_wrap("biased".to_owned(), font.clone(), p.on_amber);
    let size = galley.size() + Vec2::new(2.0 * GRID, 4.0);
    let plate = Rect::from_min_size(pos2(edge - size.x, rect.center().y - size.y / 2.0), size);
    ui.painter().rect_filled(plate, 4, p.amber);
    ui.painter().text(
        plate.center(),
        Align2::CENTER_CENTER,
        "biased",
        font,
        p.on_amber,
    );
    let response = ui.interact(plate, ui.scope_id().with("bias"), egui::Sense::hover());
    let text = format!("biased: {bias}");
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &text));
    response.on_hover_text(text);
    plate.left() - GRID
}

/// A number with k, M or G.
#[must_use]
pub fn with_prefix(value: f64) -> String {
    let (factor, prefix) = match value {
        v if v >= 1e9 => (1e9, " G"),
        v if v >= 1e6 => (1e6, " M"),
        v if v >= 1e3 => (1e3, " k"),
        _ => (1.0, ""),
    };
    format!("{}{prefix}", significant(value / factor, 3))
}

#[cfg(test)]
mod tests {
    use super::with_prefix;

    #[test]
    fn prefixes() {
        assert_eq!(with_prefix(2_310_000.0), "2.31 M");
        assert_eq!(with_prefix(950.0), "950");
    }
}
