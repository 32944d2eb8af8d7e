//! How likely any satellite is in an exposure, and how much streak is to be expected, however old the elements are.
//!
//! A satellite may be so early or late that its prediction stands far from the field, or on the other side of the Earth. What
//! counts is that its path leads through the field, and by which delays it does. For each satellite whose orbit plane passes the
//! field:
//!
//! 1. From the middle of the exposure along the orbit (two-body arithmetic, refined with SGP4) to the place where it passes
//!    the line of sight, and the same place some revolutions before and after, as far as 3.5 sigma reach.
//! 2. There, the exact chords of [`crossing_odds`].
//!
//! What is left out: delays beyond 3.5 sigma (0.05 % of each satellite's chance). What is simplified: the planes do not turn during the
//! delay (5° a day at most), and the site stands still before and after the exposure. For a telescope in orbit only the passes and
//! near misses of [`Sky::field_passes`] are summed.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use rayon::prelude::*;

use super::crossing::{Crossing, cross};
use super::expose::{ABERRATION_MARGIN_RAD, SLICE_S};
use super::exposure::Exposure;
use super::field::{Field, FieldOnSky};
use super::look::LOWEST_ALTITUDE_RAD;
use super::probability::{Odds, REACH_SIGMAS, Sigmas, crossing_odds};
use super::scene::{Scene, end_s, groups};
use super::sightline::{ObserverMotion, SightLine};
use super::sky::{PassOptions, Sky, SkyError, check};
use super::track::FieldPass;
use super::windows::Wanted;
use crate::constants::{DAY_S, WGS72_MU_KM3_S2};
use crate::frames::{Gcrs, Orientation, Position, seconds_after, seconds_between};
use crate::geometry::{Observer, ShadowModel};
use crate::orbit::{Arc, Cone, OrbitUncertainty, Propagator, Reach};

/// In an exposure longer than this the site moves too far for one place on the orbit; then all of the time is searched, seconds.
const LONG_EXPOSURE_S: f64 = 600.0;
/// And so it is, up to this delay, on an orbit whose place in the field is not found (eccentric ones near the horizon), seconds.
const LONGEST_BLIND_REACH_S: f64 = 1200.0;
/// From an orbit, passes less probable than this are not looked for.
const LEAST_IN_FLIGHT: f64 = 0.01;
/// Points along a path at which light is looked for, as for a crossing.
const LIGHT_STEPS: u32 = 24;
/// Steps towards the place on the orbit; circular orbits need two.
const MOST_STEPS: usize = 8;
/// That place is known well enough to this, seconds: the chords are then cut exactly.
const PLACE_S: f64 = 1.0;
/// All of a stretch up to this long is looked at without looking for a place first, seconds.
const SHORT_S: f64 = 40.0;
/// A stretch around that place is made twice as long until both of its ends lie outside the field, at most this often.
const MOST_DOUBLINGS: usize = 6;

/// One satellite that may be in one exposure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Chance {
    /// Which of the sky's element sets.
    pub element_index: usize,
    /// Probability that it is in the field at any time of the exposure, (0, 1].
    pub probability: f64,
    /// Expected length of its streak within the field, radians: the average over all its errors, 0 for those that lead past.
    pub streak_length_rad: f64,
    /// How far away it is where its path is nearest to the centre of the field, km.
    pub range_km: f64,
}

