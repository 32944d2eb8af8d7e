//! Errors of the module `streaks`.

use std::fmt::Display;
use std::path::PathBuf;

use thiserror::Error;

use crate::images::ImagesError;
use crate::passes::SkyError;
use crate::watch::Interrupted;

/// Errors of computing, drawing and injecting streaks.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StreaksError {
    /// A value in a frame, a file or an argument is missing or invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Invalid {
        /// Name of the value, preceded by the file and the HDU if the value is in a file.
        what: String,
        /// Given value, or `missing` if there is none.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// A description of a synthetic frame that is not valid TOML, or a key that is missing, unknown or of the wrong
    /// type.
    #[error("synthetic frame {origin}: {message}")]
    Toml {
        /// Name of the file.
        origin: String,
        /// Description and position of the error.
        message: String,
    },
    /// A table of measured streaks that cannot be read.
    #[error("{}: {problem}", path.display())]
    Table {
        /// The table.
        path: PathBuf,
        /// Description of the error.
        problem: String,
    },
    /// Errors of the computation of satellite passes.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// Errors of a frame, its world coordinates or its detector.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// A frame of an injection without celestial coordinates.
    #[error("{0}, or --pixel-scale ANGLE with random streaks or --streaks in pixels")]
    NoCoordinates(ImagesError),
    /// An error in one of several frames.
    #[error("{source}; {done} of {count} frames have already been written, without tables")]
    Batch {
        /// The error.
        source: Box<StreaksError>,
        /// Number of frames that were written completely.
        done: usize,
        /// Number of all frames.
        count: usize,
    },
    /// The computation was stopped.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
    /// Errors of the folder for temporary files.
    #[error(transparent)]
    Scratch(#[from] std::io::Error),
}

impl StreaksError {
    pub(crate) fn invalid(what: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), given: given.to_string(), allowed: allowed.into() }
    }

    /// Rejects a number that is outside a range or not finite.
    pub(super) fn check_range(what: &str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::invalid(what, given, format!("{least} to {greatest}")))
    }

    /// Prefixes the name of an invalid value with the file, the HDU or the settings that contain it.
    pub(super) fn at(self, location: impl Display) -> Self {
        match self {
            Self::Invalid { what, given, allowed } => {
                Self::Invalid { what: format!("{location}: {what}"), given, allowed }
            }
            Self::Images(error) => Self::Images(error.at(location)),
            other => other,
        }
    }
}
