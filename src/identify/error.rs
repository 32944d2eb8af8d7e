//! Errors of the identification of a streak.

use thiserror::Error;

use crate::passes::SkyError;

/// Errors in a measured streak, in a file of regions, or of the search.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentifyError {
    /// A value is invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// Given value, with its unit.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Both ends at one position.
    #[error(
        "both ends of the streak are at the same position ({separation_arcsec:.3} arcsec apart); allowed: more than 0.01 arcsec"
    )]
    NoLine {
        /// Distance between the ends, arcsec.
        separation_arcsec: f64,
    },
    /// A line of a region file that cannot be read.
    #[error("{path}: line {line}: {problem}")]
    Region {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// Problem, and allowed values.
        problem: String,
    },
    /// A file without a region.
    #[error("{path}: no region found; allowed: polygon, box, line and vector in fk5 or icrs")]
    NoRegion {
        /// The file.
        path: String,
    },
    /// Outlines of more than one streak.
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
