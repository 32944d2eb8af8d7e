//! Core and wing of residuals, by expectation maximisation (Dempster, Laird and Rubin 1977, J. R. Stat. Soc. B 39, 1).

use std::f64::consts::TAU;

use crate::math::quantile::quantile;
use crate::photometry::ErrorDistribution;

/// Fewest residuals from which a distribution is fitted: it has five parameters.
const LEAST_POINTS: f64 = 50.0;
/// Largest share of the wing.
const MOST_WING: f64 = 0.5;
/// Least width of either part, in sigmas: a part cannot shrink to a single residual.
const LEAST_SIGMA: f64 = 0.1;
/// Largest number of iterations. They stop earlier if no parameter changes by more than [`CONVERGED`].
const MOST_ITERATIONS: usize = 2000;
const CONVERGED: f64 = 1e-5;
/// Sigma of a normal distribution over its median absolute deviation.
const SIGMA_OF_MAD: f64 = 1.4826;

/// Returns the most probable distribution of `residuals`, which are pairs of a residual in units of sigma and its
/// weight.
///
/// Residuals or weights that are not finite are left out. `None` with fewer than 50 residuals.
pub fn error_distribution(residuals: &[(f64, f64)]) -> Option<ErrorDistribution> {
    let mut seen: Vec<(f64, f64)> =
        residuals.iter().copied().filter(|(x, weight)| x.is_finite() && weight.is_finite() && *weight > 0.0).collect();
    if (seen.len() as f64) < LEAST_POINTS {
        return None;
    }
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sorted: Vec<f64> = seen.iter().map(|(x, _)| *x).collect();
    let median = quantile(&sorted, 0.5);
    let mut sizes: Vec<f64> = sorted.iter().map(|x| (x - median).abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let core_sigma = (SIGMA_OF_MAD * quantile(&sizes, 0.5)).max(LEAST_SIGMA);
    let mean =
        seen.iter().map(|(x, weight)| x * weight).sum::<f64>() / seen.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut now = ErrorDistribution {
        core_shift: median,
        core_sigma,
        wing_share: 0.2,
        // Wings move the mean away from the median.
        wing_shift: median + 5.0 * (mean - median),
        wing_sigma: 2.5 * core_sigma,
    };
    for _ in 0..MOST_ITERATIONS {
        let next = improved(&now, &seen);
        let change = [
            next.core_shift - now.core_shift,
            next.core_sigma - now.core_sigma,
            next.wing_share - now.wing_share,
            next.wing_shift - now.wing_shift,
            next.wing_sigma - now.wing_sigma,
        ];
        now = next;
        if change.iter().all(|one| one.abs() < CONVERGED) {
            break;
        }
    }
    // Three decimals are more than the residuals determine; the bounds are those of model files.
    let rounded = |x: f64, most: f64| (x.clamp(-most, most) * 1000.0).round() / 1000.0;
    Some(ErrorDistribution {
        core_shift: rounded(now.core_shift, 2.0),
        core_sigma: rounded(now.core_sigma, 5.0),
        wing_share: rounded(now.wing_share, MOST_WING),
        wing_shift: rounded(now.wing_shift, 10.0),
        wing_sigma: rounded(now.wing_sigma, 20.0),
    })
}

/// One step of the iteration.
fn improved(now: &ErrorDistribution, residuals: &[(f64, f64)]) -> ErrorDistribution {
    let density = |x: f64, shift: f64, sigma: f64| (-0.5 * ((x - shift) / sigma).powi(2)).exp() / (sigma * TAU.sqrt());
    // Each residual is divided between core and wing in proportion to the probabilities that it belongs to them.
    let (mut core, mut wing) = (Moments::default(), Moments::default());
    for &(x, weight) in residuals {
        let of_core = (1.0 - now.wing_share) * density(x, now.core_shift, now.core_sigma);
        let of_wing = now.wing_share * density(x, now.wing_shift, now.wing_sigma);
        // If both densities underflow, the residual is assigned to the wing.
        let share = if of_core + of_wing > 0.0 { of_wing / (of_core + of_wing) } else { 1.0 };
        core.add(x, weight * (1.0 - share));
        wing.add(x, weight * share);
    }
    ErrorDistribution {
        core_shift: core.mean(),
        core_sigma: core.sd().max(LEAST_SIGMA),
        wing_share: (wing.weight / (core.weight + wing.weight)).min(MOST_WING),
        wing_shift: wing.mean(),
        wing_sigma: wing.sd().max(LEAST_SIGMA),
    }
}

#[derive(Default)]
struct Moments {
    weight: f64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, x: f64, weight: f64) {
        self.weight += weight;
        self.sum += weight * x;
        self.squares += weight * x * x;
    }

    fn mean(&self) -> f64 {
        self.sum / self.weight.max(f64::MIN_POSITIVE)
    }

    fn sd(&self) -> f64 {
        (self.squares / self.weight.max(f64::MIN_POSITIVE) - self.mean().powi(2)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Residuals at the quantiles of a distribution.
    fn residuals(of: &ErrorDistribution, n: usize) -> Vec<(f64, f64)> {
        let at = |share: f64| {
            let (mut low, mut high) = (-50.0, 50.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if of.cumulative(middle, 0.0) < share { low = middle } else { high = middle }
            }
            low
        };
        (0..n).map(|i| (at((i as f64 + 0.5) / n as f64), 1.0)).collect()
    }

    #[test]
    fn verif_core_and_wing_are_recovered() {
        let given =
            ErrorDistribution { core_shift: 0.15, core_sigma: 0.7, wing_share: 0.2, wing_shift: -1.0, wing_sigma: 2.0 };
        let found = error_distribution(&residuals(&given, 5000)).unwrap();
        for (found, given) in [
            (found.core_shift, given.core_shift),
            (found.core_sigma, given.core_sigma),
            (found.wing_share, given.wing_share),
            (found.wing_shift, given.wing_shift),
            (found.wing_sigma, given.wing_sigma),
        ] {
            assert!((found - given).abs() < 0.03, "{found} for {given}");
        }
    }

    #[test]
    fn verif_few_residuals_have_no_distribution() {
        assert_eq!(error_distribution(&residuals(&ErrorDistribution::NORMAL, 49)), None);
        let unknown = vec![(f64::NAN, 1.0); 100];
        assert_eq!(error_distribution(&unknown), None);
    }
}
