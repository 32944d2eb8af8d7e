//! What a form says of points that it has not seen.

use rayon::prelude::*;

use super::error::FitError;
use super::form::{BLOCK, Form};
use super::point::FitPoint;
use super::solve::{FitSettings, Problem};

/// Residuals of points that were held out of the fit that predicts them.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldOut {
    /// Observed minus predicted, mag, in the order of the points; not a number where the form says nothing of a point.
    pub residuals_mag: Vec<f64>,
    /// Fold in which each point was held out.
    pub folds: Vec<usize>,
}

/// Each group once, in order.
fn groups_of(points: &[FitPoint]) -> Vec<u32> {
    let mut groups: Vec<u32> = points.iter().map(|point| point.group).collect();
    groups.sort_unstable();
    groups.dedup();
    groups
}

/// Which fold each point is held out in: groups in the order of their numbers, dealt out in turn, so that a group is never split.
pub fn folds_by_group(points: &[FitPoint], folds: usize) -> Vec<usize> {
    let groups = groups_of(points);
    let rank = |group: u32| groups.partition_point(|&other| other < group);
    points.iter().map(|point| rank(point.group) % folds.max(1)).collect()
}

/// Fits as often as there are folds, each time without one of them, and predicts that one.
///
/// # Errors
/// [`FitError::Folds`] where there are fewer groups than folds or fewer than two folds; those of [`Problem`] of any fold.
pub fn cross_validate(
    form: &dyn Form,
    points: &[FitPoint],
    settings: &FitSettings,
    folds: usize,
) -> Result<HeldOut, FitError> {
    let of_point = folds_by_group(points, folds);
    let groups = groups_of(points);
    if folds < 2 || groups.len() < folds {
        return Err(FitError::Folds { groups: groups.len(), folds });
    }
    let parts: Vec<Vec<(usize, f64)>> = (0..folds)
        .into_par_iter()
        .map(|fold| {
            let split =
                |inside: bool| (0..points.len()).filter(|&i| (of_point[i] == fold) == inside).collect::<Vec<_>>();
            let (held, seen) = (split(true), split(false));
            let of = |indices: &[usize]| indices.iter().map(|&i| points[i]).collect::<Vec<FitPoint>>();
            let fit = Problem::new(form, &of(&seen), settings)?.solve()?;
            let predicted = predict(form, &of(&held), &fit.values());
            Ok(held.iter().zip(predicted).map(|(&i, predicted)| (i, points[i].magnitude - predicted)).collect())
        })
        .collect::<Result<_, FitError>>()?;
    let mut residuals_mag = vec![f64::NAN; points.len()];
    parts.into_iter().flatten().for_each(|(i, residual)| residuals_mag[i] = residual);
    Ok(HeldOut { residuals_mag, folds: of_point })
}

/// Magnitudes at 1000 km that a form with these parameters (all, in order) predicts; not a number where it says nothing.
pub fn predict(form: &dyn Form, points: &[FitPoint], x: &[f64]) -> Vec<f64> {
    let prepared = form.prepare(points);
    let evaluated = prepared.at(x);
    let mut out = [0.0; BLOCK];
    let mut predicted = Vec::with_capacity(points.len());
    for i in 0..points.len() {
        if i % BLOCK == 0 {
            evaluated.magnitudes(i / BLOCK, &mut out);
        }
        predicted.push(if prepared.explains(i) { out[i % BLOCK] } else { f64::NAN });
    }
    predicted
}
