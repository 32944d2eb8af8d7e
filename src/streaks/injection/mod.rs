//! Injection of streaks into frames: [`InjectionPlan`] describes it, [`Injection`] opens the frames, draws and writes.
//!
//! `frames` opens or makes frames, `lights` finds the moving lights of a frame, `run` draws and writes them; `array`
//! treats images in memory.

mod array;
mod frames;
mod lights;
mod plan;
mod run;

pub use array::{ArrayFrame, ArrayInjected};
pub use lights::InjectionSky;
pub use plan::{InjectionPlan, RandomPlan, SyntheticPlan};
pub use run::{InjectedFrame, Injection, Injections, Mark};
