//! Views of scenes that were kept, from one start to the next.

use std::path::PathBuf;

use neumann_picture::state::{KeptView, KeptViews};

use crate::memory;

/// The views of every scene.
#[derive(Clone, Debug, Default)]
pub struct Bookmarks {
    all: KeptViews,
    /// Where they are kept; `None` keeps them for this run only.
    file: Option<PathBuf>,
}

impl Bookmarks {
    /// Those of earlier runs.
    #[must_use]
    pub fn load() -> Self {
        Self::load_from(memory::file("views.json"))
    }

    /// Those in a file, where they are kept.
    #[must_use]
    pub fn load_from(file: Option<PathBuf>) -> Self {
        let text = file.as_ref().and_then(|f| std::fs::read_to_string(f).ok());
        Self {
            all: KeptViews::parse(&text.unwrap_or_default()),
            file,
        }
    }

    /// Those of a scene, which is a built-in scene's name or a path.
    #[must_use]
    pub fn of(&self, scene: &str) -> Vec<KeptView> {
        let views = self.all.0.get(&memory::lasting(scene));
        views.cloned().unwrap_or_default()
    }

    /// Keeps those of a scene, if they are other than before.
    pub fn keep(&mut self, scene: &str, views: &[KeptView]) {
        let scene = memory::lasting(scene);
        let before = self.all.0.get(&scene).map_or(&[][..], Vec::as_slice);
        if before == views {
            return;
        }
        if views.is_empty() {
            self.all.0.remove(&scene);
        } else {
            self.all.0.insert(scene, views.to_vec());
        }
        if let Some(file) = &self.file {
            memory::keep(file, &self.all.to_text());
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Mat4;
    use neumann_core::scene::description::{CameraDescription, Projection};
    use neumann_picture::state::{CameraState, KeptView};

    use super::Bookmarks;

    #[test]
    fn views_are_kept_scene_by_scene() {
        let folder = format!("neumann-views-{}", std::process::id());
        let folder = std::env::temp_dir().join(folder);
        let file = folder.join("views.json");
        let camera = CameraDescription {
            name: String::new(),
            world_from_camera: Mat4::IDENTITY,
            aspect_ratio: None,
            projection: Projection::Perspective { yfov: 0.7 },
            lens: None,
            crop: None,
        };
        let view = |name: &str| KeptView {
            name: name.to_owned(),
            camera: CameraState::of(&camera),
        };
        let mut bookmarks = Bookmarks::load_from(Some(file.clone()));
        assert!(bookmarks.of("cornell").is_empty(), "nothing is kept yet");
        bookmarks.keep("cornell", &[view("a"), view("b")]);
        bookmarks.keep("lamps", &[view("c")]);
        bookmarks.keep("lamps", &[]);
        let again = Bookmarks::load_from(Some(file));
        assert_eq!(again.of("cornell"), [view("a"), view("b")]);
        assert!(again.of("lamps").is_empty() && again.of("pool").is_empty());
        std::fs::remove_dir_all(folder).expect("it is ours");
    }
}
