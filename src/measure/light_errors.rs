//! Errors of the light of a streak other than the noise of the sky: the size of the satellite, an unknown width, and
//! photons.

use super::band::Band;
use super::fit::{Blocks, combined, fit_blocks};
use super::measurement::{MeasureOptions, PredictedStreak};
use super::streak::{Measuring, Shift, profile_of};
use crate::error::Error;
use crate::streaks::{Optics, RadialProfile};

/// Factor (one sigma) between the seeing and the assumed one, if it is neither given nor fitted.
const UNKNOWN_SEEING: f64 = 2.0;
/// Distance, km, and radius, m, of a satellite in low orbit: without a distance, the width of a streak whose seeing is
/// known differs from the assumed one by as much as that of such a satellite.
const NEAR_KM: f64 = 550.0;
const NEAR_RADIUS_M: f64 = 1.0;

impl Measuring<'_> {
    /// Returns the relative error (one sigma) of the light that the error of the satellite's size causes. If
    /// the width is fitted, it stays the same: a smaller size is compensated by a wider seeing.
    pub(super) fn size_share(
        &self,
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
        let width_pix = self.profile.fwhm_pix();
        let (scale_arcsec, aspect) = (self.image.pixel_scale_arcsec, self.image.pixel_aspect);
        let mut profiles = Vec::new();
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
            profiles.push(other);
        }
        Ok(error_and_factor(&self.responses(&profiles, band, mask, blocks, shift)?).0)
    }

    /// Returns, for a streak whose width is unknown and not fitted, the relative error (one sigma) of its light,
    /// and the factor by which it may be brighter. If the seeing is unknown, the streak may be twice or half as
    /// wide; if only the distance is, as wide as that of a near satellite.
    pub(super) fn unknown_width_share(
        &self,
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
        options: &MeasureOptions,
    ) -> Result<(f64, f64), Error> {
        let profiles: Vec<RadialProfile> =
            if options.is_seeing_known && self.predicted.range_km < PredictedStreak::FAR_KM {
                Vec::new()
            } else if options.is_seeing_known {
                let (scale_arcsec, aspect) = (self.image.pixel_scale_arcsec, self.image.pixel_aspect);
                self.optics.profile(NEAR_KM, NEAR_RADIUS_M, scale_arcsec, aspect).into_iter().collect()
            } else {
                let with = |factor: f64| Optics { seeing_arcsec: factor * self.optics.seeing_arcsec, ..self.optics };
                // A seeing that cannot be drawn is left out.
                let factors = [1.0 / UNKNOWN_SEEING, UNKNOWN_SEEING].into_iter();
                factors.filter_map(|factor| profile_of(self.image, self.predicted, &with(factor)).ok()).collect()
            };
        Ok(error_and_factor(&self.responses(&profiles, band, mask, blocks, shift)?))
    }

    /// Returns the light that is measured with the assumed profile, relative to the true one, of streaks with other
    /// profiles: the amplitude ρ of the assumed streak in the light of the other one.
    pub(super) fn responses(
        &self,
        profiles: &[RadialProfile],
        band: &Band,
        mask: &[bool],
        blocks: &Blocks,
        shift: &Shift,
    ) -> Result<Vec<f64>, Error> {
        let Some(assumed) = self.drawn(band, shift)? else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        for profile in profiles {
            let Some(mut light) = self.drawn_with(profile, band, shift)?.map(|drawn| drawn.template) else { continue };
            // Pixels without a value in the frame have no light.
            light
                .iter_mut()
                .zip(&band.values)
                .filter(|(_, value)| value.is_nan())
                .for_each(|(light, _)| *light = f32::NAN);
            let measured = combined(&fit_blocks(band, &light, mask, &assumed.template, 0, blocks));
            all.extend(measured.map(|measured| measured.value).filter(|response| *response > 0.0));
        }
        Ok(all)
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

/// Returns the relative error of the light, the mean of |1 - ρ|, and the factor by which a streak may be brighter, the
/// largest 1/ρ; 0 and 1 without values.
pub(super) fn error_and_factor(responses: &[f64]) -> (f64, f64) {
    let sum: f64 = responses.iter().map(|response| (1.0 - response).abs()).sum();
    (sum / (responses.len() as f64).max(1.0), responses.iter().copied().fold(1.0, f64::min).recip())
}
