//! Passes of photometry as `fit` reads it.

use super::pass::{Pass, PassPoint, group_passes};
use crate::elements::{Generation, NoradId};
use crate::fit::measurements::Measurements;
use crate::passes::ModelChoice;
use crate::photometry::Earthshine;

/// Numbers of measurements that were left out.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOutPoints {
    /// Without the number of a satellite.
    pub no_satellite: usize,
    /// Without a time.
    pub no_time: usize,
    /// Of a satellite whose kind is unknown or has no brightness model.
    pub no_model: usize,
    /// Without a sunlit surface in the model, or with a residual that is not finite.
    pub dark: usize,
}

impl LeftOutPoints {
    /// Returns each reason with its number, without those that do not occur.
    pub fn reasons(&self) -> impl Iterator<Item = (&'static str, usize)> {
        let all = [
            ("without a satellite number", self.no_satellite),
            ("without a time", self.no_time),
            ("of satellites without a kind or model", self.no_model),
            ("without a sunlit surface in the model", self.dark),
        ];
        all.into_iter().filter(|(_, count)| *count > 0)
    }
}

/// Returns the passes of measured magnitudes, by kind, satellite and time, and the numbers of measurements left out.
///
/// `kind_of` returns the kind of a satellite. Magnitudes are compared in the band of the measurements, which is taken
/// as that of the model.
pub fn passes_of(
    measurements: &Measurements,
    kind_of: impl Fn(NoradId) -> Option<Generation>,
    models: &ModelChoice,
    earthshine: Earthshine,
) -> (Vec<Pass>, LeftOutPoints) {
    let mut left_out = LeftOutPoints::default();
    let mut points = Vec::new();
    for point in &measurements.points {
        let Some(norad_id) = point.norad_id else {
            left_out.no_satellite += 1;
            continue;
        };
        let Some(epoch) = point.epoch else {
            left_out.no_time += 1;
            continue;
        };
        let Some((kind, model)) = kind_of(norad_id).and_then(|kind| Some((kind, models.of_kind(kind)?))) else {
            left_out.no_model += 1;
            continue;
        };
        let predicted = model.standard_magnitude_with(&point.geometry, earthshine);
        // The Earth's shadow dims the satellite: m = m_model - 2.5 log₁₀ f
        let residual_mag =
            predicted.map(|predicted| point.magnitude.0 - (predicted.0 - 2.5 * point.lit_fraction.log10()));
        let Some(residual_mag) = residual_mag.filter(|residual| residual.is_finite()) else {
            left_out.dark += 1;
            continue;
        };
        points.push((norad_id, kind, PassPoint { epoch, residual_mag, sigma_mag: point.sigma_mag }));
    }
    (group_passes(points), left_out)
}
