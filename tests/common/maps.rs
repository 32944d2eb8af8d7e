//! Helpers for tests of maps.

use streakcast::photometry::{BrightnessModel, ModelLibrary, PhotometryOptions};

/// Returns the bundled two-panel model of Starlink V1.5.
pub fn v15() -> BrightnessModel {
    ModelLibrary::embedded().get("starlink-v1.5").unwrap().as_ref().clone()
}

/// Returns the photometry options of Lu (2024), which are the default.
pub fn options() -> PhotometryOptions {
    PhotometryOptions::default()
}
