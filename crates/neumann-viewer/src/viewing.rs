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
    /// The exposure that was set, while it follows the picture.
    pub(crate) set_exposure: SetExposure,
    /// Where the picture stood in the last frame that showed it.
    pub placement: Option<Placement>,
}

/// Remembers the exposure that was set, and comes back to it when it no longer follows the picture.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SetExposure {
    set: f32,
    /// What the picture asked for last.
    automatic: Option<f32>,
}

impl SetExposure {
    /// Once or more often in a frame, after whatever may have changed the exposure. One that was
    /// set while it followed the picture stays.
    pub(crate) fn follow(&mut self, settings: &mut ViewSettings) {
        if settings.is_auto {
            self.automatic = Some(settings.exposure_ev);
            return;
        }
        let left = self.automatic.take();
        if left.is_some_and(|ev| ev.to_bits() == settings.exposure_ev.to_bits()) {
            settings.exposure_ev = self.set;
        }
        self.set = settings.exposure_ev;
    }
}
