//! Where a satellite that may be minutes late runs past a field: a circle on the sky, from one place of SGP4.
//!
//! Errors across the track shift it. Up to [`WIDE_KM`] the shift lies on the tangent plane, as in `probability`. Beyond, months after the
//! elements of a satellite that manoeuvres, it may be as wide as the sky, and no tangent plane holds it. What such a satellite
//! keeps is its distance r from the Earth's centre, for its mean motion is known far better than its plane. It comes into the line of
//! sight where that runs through its shell, at the place P, and for that its orbit is tilted by η about the line square to P in its plane,
//! an error of r η across the track:
//!
//! sin η = P·n / r
//!
//! The tilted orbit leads through the field; what is left of the field's width shifts it on the tangent plane, by e·n' / ρ radians a kilometre
//! of error (e the direction across the path on the sky, n' the tilted normal, ρ the distance).

use nalgebra::Vector3;

use super::circle_path::CirclePath;
use super::places::{Nearest, Place, Question};
use super::probability::{REACH_SIGMAS, over_shifts};
use super::track::Chord;
use super::two_body::FreeFall;
use crate::frames::{Gcrs, Position, Velocity};
use crate::orbit::{Propagator, State};

/// Errors across the track from which on they tilt the plane, km. Seen at the zenith from 550 km below, the tangent plane leaves the sky by a degree
/// at 3.5 times this.
pub(super) const WIDE_KM: f64 = 60.0;
/// Steps towards the place on a path that is nearest to the centre of the field, and when it is found, seconds.
const PATH_STEPS: usize = 4;
const PATH_S: f64 = 0.5;
/// Free fall is followed for this share of a revolution: 0.1 km of the lowest orbits.
const FALL_TURNS: f64 = 0.02;
/// Where a satellite falls in this time, seconds, and where SGP4 has it then may differ by this, km.
const AWAY_AFTER_S: f64 = 10.0;
const AWAY_KM: f64 = 1.0;

/// One satellite's path past the field.
pub(super) struct LatePath {
    circle: CirclePath,
    /// Along the path, from `fall_s` on.
    fall: FreeFall,
    fall_s: f64,
    /// From the path that is predicted to this one, and its sigma; radians across the path on the sky.
    shift_rad: f64,
    sigma_rad: f64,
    /// Where it is nearest to the centre of the field.
    geometric: Position<Gcrs>,
    speed_km_s: f64,
    /// The site's speed along the path, of the satellite's.
    carried: f64,
}

