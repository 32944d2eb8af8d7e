//! `inject`: streaks of satellites, or random ones, put into frames.

mod asked;
mod frames;
mod light;
mod outputs;
mod run;

pub use run::run;
