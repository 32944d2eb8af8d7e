//! The pixel plane: frames, their geometry on the sky, and what optics and detector make of light. It has never heard of satellites.

mod card;
mod exposure;
#[cfg(feature = "fits")]
mod fits;
mod header;
mod pixel;
mod plane;
mod wcs;

pub use card::{CARD_LENGTH, Card, CardValue};
pub use exposure::{Calibration, CountBasis, ExposureError, ExposureTime, Stated, ZeroPoint};
#[cfg(feature = "fits")]
pub use fits::{
    Bitpix, Cells, Changed, FrameCopy, FrameError, FrameFile, HduInfo, HduKind, ImageValues, NewImage, PixelFormat,
    Pixels, Rice, TableColumn, write_frame,
};
pub use header::Header;
pub use pixel::PixelPosition;
pub use plane::{Plane, PlaneError};
pub use wcs::{Wcs, WcsError};
