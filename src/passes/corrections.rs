//! Skies whose magnitudes are corrected by measurements of the same pass.

use std::collections::BTreeMap;
use std::sync::Arc;

use hifitime::Epoch;

use super::measured::{LONGEST_PASS_GAP_S, MeasuredMagnitude, MeasuredPass, MeasuredPasses};
use super::sky::Sky;
use crate::elements::{NoradId, Origin};
use crate::error::Error;
use crate::frames::seconds_between;
use crate::photometry::{PassResidual, PassUpdate, PhotometryOptions};

/// Largest number of measurements of a pass that are used. Successive measurements at 10 Hz differ little.
const MOST_OF_A_PASS: usize = 40;

impl Sky {
    /// Returns the sky with measured magnitudes, and the number of those that are not used: of satellites that are not
    /// in the sky, or without a predicted magnitude at that time. Earlier measurements are replaced.
    ///
    /// Predicted magnitudes of a measured satellite within 20 minutes of a measurement are corrected by the rule of
    /// [`PassUpdate`]. The magnitudes must be in the band and system of `photometry`, and so must the predictions.
    ///
    /// # Errors
    /// A time is outside the years of the Sun's ephemeris, or the elements of a telescope in orbit give no position.
    pub(crate) fn with_measured(
        mut self,
        measured: &[MeasuredMagnitude],
        photometry: &PhotometryOptions,
    ) -> Result<(Self, usize), Error> {
        self.measured = Arc::default();
        let mut by_satellite = BTreeMap::<NoradId, Vec<&MeasuredMagnitude>>::new();
        measured.iter().for_each(|measurement| by_satellite.entry(measurement.norad_id).or_default().push(measurement));
        let (mut passes, mut not_used) = (BTreeMap::new(), 0);
        for (norad_id, mut of_satellite) in by_satellite {
            // The catalogue number of a simulated satellite may be that of a real one.
            let index =
                self.elements().iter().position(|set| set.norad_id == norad_id && set.origin != Origin::Synthetic);
            let Some(index) = index else {
                not_used += of_satellite.len();
                continue;
            };
            of_satellite.sort_by_key(|measurement| measurement.epoch);
            let mut of_index = Vec::new();
            for pass in of_satellite.chunk_by(|a, b| seconds_between(a.epoch, b.epoch) <= LONGEST_PASS_GAP_S) {
                let step = pass.len().div_ceil(MOST_OF_A_PASS);
                let used: Vec<&MeasuredMagnitude> = pass.iter().step_by(step).copied().collect();
                let times: Vec<Epoch> = used.iter().map(|measurement| measurement.epoch).collect();
                let (points, _) = self.ephemeris(&[index], &times, Some(photometry))?;
                let residual = |point: &super::ephemeris::EphemerisPoint| {
                    let (light, measurement) = (point.point.brightness.as_ref()?, used[point.time_index]);
                    let more_mag2 = (light.sigma_mag.powi(2) - light.scatter_mag.powi(2)).max(0.0);
                    Some(PassResidual {
                        geometry: point.point.geometry,
                        residual_mag: measurement.magnitude.0 - light.magnitude.0,
                        scatter_mag: light.scatter_mag,
                        error_mag: more_mag2.sqrt().hypot(measurement.sigma_mag),
                    })
                };
                match PassUpdate::new(points.iter().filter_map(residual).collect()) {
                    Some(update) => {
                        let (first, last) = (pass[0].epoch, pass[pass.len() - 1].epoch);
                        of_index.push(MeasuredPass { first, last, update });
                    }
                    None => not_used += pass.len(),
                }
            }
            if !of_index.is_empty() {
                passes.insert(index, of_index);
            }
        }
        self.measured = Arc::new(MeasuredPasses::new(passes));
        Ok((self, not_used))
    }
}
