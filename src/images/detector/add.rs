//! Light added to a frame that exists.

use rayon::prelude::*;

use crate::images::{Patch, Plane};

use super::conversion::{Purpose, electrons, fraction, stream};
use super::error::DetectorError;
use super::saturation::{Bleeding, Saturated, Saturation};
use super::settings::Detector;

/// A pixel's new charge on top of what it has, electrons.
#[derive(Copy, Clone, Debug, PartialEq)]
struct Change {
    row: usize,
    column: usize,
    e: f32,
}

/// What light makes of one pixel of a frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AddedLight {
    /// Row, counted from 0.
    pub row: usize,
    /// Column, counted from 0.
    pub column: usize,
    /// The signal before the converter, counts: whole ones only by chance. Below 0 for ghosts of a negative coefficient.
    pub signal_adu: f32,
    /// What is added to the pixel's count: the signal, or the step of whole counts within the converter's range that was drawn for it.
    pub change_adu: f32,
}

impl Detector {
    /// Adds light to a frame in counts: what [`light_on`](Detector::light_on) finds, in single precision.
    ///
    /// # Errors
    /// As [`light_on`](Detector::light_on).
    pub fn add_light(&self, frame: &mut Plane, patches: &[Patch], seed: u64) -> Result<Saturated, DetectorError> {
        let (added, saturated) = self.light_on(frame, patches, seed)?;
        for light in added {
            let pixel = &mut frame.row_mut(light.row)[light.column];
            *pixel = (f64::from(*pixel) + f64::from(light.change_adu)) as f32;
        }
        Ok(saturated)
    }

    /// What light makes of a frame in counts, pixel by pixel in order, and what saturated; the patches hold expected electrons before vignetting and were drawn for the frame's shape.
    ///
    /// What the frame shows already stays as it is: only the added light gets photon noise, vignetting and ghosts by crosstalk, and there is no
    /// new read noise. Full wells hold the sum of both: what does not fit bleeds, and a pixel that shows more than its well holds
    /// keeps that. Counts become electrons by gain, bias and the inverse of the non-linearity, and back. Where counts are whole, the
    /// fraction that the converter cut off is drawn at random first, so that light of less than a count is not lost. Pixels without new charge are not
    /// among the answers, nor are those that are not a number; what is beyond the converter's range already stays.
    ///
    /// Changes are found as such and not as differences of counts, which of a frame of 10⁹ counts would hold no light of less than 64.
    /// With `shot_noise = false` and nothing else the light is simply added. The same seed gives the same frame on any number of threads.
    ///
    /// # Errors
    /// As [`Detector::validate`]; [`DetectorError::Shape`] where a patch is for another frame; [`DetectorError::AmplifierOutside`].
    pub fn light_on(
        &self,
        frame: &Plane,
        patches: &[Patch],
        seed: u64,
    ) -> Result<(Vec<AddedLight>, Saturated), DetectorError> {
        let (rows, columns) = (frame.rows(), frame.columns());
        self.validate_for(rows, columns)?;
        if let Some(patch) = patches.iter().find(|patch| (patch.rows(), patch.columns()) != (rows, columns)) {
            let (light_rows, light_columns) = (patch.rows(), patch.columns());
            return Err(DetectorError::Shape { light_rows, light_columns, rows, columns });
        }
        let mut changes: Vec<Change> =
            (0..rows).into_par_iter().flat_map_iter(|row| self.light_of_row(frame, patches, seed, row)).collect();
        let mut saturated = Saturated::default();
        if let Some(saturation) = &self.saturation {
            saturated = self.fill_wells(frame, saturation, &mut changes);
        }
        let measured: Vec<Change> = changes.par_iter().map(|change| self.signal_of(frame, *change)).collect();
        let mut ghosts = Vec::new();
        if let Some(crosstalk) = &self.crosstalk {
            for change in &measured {
                crosstalk.spread(change.row, change.column, change.e, |row, column, e| {
                    ghosts.push(Change { row, column, e });
                });
            }
        }
        let mut all = measured;
        all.append(&mut ghosts);
        // Stable: sums do not depend on anything but the order of amplifiers.
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

    /// Charge that the light of all patches makes in one row.
    fn light_of_row(&self, frame: &Plane, patches: &[Patch], seed: u64, row: usize) -> Vec<Change> {
        let mut spans: Vec<_> =
            patches.iter().map(|patch| patch.row(row)).filter(|span| !span.values.is_empty()).collect();
        spans.sort_by_key(|span| span.first_column);
        // Spans that touch become one, so that each pixel gets one number from the row's stream.
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
                vignetting.apply(frame.rows(), frame.columns(), row, first, &mut values);
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

    /// Electrons that a count stands for.
    fn charge_of(&self, count: f32) -> f64 {
        let measured = (f64::from(count) - self.bias_adu) * self.gain_e_adu;
        self.non_linearity.as_ref().map_or(measured, |non_linearity| non_linearity.true_e(measured))
    }

    /// What is measured of a change of charge.
    fn signal_of(&self, frame: &Plane, change: Change) -> Change {
        let Some(non_linearity) = &self.non_linearity else { return change };
        let before = self.charge_of(frame.row(change.row)[change.column]);
        let e = non_linearity.measured(before + f64::from(change.e)) - non_linearity.measured(before);
        Change { e: e as f32, ..change }
    }

    /// Cuts changes to what pixels hold, and adds those of the pixels that the rest bleeds into.
    fn fill_wells(&self, frame: &Plane, saturation: &Saturation, changes: &mut Vec<Change>) -> Saturated {
        let full = saturation.full_well_e;
        let overflows =
            |change: &&Change| self.charge_of(frame.row(change.row)[change.column]) + f64::from(change.e) > full;
        let over: Vec<&Change> = changes.iter().filter(overflows).collect();
        let (Some(first), Some(last)) =
            (over.iter().map(|change| change.column).min(), over.iter().map(|change| change.column).max())
        else {
            return Saturated::default();
        };
        // Charge stays in its columns or rows: only those that overflow are looked at.
        let (columns, rows) = match saturation.bleeding {
            Bleeding::Columns => (first..last + 1, 0..frame.rows()),
            Bleeding::Rows | Bleeding::Off => (0..frame.columns(), over[0].row..over[over.len() - 1].row + 1),
        };
        let mut room = Plane::zeros(rows.len(), columns.len());
        for (number, row) in rows.clone().enumerate() {
            for (room, count) in room.row_mut(number).iter_mut().zip(&frame.row(row)[columns.clone()]) {
                *room = (full - self.charge_of(*count)).max(0.0) as f32;
            }
        }
        let mut added = Plane::zeros(rows.len(), columns.len());
        let is_inside = |change: &Change| columns.contains(&change.column) && rows.contains(&change.row);
        // Pixels without a value hold nothing and let nothing bleed.
        let holds = |change: &&Change| is_inside(change) && !frame.row(change.row)[change.column].is_nan();
        for change in changes.iter().filter(holds) {
            added.row_mut(change.row - rows.start)[change.column - columns.start] += change.e;
        }
        let saturated = saturation.apply(&mut added, Some(&room));
        changes.retain(|change| !is_inside(change));
        for (number, row) in rows.enumerate() {
            let of_row = added.row(number).iter().zip(columns.clone());
            changes.extend(of_row.filter(|(e, _)| **e != 0.0).map(|(&e, column)| Change { row, column, e }));
        }
        changes.sort_by_key(|change| (change.row, change.column));
        saturated
    }
}
