//! Offsets of nights, and scatter of satellites in the same geometry, in the photometry of V1.5: neither would improve
//! predictions.
//!
//! Requires the data folder; skipped with a message without it.

use std::collections::BTreeMap;

use streakcast::fit::{HeldOutPoint, weighted_quantile};
use streakcast::photometry::pass_correlation;

use super::survey::{GroupMean, SURVEYS, Weighted, in_order_of_held_out, median_and_sigma_mag};

/// Correlation of the residuals of a night (docs/explanation/models.md).
const CORRELATION: f64 = 0.2;
/// Distance of two measurements in the same geometry, degrees.
const SAME_DEG: f64 = 1.5;
/// Changes and scatter in docs/explanation/models.md, mag, and their tolerance.
const CHANGES_MAG: [f64; 2] = [0.007, -0.014];
const SCATTER_MAG: f64 = 0.37;
const DOCUMENTED_MAG: f64 = 0.02;

/// Change of the mean absolute residual of a night by the offset of its first `first` measurements, mag.
fn change_mag(points: &[HeldOutPoint], median_mag: f64, sigma_mag: f64, first: usize) -> GroupMean {
    let mut nights = BTreeMap::<u32, Vec<(f64, f64)>>::new();
    for one in points {
        nights.entry(one.group).or_default().push((one.residual_mag() - median_mag, one.weight));
    }
    let (mut values, n) = (Vec::new(), first as f64);
    for (group, night) in nights.iter().filter(|(_, night)| night.len() > first) {
        let clipped = night[..first].iter().map(|(r, _)| r.clamp(-3.0 * sigma_mag, 3.0 * sigma_mag));
        // Best linear estimate of an offset with the correlation ρ: n ρ / (1 + (n - 1) ρ) times the mean.
        let offset = clipped.sum::<f64>() / n * n * CORRELATION / (1.0 + (n - 1.0) * CORRELATION);
        let change =
            |(r, weight): &(f64, f64)| Weighted { value: (r - offset).abs() - r.abs(), weight: *weight, group: *group };
        values.extend(night[first..].iter().map(change));
    }
    GroupMean::of(values)
}

#[test]
fn valid_nights_have_no_common_offset() {
    let Some(data) = crate::common::data_dir() else { return };
    let survey = &SURVEYS[0];
    let points = survey.points(&data);
    let held_out = survey.held_out(&survey.models[0], &points);
    let [median_mag, sigma_mag] = median_and_sigma_mag(held_out.iter());
    let changes = [1, 10].map(|first| change_mag(&held_out, median_mag, sigma_mag, first));
    println!(
        "change of the mean absolute residual by the first and the first ten measurements of a night: {changes:.3?}"
    );
    // Pairs of measurements of different nights in the same geometry.
    let ordered = in_order_of_held_out(&points);
    let mut pairs = Vec::new();
    for (i, (one, here)) in ordered.iter().zip(&held_out).enumerate() {
        for (other, there) in ordered.iter().zip(&held_out).skip(i + 1).filter(|(_, there)| there.group != here.group) {
            let distance_deg = -12.0 * (pass_correlation(&one.geometry, &other.geometry) / 0.9).ln();
            if distance_deg < SAME_DEG {
                let scatter_mag = (here.residual_mag() - there.residual_mag()).abs() / std::f64::consts::SQRT_2;
                pairs.push((scatter_mag, here.weight * there.weight));
            }
        }
    }
    let scatter_mag = weighted_quantile(&mut pairs, 0.6827);
    println!(
        "{} pairs in the same geometry, scatter of a measurement {scatter_mag:.3} mag, sigma {sigma_mag:.3} mag",
        pairs.len()
    );
    for (change, documented) in changes.iter().zip(CHANGES_MAG) {
        assert!((change.mean - documented).abs() < DOCUMENTED_MAG, "{changes:?}");
        assert!(change.mean > -2.0 * change.error - 0.01, "an offset of nights would improve predictions: {change:?}");
    }
    assert!((scatter_mag - SCATTER_MAG).abs() < DOCUMENTED_MAG, "{scatter_mag}");
    assert!(pairs.len() > 50 && scatter_mag > 0.8 * sigma_mag, "{scatter_mag}");
}
