//! Streaks put into frames: [`InjectionPlan`] has what is to be done, [`Injection`] opens the frames, draws and writes.
//!
//! `frames` opens frames or makes synthetic ones, `lights` finds the moving lights of a frame, `run` draws and writes them; `array` is
//! for images in memory.

mod array;
mod error;
mod frames;
mod lights;
mod plan;
mod run;

pub use array::{ArrayFrame, ArrayInjected};
pub use error::InjectionError;
pub use lights::InjectionSky;
pub use plan::{InjectionPlan, RandomPlan, SyntheticPlan};
pub use run::{InjectedFrame, Injection, Injections, Mark};
