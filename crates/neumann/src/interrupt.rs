//! Ctrl-C: the first ends rendering with the picture written, the second ends the program.

use std::process::exit;

use neumann_core::render::CancelToken;

use crate::console;

/// A token that the first Ctrl-C (or SIGTERM) cancels.
pub(crate) fn token() -> CancelToken {
    let token = CancelToken::default();
    let for_handler = token.clone();
    let handler = move || {
        if for_handler.is_cancelled() {
            exit(130);
        }
        for_handler.cancel();
    };
    if let Err(error) = ctrlc::set_handler(handler) {
        console::note(&format!("note: Ctrl-C will not save the picture ({error})"));
    }
    token
}
