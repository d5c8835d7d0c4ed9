//! From what was typed to a scene and its settings.

mod camera;
mod classes;
mod parse;

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::Vec3;
use neumann_core::film::DEFAULT_LAYERS;
use neumann_core::integrator::{DEFAULT_METHOD, METHODS, ParameterValues, method};
use neumann_core::radiometry::Rgb;
use neumann_core::render::{RenderSettings, WorkerPool, hidden_by_backs, lit};
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::{CameraDescription, EnvironmentDescription};
use neumann_core::scene::load::LoadOptions;
use neumann_core::scene::{self, Backs, Scene, SkyChoice};
use neumann_picture::photons::PhotonColours;
use neumann_picture::state::{EnvironmentState, Exact, State};
use neumann_picture::tone::{Display, ToneCurve, auto_exposure};

use crate::console;
use crate::failure::{OrBadInput, Outcome, bad_input};
use crate::progress::while_waiting;
use crate::session::Shard;
use crate::suggest::check_scene;

pub(crate) use classes::ClassOptions;
pub(crate) use parse::{
    address, bytes, pixel, positive, probability, region, size, technique, viewing_angle, whole,
};

/// Highest power of T where nothing else is asked for.
const DEFAULT_MAX_BOUNCES: u32 = 16;

/// How a scene is loaded.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct LoadArguments {
    /// Let relative URIs of the scene leave its folder
    #[arg(long)]
    pub(crate) allow_outside: bool,
    /// Let relative URIs of the scene lead to hidden files and folders
    #[arg(long)]
    pub(crate) allow_hidden: bool,
}

/// What determines the picture.
#[derive(Clone, Debug, Args)]
pub(crate) struct SettingsOptions {
    /// Method of rendering ('neumann list integrators')
    #[arg(
        long,
        value_name = "ID",
        default_value = DEFAULT_METHOD,
        value_parser = integrators(),
        hide_possible_values = true
    )]
    pub(crate) integrator: String,
    /// Set a parameter of the method ('neumann list parameters'); may be given several times
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse::assignment)]
    pub(crate) set: Vec<(String, String)>,
    /// Size of the picture, pixels [default: the camera's shape, 512 on the longer edge]
    #[arg(long, value_name = "WxH", value_parser = size, allow_hyphen_values = true)]
    pub(crate) size: Option<(usize, usize)>,
    /// Highest power of T that is computed
    #[arg(
        long,
        value_name = "N",
        default_value_t = DEFAULT_MAX_BOUNCES,
        value_parser = parse::whole(0..=65_535),
        allow_hyphen_values = true
    )]
    pub(crate) max_bounces: u32,
    /// Bounce layers kept apart; everything beyond them goes to one more, the tail
    #[arg(
        long,
        value_name = "K",
        default_value_t = DEFAULT_LAYERS as u32,
        value_parser = parse::whole(1..=64),
        allow_hyphen_values = true
    )]
    pub(crate) layers: u32,
    /// Seed of all random numbers
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0,
        value_parser = parse::long_whole,
        allow_hyphen_values = true
    )]
    pub(crate) seed: u64,
    /// Threads that render [default: all]
    #[arg(
        long,
        value_name = "N",
        value_parser = parse::whole(1..=1024),
        allow_hyphen_values = true
    )]
    pub(crate) threads: Option<u32>,
    /// Backs of single-sided surfaces: solid, or see-through for the camera (a room from outside, a
    /// model in its outline hull); to light they are solid, unless unlit
    #[arg(long, value_name = "BACKS", default_value = Backs::Solid.name(), value_parser = backs())]
    pub(crate) backs: Backs,
    #[command(flatten)]
    pub(crate) camera: CameraArguments,
    #[command(flatten)]
    pub(crate) environment: EnvironmentArguments,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
}

