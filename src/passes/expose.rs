//! One exposure of a sky: the cull slice by slice, then the exact answer for the few satellites that are left.

use std::sync::Arc as Shared;

use super::crossing::cross;
use super::exposure::Exposure;
use super::field::{Field, FieldOnSky};
use super::look::{LOWEST_ALTITUDE_RAD, Look};
use super::probability::{REACH_SIGMAS, crossing_probability, crossing_probability_in_flight, reach_s};
use super::scene::Scene;
use super::sightline::SightLine;
use super::sky::{PassOptions, Sky, SkyError};
use super::track::{Chord, FieldPass};
use crate::constants::{DAY_S, EARTH_ROTATION_RAD_S};
use crate::frames::{Direction, Orientation, seconds_after, seconds_between};
use crate::orbit::{Arc, Candidate, Cone, Cones, LeftOut, OrbitError, OrbitUncertainty, Shade, Window};

/// The cull asks for at most this long at a time, seconds: by then an observer on the ground has moved 14 km to each side.
const SLICE_S: f64 = 60.0;
/// The same for an observer in orbit, who has moved 40 km by then.
const FLIGHT_SLICE_S: f64 = 10.0;
/// So many slices are first asked about together: the two tests cost least together there.
const GROUP: u32 = 5;
/// A satellite that is a candidate again within this time is still on the same pass, seconds: nothing comes round so soon.
const SAME_PASS_S: f64 = 1200.0;
/// Satellites are looked for so much longer than they may be near, seconds.
const NEAR_MARGIN_S: f64 = 0.5;
/// The Sun's motion among the stars, rad/s: 1.02 degrees a day at most.
const SUN_RATE_RAD_S: f64 = 2.1e-7;
/// Aberration (21") and light time (6") between the astrometric axis and the geometric cone, with room, radians.
pub(super) const ABERRATION_MARGIN_RAD: f64 = 2e-4;

/// The slices of one exposure in which one satellite was a candidate, from the first to the last of one pass; seconds of the
/// scene.
pub(super) struct Run {
    pub element_index: usize,
    pub start_s: f64,
    pub end_s: f64,
    /// From when to when it may be in the field, if it is not late: a part of the slices.
    pub near_s: [f64; 2],
    /// True where it is in the Earth's shadow all the time.
    is_dark: bool,
}

impl Run {
    /// Over a stretch of time, whatever the light.
    pub fn over(element_index: usize, start_s: f64, end_s: f64) -> Self {
        Self { element_index, start_s, end_s, near_s: [start_s, end_s], is_dark: false }
    }
}

/// What becomes of satellites that are dark all along.
#[derive(Copy, Clone, PartialEq, Eq)]
pub(super) enum Dark {
    Wanted,
    /// Nobody asks SGP4 about those that are deep in the shadow.
    LeftOut,
}

impl Sky {
    /// One exposure: cull slice by slice, then the exact answer for the few that are left.
    pub(super) fn expose(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &Field,
        options: &PassOptions,
        seen: &mut Vec<Candidate>,
    ) -> Result<(Vec<FieldPass>, Vec<LeftOut>), SkyError> {
        let flight = self.flight(scene, exposure)?;
        let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
        let mut passes = Vec::new();
        let mut left_out = Vec::new();
        let dark = if options.include_dark { Dark::Wanted } else { Dark::LeftOut };
        for run in self.runs(scene, exposure, &on_sky, flight.as_ref(), dark, seen) {
            match self.pass(scene, exposure, &on_sky, &run, flight.as_ref(), options) {
                Ok(pass) => passes.extend(pass),
                Err(reason) => left_out.push(LeftOut {
                    norad_id: self.elements()[run.element_index].norad_id,
                    element_index: run.element_index,
                    reason,
                }),
            }
        }
        passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
        Ok((passes, left_out))
    }

