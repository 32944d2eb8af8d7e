//! Predictions of each pass from the other passes, which state how much learning improves.

use rayon::prelude::*;

use super::hierarchy::fit_kind;
use super::pass::Pass;
use crate::elements::Generation;
use crate::output::{Column, Kind, Table};
use crate::passes::ModelChoice;

/// Predictions of the passes of one kind, or of all kinds, from a number of other passes of each satellite.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LeaveOutRow {
    /// Kind of satellite; `None` for all kinds.
    pub kind: Option<Generation>,
    /// Number of other passes of the satellite that are used.
    pub seen: usize,
    /// Number of predicted passes.
    pub passes: usize,
    /// Root mean square of the residuals from the model, mag. Passes have equal weights.
    pub model_rms_mag: f64,
    /// Root mean square of the residuals from the learned magnitudes, mag.
    pub learned_rms_mag: f64,
    /// Fraction of the measurements within one sigma of the model. Passes have equal weights.
    pub model_within: f64,
    /// Fraction of the measurements within one sigma of the learned magnitudes.
    pub learned_within: f64,
}

/// Sums over the measurements of one pass, each divided by their number: residual² and share within one sigma, of the
/// model and of the learned magnitudes.
type Sums = [f64; 4];

/// Predicts each pass from the passes of the other satellites and from `seen` other passes of its own satellite, the
/// first ones in time.
///
/// Passes of satellites with fewer other passes are omitted. The rows are in order of kind and number; rows for all
/// kinds are the last.
pub fn leave_passes_out(passes: &[Pass], models: &ModelChoice, seen: &[usize]) -> Vec<LeaveOutRow> {
    let mut kinds: Vec<Generation> = passes.iter().map(|pass| pass.kind).collect();
    kinds.sort();
    kinds.dedup();
    let mut found: Vec<(Generation, usize, Vec<Sums>)> = Vec::new();
    for kind in kinds {
        let of_kind: Vec<&Pass> = passes.iter().filter(|pass| pass.kind == kind).collect();
        let Some(sigma_mag) = models.of_kind(kind).map(|model| model.sigma_mag()) else { continue };
        for &seen in seen {
            let predicted = |left_out: &&Pass| {
                let own = of_kind.iter().filter(|pass| pass.norad_id == left_out.norad_id && *pass != left_out);
                let own: Vec<&Pass> = own.take(seen).copied().collect();
                if own.len() < seen {
                    return None;
                }
                let others = of_kind.iter().filter(|pass| pass.norad_id != left_out.norad_id).copied();
                let training: Vec<&Pass> = others.chain(own).collect();
                let learned = fit_kind(&training, sigma_mag).predict(left_out.norad_id);
                let share = 1.0 / left_out.points.len() as f64;
                let mut sums = [0.0; 4];
                for point in &left_out.points {
                    let (old, new) = (point.residual_mag, point.residual_mag - learned.offset_mag);
                    let within = |x: f64, sigma: f64| f64::from(u8::from(x.abs() <= sigma));
                    let values = [old * old, new * new, within(old, sigma_mag), within(new, learned.sigma_mag)];
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
                }
                Some(sums)
            };
            found.push((kind, seen, of_kind.par_iter().filter_map(predicted).collect()));
        }
    }
    let row = |kind: Option<Generation>, seen: usize| {
        let selected = found.iter().filter(|(of, n, _)| *n == seen && kind.is_none_or(|kind| kind == *of));
        let sums: Vec<Sums> = selected.flat_map(|(_, _, sums)| sums.iter().copied()).collect();
        let mean = |at: usize| sums.iter().map(|sums| sums[at]).sum::<f64>() / sums.len() as f64;
        (!sums.is_empty()).then(|| LeaveOutRow {
            kind,
            seen,
            passes: sums.len(),
            model_rms_mag: mean(0).sqrt(),
            learned_rms_mag: mean(1).sqrt(),
            model_within: mean(2),
            learned_within: mean(3),
        })
    };
    let by_kind = found.iter().filter_map(|(kind, seen, _)| row(Some(*kind), *seen));
    by_kind.chain(seen.iter().filter_map(|seen| row(None, *seen))).collect()
}

const COLUMNS: [Column; 7] = [
    Column::new("kind", Kind::Text, "Kind of satellite; all for all kinds."),
    Column::new("seen_passes", Kind::Integer, "Number of other passes of the satellite that are used."),
    Column::new("passes", Kind::Integer, "Number of predicted passes."),
    Column::real("model_rms_mag", "mag", 3, "Root mean square of the residuals from the model."),
    Column::real("learned_rms_mag", "mag", 3, "Root mean square of the residuals from the learned magnitudes."),
    Column::real("model_within_one_sigma", "", 3, "Fraction of the measurements within one sigma of the model."),
    Column::real("learned_within_one_sigma", "", 3, "Fraction within one sigma of the learned magnitudes."),
];

/// Returns a table with one row for each kind and number of passes.
pub fn leave_out_table(rows: &[LeaveOutRow]) -> Table {
    let cells = |row: &LeaveOutRow| {
        vec![
            row.kind.map_or("all", Generation::name).into(),
            row.seen.into(),
            row.passes.into(),
            row.model_rms_mag.into(),
            row.learned_rms_mag.into(),
            row.model_within.into(),
            row.learned_within.into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: rows.iter().map(cells).collect() }
}
