//! Pixels of a chip that cells of corridors cover, and polygons around them.

use std::ops::Range;

use super::corridor::Cell;
use crate::images::{LightArea, PixelPosition};
use crate::math::convex::clip;

/// Distance between a polygon and a streak that is not straight, as a fraction of the half width, and at least in
/// pixels.
const BEND_SHARE: f64 = 0.1;
const LEAST_BEND_PIX: f64 = 1.0;
/// Number of points of a circle around each corner of a cell. Their polygon is outside the circle, and inside a circle
/// that is 4 % larger.
const CIRCLE_POINTS: usize = 12;
/// Corners of a polygon that are nearer than this to the line between the remaining ones are omitted, pixels. The
/// polygon is wider by as much, so that it contains the corridor.
const STRAIGHT_PIX: f64 = 0.2;

/// Pixels of a chip: adjacent ones of a row form one run. Runs are in the order of rows and columns, and do not touch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Area {
    runs: Vec<(usize, Range<usize>)>,
}

impl Area {
    /// Returns the illuminated pixels whose centres are covered by cells.
    pub fn of_cells(cells: &[Cell], light_area: &LightArea) -> Self {
        let mut runs = Vec::new();
        for cell in cells {
            add_runs(cell, light_area, &mut runs);
        }
        Self::joined(runs)
    }

    /// Returns the pixels that are in any of several areas.
    pub fn union<'a>(areas: impl IntoIterator<Item = &'a Self>) -> Self {
        Self::joined(areas.into_iter().flat_map(|area| area.runs.iter().cloned()).collect())
    }

    fn joined(mut runs: Vec<(usize, Range<usize>)>) -> Self {
        runs.sort_unstable_by_key(|(row, columns)| (*row, columns.start));
        let mut joined: Vec<(usize, Range<usize>)> = Vec::new();
        for (row, columns) in runs {
            match joined.last_mut() {
                Some((last_row, last)) if *last_row == row && columns.start <= last.end => {
                    last.end = last.end.max(columns.end);
                }
                _ => joined.push((row, columns)),
            }
        }
        Self { runs: joined }
    }

    /// Returns the runs: row and columns, counted from 0.
    pub fn runs(&self) -> &[(usize, Range<usize>)] {
        &self.runs
    }

    /// Returns the number of pixels.
    pub fn pixels(&self) -> usize {
        self.runs.iter().map(|(_, columns)| columns.len()).sum()
    }

    /// Returns the values of all pixels of a chip of this size: one value for those outside and another for those
    /// inside.
    pub fn values<T: Copy>(&self, [rows, columns]: [usize; 2], [outside, inside]: [T; 2]) -> Vec<T> {
        let mut values = vec![outside; rows * columns];
        for (row, range) in &self.runs {
            values[row * columns + range.start..row * columns + range.end].fill(inside);
        }
        values
    }

    /// Returns true if the area has this pixel.
    pub fn contains(&self, row: usize, column: usize) -> bool {
        let after = self.runs.partition_point(|(of_row, columns)| (*of_row, columns.start) <= (row, column));
        after > 0 && self.runs[after - 1].0 == row && self.runs[after - 1].1.contains(&column)
    }
}

/// Adds the pixels of a cell as one run per row.
fn add_runs(cell: &Cell, light_area: &LightArea, runs: &mut Vec<(usize, Range<usize>)>) {
    let [from, to] = cell.ends;
    let (low, high) = (from.y.min(to.y) - cell.radius_pix, from.y.max(to.y) + cell.radius_pix);
    for row in pixels_in(low, high, &light_area.rows).into_iter().flatten() {
        let [left, right] = columns_near(cell, row as f64);
        runs.extend(pixels_in(left, right, &light_area.columns).map(|columns| (row, columns)));
    }
}

/// Returns the pixels of a range whose centres are between two positions; `None` if there are none.
fn pixels_in(from: f64, to: f64, all: &Range<usize>) -> Option<Range<usize>> {
    // Conversions to integers limit infinities.
    let first = (from.ceil().max(0.0) as usize).max(all.start);
    let end = if to < 0.0 { 0 } else { (to.floor() as usize).saturating_add(1).min(all.end) };
    (first < end).then_some(first..end)
}

/// Returns the range of columns in a row that are within the radius of the line of a cell; empty (from infinity) if
/// there are none.
fn columns_near(cell: &Cell, row: f64) -> [f64; 2] {
    let ([from, to], radius) = (cell.ends, cell.radius_pix);
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut include = |x: f64| range = [range[0].min(x), range[1].max(x)];
    for end in [from, to] {
        let half = radius * radius - (row - end.y).powi(2);
        if half >= 0.0 {
            include(end.x - half.sqrt());
            include(end.x + half.sqrt());
        }
    }
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length = dx.hypot(dy);
    if length > 0.0 {
        // The sides of the widened line are parallel to it, at the distance of the radius.
        for sense in [-radius, radius] {
            let (x, y) = (from.x - dy / length * sense, from.y + dx / length * sense);
            let share = (row - y) / dy;
            if (0.0..=1.0).contains(&share) {
                include(x + share * dx);
            }
        }
    }
    range
}

