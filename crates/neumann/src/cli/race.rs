//! What can be typed after `neumann race`.

use std::path::PathBuf;

use clap::Args;

use crate::options::{DisplayOptions, SettingsOptions};

/// Arguments of `race`.
#[derive(Debug, Args)]
#[command(
    after_help = "A method takes parameters behind a colon: pt-mis:roulette=off,casters=off. Each \
    in turn has all threads; what counts is their processor time while it renders. The \
    reference is rendered by bdpt for four times as long, and kept beside the sheet.\n\n\
    Examples:\n  \
    neumann race cornell pt-nee pt-mis bdpt --time 10 -o race.png\n  \
    neumann race plates pt-bsdf pt-nee pt-mis --size 384x256 --time 5 -o v.png --csv v.csv\n  \
    neumann race lamps pt-mis bdpt --time 10 -o race.png --svg curves.svg",
    mut_arg("integrator", |a| a.hide(true)),
    mut_arg("set", |a| a.hide(true))
)]
pub(crate) struct RaceArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Two to four methods ('neumann list integrators')
    #[arg(num_args = 2..=4, required = true, value_name = "METHOD")]
    pub(crate) methods: Vec<String>,
    /// Processor time of each method, seconds
    #[arg(
        long,
        value_name = "S",
        default_value_t = 10.0,
        value_parser = crate::options::positive,
        allow_hyphen_values = true
    )]
    pub(crate) time: f64,
    /// The sheet: all pictures in a row, with their errors and curves (.png)
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Errors over time: a line for each time at which they were measured
    #[arg(long, value_name = "FILE")]
    pub(crate) csv: Option<PathBuf>,
    /// The curves as a vector figure, for print (.svg)
    #[arg(long, value_name = "FILE")]
    pub(crate) svg: Option<PathBuf>,
    /// Compare with this picture (.exr, .png or .hdr)
    #[arg(long, value_name = "FILE")]
    pub(crate) reference: Option<PathBuf>,
    /// Write what each method rendered to this folder, all layers (.exr)
    #[arg(long, value_name = "DIR")]
    pub(crate) pictures: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// Print one JSON array, with the errors over time
    #[arg(long)]
    pub(crate) json: bool,
}
