//! Errors of the light of a streak other than the noise of the sky: the size of the satellite, an unknown seeing, and
//! photons.

use super::band::Band;
use super::fit::{Blocks, combined, fit_blocks};
use super::measurement::{MeasureOptions, PredictedStreak};
use super::streak::{Measuring, Shift, profile_of};
use crate::error::Error;
use crate::streaks::{Optics, RadialProfile};

/// Factor (one sigma) between the seeing and the assumed one, if it is neither given nor fitted.
const UNKNOWN_SEEING: f64 = 2.0;

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
            amplitudes.extend(self.amplitude_with(other, band, mask, blocks, shift)?);
        }
        self.profile = given;
        Ok(half_difference(&amplitudes))
    }

    /// Returns the error (one sigma) of the amplitude of a streak whose seeing is neither given nor fitted: half of the
    /// difference of the amplitudes with twice and half of the assumed seeing.
    pub(super) fn unknown_seeing_sigma(
        &mut self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<f64, Error> {
        let (given, optics) = (self.profile.clone(), self.optics);
        let mut amplitudes = Vec::new();
        for factor in [1.0 / UNKNOWN_SEEING, UNKNOWN_SEEING] {
            let other = Optics { seeing_arcsec: factor * optics.seeing_arcsec, ..optics };
            // A seeing that cannot be drawn is left out.
            let Ok(profile) = profile_of(self.image, self.predicted, &other) else { continue };
            amplitudes.extend(self.amplitude_with(profile, band, mask, blocks, shift)?);
        }
        self.profile = given;
        Ok(half_difference(&amplitudes))
    }

    /// Returns the amplitude with another profile, which stays set; `None` if nothing can be fitted.
    fn amplitude_with(
        &mut self,
        profile: RadialProfile,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<Option<f64>, Error> {
        self.profile = profile;
        let Some(drawn) = self.drawn(band, shift)? else { return Ok(None) };
        let fits = fit_blocks(band, &band.values, mask, &drawn.template, 0, blocks);
        Ok(combined(&fits).map(|amplitude| amplitude.value))
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

/// Returns half of the difference of two amplitudes, and 0 if one is missing.
fn half_difference(amplitudes: &[f64]) -> f64 {
    match amplitudes {
        [first, other] => 0.5 * (other - first).abs(),
        _ => 0.0,
    }
}
