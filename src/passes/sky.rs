//! A catalogue over one site, or around one telescope in orbit: the one thing that every outcome asks.

use std::sync::Arc as Shared;

use hifitime::Epoch;
use rayon::prelude::*;
use thiserror::Error;

use super::crossing::cross;
use super::exposure::Exposure;
use super::field::{Field, FieldOnSky};
use super::look::{LOWEST_ALTITUDE_RAD, Look};
use super::models::ModelChoice;
use super::probability::{
    LONGEST_REACH_S, REACH_SIGMAS, crossing_probability, crossing_probability_in_flight, reach_s,
};
use super::scene::{Scene, end_s, groups};
use super::sightline::{ObserverMotion, SightLine};
use super::track::{Chord, FieldPass};
use super::viewpoint::{OrbitingObserver, Viewpoint};
use super::windows::Windows;
use crate::catalogue::ElementSet;
use crate::constants::{DAY_S, EARTH_ROTATION_RAD_S};
use crate::frames::{EopTable, Orientation, OrientationTable, seconds_after, seconds_between};
use crate::geometry::{ShadowModel, SunTable};
use crate::orbit::{Arc, Cone, LeftOut, OrbitClass, OrbitError, OrbitUncertainty, Reach, SatelliteIndex, uncertainty};
use crate::photometry::{BrightnessModel, PhotometryOptions};

/// The cull asks for at most this long at a time, seconds: by then an observer on the ground has moved 14 km to each side.
const SLICE_S: f64 = 60.0;
/// The same for an observer in orbit, who has moved 40 km by then.
const FLIGHT_SLICE_S: f64 = 10.0;
/// A satellite that is a candidate again within this time is still on the same pass, seconds: nothing comes round so soon.
const SAME_PASS_S: f64 = 1200.0;
/// Aberration (21") and light time (6") between the astrometric axis and the geometric cone, with room, radians.
const ABERRATION_MARGIN_RAD: f64 = 2e-4;
/// First and last year for which Sun and Earth are computed.
const YEARS: (i32, i32) = (1957, 2099);

/// Why a question has no answer at all.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// No ephemeris of Sun and Earth, and no elements either.
    #[error("{epoch} is outside the years for which Sun and Earth are known (allowed: {} to {})", YEARS.0, YEARS.1)]
    NoEphemeris {
        /// What was asked for.
        epoch: Epoch,
    },
    /// The telescope's own elements give no place.
    #[error("the observer {observer} has no place: {reason}")]
    Observer {
        /// Its name.
        observer: String,
        /// Why.
        reason: OrbitError,
    },
    /// A question that only a site can be asked.
    #[error("the observer {observer} is in orbit and has no horizon (allowed: a site)")]
    NoHorizon {
        /// Its name.
        observer: String,
    },
    /// An exposure of no possible length or direction.
    #[error("exposure {id}: {problem}")]
    Exposure {
        /// The schedule's name of it.
        id: String,
        /// What is wrong, and what is allowed.
        problem: String,
    },
}

/// What is wanted of each pass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassOptions {
    /// Crossings that are dark all along too.
    pub include_dark: bool,
    /// Near misses that cross with at least this probability too; `None` keeps to nominal crossings.
    pub min_probability: Option<f64>,
    /// Points along the track, evenly spaced in time from entry to exit; 0 for none.
    pub samples: usize,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
}

/// The answer to one question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passes {
    /// For each exposure asked, in its place, the passes in order of entry.
    pub by_exposure: Vec<Vec<FieldPass>>,
    /// Satellites without a position for at least one of the exposures, each once, in catalogue order.
    pub left_out: Vec<LeftOut>,
}

/// Satellites, an observer, and what is known of their light: ready for any number of questions, from any thread.
#[derive(Clone, Debug)]
pub struct Sky {
    elements: Vec<ElementSet>,
    index: SatelliteIndex,
    classes: Vec<OrbitClass>,
    models: Vec<Shared<BrightnessModel>>,
    viewpoint: Viewpoint,
    shadow: ShadowModel,
    eop: EopTable,
    windows: Windows,
}

/// The slices of one exposure in which one satellite was a candidate, from the first to the last of one pass; seconds of the
/// scene.
struct Run {
    element_index: usize,
    start_s: f64,
    end_s: f64,
}

