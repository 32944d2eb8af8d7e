//! Predictions of each pass from the other passes, which show by how much learning improves predictions.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::hierarchy::fit_kind;
use super::pass::Pass;
use crate::elements::{Generation, NoradId};
use crate::error::Error;
use crate::output::{Column, Kind, Table};
use crate::passes::ModelChoice;
use crate::watch::Watch;

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
    /// Half width that contains 68.27 % of the residuals from the model, mag. Passes have equal weights.
    pub model_half_width_mag: f64,
    /// Half width that contains 68.27 % of the residuals from the learned magnitudes, mag.
    pub learned_half_width_mag: f64,
    /// Fraction of the measurements within one sigma of the model. Passes have equal weights.
    pub model_within: f64,
    /// Fraction of the measurements within one sigma of the learned magnitudes.
    pub learned_within: f64,
}

/// Residual of a measurement from the model and from the learned magnitude, mag, and the sigmas of both. The weight is
/// 1 over the number of measurements of the pass.
#[derive(Copy, Clone)]
struct HeldOut {
    residuals_mag: [f64; 2],
    sigmas_mag: [f64; 2],
    weight: f64,
}

/// Fraction of a normal distribution within one sigma.
const ONE_SIGMA_SHARE: f64 = 0.6827;

/// Root mean square, half width that contains 68.27 %, and fraction within one sigma; `which` is 0 for the model, 1 for
/// the learned magnitudes.
fn statistics(held_out: &[HeldOut], which: usize) -> [f64; 3] {
    let mut sizes: Vec<(f64, f64)> =
        held_out.iter().map(|held| (held.residuals_mag[which].abs(), held.weight)).collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = sizes.iter().map(|(_, weight)| weight).sum();
    let rms = (sizes.iter().map(|(size, weight)| weight * size * size).sum::<f64>() / all).sqrt();
    let mut below = 0.0;
    let half_width = sizes.iter().find(|(_, weight)| {
        below += weight;
        below >= ONE_SIGMA_SHARE * all
    });
    let is_within = |held: &&HeldOut| held.residuals_mag[which].abs() <= held.sigmas_mag[which];
    let within = held_out.iter().filter(is_within).map(|held| held.weight).sum::<f64>() / all;
    [rms, half_width.map_or(f64::NAN, |(size, _)| *size), within]
}

/// Predicts each pass from the passes of the other satellites and from `seen` other passes of its own satellite, the
/// first ones in time.
///
/// Passes of satellites with fewer other passes are omitted. The rows are in order of kind and number; rows for all
/// kinds are the last.
pub fn leave_passes_out(passes: &[Pass], models: &ModelChoice, seen: &[usize]) -> Vec<LeaveOutRow> {
    let mut kinds: Vec<Generation> = passes.iter().map(|pass| pass.kind()).collect();
    kinds.sort();
    kinds.dedup();
    let mut found: Vec<(Generation, usize, Vec<Vec<HeldOut>>)> = Vec::new();
    for kind in kinds {
        let of_kind: Vec<&Pass> = passes.iter().filter(|pass| pass.kind() == kind).collect();
        let Some(sigma_mag) = models.of_kind(kind).map(|model| model.sigma_mag()) else { continue };
        for &seen in seen {
            let predicted = |left_out: &&Pass| {
                let is_own = |pass: &&Pass| pass.norad_id() == left_out.norad_id();
                let own = of_kind.iter().copied().filter(|pass| is_own(pass) && !std::ptr::eq(*pass, *left_out));
                let own: Vec<&Pass> = own.take(seen).collect();
                if own.len() < seen {
                    return None;
                }
                let others = of_kind.iter().copied().filter(|pass| !is_own(pass));
                let training: Vec<&Pass> = others.chain(own).collect();
                let learned = fit_kind(&training, sigma_mag).predict(left_out.norad_id());
                let held_out = left_out.points().iter().map(|point| HeldOut {
                    residuals_mag: [point.residual_mag, point.residual_mag - learned.offset_mag],
                    sigmas_mag: [sigma_mag, learned.sigma_mag],
                    weight: 1.0 / left_out.points().len() as f64,
                });
                Some(held_out.collect())
            };
            found.push((kind, seen, of_kind.par_iter().filter_map(predicted).collect()));
        }
    }
    let row = |kind: Option<Generation>, seen: usize| {
        let selected = found.iter().filter(|(of, n, _)| *n == seen && kind.is_none_or(|kind| kind == *of));
        let passes: Vec<&Vec<HeldOut>> = selected.flat_map(|(_, _, passes)| passes).collect();
        let held_out: Vec<HeldOut> = passes.iter().flat_map(|pass| pass.iter().copied()).collect();
        let [model, learned] = [0, 1].map(|which| statistics(&held_out, which));
        (!passes.is_empty()).then(|| LeaveOutRow {
            kind,
            seen,
            passes: passes.len(),
            model_rms_mag: model[0],
            learned_rms_mag: learned[0],
            model_half_width_mag: model[1],
            learned_half_width_mag: learned[1],
            model_within: model[2],
            learned_within: learned[2],
        })
    };
    let by_kind = found.iter().filter_map(|(kind, seen, _)| row(Some(*kind), *seen));
    by_kind.chain(seen.iter().filter_map(|seen| row(None, *seen))).collect()
}

