//! All that a person has chosen, as one structure: scene, camera, method, view, exposure, edits,
//! what views look at.
//!
//! A state file is this as JSON. Whoever opens it sees what was seen when it was saved: numbers
//! come back bit by bit ([`Exact`]). Fields that are left out have their usual value, so that a
//! file may be written by hand; those that nobody knows are ignored and told. What is measured (the
//! film, its iterations) is no part of it.

mod check;
mod file;
mod kept;
mod looked_at;
mod number;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

use glam::Mat4;
use neumann_core::film::{DEFAULT_LAYERS, LightGroup};
use neumann_core::integrator::DEFAULT_METHOD;
use neumann_core::render::RenderSettings;
use neumann_core::scene::SkyChoice;
use neumann_core::scene::builtin::builtin;
use neumann_core::scene::description::{
    CameraDescription, Crop, EnvironmentDescription, Lens, Projection,
};
use serde::{Deserialize, Serialize};

pub use file::StateError;
pub use kept::{KeptView, KeptViews};
pub use looked_at::{LobesOf, LookedAt, Racing};
pub use number::Exact;

/// All that a person has chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    /// Version of the program that wrote it.
    pub neumann: String,
    /// Name of a built-in scene, or a path, which may be relative to the state's own folder.
    pub scene: String,
    /// The camera; the file's first one where there is none.
    pub camera: Option<CameraState>,
    /// Cameras of this scene that were kept.
    pub views: Vec<KeptView>,
    /// Id of the method.
    pub method: String,
    /// Its parameters, as `--set` takes them; those that are left out have their default.
    pub parameters: BTreeMap<String, String>,
    /// Terms with `k` up to and including this one are computed.
    pub max_bounces: u32,
    /// Bounce layers kept apart.
    pub layers: usize,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Width and height of the film; it follows the window where there is none.
    pub size: Option<[usize; 2]>,
    /// The part of the picture that is rendered alone; all of it where there is none.
    pub region: Option<RegionState>,
    /// When rendering is done.
    pub stop: Stop,
    /// Id of what stands on the stage: `picture`, `techniques`.
    pub view: String,
    /// Part of the series: `L`, `T0`, `upto:3`, `tail`.
    pub part: String,
    /// How bright radiance is shown.
    pub exposure: ExposureState,
    /// Tone curve.
    pub tone: String,
    /// Luminance as colours.
    pub false_colour: FalseColourState,
    /// A part of the picture, magnified; the whole of it where there is none.
    pub magnified: Option<Magnified>,
    /// Light from infinitely far away.
    pub environment: EnvironmentState,
    /// What the camera makes of backs: `solid`, `see-through`.
    pub backs: String,
    /// What is other than in the scene's file.
    pub edits: Edits,
    /// What views beside the picture look at.
    pub looked_at: LookedAt,
    /// Layers beside the bounces.
    pub layers_beside: LayersState,
}

/// Layers beside the bounces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LayersState {
    /// Light path expressions, a layer each; a name and `=` may stand before one.
    pub expressions: Vec<String>,
    /// `each` for the light of each source apart, or groups: `key=lamp,candle;sky=environment`.
    pub lights: String,
    /// Factors on the light of groups, linear, by their names.
    pub mix: BTreeMap<String, [Exact; 3]>,
}

impl Default for LayersState {
    fn default() -> Self {
        Self {
            expressions: ["direct", "indirect diffuse", "caustics"]
                .map(str::to_owned)
                .into(),
            lights: LightGroup::EACH.to_owned(),
            mix: BTreeMap::new(),
        }
    }
}

/// A camera, all of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraState {
    /// Number of the file's camera that it began as.
    #[serde(default)]
    pub of_file: usize,
    /// From camera space to world space, column by column.
    pub world_from_camera: [Exact; 16],
    /// Width over height that the file asks for.
    #[serde(default)]
    pub aspect_ratio: Option<Exact>,
    /// Projection.
    pub projection: ProjectionState,
    /// Lens; a pinhole where there is none.
    #[serde(default)]
    pub lens: Option<LensState>,
    /// What it orbits, metres; a point before it where there is none.
    #[serde(default)]
    pub target: Option<[Exact; 3]>,
    /// What is up for it; upwards in its own picture, or the vertical if it is nearly level, where
    /// there is none.
    #[serde(default)]
    pub up: Option<[Exact; 3]>,
}

/// How a camera maps directions to the film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProjectionState {
    /// Vertical angle of view, radians.
    Perspective {
        /// The angle.
        yfov: Exact,
    },
    /// Half the height of the view, metres.
    Orthographic {
        /// Half the height.
        ymag: Exact,
    },
}

