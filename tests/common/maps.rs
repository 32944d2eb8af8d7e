//! Helpers for tests of maps.

use streakcast::photometry::{BrightnessModel, ModelLibrary, PhotometryOptions};

/// The bundled two-panel model of Starlink V1.5.
pub fn v15() -> BrightnessModel {
    ModelLibrary::embedded().get("starlink-v1.5").unwrap().as_ref().clone()
}

/// Options of the paper.
pub fn options() -> PhotometryOptions {
    PhotometryOptions::default()
}
