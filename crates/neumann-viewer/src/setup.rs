//! What is rendered: scene, camera, method and depth. Any change of it begins anew.

use std::path::PathBuf;
use std::sync::Arc;

use neumann_core::film::DEFAULT_LAYERS;
use neumann_core::integrator::{DEFAULT_METHOD, METHODS, Method, ParameterValues};
use neumann_core::render::{RenderSettings, StopRule, lit};
use neumann_core::scene::description::{Crop, EnvironmentDescription};
use neumann_core::scene::{Appearance, Backs, BetterTree, Scene, Sky, SkyChoice};
use neumann_picture::state::KeptView;

use crate::camera_control::CameraControl;
use crate::options::{CameraOptions, EnvironmentOptions, ViewOptions};
use crate::state;

/// A scene that has been opened.
pub struct OpenScene {
    /// Name of a built-in scene, or a path.
    pub source: String,
    /// As it is rendered.
    pub scene: Arc<Scene>,
    /// As its file describes it.
    pub original: Appearance,
    /// Number of the camera that was taken last.
    pub camera: usize,
}

impl OpenScene {
    /// What it is called in a bar or a file name: the built-in name, or the file's stem.
    #[must_use]
    pub fn short_name(&self) -> &str {
        let stem = std::path::Path::new(&self.source).file_stem();
        stem.and_then(|s| s.to_str()).unwrap_or(&self.source)
    }
}

/// What is rendered, as it was, for whoever wants it back.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// Number of the camera that was taken last.
    pub of_file: usize,
    /// The camera under the user's hand.
    pub camera: Option<CameraControl>,
    /// What stood in place of the scene's own sky, if anything.
    pub sky: Option<SkyChoice>,
    /// Materials, lights, environment, backs.
    pub appearance: Arc<Appearance>,
    /// Index into [`METHODS`].
    pub method: usize,
    /// Parameters of every method.
    pub values: Vec<ParameterValues>,
    /// Terms with `k` up to and including this one were computed.
    pub max_bounces: u32,
    /// Bounce layers kept apart.
    pub n_layers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Snapshot {
    /// True if what is rendered now differs from it in its appearance at most.
    #[must_use]
    pub fn has_rest_of(&self, setup: &Setup) -> bool {
        let open = setup.open.as_ref();
        open.is_some_and(|open| open.camera == self.of_file)
            && self.camera == setup.camera
            && self.sky == setup.sky
            && self.method == setup.method
            && self.values == setup.values
            && self.max_bounces == setup.max_bounces
            && self.n_layers == setup.n_layers
            && self.seed == setup.seed
    }
}

/// What something of the scene is called: its name in the file, or its kind and number.
#[must_use]
pub fn name_or(name: &str, kind: &str, number: usize) -> String {
    if name.is_empty() {
        format!("{kind} {number}")
    } else {
        name.to_owned()
    }
}

/// Where the size of the film comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilmSize {
    /// The room for it in the window, when a render begins.
    #[default]
    Window,
    /// It stays as it is.
    Locked,
    /// So many columns and rows.
    Fixed(usize, usize),
}

/// Everything that determines the picture.
pub struct Setup {
    /// The scene; `None` until the first one has been opened.
    pub open: Option<OpenScene>,
    /// What stands in place of the scene's own sky, if anything.
    pub sky: Option<SkyChoice>,
    /// The camera under the user's hand.
    pub camera: Option<CameraControl>,
    /// Cameras of this scene that were kept,
    pub views: Vec<KeptView>,
    /// and the one that was kept or gone to last.
    pub view: Option<usize>,
    /// Index into [`METHODS`].
    pub method: usize,
    /// Parameters of every method, so that coming back to one finds them.
    pub values: Vec<ParameterValues>,
    /// Terms with `k` up to and including this one are computed.
    pub max_bounces: u32,
    /// Bounce layers kept apart.
    pub n_layers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// When rendering is done.
    pub stop: StopRule,
    /// Where the size of the film comes from.
    pub film_size: FilmSize,
    /// Size of the film.
    pub size: (usize, usize),
    /// The part of the picture that is rendered alone.
    pub region: Option<Crop>,
    /// Something has been changed since rendering was started last.
    pub is_changed: bool,
}

