//! The stretch of time that is asked about: a night by its evening, or two moments.

use hifitime::Epoch;

use super::error::QuestionError;
use crate::config::{Setup, parse_moment};
use crate::constants::DAY_S;
use crate::frames::seconds_between;
use crate::output::format_utc;
use crate::schedule::{night_of, parse_instant};

/// The longest range that is looked through at once, days: a month.
const LONGEST_DAYS: f64 = 31.0;

/// First and last moment of a night (local mean noon to noon at the setup's site, by the evening's local date), or of what lies between two moments.
///
/// # Errors
/// A night that is no date; no time at all; more than 31 days, or an end before the start.
pub fn time_range(
    night: Option<&str>,
    start: Option<&str>,
    end: Option<&str>,
    setup: &Setup,
) -> Result<(Epoch, Epoch), QuestionError> {
    let (from, to) = match (night, start, end) {
        (Some(night), None, None) => {
            let evening = parse_instant(&format!("{night}T12:00:00Z"), None).map_err(|_| {
                QuestionError::said(format!(
                    "night '{night}' is not a date; allowed: the evening's local date, as 2024-08-14"
                ))
            })?;
            night_of(evening, setup.site()?.longitude_rad)
        }
        (Some(_), ..) => return Err(QuestionError::said("a night and two moments; allowed: one of them")),
        (None, Some(start), Some(end)) => {
            let scale = setup.time_scale()?;
            (parse_moment(start, scale)?, parse_moment(end, scale)?)
        }
        _ => return Err(QuestionError::said("no time; say --night 2024-08-14, or --start and --end")),
    };
    let days = seconds_between(from, to) / DAY_S;
    if !(0.0..=LONGEST_DAYS).contains(&days) {
        let (from, to) = (format_utc(from, 0), format_utc(to, 0));
        return Err(QuestionError::said(format!("{from} to {to}: allowed 0 to 31 days, the end not before the start")));
    }
    Ok((from, to))
}
