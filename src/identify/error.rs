//! Errors of the identification of a streak.

use thiserror::Error;

use crate::passes::SkyError;

/// Error in a measured streak, in a region file, or of the search.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum IdentifyError {
    /// A value is invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// Invalid value, with its unit.
        given: String,
        /// Accepted values.
        allowed: &'static str,
    },
    /// Both ends are at the same position.
    #[error(
        "both ends of the streak are at the same position ({separation_arcsec:.3} arcsec apart); allowed: more than 0.01 arcsec"
    )]
    NoLine {
        /// Distance between the ends, arcsec.
        separation_arcsec: f64,
    },
    /// A line of a region file is invalid.
    #[error("{path}: line {line}: {problem}")]
    Region {
        /// Path of the file.
        path: String,
        /// Line number, from 1.
        line: usize,
        /// What is wrong, and what is accepted.
        problem: String,
    },
    /// The file contains no region.
    #[error("{path}: no region found; allowed: polygon, box, line and vector in fk5 or icrs")]
    NoRegion {
        /// Path of the file.
        path: String,
    },
    /// The regions do not lie along one line.
    #[error(
        "the regions are not on one line: the middle of one is {off_arcsec:.1} arcsec off, and it is {width_arcsec:.1} arcsec wide; allowed: the regions of one streak"
    )]
    NotOneLine {
        /// Distance of the middle of a region from the line, arcsec.
        off_arcsec: f64,
        /// Full width of the region, arcsec.
        width_arcsec: f64,
    },
    /// Positions cannot be computed.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
