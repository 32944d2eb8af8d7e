//! Brightness models held against what others published and measured, so that anyone can do it again.
//!
//! `published` lists means and phase functions with their sources, `population` the geometries over which a model is averaged,
//! `photometry` has measured magnitudes (surveys through the room `measured`, `amateurs` by itself), `residuals` has the statistics, and `comparison` makes one row of each model and reference, which `tables` makes a table of.
//!
//! ```
//! use streakcast::fit::checks::{Verdict, compare};
//! use streakcast::photometry::ModelLibrary;
//!
//! let model = ModelLibrary::embedded().get("visorsat").unwrap();
//! let rows = compare(&model, None);
//! assert!(rows.iter().any(|row| row.verdict == Verdict::Ok));
//! ```

mod amateurs;
mod comparison;
mod error;
mod photometry;
mod population;
mod published;
mod residuals;
mod tables;

pub use comparison::{
    CORE_TOLERANCE_SIGMA, Comparison, OFFSET_TOLERANCE_MAG, RMS_TOLERANCE_SIGMA, ReferenceKind, Verdict, compare,
};
pub use error::CheckError;
pub use photometry::{DataSet, Measurement, Photometry};
pub use population::{LEAST_ALTITUDE_DEG, POPULATION, Population, SITE_LATITUDE_DEG, SUN_ALTITUDES_DEG, Viewed};
pub use published::{PublishedCurve, PublishedMean, SUBJECTS, Subject, USUAL_SURVEY_SD_MAG};
pub use residuals::Residuals;
pub use tables::comparison_table;
