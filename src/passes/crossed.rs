//! Crossings alone: who is in a field from when to when, without a magnitude or a probability. A tenth of the work of a pass, for who asks only
//! when a field is clear.

use nalgebra::Vector3;
use rayon::prelude::*;

use super::crossing::cross;
use super::expose::{ABERRATION_MARGIN_RAD, Dark, Run};
use super::exposure::Exposure;
use super::field::{Field, FieldOnSky};
use super::look::Look;
use super::scene::{Scene, end_s, groups};
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError, check};
use super::track::Chord;
use crate::constants::{DAY_S, WGS72_MU_KM3_S2};
use crate::frames::{Gcrs, Rotation, Teme, seconds_after, seconds_between};
use crate::orbit::{Arc, Beam, Candidate, LeftOut, OrbitError, Propagator, State};

/// One look tells where a satellite is for so long at most, seconds: it bends from its line by 4 km.
const LONGEST_LOOK_S: f64 = 60.0;
/// What SGP4's velocity and its positions may disagree by in that time, km: what [`Propagator::check_step`] lets pass, in half of it.
const LOOK_SLOP_KM: f64 = 3.0;

/// One lit satellite in one exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct Crossed {
    /// Which of the sky's element sets.
    pub element_index: usize,
    /// Stretches inside the field, seconds after the exposure's start, in time order.
    pub chords: Vec<Chord>,
}

/// The answer to one question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crossings {
    /// For each exposure asked, in its place, the crossings in order of entry.
    pub by_exposure: Vec<Vec<Crossed>>,
    /// Satellites without a position for at least one of the exposures, each once, in catalogue order. Nobody is asked for one while the field is below the ground.
    pub left_out: Vec<LeftOut>,
}

impl Sky {
    /// Every lit satellite that crosses the field in each exposure: the same ones as the passes of [`Sky::field_passes`] with default options, at the same
    /// times to 10 µs. A satellite whose orbit breaks down far from the field is not told of, and one that stays for hours or comes twice within minutes is lit if it is
    /// at any of the times that it crosses, not in between.
    ///
    /// # Errors
    /// As [`Sky::field_passes`].
    pub fn field_crossings(&self, exposures: &[Exposure], field: &Field) -> Result<Crossings, SkyError> {
        exposures.iter().try_for_each(check)?;
        let mut answer = Crossings { by_exposure: vec![Vec::new(); exposures.len()], left_out: Vec::new() };
        answer.left_out.extend_from_slice(self.left_out());
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let span_s = group.iter().map(|&one| end_s(start, &exposures[one])).fold(0.0, f64::max);
            let scene = self.scene(start, span_s, false);
            for window in &scene.windows {
                answer.left_out.extend_from_slice(window.left_out());
            }
            let found: Vec<(usize, Vec<Crossed>, Vec<LeftOut>)> = group
                .par_iter()
                .map_init(Vec::new, |seen, &one| {
                    let (crossed, left_out) = self.crossings_of(&scene, &exposures[one], field, seen)?;
                    Ok((one, crossed, left_out))
                })
                .collect::<Result<_, SkyError>>()?;
            for (one, crossed, left_out) in found {
                answer.by_exposure[one] = crossed;
                answer.left_out.extend(left_out);
            }
        }
        answer.left_out.sort_by_key(|left_out| left_out.element_index);
        answer.left_out.dedup_by_key(|left_out| left_out.element_index);
        Ok(answer)
    }

    fn crossings_of(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &Field,
        seen: &mut Vec<Candidate>,
    ) -> Result<(Vec<Crossed>, Vec<LeftOut>), SkyError> {
        let flight = self.flight(scene, exposure)?;
        let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
        let opened_s = seconds_between(scene.start, exposure.start);
        let (mut crossed, mut left_out) = (Vec::new(), Vec::new());
        for run in self.runs(scene, exposure, &on_sky, flight.as_ref(), Dark::LeftOut, seen) {
            let element_index = run.element_index;
            match self.crossed(scene, exposure, &on_sky, &run, flight.as_ref()) {
                Ok(None) => {}
                Ok(Some(mut chords)) => {
                    for chord in &mut chords {
                        *chord = Chord { enter_s: chord.enter_s - opened_s, exit_s: chord.exit_s - opened_s };
                    }
                    crossed.push(Crossed { element_index, chords });
                }
                Err(reason) => {
                    left_out.push(LeftOut { norad_id: self.elements()[element_index].norad_id, element_index, reason });
                }
            }
        }
        let entry = |one: &Crossed| one.chords.first().map_or(0.0, |chord| chord.enter_s);
        crossed.sort_by(|a, b| entry(a).total_cmp(&entry(b)).then(a.element_index.cmp(&b.element_index)));
        Ok((crossed, left_out))
    }

    /// The chords of one satellite, seconds of the scene; `None` where it does not cross, or is dark.
    fn crossed(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        run: &Run,
        flight: Option<&std::sync::Arc<Arc>>,
    ) -> Result<Option<Vec<Chord>>, OrbitError> {
        let mid_s = 0.5 * (run.start_s + run.end_s);
        let Some(propagator) = self.index().propagator(run.element_index) else { return Ok(None) };
        let orientation = scene.orientation.at_s(mid_s);
        let Some(observer) = self.motion(scene, &orientation, flight, mid_s) else { return Ok(None) };
        let minutes = propagator.minutes_since_epoch(scene.start);
        let teme_to_gcrs = &orientation.teme_to_gcrs;
        let (options, near_the_ground) =
            (PassOptions::default(), self.reaches_the_ground(exposure, field, &orientation));
        let (mut chords, mut is_lit) = (Vec::new(), false);
        for [from_s, to_s] in stretches_near(run.near_s, &observer, field, propagator, minutes, teme_to_gcrs)? {
            let arc = Arc::new(propagator, minutes, from_s, to_s - from_s, teme_to_gcrs)?;
            let line = SightLine { arc: &arc, observer: observer.clone() };
            let mut crossing = cross(&|time_s| line.sight(time_s), from_s, to_s, field);
            if crossing.chords.is_empty() {
                continue;
            }
            let age_days = seconds_between(propagator.epoch(), seconds_after(scene.start, mid_s)) / DAY_S;
            let look = Look {
                scene,
                viewpoint: self.viewpoint(),
                shadow: self.shadow(),
                line: &line,
                model: self.model(run.element_index),
                options: &options,
                uncertainty: self.uncertainty(run.element_index, age_days),
            };
            if let Some((enter_s, exit_s)) = look.keep_above_ground(&mut crossing, near_the_ground) {
                is_lit |= look.is_lit(enter_s, exit_s);
                chords.append(&mut crossing.chords);
            }
        }
        Ok(is_lit.then_some(chords))
    }
}

