//! Rotations between Earth-fixed, TEME and celestial axes at an epoch.
//!
//! There are two chains of rotations. They agree with those of astropy, and with those of Skyfield within millimetres:
//!
//! ```text
//! GCRS ── IAU 2006/2000A precession-nutation, Earth rotation angle, polar motion ── ITRS      (SOFA c2t06a)
//! TEME ── GMST 1982 ── pseudo Earth-fixed ── polar motion ── ITRS             (Vallado 2006, appendix C)
//! ```
//!
//! The rotation from TEME to GCRS is the second chain followed by the inverse of the first. Polar motion cancels in
//! this product, and UT1 enters only through the slowly changing difference of Greenwich mean sidereal time (GMST 1982)
//! and the Earth rotation angle (ERA). Hence the GCRS positions of satellites hardly depend on the Earth orientation
//! parameters (1 cm), while those of observers do (46 m for 0.1 s of UT1).

use std::f64::consts::TAU;

use hifitime::Epoch;
use nalgebra::Matrix3;

use super::earth_orientation::{EarthOrientationParameters, EopTable};
use super::sampled::Sampled;
use super::time::{seconds_between, tai_minus_utc_s, tt_jd, ut1_jd};
use super::vector::Rotation;
use super::vector::{Eme2000, Gcrs, Itrs, Teme};
use crate::constants::DAY_S;

/// Rotations between the three geocentric frames TEME, GCRS and ITRS at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Orientation {
    /// Rotation from TEME, the axes of SGP4, to the celestial axes.
    pub teme_to_gcrs: Rotation<Teme, Gcrs>,
    /// Rotation from the Earth-fixed axes to TEME.
    pub itrs_to_teme: Rotation<Itrs, Teme>,
    /// Rotation from the Earth-fixed axes to the celestial axes.
    pub itrs_to_gcrs: Rotation<Itrs, Gcrs>,
}

impl Orientation {
    /// Computes the orientation without interpolation (except within the Earth orientation table), in about 40 µs. For
    /// many times use [`OrientationTable`].
    pub fn at(epoch: Epoch, eop: &EopTable) -> Self {
        Self::from_parameters(epoch, &eop.at(epoch))
    }

    /// Same as [`Orientation::at`], with given Earth orientation parameters.
    #[doc(hidden)]
    pub fn from_parameters(epoch: Epoch, parameters: &EarthOrientationParameters) -> Self {
        let (ut1_day, ut1_fraction) = ut1_jd(epoch, parameters.ut1_minus_utc_s);
        let gmst_rad = sofars::erst::gmst82(ut1_day, ut1_fraction);
        Self::compose(
            Rotation::from_matrix(slow_matrix(epoch, parameters.ut1_minus_utc_s)),
            gmst_rad,
            parameters.xp_rad,
            parameters.yp_rad,
        )
    }

    fn compose(teme_to_gcrs: Rotation<Teme, Gcrs>, gmst_rad: f64, xp_rad: f64, yp_rad: f64) -> Self {
        let itrs_to_teme = itrs_to_teme(gmst_rad, xp_rad, yp_rad);
        Self { teme_to_gcrs, itrs_to_teme, itrs_to_gcrs: teme_to_gcrs * itrs_to_teme }
    }
}

/// Returns the rotation from TEME to GCRS, C⁻¹(X, Y, s) R₃(GMST82 - ERA - s'), which contains no polar motion.
///
/// C is the celestial-to-intermediate matrix, W' = W R₃(s') the polar motion of c2t06a, and W the polar motion of the
/// TEME chain. Then
///
/// (W' R₃(ERA) C)⁻¹ W R₃(GMST) = C⁻¹ R₃(-ERA) R₃(-s') R₃(GMST).
fn slow_matrix(epoch: Epoch, ut1_minus_utc_s: f64) -> Matrix3<f64> {
    let (tt_day, tt_fraction) = tt_jd(epoch);
    let (ut1_day, ut1_fraction) = ut1_jd(epoch, ut1_minus_utc_s);
    let celestial_to_intermediate = matrix(&sofars::pnp::c2i06a(tt_day, tt_fraction));
    let angle_rad = sofars::erst::gmst82(ut1_day, ut1_fraction)
        - sofars::erst::era00(ut1_day, ut1_fraction)
        - sofars::pnp::sp00(tt_day, tt_fraction);
    let (sin, cos) = angle_rad.sin_cos();
    celestial_to_intermediate.transpose() * Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// Returns (W R₃(GMST))ᵀ with W = R₁(-yp) R₂(-xp). The angles of W are of order 10⁻⁶ rad; W is expanded to second
/// order.
fn itrs_to_teme(gmst_rad: f64, xp_rad: f64, yp_rad: f64) -> Rotation<Itrs, Teme> {
    let (x, y) = (xp_rad, yp_rad);
    let (cos_x, cos_y) = (1.0 - 0.5 * x * x, 1.0 - 0.5 * y * y);
    // SOFA's pom00 with s' = 0.
    let polar_motion = Matrix3::new(cos_x, 0.0, x, x * y, cos_y, -y * cos_x, -x * cos_y, y, cos_x * cos_y);
    let (sin, cos) = gmst_rad.sin_cos();
    let earth_rotation = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
    Rotation::from_matrix((polar_motion * earth_rotation).transpose())
}

pub(super) fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| rows[row][column])
}

