//! What can be typed after `neumann lobe`.

use std::path::PathBuf;

use clap::Args;
use neumann_core::scene::Backs;

use crate::options::{CameraArguments, LoadArguments, backs, size, viewing_angle};

/// Arguments of `lobe`.
#[derive(Debug, Args)]
#[command(
    after_help = "The BSDF of a material from some viewing directions: values in the plane of the \
    viewer and over all directions, the density of BSDF sampling with the first directions that it \
    draws, and the albedo over the angle. Mirror-like lobes have no values; they are arrows as \
    long as the share of the light that they scatter.\n\n\
    --material takes the material by itself, its textures at (0, 0); --pixel the first surface \
    that the ray through the middle of the pixel meets, with its textures there.\n\n\
    Σ p is the density summed up over all directions, with the probabilities of mirror-like lobes \
    and of no direction at all: it has to be 1.\n\n\
    Examples:\n  \
    neumann lobe plates --material 2 -o plate.png --log\n  \
    neumann lobe cornell-glass --material glass --behind -o glass.png\n  \
    neumann lobe cornell --size 64x64 --pixel 32,60 --csv floor.csv"
)]
pub(crate) struct LobeArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Material of the scene, by name or number from 0
    #[arg(long, value_name = "NAME|INDEX", conflicts_with = "pixel")]
    pub(crate) material: Option<String>,
    /// Column and row of a pixel, from 0, that shows the surface; 0,0 is on the top left
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = crate::options::pixel,
        allow_hyphen_values = true
    )]
    pub(crate) pixel: Option<[u32; 2]>,
    /// Angles of the viewer to the normal, degrees; one to four
    #[arg(
        long,
        value_name = "DEG,…",
        value_delimiter = ',',
        value_parser = viewing_angle,
        default_value = "0,30,60,80",
        allow_hyphen_values = true
    )]
    pub(crate) angles: Vec<f32>,
    /// Look from behind the surface: from inside glass; a pixel decides by itself
    #[arg(long, conflicts_with = "pixel")]
    pub(crate) behind: bool,
    /// Plot f cos θ in place of f
    #[arg(long, requires = "output")]
    pub(crate) cosine: bool,
    /// Plot over the logarithm of values, four powers of ten
    #[arg(long, requires = "output")]
    pub(crate) log: bool,
    /// Sheet to write
    #[arg(short = 'o', long = "output", value_name = "FILE.png")]
    pub(crate) output: Option<PathBuf>,
    /// Curves to write, comma-separated
    #[arg(long, value_name = "FILE.csv")]
    pub(crate) csv: Option<PathBuf>,
    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Size of the picture that the pixel is of [default: the camera's shape, 512 on the longer
    /// edge]
    #[arg(
        long,
        value_name = "WxH",
        value_parser = size,
        requires = "pixel",
        allow_hyphen_values = true
    )]
    pub(crate) size: Option<(usize, usize)>,
    /// Backs of single-sided surfaces: solid, or see-through for the camera
    #[arg(
        long,
        value_name = "BACKS",
        default_value = Backs::Solid.name(),
        value_parser = backs(),
        requires = "pixel"
    )]
    pub(crate) backs: Backs,
    #[command(flatten)]
    pub(crate) camera: CameraArguments,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
}
