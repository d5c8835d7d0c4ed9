//! What can be typed after `neumann replay`.

use clap::Args;

use crate::options::{SettingsOptions, whole};

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(
    after_help = "One line for each contribution: its bounce, its technique (s vertices from the \
    light, t from the camera), its value, its MIS weight, and its path from the eye E to the light \
    L: D diffuse, G glossy, S specular, with t where light passes through; - a connection, = a \
    merge. Their sum is what the iteration has at the pixel.\n\n\
    Examples:\n  \
    neumann replay cornell --pixel 256,400\n  \
    neumann replay cornell-glass --size 64x64 --pixel 40,50 --integrator bdpt --iteration 7\n  \
    neumann replay lamps --size 64x64 --pixel 20,30 --integrator vcm --json"
)]
pub(crate) struct ReplayArguments {
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
    /// Number of the iteration
    #[arg(
        long,
        value_name = "N",
        default_value_t = 0,
        value_parser = whole(0..=u32::MAX - 1),
        allow_hyphen_values = true
    )]
    pub(crate) iteration: u32,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    /// Print everything that is known of each path as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