impl Question<'_> {
    /// True where the next seconds lead elsewhere than the velocity says: drag terms that have run away, as [`Arc::new`](crate::orbit::Arc::new) finds them.
    pub fn runs_away(&self, propagator: &Propagator, minutes: f64, place: &Nearest) -> bool {
        let later_minutes = minutes + (place.state_s + AWAY_AFTER_S) / 60.0;
        propagator.state_at_minutes(later_minutes, &self.orientation.teme_to_gcrs).map_or(true, |later| {
            let fallen = FreeFall::of(&place.state).state_at(AWAY_AFTER_S);
            (later.position - fallen.position).norm_km() > AWAY_KM
        })
    }

    /// The path as predicted; `None` where it is nearest to the field far from the place found.
    pub fn predicted(&self, place: &Nearest, cross_track_km: f64) -> Option<LatePath> {
        let path = self.circle(FreeFall::of(&place.state), place)?;
        Some(LatePath { sigma_rad: cross_track_km / path.geometric.norm_km(), ..path })
    }

    /// The path tilted into the field; `None` where that is farther than errors reach.
    pub fn tilted(&self, place: &Nearest, cross_track_km: f64) -> Option<LatePath> {
        let (position, velocity) = (place.state.position.vector(), place.state.velocity.vector());
        let normal = position.cross(velocity).try_normalize(0.0)?;
        let (target, _) = self.on_shell(place.time_s, position.norm());
        let there = target.try_normalize(0.0)?;
        // sin η = P·n / r
        let sine = there.dot(&normal);
        let off_km = position.norm() * sine.asin();
        let foot = (there - normal * sine).try_normalize(0.0)?;
        let along = normal.cross(&foot);
        let tilted_normal = there.cross(&along);
        let tilt = |vector: &Vector3<f64>| {
            there * vector.dot(&foot) + along * vector.dot(&along) + tilted_normal * vector.dot(&normal)
        };
        let state =
            State { position: Position::from_vector(tilt(position)), velocity: Velocity::from_vector(tilt(velocity)) };
        let path = self.circle(FreeFall::of(&state), place)?;
        let lean_km = path.circle.across.dot(&tilted_normal) / path.geometric.norm_km();
        Some(LatePath { shift_rad: off_km * lean_km, sigma_rad: cross_track_km * lean_km.abs(), ..path })
    }

    /// The fall from a place as a circle.
    fn circle(&self, fall: FreeFall, place: &Nearest) -> Option<LatePath> {
        let mut time_s = place.time_s;
        for _ in 0..PATH_STEPS {
            let state = fall.state_at(time_s - place.state_s);
            let sight = self.site.sight_of(&state, time_s);
            let circle = CirclePath::of(&sight, time_s, self.field.centre())?;
            let step_s = circle.closest_s - time_s;
            if step_s.abs() < PATH_S {
                let across = state.velocity.vector() - sight.vector * state.velocity.vector().dot(&sight.vector);
                let carried = self.site.velocity(time_s).dot(&across) / across.norm_squared();
                return Some(LatePath {
                    carried,
                    geometric: state.position - self.site.position(circle.closest_s),
                    speed_km_s: state.velocity.norm_km_s(),
                    circle,
                    fall,
                    fall_s: place.state_s,
                    shift_rad: 0.0,
                    sigma_rad: 0.0,
                });
            }
            time_s = circle.closest_s;
            if (time_s - place.state_s).abs() > FALL_TURNS * place.period_s {
                return None;
            }
        }
        None
    }

    /// What a path makes likely that is run through again on other revolutions, `turns_s` later (0 among them); `None` where the satellite has no chance, or is dark.
    pub fn on_path(&self, path: &LatePath, along_track_s: f64, turns_s: Vec<f64>) -> Option<Place> {
        let LatePath { circle, shift_rad, sigma_rad, .. } = path;
        let range_km = path.geometric.norm_km();
        let radius_rad = self.field.bounding_radius_rad();
        let beside_rad = circle.min_separation_rad(self.field.centre());
        if shift_rad.abs() + beside_rad > radius_rad + REACH_SIGMAS * sigma_rad {
            return None;
        }
        let sun = self.scene.sun.at_s(0.5 * (self.opened_s + self.closed_s)).sun;
        let is_lit = |time_s: f64| {
            let position = path.fall.state_at(time_s - path.fall_s).position;
            self.shadow.illumination(&position, &sun).lit_fraction() > 0.0
        };
        let nominal = circle.chords(0.0, self.field);
        let beside_s = radius_rad * range_km / path.speed_km_s;
        let enter_s = nominal.first().map_or(circle.closest_s - beside_s, |chord| chord.enter_s);
        let exit_s = nominal.last().map_or(circle.closest_s + beside_s, |chord| chord.exit_s);
        // The shadow is convex: a stretch with both of its ends in it lies in it.
        if !(is_lit(circle.closest_s) || is_lit(enter_s) || is_lit(exit_s)) {
            return None;
        }
        let delays = self.delays(along_track_s).of_turns(turns_s, circle.closest_s, circle.longest_s(radius_rad));
        let mut odds = over_shifts(
            *sigma_rad,
            radius_rad,
            || shift_rad + circle.across.dot(self.field.centre()),
            |off_rad| {
                let beside_rad = off_rad - shift_rad;
                let chords = circle.chords(beside_rad, self.field);
                delays.odds(&chords, |chord: &Chord| circle.length_rad(chord, beside_rad))
            },
        );
        if self.only_entering {
            // A field that moves along with the satellites meets fewer of them.
            odds.probability *= 1.0 - path.carried;
            odds.streak_length_rad *= 1.0 - path.carried;
        }
        (odds.probability > 0.0).then_some(Place { odds, geometric: path.geometric, range_km })
    }
}

#[cfg(test)]
mod tests {
    use hifitime::Epoch;
    use nalgebra::{Rotation3, Unit};

