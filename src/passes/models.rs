//! placeholder
use crate::catalogue::ElementSet;
use crate::photometry::{BrightnessModel, ModelLibrary};
use std::sync::Arc;
pub struct ModelChoice {
    pub library: ModelLibrary,
}
impl ModelChoice {
    pub fn model_of(&self, _e: &ElementSet) -> Arc<BrightnessModel> {
        self.library.unknown().unwrap()
    }
}
impl ModelChoice {
    pub fn embedded() -> Self {
        Self { library: ModelLibrary::embedded() }
    }
}
