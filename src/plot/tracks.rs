//! Elements of charts with tracks: arrows at the ends of tracks, numbers beside them, and a list.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::labels::Labels;
use super::numbers::fixed;
use super::picture::{INK, Picture, around, width_of};

/// Largest number of rows in the list and of numbered tracks.
pub(super) const MOST_LISTED: usize = 22;
const ROW: f64 = 29.0;

/// One row of the list.
pub(super) struct ListRow {
    pub name: String,
    /// Start and end of the track as formatted times.
    pub times: [String; 2],
    pub magnitude: f64,
    pub sigma_mag: f64,
    pub colour: RGBColor,
}

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
    let corners = vec![tip, corner(17.0, 7.0), corner(17.0, -7.0), tip];
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

/// Draws number, name, two times and magnitude of each track between two x positions, from `top` downwards.
pub(super) fn list(picture: &mut Picture, [left, right]: [f64; 2], top: f64, times: [&str; 2], rows: &[ListRow]) {
    let columns = [0.0, 46.0, 246.0, 339.0, 432.0].map(|away| left + away);
    let mut y = top;
    for (text, x) in ["", "satellite", times[0], times[1], "mag"].into_iter().zip(columns) {
        picture.text(text, (x, y), 16.0, HPos::Left);
    }
    picture.line(&[(left, y + 14.0), (right, y + 14.0)], INK.to_rgba(), 1.2);
    y += 32.0;
    for (index, row) in rows.iter().enumerate().take(MOST_LISTED) {
        picture.rectangle([columns[0], y - 8.0, columns[0] + 14.0, y + 8.0], row.colour.to_rgba());
        picture.border([columns[0], y - 8.0, columns[0] + 14.0, y + 8.0], 0.8);
        picture.text(&(index + 1).to_string(), (columns[0] + 20.0, y), 16.0, HPos::Left);
        picture.text(&shortened(&row.name, 194.0), (columns[1], y), 16.0, HPos::Left);
        picture.text(&row.times[0], (columns[2], y), 16.0, HPos::Left);
        picture.text(&row.times[1], (columns[3], y), 16.0, HPos::Left);
        let magnitude = match (row.magnitude.is_finite(), row.sigma_mag.is_finite()) {
            (true, true) => format!("{} ±{}", fixed(row.magnitude, 1), fixed(row.sigma_mag, 1)),
            (true, false) => fixed(row.magnitude, 1),
            (false, _) => "dark".to_owned(),
        };
        picture.text(&magnitude, (columns[4], y), 16.0, HPos::Left);
        y += ROW;
    }
    if rows.len() > MOST_LISTED {
        let text = format!("and {} more, in the data", rows.len() - MOST_LISTED);
        picture.text(&text, (columns[1], y), 16.0, HPos::Left);
    }
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
