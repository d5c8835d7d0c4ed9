//! What the colours of photons mean, and the choice of colours.

use egui::{Align2, Color32, Rect, Role, Sense, StrokeKind, Ui, UiBuilder, Vec2, WidgetInfo, pos2};
use neumann_core::photons::PhotonPicture;
use neumann_picture::photons::{PhotonColours, PhotonLook, PowerScale};

use super::words;
use crate::theme::{self, GRID, Palette, ROW};
use crate::views::plate;
use crate::widgets::{segmented_width, segments, significant};

/// Height of a line, points.
const LINE: f32 = 17.0;
/// Edge of a colour, points.
const SWATCH: f32 = 11.0;
/// Least width of one of two columns of keys, and the gap between them, points.
const COLUMN: f32 = 74.0;
const GAP: f32 = 2.0 * GRID;

/// The legend of photons as they are painted.
pub(super) struct Legend {
    title: &'static str,
    keys: Vec<Key>,
}

/// A colour with its meaning.
struct Key {
    colour: Color32,
    name: String,
    figure: String,
    is_shown: bool,
}

impl Legend {
    pub(super) fn new(photons: &PhotonPicture, scale: PowerScale, look: &PhotonLook) -> Self {
        let colour = |[r, g, b]: [u8; 3]| Color32::from_rgb(r, g, b);
        match look.colours {
            PhotonColours::Bounce => {
                let keys = look.bounce_keys(photons).into_iter();
                let keys = keys.map(|key| Key {
                    colour: colour(key.colour),
                    name: key.name(),
                    figure: format!("{} %", significant(100.0 * key.share, 2)),
                    is_shown: key.is_shown,
                });
                Self {
                    title: "bounce, share of photons",
                    keys: keys.collect(),
                }
            }
            PhotonColours::Power => {
                let keys = look.power_keys(scale).into_iter();
                let keys = keys.map(|(codes, name)| Key {
                    colour: colour(codes),
                    name,
                    figure: String::new(),
                    is_shown: true,
                });
                Self {
                    title: "power in a pixel",
                    keys: keys.collect(),
                }
            }
        }
    }

    /// Draws the legend in the lower right corner of `area`; yields the colours that were chosen.
    pub(super) fn show(
        &self,
        ui: &mut Ui,
        area: Rect,
        colours: PhotonColours,
    ) -> Option<PhotonColours> {
        let p = Palette::of(ui);
        let names = PhotonColours::ALL.map(PhotonColours::name);
        let control = Vec2::new(segmented_width(ui, &names), ROW + 4.0);
        let title = ui
            .painter()
            .layout_no_wrap(self.title.to_owned(), theme::small(), p.weak);
        // In a low window the keys stand in two columns, and their title gives way.
        let n_keys = self.keys.len() as f32;
        let head = control.y + GRID + LINE;
        let (head, n_columns, width) = if head + n_keys * LINE > 0.5 * area.height() {
            (control.y + GRID, 2, 2.0 * COLUMN + GAP)
        } else {
            (head, 1, title.size().x)
        };
        let n_rows = self.keys.len().div_ceil(n_columns).max(1);
        let width = width.max(control.x);
        let column_width = (width + GAP) / n_columns as f32 - GAP;
        let size = Vec2::new(width, head + n_rows as f32 * LINE);
        let corner = area.max - Vec2::new(2.0 * GRID, 1.5 * GRID);
        let spot = Rect::from_min_max(corner - size, corner);
        let painter = ui.painter().with_clip_rect(area);
        painter.rect_filled(spot.expand2(Vec2::new(GRID, 6.0)), 6, plate::ground(&p));
        if n_columns == 1 {
            let at = pos2(spot.left(), spot.top() + control.y + GRID / 2.0);
            painter.galley(at, title, p.weak);
        }
        for (i, key) in self.keys.iter().enumerate() {
            let (column, row) = (i / n_rows, i % n_rows);
            let left = spot.left() + column as f32 * (column_width + GAP);
            let middle = spot.top() + head + (row as f32 + 0.5) * LINE;
            let swatch =
                Rect::from_center_size(pos2(left + 0.5 * SWATCH, middle), Vec2::splat(SWATCH));
            let (fill, text) = if key.is_shown {
                (key.colour, p.text)
            } else {
                (key.colour.gamma_multiply(0.25), p.weak)
            };
            painter.rect(swatch, 2, fill, (1.0, p.line), StrokeKind::Outside);
            let font = theme::small();
            let at = pos2(swatch.right() + GRID, middle);
            painter.text(at, Align2::LEFT_CENTER, &key.name, font.clone(), text);
            let at = pos2(left + column_width, middle);
            painter.text(at, Align2::RIGHT_CENTER, &key.figure, font, p.weak);
        }
        let response = ui.interact(spot, ui.scope_id().with("legend"), Sense::hover());
        response.widget_info(|| WidgetInfo::labeled(Role::Label, true, self.in_words()));
        let row = Rect::from_min_size(spot.min, control);
        let chosen = PhotonColours::ALL.iter().position(|c| *c == colours);
        let clicked = ui
            .scope_builder(UiBuilder::new().max_rect(row).id_salt("colours"), |ui| {
                let about = |i: usize| words::about(PhotonColours::ALL[i]).to_owned();
                segments(ui, "colour photons by", &names, about, chosen.unwrap_or(0))
            })
            .inner;
        clicked.map(|i| PhotonColours::ALL[i])
    }

    /// The same for whoever does not see it.
    fn in_words(&self) -> String {
        let key = |key: &Key| format!("{} {}", key.name, key.figure);
        let keys: Vec<String> = self.keys.iter().map(key).collect();
        format!("legend, {}: {}", self.title, keys.join(", "))
    }
}