/// Returns polygons that contain the part of the cells on illuminated pixels. A bent streak has several.
pub fn polygons(cells: &[Cell], light_area: &LightArea) -> Vec<Vec<PixelPosition>> {
    let mut ordered: Vec<&Cell> = cells.iter().collect();
    ordered.sort_by(|a, b| a.times_s[0].total_cmp(&b.times_s[0]));
    let mut polygons = Vec::new();
    split_at_bends(&ordered, &mut polygons);
    let within = polygons.into_iter().map(|polygon| clipped(polygon, light_area));
    within.filter(|polygon| polygon.len() > 2).collect()
}

/// Returns the part of a convex polygon on the illuminated pixels (Sutherland and Hodgman 1974, CACM 17, 32).
fn clipped(polygon: Vec<PixelPosition>, light_area: &LightArea) -> Vec<PixelPosition> {
    let [left, right] = [light_area.columns.start as f64 - 0.5, light_area.columns.end as f64 - 0.5];
    let [bottom, top] = [light_area.rows.start as f64 - 0.5, light_area.rows.end as f64 - 0.5];
    // Distances from the four sides, positive inside.
    let sides: [&dyn Fn([f64; 2]) -> f64; 4] =
        [&|[x, _]| x - left, &|[x, _]| right - x, &|[_, y]| y - bottom, &|[_, y]| top - y];
    let mut corners: Vec<[f64; 2]> = polygon.into_iter().map(|corner| [corner.x, corner.y]).collect();
    for inside in sides {
        let mut part = Vec::new();
        clip(&corners, inside, |corner| part.push(corner));
        corners = part;
    }
    corners.into_iter().map(|[x, y]| PixelPosition { x, y }).collect()
}

fn split_at_bends(cells: &[&Cell], polygons: &mut Vec<Vec<PixelPosition>>) {
    let (Some(first), Some(last)) = (cells.first(), cells.last()) else { return };
    let (from, to) = (first.middle(), last.middle());
    let bend = cells.iter().map(|cell| distance_from_line(cell.middle(), from, to)).fold(0.0, f64::max);
    let widest = cells.iter().map(|cell| cell.radius_pix).fold(0.0, f64::max);
    if bend > (BEND_SHARE * widest).max(LEAST_BEND_PIX) {
        let (before, after) = cells.split_at(cells.len() / 2);
        split_at_bends(before, polygons);
        split_at_bends(after, polygons);
        return;
    }
    let circle = |cell: &Cell| {
        let radius = (cell.radius_pix + STRAIGHT_PIX) / (std::f64::consts::PI / CIRCLE_POINTS as f64).cos();
        cell.ends.into_iter().flat_map(move |end| {
            (0..CIRCLE_POINTS).map(move |point| {
                let (sin, cos) = (std::f64::consts::TAU * point as f64 / CIRCLE_POINTS as f64).sin_cos();
                PixelPosition { x: end.x + radius * cos, y: end.y + radius * sin }
            })
        })
    };
    polygons.push(hull(cells.iter().flat_map(|cell| circle(cell)).collect()));
}

fn distance_from_line(at: PixelPosition, from: PixelPosition, to: PixelPosition) -> f64 {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let length = dx.hypot(dy);
    if length > 0.0 { ((at.x - from.x) * dy - (at.y - from.y) * dx).abs() / length } else { at.distance(from) }
}

