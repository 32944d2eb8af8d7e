//! Points of a fit, made from measurements or from pixels of reduced measurements.

use crate::geometry::ViewingGeometry;
use crate::math::quantile::quantile;

use super::measurements::{Measurement, Measurements, Pixel, Reduction};

/// Smallest error of a pixel, mag. It is half the photometric error stated for MMT-9.
const LEAST_PIXEL_SIGMA_MAG: f64 = 0.05;
/// Number of points below which the interquartile range of a pixel is not used as its error.
const LEAST_FOR_RANGE: u32 = 5;

/// One magnitude to be fitted: a single measurement or a reduced pixel.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FitPoint {
    /// Directions of Sun and observer.
    pub geometry: ViewingGeometry,
    /// Magnitude at 1000 km.
    pub magnitude: f64,
    /// Error of the magnitude (one sigma), mag; positive.
    pub sigma_mag: f64,
    /// Weight of its loss in the cost, above 0 to 1; below 1 if magnitudes of its group are correlated.
    pub weight: f64,
    /// Number of the track, night or satellite to which the point belongs. Points of the same group share systematic
    /// errors: they are kept together in cross-validation and in the covariance.
    pub group: u32,
}

/// Weights of single measurements.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RawWeights {
    /// Scatter in addition to the measurement errors, mag, positive, because satellites of one type differ and change
    /// their attitude. It is added in quadrature to the stated error, and is the only error if none is stated.
    pub scatter_mag: f64,
    /// Correlation of the magnitudes of one group (track, night, pass), 0 to 1. Each of n points of a group has the
    /// weight 1/(1 + (n - 1) correlation); see [`weigh_groups`](super::weigh_groups).
    pub group_correlation: f64,
}

impl Default for RawWeights {
    /// Returns a scatter of 0.3 mag (single measurements scatter by 0.24 to 0.44 mag) and a correlation of 0.5
    /// (measured: 0.2 to 0.6).
    fn default() -> Self {
        Self { scatter_mag: 0.3, group_correlation: 0.5 }
    }
}

/// Returns one point per measurement, with longitudes folded to [0, π].
pub fn points_of_measurements(measurements: &Measurements, weights: &RawWeights) -> Vec<FitPoint> {
    let point = |m: &Measurement| FitPoint {
        geometry: m.geometry.folded(),
        magnitude: m.magnitude.0,
        sigma_mag: m.sigma_mag.unwrap_or(0.0).hypot(weights.scatter_mag),
        weight: 1.0,
        group: m.group,
    };
    let mut points: Vec<FitPoint> = measurements.points.iter().map(point).collect();
    weigh(&mut points, weights.group_correlation);
    points
}

/// Sets the weights of points for a correlation of the magnitudes of one group.
pub(super) fn weigh(points: &mut [FitPoint], correlation: f64) {
    let groups: Vec<u32> = points.iter().map(|point| point.group).collect();
    let weights = group_weights(&groups, correlation);
    points.iter_mut().zip(weights).for_each(|(point, weight)| point.weight = weight);
}

/// Returns the weight of each measurement from the numbers of their groups and the correlation within a group, 0 to 1.
/// The sum of the weights is the effective number of independent measurements.
pub fn group_weights(groups: &[u32], correlation: f64) -> Vec<f64> {
    let mut counts = std::collections::HashMap::<u32, f64>::new();
    groups.iter().for_each(|group| *counts.entry(*group).or_default() += 1.0);
    // w = 1/(1 + (n - 1) ρ)                        design effect of clusters, Kish (1965), Survey Sampling, section 8.2
    groups.iter().map(|group| 1.0 / (1.0 + (counts[group] - 1.0) * correlation)).collect()
}

