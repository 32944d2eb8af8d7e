//! Frames, detectors and streaks in pixels.

#[path = "../common/mod.rs"]
mod common;

mod detector;
mod exposure_headers;
#[cfg(feature = "fits")]
mod frame_copies;
#[cfg(feature = "fits")]
mod frame_files;
#[cfg(feature = "fits")]
mod frame_hostile;
#[cfg(feature = "fits")]
mod streak_real;
mod streaks;
mod wcs;
