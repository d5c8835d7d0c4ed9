//! What can be typed after `neumann bias`.

use std::path::PathBuf;

use clap::Args;
use neumann_core::film::View;

use crate::options::{SettingsOptions, whole};

/// Arguments of `bias`.
#[derive(Debug, Args)]
#[command(
    after_help = "The method renders the scene several times at its radius and at half of it, with \
    the same photons for both. How the renders spread is the noise of one of them. A constant \
    kernel smooths light by an amount that goes with the square of the radius, so 4/3 of the \
    difference between both radii is the bias; what noise makes of its square is subtracted. \
    Within a radius of an edge of light or of a surface it is up to 1.6 times as large.\n\n\
    All numbers are shares of the mean of the term: root mean squares over the pixels, of one \
    render. The map has noise on the left and bias on the right, in colours of one scale. A \
    method takes parameters behind a colon: ppm:radius=0.01,alpha=0.6.\n\n\
    Examples:\n  \
    neumann bias cornell ppm --size 64x64 --iterations 4 -o bias.png\n  \
    neumann bias caustic pm:radius=0.02 --size 64x64 --iterations 1 --json",
    mut_arg("integrator", |a| a.hide(true)),
    mut_arg("set", |a| a.hide(true))
)]
pub(crate) struct BiasArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// A method with a radius: pm, ppm or vcm
    pub(crate) method: String,
    /// Iterations of a render
    #[arg(
        long,
        value_name = "N",
        default_value_t = 16,
        value_parser = whole(1..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) iterations: u32,
    /// Renders at each of the two radii
    #[arg(
        long,
        value_name = "M",
        default_value_t = 8,
        value_parser = whole(2..=4096),
        allow_hyphen_values = true
    )]
    pub(crate) renders: u32,
    /// The part of the series on the map: L, T0, T1, … or tail
    #[arg(
        long,
        value_name = "VIEW",
        default_value = "L",
        allow_hyphen_values = true
    )]
    pub(crate) view: View,
    /// The map: noise and bias side by side (.png)
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
