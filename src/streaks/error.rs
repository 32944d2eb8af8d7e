//! Errors of the module `streaks`.

use std::fmt::Display;

use thiserror::Error;

use crate::images::ImagesError;
use crate::passes::SkyError;

/// Errors of the brightness, drawing and injection of streaks.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum StreaksError {
    /// A value of a frame, of a file or of a call is missing or invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Invalid {
        /// Name of the value, after the file and HDU if there are any.
        what: String,
        /// Given value, or `missing`.
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
    /// Error of the passes of satellites.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// Error of a frame, its world coordinates or its detector.
    #[error(transparent)]
    Images(#[from] ImagesError),
    /// Error of one frame of several.
    #[error("{source}; {done} of {count} frames have already been written, without a truth table")]
    Batch {
        /// Error of the frame.
        source: Box<StreaksError>,
        /// Number of frames that are complete.
        done: usize,
        /// Number of all frames.
        count: usize,
    },
    /// Error of the folder for temporary files.
    #[error(transparent)]
    Scratch(#[from] std::io::Error),
}

impl StreaksError {
    pub(crate) fn invalid(what: impl Into<String>, given: impl Display, allowed: impl Into<String>) -> Self {
        Self::Invalid { what: what.into(), given: given.to_string(), allowed: allowed.into() }
    }

    /// Rejects a number outside its range or not finite.
    pub(super) fn check_range(what: &str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::invalid(what, given, format!("{least} to {greatest}")))
    }

    /// Adds the place of an invalid value: file, HDU, or name of the settings.
    pub(super) fn at(self, place: impl Display) -> Self {
        match self {
            Self::Invalid { what, given, allowed } => {
                Self::Invalid { what: format!("{place}: {what}"), given, allowed }
            }
            Self::Images(error) => Self::Images(error.at(place)),
            other => other,
        }
    }
}
