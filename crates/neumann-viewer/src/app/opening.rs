//! What comes into the window from outside: scenes, maps, references, dropped files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::{Context, Event};
use neumann_core::render::{StopRule, hidden_by_backs};
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::load::{EnvironmentFile, LoadOptions};
use neumann_core::scene::{Backs, Scene, SkyChoice};
use neumann_picture::state::{State, StateError};

use super::{App, Loading};
use crate::compared::Reference;
use crate::display::Against;
use crate::file_list::{Choice, FileList};
use crate::notices::Offer;
use crate::options::Exposure;
use crate::panels;
use crate::scene_source::{Arrival, Wanted, in_home};
use crate::setup::FilmSize;
use crate::state;

impl App {
    /// Opens the scene that the command asked for, or takes up its state.
    pub fn open_first_scene(&mut self) {
        if let Some(state) = self.options.state.take() {
            self.open_state(state);
            return;
        }
        let source = if self.options.scene.is_empty() {
            "cornell".to_owned()
        } else {
            self.options.scene.clone()
        };
        self.open_scene(source);
    }

    /// Opens a scene by name or path, or takes up the state in a file.
    pub fn open_path(&mut self, source: String) {
        let source = in_home(PathBuf::from(source)).display().to_string();
        let extension = Path::new(&source).extension();
        if extension.is_none_or(|ending| !ending.eq_ignore_ascii_case("json")) {
            self.open_scene(source);
            return;
        }
        if self.open_read_state(State::read(Path::new(&source))) {
            self.shell.recent.add(&source);
        }
    }

    /// Takes up a state that was read, with what is odd about it; says why if it was not. True if
    /// it was.
    fn open_read_state(&mut self, read: Result<(State, Vec<String>), StateError>) -> bool {
        match read {
            Ok((state, warnings)) => {
                for warning in warnings {
                    self.shell.notices.failure(warning);
                }
                self.open_state(Box::new(state));
                true
            }
            Err(error) => {
                self.shell.notices.failure(error.to_string());
                false
            }
        }
    }

    /// Takes up a state that was pasted as text, unless a text field takes it.
    pub(super) fn take_pasted(&mut self, ctx: &Context) {
        if ctx.text_edit_focused() {
            return;
        }
        let pasted = ctx.input(|i| {
            i.events.iter().rev().find_map(|event| match event {
                Event::Paste(text) => Some(text.clone()),
                _ => None,
            })
        });
        if let Some(text) = pasted {
            self.open_read_state(State::read_from(text.as_bytes(), "pasted text"));
        }
    }

    /// Begins to open a scene; the present one stays until it is there, and if it never is.
    pub fn open_scene(&mut self, source: String) {
        // What the command asks for is meant for the scene that it names.
        let sky = self.options.environment.sky.clone();
        let sky = sky.filter(|_| self.is_first_scene);
        let backs = if self.is_first_scene {
            self.options.backs
        } else {
            Backs::default()
        };
        self.begin(source, sky, backs, None);
    }

    /// Begins to open the scene of a state, which is taken up when it is there.
    pub fn open_state(&mut self, state: Box<State>) {
        let backs = Backs::named(&state.backs).unwrap_or_default();
        self.begin(state.scene.clone(), state::sky(&state), backs, Some(state));
    }

    fn begin(
        &mut self,
        source: String,
        sky: Option<SkyChoice>,
        backs: Backs,
        state: Option<Box<State>>,
    ) {
        let options = LoadOptions {
            allow_outside: self.options.allow_outside,
            allow_hidden: self.options.allow_hidden,
            ..LoadOptions::default()
        };
        let background = &mut self.shell.background;
        let (request, progress) = background.open_scene(source.clone(), sky, backs, options);
        self.loading = Some(Loading {
            source,
            progress,
            request,
            state,
        });
    }

    /// Takes over a scene that is ready.
    pub fn take_scene(&mut self, source: String, scene: Arc<Scene>) {
        self.take_scene_as(source, scene, None);
    }

