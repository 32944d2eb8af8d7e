//! Measured magnitudes as residuals from brightness models, by satellite and pass.

use std::collections::BTreeMap;

use hifitime::Epoch;

use crate::elements::{Generation, NoradId};
use crate::frames::seconds_between;
use crate::math::quantile::median;
use crate::passes::LONGEST_PASS_GAP_S;

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
#[non_exhaustive]
pub struct Pass {
    norad_id: NoradId,
    kind: Generation,
    points: Vec<PassPoint>,
    median_mag: f64,
    scatter_mag: Option<f64>,
}

impl Pass {
    /// Creates a pass of a satellite of this kind; `None` without points.
    pub fn new(norad_id: NoradId, kind: Generation, mut points: Vec<PassPoint>) -> Option<Self> {
        if points.is_empty() {
            return None;
        }
        points.sort_by_key(|point| point.epoch);
        let median_mag = median(points.iter().map(|point| point.residual_mag).collect());
        let sizes = points.iter().map(|point| (point.residual_mag - median_mag).abs()).collect();
        let scatter_mag = (points.len() >= LEAST_FOR_SCATTER).then(|| SIGMA_OF_MAD * median(sizes));
        Some(Self { norad_id, kind, points, median_mag, scatter_mag })
    }

    /// Returns the NORAD catalogue number.
    pub fn norad_id(&self) -> NoradId {
        self.norad_id
    }

    /// Returns the kind of satellite.
    pub fn kind(&self) -> Generation {
        self.kind
    }

    /// Returns the measurements in order of time, at least one.
    pub fn points(&self) -> &[PassPoint] {
        &self.points
    }

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
        self.median_mag
    }

    /// Returns the robust standard deviation of the residuals from their median, mag; `None` with fewer than five.
    pub fn scatter_mag(&self) -> Option<f64> {
        self.scatter_mag
    }
}

/// Returns the passes of measurements of satellites, by kind, satellite and time.
///
/// Measurements of one satellite belong to one pass if less than 20 minutes separate them.
pub fn group_passes(points: impl IntoIterator<Item = (NoradId, Generation, PassPoint)>) -> Vec<Pass> {
    let mut satellites: BTreeMap<(Generation, NoradId), Vec<PassPoint>> = BTreeMap::new();
    for (norad_id, kind, point) in points {
        satellites.entry((kind, norad_id)).or_default().push(point);
    }
    let mut passes = Vec::new();
    for ((kind, norad_id), mut points) in satellites {
        points.sort_by_key(|point| point.epoch);
        let same_pass = |a: &PassPoint, b: &PassPoint| seconds_between(a.epoch, b.epoch) < LONGEST_PASS_GAP_S;
        passes.extend(points.chunk_by(same_pass).filter_map(|points| Pass::new(norad_id, kind, points.to_vec())));
    }
    passes
}
