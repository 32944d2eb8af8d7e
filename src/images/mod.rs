//! Frames: files, headers, world coordinates, detectors and telescopes. This module does not depend on satellites.

mod card;
mod detector;
mod error;
mod exposure;
#[cfg(all(feature = "fits", unix))]
mod fits;
mod header;
mod light_area;
mod magnitude_limit;
mod patch;
mod pixels;
#[cfg(feature = "plot")]
mod preview;
#[cfg(all(feature = "fits", unix))]
mod streak_catalogues;
mod streak_cost;
#[cfg(all(feature = "fits", unix))]
mod streak_table;
mod telescope;
mod telescope_streak;
mod wcs;

pub use card::{CARD_LENGTH, Card, CardValue};
pub use detector::{
    AddedLight, Amplifier, Bleeding, Crosstalk, Detector, NonLinearity, Quantisation, ReadoutCorner, Saturated,
    Saturation, Vignetting,
};
pub use error::ImagesError;
pub use exposure::{
    Calibration, CountBasis, ExposureTime, HeaderValue, PixelUnit, SITE_KEYWORDS, ZeroPoint, site_from_headers,
};
#[cfg(all(feature = "fits", unix))]
pub use fits::{
    Bitpix, Cells, Changed, CompanionPlane, FrameCopy, FrameFile, FrameImages, HduInfo, HduKind, ImageValues, NewImage,
    PixelFormat, Pixels, PlaneKind, Rice, TableColumn, write_frame, write_table,
};
pub use header::Header;
pub use light_area::LightArea;
pub use magnitude_limit::MagnitudeLimit;
pub use patch::{Patch, PatchRows, PatchSpan};
pub use pixels::{PixelPosition, Plane};
#[cfg(feature = "plot")]
pub use preview::{Overlay, preview_png};
pub use streak_cost::{PossibleStreak, StreakCost};
#[cfg(all(feature = "fits", unix))]
pub(crate) use streak_table::Bounded;
#[cfg(all(feature = "fits", unix))]
pub use streak_table::{StreakEnds, StreakRow, StreakTable};
pub use telescope::{
    ARCSEC_PER_RAD, FieldOfView, Telescope, effective_magnitude, expected_lost_pixel_fraction, satcon1_limit_mag,
    surface_brightness_mag_arcsec2, time_on_pixel_s,
};
pub use wcs::Wcs;