impl Sky {
    /// Every satellite that may be in each exposure while the Sun shines on it, with its probability; by exposure, in catalogue order.
    ///
    /// With fresh elements these are little more than the nominal crossings. With elements months old they are all satellites whose
    /// orbits lead through the field, each with a small chance.
    ///
    /// # Errors
    /// [`SkyError`] where an exposure has no finite length, pointing or rotation, or lies outside the years of the Sun's ephemeris.
    pub fn chances(&self, exposures: &[Exposure], field: &Field) -> Result<Vec<Vec<Chance>>, SkyError> {
        for exposure in exposures {
            check(exposure)?;
        }
        let Some(observer) = self.viewpoint().site() else { return self.chances_in_flight(exposures, field) };
        let mut by_exposure = vec![Vec::new(); exposures.len()];
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let span_s = group.iter().map(|&one| end_s(start, &exposures[one])).fold(0.0, f64::max);
            let mut scene = self.scene_without_windows(start, span_s);
            let reach = |sigma: OrbitUncertainty| Reach {
                along_track_s: REACH_SIGMAS * sigma.along_track_s,
                cross_track_km: REACH_SIGMAS * sigma.cross_track_km,
            };
            scene.windows = self.windows_over(start, seconds_after(start, span_s), Wanted::Anyone, reach);
            let found: Vec<(usize, Vec<Chance>)> = group
                .par_iter()
                .map_init(Vec::new, |candidates, &one| {
                    (one, self.chances_of(&scene, observer, &exposures[one], field, candidates))
                })
                .collect();
            for (one, chances) in found {
                by_exposure[one] = chances;
            }
        }
        Ok(by_exposure)
    }

    /// From an orbit, where a late satellite takes another way through the field: the passes and near misses that are found there, a few
    /// minutes early or late at most.
    fn chances_in_flight(&self, exposures: &[Exposure], field: &Field) -> Result<Vec<Vec<Chance>>, SkyError> {
        let options = PassOptions { min_probability: Some(LEAST_IN_FLIGHT), ..PassOptions::default() };
        let passes = self.field_passes(exposures, field, &options)?.by_exposure;
        // The mean chord of a circle is π/2 of its radius.
        let mean_chord_rad = std::f64::consts::FRAC_PI_2 * field.bounding_radius_rad();
        let length_rad = |pass: &FieldPass, exposure: &Exposure| {
            if pass.is_crossing() {
                pass.streak_length_rad
            } else {
                mean_chord_rad.min(pass.angular_rate_rad_s * exposure.duration_s)
            }
        };
        let of = |(passes, exposure): (Vec<FieldPass>, &Exposure)| {
            let mut chances: Vec<Chance> = passes
                .iter()
                .filter(|pass| pass.lit && pass.probability > 0.0)
                .map(|pass| Chance {
                    element_index: pass.element_index,
                    probability: pass.probability,
                    streak_length_rad: pass.probability * length_rad(pass, exposure),
                    range_km: pass.mid.range_km,
                })
                .collect();
            chances.sort_by_key(|chance| chance.element_index);
            chances
        };
        Ok(passes.into_iter().zip(exposures).map(of).collect())
    }

    fn uncertainty_at(&self, element_index: usize, age_s: f64) -> OrbitUncertainty {
        self.uncertainty(element_index, age_s / DAY_S)
    }

    fn chances_of(
        &self,
        scene: &Scene,
        observer: &Observer,
        exposure: &Exposure,
        field: &Field,
        candidates: &mut Vec<u32>,
    ) -> Vec<Chance> {
        let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
        let opened_s = seconds_between(scene.start, exposure.start);
        let closed_s = opened_s + exposure.duration_s;
        let slices = (exposure.duration_s / SLICE_S).ceil().max(1.0);
        let slice_s = exposure.duration_s / slices;
        let mut seen: Vec<u32> = Vec::new();
        for slice in 0..slices as u32 {
            let mid_s = opened_s + slice_s * (f64::from(slice) + 0.5);
            let Some((window, window_start_s)) = scene.window_at(mid_s) else { continue };
            let orientation = scene.orientation.at_s(mid_s);
            let site = ObserverMotion::of_site(observer, &orientation, scene.sun.at_s(mid_s).earth_velocity, mid_s);
            let cone = Cone {
                mid_s: mid_s - window_start_s,
                half_duration_s: 0.5 * slice_s,
                observer: site.position(mid_s),
                observer_speed_km_s: site.fastest_km_s(mid_s, 0.5 * slice_s),
                axis: exposure.pointing,
                radius_rad: on_sky.bounding_radius_rad() + ABERRATION_MARGIN_RAD,
            };
            window.candidates(&cone, &orientation.teme_to_gcrs, candidates);
            seen.extend_from_slice(candidates);
        }
        seen.sort_unstable();
        seen.dedup();
        let mid_s = 0.5 * (opened_s + closed_s);
        let orientation = scene.orientation.at_s(mid_s);
        let earth_velocity = scene.sun.at_s(mid_s).earth_velocity;
        let site =
            ObserverMotion::of_site(observer, &orientation, earth_velocity, mid_s).still_outside(opened_s, closed_s);
        let question = Question {
            scene,
            shadow: self.shadow(),
            field: &on_sky,
            site,
            orientation: &orientation,
            opened_s,
            closed_s,
        };
        let horizon = observer.state(&orientation);
        let sine_of_lowest = LOWEST_ALTITUDE_RAD.sin();
        seen.into_iter()
            .filter_map(|element_index| {
                let element_index = element_index as usize;
                let propagator = self.index().propagator(element_index)?;
                let age_s = seconds_between(propagator.epoch(), seconds_after(scene.start, mid_s));
                let place = question.odds(propagator, self.uncertainty_at(element_index, age_s))?;
                let is_up = horizon.sine_of_altitude(&place.geometric) >= sine_of_lowest;
                is_up.then_some(Chance {
                    element_index,
                    probability: place.odds.probability.min(1.0),
                    streak_length_rad: place.odds.streak_length_rad,
                    range_km: place.range_km,
                })
            })
            .collect()
    }
}

