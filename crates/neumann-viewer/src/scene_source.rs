//! Opens scenes in the background, so that the window stays alive.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use neumann_core::render::lit;
use neumann_core::scene::description::DefaultSky;
use neumann_core::scene::load::{EnvironmentFile, LoadError, LoadOptions, load_environment};
use neumann_core::scene::{self, Backs, BetterTree, OpeningProgress, Scene, SkyChoice};
use neumann_picture::exr_file::is_panorama;

use crate::compared::Reference;
use crate::compared::measured::{Measurement, Outcome};
use crate::render_link::yield_to_renderer;
use crate::sending::{self, Errand};
use crate::writing::Writing;

/// Something that was asked for has come, or has failed.
pub enum Arrival {
    /// A scene, with the number of the request.
    Scene(u64, Result<Arc<Scene>, String>),
    /// A better tree for a scene that was opened before.
    Tree(BetterTree),
    /// An environment map, by its path.
    Environment(PathBuf, Result<EnvironmentFile, String>),
    /// A reference picture.
    Reference(Result<Reference, String>),
    /// How far two pictures are apart.
    Measured(Outcome),
    /// A path was chosen in the desktop's dialog.
    Chosen(Wanted, PathBuf),
    /// The desktop has no dialog.
    NoDialog(Wanted),
    /// A picture was dropped on the window, and is most likely this.
    Dropped(Wanted, PathBuf),
    /// A file was written, or could not be.
    Saved(Result<PathBuf, String>),
    /// What came of sending to tev.
    Sent(sending::Outcome),
    /// Nothing here shows the folder of this file.
    NoOpener(PathBuf),
}

/// What a dialog asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// A scene.
    Scene,
    /// An environment map.
    Environment,
    /// A reference picture.
    Reference,
}

impl Wanted {
    /// What a dialog for it is called.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Scene => "Open a scene",
            Self::Environment => "Open an environment map",
            Self::Reference => "Open a reference picture",
        }
    }

    /// What it is, for whoever chooses among kinds of files.
    fn kind(self) -> &'static str {
        match self {
            Self::Scene => "glTF scenes and states",
            Self::Environment => "Environment maps",
            Self::Reference => "Pictures",
        }
    }

    /// Endings of its files.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Scene => &["gltf", "glb", "json"],
            Self::Environment => &["hdr", "exr"],
            Self::Reference => &["exr", "png", "hdr"],
        }
    }
}

/// Nobody closes a dialog so soon: it was never there.
const SOONEST_CLOSED: Duration = Duration::from_millis(250);

/// Runs work in the background and hands over what comes of it.
pub struct Background {
    sender: Sender<Option<Arrival>>,
    receiver: Receiver<Option<Arrival>>,
    wake: Arc<dyn Fn() + Send + Sync>,
    n_running: usize,
    n_scenes: u64,
    /// The program that shows a folder.
    pub opener: PathBuf,
}

/// What opens a folder on this system.
const OPENER: &str = if cfg!(target_os = "windows") {
    "explorer"
} else if cfg!(target_os = "macos") {
    "open"
} else {
    "xdg-open"
};

impl Background {
    /// `wake` is called, on another thread, when something has come.
    #[must_use]
    pub fn new(wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        let (sender, receiver) = channel();
        Self {
            sender,
            receiver,
            wake,
            n_running: 0,
            n_scenes: 0,
            opener: PathBuf::from(OPENER),
        }
    }

