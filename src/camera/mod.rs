//! The pixel plane: frames, their geometry on the sky, and what optics and detector make of light. It has never heard of satellites.

mod pixel;
mod plane;

pub use pixel::PixelPosition;
pub use plane::{Plane, PlaneError};
