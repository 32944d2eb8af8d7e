//! Which pixels get their light from which chord: stretches of rows, each pixel in one of them.

use std::ops::Range;

use crate::images::PatchRows;

use super::chords::{Border, Chord};
use super::ends::End;

/// Where the light of some pixels comes from.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Source {
    /// The chord of this number, whose light at each pixel's foot is all that counts.
    Smooth(usize),
    /// All panels near the chord of this number, summed.
    Summed(usize),
    /// What an end changes in the light of smooth chords, beside the path or beyond it.
    Edge {
        /// Number of the end.
        end: usize,
        /// True for pixels that have their feet on the path, whose chord has drawn them.
        is_beside: bool,
    },
    /// All panels near the end of this number, summed, in place of what is there.
    Middle(usize),
}

/// Neighbouring pixels of a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Run {
    pub row: usize,
    pub columns: Range<usize>,
    pub source: Source,
}

/// The line across the path at a border, as rows see it.
#[derive(Copy, Clone, Debug)]
struct Normal {
    at: [f64; 2],
    along: [f64; 2],
    /// Columns by which it lies farther left in the next row; not finite where it is a row.
    shift: f64,
}

impl Normal {
    fn of(border: &Border) -> Self {
        let [tx, ty] = border.along;
        Self { at: border.at, along: border.along, shift: if tx.abs() < 1e-12 { f64::INFINITY } else { ty / tx } }
    }

    /// Columns of a row that lie past it.
    fn past(&self, row: f64, frame: &PatchRows) -> Range<usize> {
        let dy = row - self.at[1];
        if self.shift.is_infinite() {
            return if dy * self.along[1] >= 0.0 { 0..frame.columns() } else { 0..0 };
        }
        let bound = self.at[0] - dy * self.shift;
        if self.along[0] > 0.0 {
            frame.columns_within(bound, f64::INFINITY)
        } else {
            frame.columns_within(f64::NEG_INFINITY, bound)
        }
    }

    /// All others.
    fn before(&self, row: f64, frame: &PatchRows) -> Range<usize> {
        let (past, count) = (self.past(row, frame), frame.columns());
        if past.is_empty() {
            0..count
        } else if past.start > 0 {
            0..past.start
        } else {
            past.end..count
        }
    }
}

fn both(a: Range<usize>, b: Range<usize>) -> Range<usize> {
    let start = a.start.max(b.start);
    start..a.end.min(b.end).max(start)
}

/// Pixels between the normals at both ends of a chord, within `reach_pix` of it.
pub(super) fn beside(chord: &Chord, reach_pix: f64, source: Source, frame: &PatchRows, runs: &mut Vec<Run>) {
    let [ux, uy] = chord.along;
    let sagitta = chord.sagitta_pix();
    let (lowest, highest) = (sagitta.min(0.0) - reach_pix, sagitta.max(0.0) + reach_pix);
    let margin = reach_pix + sagitta.abs();
    let (y0, y1) = (chord.start.at[1], chord.end.at[1]);
    let (start, end) = (Normal::of(&chord.start), Normal::of(&chord.end));
    // b = (y - y₀) u_x - (x - x₀) u_y lies from lowest to highest.
    let is_along_rows = uy.abs() <= 1e-9;
    let [shift, low, high] = [ux, lowest, highest].map(|length| length / uy);
    let (low, high) = (low.min(high), low.max(high));
    for row in frame.rows_within(y0.min(y1) - margin, y0.max(y1) + margin) {
        let y = row as f64;
        let mut columns = both(start.past(y, frame), end.before(y, frame));
        let dy = y - chord.middle[1];
        if !is_along_rows {
            let middle = chord.middle[0] + dy * shift;
            columns = both(columns, frame.columns_within(middle - high, middle - low));
        } else if dy * ux < lowest || dy * ux > highest {
            continue;
        }
        if !columns.is_empty() {
            runs.push(Run { row, columns, source });
        }
    }
}

/// Pixels before the start of a path (`is_start`) or past its end, within `reach_pix` of it.
pub(super) fn beyond(
    border: &Border,
    is_start: bool,
    reach_pix: f64,
    source: Source,
    frame: &PatchRows,
    runs: &mut Vec<Run>,
) {
    let normal = Normal::of(border);
    for row in frame.rows_within(border.at[1] - reach_pix, border.at[1] + reach_pix) {
        let y = row as f64;
        let half = (reach_pix.powi(2) - (y - border.at[1]).powi(2)).max(0.0).sqrt();
        let disc = frame.columns_within(border.at[0] - half, border.at[0] + half);
        let side = if is_start { normal.before(y, frame) } else { normal.past(y, frame) };
        let columns = both(disc, side);
        if !columns.is_empty() {
            runs.push(Run { row, columns, source });
        }
    }
}

/// Pixels within `reach_pix` of the end of this number: those that are summed apart from those farther out, and of these those beside the path from those
/// beyond it, by the same normal as those of its chord.
pub(super) fn around(end: &End, number: usize, reach_pix: f64, frame: &PatchRows, runs: &mut Vec<Run>) {
    let (at, normal) = (end.border.at, Normal::of(&end.border));
    for row in frame.rows_within(at[1] - reach_pix, at[1] + reach_pix) {
        let y = row as f64;
        let dy = y - at[1];
        let disc = |radius: f64| {
            let half = (radius.powi(2) - dy.powi(2)).max(0.0).sqrt();
            if dy.abs() < radius { frame.columns_within(at[0] - half, at[0] + half) } else { 0..0 }
        };
        let (outer, inner) = (disc(reach_pix), disc(end.from_pix));
        let mut push = |columns: Range<usize>, source| {
            if !columns.is_empty() {
                runs.push(Run { row, columns, source });
            }
        };
        let is_beside = if end.is_start { normal.past(y, frame) } else { normal.before(y, frame) };
        let edges = if inner.is_empty() { [outer, 0..0] } else { [outer.start..inner.start, inner.end..outer.end] };
        for edge in edges {
            let beside = both(edge.clone(), is_beside.clone());
            let beyond =
                if beside.is_empty() { [edge, 0..0] } else { [edge.start..beside.start, beside.end..edge.end] };
            push(beside, Source::Edge { end: number, is_beside: true });
            for beyond in beyond {
                push(beyond, Source::Edge { end: number, is_beside: false });
            }
        }
        push(inner, Source::Middle(number));
    }
}
