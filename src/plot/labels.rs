//! Free positions of labels: labels cover neither lines nor one another.

use super::picture::around;

/// Smallest distance between a label and a line, pixels.
const CLEARANCE: f64 = 5.0;

/// Lines and boxes that labels must not cover.
pub(super) struct Labels {
    /// Left, top, right and bottom of the area that contains all labels.
    within: [f64; 4],
    /// Segments of lines, each with the number of its line.
    segments: Vec<(usize, [(f64, f64); 2])>,
    boxes: Vec<[f64; 4]>,
}

impl Labels {
    /// Creates an empty area.
    pub fn new(within: [f64; 4]) -> Self {
        Self { within, segments: Vec::new(), boxes: Vec::new() }
    }

    /// Adds a line that labels must not cover.
    pub fn add_line(&mut self, number: usize, line: &[(f64, f64)]) {
        self.segments.extend(line.windows(2).map(|pair| (number, [pair[0], pair[1]])));
    }

    /// Adds a box that labels must not cover.
    pub fn add_box(&mut self, sides: [f64; 4]) {
        self.boxes.push(sides);
    }

    /// Returns the first of these positions at which a label is free, and occupies it. `half` is half the width and
    /// half the height of the label.
    pub fn place(&mut self, half: (f64, f64), candidates: impl IntoIterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
        let position = candidates.into_iter().find(|position| self.is_free(*position, half))?;
        self.add_box(around(position, half));
        Some(position)
    }

    /// Returns true if a label would be inside the area and would cover nothing.
    pub fn is_free(&self, position: (f64, f64), half: (f64, f64)) -> bool {
        let [left, top, right, bottom] = around(position, half);
        let wider = [left - CLEARANCE, top - CLEARANCE, right + CLEARANCE, bottom + CLEARANCE];
        left >= self.within[0]
            && top >= self.within[1]
            && right <= self.within[2]
            && bottom <= self.within[3]
            && self
                .boxes
                .iter()
                .all(|other| right <= other[0] || left >= other[2] || bottom <= other[1] || top >= other[3])
            && self.segments.iter().all(|(_, [from, to])| clipped(*from, *to, wider).is_none())
    }

    /// Returns true if a straight line would cross neither labels nor lines other than `own`.
    pub fn is_free_line(&self, own: usize, from: (f64, f64), to: (f64, f64)) -> bool {
        self.boxes.iter().all(|sides| clipped(from, to, *sides).is_none())
            && self.segments.iter().all(|(number, [a, b])| *number == own || !cross([from, to], [*a, *b]))
    }

    /// Returns true if no line is closer to a position than line `own`.
    pub fn is_nearest(&self, own: usize, position: (f64, f64)) -> bool {
        let (mut nearest, mut other) = (f64::INFINITY, f64::INFINITY);
        for (number, segment) in &self.segments {
            let least = if *number == own { &mut nearest } else { &mut other };
            *least = least.min(distance(position, *segment));
        }
        nearest < other
    }
}

/// Returns the part of a segment inside a box (Liang & Barsky 1984); `None` if the segment is outside.
pub(super) fn clipped(
    from: (f64, f64),
    to: (f64, f64),
    [left, top, right, bottom]: [f64; 4],
) -> Option<[(f64, f64); 2]> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (step, room) in [(-dx, from.0 - left), (dx, right - from.0), (-dy, from.1 - top), (dy, bottom - from.1)] {
        if step == 0.0 {
            if room < 0.0 {
                return None;
            }
        } else if step < 0.0 {
            first = first.max(room / step);
        } else {
            last = last.min(room / step);
        }
    }
    let at = |share: f64| (from.0 + share * dx, from.1 + share * dy);
    (first <= last).then(|| [at(first), at(last)])
}

/// Returns true if two segments cross.
fn cross([a, b]: [(f64, f64); 2], [c, d]: [(f64, f64); 2]) -> bool {
    let side = |p: (f64, f64), q: (f64, f64), r: (f64, f64)| (q.0 - p.0) * (r.1 - p.1) - (q.1 - p.1) * (r.0 - p.0);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Returns the distance of a position from a segment.
fn distance((x, y): (f64, f64), [(x0, y0), (x1, y1)]: [(f64, f64); 2]) -> f64 {
    let (dx, dy) = (x1 - x0, y1 - y0);
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 { (((x - x0) * dx + (y - y0) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - x0 - share * dx).hypot(y - y0 - share * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_labels_cover_neither_lines_nor_labels() {
        let mut labels = Labels::new([0.0, 0.0, 100.0, 100.0]);
        labels.add_line(0, &[(0.0, 50.0), (100.0, 50.0)]);
        let half = (10.0, 8.0);
        // On the line, too close to it, outside, and free.
        let candidates = [(50.0, 50.0), (50.0, 38.0), (95.0, 20.0), (50.0, 30.0)];
        assert_eq!(labels.place(half, candidates), Some((50.0, 30.0)));
        // The place is now occupied.
        assert_eq!(labels.place(half, [(50.0, 30.0), (65.0, 30.0), (70.0, 30.0)]), Some((70.0, 30.0)));
        assert_eq!(labels.place(half, [(50.0, 52.0)]), None);
        labels.add_line(1, &[(0.0, 90.0), (100.0, 90.0)]);
        assert!(labels.is_nearest(0, (50.0, 65.0)) && labels.is_nearest(1, (50.0, 75.0)));
        assert!(
            !labels.is_free_line(0, (20.0, 80.0), (20.0, 95.0)) && labels.is_free_line(1, (20.0, 80.0), (20.0, 95.0))
        );
        assert!(!labels.is_free_line(0, (20.0, 30.0), (90.0, 30.0)));
    }

    #[test]
    fn verif_segments_are_clipped_at_boxes() {
        let sides = [0.0, 0.0, 10.0, 10.0];
        assert_eq!(clipped((-5.0, 5.0), (15.0, 5.0), sides), Some([(0.0, 5.0), (10.0, 5.0)]));
        assert_eq!(clipped((2.0, 3.0), (4.0, 5.0), sides), Some([(2.0, 3.0), (4.0, 5.0)]));
        assert_eq!(clipped((-5.0, 12.0), (15.0, 12.0), sides), None);
        assert_eq!(clipped((-5.0, 4.0), (4.0, -5.0), sides), None);
        assert!((distance((5.0, 3.0), [(0.0, 0.0), (10.0, 0.0)]) - 3.0).abs() < 1e-12);
        assert!((distance((13.0, 4.0), [(0.0, 0.0), (10.0, 0.0)]) - 5.0).abs() < 1e-12);
    }
}
