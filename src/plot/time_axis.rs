//! Time axes with UTC below and local time above, and coloured bands behind a chart for day, the three twilights and
//! night.

use hifitime::Epoch;
use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame, NAME_SIZE, TICK_SIZE};
use super::picture::{INK, Picture, width_of};

const DAY_S: f64 = 86_400.0;
/// Possible steps between two ticks, seconds.
const STEPS_S: [f64; 18] = [
    0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 1800.0, 3600.0, 7200.0, 10_800.0,
];
/// Smallest gap between two labels, pixels.
const LABEL_GAP: f64 = 16.0;
/// Decimals of seconds if ticks are less than a second apart.
const FINE_DECIMALS: usize = 1;

/// Clock of the upper axis.
#[derive(Clone, Debug, PartialEq)]
pub struct LocalClock {
    /// Hours ahead of UTC, -24 to 24.
    pub ahead_of_utc_h: f64,
    /// Name, for example `local mean solar time` or `UTC−4`.
    pub name: String,
}

/// Draws the ticks, the labels and the name of the lower side of a box whose x axis is MJD (UTC), days.
pub(super) fn draw_utc(picture: &mut Picture, frame: &Frame) {
    let [left, _, right, bottom] = frame.sides;
    for (mjd, label) in ticks(&frame.x, frame.width(), 0.0) {
        let x = frame.at(mjd, frame.y.from).0;
        picture.line(&[(x, bottom), (x, bottom - 6.0)], INK.to_rgba(), 1.2);
        picture.text(&label, (x, bottom + 16.0), TICK_SIZE, HPos::Center);
    }
    let text = format!("UTC, {}", dates(&frame.x, 0.0));
    picture.text(&text, ((left + right) / 2.0, bottom + 42.0), NAME_SIZE, HPos::Center);
}

/// Draws the upper side of a box with ticks of another clock; draws nothing if there is none.
pub(super) fn draw_local(picture: &mut Picture, frame: &Frame, local: Option<&LocalClock>) {
    let Some(local) = local else { return };
    let [left, top, right, _] = frame.sides;
    for (mjd, label) in ticks(&frame.x, frame.width(), local.ahead_of_utc_h) {
        let x = frame.at(mjd, frame.y.from).0;
        picture.line(&[(x, top), (x, top + 6.0)], INK.to_rgba(), 1.2);
        picture.text(&label, (x, top - 14.0), TICK_SIZE, HPos::Center);
    }
    let text = format!("{}, {}", local.name, dates(&frame.x, local.ahead_of_utc_h));
    picture.text(&text, ((left + right) / 2.0, top - 38.0), NAME_SIZE, HPos::Center);
}

/// Returns the round times of a clock on an axis of `length` pixels, as positions and labels.
fn ticks(axis: &Axis, length: f64, ahead_h: f64) -> Vec<(f64, String)> {
    let span_s = (axis.to - axis.from) * DAY_S;
    let needed = |step: f64| width_of(&clock(0.0, step), TICK_SIZE) + LABEL_GAP;
    let step = STEPS_S.into_iter().find(|step| step / span_s * length >= needed(*step)).unwrap_or(21_600.0);
    // Seconds are counted from the midnight of the clock before the start of the axis, so that round times are integer
    // multiples of the step.
    let midnight = (axis.from + ahead_h / 24.0).floor();
    let first = ((axis.from + ahead_h / 24.0 - midnight) * DAY_S / step - 1e-6).ceil() as i64;
    let count = (span_s / step).ceil() as i64 + 1;
    let moment = |n: i64| (midnight + n as f64 * step / DAY_S - ahead_h / 24.0, clock(n as f64 * step, step));
    // Fractions of a day near MJD 60,000 are accurate to less than a microsecond.
    (first..=first + count).map(moment).filter(|(mjd, _)| (-1e-9..=1.0 + 1e-9).contains(&axis.share(*mjd))).collect()
}

/// Formats seconds of a day as hours and minutes, with seconds for steps shorter than a minute.
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

/// Formats the dates of an axis: one date, or the first date and the part of the last date that differs.
fn dates(axis: &Axis, ahead_h: f64) -> String {
    let day = |mjd: f64| {
        // Noon of the day is used, so that a leap second has no effect.
        let (year, month, day, ..) = Epoch::from_mjd_utc((mjd + ahead_h / 24.0).floor() + 0.5).to_gregorian_utc();
        (year, month, day)
    };
    let (first, last) = (day(axis.from), day(axis.to));
    let text = format!("{:04}-{:02}-{:02}", first.0, first.1, first.2);
    match last {
        _ if last == first => text,
        (year, month, day) if (year, month) == (first.0, first.1) => format!("{text}/{day:02}"),
        (year, month, day) if year == first.0 => format!("{text}/{month:02}-{day:02}"),
        (year, month, day) => format!("{text}/{year:04}-{month:02}-{day:02}"),
    }
}

/// Bands of twilight: lower limit of the Sun's altitude, degrees; name; colour. The colours are lighter than the marks,
/// because dark bands would hide the marks.
const BANDS: [(f64, &str, RGBColor); 4] = [
    (-0.833, "day", RGBColor(250, 214, 140)),
    (-6.0, "civil", RGBColor(251, 228, 180)),
    (-12.0, "nautical", RGBColor(253, 239, 212)),
    (-18.0, "astronomical twilight", RGBColor(254, 248, 236)),
];

