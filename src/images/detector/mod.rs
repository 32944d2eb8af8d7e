//! Effects of a detector on light: `vignetting`, `saturation` with bleeding, `non_linearity`, `crosstalk`, `conversion`
//! (gain, bias, quantisation, noise); `settings` (the stages in use), `expose` (a synthetic frame), `add` (light added
//! to an existing frame).

mod add;
mod conversion;
mod crosstalk;
mod expose;
mod non_linearity;
mod saturation;
mod settings;
mod vignetting;

pub use add::AddedLight;
pub use conversion::Quantisation;
pub use crosstalk::{Amplifier, Crosstalk, ReadoutCorner};
pub use non_linearity::NonLinearity;
pub use saturation::{Bleeding, Saturated, Saturation};
pub use settings::Detector;
pub use vignetting::Vignetting;
