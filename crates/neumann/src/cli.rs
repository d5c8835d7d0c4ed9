//! What can be typed.

mod agree;
mod bias;
mod hemisphere;
mod inspect;
mod lobe;
mod race;
mod replay;

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use neumann_core::film::View;
use neumann_picture::photons::PhotonColours;
use neumann_picture::quantity::Quantity;
use neumann_picture::tev::DEFAULT_ADDRESS;

use crate::options::{
    ClassOptions, DisplayOptions, GoalOptions, LoadArguments, SettingsOptions, address,
    photon_colours, positive, region, size, whole,
};

pub(crate) use agree::AgreeArguments;
pub(crate) use bias::BiasArguments;
pub(crate) use hemisphere::HemisphereArguments;
pub(crate) use inspect::InspectArguments;
pub(crate) use lobe::LobeArguments;
pub(crate) use race::RaceArguments;
pub(crate) use replay::ReplayArguments;

/// The whole command line.
#[derive(Debug, Parser)]
#[command(
    name = "neumann",
    version,
    about = "Shows light transport bounce by bounce: L = L_e + T L_e + T²L_e + …",
    after_help = "Without a subcommand the window opens with SCENE, or with the embedded Cornell \
        box. Where there is no display or graphics adapter, the scene and its series are rendered \
        to ./neumann-out instead.\n\n\
        Examples:\n  \
        neumann\n  \
        neumann cornell-glass\n  \
        neumann render room.gltf -o room.exr -o room.png --time 60\n  \
        neumann series cornell -o out\n  \
        neumann compare room.exr reference.exr\n\n\
        Exit codes: 0 done, 1 failed while working, or methods disagree, 2 wrong usage or bad \
        input.",
    args_conflicts_with_subcommands = true,
    max_term_width = 110
)]
pub(crate) struct Cli {
    /// A .gltf or .glb file, or the name of a built-in scene ('neumann list scenes')
    pub(crate) scene: Option<String>,
    /// Memory that files may take once read, such as 800M or 4G [default: half of what is free]
    #[arg(
        long,
        global = true,
        value_name = "BYTES",
        value_parser = crate::options::bytes,
        allow_hyphen_values = true
    )]
    pub(crate) memory: Option<u64>,
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Open the window, or draw it to a file
    View(ViewArguments),
    /// Render a scene to EXR and PNG files
    Render(RenderArguments),
    /// Render the terms of the series and its partial sums, and lay them out on a sheet
    Series(SeriesArguments),
    /// Let methods render for equal processor time, and compare them with a reference
    Race(RaceArguments),
    /// Say whether two methods make the same picture, bounce by bounce
    Agree(AgreeArguments),
    /// Split the error of a method with a radius into noise and the bias of the radius
    Bias(BiasArguments),
    /// Say by which paths light has come to a pixel in one iteration
    Replay(ReplayArguments),
    /// Ask why a pixel is as bright as it is: values, techniques, distribution, ways, paths
    Inspect(InspectArguments),
    /// Show the reflection equation at the surface point that a pixel shows
    Hemisphere(HemisphereArguments),
    /// Show the BSDF of a material: polar plots, lobes, sampled directions, albedo, reciprocity
    Lobe(LobeArguments),
    /// Measure how far two pictures are apart: RMSE, relMSE, FLIP, mean ratio
    Compare(CompareArguments),
    /// List built-in scenes, integrators or their parameters
    List(ListArguments),
    /// Explain how a method works: its formula, its pseudo-code
    Explain(ExplainArguments),
    /// Say what a scene consists of
    Info(InfoArguments),
    /// Join renders of one scene with different iterations into one
    Merge(MergeArguments),
    /// Print completions for a shell
    Completions(CompletionsArguments),
}

/// Arguments of `view` that a state stands for.
const IN_STATE: [&str; 20] = [
    "scene",
    "integrator",
    "set",
    "max_bounces",
    "layers",
    "seed",
    "backs",
    "camera",
    "eye",
    "target",
    "up",
    "fov",
    "aperture",
    "focus",
    "env",
    "env_intensity",
    "env_rotation",
    "view",
    "exposure",
    "tone",
];

/// Arguments of `view`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    neumann view cornell --view T2\n  \
    neumann view cornell --view depth --screenshot depth.png\n  \
    neumann view room.glb --integrator pt-nee --exposure 1.5 --tone agx\n  \
    neumann view --state shot.json\n  \
    neumann view cornell --screenshot window.png --after 64 --window-size 1280x720")]
