//! Identification of tracks: recorded ranges and phase angles are compared with those of every satellite of a
//! catalogue.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::constants::DAY_S;
use crate::elements::{ElementSet, History, NoradId};
use crate::frames::EopTable;
use crate::geometry::{Site, ViewingGeometry};
use crate::orbit::Propagator;
use crate::output::{Column, Kind, Table, Value};

use super::ephemeris::{Ephemeris, SiteAxes, age_days};
use super::offset::{Ranged, fitted_offset_s, shifted};
use super::record::{Record, Records};

/// Limits within which the best candidate is accepted.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AcceptanceLimits {
    /// Largest root mean square of the range differences, km.
    pub max_range_rms_km: f64,
    /// Largest root mean square of the differences in phase angle, radians; applied if phase angles are recorded.
    pub max_phase_rms_rad: f64,
    /// Smallest difference between the scores (χ²) of the second best and the best candidate.
    pub least_lead: f64,
}

impl Default for AcceptanceLimits {
    /// Returns 10 km, 3° and a difference of 9 (three sigma).
    fn default() -> Self {
        Self { max_range_rms_km: 10.0, max_phase_rms_rad: 3_f64.to_radians(), least_lead: 9.0 }
    }
}

/// Best candidates for one track.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackIdentification {
    /// Name of the track.
    pub track: String,
    /// Best candidate; `None` if no satellite came near the track.
    pub best: Option<TrackCandidate>,
    /// Second best candidate.
    pub next: Option<TrackCandidate>,
    /// True if the best candidate satisfies the [`AcceptanceLimits`].
    pub is_sure: bool,
}

/// Compares each track of the records with the whole catalogue. Results are in the order of the tracks.
pub fn identify_tracks(
    records: &Records,
    history: &History,
    eop: &EopTable,
    options: &AssociationOptions,
    limits: &AcceptanceLimits,
) -> Vec<TrackIdentification> {
    let tracks: Vec<(&String, Vec<_>)> = records.groups.iter().zip(records.by_group()).collect();
    let identify_track = |(track, rows): &(&String, Vec<_>)| {
        let mut candidates = associate(rows, &records.sites, history, eop, options).into_iter();
        let (best, next) = (candidates.next(), candidates.next());
        let is_near = |best: &TrackCandidate| {
            best.range_rms_km <= limits.max_range_rms_km
                && best.phase_rms_rad.is_none_or(|phase| phase <= limits.max_phase_rms_rad)
                && next.is_none_or(|next| next.score - best.score >= limits.least_lead)
        };
        TrackIdentification { track: (*track).clone(), best, next, is_sure: best.as_ref().is_some_and(is_near) }
    };
    tracks.par_iter().map(identify_track).collect()
}

const COLUMNS: [Column; 9] = [
    Column::new("track", Kind::Text, "Name of the track."),
    Column::new("norad", Kind::Integer, "NORAD number of the accepted satellite; empty if none is accepted."),
    Column::new("best", Kind::Integer, "NORAD number of the best candidate, accepted or not."),
    Column::real("range_rms_km", "km", 3, "Root mean square of the differences of range after the fit of the delay."),
    Column::real("phase_rms_deg", "deg", 3, "Root mean square of the differences of phase angle."),
    Column::real("offset_s", "s", 2, "Time offset along the track; positive if the satellite is early."),
    Column::real("element_age_days", "d", 2, "Age of the element set at the track."),
    Column::new("next", Kind::Integer, "NORAD number of the second best candidate."),
    Column::real("lead", "", 2, "Difference between the scores (chi square) of the second and the first candidate."),
];

/// Returns a table with one row per track, which [`Placement::identified`](super::Placement::identified) can use.
pub fn identification_table(tracks: &[TrackIdentification]) -> Table {
    let number = |candidate: Option<&TrackCandidate>| {
        candidate.map_or(Value::Null, |candidate| Value::Integer(i64::from(candidate.norad_id.0)))
    };
    let row = |track: &TrackIdentification| {
        let (best, next) = (track.best.as_ref(), track.next.as_ref());
        vec![
            track.track.as_str().into(),
            number(best.filter(|_| track.is_sure)),
            number(best),
            best.map(|best| best.range_rms_km).into(),
            best.and_then(|best| best.phase_rms_rad).map(f64::to_degrees).into(),
            best.map(|best| best.offset_s).into(),
            best.map(|best| best.element_age_days).into(),
            number(next),
            best.zip(next).map(|(best, next)| next.score - best.score).into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: tracks.iter().map(row).collect() }
}

/// Options for the comparison of a track with a catalogue.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AssociationOptions {
    /// Largest delay along the track, early or late, s. With element sets two weeks old, satellites are a minute or two
    /// late.
    pub max_offset_s: f64,
    /// Largest difference between the time of the track and the epoch of an element set, days.
    pub max_element_age_days: f64,
    /// Uncertainty (one sigma) of a range difference, km.
    pub range_sigma_km: f64,
    /// Uncertainty (one sigma) of a difference in phase angle, radians.
    pub phase_sigma_rad: f64,
    /// Uncertainty (one sigma) of the delay: at the epoch of the element set, s, and its growth, s per day. Without it,
    /// old element sets of other satellites would fit short tracks by chance.
    pub offset_sigma_s: [f64; 2],
}

