//! Where one satellite's path meets a field, by which delays it leads through it, and what that makes likely.
//!
//! Up to an error along the track of [`LONG_DELAY_S`] the exact chords of the path are cut. Beyond it every revolution's path is a circle on
//! the sky ([`CirclePath`]) from one place of SGP4: the exposure meets hundreds of such satellites, each with a small chance, and the error of
//! a second in a chord is nothing against a delay of minutes.

use nalgebra::Vector3;

use super::crossing::{Crossing, cross};
use super::delays::{Delays, Odds};
use super::field::FieldOnSky;
use super::late_path::WIDE_KM;
use super::probability::{REACH_SIGMAS, crossing_odds};
use super::scene::Scene;
use super::sightline::{ObserverMotion, SightLine};
use super::two_body::TwoBody;
use crate::frames::{Gcrs, Orientation, Position};
use crate::geometry::ShadowModel;
use crate::orbit::{Arc, OrbitUncertainty, Propagator, State};

/// In an exposure longer than this the site moves too far to look for one place on the orbit; then all of the time is searched, seconds. Only satellites
/// that are nearly on time come to this: of the others every exposure is asked for in pieces (`chance.rs`).
const LONG_EXPOSURE_S: f64 = 600.0;
/// And so it is, up to this delay, on an orbit whose place in the field is not found (eccentric ones near the horizon), seconds.
const LONGEST_BLIND_REACH_S: f64 = 1200.0;
/// Points along a path at which light is looked for, as for a crossing.
const LIGHT_STEPS: u32 = 24;
/// Steps towards the place on the orbit; circular orbits need two.
const MOST_STEPS: usize = 8;
/// That place is known well enough from one of SGP4 this near, seconds: the chords are then cut exactly.
const PLACE_S: f64 = 1.0;
/// The same for paths that fall freely from there.
const FALL_S: f64 = 20.0;
/// All of a stretch up to this long is looked at without looking for a place first, seconds.
const SHORT_S: f64 = 40.0;
/// A stretch around that place is made twice as long until both of its ends lie outside the field, at most this often.
const MOST_DOUBLINGS: usize = 6;
/// Errors along the track from which on paths are circles, seconds.
pub(super) const LONG_DELAY_S: f64 = 3.0;

/// One exposure, with what all satellites in it share.
pub(super) struct Question<'a> {
    pub scene: &'a Scene,
    pub shadow: ShadowModel,
    pub field: &'a FieldOnSky<'a>,
    /// Standing still outside of the exposure.
    pub site: ObserverMotion,
    pub orientation: Orientation,
    pub opened_s: f64,
    pub closed_s: f64,
    /// Errors along the track from which on paths are circles, seconds.
    pub long_delay_s: f64,
    /// True for the pieces of a long exposure after its first: who was in the field before has been counted.
    pub only_entering: bool,
}

/// Where a satellite passes the line of sight.
#[derive(Copy, Clone)]
pub(super) struct Nearest {
    pub time_s: f64,
    /// Near that time: the time of a place of SGP4, and the place.
    pub state_s: f64,
    pub state: State<Gcrs>,
    pub period_s: f64,
    distance_km: f64,
    /// Speed across the line of sight.
    rate_rad_s: f64,
}

/// What is expected of one satellite, and from where it comes.
#[derive(Copy, Clone, Debug)]
pub(super) struct Place {
    pub odds: Odds,
    pub geometric: Position<Gcrs>,
    pub range_km: f64,
}

