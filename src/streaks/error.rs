//! Errors of the module `streaks`: brightness, optics, drawing, masks.

use thiserror::Error;

use super::background::BackgroundError;
use super::count_scale::CountScaleError;
use super::optics::OpticsError;
use super::psf::BlurError;
use super::render::PathError;
use crate::passes::{FieldError, SkyError};

/// Errors of the module `streaks`: brightness, optics, drawing, masks.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StreaksError {
    /// A number is out of range or not finite.
    #[error("{what} is {given}; allowed: {allowed}")]
    Modulation {
        /// Name of the number.
        what: &'static str,
        /// Given value.
        given: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// The times of a light curve do not increase, or it has fewer than two points.
    #[error("light curve, point {point}: {problem}")]
    LightCurve {
        /// Number of the point, from 1.
        point: usize,
        /// Cause, with the allowed values.
        problem: &'static str,
    },
    /// A range of random streaks is invalid.
    #[error("random streaks: {what} {from} to {to}; allowed: {allowed}")]
    RandomStreaks {
        /// Name of the numbers.
        what: &'static str,
        /// Given lower end.
        from: f64,
        /// Given upper end.
        to: f64,
        /// Allowed values.
        allowed: &'static str,
    },
    /// Unknown mask preset.
    #[error("unknown mask preset {given:?}; allowed: {allowed}")]
    MaskPreset {
        /// Given name.
        given: String,
        /// Names of all presets.
        allowed: String,
    },
    /// All bits of a 32-bit mask are in use.
    #[error("the frame's own mask uses all bits up to {highest}; no bit is left for {plane}")]
    MaskBits {
        /// Plane without a bit.
        plane: &'static str,
        /// Highest usable bit.
        highest: u32,
    },
    /// Error of the passes of a sky.
    #[error(transparent)]
    Sky(#[from] SkyError),
    /// The field of the chips is invalid.
    #[error("invalid field of the frame's chips: {0}")]
    Field(#[from] FieldError),
    /// Error of the optics.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The path over a chip is invalid.
    #[error("invalid path over HDU {hdu}: {source}")]
    Path {
        /// HDU of the chip.
        hdu: usize,
        /// Cause.
        source: PathError,
    },
    /// Error of the background of a frame.
    #[error(transparent)]
    Background(#[from] BackgroundError),
    /// Error of the zero point or exposure of a frame.
    #[error(transparent)]
    CountScale(#[from] CountScaleError),
    /// Error of the profile of a light.
    #[error(transparent)]
    Blur(#[from] BlurError),
}
