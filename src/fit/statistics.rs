//! Residuals in a few numbers.

use crate::math::quantile::quantile;

use super::comparison::rms;

/// Residuals of a fit or a prediction, mag.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Spread {
    /// How many.
    pub n: usize,
    /// Mean.
    pub mean_mag: f64,
    /// Root mean square.
    pub rms_mag: f64,
    /// 1.4826 times the median absolute deviation from the median.
    pub core_mag: f64,
}

impl Spread {
    /// Of the finite ones among them; `None` where there are none.
    pub fn of(residuals_mag: &[f64]) -> Option<Self> {
        let mut finite: Vec<f64> = residuals_mag.iter().copied().filter(|r| r.is_finite()).collect();
        if finite.is_empty() {
            return None;
        }
        let n = finite.len() as f64;
        let mean_mag = finite.iter().sum::<f64>() / n;
        let rms_mag = rms(&finite);
        finite.sort_by(f64::total_cmp);
        let median = quantile(&finite, 0.5);
        let mut deviations: Vec<f64> = finite.iter().map(|r| (r - median).abs()).collect();
        deviations.sort_by(f64::total_cmp);
        Some(Self { n: finite.len(), mean_mag, rms_mag, core_mag: 1.4826 * quantile(&deviations, 0.5) })
    }
}

/// The sigma within which the share 0.6827 of residuals lies: what an honest prediction states, whatever the wings.
pub fn honest_sigma_mag(residuals_mag: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = residuals_mag.iter().filter(|r| r.is_finite()).map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    quantile(&sizes, 0.6827)
}

/// Share of the finite residuals within ± sigma.
pub fn share_within(residuals_mag: &[f64], sigma_mag: f64) -> f64 {
    let finite: Vec<f64> = residuals_mag.iter().copied().filter(|r| r.is_finite()).collect();
    finite.iter().filter(|r| r.abs() <= sigma_mag).count() as f64 / finite.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_few_numbers() {
        let spread = Spread::of(&[1.0, -1.0, 2.0, f64::NAN]).expect("three numbers");
        assert_eq!(spread.n, 3);
        assert!((spread.mean_mag - 2.0 / 3.0).abs() < 1e-12 && (spread.rms_mag - 2_f64.sqrt()).abs() < 1e-12);
        assert!((spread.core_mag - 1.4826).abs() < 1e-12);
        assert_eq!(Spread::of(&[f64::NAN]), None);
        let even: Vec<f64> = (-500..=500).map(|i| f64::from(i) / 500.0).collect();
        let sigma = honest_sigma_mag(&even);
        assert!((sigma - 0.6827).abs() < 2e-3 && (share_within(&even, sigma) - 0.6827).abs() < 2e-3, "{sigma}");
    }
}
