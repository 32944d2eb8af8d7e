//! Errors of forecasts and statistics.

use thiserror::Error;

use crate::passes::SkyError;

/// Errors of forecasts and statistics.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ForecastError {
    /// A number out of range.
    #[error("{what} is {given}{unit}; allowed: {allowed}")]
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// Invalid value.
        given: f64,
        /// Unit with a preceding blank, or empty.
        unit: &'static str,
        /// Accepted range.
        allowed: &'static str,
    },
    /// No satellite matches the selection.
    #[error(
        "none of the {satellites} satellites has {selection}; allowed: a selection of at least one satellite (modules and \
         docked spacecraft belong to their station: 25544 ISS, 48274 CSS)"
    )]
    EmptySelection {
        /// Number of satellites.
        satellites: usize,
        /// Description of the selection.
        selection: String,
    },
    /// Positions cannot be computed.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
