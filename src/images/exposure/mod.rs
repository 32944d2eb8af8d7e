//! Exposure data in a header: start, length, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, `exposure_time` combines start and length,
//! `calibration` reads zero point, gain, noise and band.

mod calibration;
mod exposure_time;
mod moment;

pub use calibration::{Calibration, CountBasis, HeaderValue, PixelUnit, ZeroPoint};
pub use exposure_time::ExposureTime;
