//! What the tests in `suite/` share: statistics, densities over the sphere,
//! scenes with closed-form answers, and renders whose error is known.
//!
//! Seeds are fixed everywhere, so a test gives the same verdict each time.

pub mod bsdfs;
pub mod cells;
pub mod lights;
pub mod random;
pub mod renders;
pub mod room;
pub mod scenes;
pub mod statistics;
pub mod studio;
