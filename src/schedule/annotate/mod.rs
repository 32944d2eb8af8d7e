//! The answer beside every original cell: the same schedule file, lossless, with flags and streaks.

mod csv_file;
mod error;
#[cfg(feature = "sqlite")]
mod opsim_file;
mod write;

pub use error::AnnotateError;
pub use write::{Annotation, annotate};