/// Returns the rotation from the mean equator and equinox of J2000 to GCRS: the frame bias of IAU 2000.
pub fn eme2000_to_gcrs() -> Rotation<Eme2000, Gcrs> {
    let (bias, _, _) = sofars::pnp::bp00(2_451_545.0, 0.0);
    Rotation::from_matrix(matrix(&bias).transpose())
}

/// Orientations over an interval: precession and nutation are sampled every half day, and the Earth's rotation is
/// computed for each time.
///
/// Construction takes 40 µs for each half day covered (at least four). The interpolation error is below 10⁻⁹ rad (6 mm
/// at the Earth's surface).
#[derive(Clone, Debug)]
pub struct OrientationTable {
    reference: Epoch,
    /// Elements of the TEME to GCRS matrix, row by row.
    slow: Sampled<9>,
    /// UT1 - TAI minus its value at the reference, seconds; xp and yp, radians.
    eop: Sampled<3>,
    /// GMST at the reference, its rate, and half of its acceleration, by UT1 seconds.
    gmst_rad: f64,
    gmst_rate_rad_s: f64,
    gmst_half_acceleration_rad_s2: f64,
}

impl OrientationTable {
    /// Creates a table from `start` to `end`. Up to half a day beyond either end, the cubics are extrapolated with the
    /// same accuracy.
    ///
    /// Where the Earth orientation table ends within the interval, the step to UT1 = UTC is spread over half a day.
    pub fn new(start: Epoch, end: Epoch, eop: &EopTable) -> Self {
        let slow = Sampled::new(start, end, |epoch| {
            let slow = slow_matrix(epoch, eop.at(epoch).ut1_minus_utc_s);
            std::array::from_fn(|k| slow[(k / 3, k % 3)])
        });
        Self::with_slow(start, end, eop, slow)
    }

    /// Returns a table from `start` to `end`, inside this table's interval, with seconds counted from `start`. This
    /// takes a tenth of the time of [`new`](Self::new), and the two agree within rounding. `eop` must be the table from
    /// which this one was made.
    pub fn part(&self, start: Epoch, end: Epoch, eop: &EopTable) -> Self {
        Self::with_slow(start, end, eop, self.slow.counted_from(seconds_between(self.reference, start)))
    }

    fn with_slow(start: Epoch, end: Epoch, eop: &EopTable, slow: Sampled<9>) -> Self {
        let at_start = eop.at(start);
        let offset_s = at_start.ut1_minus_utc_s - tai_minus_utc_s(start);
        let parameters = Sampled::new(start, end, |epoch| {
            let parameters = eop.at(epoch);
            [parameters.ut1_minus_utc_s - tai_minus_utc_s(epoch) - offset_s, parameters.xp_rad, parameters.yp_rad]
        });
        // GMST82 in seconds of time, T in Julian centuries of UT1 since J2000 (Aoki 1982), plus the turn since 0h UT1:
        // 24110.54841 + 8640184.812866 T + 0.093104 T² - 6.2e-6 T³ + 86400 (UT1 day fraction)
        let (ut1_day, ut1_fraction) = ut1_jd(start, at_start.ut1_minus_utc_s);
        let century_s = 36_525.0 * DAY_S;
        let t = ((ut1_day - 2_451_545.0) + ut1_fraction) / 36_525.0;
        let rate = 1.0 + (8_640_184.812_866 + 2.0 * 0.093_104 * t - 3.0 * 6.2e-6 * t * t) / century_s;
        let half_acceleration = (0.093_104 - 3.0 * 6.2e-6 * t) / (century_s * century_s);
        Self {
            reference: start,
            slow,
            eop: parameters,
            gmst_rad: sofars::erst::gmst82(ut1_day, ut1_fraction),
            gmst_rate_rad_s: rate * TAU / DAY_S,
            gmst_half_acceleration_rad_s2: half_acceleration * TAU / DAY_S,
        }
    }

    /// Returns the epoch from which seconds are counted: the `start` given to the constructor.
    pub fn reference(&self) -> Epoch {
        self.reference
    }

