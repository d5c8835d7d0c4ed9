//! What the light meets.
//!
//! [`description`] mirrors a file, [`load`] fills it in, [`build`] makes it
//! ready to trace.

pub mod description;
pub mod load;
