//! Uncertainty of the fitted parameters.
//!
//! The curvature of the cost, H = Σ ψ' J Jᵀ/σ² (ψ is the influence function; for squares H = JᵀW J), is inverted for
//! the parameters that are not at a bound. If points form groups with common systematic errors (a track, a night), H⁻¹
//! is too small, and the sandwich estimator
//!
//! ```text
//! Σ = H⁻¹ (Σ_g s_g s_gᵀ) H⁻¹ G/(G-k),    s_g = Σ_{i in g} gradient of the cost of point i
//! ```
//!
//! is used (Liang and Zeger 1986, Biometrika 73, 13). If there are too few groups for the sandwich estimator, H⁻¹ is
//! scaled by χ²/(n - k). A track contributes to many pixels, so that pixels do not form such groups: see `jackknife`.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::form::Parameter;

/// A parameter counts as being at a bound if it is nearer to it than this fraction of the interval between the bounds.
const AT_BOUND: f64 = 1e-6;
/// A direction counts as undetermined if its eigenvalue of the curvature (scaled to a diagonal of 1) is below this.
const SINGULAR: f64 = 1e-10;

/// Method by which a covariance was computed.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum CovarianceKind {
    /// From the scatter of groups of points (sandwich estimator).
    Grouped,
    /// From the curvature of the cost, scaled by χ²/(n - k).
    Scaled,
    /// From fits that each omit one set of tracks ([`jackknife`](super::jackknife())).
    Jackknife,
}

impl fmt::Display for CovarianceKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Grouped => "from the scatter of groups of points",
            Self::Scaled => "from the curvature of the cost, scaled by chi-square",
            Self::Jackknife => "from a jackknife over sets of tracks",
        })
    }
}

/// Uncertainty of the parameters of a fit.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FitUncertainty {
    /// Covariance of all parameters, with 0 for parameters that are held, at a bound or undetermined. `None` if the
    /// curvature is singular.
    pub covariance: Option<Vec<Vec<f64>>>,
    /// Method by which the covariance was computed.
    #[doc(hidden)]
    pub kind: CovarianceKind,
    /// Indices of free parameters at a bound.
    pub at_bound: Vec<usize>,
    /// Indices of free parameters that the points do not determine.
    pub undetermined: Vec<usize>,
}

impl FitUncertainty {
    /// Returns the uncertainty (one sigma) of a parameter; `None` if it is held, at a bound or undetermined.
    pub fn sigma(&self, parameter: usize) -> Option<f64> {
        let variance = self.covariance.as_ref()?[parameter][parameter];
        (variance > 0.0).then(|| variance.sqrt())
    }

    /// Returns the correlation of two parameters; `None` if one of them has no sigma.
    pub fn correlation(&self, first: usize, other: usize) -> Option<f64> {
        let product = self.sigma(first)? * self.sigma(other)?;
        Some(self.covariance.as_ref()?[first][other] / product)
    }
}

