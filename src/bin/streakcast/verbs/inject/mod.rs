//! `inject`: streaks of satellites, or random ones, put into frames.

mod arguments;
mod outputs;
mod run;

pub use arguments::InjectArguments;
pub use run::run;
