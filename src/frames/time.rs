//! Conversions between `hifitime` epochs and the Julian dates of astronomical routines.
//!
//! An [`Epoch`] counts nanoseconds as an integer. A Julian date in one `f64` loses 40 µs, so Julian dates are returned
//! in two parts: a whole number of days plus a half, and the fraction of the day (resolution 10⁻¹¹ s).

use hifitime::{Duration, Epoch, TimeScale};

use super::error;
use crate::error::Error;

/// Julian date of 1900-01-01T00:00:00, the zero of `hifitime`'s TAI, TT and UTC counts.
const JD_1900: f64 = 2_415_020.5;
/// Modified Julian date of 1900-01-01.
const MJD_1900: i64 = 15_020;
/// Nanoseconds in a day.
const DAY_NS: i128 = 86_400_000_000_000;
/// TT - TAI, nanoseconds (by definition).
const TT_MINUS_TAI_NS: i128 = 32_184_000_000;
/// TAI - GPS time, and TAI - BeiDou time, nanoseconds (by definition).
const GPS_LAG_NS: i128 = 19_000_000_000;
const BEIDOU_LAG_NS: i128 = 33_000_000_000;
/// Nanoseconds from 1900-01-01T00:00:00 to 2000-01-01T12:00:00.
const J2000_NS: i128 = 36_524 * DAY_NS + DAY_NS / 2;
/// Accepted modified Julian dates, 1900-01-01 to 2199-12-31. A number outside this range is almost certainly in another
/// unit.
const MJD_RANGE: (f64, f64) = (15_020.0, 124_593.0);
/// Julian date of MJD 0.
const MJD_ZERO_JD: f64 = 2_400_000.5;

/// Returns the two-part Julian date in TT.
pub fn tt_jd(epoch: Epoch) -> (f64, f64) {
    split_days(tai_ns(epoch) + TT_MINUS_TAI_NS)
}

/// Returns the two-part Julian date in UT1, from UT1 - UTC in seconds at the epoch.
pub fn ut1_jd(epoch: Epoch, ut1_minus_utc_s: f64) -> (f64, f64) {
    let (day, fraction) = split_days(tai_ns(epoch));
    (day, fraction + (ut1_minus_utc_s - tai_minus_utc_s(epoch)) / crate::constants::DAY_S)
}

/// Returns the two-part Julian date in UTC. During a leap second it repeats the first second of the next day, as the
/// UTC count of `hifitime` does.
pub fn utc_jd(epoch: Epoch) -> (f64, f64) {
    split_days(epoch.to_duration_in_time_scale(TimeScale::UTC).total_nanoseconds())
}

/// Returns the modified Julian date in UTC as one number, accurate to 1 µs; meant for tables and messages.
pub fn mjd_utc(epoch: Epoch) -> f64 {
    let (day, fraction) = utc_jd(epoch);
    (day - MJD_ZERO_JD) + fraction
}

/// Returns TAI - UTC, seconds: the number of leap seconds inserted so far, and 0 before 1972.
pub fn tai_minus_utc_s(epoch: Epoch) -> f64 {
    f64::from(epoch.leap_seconds_iers())
}

/// Returns the end of the interval for which the built-in list of leap seconds is known to be complete. IERS Bulletin C
/// 72 of July 2026 announces no leap second for the end of 2026, and the table made from it expires on 28 June 2027.
pub fn leap_seconds_known_until() -> Epoch {
    Epoch::from_gregorian_utc_at_midnight(2027, 6, 28)
}

/// Returns the SI seconds from `earlier` to `later`, leap seconds counted.
///
/// Subtracting two UTC epochs in `hifitime` omits the leap seconds between them.
pub fn seconds_between(earlier: Epoch, later: Epoch) -> f64 {
    let difference_ns = tai_ns(later) - tai_ns(earlier);
    let whole_s = difference_ns.div_euclid(1_000_000_000);
    let rest_ns = difference_ns.rem_euclid(1_000_000_000);
    whole_s as f64 + rest_ns as f64 * 1e-9
}

