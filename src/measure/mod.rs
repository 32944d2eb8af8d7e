//! Forced photometry of satellite streaks along predicted tracks.
//!
//! A [`PredictedStreak`] is the track of a satellite in pixels with its times and errors. [`measure_streak`] searches
//! for the streak in the corridor, the area around the track that these errors allow, and measures flux, offset,
//! lateness and width, or an upper limit.
//!
//! `background` subtracts the sky for the search, `corridor` describes the track by columns of pixels across it, and
//! `search` is the matched filter. `band` holds the pixels around one streak, and `stars` masks the stars in a band.
//! `fit` is the weighted least-squares fit of the drawn streak, `width` fits the seeing, and `noise` computes the
//! errors of the sky, `light_errors` the others, and `forms` those of the form of the point spread function. `align`
//! finds the first position of a bright streak, `narrow` that of a streak less than 1.6 pixels wide, and `ends` the
//! delay and the ends; `hidden_light` computes the share of a streak's light on masked pixels and outside of the
//! illuminated area. `streak` combines them into a [`StreakMeasurement`]; `measurement` defines this type and the
//! inputs. `cut` returns the pixels along a measured track. `predict` computes the tracks of the satellites of a sky,
//! `star_table` reads stars of known magnitude, `star_shape` and `zero_point` measure these stars by the pixels of a
//! `stamp`, `frame` measures whole files without the pixels that `bad_pixels` finds in masks and variances and with the
//! values of saturation that `levels` finds, `given` measures the streaks of a table, `pass_prediction` corrects
//! predicted magnitudes by earlier streaks of the same pass, and `table` creates the output tables.
//!
//! ```
//! use streakcast::images::{LightArea, PixelPosition, Plane};
//! use streakcast::measure::{Background, MeasureOptions, PredictedStreak, StreakImage, measure_streak};
//! use streakcast::streaks::{Optics, PathNode, SeeingForm, StreakPath};
//!
//! // A plane without a streak, and a predicted track across it: the result is an upper limit.
//! let (plane, light_area) = (Plane::zeros(200, 300), LightArea::whole(200, 300));
//! let background = Background::new(&plane, &light_area);
//! let image = StreakImage {
//!     plane: &plane,
//!     background: &background,
//!     light_area: &light_area,
//!     exposure_s: 10.0,
//!     electrons_per_unit: None,
//!     saturation: None,
//!     pixel_scale_arcsec: 1.0,
//!     pixel_aspect: 1.0,
//! };
//! let at = |time_s: f64| PixelPosition { x: 30.0 * time_s, y: 100.0 };
//! let nodes = [-2.0, 12.0].map(|time_s| PathNode::new(time_s, at(time_s), 1.0));
//! let predicted = PredictedStreak {
//!     path: StreakPath::new(nodes.to_vec())?,
//!     drift_pix_s: [0.0; 2],
//!     lateness_sigma_s: 0.1,
//!     largest_delay_s: 1.0,
//!     ends_s: None,
//!     cross_sigma_pix: 1.0,
//!     range_km: 600.0,
//!     radius_m: 1.0,
//!     radius_sigma_m: 0.0,
//! };
//! let optics =
//!     Optics { form: SeeingForm::Gaussian, seeing_arcsec: 2.0, outer_radius_m: 0.5, inner_radius_m: 0.1 };
//! let measured = measure_streak(&image, &predicted, &optics, &MeasureOptions::default())?;
//! println!("{measured:?}");
//! # Ok::<(), streakcast::Error>(())
//! ```

mod align;
mod background;
#[cfg(all(feature = "fits", unix))]
mod bad_pixels;
mod band;
mod corridor;
mod cut;
mod ends;
mod fit;
mod forms;
#[cfg(all(feature = "fits", unix))]
mod frame;
#[cfg(all(feature = "fits", unix))]
mod given;
mod hidden_light;
#[cfg(all(feature = "fits", unix))]
mod levels;
mod light_errors;
mod measurement;
mod narrow;
mod noise;
#[cfg(all(feature = "fits", unix))]
mod pass_prediction;
#[cfg(all(feature = "fits", unix))]
mod predict;
mod search;
#[cfg(all(feature = "fits", unix))]
mod stamp;
#[cfg(all(feature = "fits", unix))]
mod star_shape;
#[cfg(all(feature = "fits", unix))]
mod star_table;
mod stars;
mod streak;
#[cfg(all(feature = "fits", unix))]
mod table;
mod width;
#[cfg(all(feature = "fits", unix))]
mod zero_point;

pub use background::Background;
#[cfg(all(feature = "fits", unix))]
pub(crate) use frame::{FrameMeasurements, FrameOptions, ZeroPoints, measure_frame};
#[cfg(all(feature = "fits", unix))]
pub(crate) use given::{ListedStreak, StreakList, measure_listed};
pub use measurement::{Estimate, Flag, MeasureOptions, PredictedStreak, StreakImage, StreakMeasurement};
#[cfg(all(feature = "fits", unix))]
pub(crate) use pass_prediction::predict_within_passes;
pub use streak::measure_streak;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[cfg(all(feature = "fits", unix))]
#[doc(hidden)]
pub use self::{
    frame::MeasuredPass,
    given::ListedMeasurement,
    predict::{KnownSatellite, PredictOptions},
    star_shape::StarShape,
    star_table::{CatalogueStar, StarTable},
    table::{ScoreObserver, listed_table, measurement_table, score_table},
    zero_point::{StarZeroPoint, star_zero_point},
};
#[doc(hidden)]
pub use cut::streak_cut;
