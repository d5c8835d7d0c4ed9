//! Methods at equal processor time, judged against one reference: what the command and the window
//! have in common.
//!
//! Who has had the least time is next, with all threads. What is counted is the processor time of
//! these threads while a method renders; looking at what it has made is not.

mod chart;
mod curve;
mod entrant;
mod racer;

pub use chart::{Chart, colours};
pub use curve::{Measure, Point, seconds_to};
pub use entrant::Entrant;
pub use racer::{Racer, next_in_turn, processor_time};

/// What renders a reference: unbiased, and as good at caustics as at direct light.
pub const REFERENCE_METHOD: &str = "bdpt";

/// Most methods of a race; there are two at least.
pub const MOST: usize = 4;
