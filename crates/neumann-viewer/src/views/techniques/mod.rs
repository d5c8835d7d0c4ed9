//! What each technique (s, t) of a method adds: the pyramid of Veach's thesis, alive.
//!
//! While the view is open the renderer keeps techniques apart. [`TechniqueView`] owns what is
//! looked at and the small pictures; `pyramid` lays them out on the stage.

mod pictures;
mod pyramid;
mod words;

use std::sync::Arc;

use egui::{Key, Pos2, Ui};
use neumann_core::film::{Strategy, TechniqueFilm, TechniqueImage, View as Part};
use neumann_core::integrator::METHODS;
use neumann_picture::sheet::{SheetInfo, technique_sheet};

use super::{Needs, Row, Shown, Stage, View};
use crate::display::ViewSettings;
use crate::keys::{self, Action};
use crate::panels::Page;
use crate::session::Session;

pub use words::{description, label};

use pictures::{Tile, TileRow};

/// Its row.
pub static ROW: Row = Row {
    id: ID,
    page: Page::Method,
    title: "Show techniques",
    about: "An image for each technique: s vertices from the light, t from the camera",
    key: Some(keys::line(
        keys::DISPLAY,
        "V",
        "techniques (s, t) apart",
        &[keys::on(keys::NONE, Key::V, Action::View(ID))],
    )),
    needs: Needs {
        techniques: true,
        ..Needs::NOTHING
    },
    refusal: |setup| {
        let name = setup.method().name;
        let text = || {
            let having = METHODS.iter().filter(|method| method.has_techniques);
            let ids: Vec<_> = having.map(|method| method.id).collect();
            let ids = ids.join(", ");
            format!("{name} makes each path in one way only; these have techniques: {ids}")
        };
        (!setup.method().has_techniques).then(text)
    },
    build: || Box::new(TechniqueView::default()),
};

const ID: &str = "techniques";

/// The technique view: what of it is looked at.
#[derive(Default)]
pub struct TechniqueView {
    /// Which image of each technique is shown.
    pub image: TechniqueImage,
    /// The technique that fills the stage.
    pub enlarged: Option<Strategy>,
    film: Option<Arc<TechniqueFilm>>,
    /// Techniques bounce by bounce.
    rows: Vec<TileRow>,
    /// Columns of the pyramid, and the first of those of merges.
    columns: (usize, Option<usize>),
    /// Counts the films that were taken over.
    version: u64,
    /// Version of the picture when the renderer was last asked for a film.
    read: Option<u64>,
    /// The part of the series that was chosen when it was opened: choosing another one closes it.
    opened_on: Part,
}

impl TechniqueView {
    /// The techniques that have made anything, bounce by bounce, with their shares of the energy.
    pub fn techniques(&self) -> impl Iterator<Item = (Strategy, f64)> {
        let tiles = self.rows.iter().flat_map(|row| &row.tiles);
        let made = tiles.filter(|tile| tile.cell.is_made);
        made.map(|tile| (tile.cell.strategy, tile.cell.share))
    }

    fn take(&mut self, film: Arc<TechniqueFilm>) {
        self.version += 1;
        let old = self.rows.drain(..).flat_map(|row| row.tiles);
        let mut old: Vec<Tile> = old.collect();
        let table = film.table();
        self.columns = (table.n_columns, table.first_merge);
        for row in table.rows {
            let tiles = row.cells.into_iter().map(|cell| {
                let is_it = |tile: &Tile| tile.cell.strategy == cell.strategy;
                let known = old.iter().position(is_it);
                let mut tile = known.map_or_else(|| Tile::new(cell), |i| old.swap_remove(i));
                tile.cell = cell;
                tile
            });
            self.rows.push(TileRow {
                gain: row.gain,
                tiles: tiles.collect(),
            });
        }
        self.film = Some(film);
    }
}

impl View for TechniqueView {
    fn open(&mut self, settings: &ViewSettings) {
        *self = Self {
            image: self.image,
            opened_on: settings.part,
            ..Self::default()
        };
    }

    fn close(&mut self) {
        *self = Self {
            image: self.image,
            ..Self::default()
        };
    }

    fn attend(&mut self, session: &Session, settings: &ViewSettings) -> bool {
        if settings.part != self.opened_on {
            return false;
        }
        if self.read == Some(session.picture.version) {
            return true;
        }
        self.read = Some(session.picture.version);
        // What was kept last stays while a job has nothing new yet.
        let published = session.link.read(|published| published.techniques.clone());
        let is_new = |film: &Arc<TechniqueFilm>| {
            let old = self.film.as_ref();
            old.is_none_or(|old| !Arc::ptr_eq(old, film))
        };
        if let Some(film) = published.filter(is_new) {
            self.take(film);
        }
        true
    }

    fn draw(&mut self, ui: &mut Ui, stage: &mut Stage<'_>) -> Option<Pos2> {
        pyramid::show(ui, stage.rect, self, stage.session, stage.settings);
        None
    }

    /// The technique that is enlarged, or all of them on a sheet.
    fn image(&self, session: &Session, settings: &ViewSettings) -> Option<Shown> {
        let film = Arc::clone(self.film.as_ref()?);
        let display = settings.display();
        let kind = self.image;
        if let Some(strategy) = self.enlarged {
            return Some(Shown {
                name: format!("{}-{}", label(strategy), kind.name()),
                pixels: Box::new(move || pictures::pixels(&film, strategy, kind, display)),
            });
        }
        let metadata = session.metadata()?;
        let info = SheetInfo {
            title: metadata.scene.clone(),
            subtitle: metadata.summary(),
            display,
            max_bounces: metadata.max_bounces,
        };
        Some(Shown {
            name: "techniques".to_owned(),
            pixels: Box::new(move || technique_sheet(&film, &info)),
        })
    }

    fn step_back(&mut self) -> bool {
        self.enlarged.take().is_some()
    }
}
