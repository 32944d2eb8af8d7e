//! Which of two models explains the same points better.

use statrs::stats_tests::ttest_onesample::ttest_onesample;
use statrs::stats_tests::{Alternative, NaNPolicy};

use super::loss::Loss;

/// Root mean square, mag; not a number of none.
pub fn rms(residuals_mag: &[f64]) -> f64 {
    (residuals_mag.iter().map(|r| r * r).sum::<f64>() / residuals_mag.len() as f64).sqrt()
}

/// Akaike's information criterion of `n` normal residuals with `k` fitted parameters: n ln(RMSE²) + 2k, up to a constant (Lu 2024, section 4.2).
pub fn aic(rms_mag: f64, n: usize, k: usize) -> f64 {
    n as f64 * (rms_mag * rms_mag).ln() + 2.0 * k as f64
}

/// Akaike's criterion of residuals as they were fitted, to be compared with those of other forms on the same points under the same loss.
///
/// Of squares that of [`aic`], as the paper has it. A robust fit does not stand where the RMS is least, so that there n ln(RMSE²) would say
/// nothing of it; its likelihood is exp(-½ Σ ρ(r²/σ²)), and the criterion -2 ln L + 2k = Σ ρ + 2k, up to a constant of the points alone.
pub fn aic_under(loss: Loss, residuals_mag: &[f64], sigmas_mag: &[f64], k: usize) -> f64 {
    match loss {
        Loss::Squares => aic(rms(residuals_mag), residuals_mag.len(), k),
        robust => {
            let losses = residuals_mag.iter().zip(sigmas_mag).map(|(r, sigma)| robust.of((r / sigma).powi(2)));
            losses.sum::<f64>() + 2.0 * k as f64
        }
    }
}

/// A paired t-test.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PairedTest {
    /// Student's t of the mean of the differences.
    pub t: f64,
    /// Probability of one at least as large if both means are the same, two-sided.
    pub p: f64,
}

/// Of the hypothesis that two lists of residuals of the same points have the same mean. `None` with fewer than two pairs, or
/// where all differences are equal.
pub fn paired_t_test(one: &[f64], other: &[f64]) -> Option<PairedTest> {
    let differences: Vec<f64> = one.iter().zip(other).map(|(a, b)| a - b).collect();
    // Without scatter there is no t, and the library would look for the tail of an infinite one.
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

    /// Lu (2024), section 4.2: RMSE 0.2408 (k = 7) and 0.2423 (k = 5), AIC -13232 and -13176; both give n = 4651.
    #[test]
    fn valid_aic_against_both_printed_pairs() {
        /// Four printed digits of the RMSE: 4651 · 2 · 0.00005/0.24.
        const ROUNDING: f64 = 2.0;
        let n = 4651;
        // The RMSE that is printed as 0.2408 lies within half a unit of its last digit.
        let printed = |rmse: f64, k: usize| (aic(rmse - 5e-5, n, k), aic(rmse + 5e-5, n, k));
        for (rmse, k, expected) in [(0.2408, 7, -13232.0), (0.2423, 5, -13176.0)] {
            let (least, greatest) = printed(rmse, k);
            assert!(least - ROUNDING < expected && expected < greatest + ROUNDING, "{least} {greatest}");
        }
    }

    /// Under a robust loss one bad point is no reason to leave a better form, and a parameter costs 2.
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
        let test = paired_t_test(&[1.1, 2.3, 2.9, 4.2, 5.0], &[1.0, 2.0, 3.1, 3.9, 4.6]).expect("five pairs");
        /// Digits of the printed figures.
        const DIGITS: f64 = 1e-10;
        assert!((test.t - SCIPY.0).abs() < DIGITS && (test.p - SCIPY.1).abs() < DIGITS, "{test:?}");
        assert_eq!(paired_t_test(&[1.0, 2.0], &[1.0, 2.0]), None);
        assert_eq!(paired_t_test(&[1.0], &[2.0]), None);
    }
    /// t and p.
    const SCIPY: (f64, f64) = (1.685854460847049, 0.16710331573259815);
}
