//! Quantiles of samples.

/// Returns the value below which the fraction `share` of the sorted samples lies, interpolated linearly between
/// neighbouring samples (NumPy's default, Hyndman and Fan's type 7).
///
/// NaN if there are no samples; `share` is clamped to [0, 1].
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let at = share.clamp(0.0, 1.0) * last as f64;
    let below = at.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (at - below as f64) * (sorted[above] - sorted[below])
}

/// Returns the median of a sample; for an even number of values, the mean of the middle two. NaN without samples.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    quantile(&values, 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 2.0), 4.0);
        assert_eq!(quantile(&[7.0], 0.16), 7.0);
        assert!(quantile(&[], 0.5).is_nan());
        assert_eq!((median(vec![3.0, 1.0, 2.0]), median(vec![2.0, 1.0])), (2.0, 1.5));
        assert!(median(Vec::new()).is_nan());
    }
}
