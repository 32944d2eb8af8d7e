//! The pixel plane: frames, their geometry on the sky, and what optics and detector make of light. It has never heard of satellites.

mod background;
mod detector;
mod patch;
mod pixel;
mod plane;
mod psf;

pub use background::{BackgroundError, RandomStars, Star, background};
pub use detector::{
    Amplifier, Bleeding, Crosstalk, Detector, DetectorError, NonLinearity, Quantisation, ReadoutCorner, Saturated,
    Saturation, Vignetting,
};
pub use patch::{Patch, PatchRows, PatchSpan};
pub use pixel::PixelPosition;
pub use plane::{Plane, PlaneError};
pub use psf::{Blur, BlurError, Lanes, RadialProfile, Seeing, draw_point};