    /// Returns the orientation at a time after the reference, in SI seconds (leap seconds included); takes about 0.1 µs
    /// and allocates nothing.
    pub fn at_s(&self, seconds_after_reference: f64) -> Orientation {
        let [ut1_drift_s, xp_rad, yp_rad] = self.eop.linear_at(seconds_after_reference);
        let ut1_s = seconds_after_reference + ut1_drift_s;
        let gmst_rad = self.gmst_rad + (self.gmst_rate_rad_s + self.gmst_half_acceleration_rad_s2 * ut1_s) * ut1_s;
        let slow = Matrix3::from_row_slice(&self.slow.cubic_at(seconds_after_reference));
        Orientation::compose(Rotation::from_matrix(slow), gmst_rad, xp_rad, yp_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Position, seconds_after};

    /// Tolerance stated in the docs of [`OrientationTable`].
    const TABLE_TOLERANCE_RAD: f64 = 1e-9;

    fn largest_difference(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
        (a - b).abs().max()
    }

    #[test]
    fn verif_table_against_exact() {
        let eop = EopTable::embedded();
        // One night, and an interval over the leap second of 2016 with the Moon's terms in all phases.
        for (start, days) in
            [("2024-08-13T23:17:11 UTC", 0.4), ("2016-12-20T05:00:00 UTC", 40.0), ("2020-02-01T00:00:00 UTC", 400.0)]
        {
            let start: Epoch = start.parse().expect("an epoch");
            let table = OrientationTable::new(start, seconds_after(start, days * DAY_S), &eop);
            assert_eq!(table.reference(), start);
            for step in 0..=500 {
                let seconds = days * DAY_S * f64::from(step) / 500.0;
                let exact = Orientation::at(seconds_after(start, seconds), &eop);
                let sampled = table.at_s(seconds);
                for (what, error) in [
                    ("TEME to GCRS", largest_difference(exact.teme_to_gcrs.matrix(), sampled.teme_to_gcrs.matrix())),
                    ("ITRS to TEME", largest_difference(exact.itrs_to_teme.matrix(), sampled.itrs_to_teme.matrix())),
                    ("ITRS to GCRS", largest_difference(exact.itrs_to_gcrs.matrix(), sampled.itrs_to_gcrs.matrix())),
                    (
                        "orthogonality",
                        largest_difference(
                            &(sampled.teme_to_gcrs.matrix().transpose() * sampled.teme_to_gcrs.matrix()),
                            &Matrix3::identity(),
                        ),
                    ),
                ] {
                    assert!(error < TABLE_TOLERANCE_RAD, "{what} {seconds} s after {start}: {error}");
                }
            }
        }
    }

    #[test]
    fn verif_parts_are_tables() {
        let eop = EopTable::embedded();
        for day in ["2024-08-13T00:00:00 UTC", "2016-12-30T00:00:00 UTC"] {
            let day: Epoch = day.parse().expect("an epoch");
            let whole = OrientationTable::new(day, seconds_after(day, 3.0 * DAY_S), &eop);
            for hours in [0.0, 11.99, 23.9, 40.1] {
                let start = seconds_after(day, hours * 3600.0);
                let end = seconds_after(start, 30_000.0);
                let (part, separate) = (whole.part(start, end, &eop), OrientationTable::new(start, end, &eop));
                assert_eq!(part.reference(), start);
                for seconds in [0.0, 777.7, 30_000.0] {
                    let (part, separate) = (part.at_s(seconds).itrs_to_gcrs, separate.at_s(seconds).itrs_to_gcrs);
                    let difference = largest_difference(part.matrix(), separate.matrix());
                    // Over a leap second the nodes are a second apart: two interpolations of the same function.
                    assert!(difference < TABLE_TOLERANCE_RAD, "{day} {hours} h {seconds} s: {difference}");
                }
            }
        }
    }

    #[test]
    fn whole_chain_is_c2t06a() {
        let epoch: Epoch = "2022-05-06T07:08:09 UTC".parse().expect("an epoch");
        let eop = EopTable::embedded();
        let parameters = eop.at(epoch);
        let ((tt1, tt2), (ut1, ut2)) = (tt_jd(epoch), ut1_jd(epoch, parameters.ut1_minus_utc_s));
        let celestial_to_terrestrial =
            matrix(&sofars::pnp::c2t06a(tt1, tt2, ut1, ut2, parameters.xp_rad, parameters.yp_rad));
        let computed = Orientation::at(epoch, &eop);
        assert!(largest_difference(&celestial_to_terrestrial.transpose(), computed.itrs_to_gcrs.matrix()) < 1e-14);
    }

    #[test]
    fn polar_motion_and_ut1_leave_satellites_among_the_stars() {
        let epoch: Epoch = "2022-05-06T07:08:09 UTC".parse().expect("an epoch");
        let without = Orientation::at(epoch, &EopTable::none());
        let with = Orientation::at(epoch, &EopTable::embedded());
        let satellite = Position::<Teme>::new(7000.0, 0.0, 0.0);
        let moved_km = (with.teme_to_gcrs * satellite - without.teme_to_gcrs * satellite).norm_km();
        assert!(moved_km < 1e-5, "{moved_km}");
        let site = Position::<Itrs>::new(6378.0, 0.0, 0.0);
        let moved_km = (with.itrs_to_gcrs * site - without.itrs_to_gcrs * site).norm_km();
        assert!(moved_km > 1e-3, "{moved_km}");
    }
}
