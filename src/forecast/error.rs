//! Why there is no forecast.

use thiserror::Error;

use crate::passes::SkyError;

/// Why a question about a night has no answer.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ForecastError {
    /// A number beyond what is allowed.
    #[error("{what} {given}{unit}: allowed {allowed}")]
    OutOfRange {
        /// Which number.
        what: &'static str,
        /// What was given.
        given: f64,
        /// Its unit with a blank before it; empty for none.
        unit: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No satellite is of the kind asked for.
    #[error("none of the {satellites} satellites has {wanted}")]
    NobodyWanted {
        /// How many there are.
        satellites: usize,
        /// What was asked for.
        wanted: String,
    },
    /// The sky has no answer.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
