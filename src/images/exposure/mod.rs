//! Exposure data in a header: start, duration, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, and `comment` reads what the comments of
//! cards state. `instants` reads starts, middles and ends, `length` the exposure time, and `exposure_time` compares
//! them. `calibration` reads zero point, gain, read noise and band, and `observatory` the site.

mod calibration;
mod comment;
mod exposure_time;
mod instants;
mod length;
mod moment;
mod observatory;

pub use calibration::{Calibration, CountBasis, PixelUnit};
pub use exposure_time::ExposureTime;
pub use observatory::{HeaderSite, SITE_KEYWORDS, site_from_headers};
