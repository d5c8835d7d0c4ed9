//! Methods at equal processor time, side by side, with their errors over time: a race that is held
//! while one looks.
//!
//! While the view is open the film rests. [`RaceView`] owns who takes part and what is looked at;
//! `held` holds the race on a thread of its own, `judged` keeps what was measured, `reference` is
//! what all are judged by, and `cache` keeps it on disk. `tiles`, `curves` and `enlarged` draw.

mod cache;
mod curves;
mod enlarged;
mod held;
mod judged;
mod reference;
mod tiles;

use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use egui::{Key, Pos2, Rect, Ui, pos2, vec2};
use neumann_picture::race::{Entrant, Measure, Point, seconds_to};
use neumann_picture::sheet::{RacePicture, RaceSheet, race_sheet};
use neumann_picture::tone::Display;

use super::entry::{self, Entry};
use super::held::{Follower, Held, PERIOD, lock};
use super::method_menu::{MethodMenu, Rules};
use super::{Needs, Row, Shown, Stage, View};
use crate::display::{ViewSettings, ground};
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::session::Session;
use crate::theme::{self, GRID, Palette};
use crate::widgets::{button, button_width, cut_line, segmented_width, segments};

pub use cache::folder as cache_folder;
pub use enlarged::Wipe;
pub use held::{Report, Standing};

use held::Entries;
use tiles::Picture;

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Race methods",
    about: "Two to four methods at equal processor time, with their errors over time",
    key: Some(keys::line(
        keys::DISPLAY,
        "K",
        "race of methods at equal time",
        &[keys::on(keys::NONE, Key::K, Action::View(ID))],
    )),
    needs: Needs {
        rest: true,
        ..Needs::NOTHING
    },
    refusal: |setup| {
        let text = "There is no scene yet to race methods on";
        setup.open.is_none().then(|| text.to_owned())
    },
    build: || Box::new(RaceView::default()),
};

const ID: &str = "race";
/// What its menus allow.
const RULES: Rules = Rules {
    least: 2,
    may_repeat: false,
    why_removed: "Takes this method out of the race, which begins anew.",
};

/// The race view: who takes part, and what of it is looked at.
#[derive(Default)]
pub struct RaceView {
    /// Who takes part.
    pub entries: Vec<Entry>,
    /// Which error the curves show.
    pub measure: Measure,
    /// The error that the time to is told of; the worst of the latest ones where it is `None`.
    pub quality: Option<f64>,
    /// The picture that is enlarged: a method's, or behind them the reference.
    pub enlarged: Option<usize>,
    /// What it is wiped over.
    pub wipe: Option<Wipe>,
    /// Folder of references from one start to the next; `None` keeps none.
    pub cache: Option<PathBuf>,
    /// How the race stands.
    pub report: Report,
    /// The method whose menu is open, and what stands in its text field.
    menu: MethodMenu,
    race: Follower<Entries, Report>,
    /// How pictures are shown from now on; FLIP depends on it.
    display: Arc<Mutex<Display>>,
    pictures: Vec<Picture>,
    is_paused: bool,
    is_opening: bool,
}

impl RaceView {
    /// Processor time of each method after which its error was as low as the chosen one, and that.
    #[must_use]
    pub fn times_to_quality(&self) -> Option<(f64, Vec<Option<f64>>)> {
        let measure = self.measure;
        let curves = || self.report.standings.iter().map(|s| &s.curve[..]);
        let latest = curves().filter_map(<[Point]>::last);
        let worst = latest.map(|point| measure.of(&point.comparison));
        let worst = worst.filter(|error| error.is_finite()).reduce(f64::max);
        let quality = self.quality.or(worst)?;
        let times = curves().map(|curve| seconds_to(curve, measure, quality));
        Some((quality, times.collect()))
    }

