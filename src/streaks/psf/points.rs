//! Drawing of points of light: stars, and lines as sums of points.
//!
//! For each layer of the profile, the light of all points is summed on the layer's own grid of cells. Beginning with
//! the coarsest grid, the light is interpolated to the next finer grid; the finest grid is summed into pixels. Straight
//! and curved lines, ends, jumps of brightness and stationary points are all drawn in this way.

use crate::images::{Patch, PatchRows, PixelPosition};

use super::layers::QUARTER;
use super::profile::RadialProfile;

/// Number of cells around the frame on coarse grids, needed for interpolation.
const MARGIN: usize = 4;

/// A point of light.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PointLight {
    /// Position in the frame, pixels.
    pub at: PixelPosition,
    /// Flux, in the unit of the drawn light.
    pub light: f64,
}

/// Draws a point in a frame of `rows` by `columns` pixels. Each pixel is `flux` times the average of the profile over
/// it.
///
/// Pixels are accurate to 10⁻³ of the peak. If the whole profile lies in the frame, the pixels sum to `flux` within
/// 2·10⁻⁴. The patch is empty if the position or the flux is not finite.
pub fn draw_point(profile: &RadialProfile, at: PixelPosition, flux: f64, rows: usize, columns: usize) -> Patch {
    let is_finite = at.x.is_finite() && at.y.is_finite() && flux.is_finite();
    let point = is_finite.then_some(PointLight { at, light: flux });
    draw_points(profile, rows, columns, |_| point.into_iter().collect())
}

/// Draws the points of lines in a frame of `rows` by `columns` pixels.
///
/// `points_of` is called for each layer with the largest allowed mean distance between points (pixels of the mean
/// scale), and returns the points. The wings allow a greater distance than the core, so they need fewer points.
pub fn draw_points(
    profile: &RadialProfile,
    rows: usize,
    columns: usize,
    mut points_of: impl FnMut(f64) -> Vec<PointLight>,
) -> Patch {
    let parts = profile.parts();
    let mut canvas: Option<Patch> = None;
    for (level, layer) in profile.layers().iter().enumerate().rev() {
        let grid = Grid { cells: (1_usize << level) as f64, margin: if level == 0 { 0 } else { MARGIN } };
        let [rows, columns] = [rows * parts[1], columns * parts[0]].map(|count| grid.count(count));
        let points = if layer.is_empty() { Vec::new() } else { points_of(layer.step_pix) };
        let positions: Vec<([f64; 2], f64)> = points.iter().flat_map(|point| grid.positions(point, profile)).collect();
        let mut extents = PatchRows::new(rows, columns);
        if let Some(coarse) = &canvas {
            grid.cover(coarse, &mut extents);
        }
        for (at, _) in &positions {
            layer.cover(*at, &mut extents);
        }
        let mut fine = extents.into_patch();
        if let Some(coarse) = &canvas {
            grid.refine(coarse, &mut fine);
        }
        for (at, light) in positions {
            layer.add_to(&mut fine, at, light);
        }
        canvas = Some(fine);
    }
    let canvas = canvas.unwrap_or_else(|| PatchRows::new(rows, columns).into_patch());
    if parts == [1, 1] { canvas } else { canvas.summed(parts[0], parts[1]) }
}

/// Grid of cells over a frame.
struct Grid {
    /// Side of a cell, in units of the parts into which pixels are divided.
    cells: f64,
    /// Number of cells around the frame.
    margin: usize,
}

impl Grid {
    /// Returns the number of cells along a side that has this number of parts.
    fn count(&self, parts: usize) -> usize {
        parts.div_ceil(self.cells as usize) + 2 * self.margin
    }

    /// Returns the positions of a point in units of cells, with its light. If parts are oblong, the point is replaced
    /// by two points, each with half of the light.
    fn positions(&self, point: &PointLight, profile: &RadialProfile) -> impl Iterator<Item = ([f64; 2], f64)> + use<> {
        let (parts, shift) = (profile.parts(), profile.shift_parts());
        let cell = |pix: f64, axis: usize| (pix + 0.5) * parts[axis] as f64 / self.cells - 0.5 + self.margin as f64;
        let centre = [cell(point.at.x, 0), cell(point.at.y, 1)];
        let shift = shift.map(|parts| parts / self.cells);
        let sides: &[f64] = if shift == [0.0; 2] { &[0.0] } else { &[-1.0, 1.0] };
        let light = point.light / sides.len() as f64;
        sides.iter().map(move |side| ([0, 1].map(|axis| centre[axis] + side * shift[axis]), light))
    }

    /// Returns the index of the cell of the next coarser grid that contains a cell of this grid.
    fn coarse(&self, cell: usize) -> usize {
        cell / 2 + MARGIN - self.margin / 2
    }

    /// Adds to the extents the cells of this grid that lie within the cells of the next coarser grid.
    fn cover(&self, coarse: &Patch, extents: &mut PatchRows) {
        let back = MARGIN - self.margin / 2;
        for span in coarse.iter() {
            let fine = |cell: usize, most: usize| (2 * cell.saturating_sub(back)).min(most);
            let columns = fine(span.first_column, extents.columns())
                ..fine(span.first_column + span.values.len(), extents.columns());
            for row in fine(span.row, extents.rows())..fine(span.row + 1, extents.rows()) {
                extents.add(row, columns.clone());
            }
        }
    }

    /// Sets the light to that of the next coarser grid, by cubic interpolation along both axes.
    fn refine(&self, coarse: &Patch, fine: &mut Patch) {
        let mut backwards = QUARTER;
        backwards.reverse();
        let (mut column, mut doubled) = (Vec::new(), Vec::new());
        fine.fill(|row, first, values| {
            if values.is_empty() {
                return;
            }
            let (from, to) = (self.coarse(first) - 2, self.coarse(first + values.len() - 1) + 3);
            column.clear();
            column.resize(to - from, 0.0_f32);
            let (weights, first_row) =
                if row % 2 == 0 { (backwards, self.coarse(row) - 2) } else { (QUARTER, self.coarse(row) - 1) };
            for (weight, row) in weights.iter().zip(first_row..) {
                let span = coarse.row(row);
                let start = span.first_column.clamp(from, to);
                let end = (span.first_column + span.values.len()).clamp(start, to);
                let Some(light) = span.values.get(start.saturating_sub(span.first_column)..) else { continue };
                for (sum, value) in column[start - from..end - from].iter_mut().zip(light) {
                    *sum += weight * value;
                }
            }
            doubled.clear();
            doubled.resize(2 * (column.len() - 4), 0.0_f32);
            for (pair, near) in doubled.chunks_exact_mut(2).zip(column.windows(5)) {
                let sum = |weights: [f32; 4], from: usize| -> f32 { (0..4).map(|k| weights[k] * near[from + k]).sum() };
                pair[0] = sum(backwards, 0);
                pair[1] = sum(QUARTER, 1);
            }
            values.copy_from_slice(&doubled[first % 2..][..values.len()]);
        });
    }
}
