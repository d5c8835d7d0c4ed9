//! What can be typed after `neumann hemisphere`.

use std::path::PathBuf;

use clap::Args;

use crate::options::{DisplayOptions, SettingsOptions, whole};

/// Arguments of `hemisphere`.
#[derive(Debug, Args)]
#[command(
    after_help = "L_o = L_e + ∫ L_i f cos θ dω at the first surface that the ray through the \
    middle of the pixel meets. The integral is estimated by directions drawn from the BSDF, by \
    aiming at lights, and by both with MIS weights; it is the sum over the pictures too, and the \
    radiance of the pixel along that ray less L_e, which the integrator renders for comparison. \
    Intervals hold the truth 95 times of 100.\n\n\
    The sheet has incident radiance, BSDF, cosine and their product over the hemisphere, the \
    viewer below, and where light passes through the surface a second disk with the directions \
    behind it; the densities with the first samples; and how the estimators come together.\n\n\
    Examples:\n  \
    neumann hemisphere cornell --pixel 256,400 -o point.png\n  \
    neumann hemisphere plates --size 256x192 --pixel 100,112 --samples 16 -o plate.png\n  \
    neumann hemisphere sky --size 128x96 --pixel 64,80 --samples 16 --json"
)]
pub(crate) struct HemisphereArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Column and row of the pixel, from 0; 0,0 is on the top left
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = crate::options::pixel,
        allow_hyphen_values = true
    )]
    pub(crate) pixel: [u32; 2],
    /// Directions for each pixel of the pictures; each estimator has 512 times as many paths
    #[arg(
        long,
        value_name = "N",
        default_value_t = 64,
        value_parser = whole(1..=65_536),
        allow_hyphen_values = true
    )]
    pub(crate) samples: u32,
    /// Sheet to write
    #[arg(short = 'o', long = "output", value_name = "FILE.png")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// Print the figures, and how they came about, as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
