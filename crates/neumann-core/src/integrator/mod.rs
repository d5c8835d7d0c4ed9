//! How we guess the sum: the contract of an integrator, and the registry.
//!
//! To add one: write a file here with its `METHOD` row, add a `mod` line and
//! an entry to [`METHODS`]. Menus, command line and tests follow.

pub mod bdpt;
pub mod bidirectional;
mod distributed;
mod lanes;
pub mod light_tracing;
mod parameter;
pub mod path_tracing;
pub mod photon_mapping;
mod radius;
mod shade;
pub mod vcm;

pub use parameter::{
    Parameter, ParameterError, ParameterKind, ParameterValues, Value, parameter_name,
};
pub use radius::Radius;

use std::sync::Arc;

use glam::Vec2;

use crate::endpoint::Camera;
use crate::math::Ray;
use crate::pass::{Cancelled, Pass, PixelSink, Pixels};
use crate::photons::PhotonMap;
use crate::sampling::Sampler;
use crate::scene::Scene;
use crate::transport::Tracer;

/// A method as it renders; the two kinds differ in where their paths add.
pub enum Integrator {
    /// Each path adds to the pixel that it starts from, and to no other: the value of a pixel is
    /// known as soon as its paths have been traced.
    Pixels(Box<dyn PixelIntegrator>),
    /// Passes over the picture, from camera or lights, in whatever order.
    Passes(Box<dyn PassIntegrator>),
}

/// A path as it sets out from its pixel.
#[derive(Clone, Copy, Debug)]
pub struct PathStart<'a> {
    /// Its first ray, from the lens.
    pub ray: Ray,
    /// Its random numbers, the first of which have chosen the ray.
    pub sampler: &'a Sampler<'a>,
    /// Terms with `k` up to and including this one are wanted.
    pub max_bounces: u32,
    camera: &'a Camera,
    raster: Vec2,
}

impl PathStart<'_> {
    /// Another first ray through the same point of the pixel, from the point of the lens that `u`
    /// in [0, 1)² chooses.
    #[must_use]
    pub fn ray_through(&self, u: [f32; 2]) -> Ray {
        self.camera.ray(self.raster, u).ray
    }
}

/// A method whose paths add to the pixel that they start from, and walk each by itself.
pub trait PathIntegrator: Send + Sync {
    /// Traces a path, and hands what it brings to its pixel to the sink.
    ///
    /// A camera ray that meets nothing must bring the radiance from there, with weight 1: where
    /// that is the same from everywhere, and nothing stands before it, no path is traced.
    fn trace_path(&self, path: &PathStart<'_>, tracer: &mut Tracer<'_>, sink: &mut PixelSink<'_>);
}

/// What the paths of pixels go through.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera.
    pub camera: &'a Camera,
    /// Terms with `k` up to and including this one are wanted.
    pub max_bounces: u32,
}

/// A method whose paths add to the pixel that they start from, and which takes the paths of many
/// pixels at once. Every [`PathIntegrator`] is one, which takes them one by one.
pub trait PixelIntegrator: Send + Sync {
    /// Traces the paths of some pixels, in whatever order; tells the sink which pixel a
    /// contribution belongs to ([`PixelSink::start_pixel`]).
    ///
    /// A camera ray that meets nothing must bring the radiance from there, with weight 1: where
    /// that is the same from everywhere, and nothing stands before it, no path is traced.
    fn trace(
        &self,
        shot: &Shot<'_>,
        pixels: Pixels<'_>,
        tracer: &mut Tracer<'_>,
        sink: &mut PixelSink<'_>,
    );

    /// Paths that one may split into at most ([`PixelPath::splits`](crate::pass::PixelPath)).
    fn n_splits(&self, _scene: &Scene) -> u8 {
        1
    }

    /// True if more paths are to go where the picture is noisy.
    fn is_adaptive(&self) -> bool {
        false
    }
}

impl<T: PathIntegrator> PixelIntegrator for T {
    fn trace(
        &self,
        shot: &Shot<'_>,
        pixels: Pixels<'_>,
        tracer: &mut Tracer<'_>,
        sink: &mut PixelSink<'_>,
    ) {
        let camera = shot.camera;
        pixels.one_by_one(sink, |sample, sampler, sink| {
            let path = PathStart {
                ray: camera.ray(sample.raster, sampler.start().lens).ray,
                sampler,
                max_bounces: shot.max_bounces,
                camera,
                raster: sample.raster,
            };
            self.trace_path(&path, tracer, sink);
        });
    }
}

