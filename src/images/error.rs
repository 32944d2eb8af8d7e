//! Errors of frames, headers, detectors and telescopes.

use thiserror::Error;

use super::detector::DetectorError;
use super::exposure::ExposureError;
#[cfg(feature = "fits")]
use super::fits::FrameError;
use super::wcs::WcsError;

/// Errors of frames, headers, detectors and telescopes.
#[derive(Debug, Error)]
pub enum ImagesError {
    /// Frame in a file.
    #[cfg(feature = "fits")]
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Time of an exposure.
    #[error(transparent)]
    Exposure(#[from] ExposureError),
    /// World coordinates.
    #[error(transparent)]
    Wcs(#[from] WcsError),
    /// Detector.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// No preset of this name.
    #[error("unknown telescope {given:?}; known are {known}")]
    UnknownTelescope {
        /// As it was given.
        given: String,
        /// All presets.
        known: String,
    },
    /// Not TOML, a key missing, unknown or of the wrong type; the message names key and line.
    #[error("telescope file {origin}: {message}")]
    TelescopeToml {
        /// The file.
        origin: String,
        /// What and where.
        message: String,
    },
    /// A number outside what is allowed, or not finite.
    #[error("telescope file {origin}: {key} is {given}, allowed is {least} to {greatest}")]
    TelescopeOutOfRange {
        /// The file.
        origin: String,
        /// The key.
        key: String,
        /// As it stands there.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A limit for a band that is not known.
    #[error("telescope file {origin}: limits are given for band {given:?}; known are B V R I u g r i z y G")]
    TelescopeBand {
        /// The file.
        origin: String,
        /// As it stands there.
        given: String,
    },
    /// The values do not fill it.
    #[error("{given} values for an image of {rows} rows by {columns} columns ({} are needed)", rows * columns)]
    PlaneShape {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        columns: usize,
        /// Values given.
        given: usize,
    },
    /// A frame without rows or columns.
    #[cfg(feature = "plot")]
    #[error("a frame of {rows} rows by {columns} columns has no picture")]
    EmptyPreview {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// The encoder failed.
    #[cfg(feature = "plot")]
    #[error("the picture cannot be encoded: {0}")]
    EncodePreview(#[from] image::ImageError),
}
