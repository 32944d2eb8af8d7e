//! Effects of a detector on light: `vignetting`, `saturation` with bleeding, `non_linearity`, `crosstalk`, and
//! `conversion` (gain, bias, quantisation, noise). `settings` holds the stages in use; `expose` applies them to a
//! synthetic frame, `add` to light that is added to an existing frame.

mod add;
mod conversion;
mod crosstalk;
mod expose;
mod non_linearity;
mod saturation;
mod settings;
mod vignetting;

pub use add::AddedLight;
#[cfg(all(feature = "fits", unix))]
pub use add::FrameRows;
pub use conversion::Quantisation;
pub use crosstalk::ReadoutCorner;
pub use saturation::{Bleeding, Saturated, Saturation};
pub use settings::Detector;
