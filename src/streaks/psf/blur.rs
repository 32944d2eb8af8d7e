//! Seeing, defocus and size: what together spreads a point's light.

use serde::Deserialize;
use thiserror::Error;

use super::seeing::Seeing;

/// Radii of defocus and size above this are not drawn, pixels.
pub(super) const GREATEST_RADIUS_PIX: f64 = 200.0;
/// Profiles that reach farther are refused, pixels.
pub(super) const GREATEST_REACH_PIX: f64 = 4000.0;

/// Why a profile cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BlurError {
    /// A number outside its range, or not finite.
    #[error("{name} is {given}, allowed is {least} to {greatest}")]
    OutOfRange {
        /// The field.
        name: &'static str,
        /// As given.
        given: f64,
        /// Least allowed value.
        least: f64,
        /// Greatest allowed value.
        greatest: f64,
    },
    /// A ring without an area.
    #[error(
        "the hole in the pupil's image has a radius of {inner_pix} pixels, the image one of {outer_pix}: the hole must be smaller (at most 0.99)"
    )]
    Hole {
        /// Radius of the hole.
        inner_pix: f64,
        /// Radius of the image.
        outer_pix: f64,
    },
    /// Wings too far out.
    #[error(
        "all but 1e-4 of the light reaches {reach_pix:.0} pixels from its centre, allowed are {GREATEST_REACH_PIX}"
    )]
    Reach {
        /// As found.
        reach_pix: f64,
    },
}

impl BlurError {
    /// Holds a number to its range.
    pub(super) fn hold(name: &'static str, given: f64, least: f64, greatest: f64) -> Result<(), Self> {
        if (least..=greatest).contains(&given) {
            return Ok(());
        }
        Err(Self::OutOfRange { name, given, least, greatest })
    }
}

/// What spreads a point's light: seeing, convolved with the ring that is the pupil's image out of focus, convolved with a uniform disk for
/// the size of the body itself.
///
/// At range d a telescope focused on the stars, of outer and inner radius r_o and r_i, sees a ring of angular radii r_o/d and r_i/d
/// (Tyson et al. 2020, AJ 160, 226, section 4.2; Ragazzoni 2020, PASP 132, 114502).
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blur {
    /// Of the air.
    pub seeing: Seeing,
    /// Outer radius of the ring, \[0, 200\] pixels; 0 in focus.
    #[serde(default)]
    pub outer_radius_pix: f64,
    /// Inner radius of the ring, pixels, at most 0.99 of the outer one.
    #[serde(default)]
    pub inner_radius_pix: f64,
    /// Radius of the body, seen as a uniform disk, \[0, 200\] pixels; 0 for a point.
    #[serde(default)]
    pub body_radius_pix: f64,
}

impl Blur {
    /// Seeing alone: a star, or anything far away.
    pub fn seeing(seeing: Seeing) -> Self {
        Self { seeing, outer_radius_pix: 0.0, inner_radius_pix: 0.0, body_radius_pix: 0.0 }
    }

    /// # Errors
    /// As in [`BlurError`].
    pub(super) fn validate(&self) -> Result<(), BlurError> {
        self.seeing.validate()?;
        BlurError::hold("outer_radius_pix", self.outer_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        BlurError::hold("inner_radius_pix", self.inner_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        BlurError::hold("body_radius_pix", self.body_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        if self.inner_radius_pix > 0.99 * self.outer_radius_pix {
            return Err(BlurError::Hole { inner_pix: self.inner_radius_pix, outer_pix: self.outer_radius_pix });
        }
        Ok(())
    }

    /// Radius within which the profile may have edges, pixels.
    pub(super) fn flat_radius_pix(&self) -> f64 {
        self.outer_radius_pix + self.body_radius_pix
    }
}
