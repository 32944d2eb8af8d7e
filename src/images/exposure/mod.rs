//! Exposure data in a header: start, duration, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, and `comment` reads what the comments of
//! cards state. `instants` reads starts, middles and ends by the lists in `instant_keywords`, `length` the exposure
//! time, `stacks` numbers of added exposures, and `exposure_time` compares them. `calibration` reads zero point, gain,
//! read noise and band, and `observatory` the site.

mod calibration;
mod comment;
mod exposure_time;
mod instant_keywords;
mod instants;
mod length;
mod moment;
mod observatory;
mod stacks;

pub use calibration::{Calibration, CountBasis, PixelUnit};
pub use exposure_time::ExposureTime;

pub use observatory::{HeaderSite, SITE_KEYWORDS, UNNAMED_SITE, site_from_headers};
