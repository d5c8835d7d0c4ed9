//! neumann