    /// Takes over a scene that is ready, and the state that it was opened for.
    fn take_scene_as(&mut self, source: String, scene: Arc<Scene>, state: Option<Box<State>>) {
        let warnings = scene.warnings().to_vec();
        if self.options.exposure == Exposure::ForScene {
            self.expose_for(&source);
        }
        let views = self.shell.bookmarks.of(&source);
        self.session.setup.take_scene(source, scene);
        self.session.setup.views = views;
        let is_of_former = |o: &Offer| matches!(o, Offer::PutSkyBack(_)) || is_of_a_drop(o);
        self.shell.notices.withdraw(is_of_former);
        self.shell.material = None;
        self.shell.picked = None;
        self.viewing.settings.zoom = None;
        self.map_to_come = None;
        self.awaits_map = false;
        let is_first = std::mem::take(&mut self.is_first_scene);
        if let Some(state) = state {
            self.take_up(&state, is_first);
        } else if is_first {
            self.take_options();
        }
        self.tell_warnings(&warnings);
        self.tell_of_sky();
        self.tell_of_backs();
        self.session.history.begin(&self.session.setup);
    }

    /// Applies what the command said about its scene.
    fn take_options(&mut self) {
        let setup = &mut self.session.setup;
        if let Some(complaint) = setup.apply_camera(&self.options.camera) {
            self.shell.notices.failure(complaint);
        }
        match self.options.environment.sky.clone() {
            Some(SkyChoice::File(file)) => {
                self.awaits_map = true;
                self.shell.background.open_environment(file);
            }
            sky => setup.sky = sky,
        }
        setup.apply_environment(&self.options.environment);
        if let Some(quantity) = self.options.quantity {
            self.show_view(quantity.name());
        }
    }

    /// Takes up a state, its scene being open; size and end may be those that the command said.
    fn take_up(&mut self, state: &State, is_first: bool) {
        let complaints = state::take_up(state, &mut self.session, &mut self.viewing);
        for complaint in complaints {
            self.shell.notices.failure(complaint);
        }
        self.exposes_by_itself = false;
        let setup = &mut self.session.setup;
        if is_first {
            if self.options.size.is_some() {
                setup.film_size = FilmSize::of(self.options.size);
            }
            if self.options.stop != StopRule::Never {
                setup.stop = self.options.stop;
            }
        }
        let largest = self.largest_side;
        let size = match setup.film_size {
            FilmSize::Fixed(w, h) => Some((w, h)),
            _ => setup.region.map(|region| region.of.into()),
        };
        if let Some((w, h)) = size
            && w.max(h) > largest
        {
            setup.film_size = FilmSize::Window;
            setup.region = None;
            setup.size = (0, 0);
            self.shell.notices.failure(format!(
                "The state's size {w}×{h} is more than the graphics device draws, {largest} \
                 pixels each way; the film follows the window"
            ));
        }
        match state::sky(state) {
            Some(SkyChoice::File(file)) => {
                self.map_to_come = Some(state.environment.clone());
                self.shell.background.open_environment(file);
            }
            sky => setup.sky = sky,
        }
    }

    /// Offers to take away a sky that was added.
    fn tell_of_sky(&mut self) {
        let Some(open) = &self.session.setup.open else {
            return;
        };
        if open.scene.has_default_sky() {
            // The last of the warnings says why.
            let why = open.scene.warnings().last().map_or("", String::as_str);
            self.shell
                .notices
                .offer(why, "Remove sky", Offer::RemoveSky);
        }
    }

    /// Offers to look through backs that hide much of what the camera is to see.
    fn tell_of_backs(&mut self) {
        self.shell
            .notices
            .withdraw(|offer| matches!(offer, Offer::LookThroughBacks));
        let (Some(open), Some(control)) = (&self.session.setup.open, &self.session.setup.camera)
        else {
            return;
        };
        if let Some(share) = hidden_by_backs(&open.scene, control.camera()) {
            let text = format!(
                "Backs of single-sided surfaces hide {:.0} % of what the camera sees",
                share * 100.0
            );
            let notices = &mut self.shell.notices;
            notices.offer(text, "Look through", Offer::LookThroughBacks);
        }
    }

