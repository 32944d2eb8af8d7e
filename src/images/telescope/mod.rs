//! Telescopes as streaks see them: aperture, seeing, pixels, field, and the limits of their detectors.
//!
//! A satellite is near enough to be out of focus: seen from it the mirror is a disk with a hole, and the image of a
//! point is that disk. Widths follow Tyson et al. (2020, AJ 160, 226) and Ragazzoni (2020, PASP 132, 114502). Angles
//! at this room's face are arcseconds and degrees, since they are what people type.

mod aperture;
mod file;
mod streak;

pub use aperture::{BandLimits, FieldOfView, Telescope};
pub use streak::{
    ARCSEC_PER_RAD, effective_magnitude, expected_lost_pixel_fraction, satcon1_limit_mag,
    surface_brightness_mag_arcsec2, time_on_pixel_s,
};
