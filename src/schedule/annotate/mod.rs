//! The answer beside every original cell: the same schedule file, lossless, with flags and streaks.

mod beside;
mod csv_file;
mod ecsv_file;
mod error;
mod json_file;
#[cfg(feature = "sqlite")]
mod opsim_file;
#[cfg(feature = "parquet")]
mod parquet_file;
mod votable_file;
mod write;

pub use error::AnnotateError;
pub use write::{Annotation, annotate};
