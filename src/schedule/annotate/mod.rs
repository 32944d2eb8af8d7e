//! Annotated schedules: the original file with verdicts and streaks added.

mod annotation;
mod delimited;
mod json;
#[cfg(feature = "sqlite")]
mod opsim;
mod votable;
mod write;

pub use annotation::Annotation;
pub use write::{annotate, check_extension, check_not_annotated};