/// Returns the epoch `seconds` (SI) after another one, rounded to the nanosecond, in the same time scale. In the 36 s
/// before a leap second the result is in TAI, because hifitime's conversion from TAI to UTC is off by one second there.
pub fn seconds_after(epoch: Epoch, seconds: f64) -> Epoch {
    let whole_s = seconds.floor();
    let rest_ns = ((seconds - whole_s) * 1e9).round();
    let step = Duration::from_total_nanoseconds(whole_s as i128 * 1_000_000_000 + rest_ns as i128);
    let later = epoch.to_time_scale(TimeScale::TAI) + step;
    let back = later.to_time_scale(epoch.time_scale);
    if tai_ns(back) == tai_ns(later) { back } else { later }
}

/// Returns the epoch of a modified Julian date. The scale must be given, because TAI read as UTC is wrong by 37 s, in
/// which a satellite moves by 280 km.
///
/// # Errors
/// A number that is not finite or outside 1900..2200, or an unsupported time scale (TCG, TCB).
pub fn epoch_from_mjd(mjd: f64, scale: TimeScale) -> Result<Epoch, Error> {
    let (first, last) = MJD_RANGE;
    if !(first..=last).contains(&mjd) {
        return Err(Error::invalid("MJD", mjd, format!("{first} to {last}")));
    }
    from_day_and_fraction(mjd.floor() as i64, mjd - mjd.floor(), scale)
        .ok_or_else(|| error::unsupported_time_scale(scale))
}

/// Returns the epoch of a Julian date. The resolution of one `f64` is 40 µs, or 30 cm along a satellite's track.
///
/// # Errors
/// A number that is not finite or outside 1900..2200, or an unsupported time scale (TCG, TCB).
pub fn epoch_from_jd(jd: f64, scale: TimeScale) -> Result<Epoch, Error> {
    let (first, last) = (MJD_RANGE.0 + MJD_ZERO_JD, MJD_RANGE.1 + MJD_ZERO_JD);
    if !(first..=last).contains(&jd) {
        return Err(Error::invalid("JD", jd, format!("{first} to {last}")));
    }
    let mjd = jd - MJD_ZERO_JD;
    from_day_and_fraction(mjd.floor() as i64, mjd - mjd.floor(), scale)
        .ok_or_else(|| error::unsupported_time_scale(scale))
}

/// Returns nanoseconds since 1900-01-01T00:00:00 TAI.
pub(crate) fn tai_ns(epoch: Epoch) -> i128 {
    epoch.to_tai_duration().total_nanoseconds()
}

/// Returns 0h UTC of a whole modified Julian date.
pub(crate) fn epoch_from_utc_day(mjd: i64) -> Epoch {
    Epoch::from_duration(Duration::from_total_nanoseconds(i128::from(mjd - MJD_1900) * DAY_NS), TimeScale::UTC)
}

fn from_day_and_fraction(mjd: i64, fraction: f64, scale: TimeScale) -> Option<Epoch> {
    let since_1900_ns = i128::from(mjd - MJD_1900) * DAY_NS + (fraction * DAY_NS as f64).round() as i128;
    let count = |scale, nanoseconds| Epoch::from_duration(Duration::from_total_nanoseconds(nanoseconds), scale);
    Some(match scale {
        // These three scales count from 1900-01-01T00:00:00 in their own time.
        TimeScale::UTC | TimeScale::TAI | TimeScale::TT => count(scale, since_1900_ns),
        TimeScale::GPST | TimeScale::QZSST | TimeScale::GST => count(TimeScale::TAI, since_1900_ns + GPS_LAG_NS),
        TimeScale::BDT => count(TimeScale::TAI, since_1900_ns + BEIDOU_LAG_NS),
        // These count from 2000-01-01T12:00:00.
        TimeScale::TDB | TimeScale::ET => count(scale, since_1900_ns - J2000_NS),
        _ => return None,
    })
}