    use super::*;
    use crate::elements::{Constellation, ElementSet};
    use crate::frames::{Direction, EopTable};
    use crate::geometry::{Observer, Site};
    use crate::orbit::{Arc, OrbitUncertainty};
    use crate::passes::crossing::cross;
    use crate::passes::delays::{Delays, Odds};
    use crate::passes::sightline::{ObserverMotion, SightLine};
    use crate::passes::{Field, ModelChoice, Sky};
    use crate::photometry::ModelLibrary;

    /// Nodes and weights of the three-point Gauss-Hermite rule for a unit normal distribution (Abramowitz & Stegun, table 25.10).
    const THREE: [(f64, f64); 3] =
        [(0.0, 2.0 / 3.0), (1.732_050_807_568_877, 1.0 / 6.0), (-1.732_050_807_568_877, 1.0 / 6.0)];
    const TURNS: [f64; 5] = [-2.0, -1.0, 0.0, 1.0, 2.0];

    /// The slow way: the whole orbit tilted about both axes of its plane, step by step; every tilted path walked along and its chords through the field
    /// searched for, by every revolution that may bring it into the exposure.
    fn every_tilt(
        question: &Question<'_>,
        propagator: &Propagator,
        minutes: f64,
        near: &Nearest,
        sigma: OrbitUncertainty,
    ) -> Odds {
        let (position, velocity) = (near.state.position.vector(), near.state.velocity.vector());
        let normal = position.cross(velocity).normalize();
        let (target, distance_km) = question.on_shell(near.time_s, position.norm());
        let there = target.normalize();
        let foot = (there - normal * there.dot(&normal)).normalize();
        let along = Unit::new_normalize(normal.cross(&foot));
        let half_s = 240.0;
        let arc = Arc::new(propagator, minutes, near.time_s - half_s, 2.0 * half_s, &question.orientation.teme_to_gcrs)
            .unwrap();
        let line = SightLine { arc: &arc, observer: question.site.clone() };
        let exposure_s = (question.opened_s, question.closed_s);
        // Across the field and as much beside it, in steps of a 32nd of its radius.
        let step_rad = question.field.bounding_radius_rad() * distance_km / position.norm() / 32.0;
        let sigma_rad = sigma.cross_track_km / position.norm();
        let middle_rad = there.dot(&normal).asin();
        let mut total = Odds::default();
        for step in -80..80 {
            let tilt_rad = middle_rad + step_rad * (f64::from(step) + 0.5);
            // Along × foot = -normal: a positive turn about the other way lifts the foot towards the normal.
            let lift = Rotation3::from_axis_angle(&along, -tilt_rad);
            let z = tilt_rad / sigma_rad;
            let weight = (-0.5 * z * z).exp() / (sigma_rad * std::f64::consts::TAU.sqrt()) * step_rad;
            for (node, share) in THREE {
                let twist = Rotation3::from_axis_angle(&Unit::new_normalize(lift * foot), node * sigma_rad);
                let turn = twist * lift;
                let track = |time_s: f64| {
                    let (state, ..) = line.aspect_at(time_s);
                    let tilted = State {
                        position: Position::from_vector(turn * state.position.vector()),
                        velocity: Velocity::from_vector(turn * state.velocity.vector()),
                    };
                    question.site.sight_of(&tilted, time_s)
                };
                let chords = cross(&track, near.time_s - half_s, near.time_s + half_s, question.field).chords;
                let delays = Delays::new(exposure_s, sigma.along_track_s).of_turns(
                    TURNS.map(|turn| turn * near.period_s).to_vec(),
                    0.0,
                    f64::INFINITY,
                );
                let length_rad = |chord: &Chord| {
                    let (enter, exit) = (track(chord.enter_s).vector, track(chord.exit_s).vector);
                    enter.cross(&exit).norm().atan2(enter.dot(&exit))
                };
                let odds = delays.odds(&chords, length_rad);
                total.probability += weight * share * odds.probability;
                total.streak_length_rad += weight * share * odds.streak_length_rad;
            }
        }
        total
    }

