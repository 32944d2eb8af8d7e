//! Maps and charts as PNG and SVG pictures.
//!
//! A [`Picture`] is a list of lines, texts and pixels, which `encode` converts to a file; `raster` draws smooth lines
//! for PNGs. `scale` assigns colours to values, `contour` computes lines of equal value, and `sky_disk` projects a
//! hemisphere. `maps` draws the maps of [`maps`](crate::maps), and `sky_rate` maps of expected streaks. Charts are
//! drawn in the boxes of `axes` and `time_axis` with the help of `numbers`, `statistics` and `density`: `corner`,
//! `counts_and_spread`, `residuals` and `blocking` for fits; `night`, `light_curve`, `field_chart`, `sky_chart`,
//! `finder_chart` (with the lists of `tracks`, and `star_field`, which draws `bright_stars` and `constellations`) and
//! `sun_altitude` for observers; `alarms` and `streak_cuts` for measurements.
//!
//! ```
//! use streakcast::plot::{LightCurve, light_curve};
//!
//! let time_mjd: Vec<f64> = (0..60).map(|step| 61_266.98 + f64::from(step) / 86_400.0).collect();
//! let magnitude: Vec<f64> = (0..60).map(|step| 6.0 - 0.02 * f64::from(step)).collect();
//! let picture = light_curve(&LightCurve {
//!     title: "A satellite that brightens",
//!     caption: "",
//!     time_mjd: &time_mjd,
//!     magnitude: &magnitude,
//!     sigma_mag: &[0.3; 60],
//!     in_fitted_range: &[],
//!     in_field: &[],
//!     shutter: None,
//!     limit_mag: Some(5.5),
//!     local: None,
//! })?;
//! assert!(picture.to_svg()?.contains("brightens"));
//! # Ok::<(), streakcast::Error>(())
//! ```

mod alarms;
mod axes;
mod blocking;
mod bright_stars;
mod constellations;
mod contour;
mod corner;
mod counts_and_spread;
mod density;
mod encode;
mod error;
mod field_chart;
mod file_options;
mod finder_chart;
mod graticule;
mod labels;
mod light_curve;
mod maps;
mod night;
mod numbers;
mod picture;
mod raster;
mod residuals;
mod scale;
mod sky_chart;
mod sky_disk;
mod sky_rate;
mod star_field;
mod statistics;
mod streak_cuts;
mod sun_altitude;
mod time_axis;
mod tracks;

pub use encode::PictureFormat;
pub use file_options::{FileOptions, PictureSize};
pub use light_curve::{LightCurve, light_curve};
pub use maps::{body_picture, sky_picture};
pub use night::{NightTimeline, night_timeline};
pub use picture::Picture;
pub use scale::Quantity;
pub use sky_chart::{SkyChart, SkyTrack, sky_chart};
pub use time_axis::LocalClock;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    alarms::{AlarmChart, AlarmMark, alarm_chart},
    blocking::blocking_picture,
    corner::{Corner, corner},
    counts_and_spread::{CountsAndSpread, counts_and_spread},
    encode::data_url,
    field_chart::{FieldChart, FieldStreak, field_chart},
    finder_chart::{FinderChart, finder_chart},
    graticule::FARTHEST_FIELD_DEG,
    maps::{LayerPanel, Layers, layers, paper_picture},
    residuals::{PhaseCurve, ResidualHistogram, ResidualPanels, phase_curve, residual_histogram, residual_panels},
    scale::ColourScale,
    sky_rate::{EquatorialRate, SkyRate, equatorial_rate, sky_rate},
    streak_cuts::{CutPanel, streak_cuts},
    sun_altitude::{SunAltitude, sun_altitude},
};
