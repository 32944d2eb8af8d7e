//! Errors of the module `images`.

use std::fmt::Display;
#[cfg(all(feature = "fits", unix))]
use std::path::{Path, PathBuf};

use crate::message::Quoted;
use thiserror::Error;

/// Errors of frames, headers, world coordinates, detectors and telescopes.
///
/// An operation that fails does not change its input and leaves no partial output.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImagesError {
    /// A value in a header, a settings file or an argument is missing or invalid.
    #[error("{what} is {given}; allowed: {allowed}")]
    Invalid {
        /// Name of the value, preceded by the file and the HDU if the value is in a file.
        what: String,
        /// Given value, or `missing`.
        given: String,
        /// Allowed values.
        allowed: String,
    },
    /// Settings that are not valid TOML, or a key that is missing, unknown or of the wrong type.
    #[error("{origin}: {message}")]
    Toml {
        /// Path of the file, or the name of the settings.
        origin: String,
        /// Description and position of the error.
        message: String,
    },
    /// A header without axes of right ascension and declination.
    #[error(
        "{location}no celestial coordinates: CTYPE1 is {ctype1:?} and CTYPE2 is {ctype2:?}; allowed: one RA---xxx and one DEC--xxx", ctype1 = Quoted::new(.ctype1), ctype2 = Quoted::new(.ctype2)
    )]
    NoCelestialAxes {
        /// The file and the HDU, each followed by a colon and a blank; empty for a header alone.
        location: String,
        /// Text of CTYPE1, empty if it is missing.
        ctype1: String,
        /// Text of CTYPE2, empty if it is missing.
        ctype2: String,
    },
    /// The operating system reported an error for a file.
    #[cfg(all(feature = "fits", unix))]
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// CFITSIO reported an error for a file.
    #[cfg(all(feature = "fits", unix))]
    #[error("{}: CFITSIO: {message} (status {status})", path.display())]
    Cfitsio {
        /// The file.
        path: PathBuf,
        /// Status of CFITSIO.
        status: i32,
        /// Message of CFITSIO.
        message: String,
    },
    /// Compressed pixels cannot be decompressed, or cannot be compressed again.
    #[cfg(all(feature = "fits", unix))]
    #[error("{}: HDU {hdu}: {problem}", path.display())]
    Tiles {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Cause of the failure, and how to avoid it.
        problem: String,
    },
    /// The preview cannot be encoded as PNG.
    #[cfg(feature = "plot")]
    #[error("preview: {0}")]
    #[doc(hidden)]
    EncodePreview(#[from] image::ImageError),
}

impl ImagesError {
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

    /// Prefixes an error in a value or a header with the file, the HDU or the settings that contain it.
    pub(crate) fn at(self, location: impl Display) -> Self {
        match self {
            Self::Invalid { what, given, allowed } => {
                Self::Invalid { what: format!("{location}: {what}"), given, allowed }
            }
            Self::NoCelestialAxes { location: inner, ctype1, ctype2 } => {
                Self::NoCelestialAxes { location: format!("{location}: {inner}"), ctype1, ctype2 }
            }
            other => other,
        }
    }
}

#[cfg(all(feature = "fits", unix))]
impl ImagesError {
    /// Prefixes the name of an invalid value with its file and HDU.
    pub(crate) fn in_hdu(self, path: &Path, hdu: usize) -> Self {
        self.at(format_args!("{}: HDU {hdu}", path.display()))
    }

    /// Replaces the path in an error of CFITSIO: the path of a temporary file becomes that of the user's file.
    pub(super) fn of_file(self, path: &Path) -> Self {
        match self {
            Self::Cfitsio { status, message, .. } => Self::Cfitsio { path: path.to_owned(), status, message },
            other => other,
        }
    }

    /// Returns a function that converts an error of the operating system to an error with the path of the file.
    pub(crate) fn io(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }
}
