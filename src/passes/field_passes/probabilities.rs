//! Probability that each satellite is in the field during an exposure, and expected length of its streak, including
//! near misses.
//!
//! Candidates are searched with all delays and all shifts across the track that the errors of their elements allow.
//! Delays beyond [`Lateness::LONGEST_S`](crate::orbit::Lateness::LONGEST_S) are not searched. If elements are so old
//! that longer delays are probable, the probability is marked as a lower limit.
//!
//! The site moves past many orbit planes during an exposure, by up to 280 km in ten minutes. If a satellite may be
//! delayed by more than a few seconds, the exposure is therefore divided into pieces of ten seconds. During each piece
//! the site is held at its position in the middle of the piece. A satellite enters the field only once. Its probability
//! is the probability that it is in the field during the first piece, plus the probabilities that it enters the field
//! during each of the other pieces. This sum never decreases with the length of the exposure.
//!
//! Two effects are neglected: the precession of the orbit plane during the delay, and the change of the chord's length
//! while the site moves through a piece. The range of delays counted for a piece is therefore slightly wrong, so that
//! consecutive pieces omit some delays or count some twice. For a satellite with an uncertainty of 17 s along the track
//! this changes the probability by up to 12 %; the sum over many satellites has no bias.
//!
//! If an exposure is longer than a revolution and the satellite returns, it is counted again; the probability is
//! limited to 1. For a telescope in orbit, the passes and near misses of [`Sky::field_passes`] are used.

use std::cell::OnceCell;

use super::super::candidates::PlacedCone;
use super::super::crossing::{Crossing, cross};
use super::super::evaluator::LOWEST_ALTITUDE_RAD;
use super::super::exposure::Exposure;
use super::super::field::Field;
use super::super::intervals::intervals_where;
use super::super::probability::{Delays, REACH_SIGMAS, crossing_odds};
use super::super::sky::Sky;
use super::super::track::{ObserverMotion, Pass, SightLine};
use super::exposed_field::ExposedField;
use super::options::PassOptions;
use crate::error::Error;
use crate::frames::{Orientation, seconds_after};
use crate::geometry::{Aspect, Observer, ViewingGeometry};
use crate::orbit::{Cones, CrossingCandidate, OrbitArc, OrbitUncertainty, SearchScope};
use crate::photometry::{Band, PhotometryOptions};

/// Length of a piece of an exposure, seconds. During a piece the site moves by at most 5 km. At the distance of
/// satellites this is small compared with the width of a field of several degrees.
const PIECE_S: f64 = 10.0;
/// Length of the parts into which an exposure is divided for the search of candidates, seconds.
const SEARCHED_S: f64 = 60.0;
/// Longest delay, seconds, up to which the exposure is not divided into pieces.
const ON_TIME_S: f64 = 10.5;
/// Number of equal steps into which a satellite's path through the field is divided to find the intervals in which it
/// is lit.
const LIGHT_STEPS: usize = 24;
/// Smallest probability with which near misses are included for a telescope in orbit.
const LEAST_IN_FLIGHT: f64 = 0.01;

/// Probability that one satellite is in the field during one exposure, and its expected streak.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CrossingProbability {
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Probability that the satellite is in the field at any time of the exposure, (0, 1].
    pub probability: f64,
    /// Expected length of the satellite's streak within the field, radians. It is the average over all errors of the
    /// position; errors with which the satellite misses the field count with length 0. If the satellite is lit only on
    /// a part of its predicted path, the length is reduced in proportion.
    pub streak_length_rad: f64,
    /// One-sigma error along the track as a time, seconds.
    pub along_track_sigma_s: f64,
    /// Sun, satellite and observer at the time at which its path is nearest to the centre of the field.
    pub geometry: ViewingGeometry,
    /// Fraction of the Sun's light that reaches the satellite at that time, [0, 1].
    pub lit_fraction: f64,
    /// Angular speed at that time, rad/s.
    pub angular_rate_rad_s: f64,
    /// True if the elements are so old that delays beyond the searched ones are probable. Probability and streak length
    /// are then lower limits.
    pub is_lower_limit: bool,
}