/// Smallest number of passes of satellites with other passes from which the gain of offsets of satellites is judged.
const LEAST_JUDGED: usize = 10;
/// Largest number of passes from which the gain of offsets of satellites is judged. Of more passes those of some
/// satellites are used, at equal steps of their numbers: the time would otherwise grow with the square of the passes.
const MOST_JUDGED: usize = 500;

/// Returns true if offsets of single satellites predict their other passes better than the offset of the kind: the mean
/// absolute difference of the medians of passes is smaller. Each pass is predicted without itself.
///
/// True with fewer than ten passes of satellites that have others: the offsets are then shrunk towards that of the
/// kind.
///
/// # Errors
/// [`Cancelled`](crate::ErrorKind::Cancelled) if `watch` stops.
pub(super) fn satellites_differ(of_kind: &[&Pass], sigma_mag: f64, watch: &Watch) -> Result<bool, Error> {
    let mut by_satellite: BTreeMap<NoradId, Vec<&Pass>> = BTreeMap::new();
    of_kind.iter().for_each(|pass| by_satellite.entry(pass.norad_id()).or_default().push(*pass));
    let repeated = by_satellite.values().filter(|passes| passes.len() > 1);
    let step = of_kind.len().div_ceil(MOST_JUDGED).max(1);
    let judged: Vec<&Pass> = repeated.step_by(step).flatten().copied().take(MOST_JUDGED).collect();
    if judged.len() < LEAST_JUDGED {
        return Ok(true);
    }
    let all = if step > 1 { &judged } else { of_kind };
    let differences = |left_out: &&Pass| {
        watch.check()?;
        let others: Vec<&Pass> = all.iter().copied().filter(|pass| !std::ptr::eq(*pass, *left_out)).collect();
        let fit = fit_kind(&others, sigma_mag);
        // No satellite has the number 0: the prediction of the kind.
        Ok([left_out.norad_id(), NoradId(0)].map(|id| (left_out.median_mag() - fit.predict(id).offset_mag).abs()))
    };
    let [own, kind] = judged
        .par_iter()
        .map(differences)
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .fold([0.0, 0.0], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
    Ok(own < kind)
}

const COLUMNS: [Column; 9] = [
    Column::new("kind", Kind::Text, "Kind of satellite; all for all kinds."),
    Column::new("seen_passes", Kind::Integer, "Number of other passes of the satellite that are used."),
    Column::new("passes", Kind::Integer, "Number of predicted passes."),
    Column::real("model_rms_mag", "mag", 3, "Root mean square of the residuals from the model."),
    Column::real("learned_rms_mag", "mag", 3, "Root mean square of the residuals from the learned magnitudes."),
    Column::real("model_half_width_mag", "mag", 3, "Half width that contains 68 % of the residuals from the model."),
    Column::real("learned_half_width_mag", "mag", 3, "Half width that contains 68 % from the learned magnitudes."),
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
            row.model_half_width_mag.into(),
            row.learned_half_width_mag.into(),
            row.model_within.into(),
            row.learned_within.into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: rows.iter().map(cells).collect() }
}