pub(crate) struct ViewArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    #[arg(required_unless_present = "state")]
    pub(crate) scene: Option<String>,
    /// Show what was seen when a state was saved (Ctrl Shift S in the window): its scene, camera,
    /// method, view, exposure, environment and edits; or that of an .exr saved in the window. With
    /// `-` the state is read from standard input, as Ctrl Shift C in the window copies it
    #[arg(long, value_name = "FILE", conflicts_with_all = IN_STATE)]
    pub(crate) state: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// What is shown: L, T0, T1, …, tail, or upto:K for a partial sum; or albedo, normal, depth,
    /// error or samples
    #[arg(long, default_value = "L", value_name = "VIEW")]
    pub(crate) view: Looked,
    /// Stop after so many iterations
    #[arg(long, value_name = "N", value_parser = whole(1..=u32::MAX), allow_hyphen_values = true)]
    pub(crate) iterations: Option<u32>,
    /// Stop after so much time of rendering
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    pub(crate) time: Option<f64>,
    /// Draw the window to a PNG file instead of opening it; needs no display
    #[arg(long, value_name = "FILE.png")]
    pub(crate) screenshot: Option<PathBuf>,
    /// Iterations at full resolution to wait for before the screenshot
    #[arg(
        long,
        value_name = "ITERATIONS",
        default_value_t = 16,
        requires = "screenshot",
        value_parser = whole(0..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) after: u32,
    /// Size of the window on the screenshot
    #[arg(
        long,
        value_name = "WxH",
        default_value = "1280x720",
        value_parser = size,
        requires = "screenshot",
        allow_hyphen_values = true
    )]
    pub(crate) window_size: (usize, usize),
    /// Use the light theme on the screenshot
    #[arg(long, requires = "screenshot")]
    pub(crate) light_theme: bool,
}

/// What `--view` shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Looked {
    /// A part of the series.
    Part(View),
    /// What a pixel holds beside radiance.
    Quantity(Quantity),
}

impl FromStr for Looked {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let quantity = text.parse().map(Self::Quantity);
        let part = || text.parse().map(Self::Part);
        quantity.or_else(|_| part()).map_err(|_| {
            let names = Quantity::ALL.map(Quantity::name).join(", ");
            format!("'{text}' is not a view; use L, T0, T1, …, tail, upto:K, or one of {names}")
        })
    }
}

#[cfg(feature = "window")]
impl Looked {
    pub(crate) fn part(self) -> View {
        match self {
            Self::Part(part) => part,
            Self::Quantity(_) => View::Total,
        }
    }

    pub(crate) fn quantity(self) -> Option<Quantity> {
        match self {
            Self::Part(_) => None,
            Self::Quantity(quantity) => Some(quantity),
        }
    }
}

