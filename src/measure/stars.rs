//! Mask of stars and defects in the band around a streak.

use super::background::SIGMA_OF_MAD;
use super::band::Band;
use super::fit::{Blocks, fit_blocks};
use crate::math::quantile::median;

/// Threshold in sigmas of the light averaged over 3 by 3 pixels.
const THRESHOLD_SIGMAS: f64 = 4.0;
/// Error of the model of the streak, as a fraction of the model at the pixel and as a fraction of its peak; both are
/// added.
const MODEL_ERROR: f64 = 0.2;
const MODEL_ERROR_OF_PEAK: f64 = 0.02;
/// Pixels with at least this fraction of the greatest light of their column belong to the core of the streak.
const CORE: f32 = 0.3;
/// Light of a streak's middle from which its core is bright, sigmas of the noise.
const CORE_SIGMAS: f64 = 2.0;
/// Half length of the running median of the streak's light in widths of the streak, and its smallest value in pixels.
const MEDIAN_WIDTHS: f64 = 4.0;
const MEDIAN_PIX: usize = 15;
/// Half length, in widths of the streak, and its smallest value, pixels, of the part of the streak along which the
/// errors of its model are measured, and distance from its middle to which they are, in widths.
const ERROR_WIDTHS: f64 = 8.0;
const ERROR_PIX: usize = 30;
const ERROR_REACH_WIDTHS: f64 = 3.0;
/// Usual residuals from which the model has errors, sigmas of the noise.
const ERROR_SIGMAS: f32 = 1.5;

/// Mask of stars and defects, which depends on the model of the streak: a star that is fainter than the error of the
/// model is not marked.
pub struct StarMask {
    /// True for pixels with the light of stars or defects.
    pub mask: Vec<bool>,
    /// Residuals averaged over 3 by 3 pixels.
    smooth: Vec<f32>,
    /// Threshold of each column, and its increase per unit of the template.
    thresholds: Vec<[f32; 2]>,
    /// Threshold of each pixel by the errors of the model; 0 beside the streak.
    errors: Vec<f32>,
    /// Distance to which the surroundings of a marked pixel are masked, pixels.
    reach: isize,
}

impl StarMask {
    /// Returns the largest residual in the surroundings of each pixel.
    pub fn levels(&self, band: &Band) -> Vec<f32> {
        largest_near(band, &self.smooth, self.reach)
    }

    /// Returns the residual above which a pixel is marked where the template has a value.
    pub fn threshold(&self, column: usize, template: f32) -> f32 {
        let [constant, slope] = self.thresholds[column];
        constant + slope * template
    }
}

