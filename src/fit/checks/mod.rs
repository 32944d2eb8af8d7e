//! Comparison of brightness models with published means, phase functions and measurements.
//!
//! `published` lists means and phase functions with their sources. `population` defines the geometries over which a
//! model is averaged. `photometry` reads measured magnitudes from a folder of published files. `comparison` makes one
//! row per model and reference.
//!
//! ```
//! use streakcast::fit::checks::{Verdict, compare};
//! use streakcast::photometry::ModelLibrary;
//!
//! let model = ModelLibrary::embedded().get("visorsat").unwrap();
//! let rows = compare(&model, None);
//! assert!(rows.iter().any(|row| row.verdict == Verdict::Ok));
//! ```

mod comparison;
mod photometry;
mod population;
mod published;

pub use comparison::{Comparison, ReferenceKind, SURVEY_ERROR_MAG, Sample, Verdict, compare, comparison_table};
pub use photometry::{DataSet, Photometry, ReferenceMeasurement};
pub use population::POPULATION;
