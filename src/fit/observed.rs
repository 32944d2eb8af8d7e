//! Measurements and pixels as points of a fit.

use crate::geometry::ViewingGeometry;
use crate::measured::{Measurements, Reduction};

use super::point::{FitPoint, group_error_factors};

/// A pixel is never taken to be known better than this, mag: half the photometric error that MMT-9 states.
const LEAST_PIXEL_SIGMA_MAG: f64 = 0.05;

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
    let point = |m: &crate::measured::Measurement| FitPoint {
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
pub fn points_of_pixels(reduction: &Reduction) -> Vec<FitPoint> {
    let point = |(group, pixel): (usize, &crate::measured::Pixel)| {
        let geometry = ViewingGeometry::from_angles(
            pixel.sun_latitude_rad,
            pixel.observer_longitude_rad,
            pixel.observer_latitude_rad,
            1000.0,
            pixel.height_km,
        )?;
        let sigma_mag = pixel.iqr_mag.max(LEAST_PIXEL_SIGMA_MAG);
        Some(FitPoint { geometry, magnitude: pixel.mode_mag, sigma_mag, group: group as u32 })
    };
    reduction.kept().enumerate().filter_map(point).collect()
}
