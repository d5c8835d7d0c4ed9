//! Views of scenes that were kept: cameras with names.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::CameraState;

/// A camera that was kept, with its name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptView {
    /// What it is called.
    #[serde(default)]
    pub name: String,
    /// The camera.
    pub camera: CameraState,
}

/// Kept views of many scenes, by the name of a built-in scene or the path of a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct KeptViews(pub BTreeMap<String, Vec<KeptView>>);

impl KeptViews {
    /// Reads them; nothing of a text that is not theirs, and no view that cannot be.
    #[must_use]
    pub fn parse(text: &str) -> Self {
        let mut all: Self = serde_json::from_str(text).unwrap_or_default();
        for views in all.0.values_mut() {
            views.retain(|view| view.camera.check().is_ok());
        }
        all
    }

    /// As the text of a file.
    #[must_use]
    pub fn to_text(&self) -> String {
        // Only maps with odd keys cannot be written, and there are none.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat4;
    use neumann_core::scene::description::{CameraDescription, Projection};

    use super::{KeptView, KeptViews};
    use crate::state::{CameraState, State};

    fn view(yfov: f32) -> KeptView {
        let camera = CameraDescription {
            name: String::new(),
            world_from_camera: Mat4::IDENTITY,
            aspect_ratio: None,
            projection: Projection::Perspective { yfov },
            lens: None,
            crop: None,
        };
        KeptView {
            name: "from the door".to_owned(),
            camera: CameraState::of(&camera),
        }
    }

    #[test]
    fn they_read_back_and_nonsense_is_nothing() {
        let mut all = KeptViews::default();
        all.0.insert("cornell".to_owned(), vec![view(0.7)]);
        assert_eq!(KeptViews::parse(&all.to_text()), all);
        assert_eq!(KeptViews::parse("{ nonsense"), KeptViews::default());
        // A view that no camera can have is left out.
        let mut odd = all.clone();
        odd.0
            .insert("cornell".to_owned(), vec![view(7.0), view(0.7)]);
        assert_eq!(KeptViews::parse(&odd.to_text()), all);
    }

    #[test]
    fn a_state_names_the_view_that_cannot_be() {
        let state = State {
            scene: "cornell".to_owned(),
            views: vec![view(0.7), view(7.0)],
            ..State::default()
        };
        let (field, _) = State::parse(&state.to_text()).unwrap_err();
        assert_eq!(field, "views[1].camera.projection.perspective.yfov");
        let fine = State {
            views: vec![view(0.7)],
            ..state
        };
        assert_eq!(State::parse(&fine.to_text()).unwrap(), (fine, Vec::new()));
    }
}
