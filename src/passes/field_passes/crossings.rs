//! Crossings of a field by sunlit satellites, with times only. They are ten times faster to compute than passes,
//! because magnitude and probability are omitted.

use nalgebra::Vector3;

use super::super::candidates::{ABERRATION_MARGIN_RAD, CandidateInterval};
use super::super::crossing::cross;
use super::super::exposure::Exposure;
use super::super::field::{Field, FieldOnSky};
use super::super::sky::Sky;
use super::super::track::{Chord, ObserverMotion, SightLine};
use super::exposed_field::{ExposedField, NearSatellite};
use crate::constants::WGS72_MU_KM3_S2;
use crate::error::Error;
use crate::frames::Gcrs;
use crate::orbit::{Beam, LeftOut, SearchScope, State};

/// Longest interval that one SGP4 position covers, seconds. During half of it, the path deviates from its tangent by 4
/// km.
const LONGEST_STEP_S: f64 = 60.0;
/// Largest distance, km, between SGP4's positions and those extrapolated with its velocity, in half of that interval.
/// It follows from the tolerance of [`Propagator::check_step`](crate::orbit::Propagator::check_step).
const VELOCITY_SLOP_KM: f64 = 3.0;

/// Crossing of a field by one sunlit satellite during one exposure.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FieldCrossing {
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Parts of the track inside the field, in order; times are seconds after the start of the exposure.
    pub chords: Vec<Chord>,
}

/// Crossings of a field, grouped by exposure.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldCrossings {
    /// Crossings of each exposure in order of entry; exposures are in the order given.
    pub by_exposure: Vec<Vec<FieldCrossing>>,
    /// Satellites without a position in at least one of the exposures, without repetition, in catalogue order.
    /// Positions are not computed while the field is below the ground.
    pub left_out: Vec<LeftOut>,
}

impl Sky {
    /// Finds all sunlit satellites that cross the field in each exposure.
    ///
    /// The result contains the crossings of [`Sky::field_passes`] with default options, at the same times to 10 µs,
    /// with two exceptions. If the position of a satellite can be computed near the field, but not at other times of
    /// the exposure, the satellite is not reported as left out. A satellite that stays in the field for hours, or
    /// returns within minutes, counts as lit if it is lit at any time inside the field.
    ///
    /// # Errors
    /// The errors of [`Sky::field_passes`].
    pub fn field_crossings(&self, exposures: &[Exposure], field: &Field) -> Result<FieldCrossings, Error> {
        self.field_crossings_until(exposures, field, |_, _| false)
    }

    /// Finds crossings as [`Sky::field_crossings`] until there are enough for each exposure: `is_enough` is called with
    /// the index of an exposure and its crossings in any order, whenever their number has doubled.
    pub(crate) fn field_crossings_until(
        &self,
        exposures: &[Exposure],
        field: &Field,
        is_enough: impl Fn(usize, &[FieldCrossing]) -> bool + Sync,
    ) -> Result<FieldCrossings, Error> {
        let (by_exposure, left_out) =
            self.by_exposure(exposures, SearchScope::Nominal, |scene, (index, exposure), seen| {
                let exposed = ExposedField::new(self, scene, exposure, field)?;
                let (mut crossings, left_out) = exposed.evaluate(
                    false,
                    seen,
                    |interval| exposed.crossing(interval),
                    |crossings| is_enough(index, crossings),
                )?;
                let entry = |crossing: &FieldCrossing| crossing.chords.first().map_or(0.0, |chord| chord.enter_s);
                crossings.sort_by(|a, b| entry(a).total_cmp(&entry(b)).then(a.element_index.cmp(&b.element_index)));
                Ok((crossings, left_out))
            })?;
        Ok(FieldCrossings { by_exposure, left_out })
    }
}

