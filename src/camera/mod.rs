//! The pixel plane: frames, their geometry on the sky, and what optics and detector make of light. It has never heard of satellites.

mod background;
mod card;
mod detector;
mod exposure;
#[cfg(feature = "fits")]
mod fits;
mod header;
mod light_area;
mod patch;
mod pixel;
mod plane;
#[cfg(feature = "plot")]
mod preview;
mod psf;
mod wcs;

#[cfg(feature = "fits")]
pub(crate) use background::BRIGHTEST_E;
pub use background::{BackgroundError, RandomStars, Star, background, flux_e};
pub use card::{CARD_LENGTH, Card, CardValue};
pub use detector::{
    AddedLight, Amplifier, Bleeding, Crosstalk, Detector, DetectorError, NonLinearity, Quantisation, ReadoutCorner,
    Saturated, Saturation, Vignetting,
};
pub use exposure::{Calibration, CountBasis, ExposureError, ExposureTime, PixelUnit, Stated, ZeroPoint};
#[cfg(feature = "fits")]
pub use fits::{
    Bitpix, Cells, Changed, FrameCopy, FrameError, FrameFile, HduInfo, HduKind, ImageValues, NewImage, PixelFormat,
    Pixels, Rice, TableColumn, write_frame,
};
pub use header::Header;
pub use light_area::LightArea;
pub use patch::{Patch, PatchRows, PatchSpan};
pub use pixel::PixelPosition;
pub use plane::{Plane, PlaneError};
#[cfg(feature = "plot")]
pub use preview::{Overlay, PreviewError, preview_png};
pub use psf::{Blur, BlurError, EdgeTable, Lanes, Lattice, Parts, ProfileTables, RadialProfile, Seeing, draw_point};
pub use wcs::{Wcs, WcsError};
