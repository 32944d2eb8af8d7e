//! Where one satellite's path meets a field, by which delays it leads through it, and what that makes likely.
//!
//! Up to an error along the track of [`LONG_DELAY_S`] the exact chords of the path are cut. Beyond it every revolution's path is a circle on
//! the sky ([`CirclePath`]) from one place of SGP4: the exposure meets hundreds of such satellites, each with a small chance, and the error of
//! a second in a chord is nothing against a delay of minutes.

use nalgebra::Vector3;

use super::circle_path::CirclePath;
use super::crossing::{Crossing, cross};
use super::field::FieldOnSky;
use super::probability::{Odds, REACH_SIGMAS, Sigmas, crossing_odds, odds_of, over_shifts};
use super::scene::Scene;
use super::sightline::{ObserverMotion, SightLine};
use super::track::Chord;
use super::two_body::{FreeFall, TwoBody};
use crate::frames::{Gcrs, Orientation, Position};
use crate::geometry::ShadowModel;
use crate::orbit::{Arc, OrbitUncertainty, Propagator, State};

/// In an exposure longer than this the site moves too far for one place on the orbit; then all of the time is searched, seconds.
const LONG_EXPOSURE_S: f64 = 600.0;
/// And so it is, up to this delay, on an orbit whose place in the field is not found (eccentric ones near the horizon), seconds.
const LONGEST_BLIND_REACH_S: f64 = 1200.0;
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
/// Errors along the track from which on paths are circles, seconds.
pub(super) const LONG_DELAY_S: f64 = 3.0;
/// Steps towards the place on such a path that is nearest to the centre of the field, and when it is found, seconds.
const PATH_STEPS: usize = 4;
const PATH_S: f64 = 0.5;
/// Free fall is followed for this share of a revolution: 0.1 km of the lowest orbits.
const FALL_TURNS: f64 = 0.02;
/// Where a satellite falls in this time, seconds, and where SGP4 has it then may differ by this, km.
const AWAY_AFTER_S: f64 = 10.0;
const AWAY_KM: f64 = 1.0;

/// One exposure, with what all satellites in it share.
pub(super) struct Question<'a> {
    pub scene: &'a Scene,
    pub shadow: ShadowModel,
    pub field: &'a FieldOnSky<'a>,
    /// Standing still outside of the exposure.
    pub site: ObserverMotion,
    pub orientation: &'a Orientation,
    pub opened_s: f64,
    pub closed_s: f64,
    /// Errors along the track from which on paths are circles, seconds.
    pub long_delay_s: f64,
}

/// Where a satellite passes the line of sight.
#[derive(Copy, Clone)]
struct Nearest {
    time_s: f64,
    /// Within [`PLACE_S`] of that time: the time of a place of SGP4, and the place.
    state_s: f64,
    state: State<Gcrs>,
    period_s: f64,
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
        let Some(nearest) = self.nearest(propagator, minutes, mid_s) else {
            let blind_s = reach_s.min(LONGEST_BLIND_REACH_S);
            let (first_s, last_s) = (self.opened_s - blind_s, self.closed_s + blind_s);
            return self.on_arc(&arc(first_s, last_s)?, (first_s, last_s), sigma);
        };
        let is_long = sigma.along_track_s >= self.long_delay_s;
        if is_long && self.runs_away(propagator, minutes, &nearest) {
            return None;
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
            match self.path(there).filter(|_| is_long) {
                Some(path) => self.on_circle(there, &path, sigma),
                None => self.around(&arc, there, half_s, sigma),
            }
        };
        let mut best = place(&nearest);
        let period_s = nearest.period_s;
        let turns = (reach_s / period_s).ceil() as i32;
        for direction in [1.0, -1.0] {
            let mut last = nearest;
            let mut turn_s = direction * period_s;
            for turn in 1..=turns {
                let guess_s = last.time_s + turn_s;
                if guess_s < first_s - 0.1 * period_s || guess_s > last_s + 0.1 * period_s {
                    break;
                }
                let carried_s = direction * f64::from(turn) * period_s;
                let there = self.nearest(propagator, minutes, guess_s).unwrap_or(Nearest {
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

    /// True where the next seconds lead elsewhere than the velocity says: drag terms that have run away, as [`Arc::new`] finds them.
    fn runs_away(&self, propagator: &Propagator, minutes: f64, place: &Nearest) -> bool {
        let later_minutes = minutes + (place.state_s + AWAY_AFTER_S) / 60.0;
        propagator.state_at_minutes(later_minutes, &self.orientation.teme_to_gcrs).map_or(true, |later| {
            let fallen = FreeFall::of(&place.state).state_at(AWAY_AFTER_S);
            (later.position - fallen.position).norm_km() > AWAY_KM
        })
    }

    /// The path past the field as a circle on the sky, with the state on it that is nearest to the centre; `None` where that is far from the place found.
    fn path(&self, place: &Nearest) -> Option<(CirclePath, State<Gcrs>)> {
        let fall = FreeFall::of(&place.state);
        let mut time_s = place.time_s;
        for _ in 0..PATH_STEPS {
            let state = fall.state_at(time_s - place.state_s);
            let sight = self.site.sight_of(&state, time_s);
            let path = CirclePath::of(&sight, time_s, self.field.centre())?;
            let step_s = path.closest_s - time_s;
            if step_s.abs() < PATH_S {
                return Some((path, state));
            }
            time_s = path.closest_s;
            if (time_s - place.state_s).abs() > FALL_TURNS * place.period_s {
                return None;
            }
        }
        None
    }

    /// As [`Question::on_arc`], on a circle.
    fn on_circle(
        &self,
        place: &Nearest,
        (path, state): &(CirclePath, State<Gcrs>),
        sigma: OrbitUncertainty,
    ) -> Option<Place> {
        let geometric = state.position - self.site.position(path.closest_s);
        let range_km = geometric.norm_km();
        let cross_track_rad = sigma.cross_track_km / range_km;
        let radius_rad = self.field.bounding_radius_rad();
        if path.min_separation_rad(self.field.centre()) > radius_rad + REACH_SIGMAS * cross_track_rad {
            return None;
        }
        let sun = self.scene.sun.at_s(0.5 * (self.opened_s + self.closed_s)).sun;
        let fall = FreeFall::of(&place.state);
        let is_lit = |time_s: f64| {
            let position = fall.state_at(time_s - place.state_s).position;
            self.shadow.illumination(&position, &sun).lit_fraction() > 0.0
        };
        let nominal = path.chords(0.0, self.field);
        let beside_s = radius_rad * range_km / state.velocity.norm_km_s();
        let enter_s = nominal.first().map_or(path.closest_s - beside_s, |chord| chord.enter_s);
        let exit_s = nominal.last().map_or(path.closest_s + beside_s, |chord| chord.exit_s);
        // The shadow is convex: a stretch with both of its ends in it lies in it.
        if !(is_lit(path.closest_s) || is_lit(enter_s) || is_lit(exit_s)) {
            return None;
        }
        let odds = over_shifts(
            cross_track_rad,
            radius_rad,
            || path.across.dot(self.field.centre()),
            |shift_rad| {
                let chords = path.chords(shift_rad, self.field);
                let length_rad = |chord: &Chord| path.length_rad(chord, shift_rad);
                odds_of(&chords, length_rad, (self.opened_s, self.closed_s), sigma.along_track_s)
            },
        );
        (odds.probability > 0.0).then_some(Place { odds, geometric, range_km })
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