    /// Lets these take part, whatever the method of the picture is; the usual ones if there are
    /// fewer than two.
    pub fn enter(&mut self, entries: Vec<Entry>) {
        self.is_opening &= entries.len() < 2;
        self.entries = entries;
    }

    /// True while a race is held.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.race.is_held()
    }

    /// What is to be raced, of what the window is to render.
    fn wanted(&self, session: &Session) -> Option<Entries> {
        let job = session.link.started()?;
        let entrants = self.entries.iter();
        let entrants: Vec<Entrant> = entrants.map(|e| e.entrant(&session.setup)).collect();
        // The method that the picture is rendered by is of no account.
        let mut common = entrants.first()?.settings(&job.settings);
        common.n_layers = 1;
        Some(Entries {
            scene: Arc::clone(&job.scene),
            entrants,
            given: reference::given(session, &common),
            common,
        })
    }

    /// Sees that what is raced is what is wanted, once that has come to rest.
    fn follow(&mut self, session: &Session, settings: &ViewSettings) {
        let Some(wanted) = self.wanted(session) else {
            return;
        };
        let Some(pool) = session.link.pool() else {
            return;
        };
        let is_first = self.report.standings.is_empty();
        let (cache, display) = (self.cache.clone(), Arc::clone(&self.display));
        *lock(&display) = settings.display();
        let has_begun = self.race.follow(&wanted, is_first, |entries| {
            let pool = pool.clone();
            Held::begin(ID, move |shared| {
                held::hold(shared, &entries, &pool, &display, cache);
            })
        });
        if has_begun {
            self.pictures.clear();
            self.report = Report::default();
        }
    }
}

impl View for RaceView {
    fn open(&mut self, _settings: &ViewSettings) {
        self.is_opening = true;
    }

    fn close(&mut self) {
        *self = Self {
            entries: std::mem::take(&mut self.entries),
            measure: self.measure,
            cache: self.cache.take(),
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, settings: &ViewSettings) -> bool {
        let method = session.setup.method;
        let is_in = self
            .entries
            .iter()
            .any(|e| e.method(&session.setup) == method);
        if std::mem::take(&mut self.is_opening) && !is_in || self.entries.len() < 2 {
            self.entries = entry::row_with(method);
        }
        self.follow(session, settings);
        self.is_paused = session.link.is_paused();
        if let Some(race) = self.race.held() {
            race.pause(self.is_paused);
            *lock(&self.display) = settings.display();
            if let Some(report) = race.take_news() {
                self.report = report;
            }
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        let p = Palette::of(ui);
        let rect = stage.rect;
        ground::fill(ui, rect, p.ground);
        let inner = rect.shrink2(vec2(2.0 * GRID, 0.0));
        let head = Rect::from_min_size(inner.min, vec2(inner.width(), head_height(rect)));
        self.head(ui, head, &p);
        let below = Rect::from_min_max(
            pos2(inner.left(), head.bottom()),
            pos2(inner.right(), inner.bottom() - GRID),
        );
        if self.enlarged.is_some() {
            enlarged::show(ui, below, self, stage.settings);
        } else {
            let split = tiles::height(below, self.entries.len(), self.aspect(stage.session));
            let row = Rect::from_min_size(below.min, vec2(below.width(), split));
            tiles::row(ui, row, self, stage);
            let plot = Rect::from_min_max(pos2(below.left(), row.bottom() + GRID), below.max);
            curves::show(ui, plot, self);
        }
        self.menu
            .show(ui, &mut self.entries, &RULES, &stage.session.setup);
        if self.race.is_busy() {
            ui.ctx().request_repaint_after(PERIOD);
        }
        None
    }

    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let report = self.report.clone();
        let reference = report.reference.clone()?;
        let display = settings.display();
        let open = session.setup.open.as_ref();
        let scene = open.map_or("scene", |open| open.short_name()).to_owned();
        let pixels = move || {
            let standings = report.standings.iter();
            let pictures: Vec<RacePicture<'_>> = standings
                .filter_map(|standing| {
                    Some(RacePicture {
                        image: standing.image.as_deref()?,
                        name: &standing.name,
                        curve: &standing.curve,
                    })
                })
                .collect();
            let line = format!(
                "equal processor time · {}×{}",
                reference.width, reference.height
            );
            race_sheet(&RaceSheet {
                heading: [&scene, &line],
                pictures: &pictures,
                reference: (&reference, &report.reference_words),
                display,
            })
        };
        Some(Shown {
            name: ID.to_owned(),
            pixels: Box::new(pixels),
        })
    }

    fn n_iterations(&self) -> u32 {
        let last = |s: &Standing| s.curve.last().map_or(0, |point| point.n_iterations);
        let standings = self.report.standings.iter();
        standings.map(last).min().unwrap_or(0)
    }

    fn step_back(&mut self) -> bool {
        self.menu.close() || self.enlarged.take().is_some()
    }
}

fn head_height(rect: Rect) -> f32 {
    if rect.height() < 320.0 { 36.0 } else { 48.0 }
}

impl RaceView {
    fn aspect(&self, session: &Session) -> f32 {
        let size = session.link.started().map(|job| &job.settings);
        size.map_or(1.0, |s| s.width.max(1) as f32 / s.height.max(1) as f32)
    }

