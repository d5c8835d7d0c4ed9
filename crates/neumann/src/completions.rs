//! `neumann completions`: completions for a shell.

use clap::CommandFactory;

use crate::cli::{Cli, CompletionsArguments};
use crate::console;
use crate::failure::Outcome;

pub(crate) fn run(arguments: &CompletionsArguments) -> Outcome {
    let mut script = Vec::new();
    let mut command = Cli::command();
    clap_complete::generate(arguments.shell, &mut command, "neumann", &mut script);
    console::result(String::from_utf8_lossy(&script).trim_end())
}
