//! Points of a fit, made of measurements or of reduced pixels.

use crate::geometry::ViewingGeometry;
use crate::math::quantile::quantile;

use super::measurements::{Measurement, Measurements, Pixel, Reduction};

/// Least error of a pixel, mag: half the photometric error stated for MMT-9.
const LEAST_PIXEL_SIGMA_MAG: f64 = 0.05;
/// The interquartile range of fewer points than this is not used as an error.
const LEAST_FOR_RANGE: u32 = 5;

/// One magnitude to fit: a single measurement or a reduced pixel.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FitPoint {
    /// Directions of Sun and observer.
    pub geometry: ViewingGeometry,
    /// Magnitude at 1000 km.
    pub magnitude: f64,
    /// Error of the magnitude, mag; positive.
    pub sigma_mag: f64,
    /// Number of the track, night or satellite, a group of points with shared systematic errors. Points of one group
    /// stay together in cross-validation and vary together in the covariance.
    pub group: u32,
}

/// Weights of single measurements.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RawWeights {
    /// Scatter beyond the measurement errors, mag, positive: satellites of one kind differ and change their attitude.
    /// Added in quadrature to the stated error; the only error if none is stated.
    pub scatter_mag: f64,
    /// Weights a group (track, night) by the square root of its number of points, so that long groups do not dominate.
    pub by_group: bool,
}

impl Default for RawWeights {
    /// 0.5 mag (raw points show 0.4 to 0.8), by group.
    fn default() -> Self {
        Self { scatter_mag: 0.5, by_group: true }
    }
}

/// Returns one point per measurement, longitudes folded to [0, π].
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

/// Factors on the errors by which a group is weighted by the square root of its number of points instead of the number;
/// Σ 1/σ² is kept.
fn group_error_factors(points: &[FitPoint]) -> Vec<f64> {
    let groups = points.iter().map(|point| point.group as usize + 1).max().unwrap_or(0);
    let mut counts = vec![0.0_f64; groups];
    points.iter().for_each(|point| counts[point.group as usize] += 1.0);
    // 1/σ'² = 1/σ² n^-½ N / Σ n^-½
    let total: f64 = points.iter().map(|point| counts[point.group as usize].powf(-0.5)).sum();
    let level = points.len() as f64 / total;
    points.iter().map(|point| (counts[point.group as usize].powf(-0.5) * level).powf(-0.5)).collect()
}

/// Returns one point per kept pixel: its mode, with the interquartile range as error, in a group of its own.
///
/// The range of fewer than five points is uninformative (0 for one point); the error of such pixels is the median range
/// of the others, or the usual scatter of single measurements (0.5 mag) if there are no others.
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

    /// Points at one position each, so that each is a pixel.
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
        // IQR 0.2 and 0.9; cells of one, two and four points get the median of these.
        let sigmas = sigmas_mag(&[&narrow, &wide, &[6.0], &[6.0, 6.1], &[5.0, 5.0, 5.0, 5.0]]);
        for (sigma, expected) in sigmas.iter().zip([0.2, 0.55, 0.55, 0.55, 0.9]) {
            assert!((sigma - expected).abs() < ROUNDED, "{sigmas:?}");
        }
        assert_eq!(sigmas_mag(&[&[6.0], &[6.0, 6.1]]), [RawWeights::default().scatter_mag; 2]);
        // Five equal magnitudes are no more certain than the photometry.
        assert_eq!(sigmas_mag(&[&[5.0; 5]]), [LEAST_PIXEL_SIGMA_MAG]);
    }
}
