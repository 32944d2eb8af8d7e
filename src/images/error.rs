//! Errors of frames, headers, detectors and telescopes.

use thiserror::Error;

use super::detector::DetectorError;
use super::exposure::ExposureError;
#[cfg(all(feature = "fits", unix))]
use super::fits::FrameError;
use super::wcs::WcsError;

/// Errors of frames, headers, detectors and telescopes.
#[derive(Debug, Error)]
pub enum ImagesError {
    /// Error of a frame in a file.
    #[cfg(all(feature = "fits", unix))]
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Error of the time of an exposure.
    #[error(transparent)]
    Exposure(#[from] ExposureError),
    /// Error of world coordinates.
    #[error(transparent)]
    Wcs(#[from] WcsError),
    /// Error of a detector.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// Unknown telescope.
    #[error("unknown telescope {given:?}; known telescopes: {known}")]
    UnknownTelescope {
        /// Given name.
        given: String,
        /// Names of all presets.
        known: String,
    },
    /// Invalid TOML, or a key that is missing, unknown or of the wrong type; the message names key and line.
    #[error("telescope file {origin}: {message}")]
    TelescopeToml {
        /// The file.
        origin: String,
        /// Description and position of the error.
        message: String,
    },
    /// A number is out of range or not finite.
    #[error("telescope file {origin}: {key} is {given}; allowed: {least} to {greatest}")]
    TelescopeOutOfRange {
        /// The file.
        origin: String,
        /// The key.
        key: String,
        /// Given value.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A limit is given for an unknown band.
    #[error("telescope file {origin}: unknown band {given:?} of a limit; known bands: B V R I u g r i z y G")]
    TelescopeBand {
        /// The file.
        origin: String,
        /// Given band.
        given: String,
    },
    /// The number of values does not match the shape of the image.
    #[error("an image of {rows} rows by {columns} columns cannot have {given} values; expected {}", rows * columns)]
    PlaneShape {
        /// Rows of the image.
        rows: usize,
        /// Columns of the image.
        columns: usize,
        /// Number of values given.
        given: usize,
    },
    /// A frame without rows or columns.
    #[cfg(feature = "plot")]
    #[error("cannot draw a frame of {rows} rows by {columns} columns: it has no pixels")]
    EmptyPreview {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// The preview cannot be encoded.
    #[cfg(feature = "plot")]
    #[error("cannot encode the preview: {0}")]
    EncodePreview(#[from] image::ImageError),
}