impl ExposedField<'_> {
    /// Returns the crossing of one satellite; `None` if it does not cross the field or is dark.
    fn crossing(&self, interval: &CandidateInterval) -> Result<Option<FieldCrossing>, Error> {
        let &CandidateInterval { element_index, start_s, end_s, near_s, .. } = interval;
        let Some(satellite) = self.satellite(element_index, 0.5 * (start_s + end_s)) else { return Ok(None) };
        let near_the_ground = self.sky.reaches_the_ground(self.exposure, &self.field, &satellite.orientation);
        let (mut chords, mut is_lit) = (Vec::new(), false);
        for [from_s, to_s] in intervals_near([near_s[0].max(start_s), near_s[1].min(end_s)], &satellite, &self.field)? {
            let arc = satellite.arc(from_s, to_s)?;
            let line = SightLine { arc: &arc, observer: satellite.observer.clone() };
            let mut crossing = cross(&|time_s| line.sight(time_s), from_s, to_s, &self.field);
            if crossing.chords.is_empty() {
                continue;
            }
            let evaluator = self.evaluator(&line, element_index, None, satellite.uncertainty);
            if let Some((enter_s, exit_s)) = evaluator.keep_above_ground(&mut crossing, near_the_ground) {
                is_lit |= evaluator.is_lit(enter_s, exit_s);
                chords.extend(self.after_opening(&crossing.chords));
            }
        }
        Ok(is_lit.then_some(FieldCrossing { element_index, chords }))
    }
}

/// Returns the parts of an interval in which a satellite may be in a field, from one SGP4 position per minute.
///
/// # Errors
/// A position cannot be computed, or if velocities are inconsistent with positions.
fn intervals_near(
    [from_s, to_s]: [f64; 2],
    satellite: &NearSatellite<'_>,
    field: &FieldOnSky,
) -> Result<Vec<[f64; 2]>, Error> {
    let steps = ((to_s - from_s) / LONGEST_STEP_S).ceil().max(1.0);
    let half_s = 0.5 * (to_s - from_s) / steps;
    let mut near: Vec<[f64; 2]> = Vec::new();
    let mut before: Option<State<Gcrs>> = None;
    for step in 0..steps as usize {
        let begin_s = from_s + 2.0 * half_s * step as f64;
        let minutes = satellite.minutes + (begin_s + half_s) / 60.0;
        let state = satellite.propagator.state_at_minutes(minutes, &satellite.orientation.teme_to_gcrs)?;
        if let Some(before) = before.replace(state) {
            satellite.propagator.check_step(&before, &state, 2.0 * half_s, minutes - 2.0 * half_s / 60.0)?;
        }
        if !passes_by(&state, &satellite.observer, begin_s + half_s, half_s, field) {
            continue;
        }
        let end_s = begin_s + 2.0 * half_s;
        match near.last_mut() {
            Some(last) if begin_s - last[1] < half_s => last[1] = end_s,
            _ => near.push([begin_s, end_s]),
        }
    }
    Ok(near)
}

/// Returns true if a satellite with this state may be in a field within `half_s` of a time. Its path is approximated by
/// a straight line, with a margin for the deviation of the true path.
fn passes_by(state: &State<Gcrs>, observer: &ObserverMotion, time_s: f64, half_s: f64, field: &FieldOnSky) -> bool {
    let (there, here) = (*state.position.vector(), *observer.position(time_s).vector());
    // Satellite and observer each deviate from a straight line by at most ½ g t².
    let fall_km = |position: &Vector3<f64>| 0.5 * WGS72_MU_KM3_S2 / position.norm_squared() * half_s * half_s;
    let slop_km = fall_km(&there) + fall_km(&here) + VELOCITY_SLOP_KM;
    let velocity = state.velocity.vector() - observer.velocity(time_s);
    let beam = Beam::new(*field.centre(), field.bounding_radius_rad() + ABERRATION_MARGIN_RAD);
    beam.near_s(&(there - here), &velocity, half_s, slop_km).is_some()
}