impl Question<'_> {
    /// `None` where the satellite has no chance, or is dark.
    pub fn odds(&self, propagator: &Propagator, sigma: OrbitUncertainty) -> Option<Place> {
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
        let is_long = sigma.along_track_s >= self.long_delay_s;
        let near_s = if is_long { FALL_S } else { PLACE_S };
        let Some(nearest) = self.nearest(propagator, minutes, mid_s, near_s) else {
            let blind_s = reach_s.min(LONGEST_BLIND_REACH_S);
            let (first_s, last_s) = (self.opened_s - blind_s, self.closed_s + blind_s);
            return self.on_arc(&arc(first_s, last_s)?, (first_s, last_s), sigma);
        };
        if is_long && self.runs_away(propagator, minutes, &nearest) {
            return None;
        }
        let turns = (reach_s / nearest.period_s).ceil() as i32;
        if is_long && sigma.cross_track_km >= WIDE_KM {
            let path = self.tilted(&nearest, sigma.cross_track_km)?;
            let turns_s = (-turns..=turns).map(|turn| f64::from(turn) * nearest.period_s);
            return self.on_path(&path, sigma.along_track_s, turns_s.collect());
        }
        // Half of the time that it needs through the field and its errors, doubled where it comes nearer on the way.
        let half_s = |there: &Nearest| {
            2.0 * (self.field.bounding_radius_rad() + REACH_SIGMAS * sigma.cross_track_km / there.distance_km)
                / there.rate_rad_s
                + 1.0
        };
        let place = |there: &Nearest| {
            let half_s = half_s(there);
            if there.time_s < first_s - half_s || there.time_s > last_s + half_s {
                return None;
            }
            if !is_long {
                return self.around(&arc, there, half_s, sigma);
            }
            let path = self.predicted(there, sigma.cross_track_km);
            let path = path.or_else(|| self.tilted(there, sigma.cross_track_km))?;
            self.on_path(&path, sigma.along_track_s, vec![0.0])
        };
        let mut best = place(&nearest);
        let period_s = nearest.period_s;
        for direction in [1.0, -1.0] {
            let mut last = nearest;
            let mut turn_s = direction * period_s;
            for turn in 1..=turns {
                let guess_s = last.time_s + turn_s;
                if guess_s < first_s - 0.1 * period_s || guess_s > last_s + 0.1 * period_s {
                    break;
                }
                let carried_s = direction * f64::from(turn) * period_s;
                let there = self.nearest(propagator, minutes, guess_s, near_s).unwrap_or(Nearest {
                    time_s: nearest.time_s + carried_s,
                    state_s: nearest.state_s + carried_s,
                    ..nearest
                });
                // From node to node, which the next turn will take as well.
                turn_s = there.time_s - last.time_s;
                last = there;
                match (&mut best, place(&there)) {
                    (Some(best), Some(place)) => {
                        // Delays of different revolutions exclude one another.
                        best.odds.probability += place.odds.probability;
                        best.odds.streak_length_rad += place.odds.streak_length_rad;
                    }
                    (best @ None, place) => *best = place,
                    (Some(_), None) => {}
                }
            }
        }
        best
    }

    /// The delays that bring a satellite into this exposure.
    pub fn delays(&self, along_track_s: f64) -> Delays {
        Delays::new((self.opened_s, self.closed_s), along_track_s).only_entering(self.only_entering)
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
        let cross_track_rad = sigma.cross_track_km / aspect.range_km;
        if nominal.min_separation_rad > self.field.bounding_radius_rad() + REACH_SIGMAS * cross_track_rad {
            return None;
        }
        if !self.is_lit(arc, &nominal, searched_s, aspect.range_km) {
            return None;
        }
        let delays = self.delays(sigma.along_track_s);
        let odds = crossing_odds(&track, &nominal, searched_s, &delays, self.field, cross_track_rad);
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

    /// Where the line of sight runs through a shell, and how far away that is, km.
    pub fn on_shell(&self, time_s: f64, radius_km: f64) -> (Vector3<f64>, f64) {
        let site = *self.site.position(time_s).vector();
        // |O + ρ d| = r, the farther of the two: from within the shell the only one ahead.
        let along_km = site.dot(self.field.centre());
        let square = along_km * along_km + radius_km * radius_km - site.norm_squared();
        let distance_km = -along_km + square.max(0.0).sqrt();
        (site + self.field.centre() * distance_km, distance_km)
    }

    /// Where the satellite passes nearest to the line of sight on the revolution of `start_s`, from a place of SGP4 no farther than `near_s` from
    /// it; `None` where that is not found.
    pub fn nearest(&self, propagator: &Propagator, minutes: f64, start_s: f64, near_s: f64) -> Option<Nearest> {
        let mut time_s = start_s;
        for _ in 0..MOST_STEPS {
            let state = propagator.state_at_minutes(minutes + time_s / 60.0, &self.orientation.teme_to_gcrs).ok()?;
            let orbit = TwoBody::of(state.position.vector(), state.velocity.vector())?;
            let (target, distance_km) = self.on_shell(time_s, state.position.norm_km());
            let step_s = orbit.time_to_s(&target);
            time_s += step_s;
            if step_s.abs() < near_s {
                let across =
                    state.velocity.vector() - self.field.centre() * state.velocity.vector().dot(self.field.centre());
                return Some(Nearest {
                    time_s,
                    state_s: time_s - step_s,
                    state,
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
