//! Exposure data in a header: start, duration, and photometric calibration.
//!
//! `moment` finds values by their many keywords and parses dates and times, and `comment` reads what the comments of
//! cards state. `instants` reads starts, middles and ends by the lists in `instant_keywords`, `instant_part` the part of
//! the exposure of one `instant`, `other_instants` those in keywords of other names, `length` the exposure time, `stacks`
//! numbers of added exposures, `relative` times since a reference, `scale` the time scale.
//! `exposure_time` compares them, `clocks` chooses between clocks that differ, and `start_doubts` has the cards that
//! cast doubt on the start. `calibration` reads zero point, gain, read noise and band, and `observatory` the site.

mod calibration;
mod clocks;
mod comment;
mod exposure_time;
mod instant;
mod instant_keywords;
mod instant_part;
mod instants;
mod length;
mod moment;
mod observatory;
mod other_instants;
mod relative;
mod scale;
mod stacks;
mod start_doubts;

pub use calibration::{Calibration, CountBasis, PixelUnit};
pub use exposure_time::ExposureTime;
pub use observatory::{HeaderSite, SITE_KEYWORDS, UNNAMED_SITE, site_from_headers, unused_coordinates};
