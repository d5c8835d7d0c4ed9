//! The command `neumann`: a thin door.
//!
//! [`cli`] says what can be typed; each subcommand has a file of its own;
//! [`options`] turns what was typed into a scene and settings; [`session`] renders;
//! [`outputs`] writes. Results go to stdout, everything else to stderr.
//! Exit code 0: done. 1: failed while working, or methods that disagree. 2: wrong usage or bad
//! input.

mod agree;
mod bias;
mod cli;
mod compare;
mod completions;
mod console;
mod explain;
mod failure;
mod hemisphere;
mod info;
mod inspect;
mod interrupt;
mod list;
mod lobe;
mod merge;
mod options;
mod outputs;
mod paths;
mod progress;
mod race;
mod render;
mod replay;
mod series;
mod session;
mod start;
mod suggest;
mod view;

use std::env;
use std::process::ExitCode;

use clap::Parser;

use cli::{Cli, Command};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) if error.use_stderr() => match suggest::about_line(env::args_os()) {
            Some(suggestion) => return failure::exit_code(Err(suggestion)),
            None => error.exit(),
        },
        Err(help) => help.exit(),
    };
    if let Some(bytes) = cli.memory {
        neumann_core::memory::set_allowed(bytes);
    }
    let result = match cli.command {
        None => start::run(cli.scene.as_deref()),
        Some(Command::View(arguments)) => view::run(&arguments),
        Some(Command::Render(arguments)) => render::run(&arguments),
        Some(Command::Replay(arguments)) => replay::run(&arguments),
        Some(Command::Inspect(arguments)) => inspect::run(&arguments),
        Some(Command::Hemisphere(arguments)) => hemisphere::run(&arguments),
        Some(Command::Lobe(arguments)) => lobe::run(&arguments),
        Some(Command::Series(arguments)) => series::run(&arguments),
        Some(Command::Race(arguments)) => race::run(&arguments),
        Some(Command::Agree(arguments)) => agree::run(&arguments),
        Some(Command::Bias(arguments)) => bias::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::List(arguments)) => list::run(&arguments),
        Some(Command::Explain(arguments)) => explain::run(&arguments),
        Some(Command::Info(arguments)) => info::run(&arguments),
        Some(Command::Merge(arguments)) => merge::run(&arguments),
        Some(Command::Completions(arguments)) => completions::run(&arguments),
    };
    failure::exit_code(result)
}
