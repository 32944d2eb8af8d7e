//! Injection of streaks into frames. [`InjectionPlan`] describes an injection; [`Injection`] opens the frames and runs
//! it.
//!
//! `frames` opens or creates frames, `lights` finds the moving lights of a frame, `run` draws and writes them, and
//! `labels` writes their outlines for the training of detectors.

mod frames;
mod labels;
mod lights;
mod plan;
mod run;

pub(super) use frames::reject_untiled;
pub use labels::{LabelFile, LabelFormat};
pub use lights::InjectionSky;
pub(super) use lights::provenance_lines;
pub use plan::{InjectionPlan, RandomPlan, SyntheticPlan};
pub(crate) use run::partly_written;
pub(super) use run::reject_packed;
pub use run::{InjectedFrame, Injection, Injections};