    /// Whoever made a file had another program's exposure in mind; a built-in scene has its own,
    /// unless another one has been set.
    fn expose_for(&mut self, source: &str) {
        let settings = &mut self.viewing.settings;
        let before = self.session.setup.open.as_ref();
        let before = before.map_or(0.0, |open| exposure_of(&open.source));
        if builtin(source).is_none() {
            settings.is_auto = true;
            self.exposes_by_itself = true;
        } else if self.exposes_by_itself && settings.is_auto {
            settings.is_auto = false;
            settings.exposure_ev = exposure_of(source);
            self.exposes_by_itself = false;
        } else if !settings.is_auto && settings.exposure_ev.to_bits() == before.to_bits() {
            settings.exposure_ev = exposure_of(source);
        }
    }

    /// Shows the first few warnings of a scene, and where the others are.
    fn tell_warnings(&mut self, warnings: &[String]) {
        const MOST: usize = 3;
        let n_sky = usize::from(
            self.session
                .setup
                .open
                .as_ref()
                .is_some_and(|o| o.scene.has_default_sky()),
        );
        let warnings = &warnings[..warnings.len() - n_sky];
        if warnings.is_empty() {
            return;
        }
        let mut text = warnings[..warnings.len().min(MOST)].join("\n");
        if warnings.len() > MOST {
            text += &format!(
                "\nand {} more; see the end of the Scene page",
                warnings.len() - MOST
            );
        }
        self.shell.notices.failure(text);
    }

    /// Does what a notice offers.
    pub(super) fn accept(&mut self, offer: Offer) {
        match offer {
            Offer::RemoveSky => {
                panels::remove_sky(&mut self.session.setup, &mut self.shell.notices);
            }
            Offer::ShowFolder(path) => self.shell.background.show_folder(path),
            Offer::PutSkyBack(former) => self.session.setup.put_sky_back(&former),
            Offer::TakeAsReference(path, former) => {
                if let Some(former) = former {
                    self.session.setup.put_sky_back(&former);
                }
                self.shell.background.open_reference(path);
            }
            Offer::TakeAsSky(path) => {
                self.session.picture.reference = None;
                self.viewing.settings.difference = None;
                self.shell.background.open_environment(path);
            }
            Offer::LookThroughBacks => {
                self.session.setup.choose_backs(Backs::SeeThrough);
                // What was behind them may stand in the dark.
                if self.session.setup.add_sky_where_dim() {
                    self.tell_of_sky();
                }
            }
        }
    }

    pub(super) fn take_arrivals(&mut self, ctx: &Context) {
        for arrival in self.shell.background.arrivals() {
            match arrival {
                Arrival::Scene(request, result) => self.take_opened(request, result),
                Arrival::Tree(tree) => {
                    if let Some([scene, better]) = self.session.setup.take_tree(&tree) {
                        self.session.link.improve_scene(&scene, &better);
                    }
                }
                Arrival::Environment(path, Ok(file)) => self.take_map(ctx, path, file),
                Arrival::Reference(Ok(reference)) => self.take_reference(reference),
                Arrival::Measured(outcome) => self.session.measuring.take(outcome),
                Arrival::Chosen(wanted, path) => self.open_chosen(wanted, path),
                Arrival::NoDialog(wanted) => self.list_files(wanted),
                Arrival::Dropped(wanted, path) => self.take_dropped_picture(wanted, path),
                Arrival::Sent(outcome) => {
                    let shell = &mut self.shell;
                    shell.sending.take(ctx, outcome, &mut shell.notices);
                }
                Arrival::Saved(Ok(path)) => self.shell.notices.saved(ctx, path),
                Arrival::NoOpener(path) => {
                    ctx.copy_text(path.display().to_string());
                    let text = "Copied the path, as no program here shows folders";
                    self.shell.notices.remark(ctx, text);
                }
                Arrival::Environment(_, Err(error)) => {
                    // Another map that comes later is no part of the opening.
                    self.awaits_map = false;
                    self.map_to_come = None;
                    self.shell.notices.failure(error);
                }
                Arrival::Reference(Err(error)) | Arrival::Saved(Err(error)) => {
                    self.shell.notices.failure(error);
                }
            }
        }
    }

    /// Takes over a reference, and shows the difference from it.
    pub(super) fn take_reference(&mut self, reference: Reference) {
        self.session.picture.set_reference(reference);
        self.viewing.settings.difference = Some(Against::Reference);
        self.viewing.settings.is_wiping = false;
    }

