//! Blur of a point of light by seeing, defocus and the size of the body.

use serde::Deserialize;

use super::seeing::Seeing;
use crate::error::Error;

/// Largest accepted radius of the defocus ring and of the body, pixels.
const GREATEST_RADIUS_PIX: f64 = 200.0;

/// Seeing, convolved with the ring-shaped image of the defocused pupil and with a uniform disk for the body.
///
/// In a telescope focused on the stars, whose aperture has the outer and inner radii r_o and r_i, the image of a point
/// at range d is a ring with the angular radii r_o/d and r_i/d (Tyson et al. 2020, AJ 160, 226, section 4.2; Ragazzoni
/// 2020, PASP 132, 114502).
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blur {
    /// Profile of a star's image.
    pub seeing: Seeing,
    /// Outer radius of the defocus ring, \[0, 200\] pixels; 0 in focus.
    #[serde(default)]
    pub outer_radius_pix: f64,
    /// Inner radius of the defocus ring, pixels, at most 0.99 of the outer radius.
    #[serde(default)]
    pub inner_radius_pix: f64,
    /// Radius of the body, a uniform disk, \[0, 200\] pixels; 0 for a point.
    #[serde(default)]
    pub body_radius_pix: f64,
}

impl Blur {
    /// Creates a blur by seeing only, for a star.
    pub fn seeing(seeing: Seeing) -> Self {
        Self { seeing, outer_radius_pix: 0.0, inner_radius_pix: 0.0, body_radius_pix: 0.0 }
    }

    /// Checks that all numbers are in range.
    ///
    /// # Errors
    /// A number out of range.
    pub(super) fn validate(&self) -> Result<(), Error> {
        self.seeing.validate()?;
        Error::check_range("outer_radius_pix", self.outer_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        Error::check_range("inner_radius_pix", self.inner_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        Error::check_range("body_radius_pix", self.body_radius_pix, 0.0, GREATEST_RADIUS_PIX)?;
        if self.inner_radius_pix > 0.99 * self.outer_radius_pix {
            let allowed = format!("at most 0.99 of outer_radius_pix, which is {}", self.outer_radius_pix);
            return Err(Error::invalid("inner_radius_pix", self.inner_radius_pix, allowed));
        }
        Ok(())
    }

    /// Returns the radius within which the profile may have sharp edges, pixels.
    pub(super) fn flat_radius_pix(&self) -> f64 {
        self.outer_radius_pix + self.body_radius_pix
    }
}
