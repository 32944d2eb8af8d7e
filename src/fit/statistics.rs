//! Statistics of residuals: spread, Akaike's criterion, paired t-test.

use statrs::stats_tests::ttest_onesample::ttest_onesample;
use statrs::stats_tests::{Alternative, NaNPolicy};

use crate::math::quantile::quantile;

use super::objective::Loss;

/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
const SIGMA_OF_MAD: f64 = 1.4826;
/// Fraction of a normal distribution within one sigma.
const ONE_SIGMA_SHARE: f64 = 0.6827;

/// Statistics of residuals or of other differences, mag.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ResidualStatistics {
    /// Number of residuals.
    pub n: usize,
    /// Mean.
    pub mean_mag: f64,
    /// Standard deviation from the mean.
    pub sd_mag: f64,
    /// Root mean square, that is the deviation from zero.
    pub rms_mag: f64,
    /// 1.4826 times the median absolute deviation from the median. It is close to the sigma of a normal core even if
    /// the distribution has wings.
    pub core_mag: f64,
}

impl ResidualStatistics {
    /// Returns the statistics of the finite residuals with equal weights; `None` if there are none.
    pub fn of(residuals_mag: &[f64]) -> Option<Self> {
        Self::weighted(residuals_mag.iter().filter(|r| r.is_finite()).map(|r| (*r, 1.0)))
    }

    /// Returns the statistics of pairs of a residual, mag, and its weight (positive, finite); `None` if the weights sum
    /// to zero.
    pub(crate) fn weighted(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let mut pairs: Vec<(f64, f64)> = pairs.into_iter().collect();
        let weight: f64 = pairs.iter().map(|(_, w)| w).sum();
        if !(weight > 0.0 && weight.is_finite()) {
            return None;
        }
        let average = |of: &dyn Fn(f64) -> f64| pairs.iter().map(|&(x, w)| w * of(x)).sum::<f64>() / weight;
        // mean = Σ w x / Σ w,   rms² = Σ w x² / Σ w,   sd² = Σ w (x - mean)² / Σ w
        let mean_mag = average(&|x| x);
        let rms_mag = average(&|x| x * x).sqrt();
        let sd_mag = average(&|x| (x - mean_mag) * (x - mean_mag)).sqrt();
        let median = weighted_median(&mut pairs, weight);
        pairs.iter_mut().for_each(|(x, _)| *x = (*x - median).abs());
        let core_mag = SIGMA_OF_MAD * weighted_median(&mut pairs, weight);
        Some(Self { n: pairs.len(), mean_mag, sd_mag, rms_mag, core_mag })
    }
}

/// Returns the median: the mean of the value at which half of the weight is reached and the one at which it is
/// exceeded. With equal weights it is the usual median.
fn weighted_median(pairs: &mut [(f64, f64)], weight: f64) -> f64 {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    let mut lower = None;
    for &(x, w) in pairs.iter() {
        below += w;
        if 2.0 * below >= weight {
            let lower = *lower.get_or_insert(x);
            if 2.0 * below > weight {
                return 0.5 * (lower + x);
            }
        }
    }
    lower.unwrap_or(f64::NAN)
}

/// Returns the root mean square, mag; NaN for an empty list.
pub fn rms(residuals_mag: &[f64]) -> f64 {
    (residuals_mag.iter().map(|r| r * r).sum::<f64>() / residuals_mag.len() as f64).sqrt()
}

/// Returns the sigma that contains the fraction 0.6827 of the finite residuals, for any distribution, mag.
pub fn sigma_68_mag(residuals_mag: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals_mag.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    quantile(&sizes, ONE_SIGMA_SHARE)
}

/// Returns the fraction of the weight of pairs (residual, mag; weight) within ± `sigma_mag`; `None` if there is no
/// weight.
pub(super) fn share_within(pairs: impl IntoIterator<Item = (f64, f64)>, sigma_mag: f64) -> Option<f64> {
    let (mut inside, mut all) = (0.0, 0.0);
    for (residual, weight) in pairs {
        all += weight;
        inside += if residual.abs() <= sigma_mag { weight } else { 0.0 };
    }
    (all > 0.0).then(|| inside / all)
}

/// Returns Akaike's information criterion of `n` normal residuals with `k` fitted parameters, up to a constant.
pub(super) fn aic(rms_mag: f64, n: usize, k: usize) -> f64 {
    // n ln(RMSE²) + 2k                                                                  Lu (2024), section 4.2
    n as f64 * (rms_mag * rms_mag).ln() + 2.0 * k as f64
}

/// Returns Akaike's criterion of a fit under this loss. It can be compared between forms on the same points and with
/// the same loss.
///
/// For squares it is n ln(RMSE²) + 2k, as in Lu (2024). A robust fit does not minimise the RMS. Its likelihood is
/// exp(-½ Σ ρ(r²/σ²)), and the criterion is -2 ln L + 2k = Σ ρ + 2k, up to a constant that depends only on the points.
pub(super) fn aic_under(loss: Loss, residuals_mag: &[f64], sigmas_mag: &[f64], k: usize) -> f64 {
    match loss {
        Loss::Squares => aic(rms(residuals_mag), residuals_mag.len(), k),
        robust => {
            let losses = residuals_mag.iter().zip(sigmas_mag).map(|(r, sigma)| robust.of((r / sigma).powi(2)));
            losses.sum::<f64>() + 2.0 * k as f64
        }
    }
}

/// Result of a paired t-test.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PairedTest {
    /// Student's t of the mean difference.
    pub t: f64,
    /// Two-sided probability of a t at least as large if both means are equal.
    pub p: f64,
}

