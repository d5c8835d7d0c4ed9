//! The window's state, and one frame of it: shared by the window, screenshots and tests.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Context, Rect, Ui, pos2};
use neumann_core::render::hidden_by_backs;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::load::LoadOptions;
use neumann_core::scene::{Backs, OpeningProgress, Scene, SkyChoice};

use crate::display::{ViewSettings, image_area};
use crate::gallery::Gallery;
use crate::keys;
use crate::notices::{Notices, Offer};
use crate::options::{Exposure, ViewOptions};
use crate::panels::{self, Page};
use crate::picture::Picture;
use crate::recent::Recent;
use crate::render_link::RenderLink;
use crate::scene_source::{Arrival, Background, Wanted};
use crate::setup::Setup;
use crate::status::{self, Status};
use crate::techniques::{self, TechniqueView};
use crate::{filmstrip, help, stage, theme, top_bar};

/// All state of the window.
pub struct App {
    /// The line to the renderer.
    pub link: RenderLink,
    /// What is rendered.
    pub setup: Setup,
    /// How it is looked at.
    pub viewing: ViewSettings,
    /// The film as of this frame.
    pub picture: Picture,
    /// The techniques of a bidirectional method, apart.
    pub techniques: TechniqueView,
    /// What runs in the background.
    pub background: Background,
    /// What the window has to say.
    pub notices: Notices,
    /// Scenes opened lately.
    pub recent: Recent,
    /// The page of the panel.
    pub page: Page,
    /// Bars, panel and filmstrip are hidden.
    pub is_bare: bool,
    /// The help page is shown.
    pub is_help_open: bool,
    /// The menu of methods is open.
    pub is_menu_open: bool,
    /// What stands in the field for a scene's path.
    pub path: String,
    /// What stands in the field for an environment map's path.
    pub environment_path: String,
    /// What stands in the field for a reference's path.
    pub reference_path: String,
    /// The material that is being edited.
    pub material: Option<usize>,
    /// Small pictures of the built-in scenes.
    pub gallery: Gallery,
    /// What the window itself is to do.
    pub requests: Vec<WindowRequest>,
    /// A control had the keyboard at the end of the last frame; the toolkit takes it away at Esc itself.
    pub(crate) had_focus: bool,
    pub(crate) placement: Option<image_area::Placement>,
    options: ViewOptions,
    is_first_scene: bool,
    /// Exposure follows the picture because the scene is the user's own, not because anybody asked.
    exposes_by_itself: bool,
    loading: Option<Loading>,
    resized: Option<Instant>,
    wanted_size: (usize, usize),
    debounces_resize: bool,
}

/// How often the bar of a scene that is being opened is drawn anew.
const PROGRESS_PERIOD: Duration = Duration::from_millis(50);

/// A scene on its way.
pub struct Loading {
    /// What it was asked for by.
    pub source: String,
    /// How far it is.
    pub progress: OpeningProgress,
}

/// What only the window can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowRequest {
    /// Close.
    Quit,
    /// Fill the screen, or no longer.
    Fullscreen,
}

/// A film is made for a new size of the window when that has held this long.
const RESIZE_DELAY: Duration = Duration::from_millis(180);

const TOP: f32 = 40.0;
const STATUS: f32 = 24.0;
const PANEL: f32 = 272.0;

