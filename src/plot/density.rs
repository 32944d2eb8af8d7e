//! Many points in a box: drawn as transparent dots, as a two-dimensional histogram, or by lines that enclose a fraction
//! of the points.

use plotters::prelude::RGBColor;

use super::axes::Frame;
use super::contour::contours;
use super::picture::{PAPER, Pixels};

/// Number of empty bins around the counted ones, so that every line is closed.
const BORDER: usize = 3;

/// Number of smoothing passes before lines are drawn.
const SMOOTHINGS: usize = 2;

/// Numbers of points in equal bins of a box.
pub(super) struct Density {
    /// Number of bins along each side.
    pub bins: usize,
    /// Counts row by row, from the lower left corner of the box.
    pub counts: Vec<f64>,
}

impl Density {
    /// Counts the points in each bin; points outside the box are ignored.
    pub fn new(x: &[f64], y: &[f64], frame: &Frame, bins: usize) -> Self {
        let mut counts = vec![0.0; bins * bins];
        for (&x, &y) in x.iter().zip(y).filter(|(x, y)| frame.holds(**x, **y)) {
            let cell = |share: f64| ((share * bins as f64) as usize).min(bins - 1);
            counts[cell(frame.y.share(y)) * bins + cell(frame.x.share(x))] += 1.0;
        }
        Self { bins, counts }
    }

