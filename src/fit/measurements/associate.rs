//! Which satellite a track is of: every candidate's range and phase against the recorded ones.

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::constants::DAY_S;
use crate::elements::{ElementSet, History, NoradId};
use crate::frames::EopTable;
use crate::geometry::{Site, ViewingGeometry};
use crate::orbit::Propagator;

use super::ephemeris::Ephemeris;
use super::offset::{Ranged, fitted_offset_s, shifted};
use super::placement::{Stand, age_days};
use super::record::Record;

/// How a track is compared with a catalogue.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AssociationOptions {
    /// Satellites may be early or late by so much, s: element sets of a fortnight are late by a minute or two.
    pub max_offset_s: f64,
    /// Element sets farther away in time are not used, days.
    pub max_element_age_days: f64,
    /// What a difference of range counts as one sigma, km.
    pub range_sigma_km: f64,
    /// What a difference of phase counts as one sigma, radians.
    pub phase_sigma_rad: f64,
    /// What being late counts as one sigma: so much at the element set's epoch, s, and so much more a day. Without it, old element sets of
    /// other satellites fit a short track by chance.
    pub offset_sigma_s: [f64; 2],
}

impl Default for AssociationOptions {
    /// 120 s, 50 days, 1 km, 0.4°, 3 s and 2 s a day: Starlinks hold their places by thrust, which element sets do not know.
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

/// A satellite that may be the one.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Who.
    pub norad_id: NoradId,
    /// Root mean square of the differences of range after the shift, km.
    pub range_rms_km: f64,
    /// Root mean square of the differences of phase after the shift, radians; `None` where none is recorded.
    pub phase_rms_rad: Option<f64>,
    /// The satellite is where its element set has it so many seconds later (negative: earlier).
    pub offset_s: f64,
    /// From the element set's epoch to the track, days.
    pub element_age_days: f64,
    /// (range rms / sigma)² + (phase rms / sigma)² + (offset / sigma)² + 2 ln(sigma of the offset / that at epoch): what candidates are ranked
    /// by, the least first. The last term is what makes an old element set, which may be anywhere, the less likely explanation.
    pub score: f64,
}

/// The least and the greatest range that are worth a closer look, beyond what the shift allows, km.
const RANGE_MARGIN_KM: f64 = 50.0;

/// Candidates for a track, best first; at most one of each satellite, by whichever of its element sets fits best.
///
/// The rows should be of one track and in time order, with ranges. A satellite is looked at more closely where its range at the track's
/// middle can be the recorded one after a shift within the limit: the range changes no faster than satellite and observer move.
/// Empty where no row has time, site and range.
pub fn associate(
    track: &[Record],
    sites: &[Site],
    history: &History,
    eop: &EopTable,
    options: &AssociationOptions,
) -> Vec<Candidate> {
    let mut ephemeris = Ephemeris::new(eop.clone());
    ephemeris.prepare(track.iter().filter_map(|record| record.epoch));
    let stands: Vec<Stand> = sites.iter().map(Stand::new).collect();
    let track: Vec<&Record> = track.iter().collect();
    let points: Vec<Ranged> =
        Ranged::thinned(&track).filter_map(|record| Ranged::of(record, &ephemeris, &stands)).collect();
    let Some(middle) = points.get(points.len() / 2) else { return Vec::new() };
    let objects: Vec<&[ElementSet]> = history.objects().collect();
    let best_of = |sets: &&[ElementSet]| {
        let young = sets.iter().filter(|set| age_days(set, middle.epoch).abs() <= options.max_element_age_days);
        young.filter_map(|set| candidate(set, &points, middle, options)).min_by(|a, b| a.score.total_cmp(&b.score))
    };
    let mut candidates: Vec<Candidate> = objects.par_iter().filter_map(best_of).collect();
    candidates.sort_by(|a, b| a.score.total_cmp(&b.score).then(a.norad_id.cmp(&b.norad_id)));
    candidates
}

fn candidate(set: &ElementSet, points: &[Ranged], middle: &Ranged, options: &AssociationOptions) -> Option<Candidate> {
    let propagator = Propagator::new(set).ok()?;
    let satellite = shifted(&propagator, middle, 0.0)?;
    let apart_km = ((satellite - middle.observer).norm_km() - middle.range_km).abs();
    // v = 2π a / P at most √((1+e)/(1-e)) times; the shift moves the satellite alone.
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
    let phase_rms_rad = phases.map(|all| (all.iter().map(|one| one * one).sum::<f64>() / all.len() as f64).sqrt());
    let element_age_days = age_days(set, middle.epoch);
    let offset_sigma_s = options.offset_sigma_s[0] + options.offset_sigma_s[1] * element_age_days.abs();
    // χ² + 2 ln(σ_offset / σ_offset at epoch): minus twice the logarithm of the likelihood of the three
    let squares = [
        offset.range_rms_km / options.range_sigma_km,
        phase_rms_rad.unwrap_or(0.0) / options.phase_sigma_rad,
        offset.offset_s / offset_sigma_s,
    ];
    let score =
        squares.iter().map(|one| one * one).sum::<f64>() + 2.0 * (offset_sigma_s / options.offset_sigma_s[0]).ln();
    Some(Candidate {
        norad_id: set.norad_id,
        range_rms_km: offset.range_rms_km,
        phase_rms_rad,
        offset_s: offset.offset_s,
        element_age_days,
        score,
    })
}
