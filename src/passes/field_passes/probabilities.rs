//! Probability and expected streak length of every satellite that may be in an exposure, near misses included.
//!
//! Candidates are searched with the delays and the shifts across the track that their errors allow, delays up to
//! [`Lateness::LONGEST_S`]. Where older elements allow longer delays, the probability is a lower limit and marked as
//! such.
//!
//! A satellite with a delay of seconds or more is evaluated in pieces of ten seconds of the exposure, each with the
//! site at its position in the middle, because the site moves past many orbit planes (by up to 280 km in ten minutes).
//! The delays that bring a satellite into the field during different pieces exclude one another: its probability is
//! that of being in the field during the first piece, plus that of entering it during each of the others. So it never
//! decreases with the length of the exposure.
//!
//! Simplified: orbit planes do not turn during the delay, and chords keep their length while the site moves through a
//! piece (12 % of a single satellite with a sigma of 17 s, no bias of the sum over many). In exposures longer than a
//! revolution a satellite that comes back is counted again, up to 1. For a telescope in orbit the passes and near
//! misses of [`Sky::field_passes`] are summed.

use std::cell::OnceCell;

use super::super::candidates::PlacedCone;
use super::super::crossing::{Crossing, cross};
use super::super::error::SkyError;
use super::super::evaluator::LOWEST_ALTITUDE_RAD;
use super::super::exposure::Exposure;
use super::super::field::Field;
use super::super::probability::{Delays, REACH_SIGMAS, crossing_odds};
use super::super::scene::SearchScope;
use super::super::sky::Sky;
use super::super::track::{ObserverMotion, Pass, SightLine};
use super::exposed_field::ExposedField;
use super::options::PassOptions;
use crate::frames::{Orientation, seconds_after};
use crate::geometry::Observer;
use crate::orbit::{Candidate, Cones, OrbitArc, OrbitUncertainty};

/// Length of a piece of an exposure, seconds: the site moves by 5 km at most in it, a share of a field of degrees.
const PIECE_S: f64 = 10.0;
/// Pieces are searched together over this time, seconds.
const SEARCHED_S: f64 = 60.0;
/// Where all delays that are searched are shorter, the exposure is not cut into pieces, seconds.
const ON_TIME_S: f64 = 10.5;
/// Steps along a path in the search for light.
const LIGHT_STEPS: u32 = 24;
/// Least probability of the near misses that are summed for a telescope in orbit.
const LEAST_IN_FLIGHT: f64 = 0.01;

/// One satellite that may be in one exposure.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct CrossingProbability {
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Probability that it is in the field at any time of the exposure, (0, 1].
    pub probability: f64,
    /// Expected length of its streak within the field, radians: the average over all its errors, 0 for those that lead
    /// past.
    pub streak_length_rad: f64,
    /// Its distance where its path is nearest to the centre of the field, km.
    pub range_km: f64,
    /// True where its elements are so old that longer delays are probable than those that were searched: probability
    /// and streak length are then lower limits.
    pub is_lower_limit: bool,
}

impl CrossingProbability {
    /// Of two parts of an exposure, in time order.
    fn plus(self, next: Self) -> Self {
        Self {
            probability: (self.probability + next.probability).min(1.0),
            streak_length_rad: self.streak_length_rad + next.streak_length_rad,
            ..self
        }
    }
}

/// A part of an exposure. Times are seconds of the scene.
struct Piece {
    start_s: f64,
    end_s: f64,
    /// True for all pieces but the first: satellites that are in the field at its start belong to the piece before.
    only_entering: bool,
    /// In its middle.
    orientation: Orientation,
    site: ObserverMotion,
}

impl Piece {
    fn mid_s(&self) -> f64 {
        0.5 * (self.start_s + self.end_s)
    }
}

impl Sky {
    /// Every satellite that may be in each exposure while the Sun shines on it, with its probability; by exposure, in
    /// catalogue order.
    ///
    /// With fresh elements these are little more than the nominal crossings. With elements weeks old they are all
    /// satellites that come by within minutes, each with a small probability.
    ///
    /// # Errors
    /// As [`Sky::field_passes`].
    pub fn crossing_probabilities(
        &self,
        exposures: &[Exposure],
        field: &Field,
    ) -> Result<Vec<Vec<CrossingProbability>>, SkyError> {
        let Some(observer) = self.viewpoint().site() else { return self.probabilities_in_flight(exposures, field) };
        let (by_exposure, _) = self.by_exposure(exposures, SearchScope::Delayed, |scene, exposure, seen| {
            let exposed = ExposedField::new(self, scene, exposure, field)?;
            Ok((exposed.probabilities(observer, seen), Vec::new()))
        })?;
        Ok(by_exposure)
    }