    /// Returns the greatest count.
    pub fn most(&self) -> f64 {
        self.counts.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the bins as coloured rectangles that fill the box. `colour` returns the colour of a count above 0.
    pub fn pixels(&self, frame: &Frame, colour: impl Fn(f64) -> [u8; 3]) -> Pixels {
        let bins = self.bins;
        let colour_of = |cell: usize| {
            let count = self.counts[(bins - 1 - cell / bins) * bins + cell % bins];
            (count > 0.0).then(|| colour(count))
        };
        let [left, top, ..] = frame.sides;
        let each = (frame.width() / bins as f64, frame.height() / bins as f64);
        Pixels {
            corner: (left, top),
            each,
            columns: bins,
            colours: (0..bins * bins).map(colour_of).collect(),
            within: None,
        }
    }

    /// Returns, for each of the fractions `shares`, the lines that enclose the densest bins with this fraction of all
    /// points. Positions are in pixels of the picture.
    ///
    /// `walls` is true for each end (left and right, lower and upper) at which the values have a bound. Smoothing moves
    /// no counts past a bound.
    pub fn lines_around(&self, frame: &Frame, shares: &[f64], walls: [[bool; 2]; 2]) -> Vec<Vec<(f64, f64)>> {
        let side = self.bins + 2 * BORDER;
        let smooth = self.smooth(side, walls);
        let mut falling = smooth.clone();
        falling.sort_unstable_by(|a, b| b.total_cmp(a));
        let all: f64 = falling.iter().sum();
        let [left, top, ..] = frame.sides;
        let (wide, high) = (frame.width() / self.bins as f64, frame.height() / self.bins as f64);
        // Centre of a bin, to the right of and above the lower left corner of the box. Points in the border of empty
        // bins are moved back into the box.
        let position = |(x, y): (f64, f64)| {
            let across = ((x - BORDER as f64 + 0.5) * wide).clamp(0.0, frame.width());
            let up = ((y - BORDER as f64 + 0.5) * high).clamp(0.0, frame.height());
            (left + across, top + frame.height() - up)
        };
        let level_of = |share: f64| {
            let mut held = 0.0;
            falling.iter().copied().find(|count| {
                held += count;
                held >= share * all
            })
        };
        let found = shares.iter().filter_map(|share| level_of(*share)).filter(|level| *level > 0.0);
        found
            .flat_map(|level| contours((side, side), 1, level, |x, y| Some(smooth[y * side + x])))
            .map(|line| line.into_iter().map(position).collect())
            .collect()
    }

    /// Returns the counts with a border, smoothed with the weights 1 : 2 : 1 along both axes. Counts that would be
    /// moved past a bound remain in their bins.
    fn smooth(&self, side: usize, walls: [[bool; 2]; 2]) -> Vec<f64> {
        let mut grid = vec![0.0; side * side];
        for (cell, count) in self.counts.iter().enumerate() {
            grid[(cell / self.bins + BORDER) * side + cell % self.bins + BORDER] = *count;
        }
        let (first, last) = (BORDER, BORDER + self.bins - 1);
        for axis in [0, 1].into_iter().cycle().take(2 * SMOOTHINGS) {
            let old = grid.clone();
            let step = if axis == 0 { 1 } else { side };
            for (index, cell) in grid.iter_mut().enumerate() {
                let along = if axis == 0 { index % side } else { index / side };
                let [before, after] =
                    [along.checked_sub(1).map(|_| index - step), (along + 1 < side).then(|| index + step)];
                let [lower, upper] = walls[axis];
                let share = |neighbour: Option<usize>, is_wall: bool| match neighbour {
                    _ if is_wall => old[index],
                    neighbour => neighbour.map_or(0.0, |neighbour| old[neighbour]),
                };
                let before = share(before, (lower && along == first) || (upper && along == last + 1));
                let after = share(after, (upper && along == last) || (lower && along + 1 == first));
                *cell = 0.5 * old[index] + 0.25 * (before + after);
            }
        }
        grid
    }
}

/// Number of cells of the dot raster per pixel, along each side.
const CELLS_PER_PIXEL: usize = 2;

/// Radius of a dot, pixels.
const DOT_RADIUS: f64 = 1.7;

/// Returns the points inside a box as painted dots; points outside are ignored.
pub(super) fn dots(frame: &Frame, x: &[f64], y: &[f64], colour: RGBColor) -> Pixels {
    let columns = (frame.width() * CELLS_PER_PIXEL as f64) as usize;
    let rows = (frame.height() * CELLS_PER_PIXEL as f64) as usize;
    let mut layers = vec![0_u32; columns * rows];
    let reach = (DOT_RADIUS * CELLS_PER_PIXEL as f64).ceil() as isize;
    let is_in = |right: isize, down: isize| (right as f64).hypot(down as f64) <= DOT_RADIUS * CELLS_PER_PIXEL as f64;
    let [left, top, ..] = frame.sides;
    for (&x, &y) in x.iter().zip(y).filter(|(x, y)| frame.holds(**x, **y)) {
        let (across, down) = frame.at(x, y);
        let (column, row) =
            (((across - left) * CELLS_PER_PIXEL as f64) as isize, ((down - top) * CELLS_PER_PIXEL as f64) as isize);
        for (r, d) in
            (-reach..=reach).flat_map(|r| (-reach..=reach).map(move |d| (r, d))).filter(|(r, d)| is_in(*r, *d))
        {
            if (0..columns as isize).contains(&(column + r)) && (0..rows as isize).contains(&(row + d)) {
                layers[(row + d) as usize * columns + (column + r) as usize] += 1;
            }
        }
    }
    // Dots are more transparent if there are many points: their opacity is 60 % for a few points, and 10 % if the
    // raster cells with dots have dozens of dots on average.
    let painted: Vec<u32> = layers.iter().copied().filter(|count| *count > 0).collect();
    let mean = painted.iter().sum::<u32>() as f64 / painted.len().max(1) as f64;
    let thin = 1.0 - (0.6 / mean.max(1.0).sqrt()).max(0.06);
    let mixed = |count: &u32| {
        let paper = thin.powi((*count).min(200) as i32);
        let ink = [colour.0, colour.1, colour.2];
        let channel = |k: usize| (paper * f64::from(PAPER[k]) + (1.0 - paper) * f64::from(ink[k])).round() as u8;
        (*count > 0).then(|| [channel(0), channel(1), channel(2)])
    };
    let each = (1.0 / CELLS_PER_PIXEL as f64, 1.0 / CELLS_PER_PIXEL as f64);
    Pixels {
        corner: (left, top),
        each,
        columns: columns.max(1),
        colours: layers.iter().map(mixed).collect(),
        within: None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::axes::Axis;
    use super::*;

    const OPEN: [[bool; 2]; 2] = [[false; 2]; 2];

    /// Points concentrated at a bound: the line around them follows the bound, and none leaks beyond.
    #[test]
    fn verif_counts_stay_within_walls() {
        let (x, y): (Vec<f64>, Vec<f64>) = normal_points();
        let x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        let frame = Frame { sides: [0.0, 0.0, 400.0, 400.0], x: Axis::linear(0.0, 4.0), y: Axis::linear(-4.0, 4.0) };
        let density = Density::new(&x, &y, &frame, 40);
        let walls = [[true, false], [false, false]];
        let side = density.bins + 2 * BORDER;
        let within = |walls: [[bool; 2]; 2]| {
            let grid = density.smooth(side, walls);
            grid.iter().enumerate().filter(|(index, _)| index % side >= BORDER).map(|(_, count)| count).sum::<f64>()
        };
        let all: f64 = density.counts.iter().sum();
        assert!((within(walls) - all).abs() < 1e-9 * all && within(OPEN) < 0.99 * all);
        /// Size of a bin in the picture, pixels.
        const CELL: f64 = 10.0;
        // Half of the one-sigma line: it is 100 pixels wide, and at the wall it extends 50 pixels to both sides, as
        // without the wall.
        let highest_at_wall = |walls| {
            let lines = density.lines_around(&frame, &[0.393], walls);
            let at_wall = lines.iter().flatten().filter(|(x, _)| *x < 0.6 * CELL).map(|(_, y)| (y - 200.0).abs());
            at_wall.fold(0.0, f64::max)
        };
        assert!((highest_at_wall(walls) - 50.0).abs() < CELL, "{}", highest_at_wall(walls));
    }

    /// Evenly spaced quantiles of a normal distribution on both axes: a grid of points with known density.
    fn normal_points() -> (Vec<f64>, Vec<f64>) {
        let mut points = (Vec::new(), Vec::new());
        for ring in 0..400 {
            // Fraction of a two-dimensional normal distribution within r: 1 − exp(−r²/2).
            let radius = (-2.0 * (1.0 - (f64::from(ring) + 0.5) / 400.0).ln()).sqrt();
            for part in 0..100 {
                let (sin, cos) = ((f64::from(part) + 0.37 * f64::from(ring)) * std::f64::consts::TAU / 100.0).sin_cos();
                points.0.push(radius * cos);
                points.1.push(radius * sin);
            }
        }
        points
    }

    #[test]
    fn verif_lines_about_a_normal_distribution_are_its_circles() {
        let (x, y) = normal_points();
        let axis = Axis::linear(-4.0, 4.0);
        let frame = Frame { sides: [0.0, 0.0, 400.0, 400.0], x: axis, y: axis };
        let density = Density::new(&x, &y, &frame, 40);
        // 39.3 % are within one sigma, 86.5 % within two: 50 pixels per sigma. Smoothing widens by some 0.02.
        for (share, radius) in [(0.393, 50.0), (0.865, 100.0)] {
            let lines = density.lines_around(&frame, &[share], OPEN);
            let longest = lines.iter().max_by_key(|line| line.len()).unwrap();
            let mean = longest.iter().map(|(x, y)| (x - 200.0).hypot(y - 200.0)).sum::<f64>() / longest.len() as f64;
            assert!((mean / radius - 1.0).abs() < 0.06, "{share}: {mean}");
        }
        assert_eq!(
            density.counts.iter().sum::<f64>(),
            x.iter().zip(&y).filter(|(x, y)| frame.holds(**x, **y)).count() as f64
        );
    }

    #[test]
    fn verif_the_upper_left_cell_is_painted_above_and_left() {
        let axis = Axis::linear(0.0, 2.0);
        let frame = Frame { sides: [10.0, 20.0, 30.0, 40.0], x: axis, y: axis };
        let pixels = Density::new(&[0.5], &[1.5], &frame, 2).pixels(&frame, |_| [1, 2, 3]);
        assert_eq!(pixels.colours, [Some([1, 2, 3]), None, None, None]);
        assert!(Density::new(&[], &[], &frame, 2).lines_around(&frame, &[0.5], OPEN).is_empty());
    }
}
