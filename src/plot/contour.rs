//! Lines of equal value on a grid of points, by marching squares.

use std::collections::HashMap;

/// A side of a square: column and row of its upper left corner, and true if the side runs down.
type Side = (usize, usize, bool);

/// Returns the lines on which `value`, a function of column and row of a grid of `columns` by `rows` points, equals
/// `level`. Positions are in columns and rows from the first point.
///
/// Squares are `step` points wide. A line is closed, or it ends at the border of the grid or at missing values.
pub(super) fn contours(
    (columns, rows): (usize, usize),
    step: usize,
    level: f64,
    value: impl Fn(usize, usize) -> Option<f64>,
) -> Vec<Vec<(f64, f64)>> {
    let mut points: HashMap<Side, (f64, f64)> = HashMap::new();
    let mut neighbours: HashMap<Side, Vec<Side>> = HashMap::new();
    for row in (0..rows.saturating_sub(step)).step_by(step) {
        for column in (0..columns.saturating_sub(step)).step_by(step) {
            for [a, b] in cuts(&value, (column, row), step, level, &mut points) {
                neighbours.entry(a).or_default().push(b);
                neighbours.entry(b).or_default().push(a);
            }
        }
    }
    // Open lines are followed from their ends; lines that remain afterwards are closed.
    let mut starts: Vec<Side> = neighbours.keys().copied().collect();
    starts.sort_unstable_by_key(|side| (neighbours[side].len() != 1, *side));
    let mut lines = Vec::new();
    for start in starts {
        let mut line = Vec::new();
        let mut here = start;
        while let Some(next) = neighbours.get_mut(&here).and_then(Vec::pop) {
            if line.is_empty() {
                line.extend(points.get(&here));
            }
            if let Some(back) = neighbours.get_mut(&next) {
                back.retain(|side| *side != here);
            }
            line.extend(points.get(&next));
            here = next;
        }
        if line.len() > 2 {
            lines.push(line);
        }
    }
    lines
}

/// Returns the pairs of sides of a square between which a line runs.
fn cuts(
    value: impl Fn(usize, usize) -> Option<f64>,
    (column, row): (usize, usize),
    step: usize,
    level: f64,
    points: &mut HashMap<Side, (f64, f64)>,
) -> Vec<[Side; 2]> {
    let corners = [(0, 0), (step, 0), (step, step), (0, step)];
    let mut values = [0.0; 4];
    for (at, (right, down)) in values.iter_mut().zip(corners) {
        match value(column + right, row + down) {
            Some(found) => *at = found,
            None => return Vec::new(),
        }
    }
    let sides: [Side; 4] =
        [(column, row, false), (column + step, row, true), (column, row + step, false), (column, row, true)];
    let mut crossed = Vec::with_capacity(4);
    for (index, side) in sides.into_iter().enumerate() {
        let (from, to) = (values[index], values[(index + 1) % 4]);
        if (from < level) != (to < level) {
            let share = (level - from) / (to - from);
            let between = |from: usize, to: usize| from as f64 + share * (to as f64 - from as f64);
            let ((x0, y0), (x1, y1)) = (corners[index], corners[(index + 1) % 4]);
            points.insert(side, (column as f64 + between(x0, x1), row as f64 + between(y0, y1)));
            crossed.push(side);
        }
    }
    match crossed[..] {
        [a, b] => vec![[a, b]],
        // At a saddle point, the mean of the four corners determines which two corners are connected.
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

    /// Lines of a grid of 101 points a side, in squares of two.
    fn lines(level: f64, value: impl Fn(f64, f64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
        contours((101, 101), 2, level, |column, row| value(column as f64, row as f64))
    }

    #[test]
    fn verif_a_cone_has_a_circle() {
        let lines = lines(30.0, |x, y| Some((x - 50.0).hypot(y - 50.0)));
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|(x, y)| ((x - 50.0).hypot(y - 50.0) - 30.0).abs() < 0.05));
        assert_eq!(lines[0].first(), lines[0].last());
        // Its length is the circumference of the circle.
        let length: f64 = lines[0].windows(2).map(|p| (p[1].0 - p[0].0).hypot(p[1].1 - p[0].1)).sum();
        assert!((length - 60.0 * std::f64::consts::PI).abs() < 0.5, "{length}");
    }

    #[test]
    fn verif_a_slope_has_a_line_that_ends_where_values_end() {
        let slope = |x: f64, y: f64| (y < 60.0).then_some(x);
        let found = lines(40.25, slope);
        assert_eq!(found.len(), 1);
        assert!(found[0].iter().all(|(x, y)| (x - 40.25).abs() < 1e-9 && *y < 60.0));
        assert!(found[0].len() > 25);
        assert!(lines(200.0, slope).is_empty());
    }

    #[test]
    fn verif_a_saddle_is_two_lines() {
        let saddle = |x: f64, y: f64| Some((x - 50.3) * (y - 50.4));
        assert_eq!(lines(5.0, saddle).len(), 2);
        assert_eq!(lines(-5.0, saddle).len(), 2);
    }

    #[test]
    fn verif_a_grid_without_squares_has_no_lines() {
        assert!(contours((1, 1), 1, 0.0, |_, _| Some(1.0)).is_empty());
        assert!(contours((0, 9), 1, 0.0, |_, _| Some(1.0)).is_empty());
    }
}