impl CrossingProbability {
    /// Adds the result for the next part of the same exposure.
    fn plus(self, next: Self) -> Self {
        Self {
            probability: (self.probability + next.probability).min(1.0),
            streak_length_rad: self.streak_length_rad + next.streak_length_rad,
            ..self
        }
    }
}

/// Piece of an exposure. Times are seconds after the start of the scene.
struct Piece {
    start_s: f64,
    end_s: f64,
    /// True for all pieces except the first. Satellites that are already in the field when a piece begins are counted
    /// in the previous pieces.
    only_entering: bool,
    /// Orientation of the Earth at the middle of the piece.
    orientation: Orientation,
    site: ObserverMotion,
}

impl Piece {
    fn mid_s(&self) -> f64 {
        0.5 * (self.start_s + self.end_s)
    }
}

impl Sky {
    /// Returns, for each exposure, the satellites that may be in the field while they are sunlit, with their
    /// probabilities, in catalogue order.
    ///
    /// With recent elements, these are the predicted crossings and few others. With elements that are weeks old, they
    /// are all satellites that pass near the field within minutes of the exposure, each with a small probability.
    ///
    /// # Errors
    /// The errors of [`Sky::field_passes`].
    pub fn crossing_probabilities(
        &self,
        exposures: &[Exposure],
        field: &Field,
    ) -> Result<Vec<Vec<CrossingProbability>>, Error> {
        self.probabilities_with(exposures, field, false, Band::V)
    }

    /// Returns the same probabilities; for a telescope in orbit with those of satellites in the Earth's shadow if
    /// `include_dark`, whose streaks then have the length of the whole track. In the thermal bands W1 and W2 sunlit and
    /// other satellites count alike.
    pub(crate) fn probabilities_with(
        &self,
        exposures: &[Exposure],
        field: &Field,
        include_dark: bool,
        band: Band,
    ) -> Result<Vec<Vec<CrossingProbability>>, Error> {
        let Some(observer) = self.viewpoint().site() else {
            return self.probabilities_in_flight(exposures, field, include_dark, band);
        };
        let (by_exposure, _) = self.by_exposure(exposures, SearchScope::Delayed, |scene, (_, exposure), seen| {
            let exposed = ExposedField::new(self, scene, exposure, field)?;
            Ok((exposed.probabilities(observer, band.is_thermal(), seen)?, Vec::new()))
        })?;
        Ok(by_exposure)
    }

    fn probabilities_in_flight(
        &self,
        exposures: &[Exposure],
        field: &Field,
        include_dark: bool,
        band: Band,
    ) -> Result<Vec<Vec<CrossingProbability>>, Error> {
        let options = PassOptions {
            photometry: PhotometryOptions::in_band(band, band.usual_system()),
            include_dark,
            min_probability: Some(LEAST_IN_FLIGHT),
            without_light: true,
            ..PassOptions::default()
        };
        let passes = self.field_passes(exposures, field, &options)?.by_exposure;
        // The mean length of the chords of a circle is π/2 times its radius.
        let mean_chord_rad = std::f64::consts::FRAC_PI_2 * field.bounding_radius_rad();
        let length_rad = |pass: &Pass, exposure: &Exposure| match (pass.is_crossing(), include_dark) {
            (true, true) => pass.track_length_rad,
            (true, false) => pass.streak_length_rad,
            (false, _) => mean_chord_rad.min(pass.angular_rate_rad_s * exposure.duration_s),
        };
        let is_cut = |pass: &Pass, exposure: &Exposure| {
            let shutter_s = [0.0, exposure.duration_s];
            let middle = seconds_after(exposure.start, 0.5 * exposure.duration_s);
            self.propagator_over(exposure.start, pass.element_index, shutter_s)
                .is_some_and(|propagator| self.uncertainty_of(pass.element_index, propagator, middle).lateness.is_cut())
        };
        let of = |(passes, exposure): (Vec<Pass>, &Exposure)| {
            let mut found: Vec<CrossingProbability> = passes
                .iter()
                .filter(|pass| pass.probability > 0.0)
                .map(|pass| CrossingProbability {
                    element_index: pass.element_index,
                    probability: pass.probability,
                    streak_length_rad: pass.probability * length_rad(pass, exposure),
                    along_track_sigma_s: pass.along_track_sigma_s,
                    geometry: pass.mid.geometry,
                    lit_fraction: pass.mid.illumination.lit_fraction(),
                    angular_rate_rad_s: pass.angular_rate_rad_s,
                    is_lower_limit: is_cut(pass, exposure),
                })
                .collect();
            found.sort_by_key(|satellite| satellite.element_index);
            found
        };
        Ok(passes.into_iter().zip(exposures).map(of).collect())
    }
}

