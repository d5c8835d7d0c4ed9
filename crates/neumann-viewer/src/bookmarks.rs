//! Views of scenes that were kept, from one start to the next.
//!
//! A file that cannot be read is put aside before another one takes its place.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use neumann_picture::state::{KeptView, KeptViews};

use crate::memory;

/// The views of every scene.
#[derive(Clone, Debug, Default)]
pub struct Bookmarks {
    all: KeptViews,
    /// Where they are kept; `None` keeps them for this run only.
    file: Option<PathBuf>,
    /// What of the file there cannot be read, if anything.
    wrong: Option<String>,
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
        let (all, wrong) = match file.as_ref().map(std::fs::read_to_string) {
            Some(Ok(text)) => KeptViews::parse(&text),
            Some(Err(error)) if error.kind() != ErrorKind::NotFound => {
                (KeptViews::default(), Some(error.to_string()))
            }
            _ => (KeptViews::default(), None),
        };
        Self { all, file, wrong }
    }

    /// What to tell of a file that could not be read, or not as a whole.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let (file, wrong) = (self.file.as_ref()?, self.wrong.as_ref()?);
        Some(format!(
            "Kept views cannot all be read. {}: {wrong}. Mend it and start again; the next view \
             that is kept puts it aside as {}",
            file.display(),
            aside(file).display()
        ))
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
        if let Some(file) = &self.file
            && (self.wrong.is_none() || std::fs::rename(file, aside(file)).is_ok())
        {
            self.wrong = None;
            memory::keep(file, &self.all.to_text());
        }
    }
}

/// Where a file goes that cannot be read: beside it, where nothing is yet.
fn aside(file: &Path) -> PathBuf {
    let with = |end: &str| file.with_added_extension(end);
    let mut numbered = (2..).map(|n| with(&format!("unreadable-{n}")));
    std::iter::once(with("unreadable"))
        .chain(&mut numbered)
        .find(|path| path.symlink_metadata().is_err())
        .unwrap_or_else(|| with("unreadable"))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use glam::Mat4;
    use neumann_core::scene::description::{CameraDescription, Projection};
    use neumann_picture::state::{CameraState, Exact, KeptView, KeptViews, ProjectionState};

    use super::Bookmarks;

    /// A place for the file in a folder of its own.
    fn file(test: &str) -> PathBuf {
        let folder = format!("neumann-views-{test}-{}", std::process::id());
        std::env::temp_dir().join(folder).join("views.json")
    }

    fn view(name: &str) -> KeptView {
        let camera = CameraDescription {
            name: String::new(),
            world_from_camera: Mat4::IDENTITY,
            aspect_ratio: None,
            projection: Projection::Perspective { yfov: 0.7 },
            lens: None,
            crop: None,
        };
        KeptView {
            name: name.to_owned(),
            camera: CameraState::of(&camera),
        }
    }

    #[test]
    fn views_are_kept_scene_by_scene() {
        let file = file("kept");
        let mut bookmarks = Bookmarks::load_from(Some(file.clone()));
        assert!(bookmarks.of("cornell").is_empty(), "nothing is kept yet");
        bookmarks.keep("cornell", &[view("a"), view("b")]);
        bookmarks.keep("lamps", &[view("c")]);
        bookmarks.keep("lamps", &[]);
        let again = Bookmarks::load_from(Some(file.clone()));
        assert_eq!(again.complaint(), None);
        assert_eq!(again.of("cornell"), [view("a"), view("b")]);
        assert!(again.of("lamps").is_empty() && again.of("pool").is_empty());
        std::fs::remove_dir_all(file.parent().expect("a folder")).expect("it is ours");
    }

    #[test]
    fn a_file_that_cannot_be_read_is_put_aside() {
        let file = file("unreadable");
        let folder = file.parent().expect("a folder");
        std::fs::create_dir_all(folder).expect("a folder");
        let mut odd = KeptViews::default();
        let mut wide = view("wide");
        wide.camera.projection = ProjectionState::Perspective { yfov: Exact(7.0) };
        odd.0.insert("cornell".to_owned(), vec![view("a"), wide]);
        let texts = [
            (b"{ \"cornell\": [".to_vec(), "views.json.unreadable"),
            (vec![0xff, 0xfe], "views.json.unreadable-2"),
            (odd.to_text().into_bytes(), "views.json.unreadable-3"),
        ];
        for (bytes, name) in texts {
            std::fs::write(&file, &bytes).expect("a file");
            let mut bookmarks = Bookmarks::load_from(Some(file.clone()));
            let complaint = bookmarks.complaint().expect("it is told");
            assert!(complaint.ends_with(name), "{complaint}");
            assert!(complaint.contains("views.json: "), "{complaint}");
            // Views that are not changed leave the file alone.
            bookmarks.keep("lamps", &[]);
            assert_eq!(std::fs::read(&file).expect("it is there"), bytes);
            bookmarks.keep("lamps", &[view("b")]);
            bookmarks.keep("lamps", &[view("c")]);
            assert_eq!(
                std::fs::read(folder.join(name)).expect("it is there"),
                bytes
            );
            let again = Bookmarks::load_from(Some(file.clone()));
            assert_eq!(
                (again.complaint(), again.of("lamps")),
                (None, vec![view("c")])
            );
        }
        std::fs::remove_dir_all(folder).expect("it is ours");
    }
}
