//! Exposure of a header: start, length, and calibration of counts.
//!
//! `moment` finds values under their many keywords and reads dates and times, `exposure_time` combines start and length, `calibration`
//! gathers zero point, gain, noise and band.

mod calibration;
mod exposure_time;
mod moment;

pub use calibration::{Calibration, CountBasis, PixelUnit, Stated, ZeroPoint};
pub use exposure_time::{ExposureError, ExposureTime};
