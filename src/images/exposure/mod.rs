//! Exposure data in a header: start, duration, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, `exposure_time` determines start and
//! duration, and `calibration` reads zero point, gain, read noise and band.

mod calibration;
mod exposure_time;
mod moment;

pub use calibration::{Calibration, CountBasis, HeaderValue, PixelUnit, ZeroPoint};
pub use exposure_time::ExposureTime;
