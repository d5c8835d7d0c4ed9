//! What the light meets.
//!
//! [`description`] mirrors a file, [`load`] fills it in, [`Scene`] is ready to trace.

mod built;
pub mod description;
pub mod load;

pub use built::Scene;
