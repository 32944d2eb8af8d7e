//! Exposure times and calibrations read from headers of observatories.

mod calibration;
mod comments;
mod doubts;
mod lengths;
mod starts;

use hifitime::Epoch;
use streakcast::frames::seconds_between;
use streakcast::images::{ExposureTime, Header};

fn time(text: &str) -> Result<ExposureTime, String> {
    ExposureTime::from_headers(&[&Header::from_text(text)]).map_err(|error| error.to_string())
}

#[track_caller]
fn begins(text: &str, utc: &str, from: &str) {
    let found = time(text).unwrap_or_else(|error| panic!("{error}"));
    let expected: Epoch = format!("{utc} UTC").parse().expect("a moment");
    // One microsecond is the resolution of days in one f64.
    assert!(seconds_between(expected, found.start).abs() < 1e-6, "{} is not {utc}", found.start);
    assert_eq!(found.start_from, from);
}

const LENGTH: &str = "EXPTIME =                 60.0\n";
