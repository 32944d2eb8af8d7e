//! Reference frames, time scales and the Earth's orientation. Each frame is a Rust type, so that code that mixes two
//! frames does not compile.
//!
//! Precession and nutation are IAU 2006/2000A; UT1 and polar motion come from a table of the IERS ([`EopTable`]); times
//! are [`hifitime::Epoch`]s. [`Orientation::at`] takes 40 µs; [`OrientationTable`] interpolates in 0.1 µs:
//!
//! ```
//! use hifitime::Epoch;
//! use streakcast::frames::{EopTable, Gcrs, Itrs, OrientationTable, Position, seconds_after};
//!
//! let dusk = Epoch::from_gregorian_utc_hms(2026, 4, 25, 23, 0, 0);
//! let table = OrientationTable::new(dusk, seconds_after(dusk, 36_000.0), &EopTable::embedded());
//! let site = Position::<Itrs>::new(1819.0, -5209.0, -3195.0);
//! let site_gcrs: Position<Gcrs> = table.at_s(3600.0).itrs_to_gcrs * site;
//! # assert!((site_gcrs.norm_km() - site.norm_km()).abs() < 1e-5);
//! ```

mod angles;
mod bright_stars;
mod deep_sky;
mod earth_orientation;
mod equatorial;
mod error;
mod instant;
mod orientation;
mod sampled;
mod time;
mod vector;

pub use angles::{parse_declination_deg, parse_direction, parse_right_ascension_deg};
pub use bright_stars::{BrightStar, bright_stars};
pub use deep_sky::deep_sky_object;
pub use earth_orientation::{EarthOrientationParameters, EopStatus, EopTable};
pub use equatorial::{annual_aberration, gcrs_to_of_date, itrs_to_horizontal, without_annual_aberration};
pub use error::FramesError;
pub use instant::{FIRST_YEAR, LAST_YEAR, is_covered, parse_instant, parse_moment};
pub use orientation::{Orientation, OrientationTable, eme2000_to_gcrs};
pub(crate) use sampled::Sampled;
pub(crate) use time::tai_ns;
pub use time::{
    epoch_from_jd, epoch_from_mjd, leap_seconds_known_until, mjd_utc, seconds_after, seconds_between, tt_jd, ut1_jd,
    utc_jd,
};
pub use vector::{
    Acceleration, Body, Direction, Eme2000, Frame, Gcrs, Horizontal, Itrs, OfDate, Position, Rotation, Teme, Velocity,
};
