//! What can be typed after `neumann inspect`.

use clap::Args;

use crate::options::{SettingsOptions, whole};

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(
    after_help = "Says in a sentence where the light of a pixel comes from, then its value for \
    each bounce and each technique with an interval that holds the truth 95 times of 100, how much \
    single iterations bring, by which ways light comes, and the paths that bring most.\n\n\
    A light path expression (--only) picks ways and paths: L is the light and E the eye; D, G and \
    S are diffuse, glossy and specular bounces (Dr, Dt: reflected, transmitted only), R and T any \
    reflection or transmission, . any bounce, 'name' one at a material; * + ? {2,5} say how \
    often, [DG], [^S], | and ( ) what else may be.\n\n\
    Examples:\n  \
    neumann inspect cornell --pixel 256,400\n  \
    neumann inspect cornell-glass --pixel 200,420 --integrator bdpt --only LS+DE\n  \
    neumann inspect pool --size 96x96 --pixel 40,60 --integrator vcm --bounce 3 --json\n  \
    neumann inspect pool --size 96x96 --fireflies 5"
)]
pub(crate) struct InspectArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Column and row of the pixel, from 0; 0,0 is on the top left
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = crate::options::pixel,
        allow_hyphen_values = true,
        required_unless_present = "fireflies"
    )]
    pub(crate) pixel: Option<[u32; 2]>,
    /// Find the N pixels that stand out most and say which paths have made them
    #[arg(
        long,
        value_name = "N",
        value_parser = whole(1..=256),
        allow_hyphen_values = true,
        conflicts_with_all = ["pixel", "bounce", "technique", "only", "list"]
    )]
    pub(crate) fireflies: Option<u32>,
    /// Iterations to look at, from number 0 on
    #[arg(
        long,
        value_name = "N",
        default_value_t = 64,
        value_parser = whole(1..=1_000_000),
        allow_hyphen_values = true
    )]
    pub(crate) iterations: u32,
    /// List only ways and paths of this bounce
    #[arg(
        long,
        value_name = "K",
        value_parser = whole(0..=u32::MAX - 1),
        allow_hyphen_values = true
    )]
    pub(crate) bounce: Option<u32>,
    /// List only paths of this technique
    #[arg(long, value_name = "S,T", value_parser = crate::options::technique)]
    pub(crate) technique: Option<[u16; 2]>,
    /// List only ways and paths of this kind: a light path expression
    #[arg(long, value_name = "EXPRESSION")]
    pub(crate) only: Option<String>,
    /// List so many ways and so many paths, at most
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        value_parser = whole(0..=1024),
        allow_hyphen_values = true
    )]
    pub(crate) list: u32,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    /// Print everything that is known as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
