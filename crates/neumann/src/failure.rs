//! Failures and their exit codes.

use std::fmt;
use std::io;
use std::process::ExitCode;

use crate::console;

/// What a subcommand ends with.
pub(crate) type Outcome<T = ()> = anyhow::Result<T>;

/// Marks an error as wrong usage or bad input, exit code 2.
#[derive(Debug)]
struct BadInput(anyhow::Error);

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#}", self.0)
    }
}

impl std::error::Error for BadInput {}

/// Marks an answer that is no, given in full on stdout: exit code 1, and nothing more to say.
#[derive(Debug, thiserror::Error)]
#[error("no")]
struct AnswersNo;

/// An answer that is no.
pub(crate) fn answers_no() -> anyhow::Error {
    AnswersNo.into()
}

/// Marks errors as the user's to mend.
pub(crate) trait OrBadInput<T> {
    /// Makes the error one of wrong usage or bad input.
    fn or_bad_input(self) -> Outcome<T>;
}

impl<T, E: Into<anyhow::Error>> OrBadInput<T> for Result<T, E> {
    fn or_bad_input(self) -> Outcome<T> {
        self.map_err(|error| BadInput(error.into()).into())
    }
}

/// An error of wrong usage or bad input.
pub(crate) fn bad_input(text: impl fmt::Display) -> anyhow::Error {
    BadInput(anyhow::anyhow!("{text}")).into()
}

/// Says what went wrong, in one line, and with which code the program ends.
pub(crate) fn exit_code(result: Outcome) -> ExitCode {
    let Err(error) = result else {
        return ExitCode::SUCCESS;
    };
    let is_closed_pipe = error
        .downcast_ref::<io::Error>()
        .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe);
    if is_closed_pipe {
        // Whoever read the results has had enough of them.
        return ExitCode::SUCCESS;
    }
    if error.is::<AnswersNo>() {
        return ExitCode::from(1);
    }
    console::note(&format!("error: {}", one_line(&format!("{error:#}"))));
    ExitCode::from(if error.is::<BadInput>() { 2 } else { 1 })
}

fn one_line(text: &str) -> String {
    text.lines().map(str::trim).collect::<Vec<_>>().join(" ")
}

/// Somebody has ended the work before there was anything to write.
pub(crate) fn interrupted() -> anyhow::Error {
    anyhow::anyhow!("interrupted; nothing was written")
}

#[cfg(test)]
mod tests {
    use super::{OrBadInput, bad_input, one_line};

    #[test]
    fn marks_survive_and_messages_are_one_line() {
        let result: Result<(), _> = Err(std::io::Error::other("no"));
        let error = result.or_bad_input().unwrap_err();
        assert!(error.is::<super::BadInput>());
        assert_eq!(format!("{error:#}"), "no");
        assert!(bad_input("x").is::<super::BadInput>());
        assert_eq!(one_line("a\n  b"), "a b");
    }
}