/// Returns the index of the band for an altitude of the Sun, degrees; `None` at night.
fn band(altitude_deg: f64) -> Option<usize> {
    BANDS.iter().position(|(least, ..)| altitude_deg > *least)
}

/// Draws the bands on a time axis, from times with altitudes of the Sun (degrees), which are interpolated linearly.
/// Returns the bands that were drawn.
pub(super) fn bands_in_time(picture: &mut Picture, frame: &Frame, sun: &[(f64, f64)]) -> Vec<usize> {
    let mut shown = Vec::new();
    for pair in sun.windows(2) {
        let ((from, first), (to, last)) = (pair[0], pair[1]);
        // Intervals are divided where the altitude crosses the limit of a band.
        let mut cuts = vec![from, to];
        for (border, ..) in BANDS {
            let share = (border - first) / (last - first);
            if share > 0.0 && share < 1.0 {
                cuts.push(from + share * (to - from));
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for cut in cuts.windows(2) {
            let middle = (cut[0] + cut[1]) / 2.0;
            let altitude = first + (last - first) * (middle - from) / (to - from);
            paint(picture, frame, [cut[0], cut[1]], altitude, &mut shown);
        }
    }
    shown.sort_unstable();
    shown
}

/// Draws the bands on an x axis that is the Sun's altitude, degrees. Returns the bands that were drawn.
pub(super) fn bands_in_altitude(picture: &mut Picture, frame: &Frame) -> Vec<usize> {
    let mut shown = Vec::new();
    let mut upper = 90.0;
    for (border, ..) in BANDS {
        paint(picture, frame, [upper, border], (upper + border) / 2.0, &mut shown);
        upper = border;
    }
    shown
}

fn paint(picture: &mut Picture, frame: &Frame, [from, to]: [f64; 2], altitude_deg: f64, shown: &mut Vec<usize>) {
    let (Some(band), [_, top, _, bottom]) = (band(altitude_deg), frame.sides) else { return };
    let (left, right) = (frame.at(from, frame.y.from).0, frame.at(to, frame.y.from).0);
    if (right - left).abs() > 1e-6 {
        picture.rectangle([left.min(right), top, left.max(right), bottom], BANDS[band].2.to_rgba());
        if !shown.contains(&band) {
            shown.push(band);
        }
    }
}

/// Draws the legend of the drawn bands; returns the x position of the next entry.
pub(super) fn legend(picture: &mut Picture, shown: &[usize], mut x: f64, y: f64) -> f64 {
    for &band in shown {
        let (_, text, colour) = BANDS[band];
        picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], colour.to_rgba());
        picture.border([x, y - 8.0, x + 24.0, y + 8.0], 1.0);
        x = picture.legend_text(text, x + 31.0, y) - 8.0;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::super::axes::Axis;
    use super::*;

    #[test]
    fn verif_ticks_are_at_round_times_of_their_clock() {
        // 2024-08-13T22:30 to 2024-08-14T10:30; midnight is MJD 60536.
        let axis = Axis::linear(60_536.0 - 1.5 / 24.0, 60_536.0 + 10.5 / 24.0);
        let utc = ticks(&axis, 1000.0, 0.0);
        assert_eq!(utc[0].1, "23:00");
        assert!(utc.iter().any(|(mjd, text)| text == "00:00" && (mjd - 60_536.0).abs() < 1e-9));
        // Four hours and 43 minutes behind, midnight is at 04:43 UTC.
        let local = ticks(&axis, 1000.0, -4.0 - 43.0 / 60.0);
        let midnight = local.iter().find(|(_, text)| text == "00:00").unwrap().0;
        assert!((midnight - 60_536.0 - (4.0 + 43.0 / 60.0) / 24.0).abs() < 1e-9);
        assert_eq!(dates(&axis, 0.0), "2024-08-13/14");
        assert_eq!(dates(&Axis::linear(60_309.9, 60_310.2), 0.0), "2023-12-31/2024-01-01");
        assert_eq!(dates(&Axis::linear(60_310.0, 60_310.2), 0.0), "2024-01-01");
    }

    #[test]
    fn verif_ticks_of_short_intervals_have_seconds_and_do_not_overlap() {
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

    #[test]
    fn verif_twilights_begin_where_they_are_defined() {
        let of = |altitude: f64| band(altitude).map(|band| BANDS[band].1);
        assert_eq!(
            [1.0, -0.84, -5.99, -6.01, -12.01, -18.01].map(of),
            [Some("day"), Some("civil"), Some("civil"), Some("nautical"), Some("astronomical twilight"), None]
        );
        let frame = Frame { sides: [0.0, 0.0, 100.0, 50.0], x: Axis::linear(0.0, 1.0), y: Axis::linear(0.0, 1.0) };
        let mut picture = Picture::new(100, 50);
        assert_eq!(bands_in_time(&mut picture, &frame, &[(0.0, -10.0), (1.0, -20.0)]), [2, 3]);
        let bytes = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgb8();
        // Nautical to −12°, a fifth of the interval; night below −18°.
        let colours = [10, 30, 90].map(|x| bytes.get_pixel(x, 25).0);
        assert_eq!(colours, [[253, 239, 212], [254, 248, 236], [255, 255, 255]]);
    }
}