/// Returns one point per kept pixel: its mode, with the interquartile range as its error. Each pixel is its own group.
///
/// With fewer than five points the interquartile range is not informative (it is 0 for one point). The error of such
/// pixels is the median interquartile range of the other pixels, or the usual scatter of single measurements (0.3 mag)
/// if there are no others.
pub fn points_of_pixels(reduction: &Reduction) -> Vec<FitPoint> {
    let has_range = |pixel: &Pixel| pixel.count >= LEAST_FOR_RANGE;
    let mut ranges_mag: Vec<f64> =
        reduction.kept().filter(|pixel| has_range(pixel)).map(|pixel| pixel.iqr_mag).collect();
    ranges_mag.sort_by(f64::total_cmp);
    let pooled_mag = if ranges_mag.is_empty() { RawWeights::default().scatter_mag } else { quantile(&ranges_mag, 0.5) };
    let point = |(group, pixel): (usize, &Pixel)| {
        let geometry = ViewingGeometry::from_angles(
            pixel.sun_latitude_rad,
            pixel.observer_longitude_rad,
            pixel.observer_latitude_rad,
            1000.0,
            pixel.height_km,
        )?;
        let sigma_mag = if has_range(pixel) { pixel.iqr_mag } else { pooled_mag }.max(LEAST_PIXEL_SIGMA_MAG);
        Some(FitPoint { geometry, magnitude: pixel.mode_mag, sigma_mag, weight: 1.0, group: group as u32 })
    };
    reduction.kept().enumerate().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::super::measurements::{DensityMode, Measurement, ReduceOptions, reduce};
    use super::*;
    use crate::photometry::StandardMagnitude;

    /// Returns the errors of pixels, each given by its magnitudes, which are all at one position.
    fn sigmas_mag(pixels: &[&[f64]]) -> Vec<f64> {
        let points: Vec<Measurement> = pixels
            .iter()
            .enumerate()
            .flat_map(|(i, magnitudes)| {
                let geometry = ViewingGeometry::from_angles(-0.2, 0.3 * i as f64 + 0.1, -0.8, 1000.0, 550.0);
                let point = move |magnitude: &f64| Measurement {
                    magnitude: StandardMagnitude(*magnitude),
                    sigma_mag: None,
                    geometry: geometry.expect("a geometry"),
                    group: i as u32,
                    norad_id: None,
                    epoch: None,
                    grazing_height_km: None,
                    lit_fraction: 1.0,
                };
                magnitudes.iter().map(point)
            })
            .collect();
        let options =
            ReduceOptions { least_count: 1, most_iqr_mag: 2.0, mode: DensityMode::Kernel, ..ReduceOptions::default() };
        let mut sigmas: Vec<f64> =
            points_of_pixels(&reduce(&points, options).expect("pixels")).iter().map(|point| point.sigma_mag).collect();
        sigmas.sort_by(f64::total_cmp);
        sigmas
    }

    #[test]
    fn verif_few_points_do_not_have_the_largest_weight() {
        /// Rounding of magnitudes in pixels, which are f32, mag.
        const ROUNDED: f64 = 1e-6;
        let (narrow, wide) = ([5.0, 5.1, 5.2, 5.3, 5.4], [5.0, 5.3, 5.6, 5.9, 6.2, 6.5, 6.8]);
        // Interquartile ranges of 0.2 and 0.9; pixels of one, two and four points get the median of these.
        let sigmas = sigmas_mag(&[&narrow, &wide, &[6.0], &[6.0, 6.1], &[5.0, 5.0, 5.0, 5.0]]);
        for (sigma, expected) in sigmas.iter().zip([0.2, 0.55, 0.55, 0.55, 0.9]) {
            assert!((sigma - expected).abs() < ROUNDED, "{sigmas:?}");
        }
        assert_eq!(sigmas_mag(&[&[6.0], &[6.0, 6.1]]), [RawWeights::default().scatter_mag; 2]);
        // Five equal magnitudes are no more certain than the photometry.
        assert_eq!(sigmas_mag(&[&[5.0; 5]]), [LEAST_PIXEL_SIGMA_MAG]);
    }
}
