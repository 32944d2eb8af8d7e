//! Offsets of one kind of satellite: a hierarchical normal distribution with wings.
//!
//! ```text
//! y_sp = μ + b_s + e_sp + ε_sp      median residual of pass p of satellite s
//! μ    ~ N(0, σ_m²)                 offset of the kind, with the sigma σ_m of its model
//! b_s  ~ N(0, τ²)                   offset of the satellite from its kind
//! e_sp + ε_sp ~ t₄ √(ω² + σ²/n)     difference between passes, and scatter of the n measurements of the pass
//! ```
//!
//! τ and ω follow from the data (empirical Bayes) by expectation maximisation; Student's t is a normal distribution
//! whose precision has a weight for each pass (Lange, Little and Taylor 1989, J. Am. Stat. Assoc. 84, 881).

use std::collections::BTreeMap;

use super::pass::Pass;
use crate::elements::NoradId;
use crate::math::quantile::median;

/// Degrees of freedom of the differences between passes.
const FREEDOM: f64 = 4.0;
/// Half width that contains 68.27 % of Student's t with four degrees of freedom, in units of its scale.
const HALF_WIDTH: f64 = 1.1416;
/// Weight of the model's sigma in τ² and ω², as a number of satellites and of passes. With few measurements the sigma
/// of the model is thus shared by satellites, passes and measurements.
const PRIOR_COUNT: f64 = 2.0;
/// Number of iterations. They stop earlier if τ and ω change by less than [`CONVERGED`] of themselves.
const MOST_ITERATIONS: usize = 5000;
const CONVERGED: f64 = 1e-7;
/// Smallest scatter of the measurements of a pass, mag: the rounding of magnitudes.
const LEAST_POINT_SIGMA_MAG: f64 = 0.01;

/// Predicted difference of measurements from the model.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Offset from the model, mag; positive is fainter.
    pub offset_mag: f64,
    /// One sigma of the offset, mag.
    pub offset_sigma_mag: f64,
    /// One sigma of a single measurement in another pass, mag.
    pub sigma_mag: f64,
}

/// Offsets of one kind and of its satellites.
#[derive(Clone, Debug, PartialEq)]
pub struct KindFit {
    /// Offset of the kind μ, mag.
    pub offset_mag: f64,
    /// One sigma of the offset of the kind, mag.
    pub offset_sigma_mag: f64,
    /// Standard deviation of the offsets of satellites τ, mag.
    pub satellite_sigma_mag: f64,
    /// Scale of the differences between passes ω, mag.
    pub pass_scale_mag: f64,
    /// One sigma of the measurements within a pass, mag.
    pub point_sigma_mag: f64,
    /// Offset μ + b_s of each satellite and its variance, mag and mag².
    satellites: BTreeMap<NoradId, (f64, f64)>,
}

impl KindFit {
    /// Returns the prediction for a satellite of this kind, which may be one that was not measured.
    pub fn predict(&self, norad_id: NoradId) -> Prediction {
        let unseen = (self.offset_mag, self.satellite_sigma_mag.powi(2) + self.offset_sigma_mag.powi(2));
        let (offset_mag, variance) = self.satellites.get(&norad_id).copied().unwrap_or(unseen);
        // σ_pred² = var(μ + b_s) + (1.14 ω)² + σ²
        let pass_mag = HALF_WIDTH * self.pass_scale_mag;
        let sigma_mag = (variance + pass_mag.powi(2) + self.point_sigma_mag.powi(2)).sqrt();
        Prediction { offset_mag, offset_sigma_mag: variance.sqrt(), sigma_mag }
    }
}

/// One pass in the fit.
struct WeightedPass {
    y_mag: f64,
    /// Variance of the median that is due to the scatter of the measurements, mag².
    point_mag2: f64,
    weight: f64,
}

