//! Measured magnitudes as residuals from brightness models, by satellite and pass.

use std::collections::BTreeMap;

use hifitime::Epoch;

use crate::elements::{Generation, NoradId};
use crate::fit::measurements::Measurements;
use crate::frames::seconds_between;
use crate::math::quantile::median;
use crate::passes::ModelChoice;
use crate::photometry::Earthshine;

/// Longest interval between two measurements of one pass, seconds. A pass of a low satellite takes some ten minutes, and
/// the next one is an orbit later.
const LONGEST_GAP_S: f64 = 1200.0;
/// Ratio of the standard deviation of a normal distribution to its median absolute deviation.
const SIGMA_OF_MAD: f64 = 1.4826;
/// Smallest number of measurements from which the scatter within a pass is computed.
const LEAST_FOR_SCATTER: usize = 5;

/// One measurement of a pass.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PassPoint {
    /// Time.
    pub epoch: Epoch,
    /// Observed less predicted magnitude; positive is fainter than the model.
    pub residual_mag: f64,
    /// Stated error (one sigma) of the measurement, mag.
    pub sigma_mag: Option<f64>,
}

/// Measurements of one pass of a satellite.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Kind of satellite.
    pub kind: Generation,
    /// Measurements in order of time, at least one.
    pub points: Vec<PassPoint>,
}

impl Pass {
    /// Returns the time of the first measurement.
    pub fn first(&self) -> Epoch {
        self.points[0].epoch
    }

    /// Returns the time of the last measurement.
    pub fn last(&self) -> Epoch {
        self.points[self.points.len() - 1].epoch
    }

    /// Returns the median of the residuals, mag.
    pub fn median_mag(&self) -> f64 {
        median(self.points.iter().map(|point| point.residual_mag).collect())
    }

    /// Returns the robust standard deviation of the residuals from their median, mag; `None` with fewer than five.
    pub fn scatter_mag(&self) -> Option<f64> {
        let centre = self.median_mag();
        let sizes = self.points.iter().map(|point| (point.residual_mag - centre).abs()).collect();
        (self.points.len() >= LEAST_FOR_SCATTER).then(|| SIGMA_OF_MAD * median(sizes))
    }
}

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
/// `kind_of` returns the kind of a satellite. Measurements of one satellite belong to one pass if less than 20 minutes
/// separate them. Magnitudes are compared in the band of the measurements, which is taken as that of the model.
pub fn passes_of(
    measurements: &Measurements,
    kind_of: impl Fn(NoradId) -> Option<Generation>,
    models: &ModelChoice,
    earthshine: Earthshine,
) -> (Vec<Pass>, LeftOutPoints) {
    let mut left_out = LeftOutPoints::default();
    let mut satellites: BTreeMap<(Generation, NoradId), Vec<PassPoint>> = BTreeMap::new();
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
        let point = PassPoint { epoch, residual_mag, sigma_mag: point.sigma_mag };
        satellites.entry((kind, norad_id)).or_default().push(point);
    }
    let mut passes = Vec::new();
    for ((kind, norad_id), mut points) in satellites {
        points.sort_by_key(|point| point.epoch);
        let same_pass = |a: &PassPoint, b: &PassPoint| seconds_between(a.epoch, b.epoch) < LONGEST_GAP_S;
        passes.extend(points.chunk_by(same_pass).map(|points| Pass { norad_id, kind, points: points.to_vec() }));
    }
    (passes, left_out)
}