/// A thin lens.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LensState {
    /// Diameter of the opening, metres.
    pub aperture: Exact,
    /// Distance of what is sharp, metres.
    pub focus_distance: Exact,
}

/// A part of the picture that is rendered alone, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegionState {
    /// Width and height of the whole picture; the size of the film, if that is given.
    pub of: [usize; 2],
    /// First column and first row.
    pub at: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

/// When rendering is done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    /// Never.
    #[default]
    Never,
    /// After so many iterations.
    Iterations(u32),
    /// After so much time of rendering.
    Seconds(f64),
}

/// How bright radiance is shown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ExposureState {
    /// Multiplied by 2 to this power.
    pub stops: Exact,
    /// It follows the picture.
    pub is_automatic: bool,
}

/// Luminance as colours.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FalseColourState {
    /// Colours stand in place of the picture.
    pub is_on: bool,
    /// Which colours.
    pub colours: String,
    /// Stops that they span.
    pub stops: Exact,
}

/// A part of the picture, magnified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Magnified {
    /// Physical pixels per pixel of the film.
    pub zoom: Exact,
    /// What is in the middle, as a share of width and height.
    pub center: [Exact; 2],
}

/// Light from infinitely far away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnvironmentState {
    /// `own` for the scene's, `none`, the name of a built-in sky, or the path of a map.
    pub sky: String,
    /// Turn about the vertical, radians; as the sky has it where there is none.
    pub rotation: Option<Exact>,
    /// It shines.
    pub is_on: bool,
    /// Factor on it.
    pub brightness: Exact,
    /// Linear colour that it is multiplied by.
    pub tint: [Exact; 3],
}

/// What is other than in the scene's file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Edits {
    /// Materials that look different.
    pub materials: Vec<MaterialEdit>,
    /// Materials that shine otherwise.
    pub emitters: Vec<LevelEdit>,
    /// Punctual lights that shine otherwise.
    pub lights: Vec<LevelEdit>,
}

/// A material that looks different.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialEdit {
    /// Its number in the file.
    pub index: usize,
    /// Its name in the file.
    pub name: String,
    /// Linear base colour.
    pub base_color: [Exact; 3],
    /// Perceptual roughness.
    pub roughness: Exact,
    /// 0 dielectric, 1 metal.
    pub metallic: Exact,
    /// Strength of the dielectric's reflection.
    pub specular: Exact,
    /// Share of light that passes.
    pub transmission: Exact,
    /// Index of refraction.
    pub ior: Exact,
    /// Radiance, W m⁻² sr⁻¹.
    pub emission: [Exact; 3],
    /// Linear colour of the dielectric's reflection; as in the file where there is none.
    #[serde(default)]
    pub specular_color: Option<[Exact; 3]>,
    /// Linear colour of light that has gone the volume's distance; as in the file where there is
    /// none.
    #[serde(default)]
    pub attenuation_color: Option<[Exact; 3]>,
}

/// A light that shines otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelEdit {
    /// Its number in the file.
    pub index: usize,
    /// Its name in the file.
    pub name: String,
    /// It shines.
    pub is_on: bool,
    /// Factor on what the file says.
    pub brightness: Exact,
    /// Linear colour × intensity of a punctual light, in the unit of its kind; as in the file
    /// where there is none. Emitters have theirs with their materials.
    #[serde(default)]
    pub strength: Option<[Exact; 3]>,
}

impl State {
    /// The files that it needs: the scene's, and that of an environment map.
    #[must_use]
    pub fn files(&self) -> Vec<String> {
        let scene = builtin(&self.scene).is_none().then(|| self.scene.clone());
        let sky = &self.environment.sky;
        let is_map =
            sky != EnvironmentState::OWN && matches!(SkyChoice::from_word(sky), SkyChoice::File(_));
        scene
            .into_iter()
            .chain(is_map.then(|| sky.clone()))
            .collect()
    }

