//! How the film is looked at. No change of it renders anew.

use crate::display::ViewSettings;
use crate::display::image_area::Placement;
use crate::views::Views;

/// How the film is looked at.
#[derive(Default)]
pub struct Viewing {
    /// Part of the series, exposure, tone, magnification.
    pub settings: ViewSettings,
    /// What stands in place of the picture.
    pub views: Views,
    /// Where the picture stood in the last frame that showed it.
    pub placement: Option<Placement>,
}
