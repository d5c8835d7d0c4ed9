//! Ctrl-C: the first ends rendering with the picture written, the second ends the program.
//!
//! The same holds for a request to end, and for a terminal that goes away. Signals that the program
//! was started to ignore stay ignored: `nohup` does that with the end of the terminal, a shell with
//! Ctrl-C for what it runs in the background of a script.

use std::io;
use std::process::exit;

use neumann_core::render::CancelToken;

use crate::console;

/// A token that the first signal to end cancels.
pub(crate) fn token() -> CancelToken {
    let token = CancelToken::default();
    let for_handler = token.clone();
    let handler = move || {
        if for_handler.is_cancelled() {
            exit(130);
        }
        for_handler.cancel();
    };
    if let Err(error) = handle(handler) {
        console::note(&format!("note: Ctrl-C will not save the picture ({error})"));
    }
    token
}

/// Calls the handler, on a thread of its own, at every signal to end that is not ignored.
#[cfg(unix)]
fn handle(handler: impl Fn() + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let ignored = ignored_signals();
    let wanted = [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(|signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = Signals::new(wanted)?;
    std::thread::Builder::new()
        .name("neumann-signals".to_owned())
        .spawn(move || signals.forever().for_each(|_| handler()))?;
    Ok(())
}

#[cfg(not(unix))]
fn handle(handler: impl Fn() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(handler).map_err(io::Error::other)
}

/// The signals that were ignored when the program was started: signal n is bit n − 1.
///
/// Known on Linux, from `/proc`; elsewhere none is.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}