impl App {
    /// A window on what `link` renders. `wake` asks for a frame, from any thread.
    #[must_use]
    pub fn new(
        link: RenderLink,
        options: ViewOptions,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let (setup, complaints) = Setup::new(&options);
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(wake);
        let mut notices = Notices::default();
        for complaint in complaints {
            notices.failure(complaint);
        }
        let viewing = ViewSettings {
            view: options.view,
            exposure_ev: match options.exposure {
                Exposure::Stops(stops) => stops,
                _ => 0.0,
            },
            is_auto: options.exposure == Exposure::Auto,
            tone: options.tone,
            ..ViewSettings::default()
        };
        let debounces_resize = options.screenshot.is_none();
        Self {
            link,
            setup,
            viewing,
            picture: Picture::default(),
            techniques: TechniqueView::default(),
            background: Background::new(Arc::clone(&wake)),
            notices,
            recent: Recent::default(),
            page: Page::default(),
            is_bare: false,
            is_help_open: false,
            is_menu_open: false,
            path: String::new(),
            environment_path: String::new(),
            reference_path: String::new(),
            material: None,
            gallery: Gallery::new(wake),
            requests: Vec::new(),
            had_focus: false,
            placement: None,
            options,
            is_first_scene: true,
            exposes_by_itself: false,
            loading: None,
            resized: None,
            wanted_size: (0, 0),
            debounces_resize,
        }
    }

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
        let background = &mut self.background;
        let progress = background.open_scene(source.clone(), sky, backs, options);
        self.loading = Some(Loading { source, progress });
    }

    /// Takes over a scene that is ready.
    pub fn take_scene(&mut self, source: String, scene: Arc<Scene>) {
        let warnings = scene.warnings().to_vec();
        if self.options.exposure == Exposure::ForScene {
            self.expose_for(&source);
        }
        self.setup.take_scene(source, scene);
        self.material = None;
        self.viewing.zoom = None;
        if self.is_first_scene {
            self.is_first_scene = false;
            if let Some(complaint) = self.setup.apply_camera(&self.options.camera) {
                self.notices.failure(complaint);
            }
            if let Some(SkyChoice::File(file)) = self.options.environment.sky.clone() {
                self.background.open_environment(file);
            }
            self.setup.apply_environment(&self.options.environment);
        }
        self.tell_warnings(&warnings);
        self.tell_of_sky();
        self.tell_of_backs();
    }

    /// Offers to take away a sky that was added.
    fn tell_of_sky(&mut self) {
        let Some(open) = &self.setup.open else { return };
        if open.scene.has_default_sky() {
            // The last of the warnings says why.
            let why = open.scene.warnings().last().map_or("", String::as_str);
            self.notices.offer(why, "Remove sky", Offer::RemoveSky);
        }
    }

    /// Offers to look through backs that hide much of what the camera is to see.
    fn tell_of_backs(&mut self) {
        self.notices.withdraw(Offer::LookThroughBacks);
        let (Some(open), Some(control)) = (&self.setup.open, &self.setup.camera) else {
            return;
        };
        if let Some(share) = hidden_by_backs(&open.scene, control.camera()) {
            let text = format!(
                "Backs of single-sided surfaces hide {:.0} % of what the camera sees",
                share * 100.0
            );
            let notices = &mut self.notices;
            notices.offer(text, "Look through", Offer::LookThroughBacks);
        }
    }

    /// Whoever made a file had another program's exposure in mind; a built-in scene suits exposure 0.
    fn expose_for(&mut self, source: &str) {
        if builtin(source).is_none() {
            self.viewing.is_auto = true;
            self.exposes_by_itself = true;
        } else if self.exposes_by_itself && self.viewing.is_auto {
            self.viewing.is_auto = false;
            self.viewing.exposure_ev = 0.0;
            self.exposes_by_itself = false;
        }
    }

    /// Shows the first few warnings of a scene, and where the others are.
    fn tell_warnings(&mut self, warnings: &[String]) {
        const MOST: usize = 3;
        let n_sky = usize::from(
            self.setup
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
        self.notices.failure(text);
    }

    /// Does what a notice offers.
    fn accept(&mut self, offer: Offer) {
        match offer {
            Offer::RemoveSky => self.setup.choose_sky(None),
            Offer::LookThroughBacks => {
                self.setup.choose_backs(Backs::SeeThrough);
                // What was behind them may stand in the dark.
                if self.setup.add_sky_where_dim() {
                    self.tell_of_sky();
                }
            }
        }
    }

    /// True while a scene is being opened.
    #[must_use]
    pub fn is_loading(&self) -> bool {
        self.loading.is_some()
    }

    /// The scene that is being opened.
    #[must_use]
    pub fn loading(&self) -> Option<&Loading> {
        self.loading.as_ref()
    }

    /// True when the picture on screen is of what has been asked for.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.picture.is_there() && self.picture.generation == self.link.generation()
    }

    /// Draws one frame and acts on its input.
    pub fn ui(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if !theme::is_installed(&ctx) {
            theme::install(&ctx);
            ctx.request_repaint();
            return;
        }
        self.take_arrivals(&ctx);
        self.take_dropped_files(&ctx);
        if self.is_loading() {
            ctx.request_repaint_after(PROGRESS_PERIOD);
        }
        for action in keys::take_actions(&ctx) {
            self.perform(&ctx, action);
        }
        stage::fly(&ctx, self);
        self.picture.refresh(&self.link, &mut self.viewing);

        let window = ctx.content_rect();
        let mut stage_rect = window;
        let mut n_draws = stage::N_DRAWS;
        if !self.is_bare {
            let top = Rect::from_min_max(window.min, pos2(window.right(), window.top() + TOP));
            top_bar::show(ui, top, self);
            let bottom =
                Rect::from_min_max(pos2(window.left(), window.bottom() - STATUS), window.max);
            let strip_top = bottom.top() - filmstrip::height(window.size());
            let strip = Rect::from_min_max(
                pos2(window.left(), strip_top),
                pos2(window.right(), bottom.top()),
            );
            n_draws = filmstrip::show(ui, strip, &self.picture, &mut self.viewing, n_draws);
            let panel_width = if window.width() < 800.0 { 240.0 } else { PANEL };
            let panel = Rect::from_min_max(
                pos2(window.right() - panel_width, top.bottom()),
                pos2(window.right(), strip.top()),
            );
            panels::show(ui, panel, self);
            self.status_line(ui, bottom);
            stage_rect = Rect::from_min_max(
                pos2(window.left(), top.bottom()),
                pos2(panel.left(), strip.top()),
            );
        }
        debug_assert!(
            n_draws <= crate::display::MAX_DRAWS,
            "room for all draw calls"
        );
        self.follow_size(&ctx, stage_rect);
        techniques::attend(self);
        if self.techniques.is_open {
            techniques::show(ui, stage_rect, self);
        } else {
            stage::show(ui, stage_rect, self);
        }
        if let Some(offer) = self.notices.show(&ctx, stage_rect) {
            self.accept(offer);
        }
        if self.is_help_open {
            help::show(ui, &mut self.is_help_open);
        }
        self.had_focus = ctx.memory(|m| m.focused().is_some());
        self.start_if_changed();
    }

    /// Starts rendering anew if anything of it has been changed.
    pub fn start_if_changed(&mut self) {
        if !self.setup.is_changed {
            return;
        }
        let (Some(settings), Some(open)) = (self.setup.settings(), &self.setup.open) else {
            return;
        };
        self.link
            .start(Arc::clone(&open.scene), settings, self.setup.stop);
        self.setup.is_changed = false;
    }

    /// Lets the film's size follow the room for it, when that has come to rest.
    fn follow_size(&mut self, ctx: &Context, rect: Rect) {
        let wanted = self.setup.size_for(rect.size() * ctx.pixels_per_point());
        if wanted == self.setup.size || self.setup.open.is_none() {
            self.wanted_size = wanted;
            self.resized = None;
            return;
        }
        if wanted != self.wanted_size {
            self.wanted_size = wanted;
            self.resized = Some(Instant::now());
        }
        let is_first = self.setup.size == (0, 0) || !self.debounces_resize;
        let rested = self.resized.map_or(RESIZE_DELAY, |since| since.elapsed());
        if is_first || rested >= RESIZE_DELAY {
            self.setup.size = wanted;
            self.setup.is_changed = true;
            self.resized = None;
        } else {
            ctx.request_repaint_after(RESIZE_DELAY - rested);
        }
    }

    fn status_line(&self, ui: &mut Ui, rect: Rect) {
        let status = Status {
            picture: &self.picture,
            stop: self.setup.stop,
            is_paused: self.link.is_paused(),
            is_waiting: !self.is_current(),
            opening: self.loading.as_ref().map(|l| &l.progress),
            bias: self.bias(),
        };
        status::show(ui, rect, &status);
    }

    /// Why the picture is biased, if it is: a method that merges is not while nothing is merged.
    fn bias(&self) -> Option<&'static str> {
        let photons = self.picture.stats.photons.filter(|_| self.is_current());
        let merges = photons.is_none_or(|photons| photons.radius > 0.0);
        self.setup.method().bias.filter(|_| merges)
    }

    fn take_arrivals(&mut self, ctx: &Context) {
        for arrival in self.background.arrivals() {
            match arrival {
                Arrival::Scene(source, result) => self.take_opened(source, result),
                Arrival::Tree(tree) => {
                    if let Some([scene, better]) = self.setup.take_tree(&tree) {
                        self.link.improve_scene(&scene, &better);
                    }
                }
                Arrival::Environment(Ok(file)) => {
                    for warning in file.warnings {
                        self.notices.remark(ctx, warning);
                    }
                    if let Some(open) = &self.setup.open {
                        let mut appearance = open.scene.appearance().clone();
                        appearance.environment = Some(Arc::new(file.environment));
                        self.setup.dress(appearance);
                        self.setup.apply_environment(&self.options.environment);
                    }
                }
                Arrival::Reference(path, Ok(image)) => {
                    let size = (image.width, image.height);
                    self.picture.set_reference(path, size, &image.pixels);
                    self.viewing.is_difference = true;
                }
                Arrival::Chosen(Wanted::Scene, path) => {
                    self.open_scene(path.display().to_string());
                }
                Arrival::Chosen(Wanted::Environment, path) => {
                    self.background.open_environment(path);
                }
                Arrival::Chosen(Wanted::Reference, path) => self.background.open_reference(path),
                Arrival::Saved(Ok(text)) => self.notices.remark(ctx, text),
                Arrival::Environment(Err(error))
                | Arrival::Reference(_, Err(error))
                | Arrival::Saved(Err(error)) => self.notices.failure(error),
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
                    self.recent.add(&source);
                }
                self.background.improve(Arc::clone(&scene));
                self.take_scene(source, scene);
            }
            Err(error) => {
                self.notices.failure(error);
                if self.setup.open.is_none() && source != "cornell" {
                    // Better the default scene beside the notice than an empty window.
                    self.open_scene("cornell".to_owned());
                }
            }
        }
    }

    fn take_dropped_files(&mut self, ctx: &Context) {
        let files = ctx.input(|i| i.raw.dropped_files.clone());
        for path in files.iter().map(|file| file.path().to_owned()) {
            let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
            match extension.to_str() {
                Some("hdr") => self.background.open_environment(path),
                Some("exr") => self.background.open_reference(path),
                _ => self.open_scene(path.display().to_string()),
            }
        }
    }
}