impl FilmSize {
    /// A size that was asked for; that of the window where none was.
    #[must_use]
    pub fn of(size: Option<(usize, usize)>) -> Self {
        size.map_or(Self::Window, |(width, height)| Self::Fixed(width, height))
    }
}

impl Setup {
    /// What the command asked for. Whatever of it is not possible is told in a sentence each.
    #[must_use]
    pub fn new(options: &ViewOptions) -> (Self, Vec<String>) {
        let mut complaints = Vec::new();
        let position = |id: &str| METHODS.iter().position(|m| m.id == id);
        let wanted = options.integrator.as_deref().unwrap_or(DEFAULT_METHOD);
        let method = position(wanted).unwrap_or_else(|| {
            complaints.push(format!("there is no integrator '{wanted}'"));
            position(DEFAULT_METHOD).unwrap_or(0)
        });
        let mut values: Vec<_> = METHODS
            .iter()
            .map(|m| ParameterValues::defaults(m.parameters))
            .collect();
        for (name, text) in &options.set {
            if let Err(error) = values[method].set(METHODS[method].parameters, name, text) {
                complaints.push(error.to_string());
            }
        }
        let setup = Self {
            open: None,
            sky: None,
            camera: None,
            views: Vec::new(),
            view: None,
            method,
            values,
            max_bounces: options.max_bounces.unwrap_or(16),
            n_layers: options.layers.unwrap_or(DEFAULT_LAYERS).max(1),
            seed: options.seed.unwrap_or(0),
            stop: options.stop,
            film_size: FilmSize::of(options.size),
            size: (0, 0),
            region: None,
            is_changed: false,
        };
        (setup, complaints)
    }

