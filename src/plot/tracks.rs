//! Elements of charts with tracks: arrows at the ends of tracks, numbers beside them, and a list.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::labels::Labels;
use super::numbers::fixed;
use super::picture::{INK, Picture, around, half_size, width_of};

/// Largest number of rows in the list and of numbered tracks.
pub(super) const MOST_LISTED: usize = 22;
const ROW: f64 = 29.0;
const DAY_MIN: f64 = 1440.0;
const DAY_S: f64 = 86_400.0;
/// Smallest distance between two times along a pass, pixels.
const LABEL_GAP: f64 = 62.0;

/// Returns the position at a fraction of the length of a line.
pub(super) fn along(line: &[(f64, f64)], share: f64) -> (f64, f64) {
    let lengths: Vec<f64> = line.windows(2).map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).collect();
    let mut left = share * lengths.iter().sum::<f64>();
    for (pair, length) in line.windows(2).zip(lengths) {
        if left <= length && length > 0.0 {
            let part = left / length;
            return (pair[0].0 + part * (pair[1].0 - pair[0].0), pair[0].1 + part * (pair[1].1 - pair[0].1));
        }
        left -= length;
    }
    line[line.len() - 1]
}

/// Draws an arrow head at the end of a line, unless the line is too short to have a direction.
pub(super) fn arrow(picture: &mut Picture, line: &[(f64, f64)], colour: RGBColor) {
    let (tip, tail) = (line[line.len() - 1], along(line, 0.98));
    let length = (tip.0 - tail.0).hypot(tip.1 - tail.1);
    if length < 0.05 {
        return;
    }
    let (cos, sin) = ((tip.0 - tail.0) / length, (tip.1 - tail.1) / length);
    let corner = |back: f64, side: f64| (tip.0 - back * cos - side * sin, tip.1 - back * sin + side * cos);
    // The head ends beyond the round end of the line.
    let corners = vec![corner(-4.0, 0.0), corner(14.0, 7.0), corner(14.0, -7.0), corner(-4.0, 0.0)];
    picture.patch(corners.clone(), colour.to_rgba());
    picture.line(&corners, INK.to_rgba(), 1.3);
}

/// Draws the numbers of tracks beside them or, with a thin line, beyond their ends, where they cover neither tracks nor
/// other labels. `order` contains the indices in `lines` of the tracks, in the order in which their numbers are placed;
/// all lines are already in `labels`. The number of a track is its index plus 1. Returns how many tracks have no free
/// position for a number.
pub(super) fn numbers(picture: &mut Picture, labels: &mut Labels, lines: &[Vec<(f64, f64)>], order: &[usize]) -> usize {
    let mut without = 0;
    for &index in order {
        let (line, text) = (&lines[index], (index + 1).to_string());
        let half = (width_of(&text, 16.0) / 2.0 + 5.0, 11.0);
        let beside = SHARES.into_iter().flat_map(|share| positions_beside(line, share, half));
        let near = beside.filter(|position| labels.is_nearest(index, *position));
        let near = near.collect::<Vec<_>>();
        let position = labels.place(half, near).or_else(|| {
            let (tip, position) = positions_beyond(line, half).find(|(tip, position)| {
                labels.is_free(*position, half) && labels.is_free_line(index, *tip, *position)
            })?;
            picture.line(&[tip, position], INK.mix(0.7), 1.0);
            labels.add_line(index, &[tip, position]);
            labels.add_box(around(position, half));
            Some(position)
        });
        let position = position.or_else(|| {
            let mut starts = SHARES.into_iter().map(|share| (along(line, share), positions_beside(line, share, half)));
            starts.find_map(|(tip, beside)| place_with_line(picture, labels, index, tip, beside, half))
        });
        let Some(position) = position else {
            without += 1;
            continue;
        };
        let sides = around(position, half);
        picture.rectangle(sides, RGBColor(255, 255, 255).to_rgba());
        picture.border(sides, 1.0);
        picture.text(&text, position, 16.0, HPos::Center);
    }
    without
}

