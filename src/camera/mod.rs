//! The pixel plane: frames, their geometry on the sky, and what optics and detector make of light. It has never heard of satellites.

mod pixel;
mod plane;
#[cfg(feature = "plot")]
mod preview;

pub use pixel::PixelPosition;
pub use plane::{Plane, PlaneError};
#[cfg(feature = "plot")]
pub use preview::{Overlay, PreviewError, preview_png};