    /// What this is, what all are judged by, and the choice of the error.
    fn head(&mut self, ui: &mut Ui, rect: Rect, p: &Palette) {
        let names = Measure::ALL.map(Measure::name);
        let can_add = self.entries.len() < neumann_picture::race::MOST;
        let add = "Add method";
        let of_add = if can_add {
            button_width(ui, add) + GRID
        } else {
            0.0
        };
        let width = segmented_width(ui, &names) + of_add;
        let spot = Rect::from_min_size(
            pos2(rect.right() - width, rect.center().y - 14.0),
            vec2(width, 28.0),
        );
        let builder = egui::UiBuilder::new()
            .max_rect(spot)
            .layout(egui::Layout::left_to_right(egui::Align::Center))
            .id_salt("race head");
        ui.scope_builder(builder, |ui| {
            if can_add {
                let about = "One more method, which the race begins anew with.";
                if button(ui, add).on_hover_text(about).clicked() {
                    entry::add(&mut self.entries);
                }
            }
            let about = |i: usize| match Measure::ALL[i] {
                Measure::RelMse => "The curves show the mean relative square error.".to_owned(),
                Measure::Flip => "The curves show FLIP: what an eye sees of the error.".to_owned(),
            };
            let chosen = Measure::ALL.iter().position(|m| *m == self.measure);
            if let Some(i) = segments(ui, "error", &names, about, chosen.unwrap_or(0)) {
                self.measure = Measure::ALL[i];
                self.quality = None;
            }
        });
        let title = if self.is_paused {
            "Race at equal processor time, paused (Space)"
        } else {
            "Race at equal processor time"
        };
        let words = match self.report.reference_words.as_str() {
            "" => "the reference begins …".to_owned(),
            words => format!("reference: {words}"),
        };
        let room = spot.left() - GRID - rect.left();
        let line = |text: String, font, color| cut_line(ui.painter(), text, font, color, room);
        let title = line(title.to_owned(), theme::body(), p.text);
        let facts = line(words.clone(), theme::small(), p.weak);
        let middle = rect.center().y;
        let at = pos2(rect.left(), middle - title.size().y);
        let spot = Rect::from_min_size(at, vec2(room, title.size().y + facts.size().y));
        ui.painter().galley(at, title, p.text);
        ui.painter()
            .galley(pos2(rect.left(), middle + 1.0), facts, p.weak);
        let heard = ui.interact(spot, ui.scope_id().with("race facts"), egui::Sense::hover());
        heard.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, &words));
        heard.on_hover_text(words.clone());
    }
}
