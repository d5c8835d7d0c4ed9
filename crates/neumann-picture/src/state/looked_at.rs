//! What views beside the picture look at: pixels, materials, methods.

use serde::{Deserialize, Serialize};

use super::check::{MAX_EDGE, Wrong, whole, wrong};
use crate::race::{Entrant, MOST};

/// What views beside the picture look at; each finds something of its own where there is none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct LookedAt {
    /// Column and row of the pixel that is inspected.
    pub inspected: Option<[usize; 2]>,
    /// Column and row of the pixel that shows the point of the hemisphere.
    pub hemisphere: Option<[usize; 2]>,
    /// Whose lobes are plotted.
    pub lobes: Option<LobesOf>,
    /// Who takes part in a race.
    pub race: Vec<Racing>,
}

/// Whose lobes are plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LobesOf {
    /// Those of the surface that a pixel shows, column and row.
    Pixel([usize; 2]),
    /// Those of a material by its number in the file.
    Material(usize),
}

/// Who takes part in a race.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Racing {
    /// A method by its id, with the parameters that its page has.
    OfPage(String),
    /// A method with parameters of its own, as `neumann race` takes them.
    Own(String),
}

impl LookedAt {
    /// Refuses what cannot be.
    pub(super) fn check(&self) -> Result<(), Wrong> {
        let of_lobes = match self.lobes {
            Some(LobesOf::Pixel(pixel)) => Some(pixel),
            _ => None,
        };
        for (name, pixel) in [
            ("inspected", self.inspected),
            ("hemisphere", self.hemisphere),
            ("lobes.pixel", of_lobes),
        ] {
            for (i, at) in pixel.into_iter().flatten().enumerate() {
                whole(&format!("looked_at.{name}[{i}]"), at, 0, MAX_EDGE - 1)?;
            }
        }
        for (i, racing) in self.race.iter().enumerate() {
            let field = format!("looked_at.race[{i}]");
            racing.entrant().map_err(|what| (field, what))?;
        }
        if self.race.len() == 1 || self.race.len() > MOST {
            let what = format!("names {}; use 2 to {MOST}, or none", self.race.len());
            return wrong("looked_at.race", what);
        }
        Ok(())
    }
}

impl Racing {
    /// The method; of one with the parameters of its page, with their usual values.
    ///
    /// # Errors
    /// Says what is wrong with the name.
    pub fn entrant(&self) -> Result<Entrant, String> {
        match self {
            Self::OfPage(id) if id.contains(':') => Err(format!(
                "{id}: has the parameters of its page; use 'own' for others"
            )),
            Self::OfPage(name) | Self::Own(name) => Entrant::parse(name),
        }
    }
}
