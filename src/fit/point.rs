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
    /// If true, a group (track, night) is weighted by the square root of its number of points, so that large groups do
    /// not dominate.
    pub by_group: bool,
}

impl Default for RawWeights {
    /// Returns a scatter of 0.5 mag (single measurements show 0.4 to 0.8) and weights by group.
    fn default() -> Self {
        Self { scatter_mag: 0.5, by_group: true }
    }
}

/// Returns one point per measurement, with longitudes folded to [0, π].
pub fn points_of_measurements(measurements: &Measurements, weights: &RawWeights) -> Vec<FitPoint> {
    let point = |m: &Measurement| FitPoint {
        geometry: m.geometry.folded(),
        magnitude: m.magnitude.0,
        sigma_mag: m.sigma_mag.unwrap_or(0.0).hypot(weights.scatter_mag),
        group: m.group,
    };
    let mut points: Vec<FitPoint> = measurements.points.iter().map(point).collect();
    if weights.by_group {
        let factors = group_error_factors(&points);
        points.iter_mut().zip(factors).for_each(|(point, factor)| point.sigma_mag *= factor);
    }
    points
}

/// Returns factors for the errors of the points, such that each group is weighted by the square root of its number of
/// points instead of by that number. They leave Σ 1/σ² unchanged.
fn group_error_factors(points: &[FitPoint]) -> Vec<f64> {
    let groups = points.iter().map(|point| point.group as usize + 1).max().unwrap_or(0);
    let mut counts = vec![0.0_f64; groups];
    points.iter().for_each(|point| counts[point.group as usize] += 1.0);
    // 1/σ'² = 1/σ² n^-½ N / Σ n^-½
    let total: f64 = points.iter().map(|point| counts[point.group as usize].powf(-0.5)).sum();
    let level = points.len() as f64 / total;
    points.iter().map(|point| (counts[point.group as usize].powf(-0.5) * level).powf(-0.5)).collect()
}

/// Returns one point per kept pixel: its mode, with the interquartile range as its error. Each pixel is its own group.
///
/// With fewer than five points the interquartile range is not informative (it is 0 for one point). The error of such
/// pixels is the median interquartile range of the other pixels, or the usual scatter of single measurements (0.5 mag)
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
        Some(FitPoint { geometry, magnitude: pixel.mode_mag, sigma_mag, group: group as u32 })
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
