//! Statistics of columns for charts: quantiles, spread, histograms, and running medians with bands.

use super::axes::Axis;
use super::error;
use crate::error::{Error, ErrorKind};
use crate::math::quantile::quantile;

/// Quantiles for the dashed lines and the bands. In a normal distribution they are one standard deviation apart.
pub(super) const ONE_SIGMA: [f64; 3] = [0.16, 0.5, 0.84];

/// Factor from the median absolute deviation to the standard deviation of a normal distribution, 1 / Φ⁻¹(3/4).
const SIGMA_OF_MAD: f64 = 1.482_602_218_505_602;

/// Smallest number of points in a bin of a running band.
const LEAST_IN_BAND: usize = 8;

/// Rejects columns that are empty or contain values that are not finite.
pub(super) fn check(what: &str, values: &[f64]) -> Result<(), Error> {
    if values.is_empty() {
        return Err(Error::new(ErrorKind::TooFewData, format!("nothing to draw: no {what}")));
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(error::not_finite(what, index, values[index])),
        None => Ok(()),
    }
}

/// Rejects a column whose length differs from the expected one.
pub(super) fn check_length(what: &str, values: &[f64], expected: usize) -> Result<(), Error> {
    if values.len() == expected {
        return check(what, values);
    }
    Err(error::length(what, values.len(), expected))
}

/// Returns the values in increasing order.
pub(super) fn sorted(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// Returns the mean and the standard deviation (with the divisor n − 1; 0 for a single value).
pub(super) fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / values.len().saturating_sub(1).max(1) as f64).sqrt())
}

/// Returns 1.4826 times the median absolute deviation from the median.
pub(super) fn mad_sigma(values: &[f64]) -> f64 {
    let median = quantile(&sorted(values), 0.5);
    let distances: Vec<f64> = values.iter().map(|value| (value - median).abs()).collect();
    SIGMA_OF_MAD * quantile(&sorted(&distances), 0.5)
}

/// Counts the values in each of `bins` equal parts of an axis. The last part includes the end of the axis.
pub(super) fn histogram(values: &[f64], axis: &Axis, bins: usize) -> Vec<usize> {
    let mut counts = vec![0; bins];
    for value in values.iter().filter(|value| axis.holds(**value)) {
        counts[((axis.share(*value) * bins as f64) as usize).min(bins - 1)] += 1;
    }
    counts
}

/// Adjacent bins of a running band, each with the mean of x and the quantiles [`ONE_SIGMA`] of y.
pub(super) type BandSegment = Vec<(f64, [f64; 3])>;

/// Returns the median and the band of `y` along `x`, bin by bin. Bins with few points are omitted, which splits the
/// band into segments.
pub(super) fn running_band(x: &[f64], y: &[f64], axis: &Axis, bins: usize) -> Vec<BandSegment> {
    let mut parts: Vec<(f64, Vec<f64>)> = vec![(0.0, Vec::new()); bins];
    for (&x, &y) in x.iter().zip(y).filter(|(x, _)| axis.holds(**x)) {
        let part = &mut parts[((axis.share(x) * bins as f64) as usize).min(bins - 1)];
        part.0 += x;
        part.1.push(y);
    }
    let band = |(sum, part): &(f64, Vec<f64>)| {
        let part_sorted = sorted(part);
        (sum / part.len() as f64, ONE_SIGMA.map(|share| quantile(&part_sorted, share)))
    };
    let is_full = |(_, part): &(f64, Vec<f64>)| part.len() >= LEAST_IN_BAND;
    let runs = parts.chunk_by(|part, next| is_full(part) == is_full(next)).filter(|run| is_full(&run[0]));
    runs.map(|run| run.iter().map(band).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_numbers_of_a_small_column() {
        let values = [1.0, 2.0, 3.0, 4.0, 10.0];
        assert_eq!(mean_and_sd(&values), (4.0, 12.5_f64.sqrt()));
        assert!((mad_sigma(&values) - SIGMA_OF_MAD).abs() < 1e-12);
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!(mean_and_sd(&[7.0]), (7.0, 0.0));
        assert_eq!(histogram(&values, &Axis::linear(0.0, 4.0), 2), [1, 3]);
    }

    #[test]
    fn verif_a_band_follows_its_points() {
        let x: Vec<f64> = (0..1000).map(|n| f64::from(n) / 100.0).collect();
        let y: Vec<f64> = (0..1000).map(|n| f64::from(n) / 100.0 + f64::from(n % 3) - 1.0).collect();
        let band = running_band(&x, &y, &Axis::linear(0.0, 10.0), 10);
        assert_eq!(band.iter().map(Vec::len).collect::<Vec<_>>(), [10]);
        assert!(
            band[0].iter().all(|(x, [low, middle, high])| (middle - x).abs() < 0.3 && low < middle && middle < high)
        );
        // No points from 3 to 5: the line is interrupted.
        let (x_gap, y_gap): (Vec<f64>, Vec<f64>) = x.iter().zip(&y).filter(|(x, _)| !(3.0..5.0).contains(*x)).unzip();
        let band = running_band(&x_gap, &y_gap, &Axis::linear(0.0, 10.0), 10);
        assert_eq!(band.iter().map(Vec::len).collect::<Vec<_>>(), [3, 5]);
        assert!(running_band(&x[..7], &y[..7], &Axis::linear(0.0, 10.0), 10).is_empty());
    }

    #[test]
    fn verif_invalid_columns_are_named() {
        assert_eq!(check("O−C", &[]).unwrap_err().to_string(), "nothing to draw: no O−C");
        let error = check("O−C", &[0.0, f64::NAN]).unwrap_err().to_string();
        assert!(error.contains("O−C: value 1 (counted from 0) is NaN"), "{error}");
        assert!(check_length("phase", &[0.0], 2).unwrap_err().to_string().contains("1 values; allowed: 2"));
    }
}
