//! How far numbers lie from zero: mean, scatter, root mean square, core, share within one sigma.

/// Statistics of differences, mag.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Residuals {
    /// How many.
    pub n: usize,
    /// Mean, mag.
    pub mean_mag: f64,
    /// Standard deviation about the mean, mag.
    pub scatter_mag: f64,
    /// Root mean square about zero, mag.
    pub rms_mag: f64,
    /// 1.4826 times the median absolute deviation from the median, mag: the sigma of a normal core, whatever its wings.
    pub core_mag: f64,
}

impl Residuals {
    /// Of differences that weigh the same; `None` of none.
    pub fn of(differences_mag: impl IntoIterator<Item = f64>) -> Option<Self> {
        Self::weighted(differences_mag.into_iter().map(|difference| (difference, 1.0)))
    }

    /// Of pairs of a difference, mag, and its weight (positive, finite); `None` where the weights add up to nothing.
    pub fn weighted(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<Self> {
        let mut pairs: Vec<(f64, f64)> = pairs.into_iter().collect();
        let weight: f64 = pairs.iter().map(|(_, w)| w).sum();
        if !(weight > 0.0 && weight.is_finite()) {
            return None;
        }
        let average = |of: &dyn Fn(f64) -> f64| pairs.iter().map(|&(x, w)| w * of(x)).sum::<f64>() / weight;
        // mean = Σ w x / Σ w,   rms² = Σ w x² / Σ w,   scatter² = Σ w (x - mean)² / Σ w
        let mean_mag = average(&|x| x);
        let rms_mag = average(&|x| x * x).sqrt();
        let scatter_mag = average(&|x| (x - mean_mag) * (x - mean_mag)).sqrt();
        let middle = median(&mut pairs, weight);
        pairs.iter_mut().for_each(|(x, _)| *x = (*x - middle).abs());
        let core_mag = 1.4826 * median(&mut pairs, weight);
        Some(Self { n: pairs.len(), mean_mag, scatter_mag, rms_mag, core_mag })
    }
}

/// The first value at which more than half of the weight is reached.
fn median(pairs: &mut [(f64, f64)], weight: f64) -> f64 {
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut below = 0.0;
    for &(x, w) in pairs.iter() {
        below += w;
        if 2.0 * below > weight {
            return x;
        }
    }
    pairs.last().map_or(f64::NAN, |&(x, _)| x)
}

/// The share of the weight of pairs (difference, mag; weight) within ± `sigma_mag`; `None` of none.
pub(super) fn share_within(pairs: &[(f64, f64)], sigma_mag: f64) -> Option<f64> {
    let weight: f64 = pairs.iter().map(|(_, w)| w).sum();
    let inside: f64 = pairs.iter().filter(|(x, _)| x.abs() <= sigma_mag).map(|(_, w)| w).sum();
    (weight > 0.0).then(|| inside / weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_statistics_of_a_few_numbers() {
        let r = Residuals::of([1.0, -1.0, 2.0, 10.0]).expect("four numbers");
        assert_eq!(r.n, 4);
        assert!((r.mean_mag - 3.0).abs() < 1e-12 && (r.rms_mag - 26.5_f64.sqrt()).abs() < 1e-12);
        assert!((r.scatter_mag - 17.5_f64.sqrt()).abs() < 1e-12);
        // Sorted -1 1 2 10: the upper middle is 2, the deviations 3 1 0 8, their upper middle 3.
        assert!((r.core_mag - 3.0 * 1.4826).abs() < 1e-12);
        assert_eq!(Residuals::of([]), None);
    }

    #[test]
    fn verif_a_weight_counts_as_so_many_numbers() {
        let weighted = Residuals::weighted([(0.5, 3.0), (-1.0, 1.0), (2.0, 2.0)]).expect("weights");
        let spread = Residuals::of([0.5, 0.5, 0.5, -1.0, 2.0, 2.0]).expect("numbers");
        assert!((weighted.mean_mag - spread.mean_mag).abs() < 1e-12);
        assert!((weighted.rms_mag - spread.rms_mag).abs() < 1e-12);
        assert!((weighted.scatter_mag - spread.scatter_mag).abs() < 1e-12);
        assert!((weighted.core_mag - spread.core_mag).abs() < 1e-12);
        assert_eq!(share_within(&[(0.5, 3.0), (-1.0, 1.0)], 0.6), Some(0.75));
        assert_eq!(share_within(&[], 0.6), None);
    }
}
