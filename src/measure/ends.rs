//! Ends of a streak: the delay of the satellite, fitted ends, and their errors.

use super::band::Band;
use super::fit::{Amplitude, BlockFit, Blocks, combined, fit_blocks};
use super::search::Extent;
use super::streak::{Drawn, Measuring, Shift};
use crate::error::Error;
use crate::images::PixelPosition;
use crate::math::minimum::minimum;
use crate::streaks::{PathNode, StreakPath};

/// Largest change of a given end in sigmas of its error.
const END_SIGMAS: f64 = 3.0;

/// Variance of the position of a step in noise, in units of the variance of a sample divided by the square of the step.
const STEP_VARIANCE: f64 = 26.0;
/// Accuracy of a fitted delay or end in the time in which a satellite moves by one FWHM.
const DELAY_ACCURACY: f64 = 0.01;

/// Returns the values of the pixels of a template; those without a value in the frame have none.
fn without_missing(template: impl Iterator<Item = f32>, band: &Band) -> Vec<f32> {
    template.zip(&band.values).map(|(light, value)| if value.is_nan() { f32::NAN } else { light }).collect()
}

impl Measuring<'_> {
    /// Returns the number of ends of the exposed track that are in the image.
    pub(super) fn ends(&self, shift: &Shift) -> Result<usize, Error> {
        let Some(path) = self.path(shift)? else { return Ok(0) };
        let end_s = self.image.exposure_s;
        // If the prediction does not extend to the ends of the exposure, the path begins or ends elsewhere.
        let nodes = path.nodes();
        let (first, last) = (&nodes[0], &nodes[nodes.len() - 1]);
        let is_end = |is_exposed: bool, node: &PathNode| {
            (is_exposed || self.is_given()) && node.rate > 0.0 && self.image.light_area.contains(node.at)
        };
        Ok(usize::from(is_end(first.time_s <= 1e-9, first)) + usize::from(is_end(last.time_s >= end_s - 1e-9, last)))
    }

    /// Returns the given ends that are in the image and not at its edge, which can be fitted.
    pub(super) fn ends_inside(&self) -> Vec<usize> {
        let Some(ends_s) = self.predicted.ends_s else { return Vec::new() };
        let area = &self.image.light_area;
        let margin = END_SIGMAS * self.predicted.cross_sigma_pix;
        let is_inside = |end: &usize| {
            let at = self.predicted.path.point_at(ends_s[*end]);
            let away = [-margin, margin];
            away.iter().all(|x| away.iter().all(|y| area.contains(PixelPosition { x: at.x + x, y: at.y + y })))
        };
        (0..2).filter(is_inside).collect()
    }

    /// Returns the first and the last time at which a path is on illuminated pixels, or those of its whole exposure.
    pub(super) fn inside(&self, path: &StreakPath) -> [f64; 2] {
        let nodes = path.nodes();
        self.times_inside(path).unwrap_or([nodes[0].time_s, nodes[nodes.len() - 1].time_s])
    }

    /// Returns the first and the last time at which a path is on illuminated pixels; `None` if it never is.
    pub(super) fn times_inside(&self, path: &StreakPath) -> Option<[f64; 2]> {
        const SAMPLES: usize = 2000;
        let nodes = path.nodes();
        let (from_s, to_s) = (nodes[0].time_s, nodes[nodes.len() - 1].time_s);
        let time_s = |sample: usize| from_s + (to_s - from_s) * sample as f64 / SAMPLES as f64;
        let is_inside = |sample: &usize| {
            self.image.light_area.contains(path.point_at(time_s(*sample))) && path.rate_at(time_s(*sample)) > 0.0
        };
        Some([(0..=SAMPLES).find(is_inside)?, (0..=SAMPLES).rev().find(is_inside)?].map(time_s))
    }

    /// Fits the delay, or refines it if `is_fitted`.
    pub(super) fn fit_lateness(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        extent: &Extent,
        is_fitted: bool,
        shift: &mut Shift,
    ) -> Result<(), Error> {
        // The search has steps of half a width or of a block.
        let block_s = blocks.bounds[1] as f64 / band.cos / self.corridor.speed_pix_s;
        let step_s = block_s.max(2.0 * self.profile.fwhm_pix() / self.corridor.speed_pix_s);
        let mut failed = None;
        let mut of = |late_s: f64| match self.squares(band, mask, blocks, &Shift { late_s, ..*shift }) {
            Ok(squares) => squares.unwrap_or(f64::NAN),
            Err(error) => {
                failed = Some(error);
                f64::NAN
            }
        };
        let start = shift.late_s;
        // The sum of squares has a single minimum only within a few widths of the end, so several delays are tried
        // first.
        let steps = if is_fitted { 0..=0 } else { -4..=4 };
        let samples = steps.map(|step| start + f64::from(step) * 0.25 * step_s);
        let best = samples
            .filter(|late_s| late_s.abs() <= extent.late_s + step_s)
            .map(|late_s| (late_s, of(late_s)))
            .filter(|(_, squares)| squares.is_finite())
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(best) = best {
            let tolerance_s = DELAY_ACCURACY * self.profile.fwhm_pix() / self.corridor.speed_pix_s;
            let bounds = [best.0 - 0.25 * step_s, best.0 + 0.25 * step_s];
            shift.late_s = minimum(of, bounds, best, tolerance_s).0;
        }
        failed.map_or(Ok(()), Err)
    }

    /// Returns the error of the delay (one sigma, s).
    ///
    /// An end of a bright streak is a smooth edge: σ² = σ_pixel² / Σ (A ∂m/∂δ)², where ∂m/∂δ is without its part that is
    /// proportional to the template m. That of a faint streak is a step in the noise of the pixels along the track: its
    /// delay has the variance 26 (T / (n S²))² with the signal to noise S in the time T and n ends in the image (Yao 1987,
    /// Ann. Statist. 15, 1321). The accuracy of the fit is added.
    pub(super) fn lateness_sigma(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
        amplitude: &Amplitude,
        noise_ratio: f64,
    ) -> Result<Option<f64>, Error> {
        let width_s = self.profile.fwhm_pix() / self.corridor.speed_pix_s;
        let step_s = 0.25 * width_s;
        let at = |late_s: f64| self.drawn(band, &Shift { late_s, ..*shift });
        let (Some(before), Some(here), Some(after)) =
            (at(shift.late_s - step_s)?, at(shift.late_s)?, at(shift.late_s + step_s)?)
        else {
            return Ok(None);
        };
        let change = after.template.iter().zip(&before.template).map(|(after, before)| after - before);
        let change = without_missing(change, band);
        let Some(change) = combined(&fit_blocks(band, &change, mask, &here.template, 0, blocks)) else {
            return Ok(None);
        };
        let pixel_variance = noise_ratio * noise_ratio * amplitude.squares / amplitude.freedom;
        let smooth = pixel_variance * (2.0 * step_s / amplitude.value).powi(2) / change.squares;
        let [from_s, to_s] = self.inside(&here.path);
        let signal_squared = amplitude.value * amplitude.value * amplitude.weight / pixel_variance;
        let step = STEP_VARIANCE * ((to_s - from_s) / (self.ends(shift)? as f64 * signal_squared)).powi(2);
        let accuracy_s = DELAY_ACCURACY * width_s;
        let sigma_s = (smooth + step + accuracy_s * accuracy_s).sqrt();
        Ok(sigma_s.is_finite().then_some(sigma_s))
    }

    /// Fits one of the given ends along the streak, within its error. The sum of squares includes the given position,
    /// whose error is in units of that of a pixel: ((t - t₀) / σ)² σ_pixel². Where the pixels around the end are
    /// masked, the end stays near that position.
    pub(super) fn fit_end(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        variance: f64,
        end: usize,
        shift: &mut Shift,
    ) -> Result<(), Error> {
        let sigma_s = self.predicted.cross_sigma_pix / self.corridor.speed_pix_s;
        let reach_s = END_SIGMAS * sigma_s;
        let moved = |time_s: f64| {
            let mut moved = *shift;
            moved.ends_s[end] = time_s;
            moved
        };
        let mut failed = None;
        let mut of = |time_s: f64| match self.squares(band, mask, blocks, &moved(time_s)) {
            Ok(squares) => squares.unwrap_or(f64::NAN) + variance * (time_s / sigma_s).powi(2),
            Err(error) => {
                failed = Some(error);
                f64::NAN
            }
        };
        let (step_s, start_s) = (0.75 * sigma_s, shift.ends_s[end]);
        // The sum of squares has a single minimum only within a few widths of the end, so several positions are tried
        // first. Later the end is only refined.
        let steps = if start_s == 0.0 { -4..=4 } else { 0..=0 };
        let best = steps
            .map(|step| start_s + f64::from(step) * step_s)
            .map(|time_s| (time_s, of(time_s)))
            .filter(|(_, squares)| squares.is_finite())
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(best) = best {
            let tolerance_s = DELAY_ACCURACY * self.profile.fwhm_pix() / self.corridor.speed_pix_s;
            let bounds = [(best.0 - step_s).max(-reach_s), (best.0 + step_s).min(reach_s)];
            shift.ends_s[end] = minimum(of, bounds, best, tolerance_s).0;
        }
        failed.map_or(Ok(()), Err)
    }

    /// Returns the factor by which the variance of the light of a streak is larger because its ends are fitted, too:
    /// 1 / (1 - Σ ρ²) with the correlation ρ of the template of unit light and its derivative by the time of each end.
    pub(super) fn ends_inflation(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
        ends: &[usize],
    ) -> Result<f64, Error> {
        let unit = |shift: &Shift| -> Result<Option<Vec<f32>>, Error> {
            let Some(Drawn { path, template }) = self.drawn(band, shift)? else { return Ok(None) };
            let nodes = path.nodes();
            let duration_s = (nodes[nodes.len() - 1].time_s - nodes[0].time_s) as f32;
            Ok(Some(template.into_iter().map(|light| light / duration_s).collect()))
        };
        let step_s = 0.25 * self.profile.fwhm_pix() / self.corridor.speed_pix_s;
        let mut squares = 0.0;
        for end in ends {
            let mut moved = *shift;
            moved.ends_s[*end] += step_s;
            let (Some(same), Some(other)) = (unit(shift)?, unit(&moved)?) else { continue };
            let change = without_missing(other.iter().zip(&same).map(|(other, same)| other - same), band);
            let fits = fit_blocks(band, &change, mask, &same, 0, blocks);
            let sum = |of: fn(&BlockFit) -> f64| fits.iter().map(of).sum::<f64>();
            let norm = sum(|fit| fit.weight) * sum(|fit| fit.squares);
            squares += if norm > 0.0 { sum(|fit| fit.signal).powi(2) / norm } else { 0.0 };
        }
        Ok(1.0 / (1.0 - squares.clamp(0.0, 0.9)))
    }

    /// Returns the path of a streak with fitted ends in the time between the given ends, and the factor by which its
    /// light per second is larger; any other path and 1.
    pub(super) fn within_given_times(&self, path: &StreakPath) -> Result<(StreakPath, f64), Error> {
        let Some([from_s, to_s]) = self.predicted.ends_s else { return Ok((path.clone(), 1.0)) };
        let nodes = path.nodes();
        let (first_s, last_s) = (nodes[0].time_s, nodes[nodes.len() - 1].time_s);
        // Ends beyond the margin of the chip are not part of the path.
        let given = self.predicted.path.nodes();
        let (from_s, to_s) = (from_s.max(given[0].time_s), to_s.min(given[given.len() - 1].time_s));
        let longer = (last_s - first_s) / (to_s - from_s);
        let moved = nodes.iter().map(|node| PathNode { time_s: from_s + (node.time_s - first_s) / longer, ..*node });
        Ok((StreakPath::new(moved.collect())?, longer))
    }
}
