//! Layers of a profile: the core on a fine grid of cells, the wings on increasingly coarse grids.

use std::ops::Range;

use crate::images::{Patch, PatchRows};

use super::curve::Curve;

/// Lagrange weights of four adjacent cells, for a position a quarter of a cell beyond the second cell.
pub(super) const QUARTER: [f32; 4] = [-0.054_687_5, 0.820_312_5, 0.273_437_5, -0.039_062_5];

/// Largest error of the cubic interpolation between cells, relative to the light of a line.
const TOLERANCE: f64 = 1.5e-4;
/// Number of stamps (images of a point at tabulated positions) per FWHM, along each axis. Linear interpolation between
/// stamps has an error of δ²/8 f'', at most 4·10⁻⁴ of the peak. The wings, fainter by a factor of thirty or more, need
/// fewer stamps.
const STAMPS_PER_FWHM: f64 = 57.0;
const STAMPS_PER_WING: f64 = 20.0;
/// Largest product of the number of stamps along an axis and their radius in cells, for which the stamps take 32 MB.
const MOST_STAMP_CELLS: f64 = 2000.0;
/// Mean distance of the points that form a line, relative to the FWHM. The brightness of a line of points at equal
/// distances s varies by the Fourier transform of the profile at 1/s, which is 3·10⁻⁴ for a Moffat profile with β = 2.5
/// and less for all other profiles.
const STEP_PER_FWHM: f64 = 0.45;
/// Width of the wings, and distance of the points that form a line in the wings, both relative to the radius at which
/// the wings begin.
const WING_WIDTH: f64 = 0.45;
const WING_STEP: f64 = 0.22;
/// Smallest radius of a layer in cells; on coarser cells its light would be spread far beyond its radius.
const LEAST_CELLS: f64 = 8.0;

/// Part of a profile that is drawn on a grid whose cells are 2^level times as large as those of the finest grid.
///
/// The light of a point in each cell is tabulated as stamps, for many positions of the point within a cell. Each stamp
/// is one row of cells, for one position of the point along the row and one distance of the row from the point.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layer {
    /// Largest allowed mean distance of the points that form a line, pixels of the mean scale.
    pub step_pix: f64,
    /// Number of tabulated positions within a cell (phases), along each axis.
    phases: i64,
    /// Number of lit cells to either side of the point's cell, for each distance of the row from the point, in phases.
    reach: Vec<i64>,
    /// Number of cells in a stamp, and number of cells in front of the point's cell.
    width: usize,
    half: i64,
    /// Light in the cells of the stamps, with axes `(phases + 1, distances, width)`.
    stamps: Vec<f32>,
}

impl Layer {
    /// Splits a profile into layers. Values are in units of the light of one cell of the finest grid, whose sides are
    /// `cell_pix`.
    ///
    /// Layer k is w_k - w_(k+1), where w_0 is the profile itself. w_k equals the profile beyond a radius R_k; inside
    /// R_k it is the Taylor polynomial of second degree in r². R_k is the smallest radius for which w_k is smooth on
    /// cells of side 2^k. Layer k is 0 beyond R_(k+1).
    pub fn split(profile: &Curve, cell_pix: [f64; 2], fwhm_pix: f64) -> Vec<Self> {
        let mut wings = vec![Wing::new(profile, 0.0)];
        // The product of error and width is the same for every line of unit light.
        let allowed = 0.6 * TOLERANCE * profile.greatest() * fwhm_pix;
        loop {
            let cell = cell_pix[0].max(cell_pix[1]) * f64::from(1_u32 << wings.len());
            if profile.end_pix() < LEAST_CELLS * cell {
                break;
            }
            let last = wings[wings.len() - 1].from_pix;
            let first = (1.3 * last).max(fwhm_pix).max(4.0 * cell);
            let radii = std::iter::successors(Some(first), |from| Some(1.12 * from));
            let radii = radii.take_while(|from| *from < 0.7 * profile.end_pix());
            // The previous radius is tried first: if it suffices, the coarser cells replace the finer ones completely.
            let mut found = std::iter::once(last).chain(radii).map(|from| Wing::new(profile, from));
            let Some(next) = found.find(|wing| wing.is_smooth(cell, allowed, fwhm_pix)) else { break };
            wings.push(next);
        }
        let layer = |(level, wing): (usize, &Wing<'_>)| {
            let next = wings.get(level + 1);
            let radius_pix = next.map_or(profile.end_pix(), |next| next.from_pix);
            let is_empty = next.is_some_and(|next| next.from_pix == wing.from_pix);
            let is_core = wing.from_pix == 0.0;
            let width = if is_core { fwhm_pix } else { WING_WIDTH * wing.from_pix };
            let cell = cell_pix.map(|side| side * f64::from(1_u32 << level));
            let phases = if is_core { STAMPS_PER_FWHM } else { STAMPS_PER_WING } * cell[0].max(cell[1]) / width;
            let step_pix = (STEP_PER_FWHM * fwhm_pix).max(WING_STEP * wing.from_pix);
            let area = cell_pix[0] * cell_pix[1];
            let value =
                |r: f64| if r < radius_pix { area * (wing.at(r) - next.map_or(0.0, |next| next.at(r))) } else { 0.0 };
            Self::new(if is_empty { 0.0 } else { radius_pix }, cell, phases, step_pix, value)
        };
        wings.iter().enumerate().map(layer).collect()
    }