/// Arguments of `render`.
#[derive(Debug, Args)]
#[command(
    after_help = "Rendering ends at the first of --iterations, --time and --until-error that is \
    met; 64 iterations if none is given. Ctrl-C ends it early: whole iterations so far are \
    written, and the exit code is 1.\n\
    The .exr is also saved while rendering (--checkpoint). With --resume the goals count what is \
    in the file already, so the same command line finishes what was interrupted.\n\n\
    Examples:\n  \
    neumann render cornell -o c.exr -o c.png --iterations 256\n  \
    neumann render room.gltf -o nee.exr --integrator pt-nee --size 1280x720 --until-error 0.01\n  \
    neumann render room.gltf -o room.exr --iterations 4096 --resume\n  \
    neumann render lamps -o l.exr --integrator bdpt --techniques pyramid\n  \
    neumann render caustic -o c.exr --integrator bdpt --expression caustics --lights each\n  \
    neumann render cornell-glass --integrator pm --photons photons.png\n  \
    neumann render cornell -o c.exr --time 60 --tev\n  \
    neumann render room.gltf -o part.exr --size 1280x720 --region 400,200,320,200\n  \
    neumann render room.gltf -o part2.exr --first-iteration 1024 --iterations 1024 --threads 8\n  \
    neumann render cornell -o shard3.exr --iterations 4096 --shard 3/8\n  \
    neumann render room.gltf -o room.png --env sun --env-rotation 90 --exposure auto\n  \
    neumann render cornell -o c.exr --eye 0,1,4 --target 0,1,0 --fov 35 --set roulette=off --json"
)]
pub(crate) struct RenderArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// File to write, .exr (all layers) or .png (L as shown); may be given several times
    #[arg(
        short = 'o',
        long = "output",
        value_name = "FILE",
        required_unless_present_any = ["photons", "tev"]
    )]
    pub(crate) outputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    /// Render only a part of the picture of --size, and write that: column and row of its upper
    /// left corner, columns and rows
    #[arg(long, value_name = "X,Y,W,H", value_parser = region, allow_hyphen_values = true)]
    pub(crate) region: Option<[usize; 4]>,
    #[command(flatten)]
    pub(crate) goal: GoalOptions,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// Go on from the .exr file if it is there and was rendered with the same settings
    #[arg(long)]
    pub(crate) resume: bool,
    /// Write half floats: smaller, but not to be resumed from
    #[arg(long, conflicts_with = "resume")]
    pub(crate) half: bool,
    /// Keep the (s,t) techniques of this run apart: techniques.exr and the sheet techniques.png in
    /// this folder
    #[arg(long, value_name = "DIR")]
    pub(crate) techniques: Option<PathBuf>,
    /// Make the images of techniques so many times smaller each way
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4,
        requires = "techniques",
        value_parser = whole(1..=u32::MAX),
        allow_hyphen_values = true
    )]
    pub(crate) techniques_divisor: u32,
    #[command(flatten)]
    pub(crate) classes: ClassOptions,
    /// Draw the photons of the last iteration as points, with a legend (pm, ppm). Without -o and a
    /// goal, one iteration is rendered
    #[arg(long, value_name = "FILE.png")]
    pub(crate) photons: Option<PathBuf>,
    /// Colour photons by their bounce (how often they were scattered), or by their power
    #[arg(
        long,
        value_name = "WHAT",
        default_value = PhotonColours::Bounce.name(),
        requires = "photons",
        value_parser = photon_colours()
    )]
    pub(crate) photons_by: PhotonColours,
    /// Show the picture and its layers in tev, which listens there, while they are rendered and at
    /// the end
    #[arg(
        long,
        value_name = "HOST:PORT",
        num_args = 0..=1,
        default_missing_value = DEFAULT_ADDRESS,
        value_parser = address
    )]
    pub(crate) tev: Option<String>,
    /// End with one JSON object on stdout
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `series`.
#[derive(Debug, Args)]
#[command(
    after_help = "Writes T0, T1, …, tail, upto0, upto1, … and L, each as PNG and EXR, and \
    sheet.png. L.exr holds all layers: --resume goes on from it. With --expression and --lights, \
    also expression-NAME and light-NAME.\n\n\
    Examples:\n  \
    neumann series cornell -o out\n  \
    neumann series room.gltf -o out --layers 4 --iterations 512 --exposure 1 --tone agx"
)]
pub(crate) struct SeriesArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    /// Folder to write to; made if it is not there
    #[arg(short = 'o', long = "output", value_name = "DIR")]
    pub(crate) folder: PathBuf,
    #[command(flatten)]
    pub(crate) settings: SettingsOptions,
    #[command(flatten)]
    pub(crate) goal: GoalOptions,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// Go on from DIR/L.exr if it is there and was rendered with the same settings
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) classes: ClassOptions,
    /// End with one JSON object on stdout
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(
    after_help = "relMSE is mean((a-b)² / (b² + 0.01)) over pixels and channels, b the \
    reference. FLIP compares what is shown after exposure and tone curve, at 67 pixels per \
    degree.\n\n\
    Examples:\n  \
    neumann compare mine.exr reference.exr\n  \
    neumann compare pt-nee.exr pt-mis.exr --layer T1 -o difference.png --json"
)]
pub(crate) struct CompareArguments {
    /// The picture: .exr, .png or .hdr
    pub(crate) image: PathBuf,
    /// The reference: .exr, .png or .hdr
    pub(crate) reference: PathBuf,
    /// Compare a layer of both (T0, T1, …, tail, albedo, …) instead of L
    #[arg(long, value_name = "LAYER")]
    pub(crate) layer: Option<String>,
    /// Picture of the difference: .png orange where brighter, blue where darker; .exr the signed
    /// difference
    #[arg(short = 'o', long = "output", value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// What can be listed.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(crate) enum Listing {
    /// The scenes that come with the program
    Scenes,
    /// The methods of rendering
    Integrators,
    /// The parameters of the methods, for --set
    Parameters,
    /// Light path expressions that have names, for --expression and --only
    Expressions,
}

