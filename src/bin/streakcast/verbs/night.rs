//! The stretch of time that a verb asks about: a night by its evening, or two moments.

use hifitime::Epoch;
use streakcast::config::Setup;
use streakcast::config::time_range;

/// First and last moment.
pub fn range(
    night: Option<&str>,
    start: Option<&str>,
    end: Option<&str>,
    setup: &Setup,
) -> anyhow::Result<(Epoch, Epoch)> {
    Ok(time_range(night, start, end, setup)?)
}