    /// Where the path through the centre of the field runs in the Earth's shadow.
    fn is_dark(question: &Question<'_>, near: &Nearest) -> bool {
        let (place, _) = question.on_shell(near.time_s, near.state.position.norm_km());
        let sun = question.scene.sun.at_s(0.5 * (question.opened_s + question.closed_s)).sun;
        question.shadow.illumination(&Position::from_vector(place), &sun).lit_fraction() <= 0.0
    }

    /// Planes that may be off by hundreds of kilometres, and satellites anywhere along them.
    #[test]
    fn verif_tilted_paths_against_every_tilt() {
        /// Of one chance: a plane twisted by 8 degrees leads through the field at another rate and slant (of second order, a hundredth), the steps of the
        /// slow way see the field's width to a 64th, and the distance changes over it.
        const OF_ONE: f64 = 0.03;
        /// Of the sum of all.
        const OF_ALL: f64 = 0.02;
        let start = Epoch::from_gregorian_utc_hms(2024, 8, 13, 23, 0, 0);
        let mut elements = Constellation::by_name("starlink-gen1").unwrap().element_sets(start);
        elements.truncate(1584);
        let elements: Vec<ElementSet> = elements.into_iter().step_by(37).collect();
        let observer = Observer::new(Site::new_deg("Cerro Pachón", -30.244639, -70.749417, 2663.0).unwrap());
        let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
        let sky = Sky::new(elements, observer.clone(), EopTable::embedded(), &choice);
        let scene = sky.scene_without_windows(start, 60.0);
        let orientation = scene.orientation.at_s(15.0);
        let here = observer.state(&orientation);
        let field = Field::circle(3.5f64.to_radians()).unwrap();
        let mut sums = [Odds::default(); 2];
        let mut compared = 0;
        for (altitude_deg, azimuth_deg) in [(88.0, 10.0), (60.0, 200.0), (35.0, 80.0)] {
            let horizontal = Direction::from_lon_lat_rad(f64::to_radians(azimuth_deg), f64::to_radians(altitude_deg));
            let on_sky = field.on_sky(&(here.horizon.inverse() * horizontal), 0.0);
            let site = ObserverMotion::of_site(&observer, &orientation, scene.sun.at_s(15.0).earth_velocity, 15.0);
            let question = Question {
                scene: &scene,
                shadow: sky.shadow(),
                field: &on_sky,
                site: site.still_outside(0.0, 30.0),
                orientation,
                opened_s: 0.0,
                closed_s: 30.0,
                long_delay_s: 3.0,
                only_entering: false,
            };
            for index in 0..sky.elements().len() {
                let propagator = sky.index().propagator(index).unwrap();
                let minutes = propagator.minutes_since_epoch(start);
                for (along_track_s, cross_track_km) in [(1900.0, 1000.0), (300.0, 200.0)] {
                    let sigma = OrbitUncertainty { along_track_s, cross_track_km };
                    // On a path that SGP4 does not bring to the line of sight there is nothing to tilt.
                    let Some(near) = question.nearest(propagator, minutes, 15.0, 1.0) else { continue };
                    // The slow way knows nothing of the Earth's shadow: those that are dark where they pass are left out of both.
                    if is_dark(&question, &near) {
                        continue;
                    }
                    let fast = question.odds(propagator, sigma).map_or(Odds::default(), |place| place.odds);
                    let slow = every_tilt(&question, propagator, minutes, &near, sigma);
                    for (sum, odds) in sums.iter_mut().zip([fast, slow]) {
                        sum.probability += odds.probability;
                        sum.streak_length_rad += odds.streak_length_rad;
                    }
                    if slow.probability < 1e-6 {
                        continue;
                    }
                    compared += 1;
                    let ratio = fast.probability / slow.probability;
                    let length = fast.streak_length_rad / slow.streak_length_rad;
                    assert!((ratio - 1.0).abs() < OF_ONE && (length - 1.0).abs() < OF_ONE, "{fast:?} {slow:?}");
                }
            }
        }
        let [fast, slow] = sums;
        assert!((fast.probability / slow.probability - 1.0).abs() < OF_ALL, "{sums:?}");
        assert!((fast.streak_length_rad / slow.streak_length_rad - 1.0).abs() < OF_ALL, "{sums:?}");
        assert!(compared > 60, "{compared}");
    }
}
