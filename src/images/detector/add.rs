//! Light added to an existing frame through the stages of a detector.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Error;
use crate::images::{Patch, Plane};

use super::conversion::{Purpose, electrons, fraction, stream};
use super::saturation::{Bleeding, Saturated, Saturation};
use super::settings::Detector;

/// Number of rows or columns whose full wells are filled at once.
const LINES: usize = 256;

/// Adjacent rows of a frame in counts.
#[derive(Copy, Clone, Debug)]
pub struct FrameRows<'a> {
    /// Pixels of the rows.
    pub counts: &'a Plane,
    /// First of the rows.
    pub first_row: usize,
    /// Number of rows of the frame.
    pub frame_rows: usize,
}

impl FrameRows<'_> {
    fn rows(&self) -> Range<usize> {
        self.first_row..self.first_row + self.counts.rows()
    }

    fn row(&self, row: usize) -> &[f32] {
        self.counts.row(row - self.first_row)
    }
}

/// Charge added to a pixel, electrons.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Change {
    row: usize,
    column: usize,
    e: f32,
}

/// Effect of added light on one pixel of a frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AddedLight {
    /// Row, counted from 0.
    pub row: usize,
    /// Column, counted from 0.
    pub column: usize,
    /// Added signal before the analogue-to-digital converter, counts, in general not an integer. It is negative for
    /// ghosts with a negative crosstalk coefficient.
    pub signal_adu: f32,
    /// Change of the pixel's count. It is the signal itself, or a random integer with the signal as its mean, limited
    /// to the range of the converter.
    pub change_adu: f32,
}

impl Detector {
    /// Adds the light computed by [`added_light`](Detector::added_light) to a frame in counts. Sums are in single
    /// precision.
    ///
    /// # Errors
    /// The errors of [`added_light`](Detector::added_light).
    pub fn add_light(&self, frame: &mut Plane, patches: &[Patch], seed: u64) -> Result<Saturated, Error> {
        let whole = FrameRows { counts: frame, first_row: 0, frame_rows: frame.rows() };
        let (added, saturated) = self.added_light(whole, patches, seed)?;
        for light in added {
            let pixel = &mut frame.row_mut(light.row)[light.column];
            *pixel = (f64::from(*pixel) + f64::from(light.change_adu)) as f32;
        }
        Ok(saturated)
    }

    /// Returns true if light in one row changes pixels in others, so that
    /// [`added_light`](Detector::added_light) needs all rows of the frame at once.
    pub fn mixes_rows(&self) -> bool {
        let bleeds = self.saturation.as_ref().is_some_and(|saturation| saturation.bleeding == Bleeding::Columns);
        bleeds || self.crosstalk.is_some()
    }

    /// Computes the effect of added light on rows of a frame in counts: the changed pixels in order, and the
    /// saturation.
    ///
    /// The patches contain expected electrons before vignetting and have the shape of the frame. Photon noise,
    /// vignetting and crosstalk are applied to the added light only, and no read noise is added. Saturation depends on
    /// the sum of existing and added light: charge above the full well bleeds, while a pixel that already exceeds its
    /// full well keeps its charge. Existing counts are converted to electrons with the gain, the bias and the inverse
    /// of the non-linearity. If counts are integers, a random fraction is added before the converter, so that light of
    /// less than a count is kept on average. The result omits pixels without new charge and NaN pixels. Existing counts
    /// beyond the converter's range are kept.
    ///
    /// Changes are computed directly, not as differences of counts, because a frame of 10⁹ counts in single precision
    /// does not resolve changes below 64. With `shot_noise = false` and no other stage, the light is simply added. The
    /// result depends on the seed, but not on the number of threads.
    ///
    /// # Errors
    /// The errors of [`Detector::validate`]; a patch for a frame of another shape; an amplifier that extends beyond the
    /// frame.
    pub fn added_light(
        &self,
        frame: FrameRows<'_>,
        patches: &[Patch],
        seed: u64,
    ) -> Result<(Vec<AddedLight>, Saturated), Error> {
        let (rows, columns) = (frame.frame_rows, frame.counts.columns());
        self.validate_for(rows, columns)?;
        if let Some(patch) = patches.iter().find(|patch| (patch.rows(), patch.columns()) != (rows, columns)) {
            let size = |rows, columns| format!("{rows} rows by {columns} columns");
            let allowed = format!("{}, the size of the frame", size(rows, columns));
            return Err(Error::invalid("size of the light", size(patch.rows(), patch.columns()), allowed));
        }
        let mut changes: Vec<Change> =
            frame.rows().into_par_iter().flat_map_iter(|row| self.light_of_row(frame, patches, seed, row)).collect();
        let mut saturated = Saturated::default();
        if let Some(saturation) = &self.saturation {
            saturated = self.fill_wells(frame, saturation, &mut changes);
        }
        changes.par_iter_mut().for_each(|change| *change = self.signal_of(frame, *change));
        let mut ghosts = Vec::new();
        if let Some(crosstalk) = &self.crosstalk {
            for change in &changes {
                crosstalk.spread(change.row, change.column, change.e, |row, column, e| {
                    ghosts.push(Change { row, column, e });
                });
            }
        }
        let mut all = changes;
        all.append(&mut ghosts);
        // The sort is stable, so that sums depend only on the order of the amplifiers.
        all.sort_by_key(|change| (change.row, change.column));
        let mut added = Vec::with_capacity(all.len());
        for of_row in all.chunk_by(|a, b| a.row == b.row) {
            let row = of_row[0].row;
            let mut random = stream(seed, Purpose::Rounding, row);
            for of_pixel in of_row.chunk_by(|a, b| a.column == b.column) {
                let column = of_pixel[0].column;
                let e: f64 = of_pixel.iter().map(|change| f64::from(change.e)).sum();
                let count = frame.row(row)[column];
                let signal_adu = e / self.gain_e_adu;
                let change_adu = match &self.quantisation {
                    Some(quantisation) => {
                        quantisation.step(f64::from(count), signal_adu + f64::from(fraction(&mut random)))
                    }
                    None => signal_adu,
                };
                if signal_adu != 0.0 && count.is_finite() {
                    let (signal_adu, change_adu) = (signal_adu as f32, change_adu as f32);
                    added.push(AddedLight { row, column, signal_adu, change_adu });
                }
            }
        }
        Ok((added, saturated))
    }