impl Sky {
    /// Makes a catalogue ready over one site, or around one telescope in orbit. Takes about 2 µs a satellite and core. The shadow is geometric.
    pub fn new(
        elements: Vec<ElementSet>,
        viewpoint: impl Into<Viewpoint>,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let index = SatelliteIndex::new(&elements);
        let classes = elements.iter().map(OrbitClass::of).collect();
        let models = elements.iter().map(|elements| choice.model_of(elements)).collect();
        Self {
            elements,
            index,
            classes,
            models,
            viewpoint: viewpoint.into(),
            shadow: ShadowModel::default(),
            eop,
            windows: Windows::default(),
        }
    }

    /// The element sets, in the order of [`FieldPass::element_index`].
    pub fn elements(&self) -> &[ElementSet] {
        &self.elements
    }

    /// The same sky with another shadow of the Earth.
    pub fn with_shadow(self, shadow: ShadowModel) -> Self {
        Self { shadow, ..self }
    }

    /// What casts the Earth's shadow.
    pub fn shadow(&self) -> ShadowModel {
        self.shadow
    }

    /// Where the telescope is.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// The brightness model of an element set.
    ///
    /// # Panics
    /// Where the catalogue has no element set of this number.
    pub fn model(&self, element_index: usize) -> &BrightnessModel {
        &self.models[element_index]
    }

    /// Satellites that SGP4 cannot start from.
    pub fn left_out(&self) -> &[LeftOut] {
        self.index.left_out()
    }

    pub(super) fn index(&self) -> &SatelliteIndex {
        &self.index
    }

    /// One-sigma errors of a satellite's prediction at an age of its elements.
    pub fn uncertainty(&self, element_index: usize, age_days: f64) -> OrbitUncertainty {
        uncertainty(self.classes[element_index], age_days)
    }

