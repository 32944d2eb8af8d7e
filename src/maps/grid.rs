//! Directions of a map: regular steps of longitude and latitude, or the centres of HEALPix pixels.

use std::f64::consts::{FRAC_PI_2, TAU};

use rayon::prelude::*;

use crate::error::Error;
use crate::math::healpix::{MOST_NSIDE, cell_count, northern_cell_count, northern_rings};
use crate::watch::Watch;

use super::error::in_range;

/// Default step of a map, degrees.
pub const DEFAULT_STEP_DEG: f64 = 2.0;

/// Default nside of a HEALPix map; its pixels are 0.92° wide.
pub const DEFAULT_NSIDE: u32 = 64;

/// Directions of a map: [`Grid::regular`] or [`Grid::healpix`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Grid(Division);

/// Kinds of grid that the constructors of [`Grid`] create.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Division {
    /// Regular grid with this number of steps in 90°.
    Steps(u32),
    /// HEALPix pixels with this nside.
    Cells(u32),
}

/// Equally spaced directions of one latitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct GridRow {
    /// Latitude, radians.
    pub latitude_rad: f64,
    first_rad: f64,
    step_rad: f64,
    count: usize,
}

impl GridRow {
    /// Returns sine and cosine of each longitude by recurrence. This is ten times faster than direct evaluation; the
    /// error grows by 1e-16 per step.
    pub fn sines_and_cosines(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let (step_sin, step_cos) = self.step_rad.sin_cos();
        // sin(a + s) = sin a cos s + cos a sin s
        let turned =
            move |(sin, cos): &(f64, f64)| Some((sin * step_cos + cos * step_sin, cos * step_cos - sin * step_sin));
        std::iter::successors(Some(self.first_rad.sin_cos()), turned).take(self.count)
    }

    /// Returns the longitudes in order, radians, in [0, 2π).
    pub fn longitudes_rad(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { first_rad, step_rad, count, .. } = *self;
        (0..count).map(move |column| first_rad + column as f64 * step_rad)
    }
}

/// Computes one value for each direction of the rows, in order, on all threads of the current pool.
///
/// # Errors
/// [`Cancelled`](crate::ErrorKind::Cancelled) after [`Watch::stop`].
pub(super) fn fill<T: Copy + Send>(
    rows: Vec<GridRow>,
    blank: T,
    fill_row: impl Fn(&GridRow, &mut [T]) + Sync,
    watch: &Watch,
) -> Result<Vec<T>, Error> {
    let mut all = vec![blank; rows.iter().map(|row| row.count).sum()];
    let mut rest = all.as_mut_slice();
    let mut parts = Vec::with_capacity(rows.len());
    for row in rows {
        let (part, tail) = rest.split_at_mut(row.count);
        parts.push((row, part));
        rest = tail;
    }
    parts.into_par_iter().try_for_each(|(row, part)| {
        watch.check()?;
        fill_row(&row, part);
        Ok(())
    })?;
    Ok(all)
}

impl Grid {
    /// Creates a regular grid with longitudes 0, s, 2s, ... below 360° and latitudes 0, s, 2s, ... up to 90° (or their
    /// negatives), where s is `step_deg`. The pole is repeated for each longitude.
    ///
    /// # Errors
    /// The step is below 0.1 or above 5 degrees, or does not divide 90.
    pub fn regular(step_deg: f64) -> Result<Self, Error> {
        let allowed = "0.1 to 5 deg, in whole fractions of 90 deg";
        let steps = 90.0 / step_deg;
        let is_allowed = (0.1..=5.0).contains(&step_deg) && (steps - steps.round()).abs() < 1e-6;
        in_range("step", step_deg, " deg", allowed, is_allowed)?;
        Ok(Self(Division::Steps(steps.round() as u32)))
    }

    /// Creates a grid of the centres of the 12 nside² HEALPix pixels, in RING order. A hemisphere includes the pixels
    /// centred on the equator.
    ///
    /// # Errors
    /// `nside` is below 1 or above 1024.
    pub fn healpix(nside: u32) -> Result<Self, Error> {
        in_range("nside", f64::from(nside), "", "1 to 1024", (1..=MOST_NSIDE).contains(&nside))?;
        Ok(Self(Division::Cells(nside)))
    }

    /// Returns the nside of a HEALPix grid; `None` for a regular grid.
    pub fn nside(&self) -> Option<u32> {
        match self.0 {
            Division::Steps(_) => None,
            Division::Cells(nside) => Some(nside),
        }
    }

