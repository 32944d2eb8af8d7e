//! Statistics of residuals: spread, Akaike's criterion, paired t-test.

use statrs::stats_tests::ttest_onesample::ttest_onesample;
use statrs::stats_tests::{Alternative, NaNPolicy};

use super::objective::Loss;
use super::point::FitPoint;

/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
const SIGMA_OF_MAD: f64 = 1.4826;
/// Fraction of a normal distribution within one sigma.
const ONE_SIGMA_SHARE: f64 = 0.6827;
/// Distance from the median, in robust standard deviations, to which residuals are clipped for the correlation within
/// groups.
const CLIPPED_SIGMAS: f64 = 3.0;

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
    pub fn unweighted(residuals_mag: &[f64]) -> Option<Self> {
        Self::weighted(residuals_mag.iter().filter(|r| r.is_finite()).map(|r| (*r, 1.0)))
    }

    /// Returns the statistics of pairs of a residual, mag, and its weight (positive, finite); `None` if the weights sum
    /// to zero.
    pub fn weighted(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
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

/// Returns the median of pairs of a value and its weight (positive, finite); NaN without pairs.
pub fn median_mag(residuals: &[(f64, f64)]) -> f64 {
    let mut pairs = residuals.to_vec();
    let weight = pairs.iter().map(|(_, w)| w).sum();
    weighted_median(&mut pairs, weight)
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
    weighted_sigma_68_mag(&residuals_mag.iter().map(|r| (*r, 1.0)).collect::<Vec<_>>())
}

/// Returns the sigma that contains the fraction 0.6827 of the weight of pairs of a residual, mag, and its weight.
/// Residuals that are not finite are left out. NaN without residuals.
pub fn weighted_sigma_68_mag(residuals: &[(f64, f64)]) -> f64 {
    let sizes = residuals.iter().filter(|(r, _)| r.is_finite()).map(|(r, weight)| (r.abs(), *weight));
    weighted_quantile(&mut sizes.collect::<Vec<_>>(), ONE_SIGMA_SHARE)
}

/// Returns the value below which there is a share of the weight, interpolated between the values; NaN without values.
/// With equal weights it is the usual quantile.
pub fn weighted_quantile(pairs: &mut [(f64, f64)], share: f64) -> f64 {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else { return f64::NAN };
    let total: f64 = pairs.iter().map(|(_, weight)| weight).sum();
    // A value is at the middle of its weight; the first is at a share of 0 and the last at 1.
    let between = total - 0.5 * (first.1 + last.1);
    let mut at = 0.0;
    for pair in pairs.windows(2) {
        let [(low, low_weight), (high, high_weight)] = [pair[0], pair[1]];
        let step = 0.5 * (low_weight + high_weight) / between;
        if at + step >= share {
            return low + (high - low) * ((share - at) / step).clamp(0.0, 1.0);
        }
        at += step;
    }
    last.0
}

/// Returns the intraclass correlation of residuals: the fraction of their variance that is common to the residuals of
/// one group, 0 to 1. Residuals farther than three robust standard deviations from the median are clipped.
///
/// `residuals_mag` and `groups` have the same length. 0 if there are not two groups, or no group with two residuals.
pub fn group_correlation(residuals_mag: &[f64], groups: &[u32]) -> f64 {
    let pairs: Vec<(f64, f64)> = residuals_mag.iter().map(|r| (*r, 1.0)).collect();
    let Some(all) = ResidualStatistics::weighted(pairs.iter().copied()) else { return 0.0 };
    let (centre, most) = (median_mag(&pairs), CLIPPED_SIGMAS * all.core_mag);
    let mut by_group = std::collections::BTreeMap::<u32, Vec<f64>>::new();
    for (residual, group) in residuals_mag.iter().zip(groups) {
        by_group.entry(*group).or_default().push(residual.clamp(centre - most, centre + most));
    }
    let (count, n) = (by_group.len() as f64, residuals_mag.len() as f64);
    if count < 2.0 || n <= count {
        return 0.0;
    }
    let mean = by_group.values().flatten().sum::<f64>() / n;
    let (mut between, mut within, mut squares) = (0.0, 0.0, 0.0);
    for group in by_group.values() {
        let size = group.len() as f64;
        let own = group.iter().sum::<f64>() / size;
        between += size * (own - mean).powi(2);
        within += group.iter().map(|r| (r - own).powi(2)).sum::<f64>();
        squares += size * size;
    }
    // One-way analysis of variance: ρ = (MSB - MSW) / (MSB + (n0 - 1) MSW), n0 = (N - Σ n²/N) / (G - 1)
    //                                                                   Donner (1986), Int. Stat. Rev. 54, 67
    let (between, within) = (between / (count - 1.0), within / (n - count));
    let size = (n - squares / n) / (count - 1.0);
    let correlation = (between - within) / (between + (size - 1.0) * within);
    if correlation.is_finite() { correlation.clamp(0.0, 1.0) } else { 0.0 }
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

/// Returns Akaike's information criterion of `n` independent normal residuals with `k` fitted parameters, up to a
/// constant.
pub(super) fn aic(rms_mag: f64, n: f64, k: usize) -> f64 {
    // n ln(RMSE²) + 2k                                                                  Lu (2024), section 4.2
    n * (rms_mag * rms_mag).ln() + 2.0 * k as f64
}

/// Returns Akaike's criterion of a fit under this loss. It can be compared between forms on the same points and with
/// the same loss.
///
/// For squares it is n ln(RMSE²) + 2k, as in Lu (2024). A robust fit does not minimise the RMS. Its likelihood is
/// exp(-½ Σ w ρ(r²/σ²)), and the criterion is -2 ln L + 2k = Σ w ρ + 2k, up to a constant that depends only on the
/// points.
pub(super) fn aic_under(loss: Loss, residuals_mag: &[f64], points: &[FitPoint], k: usize) -> f64 {
    let pairs = || residuals_mag.iter().zip(points);
    match loss {
        Loss::Squares => {
            let n: f64 = points.iter().map(|point| point.weight).sum();
            aic((pairs().map(|(r, point)| point.weight * r * r).sum::<f64>() / n).sqrt(), n, k)
        }
        robust => {
            let losses = pairs().map(|(r, point)| point.weight * robust.rho((r / point.sigma_mag).powi(2)));
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
pub(super) fn paired_t_test(sample: &[f64], other: &[f64]) -> Option<PairedTest> {
    let differences: Vec<f64> = sample.iter().zip(other).map(|(a, b)| a - b).collect();
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
        let r = ResidualStatistics::unweighted(&[1.0, -1.0, 2.0, f64::NAN, 10.0]).expect("four numbers");
        assert_eq!(r.n, 4);
        assert!((r.mean_mag - 3.0).abs() < 1e-12 && (r.rms_mag - 26.5_f64.sqrt()).abs() < 1e-12);
        assert!((r.sd_mag - 17.5_f64.sqrt()).abs() < 1e-12);
        // Sorted -1 1 2 10: median 1.5, deviations 2.5 0.5 0.5 8.5, their median 1.5.
        assert!((r.core_mag - 1.5 * 1.4826).abs() < 1e-12);
        assert_eq!(ResidualStatistics::unweighted(&[f64::NAN]), None);
        let even: Vec<f64> = (-500..=500).map(|i| f64::from(i) / 500.0).collect();
        let sigma = sigma_68_mag(&even);
        let share = share_within(even.iter().map(|r| (*r, 1.0)), sigma).expect("a share");
        assert!((sigma - 0.6827).abs() < 2e-3 && (share - 0.6827).abs() < 2e-3, "{sigma}");
    }

    #[test]
    fn verif_a_weight_equals_repeated_numbers() {
        let weighted = ResidualStatistics::weighted([(0.5, 3.0), (-1.0, 1.0), (2.0, 2.0)]).expect("weights");
        let repeated = ResidualStatistics::unweighted(&[0.5, 0.5, 0.5, -1.0, 2.0, 2.0]).expect("numbers");
        assert!((weighted.mean_mag - repeated.mean_mag).abs() < 1e-12);
        assert!((weighted.rms_mag - repeated.rms_mag).abs() < 1e-12);
        assert!((weighted.sd_mag - repeated.sd_mag).abs() < 1e-12);
        assert!((weighted.core_mag - repeated.core_mag).abs() < 1e-12);
        assert_eq!(share_within([(0.5, 3.0), (-1.0, 1.0)], 0.6), Some(0.75));
        assert_eq!(share_within([], 0.6), None);
    }

    /// Values with the correlation of a common part of each group, and their weights.
    #[test]
    fn verif_correlation_and_weights_of_groups() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
        };
        // The variances of the common and of the own part are 3 to 1; the groups have 3 to 12 members.
        let (mut residuals, mut groups) = (Vec::new(), Vec::new());
        for group in 0..3000_u32 {
            let common = random();
            for _ in 0..3 + group % 10 {
                residuals.push(common + random() / 3_f64.sqrt());
                groups.push(group);
            }
        }
        let found = group_correlation(&residuals, &groups);
        assert!((found - 0.75).abs() < 0.02, "{found}");
        let alone: Vec<u32> = (0..residuals.len() as u32).collect();
        assert_eq!((group_correlation(&residuals, &alone), group_correlation(&[1.0; 4], &[0, 0, 1, 1])), (0.0, 0.0));
        let weights = super::super::point::group_weights(&[7, 7, 7, 2], 0.5);
        assert_eq!(weights, [0.5, 0.5, 0.5, 1.0]);
    }

    #[test]
    fn verif_weighted_quantiles() {
        let mut equal = [(4.0, 1.0), (1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (5.0, 1.0)];
        for (share, expected) in [(0.0, 1.0), (0.1, 1.4), (0.5, 3.0), (0.875, 4.5), (1.0, 5.0)] {
            assert!((weighted_quantile(&mut equal, share) - expected).abs() < 1e-12, "{share}");
        }
        // A large weight attracts the quantiles.
        assert!((weighted_quantile(&mut [(0.0, 1.0), (1.0, 98.0), (2.0, 1.0)], 0.5) - 1.0).abs() < 1e-12);
        assert!(weighted_quantile(&mut [], 0.5).is_nan());
    }

    /// Lu (2024), section 4.2: RMSE 0.2408 (k = 7) and 0.2423 (k = 5), AIC -13232 and -13176; both give n = 4651.
    #[test]
    fn valid_aic_against_both_printed_pairs() {
        /// Tolerance of the criterion for an RMSE printed with four digits: 4651 · 2 · 0.00005/0.24.
        const ROUNDING: f64 = 2.0;
        let n = 4651.0;
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
        let geometry =
            crate::geometry::ViewingGeometry::from_angles(-0.2, 0.5, -0.8, 700.0, 550.0).expect("a geometry");
        let points = [FitPoint { geometry, magnitude: 6.0, sigma_mag: 0.2, weight: 1.0, group: 0 }; 4];
        let student = |residuals: &[f64], k| aic_under(Loss::Student(4.0), residuals, &points, k);
        assert!(student(&close, 3) < student(&far, 2) && rms(&close) > rms(&far));
        assert!((student(&close, 5) - student(&close, 3) - 4.0).abs() < 1e-12);
        // -2 ln of Student's density t(r/σ; ν), less that at 0.
        let expected: f64 = close.iter().map(|r: &f64| 5.0 * (1.0 + (r / 0.2).powi(2) / 4.0).ln()).sum();
        assert!((student(&close, 0) - expected).abs() < 1e-12);
        assert!((aic_under(Loss::Squares, &close, &points, 2) - aic(rms(&close), 4.0, 2)).abs() < 1e-12);
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