    /// Every satellite that crosses the field in each exposure, on all threads of the current pool.
    ///
    /// Exposures may come in any order and last from nothing to days; those of one night share their preparation. The answer
    /// does not depend on the number of threads. A satellite that comes back after leaving (an exposure of hours) is a
    /// pass of its own each time.
    ///
    /// # Errors
    /// [`SkyError`] where an exposure has no finite direction or length, or lies outside the years of the Sun's ephemeris; where the telescope is in orbit and its
    /// own elements give no place.
    pub fn field_passes(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
    ) -> Result<Passes, SkyError> {
        exposures.iter().try_for_each(check)?;
        let mut answer = Passes { by_exposure: vec![Vec::new(); exposures.len()], left_out: Vec::new() };
        answer.left_out.extend_from_slice(self.index.left_out());
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let end_s = group.iter().map(|&one| end_s(start, &exposures[one])).fold(0.0, f64::max);
            let scene = self.scene(start, end_s, options.min_probability.is_some());
            for window in &scene.windows {
                answer.left_out.extend_from_slice(window.left_out());
            }
            let found: Vec<(usize, Vec<FieldPass>, Vec<LeftOut>)> = group
                .par_iter()
                .map_init(Vec::new, |candidates, &one| {
                    let (passes, left_out) = self.expose(&scene, &exposures[one], field, options, candidates)?;
                    Ok((one, passes, left_out))
                })
                .collect::<Result<_, SkyError>>()?;
            for (one, passes, left_out) in found {
                answer.by_exposure[one] = passes;
                answer.left_out.extend(left_out);
            }
        }
        answer.left_out.sort_by_key(|left_out| left_out.element_index);
        answer.left_out.dedup_by_key(|left_out| left_out.element_index);
        Ok(answer)
    }

    /// As [`Sky::field_passes`], without the cull: every satellite is asked of SGP4 for every slice. The authority that the
    /// cull is held against; thousands of times slower.
    ///
    /// # Errors
    /// As [`Sky::field_passes`].
    pub fn field_passes_by_brute_force(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
    ) -> Result<Vec<Vec<FieldPass>>, SkyError> {
        exposures.iter().try_for_each(check)?;
        exposures
            .par_iter()
            .map(|exposure| {
                let duration_s = end_s(exposure.start, exposure);
                let scene = self.scene_without_windows(exposure.start, duration_s);
                let flight = self.flight(&scene, exposure)?;
                let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
                let mut passes: Vec<FieldPass> = (0..self.elements.len())
                    .filter(|&element_index| !self.is_observer(element_index))
                    .filter_map(|element_index| {
                        let run = Run { element_index, start_s: 0.0, end_s: duration_s };
                        self.pass(&scene, exposure, &on_sky, &run, flight.as_ref(), options).ok().flatten()
                    })
                    .collect();
                passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
                Ok(passes)
            })
            .collect()
    }

    /// The telescope's own arc over an exposure, and as long before and after it as late satellites are looked for; none for a site.
    fn flight(&self, scene: &Scene, exposure: &Exposure) -> Result<Option<Shared<Arc>>, SkyError> {
        let Some(observer) = self.viewpoint.orbit() else { return Ok(None) };
        let failed = |reason| SkyError::Observer { observer: observer.name(), reason };
        let opened_s = seconds_between(scene.start, exposure.start);
        let orientation = scene.orientation.at_s(opened_s + 0.5 * exposure.duration_s);
        let minutes = observer.propagator().minutes_since_epoch(scene.start);
        Arc::new(
            observer.propagator(),
            minutes,
            opened_s - LONGEST_REACH_S,
            exposure.duration_s + 2.0 * LONGEST_REACH_S,
            &orientation.teme_to_gcrs,
        )
        .map(|arc| Some(Shared::new(arc)))
        .map_err(failed)
    }

    /// The observer near a moment.
    fn motion(
        &self,
        scene: &Scene,
        orientation: &Orientation,
        flight: Option<&Shared<Arc>>,
        time_s: f64,
    ) -> Option<ObserverMotion> {
        let earth_velocity = scene.sun.at_s(time_s).earth_velocity;
        match &self.viewpoint {
            Viewpoint::Site(observer) => Some(ObserverMotion::of_site(observer, orientation, earth_velocity, time_s)),
            Viewpoint::Orbit(_) => Some(ObserverMotion::of_flight(flight?.clone(), earth_velocity)),
        }
    }

    /// True for the telescope's own elements, which it does not see.
    fn is_observer(&self, element_index: usize) -> bool {
        let own = self.viewpoint.orbit().map(OrbitingObserver::norad_id);
        own == Some(self.elements[element_index].norad_id)
    }

    /// Sun and Earth alone.
    pub(super) fn scene_without_windows(&self, start: Epoch, span_s: f64) -> Scene {
        let end = seconds_after(start, span_s);
        Scene {
            start,
            orientation: OrientationTable::new(start, end, &self.eop),
            sun: SunTable::new(start, end),
            windows: Vec::new(),
        }
    }

    fn scene(&self, start: Epoch, span_s: f64, near_misses: bool) -> Scene {
        let reach = |element_index: usize, ends: [Epoch; 2]| {
            let age_days = |epoch| seconds_between(self.elements[element_index].epoch, epoch) / DAY_S;
            let of = |epoch| self.uncertainty(element_index, age_days(epoch));
            let [first, last] = ends.map(of);
            Reach {
                along_track_s: reach_s(first.along_track_s.max(last.along_track_s)),
                cross_track_km: REACH_SIGMAS * first.cross_track_km.max(last.cross_track_km),
            }
        };
        let mut scene = self.scene_without_windows(start, span_s);
        let reach: Option<&(dyn Fn(usize, [Epoch; 2]) -> Reach + Sync)> = if near_misses { Some(&reach) } else { None };
        scene.windows = self.windows.over(&self.index, start, seconds_after(start, span_s), reach);
        scene
    }

    /// One exposure: cull slice by slice, then the exact answer for the few that are left.
    fn expose(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &Field,
        options: &PassOptions,
        candidates: &mut Vec<u32>,
    ) -> Result<(Vec<FieldPass>, Vec<LeftOut>), SkyError> {
        let flight = self.flight(scene, exposure)?;
        let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
        let mut passes = Vec::new();
        let mut left_out = Vec::new();
        for run in self.runs(scene, exposure, &on_sky, flight.as_ref(), candidates) {
            match self.pass(scene, exposure, &on_sky, &run, flight.as_ref(), options) {
                Ok(pass) => passes.extend(pass),
                Err(reason) => left_out.push(LeftOut {
                    norad_id: self.elements[run.element_index].norad_id,
                    element_index: run.element_index,
                    reason,
                }),
            }
        }
        passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
        Ok((passes, left_out))
    }

    /// Which satellites may be in the field, and when: candidates of slices that belong together joined.
    fn runs(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        flight: Option<&Shared<Arc>>,
        candidates: &mut Vec<u32>,
    ) -> Vec<Run> {
        let start_s = seconds_between(scene.start, exposure.start);
        let longest_s = if flight.is_some() { FLIGHT_SLICE_S } else { SLICE_S };
        let slices = (exposure.duration_s / longest_s).ceil().max(1.0);
        let slice_s = exposure.duration_s / slices;
        let mut seen: Vec<(u32, u32)> = Vec::new();
        for slice in 0..slices as u32 {
            let mid_s = start_s + slice_s * (f64::from(slice) + 0.5);
            let Some((window, window_start_s)) = scene.window_at(mid_s) else { continue };
            let orientation = scene.orientation.at_s(mid_s);
            let Some(motion) = self.motion(scene, &orientation, flight, mid_s) else { continue };
            let cone = Cone {
                mid_s: mid_s - window_start_s,
                half_duration_s: 0.5 * slice_s,
                observer: motion.position(mid_s),
                observer_speed_km_s: motion.fastest_km_s(mid_s, 0.5 * slice_s),
                axis: exposure.pointing,
                radius_rad: field.bounding_radius_rad() + ABERRATION_MARGIN_RAD,
            };
            window.candidates(&cone, &orientation.teme_to_gcrs, candidates);
            seen.extend(candidates.iter().map(|&element_index| (element_index, slice)));
        }
        seen.retain(|(element_index, _)| !self.is_observer(*element_index as usize));
        seen.sort_unstable();
        let mut runs: Vec<Run> = Vec::new();
        for (element_index, slice) in seen {
            let element_index = element_index as usize;
            let (from_s, end_s) = (start_s + slice_s * f64::from(slice), start_s + slice_s * f64::from(slice + 1));
            match runs.last_mut() {
                Some(run) if run.element_index == element_index && from_s - run.end_s < SAME_PASS_S => {
                    run.end_s = end_s
                }
                _ => runs.push(Run { element_index, start_s: from_s, end_s }),
            }
        }
        runs
    }

    /// True where any of the field may lie below the lowest altitude at any time of the exposure; in orbit the Earth is always near.
    fn reaches_the_ground(&self, exposure: &Exposure, field: &FieldOnSky, orientation: &Orientation) -> bool {
        let Some(observer) = self.viewpoint.site() else { return true };
        let altitude_rad = (observer.state(orientation).horizon * exposure.pointing).latitude_rad();
        // The sky turns by no more than this, whatever the exposure's length.
        let turn_rad = (EARTH_ROTATION_RAD_S * exposure.duration_s).min(std::f64::consts::PI);
        altitude_rad - field.bounding_radius_rad() - turn_rad < LOWEST_ALTITUDE_RAD
    }

    /// The exact answer for one satellite; `None` where it is not wanted.
    fn pass(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        run: &Run,
        flight: Option<&Shared<Arc>>,
        options: &PassOptions,
    ) -> Result<Option<FieldPass>, OrbitError> {
        let mid_s = 0.5 * (run.start_s + run.end_s);
        let Some(propagator) = self.index.propagator(run.element_index) else { return Ok(None) };
        let orientation = scene.orientation.at_s(mid_s);
        let Some(observer) = self.motion(scene, &orientation, flight, mid_s) else { return Ok(None) };
        let minutes = propagator.minutes_since_epoch(scene.start);
        let arc_over =
            |from_s: f64, to_s: f64| Arc::new(propagator, minutes, from_s, to_s - from_s, &orientation.teme_to_gcrs);
        let arc = arc_over(run.start_s, run.end_s)?;
        let line = SightLine { arc: &arc, observer };
        let mut crossing = cross(&|time_s| line.sight(time_s), run.start_s, run.end_s, field);
        let wanted = options.min_probability;
        if crossing.chords.is_empty() && wanted.is_none() {
            return Ok(None);
        }
        let age_days = |time_s| seconds_between(propagator.epoch(), seconds_after(scene.start, time_s)) / DAY_S;
        let sigma = self.uncertainty(run.element_index, age_days(mid_s));
        let look = Look {
            scene,
            viewpoint: &self.viewpoint,
            shadow: self.shadow,
            line: &line,
            model: &self.models[run.element_index],
            options,
            uncertainty: sigma,
        };
        if self.reaches_the_ground(exposure, field, &orientation) {
            let closest = Chord { enter_s: crossing.closest_s, exit_s: crossing.closest_s };
            let near_miss_is_up = crossing.chords.is_empty() && !look.above_ground(&closest).is_empty();
            crossing.chords = crossing.chords.iter().flat_map(|chord| look.above_ground(chord)).collect();
            if crossing.chords.is_empty() && !near_miss_is_up {
                return Ok(None);
            }
        }
        let enter_s = crossing.chords.first().map_or(crossing.closest_s, |chord| chord.enter_s);
        let exit_s = crossing.chords.last().map_or(crossing.closest_s, |chord| chord.exit_s);
        let lit = look.is_lit(enter_s, exit_s);
        if !(lit || options.include_dark) {
            return Ok(None);
        }

        let middle_s = 0.5 * (enter_s + exit_s);
        let element_age_days = age_days(middle_s);
        let (Some(enter), Some(mid), Some(exit)) = (look.point(enter_s), look.point(middle_s), look.point(exit_s))
        else {
            return Ok(None);
        };
        let cross_track_sigma_rad = sigma.cross_track_km / mid.range_km;
        let reach_s = reach_s(sigma.along_track_s);
        if crossing.chords.is_empty() && flight.is_some() && !may_cross(&line, run, field, &sigma) {
            return Ok(None);
        }
        let opened_s = seconds_between(scene.start, exposure.start);
        // Elements that break down just outside the exposure say nothing of near misses; the nominal crossing stands.
        let probability = match arc_over(run.start_s - reach_s, run.end_s + reach_s) {
            Ok(wide) if flight.is_some() => {
                let line = SightLine { arc: &wide, observer: line.observer.clone() };
                crossing_probability_in_flight(
                    &|time_s, late_s| line.sight_of_late(time_s, late_s),
                    (run.start_s, run.end_s),
                    field,
                    sigma.along_track_s,
                    cross_track_sigma_rad,
                )
            }
            Ok(wide) => {
                // A satellite that a delay brings into the exposure is seen from where the site is then.
                let closed_s = opened_s + exposure.duration_s;
                let line = SightLine { arc: &wide, observer: line.observer.still_outside(opened_s, closed_s) };
                crossing_probability(
                    &|time_s| line.sight(time_s),
                    (run.start_s - reach_s, run.end_s + reach_s),
                    (opened_s, closed_s),
                    field,
                    sigma.along_track_s,
                    cross_track_sigma_rad,
                )
            }
            Err(_) => f64::from(u8::from(!crossing.chords.is_empty())),
        };
        if crossing.chords.is_empty() && wanted.is_none_or(|least| probability < least) {
            return Ok(None);
        }
        let (position_angle_rad, angular_rate_rad_s) = look.motion(middle_s);
        Ok(Some(FieldPass {
            norad_id: propagator.norad_id(),
            element_index: run.element_index,
            peak: look.peak(enter_s, exit_s),
            samples: look.samples(enter_s, exit_s, options.samples),
            streak_length_rad: crossing.chords.iter().map(|chord| look.length_rad(chord)).sum(),
            chords: crossing
                .chords
                .iter()
                .map(|chord| Chord { enter_s: chord.enter_s - opened_s, exit_s: chord.exit_s - opened_s })
                .collect(),
            enter,
            mid,
            exit,
            min_separation_rad: crossing.min_separation_rad,
            position_angle_rad,
            angular_rate_rad_s,
            element_age_days,
            along_track_sigma_s: sigma.along_track_s,
            cross_track_sigma_rad,
            probability,
            lit,
        }))
    }
}

