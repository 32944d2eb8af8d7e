//! What a header says of its exposure: when, how long, and what a count is worth.
//!
//! `keywords` finds values under their many names, `moment` reads dates and times, `exposure_time` puts start and length together and `calibration`
//! gathers zero point, gain, noise and band.

mod calibration;
mod exposure_time;
mod keywords;
mod moment;

pub use calibration::{Calibration, CountBasis, PixelUnit, Stated, ZeroPoint};
pub use exposure_time::{ExposureError, ExposureTime};