    /// What determines a render, with the usual looks. `scene` is a built-in scene's name, or a
    /// path, which is made absolute.
    #[must_use]
    pub fn of_render(scene: &str, settings: &RenderSettings) -> Self {
        let method = settings.method;
        let parameters = method.parameters.iter().map(|parameter| {
            let value = settings.values.value(parameter.name);
            let value = value.unwrap_or_else(|| parameter.default_value());
            (parameter.name.to_owned(), parameter.format(value))
        });
        let region = settings.camera.crop.map(RegionState::from);
        Self {
            scene: match builtin(scene) {
                Some(_) => scene.to_owned(),
                None => absolute(Path::new(scene)),
            },
            camera: Some(CameraState::of(&settings.camera)),
            method: method.id.to_owned(),
            parameters: parameters.collect(),
            max_bounces: settings.max_bounces,
            layers: settings.n_layers,
            seed: settings.seed,
            size: Some(region.map_or([settings.width, settings.height], |region| region.of)),
            region,
            ..Self::default()
        }
    }
}

impl From<Crop> for RegionState {
    fn from(Crop { of, at, size }: Crop) -> Self {
        Self { of, at, size }
    }
}

impl From<RegionState> for Crop {
    fn from(RegionState { of, at, size }: RegionState) -> Self {
        Self { of, at, size }
    }
}

impl CameraState {
    /// A camera, to the bit; it orbits what it looks at.
    #[must_use]
    pub fn of(camera: &CameraDescription) -> Self {
        Self {
            of_file: 0,
            world_from_camera: Exact::all(camera.world_from_camera.to_cols_array()),
            aspect_ratio: camera.aspect_ratio.map(Exact),
            projection: match camera.projection {
                Projection::Perspective { yfov } => {
                    ProjectionState::Perspective { yfov: Exact(yfov) }
                }
                Projection::Orthographic { ymag } => {
                    ProjectionState::Orthographic { ymag: Exact(ymag) }
                }
            },
            lens: camera.lens.map(|lens| LensState {
                aperture: Exact(lens.aperture),
                focus_distance: Exact(lens.focus_distance),
            }),
            target: None,
            up: None,
        }
    }

    /// The camera, under a name.
    #[must_use]
    pub fn description(&self, name: String) -> CameraDescription {
        CameraDescription {
            name,
            world_from_camera: Mat4::from_cols_array(&Exact::values(self.world_from_camera)),
            aspect_ratio: self.aspect_ratio.map(|ratio| ratio.0),
            projection: match self.projection {
                ProjectionState::Perspective { yfov } => Projection::Perspective { yfov: yfov.0 },
                ProjectionState::Orthographic { ymag } => Projection::Orthographic { ymag: ymag.0 },
            },
            lens: self.lens.as_ref().map(|lens| Lens {
                aperture: lens.aperture.0,
                focus_distance: lens.focus_distance.0,
            }),
            crop: None,
        }
    }
}

impl Default for State {
    fn default() -> Self {
        Self {
            neumann: env!("CARGO_PKG_VERSION").to_owned(),
            scene: String::new(),
            camera: None,
            views: Vec::new(),
            method: DEFAULT_METHOD.to_owned(),
            parameters: BTreeMap::new(),
            max_bounces: 16,
            layers: DEFAULT_LAYERS,
            seed: 0,
            size: None,
            region: None,
            stop: Stop::Never,
            view: "picture".to_owned(),
            part: "L".to_owned(),
            exposure: ExposureState::default(),
            tone: "none".to_owned(),
            false_colour: FalseColourState::default(),
            magnified: None,
            environment: EnvironmentState::default(),
            backs: "solid".to_owned(),
            edits: Edits::default(),
            layers_beside: LayersState::default(),
            looked_at: LookedAt::default(),
        }
    }
}

impl Default for FalseColourState {
    fn default() -> Self {
        Self {
            is_on: false,
            colours: "viridis".to_owned(),
            stops: Exact(10.0),
        }
    }
}

impl Default for EnvironmentState {
    fn default() -> Self {
        Self {
            sky: Self::OWN.to_owned(),
            rotation: None,
            is_on: true,
            brightness: Exact(1.0),
            tint: Exact::all([1.0; 3]),
        }
    }
}

impl EnvironmentState {
    /// The word for the sky that the scene has by itself.
    pub const OWN: &'static str = "own";

    /// A sky in place of the scene's own, or that, as it comes but for its turn.
    #[must_use]
    pub fn of(sky: Option<&SkyChoice>, map: Option<&EnvironmentDescription>) -> Self {
        Self {
            sky: match sky {
                None => Self::OWN.to_owned(),
                Some(SkyChoice::None) => "none".to_owned(),
                Some(SkyChoice::Builtin(sky)) => sky.name().to_owned(),
                Some(SkyChoice::File(path)) => absolute(path),
            },
            rotation: map.map(|map| Exact(map.rotation)),
            ..Self::default()
        }
    }
}

/// A path that means the same from every folder.
fn absolute(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.display().to_string()
}