    /// Which satellites may be in the field, and when: candidates of slices that belong together joined. `seen` is room for them.
    pub(super) fn runs(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        flight: Option<&Shared<Arc>>,
        dark: Dark,
        seen: &mut Vec<Candidate>,
    ) -> Vec<Run> {
        let start_s = seconds_between(scene.start, exposure.start);
        let longest_s = if flight.is_some() { FLIGHT_SLICE_S } else { SLICE_S };
        let slices = (exposure.duration_s / longest_s).ceil().max(1.0);
        let slice_s = exposure.duration_s / slices;
        // The cone around a moment, the window it lies in, and how the Earth stands then.
        let cone = |mid_s: f64, half_s: f64| {
            let (window, window_start_s) = scene.window_at(mid_s)?;
            let orientation = scene.orientation.at_s(mid_s);
            let motion = self.motion(scene, &orientation, flight, mid_s)?;
            let cone = Cone {
                mid_s: mid_s - window_start_s,
                half_duration_s: half_s,
                observer: motion.position(mid_s),
                observer_speed_km_s: motion.fastest_km_s(mid_s, half_s),
                axis: exposure.pointing,
                radius_rad: field.bounding_radius_rad() + ABERRATION_MARGIN_RAD,
            };
            Some((window, cone, orientation.teme_to_gcrs))
        };
        let shade = (dark == Dark::LeftOut).then(|| {
            let (radius_km, narrowing) = self.shadow().dark_core();
            let sun = scene.sun.at_s(start_s + 0.5 * exposure.duration_s).sun;
            // The Sun moves by this while the exposure lasts: a share of the depth.
            let narrowing = narrowing + SUN_RATE_RAD_S * exposure.duration_s;
            Shade { away_from_sun: Direction::from_vector(-sun.vector()), radius_km, narrowing }
        });
        let shade = shade.as_ref();
        seen.clear();
        // A telescope in orbit moves too far for groups.
        let most = if flight.is_some() { 1 } else { GROUP };
        let mut first = 0;
        while first < slices as u32 {
            let group = most.min(slices as u32 - first);
            let half_s = 0.5 * slice_s * f64::from(group);
            if self.is_below_ground(scene, exposure, field, start_s + slice_s * f64::from(first) + half_s, half_s) {
                first += group;
                continue;
            }
            let whole = cone(start_s + slice_s * f64::from(first) + half_s, half_s);
            let parts: Vec<_> = (first..first + group)
                .map(|part| cone(start_s + slice_s * (f64::from(part) + 0.5), 0.5 * slice_s))
                .collect();
            // All of them in one window.
            let of_window = |window: &Window| -> Option<Vec<Cone>> {
                let is_there = |of_part: &Window| std::ptr::eq(of_part, window);
                parts.iter().map(|part| part.as_ref().filter(|part| is_there(part.0)).map(|part| part.1)).collect()
            };
            match whole
                .filter(|_| group > 1)
                .and_then(|(window, whole, teme)| Some((window, whole, of_window(window)?, teme)))
            {
                Some((window, whole, parts, teme_to_gcrs)) => {
                    window.candidates(&Cones { whole: &whole, parts: &parts, first, shade }, &teme_to_gcrs, seen);
                }
                _ => {
                    for (number, part) in (first..).zip(&parts) {
                        let Some((window, part, teme_to_gcrs)) = part else { continue };
                        window.candidates(&Cones { whole: part, parts: &[], first: number, shade }, teme_to_gcrs, seen);
                    }
                }
            }
            first += group;
        }
        seen.retain(|candidate| !self.is_observer(candidate.element_index as usize));
        seen.sort_unstable_by_key(|candidate| (candidate.element_index, candidate.cone));
        let mut runs: Vec<Run> = Vec::new();
        for candidate in seen.iter() {
            let element_index = candidate.element_index as usize;
            let slice = candidate.cone;
            let (from_s, end_s) = (start_s + slice_s * f64::from(slice), start_s + slice_s * f64::from(slice + 1));
            let near = candidate.near_s.map(|time_s| 0.5 * (from_s + end_s) + f64::from(time_s));
            let near_s = [(near[0] - NEAR_MARGIN_S).max(from_s), (near[1] + NEAR_MARGIN_S).min(end_s)];
            match runs.last_mut() {
                Some(run) if run.element_index == element_index && from_s - run.end_s < SAME_PASS_S => {
                    run.end_s = end_s;
                    run.near_s[1] = near_s[1];
                    run.is_dark &= candidate.is_dark;
                }
                _ => runs.push(Run { element_index, start_s: from_s, end_s, near_s, is_dark: candidate.is_dark }),
            }
        }
        // A pass that is lit for a part of its way is asked about as a whole.
        runs.retain(|run| !run.is_dark);
        runs
    }

    /// True where any of the field may lie below the lowest altitude at any time of the exposure; in orbit the Earth is always near.
    pub(super) fn reaches_the_ground(
        &self,
        exposure: &Exposure,
        field: &FieldOnSky,
        orientation: &Orientation,
    ) -> bool {
        let Some(altitude_rad) = self.altitude_rad(exposure, orientation) else { return true };
        // The sky turns by no more than this, whatever the exposure's length.
        let turn_rad = (EARTH_ROTATION_RAD_S * exposure.duration_s).min(std::f64::consts::PI);
        altitude_rad - field.bounding_radius_rad() - turn_rad < LOWEST_ALTITUDE_RAD
    }

    /// True where all of the field lies below the lowest altitude for `half_s` before and after a moment: nobody crosses it there.
    fn is_below_ground(&self, scene: &Scene, exposure: &Exposure, field: &FieldOnSky, mid_s: f64, half_s: f64) -> bool {
        let reach_rad = field.bounding_radius_rad() + ABERRATION_MARGIN_RAD + EARTH_ROTATION_RAD_S * half_s;
        self.altitude_rad(exposure, &scene.orientation.at_s(mid_s))
            .is_some_and(|altitude_rad| altitude_rad + reach_rad < LOWEST_ALTITUDE_RAD)
    }

    /// Altitude of the pointing at a moment; none in orbit.
    fn altitude_rad(&self, exposure: &Exposure, orientation: &Orientation) -> Option<f64> {
        let observer = self.viewpoint().site()?;
        Some((observer.state(orientation).horizon * exposure.pointing).latitude_rad())
    }

    /// The exact answer for one satellite; `None` where it is not wanted.
    pub(super) fn pass(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        run: &Run,
        flight: Option<&Shared<Arc>>,
        options: &PassOptions,
    ) -> Result<Option<FieldPass>, OrbitError> {
        let mid_s = 0.5 * (run.start_s + run.end_s);
        let Some(propagator) = self.index().propagator(run.element_index) else { return Ok(None) };
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
            viewpoint: self.viewpoint(),
            shadow: self.shadow(),
            line: &line,
            model: self.model(run.element_index),
            options,
            uncertainty: sigma,
        };
        let near_the_ground = self.reaches_the_ground(exposure, field, &orientation);
        let Some((enter_s, exit_s)) = look.keep_above_ground(&mut crossing, near_the_ground) else { return Ok(None) };
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