    fn probabilities_in_flight(
        &self,
        exposures: &[Exposure],
        field: &Field,
    ) -> Result<Vec<Vec<CrossingProbability>>, SkyError> {
        let options =
            PassOptions { min_probability: Some(LEAST_IN_FLIGHT), without_light: true, ..PassOptions::default() };
        let passes = self.field_passes(exposures, field, &options)?.by_exposure;
        // The mean chord of a circle is π/2 of its radius.
        let mean_chord_rad = std::f64::consts::FRAC_PI_2 * field.bounding_radius_rad();
        let length_rad = |pass: &Pass, exposure: &Exposure| {
            if pass.is_crossing() {
                pass.streak_length_rad
            } else {
                mean_chord_rad.min(pass.angular_rate_rad_s * exposure.duration_s)
            }
        };
        let is_cut = |pass: &Pass, exposure: &Exposure| {
            let shutter_s = [0.0, exposure.duration_s];
            let middle = seconds_after(exposure.start, 0.5 * exposure.duration_s);
            self.propagator_over(exposure.start, pass.element_index, shutter_s)
                .is_some_and(|one| self.uncertainty_of(pass.element_index, one, middle).lateness.is_cut())
        };
        let of = |(passes, exposure): (Vec<Pass>, &Exposure)| {
            let mut found: Vec<CrossingProbability> = passes
                .iter()
                .filter(|pass| pass.lit && pass.probability > 0.0)
                .map(|pass| CrossingProbability {
                    element_index: pass.element_index,
                    probability: pass.probability,
                    streak_length_rad: pass.probability * length_rad(pass, exposure),
                    range_km: pass.mid.range_km,
                    is_lower_limit: is_cut(pass, exposure),
                })
                .collect();
            found.sort_by_key(|one| one.element_index);
            found
        };
        Ok(passes.into_iter().zip(exposures).map(of).collect())
    }
}

