//! The stretch of time that a verb asks about: a night by its evening, or two moments.

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::frames::seconds_between;
use streakcast::schedule::{night_of, parse_instant};
use streakcast::setup::{Setup, parse_moment};
use streakcast::table::format_utc;

/// The longest range that is looked through at once, seconds: a month.
const LONGEST_RANGE_S: f64 = 31.0 * 86_400.0;

/// First and last moment.
pub fn range(
    night: Option<&str>,
    start: Option<&str>,
    end: Option<&str>,
    setup: &Setup,
) -> anyhow::Result<(Epoch, Epoch)> {
    let (from, to) = match (night, start, end) {
        (Some(night), ..) => {
            let evening = parse_instant(&format!("{night}T12:00:00Z"), None).map_err(|_| {
                anyhow!("night '{night}' is not a date; allowed: the evening's local date, as 2024-08-14")
            })?;
            night_of(evening, setup.site()?.longitude_rad)
        }
        (None, Some(start), Some(end)) => {
            let scale = setup.time_scale()?;
            (parse_moment(start, scale)?, parse_moment(end, scale)?)
        }
        _ => return Err(anyhow!("no time; say --night 2024-08-14, or --start and --end")),
    };
    let length_s = seconds_between(from, to);
    if !(0.0..=LONGEST_RANGE_S).contains(&length_s) {
        let (from, to) = (format_utc(from, 0), format_utc(to, 0));
        return Err(anyhow!("{from} to {to}: allowed 0 to 31 days, the end not before the start"));
    }
    Ok((from, to))
}
