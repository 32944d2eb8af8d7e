//! Position of the Sun and velocity of the Earth.
//!
//! The source is the analytic ephemeris of the Earth in SOFA (epv00, VSOP2000). From 1900 to 2100 it agrees with JPL's
//! DE405 within 11 km, or 0.015" in the Sun's direction. No file is needed.

use hifitime::Epoch;

use crate::constants::{AU_KM, DAY_S};
use crate::frames::{Gcrs, Position, Sampled, Velocity, seconds_between, tt_jd};

/// Sun and Earth at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SunState {
    /// Geocentric geometric position of the Sun, km, with Sun and Earth at the same instant (no light time, no
    /// aberration).
    pub sun: Position<Gcrs>,
    /// The Earth's velocity relative to the solar system barycentre, km/s.
    pub earth_velocity: Velocity<Gcrs>,
}

impl SunState {
    /// Computes the state without interpolation, in about 35 µs. For many times use [`SunTable`]. NaN outside the years
    /// 1900 to 2100.
    ///
    /// TT is used in place of TDB. They differ by less than 2 ms, in which the Earth moves 60 m, or 4·10⁻¹⁰ rad.
    pub fn at(epoch: Epoch) -> Self {
        Self::from_numbers(&numbers(epoch))
    }

    fn from_numbers(&[x, y, z, vx, vy, vz]: &[f64; 6]) -> Self {
        Self { sun: Position::new(x, y, z), earth_velocity: Velocity::new(vx, vy, vz) }
    }
}

/// Returns the Sun's geocentric position, km, and the Earth's barycentric velocity, km/s.
fn numbers(epoch: Epoch) -> [f64; 6] {
    let (day, fraction) = tt_jd(epoch);
    // `epv00` returns `None` for a date outside 1900 to 2100.
    match sofars::eph::epv00(day, fraction) {
        Some((heliocentric, barycentric)) => {
            let [position, _] = heliocentric;
            let [_, velocity] = barycentric;
            let (km, km_s) = (AU_KM, AU_KM / DAY_S);
            [
                -position[0] * km,
                -position[1] * km,
                -position[2] * km,
                velocity[0] * km_s,
                velocity[1] * km_s,
                velocity[2] * km_s,
            ]
        }
        None => [f64::NAN; 6],
    }
}

/// States over an interval, sampled every half day and interpolated by cubics. They are within 10⁻⁹ rad and 10⁻⁶ km/s
/// of [`SunState::at`].
#[derive(Clone, Debug)]
pub struct SunTable {
    reference: Epoch,
    samples: Sampled<6>,
}

impl SunTable {
    /// Creates a table from `start` to `end`; this takes some 35 µs for each half day, at least four. Up to half a day
    /// beyond either end, the cubics are extrapolated with the same accuracy.
    pub fn new(start: Epoch, end: Epoch) -> Self {
        Self { reference: start, samples: Sampled::new(start, end, numbers) }
    }

    /// Returns the same table with seconds counted from `start`, which must be a time within the table.
    pub fn part(&self, start: Epoch) -> Self {
        Self { reference: start, samples: self.samples.counted_from(seconds_between(self.reference, start)) }
    }

    /// Returns the epoch from which seconds are counted: the `start` given to the constructor.
    pub fn reference(&self) -> Epoch {
        self.reference
    }

    /// Returns the state at a time after the reference, in SI seconds.
    pub fn at_s(&self, seconds_after_reference: f64) -> SunState {
        SunState::from_numbers(&self.samples.cubic_at(seconds_after_reference))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::seconds_after;

    /// Tolerances stated in the docs of [`SunTable`].
    const DIRECTION_TOLERANCE_RAD: f64 = 1e-9;
    const VELOCITY_TOLERANCE_KM_S: f64 = 1e-6;

    #[test]
    fn verif_table_against_exact() {
        let start: Epoch = "2024-08-13T23:17:11 UTC".parse().expect("an epoch");
        let table = SunTable::new(start, seconds_after(start, 40.0 * DAY_S));
        let (mut worst_rad, mut worst_km_s) = (0.0_f64, 0.0_f64);
        for step in 0..=1000 {
            let seconds = f64::from(step) * 40.0 * DAY_S / 1000.0;
            let (exact, table) = (SunState::at(seconds_after(start, seconds)), table.at_s(seconds));
            worst_rad = worst_rad.max((exact.sun - table.sun).norm_km() / exact.sun.norm_km());
            worst_km_s = worst_km_s.max((exact.earth_velocity - table.earth_velocity).norm_km_s());
        }
        assert!(worst_rad < DIRECTION_TOLERANCE_RAD, "{worst_rad}");
        assert!(worst_km_s < VELOCITY_TOLERANCE_KM_S, "{worst_km_s}");
    }

    #[test]
    fn sun_is_where_the_seasons_put_it() {
        // The equinox of March 2024 was on the 20th at 03:06 UT, by the apparent longitude of date; aberration (20")
        // and precession (24 years, 0.335 deg) separate it from the geometric one of J2000.
        let equinox = SunState::at("2024-03-20T03:06:00 UTC".parse().expect("an epoch"));
        let longitude_deg = equinox.sun.direction().expect("a direction").longitude_rad().to_degrees();
        assert!((longitude_deg - (360.0 - 0.31)).abs() < 0.01, "{longitude_deg}");
        let speed = equinox.earth_velocity.norm_km_s();
        assert!((29.0..30.5).contains(&speed), "{speed}");
    }
}
