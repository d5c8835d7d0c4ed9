//! The list of pixels that stand out; a click asks which path has made one of them.

use std::time::{Duration, Instant};

use egui::Ui;
use neumann_core::film::Firefly;

use crate::session::Session;
use crate::widgets::{hint, paragraph, row_button, significant};

/// How many are listed.
const N_LISTED: usize = 12;
/// The film is looked through anew no more often than this.
const PERIOD: Duration = Duration::from_secs(1);

/// The pixels that stood out when the film was looked through last.
#[derive(Default)]
pub(super) struct Fireflies {
    found: Vec<Firefly>,
    /// When that was, and the version of the picture then.
    looked: Option<(Instant, u64)>,
}

impl Fireflies {
    /// Looks through the film, if there is something new.
    fn follow(&mut self, session: &Session) {
        let version = session.picture.version;
        let is_fresh = |(when, of): (Instant, u64)| of == version || when.elapsed() < PERIOD;
        if self.looked.is_some_and(is_fresh) {
            return;
        }
        let found = session
            .picture
            .read_film(&session.link, |film, divisor, region| {
                let [left, top] = region.map_or([0, 0], |(_, region)| region.at);
                let mut found = film.fireflies(N_LISTED);
                for firefly in &mut found {
                    let [x, y] = firefly.pixel;
                    firefly.pixel = [left + x * divisor, top + y * divisor];
                }
                found
            });
        self.found = found.unwrap_or_default();
        self.looked = Some((Instant::now(), version));
    }

    /// Lists them; yields the one that was clicked.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        session: &Session,
        inspected: Option<[usize; 2]>,
    ) -> Option<[usize; 2]> {
        self.follow(session);
        if self.found.is_empty() {
            paragraph(ui, "No pixel stands out from those around it.");
            return None;
        }
        hint(ui, "Brighter than those around them, by few paths");
        let mut clicked = None;
        for Firefly {
            pixel,
            luminance,
            around,
        } in &self.found
        {
            let [x, y] = pixel;
            let times = match luminance / around {
                times if times < 1000.0 => format!("{} times", significant(f64::from(times), 2)),
                _ => "in the dark".to_owned(),
            };
            let is_chosen = inspected == Some(*pixel);
            let response = row_button(ui, &format!("x {x}  y {y}"), &times, is_chosen);
            let about = format!(
                "Luminance {}, {} around it. A click shows the path that has made it so bright.",
                significant(f64::from(*luminance), 3),
                significant(f64::from(*around), 3)
            );
            if response.on_hover_text(about).clicked() {
                clicked = Some(*pixel);
            }
        }
        clicked
    }
}
