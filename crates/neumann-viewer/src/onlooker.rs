//! Looking on while the window runs: for whoever measures it. The program itself has no onlooker.

use std::time::{Duration, Instant};

use egui::RawInput;
use winit::event_loop::EventLoopProxy;

use crate::app::App;
use crate::window::Event;

/// Is told of every frame, and can act as a hand on keyboard and camera would.
pub trait Onlooker {
    /// The window is open; to set up the graphics adapter took so long.
    fn opened(&mut self, adapter: Duration, nudge: Nudge);

    /// A nudge has come that was given at that time. False closes the window.
    fn nudged(&mut self, given: Instant, app: &mut App, input: &mut RawInput) -> bool;

    /// A frame has been presented; the interface's own share of it took so long.
    fn presented(&mut self, app: &App, share: Duration);
}

/// Wakes the window, from any thread.
#[derive(Clone, Debug)]
pub struct Nudge(pub(crate) EventLoopProxy<Event>);

impl Nudge {
    /// Has [`Onlooker::nudged`] called; false when the window has gone.
    #[must_use]
    pub fn give(&self) -> bool {
        self.0.send_event(Event::Nudge(Instant::now())).is_ok()
    }
}
