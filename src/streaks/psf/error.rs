//! Errors of point spread functions.

use thiserror::Error;

/// Greatest radius of the wings, pixels.
pub(super) const GREATEST_REACH_PIX: f64 = 4000.0;

/// Errors of a point spread function.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BlurError {
    /// A number outside its range, or not finite.
    #[error("{name} is {given}, allowed is {least} to {greatest}")]
    OutOfRange {
        /// Name of the field.
        name: &'static str,
        /// Value given.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A hole as large as the ring around it.
    #[error(
        "the hole in the pupil's image has a radius of {inner_pix} pixels, the image one of {outer_pix}: the hole must be smaller (at most 0.99)"
    )]
    Hole {
        /// Radius of the hole.
        inner_pix: f64,
        /// Radius of the image.
        outer_pix: f64,
    },
    /// Wings beyond the greatest radius.
    #[error(
        "all but 1e-4 of the light reaches {reach_pix:.0} pixels from its centre, allowed are {GREATEST_REACH_PIX}"
    )]
    Reach {
        /// Radius of the wings.
        reach_pix: f64,
    },
}

impl BlurError {
    /// Rejects a number outside its range.
    pub(super) fn hold(name: &'static str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::OutOfRange { name, given, least, greatest })
    }
}
