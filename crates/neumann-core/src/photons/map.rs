//! A photon map: the photons of many light paths, found by place.

use super::{HashGrid, Photon};

/// The photons that an iteration reads its light from.
#[derive(Clone, Debug)]
pub struct PhotonMap {
    /// The photons.
    pub grid: HashGrid<Photon>,
    /// Radius within which they count, metres.
    pub radius: f32,
    /// Light paths that have left them, those without a photon included.
    pub n_paths: usize,
    /// Number of the iteration that traced them; 0 for a map that all iterations share.
    pub iteration: u32,
}