fn split_days(nanoseconds: i128) -> (f64, f64) {
    let day = nanoseconds.div_euclid(DAY_NS);
    let rest = nanoseconds.rem_euclid(DAY_NS);
    (JD_1900 + day as f64, rest as f64 / DAY_NS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utc(text: &str) -> Epoch {
        text.parse().expect("an epoch")
    }

    /// Steps through a leap second and through the 36 s before it have the requested length, zero included.
    #[test]
    fn verif_steps_through_a_leap_second() {
        for second in [0, 20, 30, 45, 59] {
            let start = Epoch::from_gregorian_utc(2016, 12, 31, 23, 59, second, 500_000_000);
            for step_s in [0.0, 0.25, 11.0, 40.0, 3600.0] {
                let later = seconds_after(start, step_s);
                assert_eq!(seconds_between(start, later), step_s, "{second} {step_s}");
            }
            assert_eq!(seconds_after(start, 0.0), start);
        }
    }

    #[test]
    fn julian_dates_of_known_days() {
        // J2000.0 is JD 2451545.0 TT.
        let j2000 = Epoch::from_gregorian(2000, 1, 1, 12, 0, 0, 0, TimeScale::TT);
        assert_eq!(tt_jd(j2000), (2_451_544.5, 0.5));
        // 2017-01-01T00:00:00 UTC: TAI - UTC became 37 s.
        let new_year = utc("2017-01-01T00:00:00 UTC");
        assert_eq!(tai_minus_utc_s(new_year), 37.0);
        assert_eq!(utc_jd(new_year), (2_457_754.5, 0.0));
        assert_eq!(mjd_utc(new_year), 57_754.0);
        let (day, fraction) = ut1_jd(new_year, 0.5);
        assert!(((day - 2_457_754.5) + (fraction - 0.5 / 86_400.0)).abs() < 1e-15);
    }

    #[test]
    fn leap_second_counts_as_one() {
        let before = utc("2016-12-31T23:59:59 UTC");
        let after = utc("2017-01-01T00:00:00 UTC");
        assert_eq!(seconds_between(before, after), 2.0);
        assert_eq!(seconds_after(before, 2.0), after);
        assert_eq!(seconds_between(after, before), -2.0);
    }

    #[test]
    fn mjd_keeps_the_microsecond_in_every_scale() {
        for scale in [TimeScale::UTC, TimeScale::TAI, TimeScale::TT] {
            let epoch = epoch_from_mjd(60_535.970_123_456_78, scale).expect("a date");
            let back = epoch.to_duration_in_time_scale(scale).total_nanoseconds() as f64 / DAY_NS as f64 + 15_020.0;
            assert!((back - 60_535.970_123_456_78).abs() * 86_400.0 < 1e-6, "{scale}");
        }
        let utc = epoch_from_mjd(60_000.0, TimeScale::UTC).expect("a date");
        let tai = epoch_from_mjd(60_000.0, TimeScale::TAI).expect("a date");
        assert_eq!(seconds_between(tai, utc), 37.0);
        assert_eq!(utc, epoch_from_jd(2_460_000.5, TimeScale::UTC).expect("a date"));
        let gps = epoch_from_mjd(60_000.25, TimeScale::GPST).expect("a date");
        let tdb = epoch_from_mjd(60_000.25, TimeScale::TDB).expect("a date");
        let tt = epoch_from_mjd(60_000.25, TimeScale::TT).expect("a date");
        assert!(seconds_between(tdb, tt).abs() < 0.002);
        assert_eq!(seconds_between(epoch_from_mjd(60_000.25, TimeScale::TAI).expect("a date"), gps), 19.0);
    }

    #[test]
    fn numbers_that_are_no_dates() {
        for value in [f64::NAN, f64::INFINITY, 0.0, 2_460_000.5] {
            assert!(epoch_from_mjd(value, TimeScale::UTC).is_err(), "{value}");
        }
        assert!(epoch_from_jd(60_000.0, TimeScale::UTC).is_err());
    }
}
