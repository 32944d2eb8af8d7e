//! Axes as types: mixing two frames does not compile.

mod angles;
mod earth_orientation;
mod equatorial;
mod error;
mod frame;
mod horizontal;
mod orientation;
mod sampled;
mod time;
mod vector;

pub use angles::{parse_declination_deg, parse_right_ascension_deg};
pub use earth_orientation::{EarthOrientationParameters, EopStatus, EopTable, ut1_error_m};
pub use equatorial::{annual_aberration, gcrs_to_of_date, without_annual_aberration};
pub use error::FramesError;
pub use frame::{Body, Frame, Gcrs, Horizontal, Itrs, OfDate, Teme};
pub use horizontal::itrs_to_horizontal;
pub use orientation::{Orientation, OrientationTable};
pub(crate) use sampled::Sampled;
pub use time::{
    epoch_from_jd, epoch_from_mjd, mjd_utc, seconds_after, seconds_between, tai_minus_utc_s, tt_jd, ut1_jd, utc_jd,
};
pub use vector::{Direction, Position, Rotation, Velocity};
