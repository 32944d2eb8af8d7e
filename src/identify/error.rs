//! Why a streak cannot be identified at all.

use thiserror::Error;

use crate::passes::SkyError;

/// What is wrong with a measured streak, or with the question.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum IdentifyError {
    /// A number that makes no streak.
    #[error("{what} {given}; allowed: {allowed}")]
    Value {
        /// Of what.
        what: &'static str,
        /// As given, with its unit.
        given: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Both ends at one place.
    #[error(
        "both ends of the streak are at one place ({separation_arcsec:.3} arcsec apart); allowed: more than 0.01 arcsec"
    )]
    NoLine {
        /// How far they are apart.
        separation_arcsec: f64,
    },
    /// A file of regions that cannot be read.
    #[error("{path}: line {line}: {problem}")]
    Region {
        /// The file.
        path: String,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// A file of regions without one.
    #[error("{path}: no region in it; allowed: polygon, box, line and vector in fk5 or icrs")]
    NoRegion {
        /// The file.
        path: String,
    },
    /// Outlines of more than one streak.
    #[error(
        "the regions do not lie on one line: the middle of one stands {off_arcsec:.1} arcsec beside it, where they are {width_arcsec:.1} arcsec wide; allowed: the regions of one streak"
    )]
    NotOneLine {
        /// The farthest middle.
        off_arcsec: f64,
        /// Full width of the regions.
        width_arcsec: f64,
    },
    /// The sky has no answer.
    #[error(transparent)]
    Sky(#[from] SkyError),
}
