//! Text forms of times and counts.

use hifitime::{Duration, Epoch, TimeScale};

const NANOSECONDS_PER_SECOND: i128 = 1_000_000_000;
const SECONDS_PER_DAY: i128 = 86_400;
/// Days from 1900-01-01, the origin of hifitime's TAI and UTC, to 1970-01-01.
const DAYS_1900_TO_1970: i128 = 25_567;

/// Formats a time as UTC, `2024-08-14T00:30:00.000Z`, rounded to `decimals` digits of the second (at most 9).
///
/// During a leap second the field of seconds is 60, as ISO 8601 requires.
pub fn format_utc(epoch: Epoch, decimals: usize) -> String {
    let decimals = decimals.min(9);
    let step = 10_i128.pow(9 - decimals as u32);
    let tai_ns = epoch.to_duration_in_time_scale(TimeScale::TAI).total_nanoseconds();
    let tai_ns = (tai_ns + step / 2).div_euclid(step) * step;
    let (utc_ns, inside_leap_second) = utc_from_tai(tai_ns);
    let (seconds, nanoseconds) = (utc_ns.div_euclid(NANOSECONDS_PER_SECOND), utc_ns.rem_euclid(NANOSECONDS_PER_SECOND));
    let (days, second_of_day) = (seconds.div_euclid(SECONDS_PER_DAY), seconds.rem_euclid(SECONDS_PER_DAY));
    let (year, month, day) = civil_from_days(days - DAYS_1900_TO_1970);
    let (hour, minute) = (second_of_day / 3600, second_of_day / 60 % 60);
    let second = second_of_day % 60 + i128::from(inside_leap_second);
    let fraction = if decimals == 0 { String::new() } else { format!(".{:0decimals$}", nanoseconds / step) };
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{fraction}Z")
}

/// Converts nanoseconds of TAI since 1900 to nanoseconds of UTC. During a leap second it returns the nanoseconds of the
/// second before, and true.
///
/// In this direction hifitime changes TAI-UTC up to 37 s too early, because it compares TAI with a table in UTC. The
/// result is therefore checked, and corrected if necessary, with the conversion from UTC to TAI, which is correct.
fn utc_from_tai(tai_ns: i128) -> (i128, bool) {
    let tai = Epoch::from_duration(Duration::from_total_nanoseconds(tai_ns), TimeScale::TAI);
    let guess_ns = tai.to_duration_in_time_scale(TimeScale::UTC).total_nanoseconds();
    let later_ns = guess_ns + NANOSECONDS_PER_SECOND;
    if tai_from_utc(guess_ns) == tai_ns {
        (guess_ns, false)
    } else {
        (if tai_from_utc(later_ns) == tai_ns { later_ns } else { guess_ns }, tai_from_utc(later_ns) != tai_ns)
    }
}

fn tai_from_utc(utc_ns: i128) -> i128 {
    let utc = Epoch::from_duration(Duration::from_total_nanoseconds(utc_ns), TimeScale::UTC);
    utc.to_duration_in_time_scale(TimeScale::TAI).total_nanoseconds()
}

/// Returns the Gregorian date of a day counted from 1970-01-01 (Hinnant, "chrono-compatible low-level date
/// algorithms").
fn civil_from_days(days: i128) -> (i128, i128, i128) {
    let z = days + 719_468;
    let era = z.div_euclid(146_097);
    let day_of_era = z.rem_euclid(146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 { shifted_month + 3 } else { shifted_month - 9 };
    (year_of_era + era * 400 + i128::from(month <= 2), month, day)
}

/// Formats a count with the singular or the plural of its noun: `1 pass`, `2 passes`.
pub fn counted(count: usize, singular: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { singular } else { many })
}

#[cfg(test)]
mod tests {
    use hifitime::Unit;

    use super::*;

    #[test]
    fn moments_are_rounded_and_carried() {
        let epoch = Epoch::from_gregorian_utc(2024, 12, 31, 23, 59, 59, 999_600_000);
        assert_eq!(format_utc(epoch, 3), "2025-01-01T00:00:00.000Z");
        assert_eq!(format_utc(epoch, 6), "2024-12-31T23:59:59.999600Z");
        assert_eq!(format_utc(epoch, 0), "2025-01-01T00:00:00Z");
        assert_eq!(format_utc(epoch.to_time_scale(TimeScale::TT), 6), "2024-12-31T23:59:59.999600Z");
    }

    #[test]
    fn dates_agree_with_hifitime() {
        for day in (-20_000..80_000).step_by(37) {
            let epoch = Epoch::from_duration(Unit::Day * i64::from(day) + Unit::Second * 45_296_i64, TimeScale::UTC);
            let (year, month, date, hour, minute, second, _) = epoch.to_gregorian_utc();
            let expected = format!("{year:04}-{month:02}-{date:02}T{hour:02}:{minute:02}:{second:02}Z");
            assert_eq!(format_utc(epoch, 0), expected);
        }
    }

    #[test]
    fn a_leap_second_reads_sixty() {
        let last = Epoch::from_gregorian_utc(2016, 12, 31, 23, 59, 59, 500_000_000).to_time_scale(TimeScale::TAI);
        assert_eq!(format_utc(last, 1), "2016-12-31T23:59:59.5Z");
        assert_eq!(format_utc(last - Unit::Second * 20_i64, 1), "2016-12-31T23:59:39.5Z");
        assert_eq!(format_utc(last + Unit::Second * 1_i64, 1), "2016-12-31T23:59:60.5Z");
        assert_eq!(format_utc(last + Unit::Second * 2_i64, 1), "2017-01-01T00:00:00.5Z");
    }

    #[test]
    fn one_is_singular() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "pass", "passes")), ["0 passes", "1 pass", "2 passes"]);
    }
}
