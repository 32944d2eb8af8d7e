//! Errors of point spread functions.

use thiserror::Error;

/// Greatest radius of the wings, pixels.
pub(super) const GREATEST_REACH_PIX: f64 = 4000.0;

/// Errors of a point spread function.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BlurError {
    /// A number is out of range or not finite.
    #[error("{name} is {given}; allowed: {least} to {greatest}")]
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
    /// The inner radius of the ring is too near to the outer one.
    #[error("inner_radius_pix is {inner_pix}; allowed: at most 0.99 of outer_radius_pix, which is {outer_pix}")]
    Hole {
        /// Inner radius.
        inner_pix: f64,
        /// Outer radius.
        outer_pix: f64,
    },
    /// The wings extend beyond the greatest radius.
    #[error(
        "the light extends to {reach_pix:.0} pixels from its centre (all but 1e-4 of it); allowed: {GREATEST_REACH_PIX} pixels"
    )]
    Reach {
        /// Radius of the wings.
        reach_pix: f64,
    },
}

impl BlurError {
    /// Checks that a number is in its range.
    pub(super) fn check_range(name: &'static str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::OutOfRange { name, given, least, greatest })
    }
}