/// Fits the offsets of one kind to its passes. `model_sigma_mag` is the sigma of its model, positive.
///
/// Without passes the result is that of the prior: an offset of 0.
pub fn fit_kind(passes: &[&Pass], model_sigma_mag: f64) -> KindFit {
    let point_sigma_mag = point_sigma_mag(passes);
    let mut satellites: BTreeMap<NoradId, Vec<WeightedPass>> = BTreeMap::new();
    for pass in passes {
        let point_mag2 = point_sigma_mag.powi(2) / pass.points().len() as f64;
        let row = WeightedPass { y_mag: pass.median_mag(), point_mag2, weight: 1.0 };
        satellites.entry(pass.norad_id()).or_default().push(row);
    }
    // The model's sigma, shared equally by satellites, passes and measurements.
    let third_mag2 = model_sigma_mag.powi(2) / 3.0;
    let (mut satellite_mag2, mut pass_mag2) = (third_mag2, third_mag2);
    let mut fitted = KindFit {
        offset_mag: 0.0,
        offset_sigma_mag: model_sigma_mag,
        satellite_sigma_mag: satellite_mag2.sqrt(),
        pass_scale_mag: pass_mag2.sqrt(),
        point_sigma_mag,
        satellites: BTreeMap::new(),
    };
    for _ in 0..MOST_ITERATIONS {
        // Precision-weighted mean of each satellite: W_s = Σ u/v, m_s = Σ (u/v) y / W_s, with v = ω² + σ²/n
        let means: Vec<(NoradId, f64, f64)> = satellites
            .iter()
            .map(|(id, rows)| {
                let precision: f64 = rows.iter().map(|row| row.weight / (pass_mag2 + row.point_mag2)).sum();
                let sum: f64 = rows.iter().map(|row| row.weight / (pass_mag2 + row.point_mag2) * row.y_mag).sum();
                (*id, sum / precision, 1.0 / precision)
            })
            .collect();
        // μ = Σ w_s m_s / (1/σ_m² + Σ w_s), w_s = 1/(τ² + 1/W_s)
        let weights = means.iter().map(|(_, _, variance)| 1.0 / (satellite_mag2 + variance));
        let precision = model_sigma_mag.powi(-2) + weights.clone().sum::<f64>();
        fitted.offset_mag = weights.zip(&means).map(|(weight, (_, mean, _))| weight * mean).sum::<f64>() / precision;
        let offset_mag2 = 1.0 / precision;
        fitted.offset_sigma_mag = offset_mag2.sqrt();
        let mut satellites_mag2 = PRIOR_COUNT * third_mag2;
        for (id, mean, variance) in &means {
            // b_s = B (m_s - μ), B = τ²/(τ² + 1/W_s); var(μ + b_s) = τ² (1 - B) + (1 - B)² var μ
            let kept = satellite_mag2 / (satellite_mag2 + variance);
            let own_mag = kept * (mean - fitted.offset_mag);
            let own_mag2 = satellite_mag2 * (1.0 - kept);
            satellites_mag2 += own_mag.powi(2) + own_mag2 + kept.powi(2) * offset_mag2;
            let total_mag2 = own_mag2 + (1.0 - kept).powi(2) * offset_mag2;
            fitted.satellites.insert(*id, (fitted.offset_mag + own_mag, total_mag2));
        }
        let (mut passes_mag2, mut rows_of_all) = (PRIOR_COUNT * third_mag2, 0.0);
        for (id, rows) in &mut satellites {
            let (offset_mag, offset_mag2) = fitted.satellites.get(id).copied().unwrap_or_default();
            for row in rows {
                // u = 5 / (4 + d²/v); E[u e²] = u (ω²/v)² d² + ω² (σ²/n) / v
                let v = pass_mag2 + row.point_mag2;
                let d2 = (row.y_mag - offset_mag).powi(2) + offset_mag2;
                row.weight = (FREEDOM + 1.0) / (FREEDOM + d2 / v);
                passes_mag2 += row.weight * (pass_mag2 / v).powi(2) * d2 + pass_mag2 * row.point_mag2 / v;
                rows_of_all += 1.0;
            }
        }
        let next = [satellites_mag2 / (PRIOR_COUNT + means.len() as f64), passes_mag2 / (PRIOR_COUNT + rows_of_all)];
        let change = (next[0] / satellite_mag2 - 1.0).abs().max((next[1] / pass_mag2 - 1.0).abs());
        [satellite_mag2, pass_mag2] = next;
        if change < CONVERGED {
            break;
        }
    }
    fitted.satellite_sigma_mag = satellite_mag2.sqrt();
    fitted.pass_scale_mag = pass_mag2.sqrt();
    fitted
}

/// Returns the scatter of measurements within a pass, mag: the median over passes with five measurements or more, or
/// else the median of the stated errors.
fn point_sigma_mag(passes: &[&Pass]) -> f64 {
    let scatters: Vec<f64> = passes.iter().filter_map(|pass| pass.scatter_mag()).collect();
    let stated = || passes.iter().flat_map(|pass| pass.points()).filter_map(|point| point.sigma_mag);
    let found = if scatters.is_empty() { median(stated().collect()) } else { median(scatters) };
    // Without scatters and stated errors, `found` is NaN, and `max` returns the smallest scatter.
    found.max(LEAST_POINT_SIGMA_MAG)
}
