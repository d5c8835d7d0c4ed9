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
    /// Reads those that there can be, and what is wrong with the text, if anything is.
    #[must_use]
    pub fn parse(text: &str) -> (Self, Option<String>) {
        let mut all: Self = match serde_json::from_str(text) {
            Ok(all) => all,
            Err(error) => return (Self::default(), Some(error.to_string())),
        };
        let mut wrong = None;
        for (scene, views) in &mut all.0 {
            views.retain(|view| match view.camera.check() {
                Ok(()) => true,
                Err((field, what)) => {
                    let name = &view.name;
                    wrong.get_or_insert(format!("view '{name}' of {scene}: {field}: {what}"));
                    false
                }
            });
        }
        (all, wrong)
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
    fn they_read_back_and_what_cannot_be_is_told() {
        let mut all = KeptViews::default();
        all.0.insert("cornell".to_owned(), vec![view(0.7)]);
        assert_eq!(KeptViews::parse(&all.to_text()), (all.clone(), None));
        let (none, wrong) = KeptViews::parse("{ nonsense");
        assert!(none.0.is_empty() && wrong.is_some_and(|wrong| wrong.contains("line 1")));
        // A view that no camera can have is left out.
        let mut odd = all.clone();
        odd.0
            .insert("cornell".to_owned(), vec![view(7.0), view(0.7)]);
        let (left, wrong) = KeptViews::parse(&odd.to_text());
        let wrong = wrong.expect("it is told");
        assert_eq!(left, all);
        assert!(
            wrong.starts_with("view 'from the door' of cornell: camera."),
            "{wrong}"
        );
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
