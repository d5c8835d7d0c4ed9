//! The only file that writes to stdout and stderr.

use std::io::{self, IsTerminal, Write};

use serde_json::Value;

use crate::failure::Outcome;

/// Writes results to stdout.
pub(crate) fn result(text: &str) -> Outcome {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes())?;
    stdout.write_all(b"\n")?;
    stdout.flush()?;
    Ok(())
}

/// Writes results to stdout as JSON.
pub(crate) fn json(value: &Value) -> Outcome {
    result(&serde_json::to_string_pretty(value)?)
}

/// Says something on stderr; if nobody listens, so be it.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// True if somebody watches stderr.
pub(crate) fn is_watched() -> bool {
    io::stderr().is_terminal()
}