impl ExposedField<'_> {
    /// All satellites that may be in the exposure. `seen` is a buffer.
    fn probabilities(&self, observer: &Observer, seen: &mut Vec<Candidate>) -> Vec<CrossingProbability> {
        // From the opening on, so that a longer exposure begins with the same pieces.
        let cut = |start_s: f64, end_s: f64, length_s: f64| -> Vec<Piece> {
            let count = ((end_s - start_s) / length_s).ceil().max(1.0) as u32;
            (0..count)
                .map(|number| {
                    let from_s = start_s + length_s * f64::from(number);
                    self.piece(observer, from_s, end_s.min(from_s + length_s), from_s > self.opened_s)
                })
                .collect()
        };
        let parts = cut(self.opened_s, self.closed_s, SEARCHED_S);
        // Only late satellites need the pieces.
        let pieces: Vec<OnceCell<Vec<Piece>>> = parts.iter().map(|_| OnceCell::new()).collect();
        let shadow = self.sky.dark_cone(self.scene, self.exposure);
        seen.clear();
        for (first, part) in (0..).zip(&parts) {
            let times_s = (part.mid_s(), 0.5 * (part.end_s - part.start_s));
            let near = (&part.site, &part.orientation);
            let Some(PlacedCone { window, cone, teme_to_gcrs }) =
                self.sky.cone(self.scene, self.exposure, &self.field, near, times_s)
            else {
                continue;
            };
            let cones = Cones { whole: &cone, parts: &[], first, shadow: Some(&shadow) };
            window.candidates(&cones, &teme_to_gcrs, seen);
        }
        seen.retain(|candidate| !candidate.is_dark);
        seen.sort_unstable_by_key(|candidate| (candidate.element_index, candidate.cone));
        let mut whole = self.piece(observer, self.opened_s, self.closed_s, false);
        whole.site = whole.site.still_outside(whole.start_s, whole.end_s);
        let mid = seconds_after(self.scene.start, whole.mid_s());
        let of_one = |candidates: &[Candidate]| {
            let element_index = candidates[0].element_index as usize;
            let propagator = self.propagator(element_index)?;
            let sigma = self.sky.uncertainty_of(element_index, propagator, mid);
            let near_s = |candidate: &Candidate| {
                let mid_s = parts[candidate.cone as usize].mid_s();
                candidate.near_s.map(|time_s| mid_s + f64::from(time_s))
            };
            if sigma.lateness.reach_s() < ON_TIME_S {
                let all_s =
                    candidates.iter().map(near_s).reduce(|one, next| [one[0].min(next[0]), one[1].max(next[1])]);
                return self.probability_in(std::slice::from_ref(&whole), observer, element_index, all_s?, sigma);
            }
            let of_parts = candidates.iter().filter_map(|one| {
                let part = one.cone as usize;
                let pieces = pieces[part].get_or_init(|| cut(parts[part].start_s, parts[part].end_s, PIECE_S));
                self.probability_in(pieces, observer, element_index, near_s(one), sigma)
            });
            of_parts.reduce(CrossingProbability::plus)
        };
        seen.chunk_by(|one, other| one.element_index == other.element_index).filter_map(of_one).collect()
    }

    fn piece(&self, observer: &Observer, start_s: f64, end_s: f64, only_entering: bool) -> Piece {
        let mid_s = 0.5 * (start_s + end_s);
        let orientation = self.scene.orientation.at_s(mid_s);
        let earth_velocity = self.scene.sun.at_s(mid_s).earth_velocity;
        let site = ObserverMotion::of_site(observer, &orientation, earth_velocity, mid_s);
        Piece { start_s, end_s, only_entering, orientation, site }
    }

    /// One satellite in some pieces, its predicted track being near the field during `near_s`; `None` where it cannot
    /// be in the field, or is dark.
    fn probability_in(
        &self,
        pieces: &[Piece],
        observer: &Observer,
        element_index: usize,
        [from_s, to_s]: [f64; 2],
        sigma: OrbitUncertainty,
    ) -> Option<CrossingProbability> {
        let propagator = self.propagator(element_index)?;
        let minutes = propagator.minutes_since_epoch(self.scene.start);
        let teme_to_gcrs = &pieces[pieces.len() / 2].orientation.teme_to_gcrs;
        let arc = OrbitArc::new(propagator, minutes, from_s, to_s - from_s, teme_to_gcrs).ok()?;
        let is_late = sigma.lateness.reach_s() >= ON_TIME_S;
        let of = |piece: &Piece| {
            let still =
                if is_late { piece.site.still_outside(piece.mid_s(), piece.mid_s()) } else { piece.site.clone() };
            let line = SightLine { arc: &arc, observer: still };
            let track = |time_s: f64| line.sight(time_s);
            let nominal = cross(&track, from_s, to_s, &self.field);
            let (state, _, aspect) = line.aspect_at(nominal.closest_s);
            let cross_track_rad = sigma.cross_track_km / aspect.range_km;
            if nominal.min_separation_rad > self.field.bounding_radius_rad() + REACH_SIGMAS * cross_track_rad {
                return None;
            }
            let sine_of_altitude = observer.state(&piece.orientation).sine_of_altitude(&aspect.geometric);
            if sine_of_altitude < LOWEST_ALTITUDE_RAD.sin()
                || !self.is_lit(piece, &arc, &nominal, (from_s, to_s), aspect.range_km)
            {
                return None;
            }
            // The site, moving along with a satellite of velocity v at right angles to the line of sight, delays its
            // entry by u·v / v² of the time: so much fewer enter in a piece.
            let carried = if is_late {
                let sight = aspect.direction.vector();
                let across = state.velocity.vector() - sight * state.velocity.vector().dot(sight);
                line.observer.velocity(piece.mid_s()).dot(&across) / across.norm_squared().max(1e-12)
            } else {
                0.0
            };
            let half_s = 0.5 * (piece.end_s - piece.start_s) * (1.0 - carried).abs();
            let lateness = sigma.lateness;
            let delays = Delays {
                start_s: piece.mid_s() - half_s,
                end_s: piece.mid_s() + half_s,
                lateness,
                only_entering: piece.only_entering,
            };
            let odds = crossing_odds(&track, &nominal, (from_s, to_s), &delays, &self.field, cross_track_rad);
            (odds.probability > 0.0).then_some(CrossingProbability {
                element_index,
                probability: odds.probability.min(1.0),
                streak_length_rad: odds.streak_length_rad,
                range_km: aspect.range_km,
                is_lower_limit: lateness.is_cut(),
            })
        };
        pieces.iter().filter_map(of).reduce(CrossingProbability::plus)
    }

    /// True where the Sun as it is during the piece shines on the path anywhere within the field, or, for a path beside
    /// it, where it passes by.
    fn is_lit(
        &self,
        piece: &Piece,
        arc: &OrbitArc,
        nominal: &Crossing,
        (from_s, to_s): (f64, f64),
        range_km: f64,
    ) -> bool {
        let sun = self.scene.sun.at_s(piece.mid_s()).sun;
        let is_lit_at =
            |time_s: f64| self.sky.shadow().illumination(&arc.state_at(time_s).position, &sun).lit_fraction() > 0.0;
        if is_lit_at(nominal.closest_s) {
            return true;
        }
        let speed_km_s = arc.state_at(nominal.closest_s).velocity.norm_km_s();
        let beside_s = self.field.bounding_radius_rad() * range_km / speed_km_s;
        let (enter_s, exit_s) = match (nominal.chords.first(), nominal.chords.last()) {
            (Some(first), Some(last)) => (first.enter_s, last.exit_s),
            _ => ((nominal.closest_s - beside_s).max(from_s), (nominal.closest_s + beside_s).min(to_s)),
        };
        (0..=LIGHT_STEPS).any(|step| is_lit_at(enter_s + (exit_s - enter_s) * f64::from(step) / f64::from(LIGHT_STEPS)))
    }
}
