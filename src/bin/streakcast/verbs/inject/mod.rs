//! `inject`: streaks of satellites, or random ones, put into frames.

mod outputs;
mod run;

pub use run::run;