/// One exposure, with what all satellites in it share.
struct Question<'a> {
    scene: &'a Scene,
    shadow: ShadowModel,
    field: &'a FieldOnSky<'a>,
    /// Standing still outside of the exposure.
    site: ObserverMotion,
    orientation: &'a Orientation,
    opened_s: f64,
    closed_s: f64,
}

/// Where a satellite passes the line of sight.
#[derive(Copy, Clone)]
struct Nearest {
    time_s: f64,
    period_s: f64,
    distance_km: f64,
    /// Speed across the line of sight.
    rate_rad_s: f64,
}

/// What is expected of one satellite, and from where it comes.
struct Place {
    odds: Odds,
    geometric: Position<Gcrs>,
    range_km: f64,
}

impl Question<'_> {
    /// `None` where the satellite has no chance, or is dark.
    fn odds(&self, propagator: &Propagator, sigma: OrbitUncertainty) -> Option<Place> {
        let minutes = propagator.minutes_since_epoch(self.scene.start);
        let reach_s = REACH_SIGMAS * sigma.along_track_s;
        let (first_s, last_s) = (self.opened_s - reach_s, self.closed_s + reach_s);
        let arc = |from_s: f64, to_s: f64| {
            Arc::new(propagator, minutes, from_s, to_s - from_s, &self.orientation.teme_to_gcrs).ok()
        };
        if last_s - first_s <= SHORT_S || self.closed_s - self.opened_s > LONG_EXPOSURE_S {
            return self.on_arc(&arc(first_s, last_s)?, (first_s, last_s), sigma);
        }
        let mid_s = 0.5 * (self.opened_s + self.closed_s);
        let Some(nearest) = self.nearest(propagator, minutes, mid_s) else {
            let blind_s = reach_s.min(LONGEST_BLIND_REACH_S);
            let (first_s, last_s) = (self.opened_s - blind_s, self.closed_s + blind_s);
            return self.on_arc(&arc(first_s, last_s)?, (first_s, last_s), sigma);
        };
        let mut best: Option<Place> = None;
        let period_s = nearest.period_s;
        let turns = (reach_s / period_s).ceil() as i32;
        for turn in -turns..=turns {
            let guess_s = nearest.time_s + f64::from(turn) * period_s;
            let there = match turn {
                0 => nearest,
                _ if guess_s < first_s - 0.1 * period_s || guess_s > last_s + 0.1 * period_s => continue,
                _ => self.nearest(propagator, minutes, guess_s).unwrap_or(Nearest { time_s: guess_s, ..nearest }),
            };
            // Half of the time that it needs through the field and its errors, doubled where it comes nearer on the way.
            let half_s = 2.0
                * (self.field.bounding_radius_rad() + REACH_SIGMAS * sigma.cross_track_km / there.distance_km)
                / there.rate_rad_s
                + 1.0;
            if there.time_s < first_s - half_s || there.time_s > last_s + half_s {
                continue;
            }
            let Some(place) = self.around(&arc, &there, half_s, sigma) else { continue };
            match &mut best {
                Some(best) => {
                    // Delays of different revolutions exclude one another.
                    best.odds.probability += place.odds.probability;
                    best.odds.streak_length_rad += place.odds.streak_length_rad;
                }
                None => best = Some(place),
            }
        }
        best
    }

    /// The stretch around a place, made longer until both ends lie outside of the field.
    fn around(
        &self,
        arc: &impl Fn(f64, f64) -> Option<Arc>,
        place: &Nearest,
        mut half_s: f64,
        sigma: OrbitUncertainty,
    ) -> Option<Place> {
        for doubling in 0.. {
            half_s = half_s.min(0.25 * place.period_s);
            let (from_s, to_s) = (place.time_s - half_s, place.time_s + half_s);
            let stretch = arc(from_s, to_s)?;
            let line = SightLine { arc: &stretch, observer: self.site.clone() };
            let outside = |time_s: f64| {
                let (_, _, aspect) = line.aspect_at(time_s);
                let angle_rad = separation_rad(aspect.geometric.vector(), self.field.centre());
                angle_rad > self.field.bounding_radius_rad() + REACH_SIGMAS * sigma.cross_track_km / aspect.range_km
            };
            if doubling == MOST_DOUBLINGS || half_s >= 0.25 * place.period_s || (outside(from_s) && outside(to_s)) {
                return self.on_arc(&stretch, (from_s, to_s), sigma);
            }
            half_s *= 2.0;
        }
        None
    }

    fn on_arc(&self, arc: &Arc, searched_s: (f64, f64), sigma: OrbitUncertainty) -> Option<Place> {
        let line = SightLine { arc, observer: self.site.clone() };
        let track = |time_s: f64| line.sight(time_s);
        let nominal = cross(&track, searched_s.0, searched_s.1, self.field);
        let (_, _, aspect) = line.aspect_at(nominal.closest_s);
        let sigmas =
            Sigmas { along_track_s: sigma.along_track_s, cross_track_rad: sigma.cross_track_km / aspect.range_km };
        if nominal.min_separation_rad > self.field.bounding_radius_rad() + REACH_SIGMAS * sigmas.cross_track_rad {
            return None;
        }
        if !self.is_lit(arc, &nominal, searched_s, aspect.range_km) {
            return None;
        }
        let odds = crossing_odds(&track, &nominal, searched_s, (self.opened_s, self.closed_s), self.field, sigmas);
        (odds.probability > 0.0).then_some(Place { odds, geometric: aspect.geometric, range_km: aspect.range_km })
    }

    /// True where the exposure's Sun shines on the path anywhere within the field, or, for a path beside it, where it passes by.
    fn is_lit(&self, arc: &Arc, nominal: &Crossing, (from_s, to_s): (f64, f64), range_km: f64) -> bool {
        let sun = self.scene.sun.at_s(0.5 * (self.opened_s + self.closed_s)).sun;
        let at = |time_s: f64| self.shadow.illumination(&arc.state_at(time_s).position, &sun).lit_fraction() > 0.0;
        if at(nominal.closest_s) {
            return true;
        }
        let speed_km_s = arc.state_at(nominal.closest_s).velocity.vector().norm();
        let beside_s = self.field.bounding_radius_rad() * range_km / speed_km_s;
        let (enter_s, exit_s) = match (nominal.chords.first(), nominal.chords.last()) {
            (Some(first), Some(last)) => (first.enter_s, last.exit_s),
            _ => ((nominal.closest_s - beside_s).max(from_s), (nominal.closest_s + beside_s).min(to_s)),
        };
        (0..=LIGHT_STEPS).any(|step| at(enter_s + (exit_s - enter_s) * f64::from(step) / f64::from(LIGHT_STEPS)))
    }

    /// Where the satellite passes nearest to the line of sight on the revolution of `start_s`; `None` where that is not found.
    fn nearest(&self, propagator: &Propagator, minutes: f64, start_s: f64) -> Option<Nearest> {
        let mut time_s = start_s;
        for _ in 0..MOST_STEPS {
            let state = propagator.state_at_minutes(minutes + time_s / 60.0, &self.orientation.teme_to_gcrs).ok()?;
            let orbit = TwoBody::of(state.position.vector(), state.velocity.vector())?;
            let site = *self.site.position(time_s).vector();
            // |O + ρ d| = r, the farther of the two: from within the shell the only one ahead.
            let along_km = site.dot(self.field.centre());
            let square = along_km * along_km + state.position.vector().norm_squared() - site.norm_squared();
            let distance_km = -along_km + square.max(0.0).sqrt();
            let step_s = orbit.time_to_s(&(site + self.field.centre() * distance_km));
            time_s += step_s;
            if step_s.abs() < PLACE_S {
                let across =
                    state.velocity.vector() - self.field.centre() * state.velocity.vector().dot(self.field.centre());
                return Some(Nearest {
                    time_s,
                    period_s: orbit.period_s(),
                    distance_km,
                    rate_rad_s: (across.norm() / distance_km).max(1e-7),
                });
            }
        }
        None
    }
}