/// Marks pixels that are brighter than streak and background, with their surroundings.
///
/// 1. The background of a block is the median of its pixels outside the streak.
/// 2. The light of the streak is fitted in each column; its running median is not affected by stars, which are shorter
///    than the median's length.
/// 3. The median of the residuals at each distance across the streak is subtracted, because the profile of the streak
///    may differ from the model.
/// 4. The residuals are averaged over 3 by 3 pixels; those above the threshold are marked. On the streak the threshold
///    is
///    not below the usual residuals at the same distance from its middle, which are the errors of the model of a bright
///    streak; stars are shorter than the part of the streak in which these are measured.
/// 5. All pixels within one FWHM of a marked pixel are marked.
///
/// With `keeps_core`, no pixel within 1.5 FWHM of the middle of a bright streak is marked, because the template is not
/// yet aligned with the streak. The pixels of a faint streak are below the threshold.
pub fn mask_stars(band: &Band, template: &[f32], blocks: &Blocks, fwhm_pix: f64, keeps_core: bool) -> StarMask {
    let height = band.height;
    let peak_of = |column: usize| template[column * height..][..height].iter().copied().fold(0.0, f32::max);
    let peaks: Vec<f32> = (0..band.len()).map(peak_of).collect();

    let mut background = vec![0.0f32; band.len()];
    for columns in blocks.ranges() {
        let pixels =
            columns.clone().flat_map(|column| (0..height).map(move |offset| (column, column * height + offset)));
        let mut values: Vec<f32> = pixels
            .filter(|(column, at)| band.values[*at].is_finite() && template[*at] <= 0.05 * peaks[*column])
            .map(|(_, at)| band.values[at])
            .collect();
        if values.is_empty() {
            continue;
        }
        let middle = values.len() / 2;
        let level = *values.select_nth_unstable_by(middle, f32::total_cmp).1;
        background[columns].fill(level);
    }
    let light = column_light(band, template, &peaks, &background, fwhm_pix);

    // Residuals; 0 where the frame has no pixel.
    let mut residual = vec![0.0f32; band.values.len()];
    for column in 0..band.len() {
        for offset in 0..height {
            let at = column * height + offset;
            let value = band.values[at] - background[column] - light[column] * template[at];
            residual[at] = if value.is_finite() { value } else { 0.0 };
        }
    }
    subtract_profile(band, &mut residual, &peaks);
    let smooth = averaged(band, &residual);
    let sampled = smooth.iter().zip(&band.values).step_by(7).filter(|(_, value)| value.is_finite());
    let sigma = SIGMA_OF_MAD * median(sampled.map(|(value, _)| f64::from(value.abs())).collect());
    let threshold = |(light, peak): (&f32, &f32)| {
        [(THRESHOLD_SIGMAS * sigma) as f32 + MODEL_ERROR_OF_PEAK as f32 * light * peak, MODEL_ERROR as f32 * light]
    };
    let reach = fwhm_pix.round().max(1.0) as isize;
    let thresholds = light.iter().zip(&peaks).map(threshold).collect();
    let errors = model_errors(band, &smooth, &peaks, fwhm_pix, sigma as f32);
    let mut stars = StarMask { mask: Vec::new(), smooth, thresholds, errors, reach };
    let excess = |at: usize| stars.smooth[at] - stars.threshold(at / height, template[at]).max(stars.errors[at]);
    let excess: Vec<f32> = (0..template.len()).map(excess).collect();
    stars.mask = largest_near(band, &excess, reach).into_iter().map(|excess| excess > 0.0).collect();
    if keeps_core {
        let core = (1.5 * fwhm_pix / band.cos).ceil() as usize;
        let is_bright = |column: usize| f64::from(light[column] * peaks[column]) > CORE_SIGMAS * sigma;
        for (_, column) in stars.mask.chunks_exact_mut(height).enumerate().filter(|(column, _)| is_bright(*column)) {
            column[(height / 2).saturating_sub(core)..=(height / 2 + core).min(height - 1)].fill(false);
        }
    }
    stars
}

/// Returns the threshold of each pixel near the middle of the streak by the residuals along the streak: the threshold
/// in sigmas, with the running median of their absolute values at this distance from the middle as a measure of sigma.
/// 0 where this is the noise `sigma` of the band.
fn model_errors(band: &Band, smooth: &[f32], peaks: &[f32], fwhm_pix: f64, sigma: f32) -> Vec<f32> {
    let (height, half) = (band.height, band.half());
    let mut errors = vec![0.0f32; smooth.len()];
    let near = ((ERROR_REACH_WIDTHS * fwhm_pix / band.cos).ceil() as usize).min(half);
    let reach = ((ERROR_WIDTHS * fwhm_pix) as usize).max(ERROR_PIX);
    let lit: Vec<usize> = (0..band.len()).filter(|column| peaks[*column] > 0.0).collect();
    // In shorter streaks a star may be most of them.
    if lit.len() < 2 * reach {
        return errors;
    }
    let mut values: Vec<f32> = Vec::with_capacity(2 * reach + 1);
    for offset in half - near..=half + near {
        for (number, column) in lit.iter().enumerate() {
            let along = &lit[number.saturating_sub(reach)..(number + reach + 1).min(lit.len())];
            let along = along.iter().map(|other| other * height + offset);
            values.clear();
            values.extend(along.filter(|at| band.values[*at].is_finite()).map(|at| smooth[at].abs()));
            if values.is_empty() {
                continue;
            }
            let middle = values.len() / 2;
            let error = SIGMA_OF_MAD as f32 * *values.select_nth_unstable_by(middle, f32::total_cmp).1;
            if error > ERROR_SIGMAS * sigma {
                errors[column * height + offset] = THRESHOLD_SIGMAS as f32 * error;
            }
        }
    }
    errors
}

/// Subtracts the median along the streak at each distance across it. Where the streak ends, it is reduced with the
/// light of the streak.
fn subtract_profile(band: &Band, residual: &mut [f32], peaks: &[f32]) {
    let height = band.height;
    let lit: Vec<usize> = (0..band.len()).filter(|column| peaks[*column] > 0.0).collect();
    let usual = median(lit.iter().map(|column| f64::from(peaks[*column])).collect()) as f32;
    let mut values: Vec<f32> = Vec::with_capacity(lit.len());
    for offset in 0..height {
        let used = lit.iter().map(|column| column * height + offset);
        values.clear();
        values.extend(used.filter(|at| band.values[*at].is_finite()).map(|at| residual[at]));
        // The median of too few pixels is not used.
        if 2 * values.len() < lit.len() || values.is_empty() {
            continue;
        }
        let middle = values.len() / 2;
        let level = *values.select_nth_unstable_by(middle, f32::total_cmp).1;
        for column in &lit {
            residual[column * height + offset] -= level * (peaks[*column] / usual).min(1.0);
        }
    }
}

