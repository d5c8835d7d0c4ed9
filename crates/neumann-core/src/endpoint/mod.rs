//! Both ends of a path.
use crate::scene::description::CameraDescription;
/// A camera with its film.
pub struct Camera {}
impl Camera {
    /// A camera for a film of `width × height` pixels.
    #[must_use]
    pub fn new(_d: &CameraDescription, _width: usize, _height: usize) -> Self {
        Self {}
    }
}