    /// Returns the charge that the light of all patches gives to the pixels of one row.
    fn light_of_row(&self, frame: FrameRows<'_>, patches: &[Patch], seed: u64, row: usize) -> Vec<Change> {
        let mut spans: Vec<_> =
            patches.iter().map(|patch| patch.row(row)).filter(|span| !span.values.is_empty()).collect();
        spans.sort_by_key(|span| span.first_column);
        // Adjacent spans are merged, so that each pixel uses exactly one number of the row's random stream.
        let mut merged: Vec<(usize, Vec<f32>)> = Vec::new();
        for span in spans {
            let end = span.first_column + span.values.len();
            match merged.last_mut() {
                Some((first, values)) if *first + values.len() >= span.first_column => {
                    let length = values.len().max(end - *first);
                    values.resize(length, 0.0);
                    for (value, light) in values[span.first_column - *first..].iter_mut().zip(span.values) {
                        *value += light;
                    }
                }
                _ => merged.push((span.first_column, span.values.to_vec())),
            }
        }
        let mut random = stream(seed, Purpose::Shot, row);
        let mut changes = Vec::new();
        for (first, mut values) in merged {
            if let Some(vignetting) = &self.vignetting {
                vignetting.apply(frame.frame_rows, frame.counts.columns(), row, first, &mut values);
            }
            for (column, light) in (first..).zip(values) {
                let e = if self.shot_noise { electrons(light, &mut random) } else { light };
                if e != 0.0 {
                    changes.push(Change { row, column, e });
                }
            }
        }
        changes
    }

    /// Returns the charge, in electrons, that corresponds to a count.
    fn charge_of(&self, count: f32) -> f64 {
        let measured = (f64::from(count) - self.bias_adu) * self.gain_e_adu;
        self.non_linearity.as_ref().map_or(measured, |non_linearity| non_linearity.true_e(measured))
    }

    /// Returns the change of the measured signal that a change of charge causes.
    fn signal_of(&self, frame: FrameRows<'_>, change: Change) -> Change {
        let Some(non_linearity) = &self.non_linearity else { return change };
        let before = self.charge_of(frame.row(change.row)[change.column]);
        let e = non_linearity.measured(before + f64::from(change.e)) - non_linearity.measured(before);
        Change { e: e as f32, ..change }
    }

    /// Limits changes to the free capacity of the pixels, and adds changes of the pixels into which the excess charge
    /// bleeds.
    fn fill_wells(&self, frame: FrameRows<'_>, saturation: &Saturation, changes: &mut Vec<Change>) -> Saturated {
        let full = saturation.full_well_e;
        let overflows =
            |change: &&Change| self.charge_of(frame.row(change.row)[change.column]) + f64::from(change.e) > full;
        let is_along_columns = saturation.bleeding == Bleeding::Columns;
        let line = |change: &Change| if is_along_columns { change.column } else { change.row };
        let over = || changes.iter().filter(overflows).map(line);
        let (Some(first), Some(last)) = (over().min(), over().max()) else { return Saturated::default() };
        let mut saturated = Saturated::default();
        // Charge bleeds along one direction only, so only the columns or rows with an excess are processed.
        for first in (first..last + 1).step_by(LINES) {
            let lines = first..(last + 1).min(first + LINES);
            let (rows, columns) =
                if is_along_columns { (frame.rows(), lines) } else { (lines, 0..frame.counts.columns()) };
            let mut capacity = Plane::zeros(rows.len(), columns.len());
            for (number, row) in rows.clone().enumerate() {
                for (capacity, count) in capacity.row_mut(number).iter_mut().zip(&frame.row(row)[columns.clone()]) {
                    *capacity = (full - self.charge_of(*count)).max(0.0) as f32;
                }
            }
            let mut added = Plane::zeros(rows.len(), columns.len());
            let is_inside = |change: &Change| columns.contains(&change.column) && rows.contains(&change.row);
            // NaN pixels have no charge and do not bleed.
            let holds = |change: &&Change| is_inside(change) && !frame.row(change.row)[change.column].is_nan();
            for change in changes.iter().filter(holds) {
                added.row_mut(change.row - rows.start)[change.column - columns.start] += change.e;
            }
            let of_lines = saturation.apply(&mut added, Some(&capacity));
            saturated.pixels += of_lines.pixels;
            saturated.lost_e += of_lines.lost_e;
            changes.retain(|change| !is_inside(change));
            for (number, row) in rows.enumerate() {
                let of_row = added.row(number).iter().zip(columns.clone());
                changes.extend(of_row.filter(|(e, _)| **e != 0.0).map(|(&e, column)| Change { row, column, e }));
            }
        }
        changes.sort_by_key(|change| (change.row, change.column));
        saturated
    }
}
