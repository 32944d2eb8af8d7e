//! Frames: files, headers, world coordinates, detectors and telescopes. This module does not depend on satellites.
//!
//! ```
//! use streakcast::frames::Direction;
//! use streakcast::images::{PixelPosition, Wcs};
//!
//! // A chip of 2,000 rows and 1,000 columns with pixels of 0.5 arcsec, north up, centred on RA 60 and Dec -20 deg.
//! let centre = Direction::from_lon_lat_rad(60.0_f64.to_radians(), -20.0_f64.to_radians());
//! let wcs = Wcs::tangent(centre, 0.5, 0.0, 1000, 2000)?;
//! let pixel: PixelPosition = wcs.to_pixel(centre).expect("on the chip's side of the sky");
//! let back = wcs.to_sky(pixel).expect("on the sky");
//! assert!(back.separation_rad(&centre) < 1e-9);
//! # Ok::<(), streakcast::Error>(())
//! ```

mod card;
mod detector;
mod exposure;
#[cfg(all(feature = "fits", unix))]
mod fits;
mod header;
mod light_area;
mod magnitude_limit;
mod patch;
#[cfg(all(feature = "fits", unix))]
mod physical;
mod pixels;
#[cfg(feature = "plot")]
mod preview;
#[cfg(all(feature = "fits", unix))]
mod psf_file;
mod regions;
#[cfg(all(feature = "fits", unix))]
mod row_origin;
#[cfg(all(feature = "fits", unix))]
mod streak_catalogues;
mod streak_cost;
#[cfg(all(feature = "fits", unix))]
mod streak_table;
mod telescope;
mod telescope_streak;
mod wcs;

pub(crate) use detector::AddedLight;
#[cfg(all(feature = "fits", unix))]
pub(crate) use detector::FrameRows;
#[cfg(all(feature = "fits", unix))]
pub use fits::FrameFile;
#[cfg(all(feature = "fits", unix))]
pub(crate) use fits::{Changed, CompanionPlane, write_table};
pub use header::Header;
pub use light_area::LightArea;
pub use patch::Patch;
pub(crate) use patch::PatchRows;
pub use pixels::{PixelPosition, Plane};
#[cfg(all(feature = "fits", unix))]
pub(crate) use psf_file::{PsfFile, PsfGrid};
#[cfg(all(feature = "fits", unix))]
pub(crate) use row_origin::RowOrigin;
#[cfg(all(feature = "fits", unix))]
pub(crate) use streak_table::{StreakEnds, StreakRow, StreakTable};
pub(crate) use telescope::{ARCSEC_PER_RAD, effective_magnitude, surface_brightness_mag_arcsec2};
pub use telescope::{FieldOfView, Telescope};
pub use wcs::Wcs;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    card::{Card, CardValue},
    detector::{Bleeding, Detector, Quantisation, ReadoutCorner, Saturated, Saturation},
    exposure::{
        Calibration, CountBasis, ExposureTime, HeaderSite, PixelUnit, SITE_KEYWORDS, UNNAMED_SITE, site_from_headers,
        unused_coordinates,
    },
    magnitude_limit::MagnitudeLimit,
    regions::{OUTLINES, Outline, parse_regions},
    streak_cost::{PossibleStreak, StreakCost},
};
#[cfg(all(feature = "fits", unix))]
#[doc(hidden)]
pub use fits::{
    Bitpix, Cells, FrameCopy, FrameImages, HduKind, ImageValues, NewImage, Pixels, PlaneKind, Rice, TableColumn,
    write_frame,
};
#[cfg(feature = "plot")]
#[doc(hidden)]
pub use preview::{Overlay, preview_png};
#[cfg(all(feature = "fits", unix))]
pub(crate) use streak_table::Bounded;
