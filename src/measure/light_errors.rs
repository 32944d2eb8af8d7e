//! Errors of the light of a streak other than the noise of the sky: the size of the satellite, and photons.

use super::band::Band;
use super::fit::{Blocks, combined, fit_blocks};
use super::measurement::{MeasureOptions, PredictedStreak};
use super::streak::{Measuring, Shift};
use crate::error::Error;
use crate::streaks::Optics;

impl Measuring<'_> {
    /// Returns the error (one sigma) of the amplitude that the error of the satellite's size causes: half of the
    /// difference of the amplitudes with the size one sigma larger and one sigma smaller. If the width is fitted, it
    /// stays the same: a smaller size is compensated by a wider seeing.
    pub(super) fn size_sigma(
        &mut self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
        options: &MeasureOptions,
    ) -> Result<f64, Error> {
        let PredictedStreak { range_km, radius_m, radius_sigma_m, .. } = *self.predicted;
        if radius_sigma_m <= 0.0 {
            return Ok(0.0);
        }
        let (given, width_pix) = (self.profile.clone(), self.profile.fwhm_pix());
        let (scale_arcsec, aspect) = (self.image.pixel_scale_arcsec, self.image.pixel_aspect);
        let mut amplitudes = Vec::new();
        for radius_m in [(radius_m - radius_sigma_m).max(0.0), radius_m + radius_sigma_m] {
            let mut optics = self.optics;
            let profile = |optics: &Optics| optics.profile(range_km, radius_m, scale_arcsec, aspect);
            let Ok(mut other) = profile(&optics) else { continue };
            if options.fit_width {
                // The squares of the widths of seeing, defocus and size add up approximately, so two steps suffice.
                for _ in 0..2 {
                    let squares = optics.seeing_arcsec.powi(2)
                        + (width_pix.powi(2) - other.fwhm_pix().powi(2)) * scale_arcsec * scale_arcsec;
                    optics.seeing_arcsec = squares.max(0.04 * optics.seeing_arcsec.powi(2)).sqrt();
                    let Ok(next) = profile(&optics) else { break };
                    other = next;
                }
            }
            self.profile = other;
            if let Some(drawn) = self.drawn(band, shift)? {
                let fits = fit_blocks(band, &band.values, mask, &drawn.template, 0, blocks);
                amplitudes.extend(combined(&fits).map(|amplitude| amplitude.value));
            }
        }
        self.profile = given;
        Ok(match amplitudes[..] {
            [smaller, larger] => 0.5 * (larger - smaller).abs(),
            _ => 0.0,
        })
    }

    /// Returns the variance of the amplitude due to the photons of the streak: Σ w² m² A m / g / (Σ w m²)² with the
    /// weights w of the blocks. `None` without gain.
    pub(super) fn photon_variance(
        &self,
        band: &Band,
        mask: &[bool],
        template: &[f32],
        blocks: &Blocks,
        amplitude: f64,
    ) -> Option<f64> {
        let gain = self.image.electrons_per_unit?;
        let (mut squares, mut cubes) = (0.0, 0.0);
        for (columns, weight) in blocks.weighted() {
            for at in columns.start * band.height..columns.end * band.height {
                if !mask[at] && band.values[at].is_finite() {
                    let light = f64::from(template[at]);
                    squares += weight * light * light;
                    cubes += weight * weight * light * light * light;
                }
            }
        }
        Some(if squares > 0.0 { amplitude.max(0.0) * cubes / (gain * squares * squares) } else { 0.0 })
    }
}
