//! The bottom line: how rendering is going.

use egui::{Align2, FontId, Rect, Ui, Vec2, pos2};
use neumann_core::render::StopRule;
use neumann_core::scene::OpeningProgress;
use neumann_core::scene::description::Crop;

use crate::picture::Picture;
use crate::region;
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
    /// It is kept since a region was rendered.
    pub is_after_region: bool,
    /// The region that is rendered.
    pub region: Option<Crop>,
    /// The film would fit the window better in another size.
    pub can_fit: bool,
    /// How far a scene is that is being opened.
    pub opening: Option<&'a OpeningProgress>,
    /// Why the picture is biased, if it is.
    pub bias: Option<&'a str>,
}

/// Draws the line into `rect`; true if the region is to end.
pub fn show(ui: &mut Ui, rect: Rect, status: &Status<'_>) -> bool {
    let p = Palette::of(ui);
    let painter = ui.painter_at(rect);
    theme::fill_panel(ui, rect);
    painter.hline(rect.x_range(), rect.top() + 0.5, (1.0, p.line));
    let right = badge(ui, rect, status.bias);
    let mut spoken = String::new();
    let mut tips = Vec::new();
    let mut x = rect.left() + 2.0 * GRID;
    for (i, fact) in facts(status).into_iter().enumerate() {
        let Fact {
            name,
            value,
            unit,
            about,
            ends_region,
        } = fact;
        let start = x;
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
        let spot = Rect::from_x_y_ranges(start..=x, rect.y_range());
        tips.push((spot, i, about, ends_region));
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
    let mut ends = false;
    for (spot, i, about, ends_region) in tips {
        let id = ui.scope_id().with(("fact", i));
        if !ends_region {
            ui.interact(spot, id, egui::Sense::hover())
                .on_hover_text(about);
            continue;
        }
        let response = ui.interact(spot, id, egui::Sense::click());
        let name = "End the region";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
        let is_active = response.hovered() || response.has_focus();
        let line = if is_active { p.weak } else { p.line };
        let plate = Rect::from_x_y_ranges(spot.x_range().expand(4.0), spot.y_range());
        painter.rect_stroke(plate.shrink2(Vec2::new(0.0, 3.0)), 4, (1.0, line), INSIDE);
        ends |= response.clicked();
        response.on_hover_text(about);
    }
    ends
}

const INSIDE: egui::StrokeKind = egui::StrokeKind::Inside;

/// A figure of the line.
struct Fact {
    name: String,
    value: String,
    unit: String,
    /// What it is, in a sentence.
    about: &'static str,
    /// It is a button that ends the region.
    ends_region: bool,
}

fn font() -> FontId {
    theme::small()
}

/// Name, value and unit of everything the line says, most important first.
fn facts(status: &Status<'_>) -> Vec<Fact> {
    let fact = |name: &str, value: String, unit: &str, about| Fact {
        name: name.to_owned(),
        value,
        unit: unit.to_owned(),
        about,
        ends_region: false,
    };
    let mut facts = Vec::new();
    let picture = status.picture;
    if let Some(opening) = status.opening {
        let about = "A scene is being opened; the one before stays until it is there.";
        facts.push(fact("opening", opening.step().what().to_owned(), "", about));
    }
    if !picture.is_there() {
        return facts;
    }
    let stats = &picture.stats;
    if let Some(region) = &status.region {
        let about = "Only this part of the picture is rendered; around it stands what was there \
                     before. Press here, B or Esc to render all of it again.";
        facts.push(Fact {
            ends_region: true,
            ..fact("region", region::words(region), "end", about)
        });
    }
    if status.is_paused {
        let about = "Rendering waits and keeps all samples; Space resumes it.";
        facts.push(fact("", "paused".to_owned(), "", about));
    } else if let Some((n, of)) = status.catching_up {
        let (name, about) = if status.is_after_region {
            let about = "Iterations of the whole picture, which began anew after the region; the \
                         old picture stays until it has as many.";
            ("whole picture", about)
        } else {
            let about = "Iterations of the film of the new size; the old picture stays until it \
                         has as many.";
            ("new size", about)
        };
        facts.push(fact(name, format!("{n} of {of}"), "", about));
    } else if stats.is_done && !status.is_waiting {
        let about = "Rendering has ended, as 'Stop after' on the Method page asks.";
        facts.push(fact("", "done".to_owned(), "", about));
    } else if status.is_waiting {
        let about = "The picture is still of what was rendered before.";
        facts.push(fact("", "starting".to_owned(), "", about));
    } else if picture.divisor > 1 {
        let about = "A coarse picture, which is there sooner; finer ones follow.";
        let text = format!("1/{} resolution", picture.divisor);
        facts.push(fact("", text, "", about));
    }
    let iteration = match status.stop {
        StopRule::Iterations(n) if stats.n_iterations <= n => {
            format!("{} of {n}", stats.n_iterations)
        }
        _ => stats.n_iterations.to_string(),
    };
    let about = "Complete estimates of the picture so far; what is shown is their mean.";
    facts.push(fact("iteration", iteration, "", about));
    let about = "Time spent on rendering, pauses left out.";
    facts.push(fact("", format!("{:.1}", stats.seconds), "s", about));
    let about = "Samples of pixels in a second: each is one path or more through a pixel.";
    let samples = with_prefix(stats.samples_per_second);
    facts.push(fact("", samples, "samples/s", about));
    let about = "Rays in a second that were followed to the next surface or tested for shadow.";
    let rays = with_prefix(stats.rays_per_second);
    facts.push(fact("", rays, "rays/s", about));
    let about = "Estimated noise: the standard error of all pixels, as a share of the mean \
                 radiance, without bias. It halves with four times the time.";
    facts.push(match stats.estimated_error {
        Some(error) => {
            let percent = significant(100.0 * error, 2);
            fact("estimated error", percent, "%", about)
        }
        None => fact("estimated error", "–".to_owned(), "", about),
    });
    if let Some(photons) = stats.photons {
        if photons.radius > 0.0 {
            let about = "Distance within which photons count for a point in this iteration.";
            let radius = significant(f64::from(photons.radius), 3);
            facts.push(fact("radius", radius, "m", about));
        }
        let about = "Places where light paths landed that are kept for this iteration, and the \
                     memory that they take.";
        let stored = with_prefix(photons.n_vertices as f64);
        let megabytes = significant(photons.bytes as f64 / 1e6, 2);
        let unit = format!("({megabytes} MB)");
        facts.push(fact("photons", stored, &unit, about));
    }
    let about = "Contributions that were left out, because they were not finite or negative.";
    facts.push(fact("refused", stats.n_refused.to_string(), "", about));
    let (width, height) = status
        .region
        .map_or(picture.size, |region| region.of.into());
    let size = format!("{width} × {height}");
    let (unit, about) = if status.can_fit {
        let about = "Pixels of the film. It is shown scaled, as the window has another size; \
                     Shift Z begins a film that fits.";
        ("scaled", about)
    } else {
        ("", "Pixels of the film, columns and rows.")
    };
    facts.push(fact("", size, unit, about));
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
    use neumann_core::render::StopRule;

    use super::{Status, facts, with_prefix};
    use crate::picture::Picture;

    #[test]
    fn every_figure_is_explained_in_a_sentence() {
        let mut picture = Picture::default();
        (picture.version, picture.divisor) = (1, 2);
        picture.stats.photons = Some(neumann_core::film::PhotonReport {
            radius: 0.1,
            ..Default::default()
        });
        let facts = facts(&Status {
            picture: &picture,
            stop: StopRule::Never,
            is_paused: false,
            is_waiting: false,
            catching_up: None,
            is_after_region: false,
            region: None,
            can_fit: true,
            opening: None,
            bias: None,
        });
        assert_eq!(facts.len(), 10);
        for fact in facts {
            let words = fact.about.split_whitespace().count();
            assert!(fact.about.ends_with('.') && words > 5, "{}", fact.about);
        }
    }

    #[test]
    fn prefixes() {
        assert_eq!(with_prefix(2_310_000.0), "2.31 M");
        assert_eq!(with_prefix(950.0), "950");
    }
}
