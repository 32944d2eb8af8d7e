//! First position of a narrow streak, less than [`NARROW_PIX`] wide: the best one of a grid that is finer than the
//! steps of the search.

use super::band::Band;
use super::fit::{Blocks, combined, fit_blocks};
use super::search::Extent;
use super::stars::mask_stars;
use super::streak::{Measuring, Shift};
use crate::error::Error;

/// Width of a streak, pixels, below which the steps of the search are too coarse.
const NARROW_PIX: f64 = 1.6;
/// Half width of the grid at the middle and at the ends of the streak, pixels.
const GRID_PIX: f64 = 1.0;
/// Steps of the grid, FWHM.
const GRID_WIDTHS: f64 = 0.4;
/// Smallest width of the light of a streak, pixels.
const LEAST_WIDTH_PIX: f64 = 0.8;

impl Measuring<'_> {
    /// Returns true for streaks that may be between two steps of the search.
    pub(super) fn is_narrow(&self) -> bool {
        self.profile.fwhm_pix() < NARROW_PIX
    }

    /// Returns, for a narrow streak, the shift with the most significant light of a fine grid of offsets and tilts
    /// around `shift`, with stars masked; otherwise `shift`.
    pub(super) fn best_if_narrow(
        &self,
        band: &Band,
        blocks: &Blocks,
        extent: &Extent,
        shift: &Shift,
    ) -> Result<Shift, Error> {
        if !self.is_narrow() {
            return Ok(*shift);
        }
        let Some(drawn) = self.drawn(band, shift)? else { return Ok(*shift) };
        let fwhm = self.profile.fwhm_pix();
        let stars = mask_stars(band, &drawn.template, blocks, fwhm.max(1.0), true);
        let half_length_pix = 0.5 * band.len() as f64 / band.cos;
        let count = (GRID_PIX / (GRID_WIDTHS * fwhm.max(LEAST_WIDTH_PIX))).ceil() as i32;
        let pix = |step: i32| f64::from(step) * GRID_PIX / f64::from(count);
        let (mut best, mut most) = (*shift, 0.0);
        for (across, turn) in (-count..=count).flat_map(|across| (-count..=count).map(move |turn| (across, turn))) {
            let offset_pix = shift.offset_pix + pix(across);
            let tilt_rad = shift.tilt_rad + pix(turn) / half_length_pix;
            let moved = Shift { offset_pix, tilt_rad, ..*shift };
            // Out of the corridor the light is that of a neighbour or a star.
            if offset_pix.abs() > extent.across_pix {
                continue;
            }
            let Some(drawn) = self.drawn(band, &moved)? else { continue };
            let fits = fit_blocks(band, &band.values, &stars.mask, &drawn.template, 0, blocks);
            // A √(Σ m'²)
            let light = combined(&fits).map_or(0.0, |amplitude| amplitude.value * amplitude.weight.sqrt());
            if light > most {
                (best, most) = (moved, light);
            }
        }
        Ok(best)
    }
}