/// Whether errors of the elements can bring a satellite into the field at all, for an observer in orbit: a few looks that spare many.
fn may_cross(line: &SightLine<'_>, run: &Run, field: &FieldOnSky, sigma: &OrbitUncertainty) -> bool {
    let mut time_s = run.start_s;
    loop {
        let sight = line.sight(time_s);
        let (state, _, aspect) = line.aspect_at(time_s);
        // A late satellite stands elsewhere on its curved way, never farther than this.
        let strayed_km =
            1.1 * state.velocity.norm_km_s() * reach_s(sigma.along_track_s) + 1.5 * REACH_SIGMAS * sigma.cross_track_km;
        let relative_km_s = sight.rate_s.norm() * aspect.range_km;
        let step_s = (0.1 * aspect.range_km / relative_km_s.max(1e-6)).clamp(0.05, 5.0);
        let reach_rad = ((strayed_km + relative_km_s * step_s) / aspect.range_km).min(1.0).asin();
        let angle_rad = aspect.direction.vector().angle(field.centre());
        if angle_rad <= field.bounding_radius_rad() + 1.1 * reach_rad {
            return true;
        }
        if time_s >= run.end_s {
            return false;
        }
        time_s = (time_s + step_s).min(run.end_s);
    }
}

fn check(exposure: &Exposure) -> Result<(), SkyError> {
    let fail = |problem: String| Err(SkyError::Exposure { id: exposure.id.clone(), problem });
    if !(exposure.duration_s >= 0.0 && exposure.duration_s.is_finite()) {
        return fail(format!("a duration of {} s (allowed: 0 or more)", exposure.duration_s));
    }
    if !(exposure.pointing.vector().norm() - 1.0).abs().lt(&1e-6) || !exposure.rotation_rad.is_finite() {
        return fail("a pointing or rotation that is not a number".to_owned());
    }
    check_epoch(exposure.start)
}

/// Holds a moment against the years of the Sun's ephemeris.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), SkyError> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(SkyError::NoEphemeris { epoch }) } else { Ok(()) }
}
