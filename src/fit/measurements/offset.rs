//! Time offset of a satellite along its track (positive is early), fitted to the recorded ranges of the track.

use crate::frames::{Gcrs, Position};
use crate::math::minimum::minimum;
use crate::orbit::Propagator;

use super::ephemeris::{Ephemeris, Moment, SiteAxes};
use super::record::Record;

/// Recorded range, with the position of the observer.
pub(super) struct Ranged {
    pub epoch: hifitime::Epoch,
    pub moment: Moment,
    pub observer: Position<Gcrs>,
    pub range_km: f64,
    pub phase_rad: Option<f64>,
}

/// Fitted time offset and the differences that remain.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Offset {
    pub offset_s: f64,
    pub range_rms_km: f64,
}

/// Largest number of points of a track that are compared; more points do not improve the fit.
const POINTS: usize = 12;
/// Grid step of the offset, s. It is short compared with the time scale on which the range varies nonlinearly: distance
/// divided by speed, half a minute or more.
const STEP_S: f64 = 5.0;
/// Tolerance of the offset, s; it corresponds to 8 m along the track.
const TOLERANCE_S: f64 = 1e-3;

impl Ranged {
    /// Returns evenly spaced rows of a track, including the first and the last.
    pub(super) fn thinned<'r>(track: &[&'r Record]) -> impl Iterator<Item = &'r Record> {
        let last = track.len().saturating_sub(1);
        let steps = POINTS.min(track.len());
        let picked: Vec<_> =
            (0..steps).filter_map(|step| track.get(step * last / (steps - 1).max(1)).copied()).collect();
        picked.into_iter()
    }

    /// Creates the recorded range of a row with the position of its observer; `None` without time, site or range.
    pub(super) fn from_record(record: &Record, ephemeris: &Ephemeris, sites: &[SiteAxes]) -> Option<Self> {
        let (epoch, (range_km, phase_rad)) = (record.epoch?, record.sighting.distance_and_phase());
        let moment = ephemeris.at(epoch)?;
        let (observer, _) = sites.get(record.site? as usize)?.at(&moment);
        Some(Self { epoch, moment, observer, range_km: range_km?, phase_rad })
    }
}

/// Returns the geocentric position predicted for `offset_s` after the record.
pub(super) fn shifted(propagator: &Propagator, point: &Ranged, offset_s: f64) -> Option<Position<Gcrs>> {
    let minutes = propagator.minutes_since_epoch(point.epoch) + offset_s / 60.0;
    propagator.state_at_minutes(minutes, &point.moment.orientation.teme_to_gcrs).ok().map(|state| state.position)
}

/// Returns the root mean square of the range differences, km; infinite if there is no position.
fn range_rms_km(propagator: &Propagator, points: &[Ranged], offset_s: f64) -> f64 {
    let mut sum = 0.0;
    for point in points {
        let Some(satellite) = shifted(propagator, point, offset_s) else { return f64::INFINITY };
        let difference = (satellite - point.observer).norm_km() - point.range_km;
        sum += difference * difference;
    }
    (sum / points.len() as f64).sqrt()
}

/// Returns the offset within ± `limit_s` with the smallest range differences: the best node of a grid of 5 s, refined.
/// `None` without points or positions.
pub(super) fn fitted_offset_s(propagator: &Propagator, points: &[Ranged], limit_s: f64) -> Option<Offset> {
    if points.is_empty() {
        return None;
    }
    let rms = |offset_s: f64| range_rms_km(propagator, points, offset_s);
    let steps = (limit_s / STEP_S).ceil().max(1.0);
    let step_s = limit_s / steps;
    let grid = (-(steps as i32)..=steps as i32).map(|step| f64::from(step) * step_s);
    let (best_s, best_km) = grid.map(|offset| (offset, rms(offset))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    if !best_km.is_finite() {
        return None;
    }
    let ends_s = [(best_s - step_s).max(-limit_s), (best_s + step_s).min(limit_s)];
    let (offset_s, range_rms_km) = minimum(rms, ends_s, (best_s, best_km), 0.5 * TOLERANCE_S);
    Some(Offset { offset_s, range_rms_km })
}