/// Which camera, and what about it is different.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraArguments {
    /// Camera of the file, by name or number from 0
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) camera: Option<String>,
    /// Where the camera stands, metres
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true)]
    pub(crate) eye: Option<Vec3>,
    /// What it looks at
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true)]
    pub(crate) target: Option<Vec3>,
    /// What is up for it
    #[arg(long, value_name = "X,Y,Z", value_parser = parse::vector, allow_hyphen_values = true)]
    pub(crate) up: Option<Vec3>,
    /// Vertical angle of view, degrees
    #[arg(
        long,
        value_name = "DEG",
        value_parser = parse::angle_of_view,
        allow_hyphen_values = true
    )]
    pub(crate) fov: Option<f32>,
    /// Diameter of the lens opening, metres; 0 for a pinhole
    #[arg(long, value_name = "M", value_parser = parse::not_negative, allow_hyphen_values = true)]
    pub(crate) aperture: Option<f32>,
    /// Distance of what is sharp, metres [default: of what is in the middle of the picture]
    #[arg(
        long,
        value_name = "M",
        value_parser = parse::positive_single,
        allow_hyphen_values = true
    )]
    pub(crate) focus: Option<f32>,
}

/// An environment in place of the scene's.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Environment")]
pub(crate) struct EnvironmentArguments {
    /// Sky in place of the scene's: studio, uniform, sun or none, or a lat-long map, .hdr or .exr
    /// ('./sun' for a file of such a name). A map's centre is seen looking along -Z, its right half
    /// towards +X
    #[arg(long, value_name = "NAME|FILE", value_parser = sky)]
    pub(crate) env: Option<SkyChoice>,
    /// Factor on the environment
    #[arg(long, value_name = "F", value_parser = parse::not_negative, allow_hyphen_values = true)]
    pub(crate) env_intensity: Option<f32>,
    /// Turn of the environment about the vertical, degrees, counter-clockwise seen from above; a
    /// map placed as in Blender (exported with +Y up) needs -90, as in Mitsuba 180
    #[arg(long, value_name = "DEG", value_parser = parse::finite, allow_hyphen_values = true)]
    pub(crate) env_rotation: Option<f32>,
}

/// How the picture is shown.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Display")]
pub(crate) struct DisplayOptions {
    /// Exposure: stops, or auto to bring what is lit to middle grey on average [default: 0; in the
    /// window auto for files of your own]
    #[arg(long, value_name = "EV|auto", value_parser = parse::exposure, allow_hyphen_values = true)]
    pub(crate) exposure: Option<Exposure>,
    /// Tone curve
    #[arg(long, value_name = "CURVE", default_value = "none", value_parser = tone_curves())]
    pub(crate) tone: ToneCurve,
}

/// How bright radiance is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Exposure {
    /// Multiplied by 2 to this power.
    Stops(f32),
    /// As suits the picture.
    Auto,
}

/// When rendering is done.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "How long")]
pub(crate) struct GoalOptions {
    /// Number of iterations of the picture
    #[arg(
        long,
        value_name = "N",
        value_parser = parse::whole(1..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) iterations: Option<u32>,
    /// Time of rendering; an iteration that would end later is not begun, but for the first
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,
    /// Estimated relative error of the picture, such as 0.01: the root of the mean variance over
    /// pixels and channels, over the mean radiance; unknown until light has been found
    #[arg(long, value_name = "RELATIVE", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) until_error: Option<f64>,
    /// Number of the first iteration; renders with different ones can be merged
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = parse::whole(0..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) first_iteration: u32,
    /// Render part I (from 1 on) of N equal parts of the iterations; 'neumann merge' joins the
    /// parts
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub(crate) shard: Option<Shard>,
    /// Save the .exr so often while rendering, so that a kill loses no more; 0 for never
    /// [default: 60, or longer, so that saving takes no more than a twentieth of the time]
    #[arg(
        long,
        value_name = "SECONDS",
        value_parser = parse::not_negative_double,
        allow_hyphen_values = true
    )]
    pub(crate) checkpoint: Option<f64>,
}

impl EnvironmentArguments {
    /// True if the environment is to be other than it comes.
    fn adjusts(&self) -> bool {
        self.env_intensity.is_some() || self.env_rotation.is_some()
    }

    /// Brightens and turns the environment.
    fn adjust(&self, map: &mut EnvironmentDescription) {
        map.intensity = self.env_intensity.unwrap_or(map.intensity);
        map.rotation = self.env_rotation.map_or(map.rotation, f32::to_radians);
    }
}