    /// The method.
    #[must_use]
    pub fn method(&self) -> &'static Method {
        METHODS[self.method.min(METHODS.len() - 1)]
    }

    /// Chooses a method by its place in [`METHODS`].
    pub fn choose_method(&mut self, index: usize) {
        if index < METHODS.len() && index != self.method {
            self.method = index;
            self.is_changed = true;
        }
    }

    /// Takes over a scene, with its first camera.
    pub fn take_scene(&mut self, source: String, scene: Arc<Scene>) {
        self.camera = scene
            .cameras()
            .first()
            .map(|camera| CameraControl::new(camera.clone(), scene.subject()));
        self.sky = None;
        self.region = None;
        self.views = Vec::new();
        self.view = None;
        self.open = Some(OpenScene {
            source,
            original: scene.appearance().clone(),
            scene,
            camera: 0,
        });
        self.is_changed = true;
    }

    /// Takes over a better tree; nothing about the picture changes. Yields the scene as it was and
    /// as it is, if the tree is for it.
    pub fn take_tree(&mut self, tree: &BetterTree) -> Option<[Arc<Scene>; 2]> {
        let open = self.open.as_mut()?;
        let better = Arc::new(open.scene.with_tree(tree)?);
        let scene = std::mem::replace(&mut open.scene, Arc::clone(&better));
        Some([scene, better])
    }

    /// Takes one of the file's cameras.
    pub fn take_camera(&mut self, index: usize) {
        let (Some(open), Some(control)) = (&mut self.open, &mut self.camera) else {
            return;
        };
        if let Some(camera) = open.scene.cameras().get(index) {
            open.camera = index;
            control.take(camera.clone());
            self.view = None;
            self.is_changed = true;
        }
    }

    /// Keeps the present camera as the view of that number, in place of the one there, or as one
    /// more where there is none; yields its number. `None` while there is no scene.
    pub fn keep_view(&mut self, index: usize) -> Option<usize> {
        let camera = state::camera_of(self)?;
        let index = index.min(self.views.len());
        if let Some(view) = self.views.get_mut(index) {
            view.camera = camera;
        } else {
            let is_free = |name: &String| self.views.iter().all(|view| view.name != *name);
            let mut names = (1..).map(|n| format!("View {n}"));
            let name = names.find(is_free).unwrap_or_default();
            self.views.push(KeptView { name, camera });
        }
        self.view = Some(index);
        Some(index)
    }

    /// Puts the camera where a view was kept; false if there is none of that number.
    pub fn go_to_view(&mut self, index: usize) -> bool {
        let Some(view) = self.views.get(index).cloned() else {
            return false;
        };
        state::take_camera(&view.camera, self);
        self.view = Some(index);
        self.is_changed = true;
        true
    }

    /// Forgets a view.
    pub fn forget_view(&mut self, index: usize) {
        if index < self.views.len() {
            self.views.remove(index);
            self.view = None;
        }
    }

    /// Changes materials, lights or environment; the geometry is shared with what was before.
    pub fn dress(&mut self, appearance: Appearance) {
        if let Some(open) = &mut self.open {
            open.scene = Arc::new(open.scene.with_appearance(appearance));
            self.is_changed = true;
        }
    }

    /// Applies what the command said about the camera; yields what was wrong with it.
    pub fn apply_camera(&mut self, options: &CameraOptions) -> Option<String> {
        let mut complaint = None;
        if let (Some(wanted), Some(open)) = (&options.camera, &self.open) {
            let cameras = open.scene.cameras();
            let by_name = cameras.iter().position(|c| c.name == *wanted);
            let by_number = wanted.parse().ok().filter(|i| *i < cameras.len());
            match by_name.or(by_number) {
                Some(index) => self.take_camera(index),
                None => complaint = Some(format!("the scene has no camera '{wanted}'")),
            }
        }
        let control = self.camera.as_mut()?;
        if options.eye.is_some() || options.target.is_some() || options.up.is_some() {
            let eye = options.eye.unwrap_or(control.eye());
            let target = options.target.unwrap_or(control.target());
            control.look_at(eye, target, options.up.unwrap_or(glam::Vec3::Y));
        }
        if let Some(fov) = options.fov {
            control.set_fov(fov.to_radians());
        }
        let mut lens = control.lens();
        lens.aperture = options.aperture.unwrap_or(lens.aperture);
        lens.focus_distance = options.focus.unwrap_or(lens.focus_distance);
        control.set_lens(lens);
        control.make_home();
        complaint
    }

    /// Puts a built-in sky, or none, in place of the environment, turned like the one before.
    pub fn choose_sky(&mut self, sky: Option<Sky>) {
        let Some(open) = &self.open else { return };
        self.sky = Some(sky.map_or(SkyChoice::None, SkyChoice::Builtin));
        let mut appearance = open.scene.appearance().clone();
        let rotation = appearance.environment.as_ref().map_or(0.0, |e| e.rotation);
        appearance.environment = sky.map(|sky| {
            Arc::new(EnvironmentDescription {
                rotation,
                ..sky.description()
            })
        });
        self.dress(appearance);
    }

    /// What is rendered now, to come back to; `None` without a scene.
    #[must_use]
    pub fn snapshot(&self) -> Option<Snapshot> {
        let open = self.open.as_ref()?;
        Some(Snapshot {
            of_file: open.camera,
            camera: self.camera.clone(),
            sky: self.sky.clone(),
            appearance: Arc::new(open.scene.appearance().clone()),
            method: self.method,
            values: self.values.clone(),
            max_bounces: self.max_bounces,
            n_layers: self.n_layers,
            seed: self.seed,
        })
    }

    /// Comes back to what was rendered, of the same scene.
    pub fn restore(&mut self, former: &Snapshot) {
        let Some(open) = &mut self.open else { return };
        open.camera = former.of_file;
        self.camera.clone_from(&former.camera);
        self.sky.clone_from(&former.sky);
        self.method = former.method;
        self.values.clone_from(&former.values);
        self.max_bounces = former.max_bounces;
        self.n_layers = former.n_layers;
        self.seed = former.seed;
        self.dress(Appearance::clone(&former.appearance));
    }

    /// Puts back the sky of a snapshot, and nothing else of it.
    pub fn put_sky_back(&mut self, former: &Snapshot) {
        let Some(now) = self.snapshot() else { return };
        let mut appearance = Appearance::clone(&now.appearance);
        appearance
            .environment
            .clone_from(&former.appearance.environment);
        appearance.environment_level = former.appearance.environment_level;
        appearance.environment_tint = former.appearance.environment_tint;
        self.restore(&Snapshot {
            sky: former.sky.clone(),
            appearance: Arc::new(appearance),
            ..now
        });
    }

    /// Puts a map that was read from a file in place of the environment.
    pub fn take_map(&mut self, file: PathBuf, map: EnvironmentDescription) {
        let Some(open) = &self.open else { return };
        self.sky = Some(SkyChoice::File(file));
        let mut appearance = open.scene.appearance().clone();
        appearance.environment = Some(Arc::new(map));
        self.dress(appearance);
    }

    /// Has the camera look through backs of single-sided surfaces, or not.
    pub fn choose_backs(&mut self, backs: Backs) {
        if let Some(open) = &mut self.open {
            open.scene = Arc::new(Scene::clone(&open.scene).with_backs(backs));
            self.is_changed = true;
        }
    }

    /// Adds the default sky where the scene's own light hardly shows what the camera sees; true if
    /// it was added.
    pub fn add_sky_where_dim(&mut self) -> bool {
        let Some(open) = &mut self.open else {
            return false;
        };
        if !open.scene.may_have_default_sky() {
            return false;
        }
        open.scene = Arc::new(lit(Scene::clone(&open.scene)));
        open.scene.has_default_sky()
    }

    /// Applies intensity and rotation of the environment.
    pub fn apply_environment(&mut self, options: &EnvironmentOptions) {
        let Some(open) = &self.open else { return };
        if options.intensity.is_none() && options.rotation.is_none() {
            return;
        }
        let mut appearance = open.scene.appearance().clone();
        if let Some(intensity) = options.intensity {
            appearance.environment_level.brightness = intensity;
        }
        if let (Some(rotation), Some(environment)) = (options.rotation, &mut appearance.environment)
        {
            Arc::make_mut(environment).rotation = rotation.to_radians();
        }
        self.dress(appearance);
    }

    /// Renders a region of the picture alone, or all of it again.
    pub fn choose_region(&mut self, region: Option<Crop>) {
        if self.region != region {
            self.region = region;
            self.is_changed = true;
        }
    }

    /// What the renderer is told; `None` while there is no scene or no film.
    #[must_use]
    pub fn settings(&self) -> Option<RenderSettings> {
        let control = self.camera.as_ref()?;
        if self.size.0 == 0 || self.size.1 == 0 {
            return None;
        }
        let mut camera = control.camera().clone();
        let (width, height) = self.size;
        camera.crop = self.region.filter(|region| region.of == [width, height]);
        let [width, height] = camera.crop.map_or([width, height], |region| region.size);
        let mut settings = RenderSettings::new(camera, width, height);
        settings.method = self.method();
        settings.values = self.values[self.method].clone();
        settings.max_bounces = self.max_bounces;
        settings.n_layers = self.n_layers;
        settings.seed = self.seed;
        Some(settings)
    }

    /// Size of the film where there is room for so many physical pixels: it fills the room, in the
    /// camera's own shape if it has one, unless it is not to follow the window.
    #[must_use]
    pub fn size_for(&self, room: egui::Vec2) -> (usize, usize) {
        match self.film_size {
            FilmSize::Fixed(width, height) => return (width, height),
            FilmSize::Locked if self.size != (0, 0) => return self.size,
            _ => {}
        }
        let (w, h) = (room.x.max(1.0), room.y.max(1.0));
        let aspect = self
            .camera
            .as_ref()
            .and_then(|c| c.camera().aspect_ratio)
            .filter(|a| a.is_finite() && *a > 0.01 && *a < 100.0);
        let (w, h) = match aspect {
            Some(aspect) if w / h > aspect => (h * aspect, h),
            Some(aspect) => (w, w / aspect),
            None => (w, h),
        };
        // A film of a part of a pixel, or of more than any display shows, helps nobody.
        let whole = |v: f32| (v + 0.01).floor().clamp(1.0, 8192.0) as usize;
        (whole(w), whole(h))
    }
}