/// Returns the uncertainty, from the curvature at the minimum, `(n_free, n_free)`, and each point's term of the
/// gradient. `effective_points` is the sum of the weights of the points.
pub(super) fn uncertainty(
    curvature: &DMatrix<f64>,
    scores: &[Vec<f64>],
    groups: &[u32],
    parameters: &[Parameter],
    free: &[usize],
    cost: f64,
    effective_points: f64,
) -> FitUncertainty {
    let at_end = |i: usize| {
        let p = &parameters[i];
        let near = AT_BOUND * (p.greatest - p.least);
        p.value <= p.least + near || p.value >= p.greatest - near
    };
    let at_bound: Vec<usize> = free.iter().copied().filter(|&i| at_end(i)).collect();
    let inner: Vec<usize> = (0..free.len()).filter(|&k| !at_end(free[k])).collect();
    let group_count = groups.iter().collect::<std::collections::HashSet<_>>().len();
    let is_grouped = group_count > 2 * free.len();
    let kind = if is_grouped { CovarianceKind::Grouped } else { CovarianceKind::Scaled };
    let mut known = FitUncertainty { covariance: None, kind, at_bound, undetermined: Vec::new() };

    let mut inner = inner;
    let inverse = loop {
        // Undetermined parameters are removed, and the curvature of the remaining ones is inverted.
        if let Some(index) = inner.iter().position(|&k| !(curvature[(k, k)] > 0.0 && curvature[(k, k)].is_finite())) {
            known.undetermined.push(free[inner.remove(index)]);
            continue;
        }
        let m = inner.len();
        if m == 0 {
            known.covariance = Some(vec![vec![0.0; parameters.len()]; parameters.len()]);
            return known;
        }
        // The curvature is scaled to a diagonal of 1, so that the units of the parameters do not matter.
        let scale: Vec<f64> = inner.iter().map(|&k| curvature[(k, k)].sqrt()).collect();
        let unit = DMatrix::from_fn(m, m, |r, c| curvature[(inner[r], inner[c])] / (scale[r] * scale[c]));
        let eigen = unit.clone().symmetric_eigen();
        if let Some(flat) = eigen.eigenvalues.iter().position(|value| *value < SINGULAR) {
            let direction = eigen.eigenvectors.column(flat);
            let (moving, fixed): (Vec<usize>, Vec<usize>) = (0..m).partition(|&k| direction[k].abs() > 0.3);
            known.undetermined.extend(moving.iter().map(|&k| free[inner[k]]));
            inner = fixed.into_iter().map(|k| inner[k]).collect();
            continue;
        }
        let Some(inverse) = unit.try_inverse() else { return known };
        break DMatrix::from_fn(m, m, |r, c| inverse[(r, c)] / (scale[r] * scale[c]));
    };
    let m = inner.len();
    let covariance = if is_grouped {
        let mut sums = std::collections::BTreeMap::<u32, DVector<f64>>::new();
        for (score, group) in scores.iter().zip(groups) {
            let sum = sums.entry(*group).or_insert_with(|| DVector::zeros(m));
            inner.iter().enumerate().for_each(|(k, &column)| sum[k] += score[column]);
        }
        let meat = sums.values().fold(DMatrix::zeros(m, m), |meat, sum| meat + sum * sum.transpose());
        let groups = sums.len() as f64;
        &inverse * meat * &inverse * (groups / (groups - m as f64))
    } else {
        // χ² = 2 C for squares
        let spare = (effective_points - free.len() as f64).max(1.0);
        inverse * (2.0 * cost / spare)
    };
    let mut full = vec![vec![0.0; parameters.len()]; parameters.len()];
    for r in 0..m {
        for c in 0..m {
            // Rounding makes the product slightly asymmetric.
            full[free[inner[r]]][free[inner[c]]] = 0.5 * (covariance[(r, c)] + covariance[(c, r)]);
        }
    }
    known.covariance = Some(full);
    known
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::StandardNormal;

    use super::*;
    use crate::fit::{FitPoint, FitSettings, Loss, PhaseForm, Problem};
    use crate::geometry::ViewingGeometry;

    const SIMULATIONS: u64 = 300;
    const GROUPS: u32 = 60;
    const IN_GROUP: usize = 12;
    /// True line in the phase angle: value at its beginning, and change over a radian.
    const TRUTH: [f64; 2] = [6.0, 1.5];

    /// Groups of points with a common offset of `offset_mag` (one sigma) and a common interval of phase angles. The
    /// error of a point is 0.1 mag (one sigma), or 3 mag for a fraction `far_share` of the points.
    fn seen(seed: u64, offset_mag: f64, far_share: f64) -> Vec<FitPoint> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut points = Vec::new();
        for group in 0..GROUPS {
            let offset = offset_mag * random.sample::<f64, _>(StandardNormal);
            let begin = 0.3 + 1.9 * random.random::<f64>();
            for _ in 0..IN_GROUP {
                let longitude = begin + 0.4 * random.random::<f64>();
                let geometry = ViewingGeometry::from_angles(-0.2, longitude, -0.4, 1000.0, 550.0).expect("a geometry");
                let is_far = random.random::<f64>() < far_share;
                let noise = if is_far { 3.0 } else { 0.1 } * random.sample::<f64, _>(StandardNormal);
                let magnitude = TRUTH[0] + TRUTH[1] * geometry.phase_angle_rad() + offset + noise;
                points.push(FitPoint { geometry, magnitude, sigma_mag: 0.1, weight: 1.0, group });
            }
        }
        points
    }

    /// For each coefficient: its scatter, and the root mean square of its sigmas with and without groups.
    fn sigmas(offset_mag: f64, far_share: f64, loss: Loss) -> [[f64; 3]; 2] {
        let settings = FitSettings { loss, ..FitSettings::free(&["a0", "a1"]) };
        let sigmas_of = |seed: u64| {
            let mut points = seen(seed, offset_mag, far_share);
            let solved = |points: &[FitPoint]| {
                Problem::new(&PhaseForm { degree: 1 }, points, &settings).and_then(|problem| problem.solve())
            };
            let fit = solved(&points).expect("a fit");
            assert_eq!(fit.uncertainty.kind, CovarianceKind::Grouped);
            points.iter_mut().for_each(|point| point.group = 0);
            let ungrouped = solved(&points).expect("a fit");
            assert_eq!(ungrouped.uncertainty.kind, CovarianceKind::Scaled);
            [0, 1].map(|i| {
                let sigma = |fit: &crate::fit::Fit| fit.uncertainty.sigma(i).expect("a sigma");
                [fit.parameters[i].value, sigma(&fit), sigma(&ungrouped)]
            })
        };
        let all: Vec<_> = (1..=SIMULATIONS).map(sigmas_of).collect();
        let n = SIMULATIONS as f64;
        [0, 1].map(|i| {
            let mean = all.iter().map(|values| values[i][0]).sum::<f64>() / n;
            let scatter = (all.iter().map(|values| (values[i][0] - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
            let root_mean = |k: usize| (all.iter().map(|values| values[i][k].powi(2)).sum::<f64>() / n).sqrt();
            [scatter, root_mean(1), root_mean(2)]
        })
    }

    /// Relative tolerance: three times the error of the scatter of 300 simulations, which is 4 %, plus a bias of a few
    /// per cent for 60 groups.
    const MONTE_CARLO: f64 = 0.16;

    #[test]
    fn verif_the_sigma_of_groups_is_the_scatter() {
        for [scatter, grouped, ungrouped] in sigmas(0.3, 0.0, Loss::Squares) {
            assert!((grouped / scatter - 1.0).abs() < MONTE_CARLO, "{grouped} {scatter}");
            // Points taken as independent give too small a sigma.
            assert!(ungrouped < 0.6 * scatter, "{ungrouped} {scatter}");
        }
    }

    #[test]
    fn verif_the_sigma_of_a_robust_fit_is_the_scatter() {
        let squares = sigmas(0.1, 0.1, Loss::Squares);
        for loss in [Loss::SoftL1, Loss::Student(4.0)] {
            for ([scatter, grouped, _], [of_squares, ..]) in sigmas(0.1, 0.1, loss).into_iter().zip(squares) {
                assert!((grouped / scatter - 1.0).abs() < MONTE_CARLO, "{loss:?}: {grouped} {scatter}");
                // One point in ten is an outlier and hardly counts.
                assert!(scatter < 0.7 * of_squares, "{loss:?}: {scatter} {of_squares}");
            }
        }
    }
}
