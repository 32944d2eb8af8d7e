//! Annotated schedules: the file with flags and streaks added, and all of its original contents.

mod annotation;
mod delimited;
mod json;
#[cfg(feature = "sqlite")]
mod opsim;
#[cfg(feature = "parquet")]
mod parquet;
mod votable;
mod write;

pub use annotation::Annotation;
pub use write::annotate;
