//! Candidate satellites of one exposure: the exposure is divided into slices, a search cone is made for each, and each
//! candidate gets a time interval.

use std::sync::Arc;

use super::evaluator::LOWEST_ALTITUDE_RAD;
use super::exposure::Exposure;
use super::field::FieldOnSky;
use super::scene::Scene;
use super::sky::Sky;
use super::track::ObserverMotion;
use crate::constants::EARTH_ROTATION_RAD_S;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, Orientation, Rotation, Teme, seconds_between};
use crate::geometry::ShadowModel;
use crate::orbit::{Cone, Cones, CrossingCandidate, OrbitArc, ShadowCone, Window};

/// Longest slice of an exposure that is searched with one position of an observer on the ground, seconds. From the
/// middle of the slice to its ends the observer moves by 14 km.
const SLICE_S: f64 = 60.0;
/// Longest slice for an observer in orbit, seconds. From the middle of the slice to its ends the observer moves by 40
/// km.
const FLIGHT_SLICE_S: f64 = 10.0;
/// Number of slices that are tested together before each is tested separately; this number was measured to be the
/// fastest.
const GROUP: u32 = 5;
/// Longest interruption of one pass, seconds. No satellite completes a revolution in this time, so a satellite that
/// reappears sooner is still on the same pass.
const SAME_PASS_S: f64 = 1200.0;
/// Largest rate of the Sun relative to the stars, rad/s (1.02 degrees a day).
const SUN_RATE_RAD_S: f64 = 2.1e-7;
/// Margin for aberration (21") and light time (6") between the astrometric axis and the geometric cone, radians.
pub(super) const ABERRATION_MARGIN_RAD: f64 = 2e-4;

/// Time interval in which one satellite may cross the field during one pass. It consists of whole slices of the
/// exposure. Times are seconds after the start of the scene.
pub(super) struct CandidateInterval {
    pub element_index: usize,
    pub start_s: f64,
    pub end_s: f64,
    /// Interval in which the predicted position may be in the field. It extends beyond the slices by the delays that
    /// are searched.
    pub near_s: [f64; 2],
    /// True if the satellite is in the Earth's shadow during the whole interval.
    is_dark: bool,
}

impl CandidateInterval {
    /// Creates an interval for a satellite that is evaluated without a search.
    pub fn over(element_index: usize, start_s: f64, end_s: f64) -> Self {
        Self { element_index, start_s, end_s, near_s: [start_s, end_s], is_dark: false }
    }
}

/// Search cone with the window that contains its time, and the orientation of the Earth.
pub(super) struct PlacedCone<'a> {
    pub window: &'a Window,
    pub cone: Cone,
    pub teme_to_gcrs: Rotation<Teme, Gcrs>,
}