fn separation_rad(one: &Vector3<f64>, other: &Vector3<f64>) -> f64 {
    one.cross(other).norm().atan2(one.dot(other))
}

/// An osculating ellipse, and where on it the satellite is.
struct TwoBody {
    position: Vector3<f64>,
    normal: Vector3<f64>,
    /// Towards the perigee, as long as the eccentricity.
    eccentricity: Vector3<f64>,
    mean_motion_rad_s: f64,
}

impl TwoBody {
    /// `None` for an orbit that is not closed.
    fn of(position: &Vector3<f64>, velocity: &Vector3<f64>) -> Option<Self> {
        let momentum = position.cross(velocity);
        let radius_km = position.norm();
        // vis viva: 1/a = 2/r - v²/μ
        let axis_km = 1.0 / (2.0 / radius_km - velocity.norm_squared() / WGS72_MU_KM3_S2);
        let eccentricity = velocity.cross(&momentum) / WGS72_MU_KM3_S2 - position / radius_km;
        (axis_km > 0.0 && eccentricity.norm() < 1.0).then(|| Self {
            position: *position,
            normal: momentum.normalize(),
            eccentricity,
            mean_motion_rad_s: (WGS72_MU_KM3_S2 / axis_km.powi(3)).sqrt(),
        })
    }

    fn period_s(&self) -> f64 {
        TAU / self.mean_motion_rad_s
    }

    /// Mean anomaly of a direction in the plane, radians.
    fn mean_anomaly_rad(&self, direction: &Vector3<f64>) -> f64 {
        let e = self.eccentricity.norm();
        // A circle has no perigee; any direction will do.
        let x_axis = if e > 1e-9 { self.eccentricity / e } else { self.position.normalize() };
        let y_axis = self.normal.cross(&x_axis);
        let (x, y) = (direction.dot(&x_axis), direction.dot(&y_axis));
        let radius = x.hypot(y);
        // tan E = √(1 - e²) sin ν / (e + cos ν), M = E - e sin E
        let eccentric_rad = ((1.0 - e * e).sqrt() * y).atan2(e * radius + x);
        eccentric_rad - e * eccentric_rad.sin()
    }

    /// Time to the direction of a target, the shorter way round, seconds.
    fn time_to_s(&self, target: &Vector3<f64>) -> f64 {
        let turn_rad = self.mean_anomaly_rad(target) - self.mean_anomaly_rad(&self.position);
        ((turn_rad + PI).rem_euclid(TAU) - PI) / self.mean_motion_rad_s
    }
}
