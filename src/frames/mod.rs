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
mod deep_sky;
mod earth_orientation;
mod equatorial;
mod error;
mod instant;
mod orientation;
mod sampled;
mod time;
mod vector;

pub(crate) use angles::degrees_of;
pub use earth_orientation::EopTable;
pub(crate) use equatorial::itrs_to_horizontal;
pub use instant::parse_instant;
pub(crate) use instant::{FIRST_YEAR, LAST_YEAR, has_zone};
pub(crate) use orientation::eme2000_to_gcrs;
pub use orientation::{Orientation, OrientationTable};
pub use time::{epoch_from_mjd, mjd_utc, seconds_after, seconds_between};
pub(crate) use time::{leap_seconds_known_until, tt_jd};
pub(crate) use vector::Acceleration;
pub use vector::{Body, Direction, Frame, Gcrs, Horizontal, Itrs, Position, Rotation, Teme, Velocity};

// Not documented, without a promise of stability: for the program, the Python extension, tests and benches, and for
// code of other features.
#[doc(hidden)]
pub use self::{
    angles::{compass, parse_declination_deg, parse_direction, parse_right_ascension_deg},
    deep_sky::deep_sky_object,
    earth_orientation::{EarthOrientationParameters, EopStatus},
    equatorial::{annual_aberration, gcrs_to_of_date, without_annual_aberration},
    instant::{check_time_of_day, is_covered, parse_moment, parse_start},
    time::{epoch_from_jd, ut1_jd, utc_jd},
    vector::OfDate,
};
pub(crate) use sampled::Sampled;
#[cfg(all(feature = "fits", unix))]
pub(crate) use time::tai_ns;
