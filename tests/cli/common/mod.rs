//! Helpers for tests of the program: those of all tests, and those that run it.

pub mod cli;
#[cfg(unix)]
pub mod injected;
pub mod server;
#[path = "../../common/mod.rs"]
mod shared;
#[path = "../../common/simulated_photometry.rs"]
pub mod simulated_photometry;

pub use shared::*;