/// When a satellite may be in a field, within a stretch in which its interpolated elements cannot tell: one look of SGP4 for each minute.
///
/// # Errors
/// [`OrbitError`] where there is no place at one of the looks, or velocities are not the rate of places.
fn stretches_near(
    [from_s, to_s]: [f64; 2],
    observer: &ObserverMotion,
    field: &FieldOnSky,
    propagator: &Propagator,
    reference_minutes: f64,
    teme_to_gcrs: &Rotation<Teme, Gcrs>,
) -> Result<Vec<[f64; 2]>, OrbitError> {
    let looks = ((to_s - from_s) / LONGEST_LOOK_S).ceil().max(1.0);
    let half_s = 0.5 * (to_s - from_s) / looks;
    let mut near: Vec<[f64; 2]> = Vec::new();
    let mut before: Option<State<Gcrs>> = None;
    for look in 0..looks as usize {
        let begin_s = from_s + 2.0 * half_s * look as f64;
        let minutes = reference_minutes + (begin_s + half_s) / 60.0;
        let state = propagator.state_at_minutes(minutes, teme_to_gcrs)?;
        if let Some(before) = before.replace(state) {
            propagator.check_step(&before, &state, 2.0 * half_s, minutes - 2.0 * half_s / 60.0)?;
        }
        if !passes_by(&state, observer, begin_s + half_s, half_s, field) {
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

/// Whether a satellite that stands so at a moment may be in a field for so long before and after it: along a straight line, with all that the true one leaves it by.
fn passes_by(state: &State<Gcrs>, observer: &ObserverMotion, look_s: f64, half_s: f64, field: &FieldOnSky) -> bool {
    let (there, here) = (*state.position.vector(), *observer.position(look_s).vector());
    // Both fall by ½ g t² at most.
    let fall_km = |place: &Vector3<f64>| 0.5 * WGS72_MU_KM3_S2 / place.norm_squared() * half_s * half_s;
    let slop_km = fall_km(&there) + fall_km(&here) + LOOK_SLOP_KM;
    let velocity = state.velocity.vector() - observer.velocity(look_s);
    let beam = Beam::new(*field.centre(), field.bounding_radius_rad() + ABERRATION_MARGIN_RAD);
    beam.near_s(&(there - here), &velocity, half_s, slop_km).is_some()
}