    /// True while something is under way.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.n_running > 0
    }

    /// What has come since.
    pub fn arrivals(&mut self) -> Vec<Arrival> {
        let finished: Vec<_> = self.receiver.try_iter().collect();
        self.n_running = self.n_running.saturating_sub(finished.len());
        finished.into_iter().flatten().collect()
    }

    /// Opens a built-in scene by name or a file by path, under its own sky or another. Yields the
    /// number of the request and how far it is.
    pub fn open_scene(
        &mut self,
        source: String,
        sky: Option<SkyChoice>,
        backs: Backs,
        options: LoadOptions,
    ) -> (u64, OpeningProgress) {
        let progress = options.progress.clone();
        self.n_scenes += 1;
        let request = self.n_scenes;
        self.run("neumann-load", move || {
            let open = || {
                let mut description = scene::open(&source, &options)?;
                match &sky {
                    None => {}
                    // A map comes later, so that one that cannot be read does not keep the scene
                    // from being shown.
                    Some(SkyChoice::File(_)) => description.default_sky = DefaultSky::Never,
                    Some(sky) => sky.apply(&mut description)?,
                }
                let scene = Scene::build_quickly(&description, &options.progress);
                Ok(lit(scene.with_backs(backs)))
            };
            let scene = open().map(Arc::new).map_err(|e: LoadError| e.to_string());
            Some(Arrival::Scene(request, scene))
        });
        (request, progress)
    }

    /// Builds a better tree for a scene that was built quickly.
    pub fn improve(&mut self, scene: Arc<Scene>) {
        self.run("neumann-tree", move || {
            scene.better_tree().map(Arrival::Tree)
        });
    }

    /// Reads an environment map.
    pub fn open_environment(&mut self, path: PathBuf) {
        let path = in_home(path);
        self.run("neumann-load", move || {
            let map = load_environment(&path).map_err(|e| e.to_string());
            Some(Arrival::Environment(path, map))
        });
    }

    /// Reads a picture to hold the film against.
    pub fn open_reference(&mut self, path: PathBuf) {
        let path = in_home(path);
        self.run("neumann-load", move || {
            Some(Arrival::Reference(Reference::read(&path)))
        });
    }

    /// Measures how far two pictures are apart.
    pub fn measure(&mut self, measurement: Measurement) {
        self.run("neumann-compare", move || {
            yield_to_renderer();
            Some(Arrival::Measured(measurement.make()))
        });
    }

    /// Finds out whether a picture is a sky or a reference.
    pub fn recognise(&mut self, path: PathBuf) {
        self.run("neumann-load", move || {
            let wanted = if is_panorama(&path) {
                Wanted::Environment
            } else {
                Wanted::Reference
            };
            Some(Arrival::Dropped(wanted, path))
        });
    }

    /// Asks for a file in the desktop's dialog.
    pub fn choose(&mut self, wanted: Wanted) {
        self.run("neumann-dialog", move || {
            let start = Instant::now();
            let dialog = rfd::FileDialog::new().set_title(wanted.title());
            let chosen = dialog
                .add_filter(wanted.kind(), wanted.endings())
                .pick_file();
            match chosen {
                Some(path) => Some(Arrival::Chosen(wanted, path)),
                None if start.elapsed() < SOONEST_CLOSED => Some(Arrival::NoDialog(wanted)),
                None => None,
            }
        });
    }

    /// Asks in the desktop's dialog where a picture is to be written, and writes it there.
    pub fn save_as(
        &mut self,
        name: String,
        write: impl FnOnce(PathBuf) -> Result<PathBuf, String> + Send + 'static,
    ) {
        self.run("neumann-dialog", move || {
            let dialog = rfd::FileDialog::new()
                .set_title("Save the picture")
                .set_file_name(name)
                .add_filter("PNG", &["png"]);
            let path = dialog.save_file()?;
            let _writing = Writing::begin();
            Some(Arrival::Saved(write(path)))
        });
    }

    /// Shows the folder of a file in the desktop's file manager.
    pub fn show_folder(&mut self, file: PathBuf) {
        let opener = self.opener.clone();
        self.run("neumann-folder", move || {
            let folder = file.parent().unwrap_or(Path::new("/"));
            let status = Command::new(opener)
                .arg(folder)
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status();
            // Explorer says that it failed whatever it does.
            let is_shown = status.is_ok_and(|s| s.success() || cfg!(target_os = "windows"));
            (!is_shown).then_some(Arrival::NoOpener(file))
        });
    }

    /// Writes something; the path that it yields is shown in a notice.
    pub fn save(&mut self, write: impl FnOnce() -> Result<PathBuf, String> + Send + 'static) {
        let writing = Writing::begin();
        self.run("neumann-save", move || {
            let saved = write();
            drop(writing);
            Some(Arrival::Saved(saved))
        });
    }

    /// Seeks tev, or sends it a picture.
    pub fn send(&mut self, errand: Errand) {
        self.run("neumann-tev", move || {
            yield_to_renderer();
            Some(Arrival::Sent(errand.run()))
        });
    }

    fn run(&mut self, name: &str, work: impl FnOnce() -> Option<Arrival> + Send + 'static) {
        let (sender, wake) = (self.sender.clone(), Arc::clone(&self.wake));
        let thread = std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || {
                let arrival = work();
                // Nobody listens any more once the window has gone.
                let _ = sender.send(arrival);
                wake();
            });
        if thread.is_ok() {
            self.n_running += 1;
        }
    }
}

/// A path as somebody types it: `~` is the user's own folder.
#[must_use]
pub fn in_home(path: PathBuf) -> PathBuf {
    let variable = if cfg!(target_os = "windows") {
        "USERPROFILE"
    } else {
        "HOME"
    };
    match std::env::var_os(variable) {
        Some(home) => beneath(Path::new(&home), path),
        None => path,
    }
}

fn beneath(home: &Path, path: PathBuf) -> PathBuf {
    match path.strip_prefix("~") {
        Ok(rest) if rest.as_os_str().is_empty() => home.to_owned(),
        Ok(rest) => home.join(rest),
        Err(_) => path,
    }
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::beneath;

    #[test]
    fn a_tilde_is_the_folder_of_the_user() {
        let home = Path::new("home");
        for (typed, meant) in [
            ("~/scenes/a.glb", "home/scenes/a.glb"),
            ("~", "home"),
            ("a~/b.glb", "a~/b.glb"),
            ("~other/b.glb", "~other/b.glb"),
            ("cornell", "cornell"),
        ] {
            let found = beneath(home, PathBuf::from(typed));
            assert_eq!(found, Path::new(meant), "{typed}");
        }
    }
}
