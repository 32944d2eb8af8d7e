//! Errors of a measured streak: the scatter of control fits, which are fits of the same template at both sides of the
//! streak; the error of its offset across the track; and the bias of its flux because its position is fitted.

use super::background::median_and_sigma;
use super::band::Band;
use super::fit::{Amplitude, BlockFit, Blocks, combined, fit_blocks_where};
use super::stars::StarMask;

/// Number of control fits on each side of the streak.
pub(super) const CONTROLS_A_SIDE: usize = 30;
/// Smallest weight of a control fit relative to that of the streak, and the smallest number of control fits from which
/// the error is computed.
const LEAST_CONTROL_WEIGHT: f64 = 0.5;
pub(super) const LEAST_CONTROLS: usize = 10;
/// Control fits beyond this number of robust sigmas are omitted.
const CONTROL_CLIP: f64 = 5.0;
/// Share of the control fits that is independent: neighbouring ones overlap.
const INDEPENDENT: f64 = 0.7;
/// Smallest signal to noise at which offset and angle are fitted.
pub(super) const REFINED_FROM: f64 = 3.5;

/// Factor within which the noise of a plane agrees with the scatter of the sky.
pub(super) const AGREEMENT: f64 = 1.5;

/// Returns the error of the amplitude by the background: that of control fits or, without these, of the pixels, and at
/// least that of the noise which a plane states, if it agrees. `noise` is that of a pixel of the sky, and its ratio to
/// the scatter of the sky.
pub(super) fn background_sigma(
    controls: Option<f64>,
    pixel_sigma: f64,
    noise: Option<(f64, f64)>,
    (fits, blocks): (&[BlockFit], &Blocks),
) -> f64 {
    let weight: f64 = fits.iter().map(|fit| fit.weight).sum();
    let measured = controls.map_or(pixel_sigma, |sigma| sigma / weight.sqrt());
    match noise {
        Some((sigma, ratio)) if pixel_sigma.is_finite() && (controls.is_none() || ratio <= AGREEMENT) => {
            // σ² = σ_pixel² Σ w² m² / (Σ w m²)² with the weights w of the blocks
            let squares: f64 = fits.iter().zip(&blocks.weights).map(|(fit, weight)| fit.weight * weight).sum();
            measured.max(sigma * squares.sqrt() / weight)
        }
        _ => measured,
    }
}

/// Returns the scatter of fits of the same template at distances on both sides of the streak, pixels of the minor axis,
/// multiplied by the square root of their weights; `None` if there is no space for enough of them.
///
/// These fits contain all noise of the background: that of the pixels, correlated or not, of faint stars, of masks and
/// of the fitted background. No other term for the background is added to the error. Stars that would not be masked
/// under the streak, because they are fainter than the error of its model, are not masked beside it either. This mask
/// is approximate, because it compares the largest residual near a pixel with the threshold at this pixel.
pub(super) fn controls(
    band: &Band,
    rest: &[f32],
    stars: &StarMask,
    template: &[f32],
    blocks: &Blocks,
    weight: f64,
    distances: impl Iterator<Item = isize>,
) -> Option<f64> {
    let shifts = distances.flat_map(|distance| [distance, -distance]);
    let levels = stars.levels(band);
    let is_used =
        |column: usize, at: usize, light: f32| !stars.mask[at] || levels[at] <= stars.threshold(column, light);
    let scaled: Vec<f64> = shifts
        .filter_map(|shift| combined(&fit_blocks_where(band, rest, is_used, template, shift, blocks)))
        .filter(|amplitude| amplitude.weight >= LEAST_CONTROL_WEIGHT * weight)
        .map(|amplitude| amplitude.value * amplitude.weight.sqrt())
        .collect();
    if scaled.len() < LEAST_CONTROLS {
        return None;
    }
    let (middle, sigma) = median_and_sigma(&scaled);
    let kept: Vec<f64> = scaled.into_iter().filter(|value| (value - middle).abs() <= CONTROL_CLIP * sigma).collect();
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    let variance = kept.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (kept.len() as f64 - 1.0);
    // Half width of 68.27 % of Student's distribution, to first order in 1 / degrees of freedom.
    let student = 1.0 + 0.5 / (INDEPENDENT * kept.len() as f64);
    (variance > 0.0).then(|| student * variance.sqrt())
}

/// Returns the factor by which a fitted flux is multiplied because offset, tilt, and a number of parameters `along` the
/// streak (the delay if an end of the streak is in the image, or fitted ends) are fitted to the same pixels. Each of
/// these parameters follows the noise to a position of more light, which increases the flux by the fraction 1 / (2 S²)
/// at a signal to noise S. For two parameters this is the bias 1 / S² of Portillo, Speagle & Finkbeiner (2020, AJ 159,
/// 165). The factor is 1 below the signal to noise from which the parameters are fitted.
pub(super) fn without_fit_bias(signal_to_noise: f64, along: usize) -> f64 {
    let parameters = 2.0 + along as f64;
    if signal_to_noise < REFINED_FROM { 1.0 } else { 1.0 - 0.5 * parameters / (signal_to_noise * signal_to_noise) }
}

/// Returns the error of the offset from the pixels, with the tilt as another parameter: σ² = σ_pixel² [JJ]⁻¹ with J = A
/// ∂m/∂v (1, u), where A is the amplitude, m the template, v the offset and u the distance along the track.
pub(super) fn offset_sigma(
    band: &Band,
    mask: &[bool],
    template: &[f32],
    blocks: &Blocks,
    amplitude: &Amplitude,
) -> f64 {
    let middle = 0.5 * band.len() as f64;
    let [mut jj, mut ju, mut juu] = [0.0; 3];
    for (columns, weight) in blocks.weighted() {
        for at in (columns.start * band.height).max(1)..(columns.end * band.height).min(template.len() - 1) {
            if !mask[at] && band.values[at].is_finite() {
                let u = ((at / band.height) as f64 - middle) / band.cos;
                let square = weight * (f64::from(template[at - 1] - template[at + 1]) / (2.0 * band.cos)).powi(2);
                jj += square;
                ju += square * u;
                juu += square * u * u;
            }
        }
    }
    let variance = amplitude.squares / amplitude.freedom * juu / (jj * juu - ju * ju);
    variance.sqrt() / amplitude.value.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without control fits the noise of a plane counts up to three times the scatter of the pixels, with them up to
    /// 1.5 times.
    #[test]
    fn verif_the_noise_of_a_plane_is_a_lower_limit() {
        let fits = [BlockFit { weight: 2.0, ..BlockFit::default() }, BlockFit { weight: 2.0, ..BlockFit::default() }];
        let mut blocks = Blocks::new(2, 1, 1);
        let of = |controls, ratio: f64, blocks: &Blocks| {
            background_sigma(controls, 1.0, Some((2.0 * ratio, ratio)), (&fits, blocks))
        };
        // σ = 2 r / √4 for equal weights.
        assert_eq!([1.2, 2.5].map(|ratio| of(None, ratio, &blocks)), [1.2, 2.5]);
        assert_eq!([1.2, 2.5].map(|ratio| of(Some(2.0), ratio, &blocks)), [1.2, 1.0]);
        assert_eq!(of(Some(4.0), 1.2, &blocks), 2.0);
        blocks.weights = vec![0.25, 0.25];
        assert_eq!(of(None, 2.5, &blocks), 1.25);
        assert!(background_sigma(None, f64::NAN, Some((1.0, 1.0)), (&fits, &blocks)).is_nan());
    }
}
