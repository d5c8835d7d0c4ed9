//! What each technique (s, t) of a bidirectional method adds: the pyramid of Veach's thesis, alive.
//!
//! While the view is open the renderer keeps techniques apart; [`TechniqueView`] owns what is looked at
//! and the small pictures, `pyramid` lays them out in place of the picture.

mod pictures;
mod pyramid;
mod words;

use std::sync::Arc;

use neumann_core::film::{Strategy, TechniqueFilm, TechniqueImage, View};

use crate::app::App;
use crate::display::ViewSettings;

pub use pyramid::show;
pub use words::{description, label};

use pictures::Tile;

/// The technique view: what of it is looked at.
#[derive(Default)]
pub struct TechniqueView {
    /// It stands in place of the picture.
    pub is_open: bool,
    /// Which image of each technique is shown.
    pub image: TechniqueImage,
    /// The technique that fills the stage.
    pub enlarged: Option<Strategy>,
    film: Option<Arc<TechniqueFilm>>,
    /// Techniques bounce by bounce.
    rows: Vec<Vec<Tile>>,
    /// Counts the films that were taken over.
    version: u64,
    /// Version of the picture when the renderer was last asked for a film.
    read: Option<u64>,
    /// The view that was chosen when it was opened: choosing another one closes it.
    opened_on: View,
    is_centered: bool,
}

impl TechniqueView {
    fn open(&mut self, viewing: &ViewSettings) {
        *self = Self {
            is_open: true,
            image: self.image,
            opened_on: viewing.part,
            ..Self::default()
        };
    }

    /// Goes back to the picture and forgets the techniques.
    pub fn close(&mut self) {
        *self = Self {
            image: self.image,
            ..Self::default()
        };
    }

    /// One step back: from one technique to all of them, from there to the picture.
    pub fn step_back(&mut self) {
        if self.enlarged.is_some() {
            self.enlarged = None;
        } else {
            self.close();
        }
    }

    /// The techniques that have made anything, bounce by bounce, with their shares of the energy.
    pub fn techniques(&self) -> impl Iterator<Item = (Strategy, f64)> {
        let tiles = self.rows.iter().flatten();
        tiles.map(|tile| (tile.strategy, tile.share))
    }

    fn take(&mut self, film: Arc<TechniqueFilm>) {
        self.version += 1;
        let mut old: Vec<Tile> = self.rows.drain(..).flatten().collect();
        for row in film.shares() {
            let tiles = row.into_iter().map(|(strategy, share)| {
                let known = old.iter().position(|tile| tile.strategy == strategy);
                let mut tile = known.map_or_else(|| Tile::new(strategy), |i| old.swap_remove(i));
                tile.share = share;
                tile
            });
            self.rows.push(tiles.collect());
        }
        while self.rows.last().is_some_and(Vec::is_empty) {
            self.rows.pop();
        }
        self.film = Some(film);
    }
}

/// Opens the view, or closes it.
pub fn toggle(app: &mut App) {
    if app.viewing.techniques.is_open {
        app.viewing.techniques.close();
    } else if app.session.setup.method().has_techniques {
        app.viewing.techniques.open(&app.viewing.settings);
    } else {
        let name = app.session.setup.method().name;
        let text = format!("{name} makes each path in one way only; BDPT and VCM have techniques");
        app.shell.notices.failure(text);
    }
}

/// Once a frame: closes the view where it has become pointless, lets the renderer keep techniques apart
/// for as long as it is open, and takes over what is new.
pub fn attend(app: &mut App) {
    let view = &mut app.viewing.techniques;
    if view.is_open
        && (!app.session.setup.method().has_techniques
            || app.viewing.settings.part != view.opened_on)
    {
        view.close();
    }
    if app.session.link.is_recording() != view.is_open {
        app.session.link.record_techniques(view.is_open);
    }
    if !view.is_open || view.read == Some(app.session.picture.version) {
        return;
    }
    view.read = Some(app.session.picture.version);
    // What was kept last stays while a job has nothing new yet.
    if let Some(film) = app
        .session
        .link
        .read(|published| published.techniques.clone())
        && view
            .film
            .as_ref()
            .is_none_or(|old| !Arc::ptr_eq(old, &film))
    {
        view.take(film);
    }
}