/// A method that makes passes over the picture.
pub trait PassIntegrator: Send {
    /// Adds one complete estimate of the image, or stops early when cancelled.
    ///
    /// # Errors
    /// [`Cancelled`] when the pass was told to stop.
    fn iterate(&mut self, scene: &Scene, pass: &mut Pass<'_>) -> Result<(), Cancelled>;

    /// The photons that the iteration of `pass` reads its light from: those that are kept, or the
    /// same ones traced again, so that nothing need be kept for whoever may want to look at them.
    /// Nothing is added to the frame. `None` if the method has none.
    ///
    /// # Errors
    /// [`Cancelled`] when the pass was told to stop.
    fn photons(
        &mut self,
        _scene: &Scene,
        _pass: &mut Pass<'_>,
    ) -> Result<Option<Arc<PhotonMap>>, Cancelled> {
        Ok(None)
    }

    /// True if the error of the mean shows in how iterations differ. It does not where they have
    /// random numbers in common.
    fn shows_its_error(&self) -> bool {
        true
    }
}

impl Integrator {
    /// [`PassIntegrator::shows_its_error`]; always true of paths of pixels.
    #[must_use]
    pub fn shows_its_error(&self) -> bool {
        match self {
            Self::Pixels(_) => true,
            Self::Passes(passes) => passes.shows_its_error(),
        }
    }

    /// True if each path adds to the pixel that it starts from.
    #[must_use]
    pub fn adds_to_own_pixels(&self) -> bool {
        matches!(self, Self::Pixels(_))
    }
}

/// One row of the registry: everything that menus, command line, README and tests need to know.
pub struct Method {
    /// Name on the command line.
    pub id: &'static str,
    /// Name in a menu, short.
    pub title: &'static str,
    /// Full name, as a heading.
    pub name: &'static str,
    /// What it is, a sentence or two.
    pub about: &'static str,
    /// What it cannot see, one sentence; empty if it sees everything.
    pub blind_spots: &'static str,
    /// Its estimator; `_` is before an index, `^` before an exponent, of several characters in
    /// braces.
    pub formula: &'static str,
    /// What it does, line by line, with the same signs.
    pub pseudo_code: &'static str,
    /// The same as [`Self::blind_spots`] as facts that tests rely on.
    pub sight: Sight,
    /// Why its expectation differs from L; `None` for an unbiased method.
    pub bias: Option<&'static str>,
    /// Whether its paths are made by several techniques (s, t), which a
    /// [`TechniqueFilm`](crate::film::TechniqueFilm) keeps apart.
    pub has_techniques: bool,
    /// Whether it reads light from photons, which can be looked at
    /// ([`PassIntegrator::photons`]).
    pub has_photons: bool,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes an integrator with the given parameter values.
    pub build: fn(&ParameterValues) -> Integrator,
}

/// The signs of [`Method::formula`] and [`Method::pseudo_code`].
pub const NOTATION: &str = "\
L radiance, L_e emitted; f BSDF; θ angle between ω and the normal; p density; w MIS weight;
I value of a pixel, W_e its importance; V 1 where nothing is between, G cos θ cos θ' / distance²;
β throughput from the lens, Φ power of a path from a light; N such paths; r radius, K kernel.";

/// What a method can see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sight {
    /// Light from point, spot and directional lights.
    pub punctual_lights: bool,
    /// Light by way of mirrors and smooth glass.
    pub delta_surfaces: bool,
    /// Mirrors and smooth glass that the camera sees directly.
    pub delta_to_camera: bool,
    /// On diffuse surfaces alone, the highest bounce that it computes; `None` for no limit.
    pub diffuse_bounces: Option<u32>,
    /// Shadows.
    pub shadows: bool,
}

impl Sight {
    /// Everything.
    pub const FULL: Self = Self {
        punctual_lights: true,
        delta_surfaces: true,
        delta_to_camera: true,
        diffuse_bounces: None,
        shadows: true,
    };
}

impl std::fmt::Debug for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Method").field(&self.id).finish()
    }
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

/// All methods, in lecture order.
pub static METHODS: &[&Method] = &[
    &path_tracing::naive::METHOD,
    &path_tracing::bsdf::METHOD,
    &path_tracing::nee::METHOD,
    &path_tracing::mis::METHOD,
    &distributed::METHOD,
    &shade::METHOD,
    &light_tracing::METHOD,
    &bdpt::METHOD,
    &photon_mapping::METHOD,
    &photon_mapping::PROGRESSIVE,
    &vcm::METHOD,
];

/// The method where nothing else is asked for.
pub const DEFAULT_METHOD: &str = "pt-mis";

/// The method with the given id.
#[must_use]
pub fn method(id: &str) -> Option<&'static Method> {
    METHODS.iter().copied().find(|m| m.id == id)
}

/// The ids of the methods that have photons, as a sentence names them: "pm or ppm".
#[must_use]
pub fn methods_with_photons() -> String {
    let with_photons = METHODS.iter().filter(|method| method.has_photons);
    let ids: Vec<&str> = with_photons.map(|method| method.id).collect();
    ids.join(" or ")
}