/// Arguments of `list`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  neumann list scenes\n  neumann list integrators --json")]
pub(crate) struct ListArguments {
    /// What to list
    pub(crate) what: Listing,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `explain`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  neumann explain pt-mis\n  neumann explain --json")]
pub(crate) struct ExplainArguments {
    /// Which method ('neumann list integrators'); all, if none is named
    #[arg(value_parser = crate::options::integrators(), hide_possible_values = true)]
    pub(crate) integrator: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `info`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  neumann info cornell\n  neumann info room.gltf --json")]
pub(crate) struct InfoArguments {
    /// A .gltf or .glb file, or the name of a built-in scene
    pub(crate) scene: String,
    #[command(flatten)]
    pub(crate) load: LoadArguments,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments of `merge`.
#[derive(Debug, Args)]
#[command(
    after_help = "The renders must be of the same scene with the same settings and seed, and have \
    no iteration in common. The result equals one render of all iterations but for rounding, a few \
    millionths.\n\n\
    Examples:\n  \
    neumann render cornell -o a.exr --iterations 64\n  \
    neumann render cornell -o b.exr --iterations 64 --first-iteration 64\n  \
    neumann merge a.exr b.exr -o both.exr"
)]
pub(crate) struct MergeArguments {
    /// Films that 'neumann render' wrote
    #[arg(required = true, num_args = 2.., value_name = "FILE.exr")]
    pub(crate) inputs: Vec<PathBuf>,
    /// File to write, .exr or .png; may be given several times
    #[arg(short = 'o', long = "output", value_name = "FILE", required = true)]
    pub(crate) outputs: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) display: DisplayOptions,
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    neumann completions bash > ~/.local/share/bash-completion/completions/neumann\n  \
    neumann completions fish > ~/.config/fish/completions/neumann.fish")]
pub(crate) struct CompletionsArguments {
    /// The shell
    pub(crate) shell: Shell,
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::{Cli, Command};
    use crate::options::Exposure;

    #[test]
    fn the_description_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_subcommand_has_examples() {
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string);
            let help = help.unwrap_or_default();
            let (_, examples) = help.split_once("Examples:\n").unwrap();
            for line in examples.lines() {
                let words = line.split(" >").next().unwrap().split_whitespace();
                let read = Cli::try_parse_from(words);
                assert!(read.is_ok(), "{line}: {}", read.unwrap_err());
            }
        }
    }

    #[test]
    fn options_read_as_the_design_writes_them() {
        let line = "neumann render cornell -o a.exr -o a.png --integrator pt-nee --iterations 8 \
            --first-iteration 4 --shard 1/2 --checkpoint 30 --size 64x48 --camera 0 --eye -1,2,3.5 \
            --target 0,0,0 --up 0,1,0 --fov 40 --aperture 0.1 --focus 3 --max-bounces 5 --layers 4 \
            --seed 7 --threads 2 --set a=1 --set b=on --exposure -1.5 --tone agx --resume \
            --allow-outside --env sky.hdr --env-intensity 2 --env-rotation -90 --json";
        let cli = Cli::try_parse_from(line.split_whitespace()).unwrap();
        let Some(Command::Render(render)) = cli.command else {
            panic!("{cli:?}");
        };
        assert_eq!(render.outputs.len(), 2);
        assert_eq!(render.settings.size, Some((64, 48)));
        assert_eq!(
            render.settings.camera.eye,
            Some(glam::Vec3::new(-1.0, 2.0, 3.5))
        );
        assert_eq!(render.settings.set[1], ("b".to_owned(), "on".to_owned()));
        assert_eq!(render.display.exposure, Some(Exposure::Stops(-1.5)));
        let cli = Cli::try_parse_from(["neumann", "cornell"]).unwrap();
        assert_eq!(cli.scene.as_deref(), Some("cornell"));
        assert!(Cli::try_parse_from(["neumann"]).unwrap().command.is_none());
    }

    #[test]
    fn nonsense_is_refused() {
        for line in [
            "render cornell",
            "render cornell -o a.exr --size 64",
            "render cornell -o a.exr --size 0x4",
            "render cornell -o a.exr --iterations 0",
            "render cornell -o a.exr --time -3",
            "render cornell -o a.exr --time=-1",
            "render cornell -o a.exr --time nan",
            "render cornell -o a.exr --until-error inf",
            "render cornell -o a.exr --iterations 4294967296",
            "render cornell -o a.exr --iterations -1",
            "render cornell -o a.exr --first-iteration -1",
            "render cornell -o a.exr --seed -1",
            "render cornell -o a.exr --exposure 1e30",
            "render cornell -o a.exr --shard 0/4",
            "render cornell -o a.exr --checkpoint -1",
            "render cornell -o a.exr --eye 1,2",
            "render cornell -o a.exr --fov 190",
            "render cornell -o a.exr --integrator magic",
            "render cornell -o a.exr --tone loud",
            "render cornell -o a.exr --set roulette",
            "merge a.exr -o b.exr",
            "list colours",
            "view cornell --view T",
        ] {
            let words = std::iter::once("neumann").chain(line.split_whitespace());
            assert!(Cli::try_parse_from(words).is_err(), "{line}");
        }
    }
}
