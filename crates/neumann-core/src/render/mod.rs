//! Threads, streams and merge order: how iterations are run and collected.
//!
//! [`Pass`] runs one iteration in parallel and deterministically;
//! [`Renderer`] strings iterations together for a command; [`RenderLoop`]
//! does so in the background for a window.

mod adaptive;
mod behind_backs;
pub mod hemisphere;
mod inspection;
mod iteration_times;
mod job;
mod ladder;
pub mod lobe;
mod own_light;
mod photons;
mod pool;
mod render_loop;
mod renderer;
mod replay;
mod settings;
mod summary;

pub use behind_backs::hidden_by_backs;
pub use hemisphere::Hemisphere;
pub use inspection::{Inspection, Measured, SampleCount, WayShare};
pub use iteration_times::IterationTimes;
pub use job::{Job, StopRule};
pub use own_light::lit;
pub use pool::WorkerPool;
pub use render_loop::RenderLoop;
pub use renderer::{Iteration, Renderer};
pub use settings::RenderSettings;
pub use summary::{Published, Stats, Thumbnail};

pub use crate::pass::{
    CancelToken, Cancelled, Collected, LightNumbers, LightPaths, Pass, PathId, PixelPath,
    PixelPlace, PixelSample, Pixels, Replayed, SampleCounts, Sink, Splits,
};
