//! Measurements and pixels as points of a fit.

use super::measurements::{Measurements, Pixel, Reduction};
use crate::geometry::ViewingGeometry;
use crate::math::quantile::quantile;

use super::point::{FitPoint, group_error_factors};

/// A pixel is never taken to be known better than this, mag: half the photometric error that MMT-9 states.
const LEAST_PIXEL_SIGMA_MAG: f64 = 0.05;
/// The interquartile range of fewer points than this is no error of theirs.
const LEAST_FOR_RANGE: u32 = 5;

/// How single measurements are weighed.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct RawWeights {
    /// Scatter that is not of the measurement, mag: satellites of one kind differ and wobble by this. Added in quadrature to the
    /// error that the survey states; where it states none, all there is. Positive.
    pub scatter_mag: f64,
    /// Groups (tracks, nights) weigh the square root of their numbers of points, so that no long one rules.
    pub by_group: bool,
}

impl Default for RawWeights {
    /// 0.5 mag (0.4 to 0.8 is what raw points show), by group.
    fn default() -> Self {
        Self { scatter_mag: 0.5, by_group: true }
    }
}

/// Every measurement as a point, longitudes folded to [0, π].
pub fn points_of_measurements(measurements: &Measurements, weights: &RawWeights) -> Vec<FitPoint> {
    let point = |m: &super::measurements::Measurement| FitPoint {
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

/// Every kept pixel as a point: its mode with the interquartile range as error, a group of its own.
///
/// Of fewer than five points the range says next to nothing (of one it is 0); the error of such pixels is the median of the others' ranges, or
/// the usual scatter of single measurements (0.5 mag) where there are no others.
pub fn points_of_pixels(reduction: &Reduction) -> Vec<FitPoint> {
    let knows = |pixel: &Pixel| pixel.count >= LEAST_FOR_RANGE;
    let mut ranges_mag: Vec<f64> = reduction.kept().filter(|pixel| knows(pixel)).map(|pixel| pixel.iqr_mag).collect();
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
        let sigma_mag = if knows(pixel) { pixel.iqr_mag } else { pooled_mag }.max(LEAST_PIXEL_SIGMA_MAG);
        Some(FitPoint { geometry, magnitude: pixel.mode_mag, sigma_mag, group: group as u32 })
    };
    reduction.kept().enumerate().filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::super::measurements::{DensityMode, Measurement, ReduceOptions, reduce};
    use super::*;
    use crate::photometry::StandardMagnitude;

    /// Points of one place each, so that each is a pixel.
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
    fn verif_few_points_do_not_weigh_most() {
        /// Pixels keep magnitudes as f32, mag.
        const ROUNDED: f64 = 1e-6;
        let (narrow, wide) = ([5.0, 5.1, 5.2, 5.3, 5.4], [5.0, 5.3, 5.6, 5.9, 6.2, 6.5, 6.8]);
        // IQR 0.2 and 0.9; one point, two and four take what lies in the middle.
        let sigmas = sigmas_mag(&[&narrow, &wide, &[6.0], &[6.0, 6.1], &[5.0, 5.0, 5.0, 5.0]]);
        for (sigma, expected) in sigmas.iter().zip([0.2, 0.55, 0.55, 0.55, 0.9]) {
            assert!((sigma - expected).abs() < ROUNDED, "{sigmas:?}");
        }
        assert_eq!(sigmas_mag(&[&[6.0], &[6.0, 6.1]]), [RawWeights::default().scatter_mag; 2]);
        // Equal magnitudes are five times the same, and no more certain than photometry.
        assert_eq!(sigmas_mag(&[&[5.0; 5]]), [LEAST_PIXEL_SIGMA_MAG]);
    }
}
