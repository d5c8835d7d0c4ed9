//! The caption on the picture: the part of the series as a formula and in words, what is compared,
//! and what the method cannot see of it.

use egui::{Painter, Pos2, Rect, Vec2};
use neumann_core::film::View as Part;

use crate::blind_spots;
use crate::compared::Compared;
use crate::display::ViewSettings;
use crate::formula::Formula;
use crate::region;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::views::plate;

/// What stands in the upper left corner of the picture.
pub(super) struct Caption {
    /// The part of the series, where there is only one.
    formula: Option<Part>,
    text: String,
    notes: Vec<String>,
    is_compared: bool,
}

impl Caption {
    pub(super) fn of(session: &Session, settings: &ViewSettings, compared: &Compared) -> Self {
        let part = settings.part;
        if let Some([a, b]) = compared.sides() {
            let mut notes = compared.lines();
            let measured = session.measuring.of(session, compared);
            notes.extend(measured.map(|measured| measured.words()));
            return Self {
                formula: (a.part == b.part).then_some(a.part),
                text: compared.title(),
                notes,
                is_compared: true,
            };
        }
        let region = session.region().map(|region| {
            let [x, y] = region.at;
            let size = region::words(&region);
            format!("region {size} at {x}, {y}")
        });
        let drawing = settings
            .drawing
            .map(|drawing| match drawing.region(session.setup.size) {
                Some(drawn) => region::words(&drawn),
                None => "drag a rectangle to render it alone; Esc leaves".to_owned(),
            });
        let is_kept = part.layers(session.picture.n_layers).is_some();
        let refusal = match compared {
            Compared::Refused(why) => Some(why.clone()),
            _ => None,
        };
        Self {
            formula: Some(part),
            text: if is_kept {
                part.caption()
            } else {
                "not kept apart; raise the number of terms".to_owned()
            },
            notes: refusal
                .into_iter()
                .chain(drawing)
                .chain(region)
                .chain(blind_spots_of(session, part))
                .collect(),
            is_compared: false,
        }
    }

    /// The same for whoever does not see it.
    pub(super) fn spoken(&self) -> String {
        let what = if self.is_compared {
            "compared"
        } else {
            "picture"
        };
        let notes: String = self.notes.iter().map(|note| format!("; {note}")).collect();
        format!("{what}: {}{notes}", self.text)
    }

    /// Draws it in the upper left corner of `rect`, where the picture begins at `edge`; yields what
    /// it covers.
    pub(super) fn show(&self, painter: &Painter, rect: Rect, edge: Pos2, p: &Palette) -> Rect {
        let room = rect.width() - 6.0 * GRID;
        let formula = self.formula;
        let formula = formula.map(|part| Formula::full(painter, part, theme::CAPTION, p.text));
        let below = formula
            .as_ref()
            .map_or(0.0, |f| theme::CAPTION * 1.15 + f.size.y * 0.22);
        let text = painter.layout(self.text.clone(), theme::body(), p.text, room);
        let notes = self.notes.iter();
        let notes: Vec<_> = notes
            .map(|note| painter.layout(note.clone(), theme::small(), p.weak, room))
            .collect();
        let width = notes.iter().chain([&text]).map(|line| line.size().x);
        let width = width.fold(formula.as_ref().map_or(0.0, |f| f.size.x), f32::max);
        let heights = notes.iter().map(|note| note.size().y + 2.0);
        let height = below + text.size().y + heights.sum::<f32>();
        let at = plate::corner(rect, edge, Vec2::new(width, height));
        let spot = Rect::from_min_size(at, Vec2::new(width, height));
        let plate = spot.expand2(plate::MARGIN);
        painter.rect_filled(plate, 6, theme::plate(p));
        if let Some(formula) = formula {
            formula.paint(painter, at);
        }
        let mut y = below + text.size().y + 2.0;
        painter.galley(at + Vec2::new(0.0, below), text, p.text);
        for note in notes {
            let height = note.size().y;
            painter.galley(at + Vec2::new(0.0, y), note, p.weak);
            y += height + 2.0;
        }
        plate
    }
}

/// What the method on screen cannot see of a part, if the picture is of it.
fn blind_spots_of(session: &Session, part: Part) -> Option<String> {
    let open = session.setup.open.as_ref()?;
    if !session.is_current() {
        return None;
    }
    blind_spots::note(
        session.setup.method().sight,
        open.scene.appearance(),
        part,
        session.picture.n_layers,
    )
}
