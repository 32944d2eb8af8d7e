//! One instant of a header, with the part of the exposure to which it refers.

use hifitime::Epoch;

use super::comment::Role;
use super::moment::{date_and_time, without_offset};

/// One instant of a header.
pub struct Instant {
    pub epoch: Epoch,
    /// Keyword, or several keywords joined.
    pub from: String,
    /// Its value as written.
    pub value: String,
    /// Rounding error of its digits, or the uncertainty that its comment states, seconds.
    pub slack_s: f64,
    pub role: Role,
    /// True for keywords that are used only if no other keyword gives the start.
    pub is_loose: bool,
    /// True for a time of day in a keyword such as UT beside a date, whose comment does not state the start. It may be
    /// later than the start in another keyword.
    pub is_loose_clock: bool,
    /// Beginning of the day of a date in another keyword, and the part of the exposure to which the date belongs by its
    /// comment.
    pub day: Option<(Epoch, Option<Role>)>,
    /// True if the name of the keyword or its comment states the part of the exposure.
    pub is_role_stated: bool,
    /// True for an end whose comment states the end of the observation, perhaps with the readout.
    pub is_of_observation: bool,
}

impl Instant {
    pub fn new(epoch: Epoch, from: String, role: Role) -> Self {
        Self {
            epoch,
            from,
            value: String::new(),
            slack_s: 0.0,
            role,
            is_loose: false,
            is_loose_clock: false,
            day: None,
            is_role_stated: false,
            is_of_observation: false,
        }
    }

    /// Returns the last digit of the seconds of a date and time or a time of day, seconds; 0 for a number of days.
    pub fn step_s(&self) -> f64 {
        // "031500" is a time.
        let whole = self.value.split('.').next().unwrap_or_default();
        if self.value.parse::<f64>().is_ok() && whole.len() != 6 {
            return 0.0;
        }
        let (day, clock) = date_and_time(without_offset(&self.value).0);
        let clock = clock.unwrap_or(day);
        let clock = clock.trim_end_matches(|c: char| !c.is_ascii_digit());
        let decimals = clock.rsplit_once(['.', ',']).map_or("", |(_, decimals)| decimals);
        // "03.15.00"
        let is_fraction = clock.matches(['.', ',']).count() == 1 && decimals.bytes().all(|byte| byte.is_ascii_digit());
        if is_fraction { 10f64.powi(-(decimals.len() as i32)) } else { 1.0 }
    }

    /// Returns true for a number of days, such as a modified Julian date.
    pub fn is_days(&self) -> bool {
        self.step_s() == 0.0
    }
}
