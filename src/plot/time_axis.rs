//! Time along an axis: UTC below, local time above, ticks at round clock times.

use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use hifitime::Epoch;

use super::axes::{Axis, Frame, NAME_SIZE, TICK_SIZE};
use super::picture::{INK, Picture, width_of};

const DAY_S: f64 = 86_400.0;
/// Between two ticks, seconds: what clocks are read in.
const STEPS_S: [f64; 18] = [
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 10_800.0,
];
/// Between two labels, pixels.
const ROOM: f64 = 16.0;
/// Times of day have so many seconds' decimals where ticks are closer than a second.
const FINE_DECIMALS: usize = 1;

/// The clock that the upper side is labelled with.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LocalClock<'a> {
    /// Ahead of UTC, hours, -24 to 24.
    pub ahead_of_utc_h: f64,
    /// What it is called: `local mean solar time`, `UTC−4`.
    pub name: &'a str,
}

/// Ticks, labels and the name of the lower side of a frame whose x axis is in days of MJD (UTC).
pub(super) fn draw_utc(picture: &mut Picture, frame: &Frame) {
    let [left, _, right, bottom] = frame.sides;
    for (mjd, label) in ticks(&frame.x, frame.width(), 0.0) {
        let x = frame.at(mjd, frame.y.from).0;
        picture.line(&[(x, bottom), (x, bottom - 6.0)], INK.to_rgba(), 1.2);
        picture.text(&label, (x, bottom + 16.0), TICK_SIZE, HPos::Center);
    }
    let words = format!("UTC, {}", dates(&frame.x, 0.0));
    picture.text(&words, ((left + right) / 2.0, bottom + 42.0), NAME_SIZE, HPos::Center);
}

/// The same of the upper side, by another clock; bare where none is known.
pub(super) fn draw_local(picture: &mut Picture, frame: &Frame, local: Option<&LocalClock<'_>>) {
    let Some(local) = local else { return };
    let [left, top, right, _] = frame.sides;
    for (mjd, label) in ticks(&frame.x, frame.width(), local.ahead_of_utc_h) {
        let x = frame.at(mjd, frame.y.from).0;
        picture.line(&[(x, top), (x, top + 6.0)], INK.to_rgba(), 1.2);
        picture.text(&label, (x, top - 14.0), TICK_SIZE, HPos::Center);
    }
    let words = format!("{}, {}", local.name, dates(&frame.x, local.ahead_of_utc_h));
    picture.text(&words, ((left + right) / 2.0, top - 38.0), NAME_SIZE, HPos::Center);
}

/// Places of round times of a clock on an axis of `length` pixels, with their words.
fn ticks(axis: &Axis, length: f64, ahead_h: f64) -> Vec<(f64, String)> {
    let span_s = (axis.to - axis.from) * DAY_S;
    let needed = |step: f64| width_of(&clock(0.0, step), TICK_SIZE) + ROOM;
    let step = STEPS_S.into_iter().find(|step| step / span_s * length >= needed(*step)).unwrap_or(21_600.0);
    // Seconds of the clock from the midnight before the axis begins: whole numbers stay whole.
    let midnight = (axis.from + ahead_h / 24.0).floor();
    let first = ((axis.from + ahead_h / 24.0 - midnight) * DAY_S / step - 1e-6).ceil() as i64;
    let count = (span_s / step).ceil() as i64 + 1;
    let moment = |n: i64| (midnight + n as f64 * step / DAY_S - ahead_h / 24.0, clock(n as f64 * step, step));
    // The share of days near 60,000 is good to a few bits of a microsecond.
    (first..=first + count).map(moment).filter(|(mjd, _)| (-1e-9..=1.0 + 1e-9).contains(&axis.share(*mjd))).collect()
}

/// Seconds of a day as hours and minutes, with seconds where steps are shorter than a minute.
fn clock(seconds: f64, step: f64) -> String {
    let tenths = (seconds * 10.0).round() as i64 % 864_000;
    let (hours, minutes, rest) = (tenths / 36_000, tenths / 600 % 60, tenths % 600);
    if step >= 60.0 {
        format!("{hours:02}:{minutes:02}")
    } else if step >= 1.0 {
        format!("{hours:02}:{minutes:02}:{:02}", rest / 10)
    } else {
        format!("{hours:02}:{minutes:02}:{:04.FINE_DECIMALS$}", rest as f64 / 10.0)
    }
}

/// The days of an axis: one date, or the first and what of the last is other.
fn dates(axis: &Axis, ahead_h: f64) -> String {
    let day = |mjd: f64| {
        // Noon of the day: a leap second more or less changes nothing.
        let (year, month, day, ..) = Epoch::from_mjd_utc((mjd + ahead_h / 24.0).floor() + 0.5).to_gregorian_utc();
        (year, month, day)
    };
    let (first, last) = (day(axis.from), day(axis.to));
    let words = format!("{:04}-{:02}-{:02}", first.0, first.1, first.2);
    match last {
        _ if last == first => words,
        (year, month, day) if (year, month) == (first.0, first.1) => format!("{words}/{day:02}"),
        (year, month, day) if year == first.0 => format!("{words}/{month:02}-{day:02}"),
        (year, month, day) => format!("{words}/{year:04}-{month:02}-{day:02}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_ticks_stand_at_round_times_of_their_clock() {
        // 2024-08-13T22:30 to 2024-08-14T10:30, MJD of whose midnight is 60536.
        let axis = Axis::linear(60_536.0 - 1.5 / 24.0, 60_536.0 + 10.5 / 24.0);
        let utc = ticks(&axis, 1000.0, 0.0);
        assert_eq!(utc[0].1, "23:00");
        assert!(utc.iter().any(|(mjd, words)| words == "00:00" && (mjd - 60_536.0).abs() < 1e-9));
        // Four hours and 43 minutes behind, midnight is at 04:43 UTC.
        let local = ticks(&axis, 1000.0, -4.0 - 43.0 / 60.0);
        let midnight = local.iter().find(|(_, words)| words == "00:00").unwrap().0;
        assert!((midnight - 60_536.0 - (4.0 + 43.0 / 60.0) / 24.0).abs() < 1e-9);
        assert_eq!(dates(&axis, 0.0), "2024-08-13/14");
        assert_eq!(dates(&Axis::linear(60_309.9, 60_310.2), 0.0), "2023-12-31/2024-01-01");
        assert_eq!(dates(&Axis::linear(60_310.0, 60_310.2), 0.0), "2024-01-01");
    }

    #[test]
    fn verif_ticks_of_short_spans_say_seconds_and_stand_apart() {
        for span_s in [0.8, 3.0, 15.0, 60.0, 400.0, 4000.0, 40_000.0, 86_000.0] {
            let axis = Axis::linear(60_536.0, 60_536.0 + span_s / DAY_S);
            let ticks = ticks(&axis, 800.0, 0.0);
            assert!(ticks.len() > 1, "{span_s}");
            for pair in ticks.windows(2) {
                assert!(pair[0].1 != pair[1].1, "{ticks:?}");
                let apart = (axis.share(pair[1].0) - axis.share(pair[0].0)) * 800.0;
                assert!(apart > width_of(&pair[0].1, TICK_SIZE), "{ticks:?}");
            }
        }
    }
}