/// Positions of numbers along a track, as fractions of its length.
const SHARES: [f64; 13] = [0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.45, 0.55, 0.12, 0.88, 0.05, 0.95];
/// Distance between a track and the box of its number, pixels. It is larger than the diagonal of the clearance of
/// labels.
const BESIDE: f64 = 8.0;

/// Returns the positions on both sides of a line at which a box is next to it. `half` is half the width and half the
/// height of the box.
pub(super) fn positions_beside(line: &[(f64, f64)], share: f64, half: (f64, f64)) -> [(f64, f64); 2] {
    let (x, y) = along(line, share);
    let ((x0, y0), (x1, y1)) = (along(line, (share - 0.02).max(0.0)), along(line, (share + 0.02).min(1.0)));
    let length = (x1 - x0).hypot(y1 - y0);
    // A track of a single point has no direction; its positions are above and below.
    let (cos, sin) = if length > 1e-9 { ((x1 - x0) / length, (y1 - y0) / length) } else { (1.0, 0.0) };
    let away = half.0 * sin.abs() + half.1 * cos.abs() + BESIDE;
    [(x + away * sin, y - away * cos), (x - away * sin, y + away * cos)]
}

/// Returns the ends of a line, each with positions beyond it, nearest first.
fn positions_beyond(line: &[(f64, f64)], half: (f64, f64)) -> impl Iterator<Item = ((f64, f64), (f64, f64))> {
    let ends = [(line[0], along(line, 0.05)), (line[line.len() - 1], along(line, 0.95))];
    let directions = ends.map(|(tip, inside)| {
        let length = (tip.0 - inside.0).hypot(tip.1 - inside.1);
        let cos_sin =
            if length > 1e-9 { ((tip.0 - inside.0) / length, (tip.1 - inside.1) / length) } else { (0.0, -1.0) };
        (tip, cos_sin)
    });
    let distances = [10.0, 32.0, 56.0, 80.0, 104.0];
    distances.into_iter().flat_map(move |distance| {
        [0.0, 26.0, -26.0, 52.0, -52.0, 78.0, -78.0].into_iter().flat_map(move |aside| {
            directions.map(|(tip, (cos, sin))| {
                let away = half.0 * cos.abs() + half.1 * sin.abs() + distance;
                (tip, (tip.0 + away * cos - aside * sin, tip.1 + away * sin + aside * cos))
            })
        })
    })
}

/// Returns the sentence of a caption on tracks whose numbers do not fit; empty if all fit.
pub(super) fn without_numbers(without: usize) -> String {
    match without {
        0 => String::new(),
        1 => "1 listed track has no number in the chart for lack of room. ".to_owned(),
        more => format!("{more} listed tracks have no numbers in the chart for lack of room. "),
    }
}

/// Draws the number of each track and the cells of its row between two x positions, from `top` downwards. `columns` are
/// headings and distances from the left side; texts are shortened to fit.
pub(super) fn list(
    picture: &mut Picture,
    [left, right]: [f64; 2],
    top: f64,
    columns: &[(&str, f64)],
    rows: &[Vec<String>],
) {
    let mut y = top;
    for (heading, away) in columns {
        picture.text(heading, (left + away, y), 16.0, HPos::Left);
    }
    picture.line(&[(left, y + 14.0), (right, y + 14.0)], INK.to_rgba(), 1.2);
    y += 32.0;
    let widths: Vec<f64> = columns.windows(2).map(|pair| pair[1].1 - pair[0].1 - 8.0).collect();
    for (index, row) in rows.iter().enumerate().take(MOST_LISTED) {
        picture.text(&(index + 1).to_string(), (left, y), 16.0, HPos::Left);
        for (column, text) in row.iter().enumerate() {
            let width = widths.get(column).copied().unwrap_or(f64::INFINITY);
            picture.text(&shortened(text, width), (left + columns[column].1, y), 16.0, HPos::Left);
        }
        y += ROW;
    }
    if rows.len() > MOST_LISTED {
        let text = format!("and {} more, in the data", rows.len() - MOST_LISTED);
        picture.text(&text, (left + columns[0].1, y), 16.0, HPos::Left);
    }
}

