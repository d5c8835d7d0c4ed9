//! What comes into the window from outside: scenes, maps, references, dropped files.

use std::sync::Arc;

use egui::Context;
use neumann_core::render::hidden_by_backs;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::load::LoadOptions;
use neumann_core::scene::{Backs, Scene, SkyChoice};

use super::{App, Loading};
use crate::notices::Offer;
use crate::options::Exposure;
use crate::scene_source::{Arrival, Wanted};

impl App {
    /// Opens the scene that the command asked for.
    pub fn open_first_scene(&mut self) {
        let source = if self.options.scene.is_empty() {
            "cornell".to_owned()
        } else {
            self.options.scene.clone()
        };
        self.open_scene(source);
    }

    /// Begins to open a scene; the present one stays until it is there, and if it never is.
    pub fn open_scene(&mut self, source: String) {
        let options = LoadOptions {
            allow_outside: self.options.allow_outside,
            allow_hidden: self.options.allow_hidden,
            ..LoadOptions::default()
        };
        // What the command asks for is meant for the scene that it names.
        let sky = self.options.environment.sky.clone();
        let sky = sky.filter(|_| self.is_first_scene);
        let backs = if self.is_first_scene {
            self.options.backs
        } else {
            Backs::default()
        };
        let background = &mut self.shell.background;
        let progress = background.open_scene(source.clone(), sky, backs, options);
        self.loading = Some(Loading { source, progress });
    }

    /// Takes over a scene that is ready.
    pub fn take_scene(&mut self, source: String, scene: Arc<Scene>) {
        let warnings = scene.warnings().to_vec();
        if self.options.exposure == Exposure::ForScene {
            self.expose_for(&source);
        }
        self.session.setup.take_scene(source, scene);
        self.shell.material = None;
        self.viewing.settings.zoom = None;
        if self.is_first_scene {
            self.is_first_scene = false;
            if let Some(complaint) = self.session.setup.apply_camera(&self.options.camera) {
                self.shell.notices.failure(complaint);
            }
            if let Some(SkyChoice::File(file)) = self.options.environment.sky.clone() {
                self.shell.background.open_environment(file);
            }
            self.session
                .setup
                .apply_environment(&self.options.environment);
        }
        self.tell_warnings(&warnings);
        self.tell_of_sky();
        self.tell_of_backs();
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
        self.shell.notices.withdraw(Offer::LookThroughBacks);
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

    /// Whoever made a file had another program's exposure in mind; a built-in scene suits exposure 0.
    fn expose_for(&mut self, source: &str) {
        if builtin(source).is_none() {
            self.viewing.settings.is_auto = true;
            self.exposes_by_itself = true;
        } else if self.exposes_by_itself && self.viewing.settings.is_auto {
            self.viewing.settings.is_auto = false;
            self.viewing.settings.exposure_ev = 0.0;
            self.exposes_by_itself = false;
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
                "\nand {} more; see the end of the page Scene",
                warnings.len() - MOST
            );
        }
        self.shell.notices.failure(text);
    }

    /// Does what a notice offers.
    pub(super) fn accept(&mut self, offer: Offer) {
        match offer {
            Offer::RemoveSky => self.session.setup.choose_sky(None),
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
                Arrival::Scene(source, result) => self.take_opened(source, result),
                Arrival::Tree(tree) => {
                    if let Some([scene, better]) = self.session.setup.take_tree(&tree) {
                        self.session.link.improve_scene(&scene, &better);
                    }
                }
                Arrival::Environment(Ok(file)) => {
                    for warning in file.warnings {
                        self.shell.notices.remark(ctx, warning);
                    }
                    if let Some(open) = &self.session.setup.open {
                        let mut appearance = open.scene.appearance().clone();
                        appearance.environment = Some(Arc::new(file.environment));
                        self.session.setup.dress(appearance);
                        self.session
                            .setup
                            .apply_environment(&self.options.environment);
                    }
                }
                Arrival::Reference(path, Ok(image)) => {
                    let size = (image.width, image.height);
                    self.session
                        .picture
                        .set_reference(path, size, &image.pixels);
                    self.viewing.settings.is_difference = true;
                }
                Arrival::Chosen(Wanted::Scene, path) => {
                    self.open_scene(path.display().to_string());
                }
                Arrival::Chosen(Wanted::Environment, path) => {
                    self.shell.background.open_environment(path);
                }
                Arrival::Chosen(Wanted::Reference, path) => {
                    self.shell.background.open_reference(path);
                }
                Arrival::Saved(Ok(text)) => self.shell.notices.remark(ctx, text),
                Arrival::Environment(Err(error))
                | Arrival::Reference(_, Err(error))
                | Arrival::Saved(Err(error)) => self.shell.notices.failure(error),
            }
        }
    }

    fn take_opened(&mut self, source: String, result: Result<Arc<Scene>, String>) {
        // Of several opened in haste, the last one asked for counts.
        if self.loading.as_ref().map(|l| &l.source) != Some(&source) {
            return;
        }
        self.loading = None;
        match result {
            Ok(scene) => {
                if builtin(&source).is_none() {
                    self.shell.recent.add(&source);
                }
                self.shell.background.improve(Arc::clone(&scene));
                self.take_scene(source, scene);
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

    pub(super) fn take_dropped_files(&mut self, ctx: &Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for path in files.iter().map(|file| file.path().to_owned()) {
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            match extension.to_str() {
                Some("hdr") => self.shell.background.open_environment(path),
                Some("exr") => self.shell.background.open_reference(path),
                _ => self.open_scene(path.display().to_string()),
            }
        }
    }
}
