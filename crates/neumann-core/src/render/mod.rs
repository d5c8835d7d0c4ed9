//! Threads, streams and merge order: how iterations are run and collected.
//!
//! [`Pass`] runs one iteration in parallel and deterministically;
//! [`Renderer`] strings iterations together for a command; [`RenderLoop`]
//! does so in the background for a window.

mod behind_backs;
mod cancel;
mod coverage;
mod iteration_times;
mod light_paths;
mod own_light;
mod pass;
mod pixels;
mod pool;
mod render_loop;
mod renderer;
mod replay;
mod sample_counts;
mod settings;
mod sink;

pub use behind_backs::hidden_by_backs;
pub use cancel::{CancelToken, Cancelled};
pub use iteration_times::IterationTimes;
pub use light_paths::{Collected, LightNumbers, LightPaths};
pub use own_light::lit;
pub use pass::Pass;
pub use pixels::{PixelPath, PixelSample, Pixels, Splits};
pub use pool::WorkerPool;
pub use render_loop::{Job, Published, RenderLoop, Stats, StopRule, Thumbnail};
pub use renderer::{Iteration, Renderer};
pub use replay::{PathId, Replayed};
pub use sample_counts::SampleCounts;
pub use settings::RenderSettings;
pub use sink::{PixelPlace, Sink};