impl DisplayOptions {
    /// How to show pictures of which `pixels` is the one to expose for.
    pub(crate) fn display(&self, pixels: impl FnOnce() -> Vec<Rgb>) -> Display {
        let exposure_ev = match self.exposure {
            None => 0.0,
            Some(Exposure::Stops(stops)) => stops,
            Some(Exposure::Auto) => {
                let stops = auto_exposure(&pixels());
                console::note(&format!("exposure {stops:.2} by itself"));
                stops
            }
        };
        Display {
            exposure_ev,
            tone: self.tone,
        }
    }
}

/// Opens a scene by name or path with the environment asked for, and says what is odd about it.
pub(crate) fn open_scene(
    name: &str,
    load: &LoadArguments,
    environment: &EnvironmentArguments,
    backs: Backs,
) -> Outcome<Scene> {
    let options = LoadOptions {
        allow_outside: load.allow_outside,
        allow_hidden: load.allow_hidden,
        ..LoadOptions::default()
    };
    check_scene(name)?;
    let mut description =
        while_waiting(&format!("reading {name}"), || scene::open(name, &options)).or_bad_input()?;
    if let Some(sky) = &environment.env {
        sky.apply(&mut description).or_bad_input()?;
    }
    if let Some(map) = &mut description.environment {
        environment.adjust(map);
    }
    let n_triangles: usize = description
        .instances
        .iter()
        .filter_map(|i| Some(description.meshes.get(i.mesh)?.triangles.len()))
        .sum();
    let building = format!("building trees over {n_triangles} triangles");
    let mut scene = while_waiting(&building, || {
        lit(Scene::build(&description).with_backs(backs))
    });
    if description.environment.is_none() && environment.adjusts() {
        let mut appearance = scene.appearance().clone();
        let Some(default_sky) = &mut appearance.environment else {
            return Err(bad_input(format!(
                "{name}: has no environment to turn or brighten; give one with --env"
            )));
        };
        environment.adjust(Arc::make_mut(default_sky));
        scene = scene.with_appearance(appearance);
    }
    for warning in scene.warnings() {
        console::note(&format!("warning: {warning}"));
    }
    Ok(scene)
}

impl SettingsOptions {
    /// What holds where nothing is typed.
    pub(crate) fn defaults() -> Self {
        Self {
            integrator: DEFAULT_METHOD.to_owned(),
            set: Vec::new(),
            size: None,
            max_bounces: DEFAULT_MAX_BOUNCES,
            layers: DEFAULT_LAYERS as u32,
            seed: 0,
            threads: None,
            camera: CameraArguments::default(),
            environment: EnvironmentArguments::default(),
            backs: Backs::default(),
            load: LoadArguments::default(),
        }
    }

    /// The scene and the settings, ready to render.
    pub(crate) fn resolve(&self, name: &str) -> Outcome<(Arc<Scene>, RenderSettings)> {
        let method = method(&self.integrator)
            .ok_or_else(|| bad_input(format!("no integrator '{}'", self.integrator)))?;
        let mut values = ParameterValues::defaults(method.parameters);
        for (parameter, text) in &self.set {
            values
                .set(method.parameters, parameter, text)
                .map_err(|e| bad_input(format!("--set {parameter}={text}: {} ({e})", method.id)))?;
        }
        let scene = open_scene(name, &self.load, &self.environment, self.backs)?;
        let camera = camera::resolve(&self.camera, &scene)?;
        tell_of_backs(&scene, &camera);
        let (width, height) = self.size.unwrap_or_else(|| default_size(&camera));
        let settings = RenderSettings {
            method,
            values,
            camera,
            width,
            height,
            max_bounces: self.max_bounces,
            n_layers: self.layers as usize,
            seed: self.seed,
        };
        Ok((Arc::new(scene), settings))
    }

