//! Start and end in seconds or days since a reference time: TSTART and TSTOP (FITS standard 4.0, section 9).

use hifitime::{Epoch, TimeScale};

use crate::constants::DAY_S;
use crate::frames::{epoch_from_mjd, seconds_after};

use super::comment::{Comment, Role, seconds_in};
use super::moment::Keywords;

const START: &str = "TSTART";
const STOP: &str = "TSTOP";
/// Corrections of the clock of Swift, with which its times are to be used.
const CLOCK_CORRECTIONS: &[&str] = &["UTCFINIT", "UTCF"];

/// Start and end since a reference time, in an unknown unit if `unit_s` is `None`.
pub struct RelativeTimes {
    start: f64,
    stop: f64,
    unit_s: Option<f64>,
}

impl RelativeTimes {
    pub fn read(keywords: Keywords<'_>) -> Option<Self> {
        let (_, start, comment) = keywords.number(&[START], |_| true)?;
        let (_, stop, _) = keywords.number(&[STOP], |stop| stop > start)?;
        let of_comment = || Comment::new(&comment).unit_s().ok().flatten();
        let unit_s = keywords.text(&["TIMEUNIT"]).and_then(|(_, unit)| seconds_in(&unit)).or_else(of_comment);
        // The unit of the standard.
        let unit_s = unit_s.or_else(|| reference(keywords).map(|_| 1.0));
        Some(Self { start, stop, unit_s })
    }

    /// Returns the times from start to end that the numbers may be, seconds.
    pub fn spans_s(&self) -> Vec<f64> {
        let units_s = self.unit_s.map_or_else(|| vec![1.0, 60.0, 3600.0, DAY_S], |unit_s| vec![unit_s]);
        // Rounded to 1 us: numbers since a reference have few digits left.
        units_s.into_iter().map(|unit_s| ((self.stop - self.start) * unit_s * 1e6).round() / 1e6).collect()
    }

    pub fn has_unit(&self) -> bool {
        self.unit_s.is_some()
    }
}

/// Returns MJDREF, or the sum of its whole and its fractional part.
fn reference(keywords: Keywords<'_>) -> Option<f64> {
    let number = |name: &str| keywords.number(&[name], |_| true).map(|(_, number, _)| number);
    number("MJDREF").or_else(|| Some(number("MJDREFI")? + number("MJDREFF").unwrap_or(0.0)))
}

/// Returns start and end since MJDREF, with TIMEZERO.
pub fn relative_instants(keywords: Keywords<'_>, scale: TimeScale) -> Vec<(Epoch, &'static str, Role)> {
    let found = || -> Option<Vec<(Epoch, &'static str, Role)>> {
        let times = RelativeTimes::read(keywords)?;
        let unit_s = times.unit_s.filter(|_| keywords.number(CLOCK_CORRECTIONS, |_| true).is_none())?;
        let zero = epoch_from_mjd(reference(keywords)?, scale).ok()?;
        let shift = keywords.number(&["TIMEZERO"], |_| true).map_or(0.0, |(_, shift, _)| shift);
        // Three thousand years
        const MOST_S: f64 = 1e11;
        let at = |number: f64| {
            let seconds = (number + shift) * unit_s;
            (seconds.abs() < MOST_S).then(|| seconds_after(zero, seconds))
        };
        Some(vec![(at(times.start)?, START, Role::Start), (at(times.stop)?, STOP, Role::End)])
    };
    found().unwrap_or_default()
}