impl Sky {
    /// Returns the search cone of a field from `half_s` before to `half_s` after a time.
    pub(super) fn cone<'a>(
        &self,
        scene: &'a Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        (motion, orientation): (&ObserverMotion, &Orientation),
        (mid_s, half_s): (f64, f64),
    ) -> Option<PlacedCone<'a>> {
        let (window, window_start_s) = scene.window_at(mid_s)?;
        let cone = Cone {
            mid_s: mid_s - window_start_s,
            half_duration_s: half_s,
            observer: motion.position(mid_s),
            observer_speed_km_s: motion.fastest_km_s(mid_s, half_s),
            axis: exposure.pointing,
            radius_rad: field.bounding_radius_rad() + ABERRATION_MARGIN_RAD,
        };
        Some(PlacedCone { window, cone, teme_to_gcrs: orientation.teme_to_gcrs })
    }

    /// Returns the part of the Earth's shadow in which no satellite is lit at any time of an exposure.
    pub(super) fn dark_cone(&self, scene: &Scene, exposure: &Exposure) -> ShadowCone {
        let (radius_km, narrowing) = ShadowModel::dark_core();
        let sun = scene.sun.at_s(seconds_between(scene.start, exposure.start) + 0.5 * exposure.duration_s).sun;
        // The Sun moves during the exposure, which narrows the dark cone by a fraction of the depth.
        let narrowing = narrowing + SUN_RATE_RAD_S * exposure.duration_s;
        ShadowCone { away_from_sun: Direction::from_vector(-sun.vector()), radius_km, narrowing }
    }

    /// Returns the satellites that may be in the field during an exposure, with their time intervals. Satellites in
    /// shadow are included only with `include_dark`. `seen` is a buffer that is reused.
    pub(super) fn candidate_intervals(
        &self,
        scene: &Scene,
        exposure: &Exposure,
        field: &FieldOnSky,
        flight: Option<&Arc<OrbitArc>>,
        include_dark: bool,
        seen: &mut Vec<CrossingCandidate>,
    ) -> Result<Vec<CandidateInterval>, Error> {
        let start_s = seconds_between(scene.start, exposure.start);
        let longest_s = if flight.is_some() { FLIGHT_SLICE_S } else { SLICE_S };
        let slices = (exposure.duration_s / longest_s).ceil().max(1.0);
        let slice_s = exposure.duration_s / slices;
        let cone = |mid_s: f64, half_s: f64| {
            let orientation = scene.orientation.at_s(mid_s);
            let motion = self.motion(scene, &orientation, flight, mid_s)?;
            self.cone(scene, exposure, field, (&motion, &orientation), (mid_s, half_s))
        };
        let shadow = (!include_dark).then(|| self.dark_cone(scene, exposure));
        let (shadow, scope) = (shadow.as_ref(), scene.scope);
        seen.clear();
        // A telescope in orbit moves too far during several slices, so its slices are not grouped.
        let most = if flight.is_some() { 1 } else { GROUP };
        let mut first = 0;
        while first < slices as u32 {
            self.watch().check()?;
            let group = most.min(slices as u32 - first);
            let half_s = 0.5 * slice_s * f64::from(group);
            let mid_s = start_s + slice_s * f64::from(first) + half_s;
            if self.is_below_ground(scene, exposure, field, mid_s, half_s) {
                first += group;
                continue;
            }
            let parts: Vec<_> = (first..first + group)
                .map(|part| cone(start_s + slice_s * (f64::from(part) + 0.5), 0.5 * slice_s))
                .collect();
            // A group is tested together only if all its slices are in one window.
            let of_window = |window: &Window| -> Option<Vec<Cone>> {
                let is_there = |part: &&PlacedCone<'_>| std::ptr::eq(part.window, window);
                parts.iter().map(|part| part.as_ref().filter(is_there).map(|part| part.cone)).collect()
            };
            let whole = if group > 1 { cone(mid_s, half_s) } else { None };
            match whole.and_then(|whole| of_window(whole.window).map(|parts| (whole, parts))) {
                Some((PlacedCone { window, cone, teme_to_gcrs }, parts)) => {
                    window.candidates(
                        &Cones { whole: &cone, parts: &parts, first, shadow, scope },
                        &teme_to_gcrs,
                        seen,
                    );
                }
                None => {
                    for (number, part) in (first..).zip(&parts) {
                        let Some(PlacedCone { window, cone, teme_to_gcrs }) = part else { continue };
                        window.candidates(
                            &Cones { whole: cone, parts: &[], first: number, shadow, scope },
                            teme_to_gcrs,
                            seen,
                        );
                    }
                }
            }
            first += group;
        }
        seen.retain(|candidate| !self.is_observer(candidate.element_index as usize));
        seen.sort_unstable_by_key(|candidate| (candidate.element_index, candidate.cone));
        let mut intervals: Vec<CandidateInterval> = Vec::new();
        for candidate in seen.iter() {
            let element_index = candidate.element_index as usize;
            let slice = candidate.cone;
            let (from_s, end_s) = (start_s + slice_s * f64::from(slice), start_s + slice_s * f64::from(slice + 1));
            let near_s = candidate.near_s.map(|time_s| 0.5 * (from_s + end_s) + f64::from(time_s));
            match intervals.last_mut() {
                Some(last) if last.element_index == element_index && from_s - last.end_s < SAME_PASS_S => {
                    last.end_s = end_s;
                    last.near_s = [last.near_s[0].min(near_s[0]), last.near_s[1].max(near_s[1])];
                    last.is_dark &= candidate.is_dark;
                }
                _ => intervals.push(CandidateInterval {
                    element_index,
                    start_s: from_s,
                    end_s,
                    near_s,
                    is_dark: candidate.is_dark,
                }),
            }
        }
        // A pass that is partly lit is evaluated as a whole.
        intervals.retain(|interval| !interval.is_dark);
        Ok(intervals)
    }

    /// Returns true if a part of the field may be below the lowest altitude during the exposure; always true for an
    /// observer in orbit.
    pub(super) fn reaches_the_ground(
        &self,
        exposure: &Exposure,
        field: &FieldOnSky,
        orientation: &Orientation,
    ) -> bool {
        let Some(altitude_rad) = self.pointing_altitude_rad(exposure, orientation) else { return true };
        // Largest rotation of the sky during the exposure.
        let turn_rad = (EARTH_ROTATION_RAD_S * exposure.duration_s).min(std::f64::consts::PI);
        altitude_rad - field.bounding_radius_rad() - turn_rad < LOWEST_ALTITUDE_RAD
    }

    /// Returns true if the whole field is below the lowest altitude from `half_s` before to `half_s` after a time.
    fn is_below_ground(&self, scene: &Scene, exposure: &Exposure, field: &FieldOnSky, mid_s: f64, half_s: f64) -> bool {
        let reach_rad = field.bounding_radius_rad() + ABERRATION_MARGIN_RAD + EARTH_ROTATION_RAD_S * half_s;
        self.pointing_altitude_rad(exposure, &scene.orientation.at_s(mid_s))
            .is_some_and(|altitude_rad| altitude_rad + reach_rad < LOWEST_ALTITUDE_RAD)
    }

    /// Returns the altitude of the pointing, radians; `None` for an observer in orbit.
    fn pointing_altitude_rad(&self, exposure: &Exposure, orientation: &Orientation) -> Option<f64> {
        let observer = self.viewpoint().site()?;
        Some((observer.state(orientation).horizon * exposure.pointing).latitude_rad())
    }
}