/// Formats a magnitude with its uncertainty, if it is known.
pub(super) fn magnitude_text(magnitude: f64, sigma_mag: f64) -> String {
    match (magnitude.is_finite(), sigma_mag.is_finite()) {
        (true, true) => format!("{} ±{}", fixed(magnitude, 1), fixed(sigma_mag, 1)),
        (true, false) => fixed(magnitude, 1),
        (false, _) => "not visible".to_owned(),
    }
}

/// Reserves a free position for a label away from `tip` on the line `own`, beyond the positions `beside` it, and draws
/// a thin line to it. Returns the position; `None` if there is none.
pub(super) fn place_with_line(
    picture: &mut Picture,
    labels: &mut Labels,
    own: usize,
    tip: (f64, f64),
    beside: [(f64, f64); 2],
    half: (f64, f64),
) -> Option<(f64, f64)> {
    let farther = |more: f64| {
        beside.map(|(x, y)| {
            let share = 1.0 + more / (x - tip.0).hypot(y - tip.1);
            (tip.0 + share * (x - tip.0), tip.1 + share * (y - tip.1))
        })
    };
    let mut candidates = [20.0, 36.0, 56.0, 80.0, 110.0].into_iter().flat_map(farther);
    let free =
        candidates.find(|position| labels.is_free(*position, half) && labels.is_free_line(own, tip, *position))?;
    picture.line(&[tip, free], INK.mix(0.7), 1.0);
    labels.add_line(own, &[tip, free]);
    labels.add_box(around(free, half));
    Some(free)
}

/// Largest number of marks along a track.
const MOST_MARKS: f64 = 60.0;

/// Draws a mark at every full minute of a track (times in MJD, UTC), with the time of this size beside it, or with a
/// thin line to the time where there is no room beside it. Tracks of more than an hour have a mark every 10 min, hour
/// or day. Times without room are left out. `ahead_days` is the clock's difference to UTC, and `own` the number of the
/// track in `labels`.
pub(super) fn minutes_along(
    picture: &mut Picture,
    labels: &mut Labels,
    own: usize,
    time_mjd: &[f64],
    line: &[(f64, f64)],
    ahead_days: f64,
    size: f64,
) {
    let (first, last) = (time_mjd[0], time_mjd[time_mjd.len() - 1]);
    let mut labelled: Option<(f64, f64)> = None;
    // Minutes of the clock that is shown: its difference to UTC may have seconds.
    let minute_of = |mjd: f64| (mjd + ahead_days) * DAY_MIN;
    // Every minute of a pass, fewer marks of a longer track, none of one of months.
    let marks = |step: &f64| (minute_of(last) - minute_of(first)) / step <= MOST_MARKS;
    let Some(step) = [1.0, 10.0, 60.0, 1440.0].into_iter().find(marks) else { return };
    for mark in (minute_of(first) / step).ceil() as i64..=(minute_of(last) / step).floor() as i64 {
        let mjd = mark as f64 * step / DAY_MIN - ahead_days;
        let Some(step) = time_mjd.windows(2).position(|pair| (pair[0]..=pair[1]).contains(&mjd)) else {
            continue;
        };
        let part = (mjd - time_mjd[step]) / (time_mjd[step + 1] - time_mjd[step]);
        let ((x0, y0), (x1, y1)) = (line[step], line[step + 1]);
        let (x, y) = (x0 + part * (x1 - x0), y0 + part * (y1 - y0));
        picture.disk((x, y), 5.0, INK);
        picture.disk((x, y), 3.0, RGBColor(255, 255, 255));
        if labelled.is_none_or(|(x_before, y_before): (f64, f64)| (x - x_before).hypot(y - y_before) > LABEL_GAP) {
            // The label is next to the track, at a right angle to it.
            let text = clock(mjd + ahead_days, 60.0);
            let half = half_size(&text, size);
            let beside = positions_beside(&[line[step], line[step + 1]], part, half);
            let position = labels.place(half, beside);
            let position = position.or_else(|| place_with_line(picture, labels, own, (x, y), beside, half));
            if let Some(position) = position {
                picture.note_of(&text, position, size);
                labelled = Some((x, y));
            }
        }
    }
}