/// Returns the convex hull of positions, anticlockwise, without corners that are almost straight (Andrew 1979, Inf.
/// Process. Lett. 9, 216).
fn hull(mut points: Vec<PixelPosition>) -> Vec<PixelPosition> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let turn =
        |a: PixelPosition, b: PixelPosition, c: PixelPosition| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    let chain = |points: &mut dyn Iterator<Item = PixelPosition>| {
        let mut chain: Vec<PixelPosition> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..]
                && turn(before, last, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut points.iter().copied());
    corners.extend(chain(&mut points.iter().rev().copied()));
    let mut kept: Vec<PixelPosition> = Vec::new();
    // First corner after the last one that is kept.
    let mut first = 0;
    for (index, corner) in corners.iter().enumerate() {
        let next = corners[(index + 1) % corners.len()];
        let is_straight = |last: &PixelPosition| {
            corners[first..=index].iter().all(|corner| distance_from_line(*corner, *last, next) < STRAIGHT_PIX)
        };
        if !kept.last().is_some_and(is_straight) {
            kept.push(*corner);
            first = index + 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(ends: [(f64, f64); 2], radius_pix: f64) -> Cell {
        Cell { ends: ends.map(|(x, y)| PixelPosition { x, y }), radius_pix, light_pix: 0.0, times_s: [0.0, 1.0] }
    }

    /// Distance of a position from the line of a cell.
    fn distance(at: PixelPosition, [from, to]: [PixelPosition; 2]) -> f64 {
        let (dx, dy) = (to.x - from.x, to.y - from.y);
        let share = (((at.x - from.x) * dx + (at.y - from.y) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        at.distance(PixelPosition { x: from.x + share * dx, y: from.y + share * dy })
    }

    #[test]
    fn verif_pixels_of_a_cell_are_those_within_its_radius() {
        let whole = LightArea::whole(60, 80);
        for (ends, radius) in [
            ([(10.0, 10.0), (50.0, 20.0)], 4.3),
            ([(-20.0, 5.5), (100.0, 8.1)], 3.0),
            ([(30.0, -9.0), (30.0, 70.0)], 6.5),
            ([(70.0, 30.0), (20.0, 30.0)], 8.2),
        ] {
            let cell = cell(ends, radius);
            let area = Area::of_cells(&[cell], &whole);
            let mut count = 0;
            for row in 0..60 {
                for column in 0..80 {
                    let at = PixelPosition { x: column as f64, y: row as f64 };
                    let expected = distance(at, cell.ends) <= radius;
                    assert_eq!(area.contains(row, column), expected, "{row} {column}");
                    count += usize::from(expected);
                }
            }
            assert_eq!(area.pixels(), count);
            // The polygon contains all of the cell on the chip, and is at most 4 % and a pixel wider.
            let [polygon] = &polygons(&[cell], &whole)[..] else { panic!("one polygon") };
            for corner in polygon {
                let sides = [corner.x, corner.x - 79.0, corner.y, corner.y - 59.0];
                let is_at_edge = sides.iter().any(|side| side.abs() < 0.6);
                let away = distance(*corner, cell.ends);
                assert!(away <= 1.04 * radius + 1.0 && (is_at_edge || away >= radius - 1e-9), "{away}");
                assert!((-0.6..=79.6).contains(&corner.x) && (-0.6..=59.6).contains(&corner.y), "{corner:?}");
            }
        }
        // Pixels outside the illuminated area are omitted.
        let lit = LightArea { rows: 0..60, columns: 40..50 };
        let area = Area::of_cells(&[cell([(0.0, 30.0), (79.0, 30.0)], 0.5)], &lit);
        assert_eq!(area.runs(), [(30, 40..50)]);
    }

    #[test]
    fn verif_areas_are_joined_and_bent_streaks_have_several_polygons() {
        let whole = LightArea::whole(20, 20);
        let [a, b] = [3.0, 7.0].map(|x| Area::of_cells(&[cell([(x, 4.0), (x, 4.5)], 2.0)], &whole));
        let both = Area::union([&a, &b]);
        assert_eq!(both.runs().iter().find(|(row, _)| *row == 4).unwrap().1, 1..10);
        assert!(both.pixels() < a.pixels() + b.pixels());
        assert!(Area::union([]).runs().is_empty());
        let bent = |step: f64| Cell {
            times_s: [step, step + 1.0],
            ..cell([(4.0 * step, step * step), (4.0 * step + 4.0, 0.0)], 1.0)
        };
        let cells: Vec<Cell> = (0..8).map(|step| bent(f64::from(step))).collect();
        assert!(polygons(&cells, &LightArea::whole(100, 100)).len() > 1);
    }

    #[test]
    fn verif_polygons_contain_all_pixels_of_narrow_corridors() {
        let whole = LightArea::whole(300, 300);
        // An arc that bends by less than a pixel, so that it has one polygon with many corners.
        let at = |step: i32| {
            let share = f64::from(step) / 40.0;
            (20.0 + 250.0 * share, 30.0 + 140.0 * share + 0.9 * (std::f64::consts::PI * share).sin())
        };
        for radius in [0.5, 0.7, 1.0, 1.3, 2.0, 3.0] {
            let part = |step: i32| Cell {
                times_s: [f64::from(step), f64::from(step + 1)],
                ..cell([at(step), at(step + 1)], radius)
            };
            let cells: Vec<Cell> = (0..40).map(part).collect();
            let outlines = polygons(&cells, &whole);
            assert!(outlines.iter().all(|outline| outline.len() < 40), "corners are omitted");
            let is_inside = |x: f64, y: f64, outline: &[PixelPosition]| {
                let sides = outline.iter().zip(outline.iter().cycle().skip(1));
                sides.into_iter().all(|(a, b)| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) >= 0.0)
            };
            for (row, columns) in Area::of_cells(&cells, &whole).runs() {
                for column in columns.clone() {
                    let is_contained = outlines.iter().any(|outline| is_inside(column as f64, *row as f64, outline));
                    assert!(is_contained, "radius {radius}: pixel {column} {row}");
                }
            }
        }
    }
}
