//! Forced photometry of satellite streaks along predicted tracks.
//!
//! A [`PredictedStreak`] is the track of a satellite in pixels with its times and errors. [`measure_streak`] searches
//! for the streak in the corridor, the area around the track that these errors allow, and measures flux, offset,
//! lateness and width, or an upper limit.
//!
//! `background` subtracts the sky for the search, `corridor` describes the track by columns of pixels across it, and
//! `search` is the matched filter. `band` holds the pixels around one streak, and `stars` masks the stars in a band.
//! `fit` is the weighted least-squares fit of the drawn streak, `width` fits the seeing, and `noise` computes the
//! errors. `streak` combines them into a [`StreakMeasurement`]; `measurement` defines this type and the inputs. `cut`
//! returns the pixels along a measured track. `predict` computes the tracks of the satellites of a sky, `star_table`
//! reads stars of known magnitude, `zero_point` measures these stars, `frame` measures whole files
//! without the pixels that `bad_pixels` finds in masks and variances, and `table` creates the output tables.

mod background;
#[cfg(all(feature = "fits", unix))]
mod bad_pixels;
mod band;
mod corridor;
mod cut;
mod error;
mod fit;
#[cfg(all(feature = "fits", unix))]
mod frame;
mod measurement;
mod noise;
#[cfg(all(feature = "fits", unix))]
mod predict;
mod search;
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
pub use error::MeasureError;
#[cfg(all(feature = "fits", unix))]
pub(crate) use frame::{FrameMeasurements, FrameOptions, ZeroPoints, measure_frame};
pub use measurement::{Estimate, Flag, MeasureOptions, PredictedStreak, StreakImage, StreakMeasurement};
pub use streak::measure_streak;

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[cfg(all(feature = "fits", unix))]
#[doc(hidden)]
pub use self::{
    frame::MeasuredPass,
    predict::PredictOptions,
    star_table::{CatalogueStar, StarTable},
    table::{ScoreObserver, measurement_table, score_table},
    zero_point::{StarZeroPoint, star_zero_point},
};
#[doc(hidden)]
pub use cut::streak_cut;