    fn new(radius_pix: f64, cell_pix: [f64; 2], phases: f64, step_pix: f64, value: impl Fn(f64) -> f64) -> Self {
        let radius = cell_pix.map(|side| radius_pix / side);
        let most = MOST_STAMP_CELLS / radius[0].max(radius[1]);
        let phases = phases.min(most).ceil().max(2.0) as usize;
        let [half, rows] = radius.map(|radius| radius.ceil() as usize);
        let distances = (rows + 1) * phases + 1;
        let reach = |distance: usize| {
            // The distance is reduced by one phase, because the stamps of two adjacent distances are interpolated.
            let share = (distance as f64 - 1.0).max(0.0) / (radius[1] * phases as f64);
            (radius[0] * (1.0 - share * share).max(0.0).sqrt()).ceil() as i64
        };
        let width = 2 * half + 2;
        let mut stamps = Vec::new();
        if radius_pix > 0.0 {
            stamps.reserve((phases + 1) * distances * width);
            // Values indexed by the distance from the point along both axes, in phases.
            let [dx, dy] = cell_pix.map(|side| side / phases as f64);
            let along = (half + 1) * phases + 1;
            let near: Vec<f32> = (0..distances * along)
                .map(|at| value(((at % along) as f64 * dx).hypot((at / along) as f64 * dy)) as f32)
                .collect();
            for phase in 0..=phases {
                for row in near.chunks_exact(along) {
                    stamps.extend((0..width).map(|column| row[(column * phases).abs_diff(half * phases + phase)]));
                }
            }
        }
        let reach = (0..distances).map(reach).collect();
        Self { step_pix, phases: phases as i64, reach, width, half: half as i64, stamps }
    }

    /// Returns true if the layer has no light.
    pub fn is_empty(&self) -> bool {
        self.stamps.is_empty()
    }

    /// Adds the cells that a point illuminates to the extents.
    pub fn cover(&self, at: [f64; 2], extents: &mut PatchRows) {
        let position = self.position(at);
        for (row, columns, _) in self.rows(position, extents.rows(), extents.columns()) {
            extents.add(row, columns);
        }
    }

