//! Saturation of pixels at their full well, and bleeding of the excess charge.

use serde::Deserialize;

use crate::error::Error;
use crate::images::Plane;

/// Full well of the pixels, and what happens to charge above it.
#[derive(Copy, Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Saturation {
    /// Full well, electrons, \[1, 1e9\].
    pub full_well_e: f64,
    /// Where charge above the full well goes.
    #[serde(default)]
    pub bleeding: Bleeding,
}

/// Where charge above the full well goes.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bleeding {
    /// Along the columns: half of the charge upwards and half downwards, to the next pixels with free capacity. Charge
    /// that reaches the edge of the frame is lost.
    #[default]
    Columns,
    /// Along the rows, for detectors that are read along their rows.
    Rows,
    /// The charge is lost (anti-blooming drains, most CMOS detectors).
    Off,
}

/// Number of saturated pixels and lost charge.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Saturated {
    /// Pixels that receive more charge from light than their full well, before bleeding.
    pub pixels: usize,
    /// Charge that left the frame at its edges or was drained, electrons.
    pub lost_e: f64,
}

impl Saturation {
    pub(super) fn validate(&self) -> Result<(), Error> {
        Error::check_range("saturation.full_well_e", self.full_well_e, 1.0, 1e9)
    }

    /// Limits all pixels to their capacity, and distributes the excess charge by bleeding.
    ///
    /// `capacity` is the free capacity of each pixel, electrons, 0 or more, for charge that is added to an existing
    /// frame. It has the shape of `charge`. If it is `None`, all pixels are initially empty.
    pub(super) fn apply(&self, charge: &mut Plane, capacity: Option<&Plane>) -> Saturated {
        let (rows, columns) = (charge.rows(), charge.columns());
        let full = self.full_well_e as f32;
        let capacity_of = |row: usize, column: usize| capacity.map_or(full, |capacity| capacity.row(row)[column]);
        let mut saturated = Saturated::default();
        let mut excess: Vec<(usize, usize, f32)> = Vec::new();
        for row in 0..rows {
            for (column, value) in charge.row_mut(row).iter_mut().enumerate() {
                let most = capacity_of(row, column);
                if *value > most {
                    excess.push((row, column, *value - most));
                    *value = most;
                }
            }
        }
        saturated.pixels = excess.len();
        let all = |excess: &[(usize, usize, f32)]| excess.iter().map(|(_, _, e)| f64::from(*e)).sum::<f64>();
        let is_along_rows = match self.bleeding {
            Bleeding::Columns => false,
            Bleeding::Rows => true,
            Bleeding::Off => {
                saturated.lost_e = all(&excess);
                return saturated;
            }
        };
        // Charge moves along lines of pixels (rows or columns); a pixel is given by its line and its position on the
        // line.
        let positioned = |(row, column, e): (usize, usize, f32)| {
            let (line, position) = if is_along_rows { (row, column) } else { (column, row) };
            (line, position, f64::from(e))
        };
        let mut excess: Vec<(usize, usize, f64)> = excess.into_iter().map(positioned).collect();
        excess.sort_by_key(|(line, position, _)| (*line, *position));
        let length = if is_along_rows { columns } else { rows };
        for line in excess.chunk_by(|a, b| a.0 == b.0) {
            let mut fill = |position: usize, carried: f64| -> f64 {
                let (row, column) = if is_along_rows { (line[0].0, position) } else { (position, line[0].0) };
                let capacity = f64::from(capacity_of(row, column));
                let pixel = &mut charge.row_mut(row)[column];
                let filled = carried.min((capacity - f64::from(*pixel)).max(0.0));
                *pixel = (f64::from(*pixel) + filled) as f32;
                carried - filled
            };
            saturated.lost_e += bleed(line.iter().map(|(_, position, e)| (*position, *e)), 0..length, &mut fill);
            saturated.lost_e +=
                bleed(line.iter().rev().map(|(_, position, e)| (*position, *e)), (0..length).rev(), &mut fill);
        }
        saturated
    }
}

/// Moves half of each excess charge along the pixels in the given order. Returns the charge that is left after the last
/// pixel.
fn bleed(
    excess: impl Iterator<Item = (usize, f64)>,
    positions: impl Iterator<Item = usize>,
    fill: &mut impl FnMut(usize, f64) -> f64,
) -> f64 {
    let mut sources = excess.peekable();
    let mut carried = 0.0;
    for position in positions {
        if carried > 0.0 {
            carried = fill(position, carried);
        }
        if let Some((_, e)) = sources.next_if(|(source, _)| *source == position) {
            carried += 0.5 * e;
        }
    }
    carried
}
