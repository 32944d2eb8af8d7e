//! Pixels along a measured track, and their profile across it.

use super::background::SIGMA_OF_MAD;
use super::measurement::{StreakImage, StreakMeasurement};
use crate::images::PixelPosition;
use crate::math::quantile::median;
use crate::streaks::RadialProfile;

/// Half width of a cut in widths of the streak, and its smallest and largest value in pixels.
const HALF_WIDTHS: f64 = 6.0;
const LEAST_HALF_PIX: f64 = 10.0;
const MOST_HALF_PIX: f64 = 60.0;
/// Largest number of columns of a cut.
const MOST_COLUMNS: usize = 330;
/// The sky of a column is measured beyond this fraction of the half width.
const SKY_FROM: f64 = 0.5;

/// Pixels along a measured track, less the sky, and their profile across the track.
#[derive(Clone, Debug, PartialEq)]
pub struct StreakCut {
    /// Number of columns along the track.
    pub columns: usize,
    /// Length of the track in the image, pixels.
    pub length_pix: f64,
    /// Distances across the track, pixels, increasing; shape `(n_row)`. Their sign is that of
    /// [`offset_pix`](StreakMeasurement::offset_pix).
    pub across_pix: Vec<f64>,
    /// Mean of the pixels of each row and column, less the sky, row by row; NaN without pixels; shape
    /// `(n_row * columns)`.
    pub values: Vec<f64>,
    /// Median of each row, which stars do not affect; NaN without pixels; shape `(n_row)`.
    pub profile: Vec<f64>,
    /// Error (one sigma) of the profile; shape `(n_row)`.
    pub profile_sigma: Vec<f64>,
    /// Fitted streak at each row; shape `(n_row)`.
    pub model: Vec<f64>,
}

/// Returns the pixels along a measured track. `profile` is the image of the satellite with which the streak was drawn.
pub fn streak_cut(image: &StreakImage<'_>, measured: &StreakMeasurement, profile: &RadialProfile) -> StreakCut {
    let [from_s, to_s] = measured.inside_s;
    let (first, last) = (measured.path.point_at(from_s), measured.path.point_at(to_s));
    let length_pix = first.distance(last).max(1.0);
    let [ex, ey] = [(last.x - first.x) / length_pix, (last.y - first.y) / length_pix];
    // Positive distances have larger y, or larger x for a track nearer to the columns.
    let sense = if ex.abs() >= ey.abs() { ex.signum() } else { -ey.signum() };
    let [nx, ny] = [-ey * sense, ex * sense];
    let wanted = (HALF_WIDTHS * profile.fwhm_pix()).max(LEAST_HALF_PIX).max(1.3 * measured.offset_pix.value.abs());
    let half = wanted.min(MOST_HALF_PIX).ceil() as usize;
    let rows = 2 * half + 1;
    let columns = (length_pix.ceil() as usize).clamp(1, MOST_COLUMNS);
    let steps = (length_pix / columns as f64).ceil() as usize;
    let across_pix: Vec<f64> = (0..rows).map(|row| row as f64 - half as f64).collect();
    let (mut sums, mut counts) = (vec![0.0; rows * columns], vec![0.0; rows * columns]);
    // Sums of the model and numbers of pixels by row. The model is evaluated at the distances of the pixels from the
    // track, which differ from that of the row by up to 0.7 pixels.
    let (mut light, mut lit) = (vec![0.0; rows], vec![0.0; rows]);
    let angle_rad = ey.atan2(ex);
    let speed_pix_s = length_pix / (to_s - from_s).max(1e-9);
    for step in 0..columns * steps {
        let share = (step as f64 + 0.5) / (columns * steps) as f64;
        let at = measured.path.point_at(from_s + share * (to_s - from_s));
        for (row, across) in across_pix.iter().enumerate() {
            let pixel = PixelPosition { x: (at.x + nx * across).round(), y: (at.y + ny * across).round() };
            if !image.light_area.contains(pixel) {
                continue;
            }
            let value = f64::from(image.plane.row(pixel.y as usize)[pixel.x as usize]);
            if value.is_finite() {
                let index = row * columns + step / steps;
                sums[index] += value;
                counts[index] += 1.0;
                let away = (pixel.x - at.x) * nx + (pixel.y - at.y) * ny;
                light[row] += measured.rate.value / speed_pix_s * profile.line(away, angle_rad);
                lit[row] += 1.0;
            }
        }
    }
    let mut values: Vec<f64> = sums.iter().zip(&counts).map(|(sum, count)| sum / count).collect();
    for column in 0..columns {
        let is_sky = |row: &usize| across_pix[*row].abs() > SKY_FROM * half as f64;
        let sky: Vec<f64> = (0..rows)
            .filter(is_sky)
            .map(|row| values[row * columns + column])
            .filter(|value| value.is_finite())
            .collect();
        let level = if sky.is_empty() { f64::NAN } else { median(sky) };
        (0..rows).for_each(|row| values[row * columns + column] -= level);
    }
    let (profile, profile_sigma) = values
        .chunks_exact(columns)
        .map(|row| {
            let finite: Vec<f64> = row.iter().copied().filter(|value| value.is_finite()).collect();
            if finite.is_empty() {
                return (f64::NAN, f64::NAN);
            }
            let middle = median(finite.clone());
            let scatter = SIGMA_OF_MAD * median(finite.iter().map(|value| (value - middle).abs()).collect());
            (middle, scatter * (std::f64::consts::FRAC_PI_2 / finite.len() as f64).sqrt())
        })
        .unzip();
    let model = light.iter().zip(&lit).map(|(light, lit)| light / lit).collect();
    StreakCut { columns, length_pix, across_pix, values, profile, profile_sigma, model }
}
