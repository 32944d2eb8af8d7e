//! What a fit sees of a measured magnitude.

use crate::geometry::ViewingGeometry;

/// One magnitude to be explained: a raw measurement or a reduced pixel.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct FitPoint {
    /// Where Sun and observer stood.
    pub geometry: ViewingGeometry,
    /// Magnitude at 1000 km.
    pub magnitude: f64,
    /// Its error, mag; positive.
    pub sigma_mag: f64,
    /// What it shares its faults with: a track, a night, a satellite. Points of one group stay together in
    /// cross-validation and vary together in the covariance.
    pub group: u32,
}

/// Errors that take account of groups: each group weighs the square root of its number of points instead of the number.
///
/// Returned as factors on the errors, 1 on average in the sense that Σ 1/σ² stays; a group of many points then counts for
/// more than one of few, but not by all of its points, which share their faults.
pub fn group_error_factors(points: &[FitPoint]) -> Vec<f64> {
    let groups = points.iter().map(|point| point.group as usize + 1).max().unwrap_or(0);
    let mut counts = vec![0.0_f64; groups];
    points.iter().for_each(|point| counts[point.group as usize] += 1.0);
    // 1/σ'² = 1/σ² n^-½ N / Σ n^-½
    let total: f64 = points.iter().map(|point| counts[point.group as usize].powf(-0.5)).sum();
    let level = points.len() as f64 / total;
    points.iter().map(|point| (counts[point.group as usize].powf(-0.5) * level).powf(-0.5)).collect()
}
