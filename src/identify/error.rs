//! Errors of identifying a streak.

use thiserror::Error;

use crate::passes::SkyError;

/// Errors in a measured streak, in a file of regions, or of the search.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentifyError {
    /// A value is invalid.
    #[error("{what} {given}; allowed: {allowed}")]
    Value {
        /// Name of the value.
        what: &'static str,
        /// Given value, with its unit.
        given: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Both ends are at one position.
    #[error(
        "both ends of the streak are at one place ({separation_arcsec:.3} arcsec apart); allowed: more than 0.01 arcsec"
    )]
    NoLine {
        /// Distance of the ends.
        separation_arcsec: f64,
    },
    /// A file of regions cannot be read.
    #[error("{path}: line {line}: {problem}")]
    Region {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// Error, and allowed values.
        problem: String,
    },
    /// A file has no region.
    #[error("{path}: no region in it; allowed: polygon, box, line and vector in fk5 or icrs")]
    NoRegion {
        /// The file.
        path: String,
    },
    /// The outlines belong to more than one streak.
    #[error(
        "the regions do not lie on one line: the middle of one stands {off_arcsec:.1} arcsec beside it, where they are {width_arcsec:.1} arcsec wide; allowed: the regions of one streak"
    )]
    NotOneLine {
        /// Largest distance of a middle from the line.
        off_arcsec: f64,
        /// Full width of the regions.
        width_arcsec: f64,
    },
    /// Positions cannot be computed.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
