//! Exposure data in a header: start, duration, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, `exposure_time` determines start and
//! duration, `calibration` reads zero point, gain, read noise and band, and `observatory` the site.

mod calibration;
mod exposure_time;
mod moment;
mod observatory;

pub use calibration::{Calibration, CountBasis, HeaderValue, PixelUnit, ZeroPoint};
pub use exposure_time::ExposureTime;
pub use observatory::{SITE_KEYWORDS, site_from_headers};