    /// Returns the number of directions in the hemisphere from the equator to a pole.
    pub fn half_len(&self) -> usize {
        match self.0 {
            Division::Steps(steps) => 4 * steps as usize * (steps as usize + 1),
            Division::Cells(nside) => northern_cell_count(nside) as usize,
        }
    }

    /// Returns the rows of the northern hemisphere: regular grids from the equator to the pole, HEALPix pixels in RING
    /// order.
    pub(super) fn northern(&self) -> Vec<GridRow> {
        match self.0 {
            Division::Steps(steps) => {
                let step_rad = FRAC_PI_2 / f64::from(steps);
                let row = |row: u32| GridRow {
                    latitude_rad: (f64::from(row) * step_rad).min(FRAC_PI_2),
                    first_rad: 0.0,
                    step_rad,
                    count: 4 * steps as usize,
                };
                (0..=steps).map(row).collect()
            }
            Division::Cells(nside) => northern_rings(nside)
                .map(|ring| GridRow {
                    latitude_rad: ring.latitude_rad,
                    first_rad: ring.first_rad,
                    step_rad: TAU / f64::from(ring.count),
                    count: ring.count as usize,
                })
                .collect(),
        }
    }

    /// Returns the rows of the southern hemisphere: regular grids from the pole to the equator, HEALPix pixels in RING
    /// order.
    pub(super) fn southern(&self) -> Vec<GridRow> {
        // Rows are symmetric about the equator. HEALPix rings are ordered from north to south in both hemispheres.
        let mirrored = self.northern().into_iter().rev();
        mirrored.map(|row| GridRow { latitude_rad: -row.latitude_rad, ..row }).collect()
    }

    /// Returns the number of the HEALPix pixel at `index` in the northern hemisphere; `None` for a regular grid.
    pub fn northern_cell(&self, index: usize) -> Option<u64> {
        self.nside().map(|_| index as u64)
    }

    /// Returns the number of the HEALPix pixel at `index` in the southern hemisphere; `None` for a regular grid.
    pub fn southern_cell(&self, index: usize) -> Option<u64> {
        self.nside().map(|nside| cell_count(nside) - northern_cell_count(nside) + index as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::healpix::ring_centre_rad;

    fn directions(rows: Vec<GridRow>) -> Vec<(f64, f64)> {
        rows.into_iter()
            .flat_map(|row| row.longitudes_rad().map(move |longitude| (longitude, row.latitude_rad)))
            .collect()
    }

    #[test]
    fn verif_regular_grids_hold_every_step_once() {
        let grid = Grid::regular(5.0).unwrap();
        let all = directions(grid.northern());
        assert_eq!((all.len(), grid.half_len()), (72 * 19, 72 * 19));
        assert_eq!(all[0], (0.0, 0.0));
        assert!((all[73].0.to_degrees() - 5.0).abs() < 1e-12);
        assert!((all[73].1.to_degrees() - 5.0).abs() < 1e-12);
        assert_eq!(all[all.len() - 1].1, FRAC_PI_2);
        let below = directions(grid.southern());
        assert_eq!((below[0].1, below[below.len() - 1].1), (-FRAC_PI_2, 0.0));
        assert!(below.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert_eq!(grid.northern_cell(3), None);
    }

    #[test]
    fn verif_rows_of_cells_hold_their_centres() {
        for nside in [1, 2, 3, 4, 17, 64, 1023, MOST_NSIDE] {
            let grid = Grid::healpix(nside).unwrap();
            for (half, cell) in [
                (grid.northern(), Grid::northern_cell as fn(&Grid, usize) -> Option<u64>),
                (grid.southern(), Grid::southern_cell),
            ] {
                let all = directions(half);
                assert_eq!(all.len(), grid.half_len());
                for (index, (longitude, latitude)) in all.into_iter().enumerate() {
                    let centre = ring_centre_rad(nside, cell(&grid, index).unwrap()).unwrap();
                    assert!(
                        (longitude - centre.0).abs() < 1e-13 && (latitude - centre.1).abs() < 1e-14,
                        "{nside} {index}"
                    );
                }
            }
        }
    }

    #[test]
    fn verif_invalid_grids_are_rejected() {
        for step in [0.0, -1.0, 0.05, 7.0, 5.1, f64::NAN] {
            assert!(Grid::regular(step).is_err(), "{step}");
        }
        for step in [0.1, 0.5, 1.0, 2.0, 2.5, 4.5, 5.0] {
            assert!(Grid::regular(step).is_ok(), "{step}");
        }
        assert!(Grid::healpix(0).is_err() && Grid::healpix(1025).is_err());
    }
}
