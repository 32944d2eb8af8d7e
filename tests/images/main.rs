//! Tests of frames, detectors and drawn streaks.

#[path = "../common/mod.rs"]
mod common;

mod detector;
mod exposure_headers;
#[cfg(all(feature = "fits", unix))]
mod frame_copies;
#[cfg(all(feature = "fits", unix))]
mod frame_files;
#[cfg(all(feature = "fits", unix))]
mod frame_hostile;
#[cfg(all(feature = "fits", unix))]
mod frame_planes;
#[cfg(all(feature = "fits", unix))]
mod masks;
mod measure;
#[cfg(all(feature = "fits", unix))]
mod measure_stars;
#[cfg(all(feature = "fits", unix))]
mod streak_real;
mod streaks;
mod wcs;