/// Returns the light of the streak in each column: a running median of the amplitudes of single columns.
fn column_light(band: &Band, template: &[f32], peaks: &[f32], background: &[f32], fwhm_pix: f64) -> Vec<f32> {
    let height = band.height;
    let amplitude = |column: usize| -> Option<f64> {
        let (mut signal, mut weight) = (0.0, 0.0);
        for offset in 0..height {
            let at = column * height + offset;
            let is_core = template[at] > CORE * peaks[column] && template[at] > 0.0;
            if is_core && band.values[at].is_finite() {
                signal += f64::from(template[at] * (band.values[at] - background[column]));
                weight += f64::from(template[at] * template[at]);
            }
        }
        (weight > 0.0).then(|| signal / weight)
    };
    let amplitudes: Vec<Option<f64>> = (0..band.len()).map(amplitude).collect();
    let reach = ((MEDIAN_WIDTHS * fwhm_pix) as usize).max(MEDIAN_PIX);
    (0..band.len())
        .map(|column| {
            let near = column.saturating_sub(reach)..(column + reach + 1).min(band.len());
            let near: Vec<f64> = amplitudes[near].iter().flatten().copied().collect();
            if near.is_empty() { 0.0 } else { median(near).max(0.0) as f32 }
        })
        .collect()
}

/// Returns the average over 3 by 3 pixels of the frame.
fn averaged(band: &Band, values: &[f32]) -> Vec<f32> {
    let height = band.height;
    let mut columns = vec![0.0f32; values.len()];
    for column in 0..band.len() {
        let own = &values[column * height..][..height];
        for offset in 0..height {
            let near = &own[offset.saturating_sub(1)..(offset + 2).min(height)];
            columns[column * height + offset] = near.iter().sum::<f32>() / 3.0;
        }
    }
    let mut averaged = vec![0.0f32; values.len()];
    for column in 0..band.len() {
        for other in column.saturating_sub(1)..(column + 2).min(band.len()) {
            let step = band.step(other, column);
            for offset in 0..height {
                let source = offset as isize + step;
                if (0..height as isize).contains(&source) {
                    averaged[column * height + offset] += columns[other * height + source as usize] / 3.0;
                }
            }
        }
    }
    averaged
}

/// Returns the largest value within `reach` pixels of each pixel, in a square.
fn largest_near(band: &Band, values: &[f32], reach: isize) -> Vec<f32> {
    let (height, reach) = (band.height, reach.unsigned_abs());
    let mut columns = vec![f32::NEG_INFINITY; values.len()];
    for (largest, own) in columns.chunks_exact_mut(height).zip(values.chunks_exact(height)) {
        for (offset, largest) in largest.iter_mut().enumerate() {
            let near = &own[offset.saturating_sub(reach)..(offset + reach + 1).min(height)];
            *largest = near.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        }
    }
    let mut all = vec![f32::NEG_INFINITY; values.len()];
    for (column, largest) in all.chunks_exact_mut(height).enumerate() {
        for other in column.saturating_sub(reach)..(column + reach + 1).min(band.len()) {
            // The offset 0 of one column is the offset `step` of the other.
            let step = band.step(other, column);
            let (from, to) = (
                (-step).clamp(0, height as isize) as usize,
                (height as isize - step).clamp(0, height as isize) as usize,
            );
            let first = (from as isize + step).clamp(0, height as isize) as usize;
            let near = &columns[other * height + first..][..to.saturating_sub(from)];
            largest[from..].iter_mut().zip(near).for_each(|(largest, near)| *largest = largest.max(*near));
        }
    }
    all
}

/// Residuals of the fit: the data minus the template with the amplitude of each block.
pub fn without_streak(band: &Band, mask: &[bool], template: &[f32], blocks: &Blocks) -> Vec<f32> {
    let fits = fit_blocks(band, &band.values, mask, template, 0, blocks);
    let mut rest = band.values.clone();
    for (columns, fit) in blocks.ranges().zip(fits) {
        let amplitude = fit.amplitude().unwrap_or(0.0).max(0.0) as f32;
        for at in columns.start * band.height..columns.end * band.height {
            rest[at] -= amplitude * template[at];
        }
    }
    rest
}