impl ExposedField<'_> {
    /// Returns the probabilities of all satellites that may be in the exposure, sunlit or not if `with_shadow`. `seen`
    /// is a buffer that is reused.
    fn probabilities(
        &self,
        observer: &Observer,
        with_shadow: bool,
        seen: &mut Vec<CrossingCandidate>,
    ) -> Result<Vec<CrossingProbability>, Error> {
        let parts = self.cut(observer, self.opened_s, self.closed_s, SEARCHED_S);
        // The pieces are computed only if a satellite may be late.
        let pieces: Vec<OnceCell<Vec<Piece>>> = parts.iter().map(|_| OnceCell::new()).collect();
        let shadow = (!with_shadow).then(|| self.sky.dark_cone(self.scene, self.exposure));
        seen.clear();
        for (first, part) in (0..).zip(&parts) {
            self.sky.watch().check()?;
            let times_s = (part.mid_s(), 0.5 * (part.end_s - part.start_s));
            let near = (&part.site, &part.orientation);
            let Some(PlacedCone { window, cone, teme_to_gcrs }) =
                self.sky.cone(self.scene, self.exposure, &self.field, near, times_s)
            else {
                continue;
            };
            let cones = Cones { whole: &cone, parts: &[], first, shadow: shadow.as_ref(), scope: self.scene.scope };
            window.candidates(&cones, &teme_to_gcrs, seen);
        }
        seen.retain(|candidate| !candidate.is_dark);
        seen.sort_unstable_by_key(|candidate| (candidate.element_index, candidate.cone));
        let whole = self.whole(observer);
        let mid = seconds_after(self.scene.start, whole.mid_s());
        let of_one = |candidates: &[CrossingCandidate]| {
            let element_index = candidates[0].element_index as usize;
            let propagator = self.propagator(element_index)?;
            let sigma = self.sky.uncertainty_of(element_index, propagator, mid);
            let near_s = |candidate: &CrossingCandidate| {
                let mid_s = parts[candidate.cone as usize].mid_s();
                candidate.near_s.map(|time_s| mid_s + f64::from(time_s))
            };
            if sigma.lateness.reach_s() < ON_TIME_S {
                let all_s = candidates
                    .iter()
                    .map(near_s)
                    .reduce(|times_s, next| [times_s[0].min(next[0]), times_s[1].max(next[1])]);
                let whole = std::slice::from_ref(&whole);
                return self.visible_probability(whole, observer, element_index, all_s?, sigma, with_shadow);
            }
            let of_parts = candidates.iter().filter_map(|candidate| {
                let part = candidate.cone as usize;
                let pieces =
                    pieces[part].get_or_init(|| self.cut(observer, parts[part].start_s, parts[part].end_s, PIECE_S));
                self.visible_probability(pieces, observer, element_index, near_s(candidate), sigma, with_shadow)
            });
            of_parts.reduce(CrossingProbability::plus)
        };
        let mut found = Vec::new();
        for of_satellite in seen.chunk_by(|first, other| first.element_index == other.element_index) {
            self.sky.watch().check()?;
            found.extend(of_one(of_satellite));
        }
        Ok(found)
    }

    /// Returns the probability that a satellite, sunlit or not, is in the field at any time of the exposure, for an
    /// observer at a site.
    ///
    /// Only predicted times within `searched_s`, which `arc` covers, are considered. This is one pass of the satellite,
    /// extended on both sides by the longest delay.
    pub(super) fn probability_at_site(
        &self,
        observer: &Observer,
        element_index: usize,
        arc: &OrbitArc,
        searched_s: (f64, f64),
        sigma: OrbitUncertainty,
    ) -> f64 {
        let pieces = if sigma.lateness.reach_s() < ON_TIME_S {
            vec![self.whole(observer)]
        } else {
            self.cut(observer, self.opened_s, self.closed_s, PIECE_S)
        };
        let of_piece = |piece: &Piece| {
            let reach_s = sigma.lateness.reach_s();
            let (from_s, to_s) = (searched_s.0.max(piece.start_s - reach_s), searched_s.1.min(piece.end_s + reach_s));
            if from_s > to_s {
                return None;
            }
            self.probability_in(piece, element_index, arc, [from_s, to_s], sigma, |_, _| 1.0)
        };
        pieces
            .iter()
            .filter_map(of_piece)
            .reduce(CrossingProbability::plus)
            .map_or(0.0, |crossing| crossing.probability)
    }

    /// Divides a part of the exposure into pieces that are counted from its start, so that a longer exposure begins
    /// with the same pieces.
    fn cut(&self, observer: &Observer, start_s: f64, end_s: f64, length_s: f64) -> Vec<Piece> {
        let count = ((end_s - start_s) / length_s).ceil().max(1.0) as u32;
        let piece = |number: u32| {
            let from_s = start_s + length_s * f64::from(number);
            self.piece(observer, from_s, end_s.min(from_s + length_s), from_s > self.opened_s)
        };
        (0..count).map(piece).collect()
    }

    /// Returns the whole exposure as one piece, during which the site moves.
    fn whole(&self, observer: &Observer) -> Piece {
        let mut whole = self.piece(observer, self.opened_s, self.closed_s, false);
        whole.site = whole.site.still_outside(whole.start_s, whole.end_s);
        whole
    }

    fn piece(&self, observer: &Observer, start_s: f64, end_s: f64, only_entering: bool) -> Piece {
        let mid_s = 0.5 * (start_s + end_s);
        let orientation = self.scene.orientation.at_s(mid_s);
        let earth_velocity = self.scene.sun.at_s(mid_s).earth_velocity;
        let site = ObserverMotion::of_site(observer, &orientation, earth_velocity, mid_s);
        Piece { start_s, end_s, only_entering, orientation, site }
    }

    /// Returns the probability of a satellite in several pieces, counted while it is above the ground and, unless
    /// `with_shadow`, sunlit. Its predicted track is near the field from `from_s` to `to_s`. `None` if it cannot be in
    /// the field or has no position.
    fn visible_probability(
        &self,
        pieces: &[Piece],
        observer: &Observer,
        element_index: usize,
        [from_s, to_s]: [f64; 2],
        sigma: OrbitUncertainty,
        with_shadow: bool,
    ) -> Option<CrossingProbability> {
        let propagator = self.propagator(element_index)?;
        let minutes = propagator.minutes_since_epoch(self.scene.start);
        let teme_to_gcrs = &pieces[pieces.len() / 2].orientation.teme_to_gcrs;
        let arc = OrbitArc::new(propagator, minutes, from_s, to_s - from_s, teme_to_gcrs).ok()?;
        let of_piece = |piece: &Piece| {
            let visible_share = |nominal: &Crossing, nearest: &Aspect| {
                let sine = observer.state(&piece.orientation).sine_of_altitude(&nearest.geometric);
                if sine < LOWEST_ALTITUDE_RAD.sin() {
                    return 0.0;
                }
                if with_shadow {
                    return 1.0;
                }
                self.lit_share(piece, &arc, nominal, (from_s, to_s), nearest.range_km)
            };
            self.probability_in(piece, element_index, &arc, [from_s, to_s], sigma, visible_share)
        };
        pieces.iter().filter_map(of_piece).reduce(CrossingProbability::plus)
    }

    /// Returns the probability that a satellite crosses the field in one piece of the exposure. `None` if it cannot be
    /// in the field, or if no part of its predicted crossing is visible. `visible_share` returns the visible part of
    /// the crossing as a fraction of its time; it also receives the satellite's aspect where it is nearest to the
    /// centre of the field.
    fn probability_in(
        &self,
        piece: &Piece,
        element_index: usize,
        arc: &OrbitArc,
        [from_s, to_s]: [f64; 2],
        sigma: OrbitUncertainty,
        visible_share: impl Fn(&Crossing, &Aspect) -> f64,
    ) -> Option<CrossingProbability> {
        let is_late = sigma.lateness.reach_s() >= ON_TIME_S;
        let still = if is_late { piece.site.still_outside(piece.mid_s(), piece.mid_s()) } else { piece.site.clone() };
        let line = SightLine { arc, observer: still };
        let track = |time_s: f64| line.sight(time_s);
        let nominal = cross(&track, from_s, to_s, &self.field);
        let (state, observer, aspect) = line.aspect_at(nominal.closest_s);
        let cross_track_rad = sigma.cross_track_km / aspect.range_km;
        if nominal.min_separation_rad > self.field.bounding_radius_rad() + REACH_SIGMAS * cross_track_rad {
            return None;
        }
        let visible_share = visible_share(&nominal, &aspect);
        if visible_share <= 0.0 {
            return None;
        }
        // If the site moves in the same direction as the satellite, the satellite enters the field later. In the time
        // dt the entry is delayed by dt u·v / v², where u is the velocity of the site and v the velocity of the
        // satellite across the line of sight.
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
        if odds.probability <= 0.0 {
            return None;
        }
        let sun = self.scene.sun.at_s(piece.mid_s()).sun;
        Some(CrossingProbability {
            element_index,
            probability: odds.probability.min(1.0),
            streak_length_rad: odds.streak_length_rad * visible_share,
            along_track_sigma_s: sigma.along_track_s,
            geometry: ViewingGeometry::new(&state.position, &observer, &sun)?,
            lit_fraction: self.sky.shadow().illumination(&state.position, &sun).lit_fraction(),
            angular_rate_rad_s: track(nominal.closest_s).angular_rate_rad_s(),
            is_lower_limit: lateness.is_cut(),
        })
    }

    /// Returns the fraction of the time on the path within the field in which the satellite is lit; the Sun is at its
    /// position at the middle of the piece. For a path that misses the field, the part nearest to the field counts.
    fn lit_share(
        &self,
        piece: &Piece,
        arc: &OrbitArc,
        nominal: &Crossing,
        (from_s, to_s): (f64, f64),
        range_km: f64,
    ) -> f64 {
        let sun = self.scene.sun.at_s(piece.mid_s()).sun;
        let is_lit_at = |time_s: f64| self.sky.shadow().illumination(&arc.state_at(time_s).position, &sun).is_lit();
        let speed_km_s = arc.state_at(nominal.closest_s).velocity.norm_km_s();
        let beside_s = self.field.bounding_radius_rad() * range_km / speed_km_s;
        let (enter_s, exit_s) = match (nominal.chords.first(), nominal.chords.last()) {
            (Some(first), Some(last)) => (first.enter_s, last.exit_s),
            _ => ((nominal.closest_s - beside_s).max(from_s), (nominal.closest_s + beside_s).min(to_s)),
        };
        if exit_s <= enter_s {
            return f64::from(u8::from(is_lit_at(nominal.closest_s)));
        }
        let lit = intervals_where(enter_s, exit_s, LIGHT_STEPS, is_lit_at);
        lit.iter().map(|(from_s, to_s)| to_s - from_s).sum::<f64>() / (exit_s - enter_s)
    }
}