    /// What is rendered, as a state that the window can take up.
    pub(crate) fn state(&self, name: &str, scene: &Scene, settings: &RenderSettings) -> State {
        let map = scene.appearance().environment.as_deref();
        let sky = self.environment.env.as_ref();
        State {
            environment: EnvironmentState {
                brightness: Exact(self.environment.env_intensity.unwrap_or(1.0)),
                ..EnvironmentState::of(sky, map)
            },
            backs: self.backs.name().to_owned(),
            ..State::of_render(name, settings)
        }
    }

    /// The files that a scene is made of.
    pub(crate) fn inputs(&self, name: &str, scene: &Scene) -> Vec<PathBuf> {
        let mut inputs = scene.report().files.clone();
        if builtin(name).is_none() {
            inputs.push(PathBuf::from(name));
        }
        let sky = self.environment.env.as_ref();
        inputs.extend(sky.and_then(SkyChoice::file).cloned());
        inputs
    }

    /// The threads that render.
    pub(crate) fn pool(&self) -> Outcome<WorkerPool> {
        let n_threads = self.threads.map(|n| n as usize);
        WorkerPool::new(n_threads, || ())
            .map_err(|e| anyhow::anyhow!("cannot start threads: {e}; try a smaller --threads"))
    }
}

/// Says so where backs hide much of what the camera is to see.
fn tell_of_backs(scene: &Scene, camera: &CameraDescription) {
    if let Some(share) = hidden_by_backs(scene, camera) {
        console::note(&format!(
            "warning: backs of single-sided surfaces hide {:.0} % of what the camera sees; \
             --backs see-through looks through them",
            share * 100.0
        ));
    }
}

/// Longer edge of a picture where no size is asked for, pixels.
const DEFAULT_EDGE: f32 = 512.0;

fn default_size(camera: &CameraDescription) -> (usize, usize) {
    let is_usable = |a: &f32| a.is_finite() && *a > 0.0;
    let aspect = camera.aspect_ratio.filter(is_usable).unwrap_or(1.0);
    let shorter = |ratio: f32| ((DEFAULT_EDGE * ratio).round() as usize).max(1);
    if aspect >= 1.0 {
        (DEFAULT_EDGE as usize, shorter(1.0 / aspect))
    } else {
        (shorter(aspect), DEFAULT_EDGE as usize)
    }
}

pub(crate) fn integrators() -> impl TypedValueParser<Value = String> {
    PossibleValuesParser::new(
        METHODS
            .iter()
            .map(|m| PossibleValue::new(m.id).help(m.name)),
    )
}

/// A sky by name, or a map by path.
fn sky(text: &str) -> Result<SkyChoice, std::convert::Infallible> {
    Ok(SkyChoice::from_word(text))
}

/// What photons can be coloured by.
pub(crate) fn photon_colours() -> impl TypedValueParser<Value = PhotonColours> {
    let names = PhotonColours::ALL.map(|colours| PossibleValue::new(colours.name()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<PhotonColours>())
}

pub(crate) fn backs() -> impl TypedValueParser<Value = Backs> {
    PossibleValuesParser::new(Backs::ALL.map(Backs::name))
        .map(|name| Backs::named(&name).unwrap_or_default())
}

fn tone_curves() -> impl TypedValueParser<Value = ToneCurve> {
    PossibleValuesParser::new(ToneCurve::ALL.map(ToneCurve::name))
        .try_map(|name| name.parse::<ToneCurve>())
}

#[cfg(test)]
mod tests {
    use neumann_core::scene::description::{CameraDescription, Projection};

    use super::default_size;

    #[test]
    fn the_longer_edge_is_512() {
        let with_aspect = |aspect_ratio| CameraDescription {
            name: String::new(),
            world_from_camera: glam::Mat4::IDENTITY,
            aspect_ratio,
            projection: Projection::Perspective { yfov: 0.7 },
            lens: None,
            crop: None,
        };
        assert_eq!(default_size(&with_aspect(None)), (512, 512));
        assert_eq!(default_size(&with_aspect(Some(2.0))), (512, 256));
        assert_eq!(default_size(&with_aspect(Some(0.5))), (256, 512));
        assert_eq!(default_size(&with_aspect(Some(1e9))), (512, 1));
        assert_eq!(default_size(&with_aspect(Some(f32::NAN))), (512, 512));
    }
}