/// Formats the time of day, rounded to `step_s`, without seconds if this is a minute; empty for a time that is not
/// finite.
pub(super) fn clock(mjd: f64, step_s: f64) -> String {
    let text = time_of_day((mjd * DAY_S / step_s).round() * step_s / DAY_S, 0);
    text.chars().take(if step_s < 60.0 { 8 } else { 5 }).collect()
}

/// Formats the time of day, UTC, with this number of decimals of the second; empty for a time that is not finite.
pub(super) fn time_of_day(mjd: f64, decimals: usize) -> String {
    if !mjd.is_finite() {
        return String::new();
    }
    // A displayed clock can ignore leap seconds.
    let parts_a_second = 10_i64.pow(decimals as u32);
    let parts = ((mjd - mjd.floor()) * 86_400.0 * parts_a_second as f64).round() as i64 % (86_400 * parts_a_second);
    let (seconds, fraction) = (parts / parts_a_second, parts % parts_a_second);
    let clock = format!("{:02}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
    if decimals == 0 { clock } else { format!("{clock}.{fraction:0decimals$}") }
}

/// Returns the indices of magnitudes in order of brightness, the brightest first; missing magnitudes are last, in their
/// order.
pub(super) fn by_brightness(magnitudes: impl Iterator<Item = f64>) -> Vec<usize> {
    let magnitudes: Vec<f64> =
        magnitudes.map(|magnitude| if magnitude.is_nan() { f64::INFINITY } else { magnitude }).collect();
    let mut order: Vec<usize> = (0..magnitudes.len()).collect();
    order.sort_by(|a, b| magnitudes[*a].total_cmp(&magnitudes[*b]));
    order
}

/// Truncates text to a width and marks the truncation.
fn shortened(text: &str, width: f64) -> String {
    if width_of(text, 16.0) <= width {
        return text.to_owned();
    }
    let mut kept: String = text.to_owned();
    while !kept.is_empty() && width_of(&format!("{kept}…"), 16.0) > width {
        kept.pop();
    }
    format!("{}…", kept.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_clocks_are_rounded_and_the_brightest_come_first() {
        let late = 60_536.0 + 86_399.97 / 86_400.0;
        assert_eq!((time_of_day(late, 2), time_of_day(late, 1)), ("23:59:59.97".into(), "00:00:00.0".into()));
        assert_eq!(time_of_day(60_536.25 + 1.4 / 86_400.0, 0), "06:00:01");
        let moment = 60_536.25 + 97.0 / 86_400.0;
        assert_eq!([1.0, 10.0, 60.0].map(|step_s| clock(moment, step_s)), ["06:01:37", "06:01:40", "06:02"]);
        assert_eq!(clock(f64::NAN, 60.0), "");
        assert_eq!(time_of_day(f64::NAN, 1), "");
        assert_eq!(by_brightness([f64::NAN, 5.0, -1.0, f64::NAN, 5.0].into_iter()), [2, 1, 4, 0, 3]);
    }

    #[test]
    fn verif_positions_along_a_line() {
        let line = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)];
        assert_eq!(
            [along(&line, 0.25), along(&line, 0.75), along(&line, 1.0)],
            [(5.0, 0.0), (10.0, 5.0), (10.0, 10.0)]
        );
        assert_eq!(along(&[(3.0, 4.0), (3.0, 4.0)], 0.5), (3.0, 4.0));
        assert_eq!(shortened("STARLINK-1234", 500.0), "STARLINK-1234");
        assert!(shortened("COSMOS 2251 DEBRIS OF 1993-036", 160.0).ends_with('…'));
    }
}