    /// Adds the layer around a point, multiplied by `light`.
    pub fn add_to(&self, canvas: &mut Patch, at: [f64; 2], light: f64) {
        let position = self.position(at);
        let [after, above] = [0, 1].map(|axis| at[axis] * self.phases as f64 - position[axis] as f64);
        let weights = [(1.0 - after) * (1.0 - above), (1.0 - after) * above, after * (1.0 - above), after * above];
        let [a, b, c, d] = weights.map(|weight| (light * weight) as f32);
        let first = position[0].div_euclid(self.phases) - self.half;
        let size = self.reach.len() * self.width;
        let phase = position[0].rem_euclid(self.phases) as usize * size;
        for (row, columns, distance) in self.rows(position, canvas.rows(), canvas.columns()) {
            let (from, count) = ((columns.start as i64 - first) as usize, columns.len());
            let cells = canvas.span_mut(row, columns);
            let near = phase + distance.unsigned_abs() as usize * self.width + from;
            let far = phase + (distance - 1).unsigned_abs() as usize * self.width + from;
            let stamp = |start: usize| self.stamps.get(start..start + count).unwrap_or(&[]);
            let [p, q, r, s] = [near, far, near + size, far + size].map(stamp);
            for (cell, (((p, q), r), s)) in cells.iter_mut().zip(p.iter().zip(q).zip(r).zip(s)) {
                *cell += a * p + b * q + c * r + d * s;
            }
        }
    }

    /// Returns the position of a point in phases, rounded down.
    fn position(&self, at: [f64; 2]) -> [i64; 2] {
        at.map(|position| (position * self.phases as f64).floor() as i64)
    }

    /// Returns the rows and columns of a grid that a point illuminates, and for each row its distance from the point in
    /// phases.
    fn rows(
        &self,
        position: [i64; 2],
        rows: usize,
        columns: usize,
    ) -> impl Iterator<Item = (usize, Range<usize>, i64)> {
        let [column, row] = position.map(|position| position.div_euclid(self.phases));
        let most = self.reach.len() as i64 / self.phases - 1;
        let clamped = |position: i64, count: usize| position.clamp(0, count as i64) as usize;
        let rows = (clamped(row - most, rows)..clamped(row + most + 2, rows)).map(move |row| {
            let distance = row as i64 * self.phases - position[1];
            let reach = self.reach[distance.unsigned_abs() as usize];
            (row, clamped(column - reach, columns)..clamped(column + reach + 2, columns), distance)
        });
        rows.filter(|(_, columns, _)| !columns.is_empty())
    }
}

/// The wings of a profile beyond a radius R, with a smooth continuation inside R.
struct Wing<'a> {
    profile: &'a Curve,
    from_pix: f64,
    /// Coefficients of the powers of r² - R² inside the radius R.
    inside: [f64; 3],
}

impl<'a> Wing<'a> {
    fn new(profile: &'a Curve, from_pix: f64) -> Self {
        // The derivatives with respect to r² are computed from three values.
        let (square, step) = (from_pix * from_pix, 0.1 * from_pix * from_pix);
        let [before, value, after] = [square - step, square, square + step].map(|square| profile.at(square.sqrt()));
        let per = if step > 0.0 { 1.0 / step } else { 0.0 };
        let inside = [value, 0.5 * (after - before) * per, 0.5 * (after - 2.0 * value + before) * per * per];
        Self { profile, from_pix, inside }
    }

    fn at(&self, r_pix: f64) -> f64 {
        if r_pix >= self.from_pix {
            return self.profile.at(r_pix);
        }
        let x = r_pix * r_pix - self.from_pix * self.from_pix;
        self.inside[0] + x * (self.inside[1] + x * self.inside[2])
    }

    /// Returns true if interpolation between cells, as done in `points`, has an error below `allowed` divided by the
    /// local width of the light.
    fn is_smooth(&self, cell_pix: f64, allowed: f64, fwhm_pix: f64) -> bool {
        let count = (self.profile.end_pix() / cell_pix * 2.0).ceil() as usize + 2;
        (0..count).all(|number| {
            let r = 0.5 * number as f64 * cell_pix;
            let near = |cells: f64| self.at((r + cells * cell_pix).abs());
            let found: f64 =
                QUARTER.iter().zip([-1.25, -0.25, 0.75, 1.75]).map(|(w, at)| f64::from(*w) * near(at)).sum();
            (found - self.at(r)).abs() * fwhm_pix.max(0.5 * self.from_pix).max(r) <= allowed
        })
    }
}
