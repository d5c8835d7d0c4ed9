//! The window goes away under the program: its X server ends, or another program takes it.
//!
//! The window system tells of it in three ways. Xlib calls a handler, and ends the program when
//! that returns, with a sentence of its own unless there is another handler. Winit unwraps answers
//! of the server and panics where none comes. Or the window is destroyed, which is an event. All
//! three end in the same sentence and exit code 1, when all files are written.

use std::io::Write;
use std::time::Duration;

use winit::event_loop::EventLoop;

use crate::options::ViewError;
use crate::writing;

/// Longest time that the end waits for files that are being written.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Has the program end with its own sentence when the display does.
pub(crate) fn watch<T: 'static>(event_loop: &EventLoop<T>) {
    #[cfg(all(unix, not(target_os = "macos")))]
    if winit::platform::x11::EventLoopExtX11::is_x11(event_loop) {
        xlib::watch();
        watch_panics();
    }
    #[cfg(not(all(unix, not(target_os = "macos"))))]
    let _ = event_loop;
}

/// A panic within winit's X11 backend means that the server has not answered.
#[cfg(all(unix, not(target_os = "macos")))]
fn watch_panics() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if panic.location().is_some_and(|at| is_x11(at.file())) {
            end();
        }
        usual(panic);
    }));
}

/// True for source files of winit's X11 backend.
#[cfg(all(unix, not(target_os = "macos")))]
fn is_x11(file: &str) -> bool {
    let parts: Vec<&str> = file.split(['/', '\\']).collect();
    parts.iter().any(|part| part.starts_with("winit-")) && parts.contains(&"x11")
}

/// Says what has happened, and ends the program.
#[cfg(all(unix, not(target_os = "macos")))]
fn end() -> ! {
    writing::finish(PATIENCE);
    // Nobody may be listening any more.
    let _ = writeln!(std::io::stderr(), "error: {}", ViewError::Gone);
    std::process::exit(1)
}

#[cfg(all(unix, not(target_os = "macos")))]
#[allow(unsafe_code, reason = "Xlib calls back through a C function")]
mod xlib {
    use std::ffi::c_int;

    use x11_dl::xlib::{Display, Xlib};

    /// Takes the place of Xlib's own handler. Without Xlib there is no X11 window either.
    pub(super) fn watch() {
        if let Ok(xlib) = Xlib::open() {
            // SAFETY: the function has the type that Xlib asks for, lives as long as the program,
            // and does not unwind; setting it needs no connection.
            unsafe { (xlib.XSetIOErrorHandler)(Some(is_gone)) };
        }
    }

    /// Xlib has lost its connection.
    unsafe extern "C" fn is_gone(_: *mut Display) -> c_int {
        super::end()
    }
}

#[cfg(all(test, unix, not(target_os = "macos")))]
mod tests {
    use super::is_x11;

    #[test]
    fn panics_of_the_backend_are_told_from_others() {
        let winit = "registry/src/index/winit-0.30.13/src/platform_impl/linux";
        assert!(is_x11(&format!("{winit}/x11/window.rs")));
        assert!(!is_x11(&format!("{winit}/wayland/mod.rs")));
        assert!(!is_x11("crates/neumann-viewer/src/window.rs"));
    }
}