/// Tests the hypothesis that two lists of residuals of the same points have the same mean (paired t-test).
///
/// `None` for fewer than two pairs, or if all differences are equal.
pub(super) fn paired_t_test(one: &[f64], other: &[f64]) -> Option<PairedTest> {
    let differences: Vec<f64> = one.iter().zip(other).map(|(a, b)| a - b).collect();
    // If the differences do not scatter, t is infinite, and statrs does not terminate in the tail of the distribution.
    let first = *differences.first()?;
    if differences.iter().all(|difference| *difference == first) {
        return None;
    }
    let (t, p) = ttest_onesample(differences, 0.0, Alternative::TwoSided, NaNPolicy::Error).ok()?;
    (t.is_finite() && p.is_finite()).then_some(PairedTest { t, p })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_statistics_of_a_few_numbers() {
        let r = ResidualStatistics::of(&[1.0, -1.0, 2.0, f64::NAN, 10.0]).expect("four numbers");
        assert_eq!(r.n, 4);
        assert!((r.mean_mag - 3.0).abs() < 1e-12 && (r.rms_mag - 26.5_f64.sqrt()).abs() < 1e-12);
        assert!((r.sd_mag - 17.5_f64.sqrt()).abs() < 1e-12);
        // Sorted -1 1 2 10: median 1.5, deviations 2.5 0.5 0.5 8.5, their median 1.5.
        assert!((r.core_mag - 1.5 * 1.4826).abs() < 1e-12);
        assert_eq!(ResidualStatistics::of(&[f64::NAN]), None);
        let even: Vec<f64> = (-500..=500).map(|i| f64::from(i) / 500.0).collect();
        let sigma = sigma_68_mag(&even);
        let share = share_within(even.iter().map(|r| (*r, 1.0)), sigma).expect("a share");
        assert!((sigma - 0.6827).abs() < 2e-3 && (share - 0.6827).abs() < 2e-3, "{sigma}");
    }

    #[test]
    fn verif_a_weight_equals_repeated_numbers() {
        let weighted = ResidualStatistics::weighted([(0.5, 3.0), (-1.0, 1.0), (2.0, 2.0)]).expect("weights");
        let repeated = ResidualStatistics::of(&[0.5, 0.5, 0.5, -1.0, 2.0, 2.0]).expect("numbers");
        assert!((weighted.mean_mag - repeated.mean_mag).abs() < 1e-12);
        assert!((weighted.rms_mag - repeated.rms_mag).abs() < 1e-12);
        assert!((weighted.sd_mag - repeated.sd_mag).abs() < 1e-12);
        assert!((weighted.core_mag - repeated.core_mag).abs() < 1e-12);
        assert_eq!(share_within([(0.5, 3.0), (-1.0, 1.0)], 0.6), Some(0.75));
        assert_eq!(share_within([], 0.6), None);
    }

    /// Lu (2024), section 4.2: RMSE 0.2408 (k = 7) and 0.2423 (k = 5), AIC -13232 and -13176; both give n = 4651.
    #[test]
    fn valid_aic_against_both_printed_pairs() {
        /// Tolerance of the criterion for an RMSE printed with four digits: 4651 · 2 · 0.00005/0.24.
        const ROUNDING: f64 = 2.0;
        let n = 4651;
        // The RMSE printed as 0.2408 is within half a unit of its last digit.
        let printed = |rmse: f64, k: usize| (aic(rmse - 5e-5, n, k), aic(rmse + 5e-5, n, k));
        for (rmse, k, expected) in [(0.2408, 7, -13232.0), (0.2423, 5, -13176.0)] {
            let (least, greatest) = printed(rmse, k);
            assert!(least - ROUNDING < expected && expected < greatest + ROUNDING, "{least} {greatest}");
        }
    }

    /// Under a robust loss one outlier does not favour the worse form, and a parameter costs 2.
    #[test]
    fn verif_a_robust_criterion_is_that_of_its_likelihood() {
        let (close, far) = ([0.1, -0.1, 0.1, 4.0], [0.5, -0.5, 0.5, 3.5]);
        let sigmas = [0.2; 4];
        let student = |residuals: &[f64], k| aic_under(Loss::Student(4.0), residuals, &sigmas, k);
        assert!(student(&close, 3) < student(&far, 2) && rms(&close) > rms(&far));
        assert!((student(&close, 5) - student(&close, 3) - 4.0).abs() < 1e-12);
        // -2 ln of Student's density t(r/σ; ν), less that at 0.
        let expected: f64 = close.iter().map(|r: &f64| 5.0 * (1.0 + (r / 0.2).powi(2) / 4.0).ln()).sum();
        assert!((student(&close, 0) - expected).abs() < 1e-12);
        assert_eq!(aic_under(Loss::Squares, &close, &sigmas, 2), aic(rms(&close), 4, 2));
    }

    /// scipy.stats.ttest_rel([1.1, 2.3, 2.9, 4.2, 5.0], [1.0, 2.0, 3.1, 3.9, 4.6]), SciPy 1.17.1.
    #[test]
    fn valid_paired_test_against_scipy() {
        /// Student's t and its probability p.
        const SCIPY: (f64, f64) = (1.685854460847049, 0.16710331573259815);
        /// Relative tolerance of the printed figures.
        const DIGITS: f64 = 1e-10;
        let test = paired_t_test(&[1.1, 2.3, 2.9, 4.2, 5.0], &[1.0, 2.0, 3.1, 3.9, 4.6]).expect("five pairs");
        assert!((test.t - SCIPY.0).abs() < DIGITS && (test.p - SCIPY.1).abs() < DIGITS, "{test:?}");
        assert_eq!(paired_t_test(&[1.0, 2.0], &[1.0, 2.0]), None);
        assert_eq!(paired_t_test(&[1.0], &[2.0]), None);
    }
}
