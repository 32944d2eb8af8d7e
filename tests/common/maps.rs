//! What the tests of maps share.

use streakcast::photometry::{BrightnessModel, ModelLibrary, PhotometryOptions};

/// The shipped two panels of Starlink V1.5.
pub fn v15() -> BrightnessModel {
    ModelLibrary::embedded().get("starlink-v1.5").unwrap().as_ref().clone()
}

/// As the paper has it.
pub fn options() -> PhotometryOptions {
    PhotometryOptions::default()
}