    fn open_chosen(&mut self, wanted: Wanted, path: PathBuf) {
        match wanted {
            Wanted::Scene => self.open_path(path.display().to_string()),
            Wanted::Environment => self.shell.background.open_environment(path),
            Wanted::Reference => self.shell.background.open_reference(path),
        }
    }

    /// Shows files to choose from: those beside the open scene, or where the program was started.
    pub fn list_files(&mut self, wanted: Wanted) {
        let open = self.session.setup.open.as_ref();
        let beside = open.and_then(|open| std::fs::canonicalize(&open.source).ok());
        let folder = beside.and_then(|path| path.parent().map(Path::to_owned));
        let folder = folder.or_else(|| std::env::current_dir().ok());
        let folder = folder.unwrap_or_else(|| in_home(PathBuf::from("~")));
        self.shell.file_list = Some(FileList::new(wanted, folder));
    }

    /// Does what the list of files came to.
    pub(super) fn take_choice(&mut self, choice: Option<Choice>) {
        let Some(choice) = choice else { return };
        self.shell.file_list = None;
        if let Choice::File(wanted, path) = choice {
            self.open_chosen(wanted, path);
        }
    }

    fn take_map(&mut self, ctx: &Context, path: PathBuf, file: EnvironmentFile) {
        for warning in file.warnings {
            self.shell.notices.remark(ctx, warning);
        }
        let setup = &mut self.session.setup;
        setup.take_map(path, file.environment);
        setup.apply_environment(&self.options.environment);
        let of_state = self.map_to_come.take();
        let is_part_of_opening = std::mem::take(&mut self.awaits_map) || of_state.is_some();
        if let (Some(state), Some(open)) = (of_state, &setup.open) {
            let mut appearance = open.scene.appearance().clone();
            state::take_environment(&state, &mut appearance);
            setup.dress(appearance);
        }
        if is_part_of_opening {
            self.session.history.begin(&self.session.setup);
        }
    }

    fn take_opened(&mut self, request: u64, result: Result<Arc<Scene>, String>) {
        // Of several opened in haste, the last one asked for counts.
        let is_wanted = |loading: &mut Loading| loading.request == request;
        let Some(Loading { source, state, .. }) = self.loading.take_if(is_wanted) else {
            return;
        };
        match result {
            Ok(scene) => {
                if builtin(&source).is_none() {
                    self.shell.recent.add(&source);
                }
                self.shell.background.improve(Arc::clone(&scene));
                self.take_scene_as(source, scene, state);
            }
            Err(error) => {
                self.shell.notices.failure(error);
                if self.session.setup.open.is_none() && source != "cornell" {
                    // Better the default scene beside the notice than an empty window.
                    self.open_scene("cornell".to_owned());
                }
            }
        }
    }

    /// Takes a dropped picture for what it most likely is, and offers to take it for the other.
    fn take_dropped_picture(&mut self, wanted: Wanted, path: PathBuf) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let notices = &mut self.shell.notices;
        notices.withdraw(is_of_a_drop);
        if wanted == Wanted::Environment {
            let text = format!("{name} is taken for a sky, as it is twice as wide as high");
            let former = self.session.setup.snapshot().map(Box::new);
            let offer = Offer::TakeAsReference(path.clone(), former);
            notices.offer(text, "Use as reference", offer);
            self.shell.background.open_environment(path);
        } else {
            let text = format!("{name} is taken for a reference to compare with");
            notices.offer(text, "Use as sky", Offer::TakeAsSky(path.clone()));
            self.shell.background.open_reference(path);
        }
    }

    pub(super) fn take_dropped_files(&mut self, ctx: &Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for path in files.iter().map(|file| file.path().to_owned()) {
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            match extension.to_str() {
                Some("hdr") => self.shell.background.open_environment(path),
                Some("exr") => self.shell.background.recognise(path),
                _ => self.open_path(path.display().to_string()),
            }
        }
    }
}

/// Exposure that a built-in scene is made for, stops. The furnace has radiance 2 from everywhere,
/// which would be white; two stops less leave its terms apart.
fn exposure_of(source: &str) -> f32 {
    if source == "furnace" { -2.0 } else { 0.0 }
}

fn is_of_a_drop(offer: &Offer) -> bool {
    matches!(offer, Offer::TakeAsReference(..) | Offer::TakeAsSky(_))
}
