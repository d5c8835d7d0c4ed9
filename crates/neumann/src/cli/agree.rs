//! What can be typed after `neumann agree`.

use std::path::PathBuf;

use clap::Args;

use neumann_picture::agreement::FEWEST;

use crate::options::{SettingsOptions, whole};

/// Arguments of `agree`.
#[derive(Debug, Args)]
#[command(
    after_help = "The methods render batches in turn, each with a seed of its own. In the whole \
    picture, \
    its quarters, their quarters and so on, the means of the batches are held against each \
    other for each bounce and channel by Welch's test. A score is their difference in \
    standard deviations; the limit is that which any of all scores passes by chance with the \
    probability --level. A method takes parameters behind a colon: pt-mis:roulette=off. A \
    method may stand against itself.\n\n\
    On the map noise is grey; orange is where the first method is brighter, blue where it is \
    darker. Biased methods disagree with good reason, which is printed.\n\n\
    Exit code 0: they agree. 1: they disagree.\n\n\
    Examples:\n  \
    neumann agree cornell pt-mis bdpt --size 64x64 --iterations 2 -o map.png\n  \
    neumann agree cornell pt-mis pt-mis:roulette=off --size 64x64 --iterations 2 --json",
    mut_arg("integrator", |a| a.hide(true)),
    mut_arg("set", |a| a.hide(true))
)]
pub(crate) struct AgreeArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Two methods ('neumann list integrators')
    #[arg(num_args = 2, required = true, value_name = "METHOD")]
    pub(crate) methods: Vec<String>,
    /// Processor time of each method, seconds
    #[arg(
        long,
        value_name = "S",
        default_value_t = 20.0,
        value_parser = crate::options::positive,
        allow_hyphen_values = true
    )]
    pub(crate) time: f64,
    /// Iterations of each batch, instead of a time
    #[arg(
        long,
        value_name = "N",
        conflicts_with = "time",
        value_parser = whole(1..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) iterations: Option<u32>,
    /// Batches of each method
    #[arg(
        long,
        value_name = "B",
        default_value_t = 32,
        value_parser = whole(FEWEST as u32..=4096),
        allow_hyphen_values = true
    )]
    pub(crate) batches: u32,
    /// Probability of a false alarm, of the whole comparison
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.01,
        value_parser = crate::options::probability,
        allow_hyphen_values = true
    )]
    pub(crate) level: f64,
    /// The map: a tile for each bounce, for the tail and for L (.png)
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