impl Default for AssociationOptions {
    /// Returns 120 s, 50 days, 1 km, 0.4°, 3 s and 2 s per day. The values for the delay are those of Starlink
    /// satellites, which keep their stations by thrust that element sets do not model.
    fn default() -> Self {
        Self {
            max_offset_s: 120.0,
            max_element_age_days: 50.0,
            range_sigma_km: 1.0,
            phase_sigma_rad: 0.4_f64.to_radians(),
            offset_sigma_s: [3.0, 2.0],
        }
    }
}

/// Candidate satellite of a track.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct TrackCandidate {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Root mean square of the range differences after the fit of the delay, km.
    pub range_rms_km: f64,
    /// Root mean square of the differences in phase angle after the fit of the delay, radians; `None` if none are
    /// recorded.
    pub phase_rms_rad: Option<f64>,
    /// Time offset along the track, s: the satellite is where the element set predicts it this much later. A satellite
    /// with a positive offset is early, one with a negative offset is late.
    pub offset_s: f64,
    /// Time from the epoch of the element set to the track, days.
    pub element_age_days: f64,
    /// (range rms / sigma)² + (phase rms / sigma)² + (delay / sigma)² + 2 ln(sigma of the delay / its sigma at epoch).
    /// The best candidate has the smallest score. The last term penalises old element sets, whose positions are
    /// uncertain.
    pub score: f64,
}

/// Margin in range for the first comparison, in addition to the effect of the largest delay, km.
const RANGE_MARGIN_KM: f64 = 50.0;

/// Returns candidates for a track, the best first. A satellite occurs once, with the best of its element sets.
///
/// The rows should belong to one track, be in order of time and have ranges. A first comparison rejects satellites that
/// cannot have the range recorded at the middle of the track for any allowed delay, because the range changes no faster
/// than the satellite moves. Empty if no row has time, site and range.
pub fn associate(
    track: &[Record],
    sites: &[Site],
    history: &History,
    eop: &EopTable,
    options: &AssociationOptions,
) -> Vec<TrackCandidate> {
    let mut ephemeris = Ephemeris::new(eop.clone());
    ephemeris.prepare(track.iter().filter_map(|record| record.epoch));
    let observers: Vec<SiteAxes> = sites.iter().map(SiteAxes::new).collect();
    let track: Vec<&Record> = track.iter().collect();
    let points: Vec<Ranged> =
        Ranged::thinned(&track).filter_map(|record| Ranged::from_record(record, &ephemeris, &observers)).collect();
    let Some(middle) = points.get(points.len() / 2) else { return Vec::new() };
    let objects: Vec<&[ElementSet]> = history.objects().collect();
    let best_of = |sets: &&[ElementSet]| {
        let young = sets.iter().filter(|set| age_days(set, middle.epoch).abs() <= options.max_element_age_days);
        young.filter_map(|set| candidate(set, &points, middle, options)).min_by(|a, b| a.score.total_cmp(&b.score))
    };
    let mut candidates: Vec<TrackCandidate> = objects.par_iter().filter_map(best_of).collect();
    candidates.sort_by(|a, b| a.score.total_cmp(&b.score).then(a.norad_id.cmp(&b.norad_id)));
    candidates
}

fn candidate(
    set: &ElementSet,
    points: &[Ranged],
    middle: &Ranged,
    options: &AssociationOptions,
) -> Option<TrackCandidate> {
    let propagator = Propagator::new(set).ok()?;
    let satellite = shifted(&propagator, middle, 0.0)?;
    let apart_km = ((satellite - middle.observer).norm_km() - middle.range_km).abs();
    // v ≤ √((1+e)/(1-e)) 2π a / P
    let radius_km = satellite.norm_km();
    let speed_km_s = TAU * radius_km / (DAY_S / set.mean_motion_rev_day) * (1.0 + 2.0 * set.eccentricity);
    if apart_km > speed_km_s * options.max_offset_s + RANGE_MARGIN_KM {
        return None;
    }
    let offset = fitted_offset_s(&propagator, points, options.max_offset_s)?;
    let phases: Option<Vec<f64>> = points
        .iter()
        .map(|point| {
            let satellite = shifted(&propagator, point, offset.offset_s)?;
            let geometry = ViewingGeometry::new(&satellite, &point.observer, &point.moment.sun)?;
            Some(geometry.phase_angle_rad() - point.phase_rad?)
        })
        .collect();
    let phase_rms_rad = phases.map(|all| {
        (all.iter().map(|difference_rad| difference_rad * difference_rad).sum::<f64>() / all.len() as f64).sqrt()
    });
    let element_age_days = age_days(set, middle.epoch);
    let offset_sigma_s = options.offset_sigma_s[0] + options.offset_sigma_s[1] * element_age_days.abs();
    // χ² + 2 ln(σ_delay / σ_delay at epoch), minus twice the log likelihood
    let squares = [
        offset.range_rms_km / options.range_sigma_km,
        phase_rms_rad.unwrap_or(0.0) / options.phase_sigma_rad,
        offset.offset_s / offset_sigma_s,
    ];
    let score =
        squares.iter().map(|term| term * term).sum::<f64>() + 2.0 * (offset_sigma_s / options.offset_sigma_s[0]).ln();
    Some(TrackCandidate {
        norad_id: set.norad_id,
        range_rms_km: offset.range_rms_km,
        phase_rms_rad,
        offset_s: offset.offset_s,
        element_age_days,
        score,
    })
}
