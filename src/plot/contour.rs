//! Lines of equal magnitude by marching squares.

use std::collections::HashMap;

use super::disc::{Raster, Seen};

/// Sides of the squares, pixels.
const STEP: usize = 2;

/// What the shadow is taken for, below the line, mag.
const SHADOW_BELOW_MAG: f64 = 2.0;

/// A side of a square: column and row of its upper left corner, and whether it runs down.
type Side = (usize, usize, bool);

/// Lines on which the magnitude is `level`, in pixels right of and below the raster's upper left corner.
///
/// Each line is closed, or ends at the rim or where nothing lit is seen. The Earth's shadow is fainter than any line.
pub(super) fn contours(raster: &Raster, level: f64) -> Vec<Vec<(f64, f64)>> {
    let mut places: HashMap<Side, (f64, f64)> = HashMap::new();
    let mut neighbours: HashMap<Side, Vec<Side>> = HashMap::new();
    let squares = raster.side.saturating_sub(1) / STEP;
    for row in (0..squares).map(|row| row * STEP) {
        for column in (0..squares).map(|column| column * STEP) {
            for [a, b] in cuts(raster, column, row, level, &mut places) {
                neighbours.entry(a).or_default().push(b);
                neighbours.entry(b).or_default().push(a);
            }
        }
    }
    // Open lines are followed from their ends, what is left over is closed.
    let mut starts: Vec<Side> = neighbours.keys().copied().collect();
    starts.sort_unstable_by_key(|side| (neighbours[side].len() != 1, *side));
    let mut lines = Vec::new();
    for start in starts {
        let mut line = Vec::new();
        let mut here = start;
        while let Some(next) = neighbours.get_mut(&here).and_then(Vec::pop) {
            if line.is_empty() {
                line.extend(places.get(&here));
            }
            if let Some(back) = neighbours.get_mut(&next) {
                back.retain(|side| *side != here);
            }
            line.extend(places.get(&next));
            here = next;
        }
        if line.len() > 2 {
            lines.push(line);
        }
    }
    lines
}

/// The sides of a square between which a line runs.
fn cuts(
    raster: &Raster,
    column: usize,
    row: usize,
    level: f64,
    places: &mut HashMap<Side, (f64, f64)>,
) -> Vec<[Side; 2]> {
    let corners = [(0, 0), (STEP, 0), (STEP, STEP), (0, STEP)];
    let mut values = [0.0; 4];
    for (value, (right, down)) in values.iter_mut().zip(corners) {
        match raster.pixels.get((row + down) * raster.side + column + right) {
            Some(Some(Seen::Magnitude(magnitude))) => *value = *magnitude,
            // Fainter than any line: what is brighter is enclosed along the shadow, whose border is as narrow as a pixel.
            Some(Some(Seen::Shadow)) => *value = level + SHADOW_BELOW_MAG,
            _ => return Vec::new(),
        }
    }
    let sides: [Side; 4] =
        [(column, row, false), (column + STEP, row, true), (column, row + STEP, false), (column, row, true)];
    let mut crossed = Vec::with_capacity(4);
    for (index, side) in sides.into_iter().enumerate() {
        let (from, to) = (values[index], values[(index + 1) % 4]);
        if (from < level) != (to < level) {
            let share = (level - from) / (to - from);
            let between = |from: usize, to: usize| from as f64 + share * (to as f64 - from as f64);
            let ((x0, y0), (x1, y1)) = (corners[index], corners[(index + 1) % 4]);
            // Pixel centres lie half a pixel in.
            let place = (column as f64 + between(x0, x1) + 0.5, row as f64 + between(y0, y1) + 0.5);
            places.insert(side, place);
            crossed.push(side);
        }
    }
    match crossed[..] {
        [a, b] => vec![[a, b]],
        // A saddle: the mean of the corners says which two are joined.
        [a, b, c, d] => {
            let is_joined = (values.iter().sum::<f64>() / 4.0 < level) == (values[0] < level);
            if is_joined { vec![[a, b], [c, d]] } else { vec![[d, a], [b, c]] }
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(side: usize, value: impl Fn(f64, f64) -> Option<f64>) -> Raster {
        let pixel = |index: usize| {
            let (x, y) = ((index % side) as f64 + 0.5, (index / side) as f64 + 0.5);
            Some(value(x, y).map_or(Seen::Nothing, Seen::Magnitude))
        };
        Raster { side, pixels: (0..side * side).map(pixel).collect() }
    }

    #[test]
    fn verif_a_cone_has_a_circle() {
        let cone = raster(101, |x, y| Some((x - 50.5).hypot(y - 50.5)));
        let lines = contours(&cone, 30.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|(x, y)| ((x - 50.5).hypot(y - 50.5) - 30.0).abs() < 0.05));
        assert_eq!(lines[0].first(), lines[0].last());
        // Its length is that of the circle.
        let length: f64 = lines[0].windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum();
        assert!((length - 60.0 * std::f64::consts::PI).abs() < 0.5, "{length}");
    }

    #[test]
    fn verif_a_slope_has_a_line_that_ends_where_magnitudes_end() {
        let slope = raster(101, |x, y| (y < 60.0).then_some(x));
        let lines = contours(&slope, 40.25);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|(x, y)| (x - 40.25).abs() < 1e-9 && *y < 60.0));
        assert!(lines[0].len() > 25);
        assert!(contours(&slope, 200.0).is_empty());
    }

    #[test]
    fn verif_a_line_runs_along_the_shadow() {
        let half = |index: usize| Some(if index / 101 < 60 { Seen::Magnitude(6.0) } else { Seen::Shadow });
        let lines = contours(&Raster { side: 101, pixels: (0..101 * 101).map(half).collect() }, 7.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() > 45 && lines[0].iter().all(|(_, y)| (y - 60.0).abs() < 1.5), "{:?}", lines[0]);
    }

    #[test]
    fn verif_a_saddle_is_two_lines() {
        let saddle = raster(101, |x, y| Some((x - 50.3) * (y - 50.4)));
        assert_eq!(contours(&saddle, 5.0).len(), 2);
        assert_eq!(contours(&saddle, -5.0).len(), 2);
    }
}
