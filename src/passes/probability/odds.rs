//! Probability of a crossing and expected streak length, for an observer at a site.
//!
//! The error of the predicted position is modelled as a shift in time along the track (`along_track_s`) and an
//! independent Gaussian shift across the track (`cross_track_rad`, as seen by the observer). Both are constant during
//! the exposure. A satellite that is late by δ is at time t where it was predicted for t - δ. Let the track that is
//! shifted by x across be in the field during the chords [a, b] of predicted time. The satellite is then in the field
//! during the exposure [0, T] if -b ≤ δ ≤ T - a, which has the probability
//!
//! P = ∫ dx N(x; σ_c) Σ_chords [F(T - a) - F(-b)]
//!
//! where F is the distribution function of the delay. The mean time that the satellite spends in the field is
//!
//! ∫ dx N(x; σ_c) Σ_chords ∫₀ᵀ dt [F(t - a) - F(t - b)]
//!
//! The integrals over δ and t are exact. The integral over x is a Gauss-Hermite sum if the field is wide compared with
//! the error across the track, otherwise a Gauss-Legendre sum over the shifts that lead through the field. `track` must
//! be seen from a site that is at rest before the shutter opens and after it closes, because a satellite that is
//! delayed into the exposure is seen from the site's position during the exposure.

use nalgebra::Vector3;

use super::super::crossing::{Crossing, cross};
use super::super::field::FieldOnSky;
use super::super::track::{Chord, Sight};
use super::delays::{Delays, Odds};

/// Largest shift across the track that is considered, in sigmas.
pub(in crate::passes) const REACH_SIGMAS: f64 = 3.5;
/// Largest error across the track, as a fraction of the field's radius, for which the five-point Gauss-Hermite rule is
/// used.
const WIDE_SHARE: f64 = 0.3;

/// Nodes and weights of the five-point Gauss-Hermite rule for a unit normal distribution (Abramowitz & Stegun, table
/// 25.10).
pub(super) const GAUSS_HERMITE: [(f64, f64); 5] = [
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_69),
    (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
];

/// Positive nodes, and weights, of the eight-point Gauss-Legendre rule on [-1, 1] (Abramowitz & Stegun, table 25.4).
const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_650, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887),
    (0.796_666_477_413_627, 0.222_381_034_453_374),
    (0.960_289_856_497_536, 0.101_228_536_290_376),
];

/// Returns the probability and the expected streak length of one satellite.
///
/// `track` is the predicted track, and `searched_s` the part of it that a delay or shift may bring into the field.
/// `nominal` is the crossing without a shift, `sigma_rad` the uncertainty across the track.
pub(in crate::passes) fn crossing_odds(
    track: &impl Fn(f64) -> Sight,
    nominal: &Crossing,
    searched_s: (f64, f64),
    delays: &Delays,
    field: &FieldOnSky,
    sigma_rad: f64,
) -> Odds {
    let radius_rad = field.bounding_radius_rad();
    if sigma_rad > 0.0 && nominal.min_separation_rad > radius_rad + 2.0 * REACH_SIGMAS * sigma_rad {
        return Odds::default();
    }
    let shifted = |shift_rad: f64| {
        if shift_rad == 0.0 {
            return delays.odds(&nominal.chords, length_on(track));
        }
        let shifted = |time_s: f64| shifted_across(&track(time_s), shift_rad);
        let chords = cross(&shifted, searched_s.0, searched_s.1, field).chords;
        delays.odds(&chords, length_on(&shifted))
    };
    if sigma_rad <= 0.0 {
        return shifted(0.0);
    }
    let mut total = Odds::default();
    let mut add = |shift_rad: f64, weight: f64| {
        if weight > 1e-9 {
            let odds = shifted(shift_rad);
            total.probability += weight * odds.probability;
            total.streak_length_rad += weight * odds.streak_length_rad;
        }
    };
    if sigma_rad <= WIDE_SHARE * radius_rad {
        for (node, weight) in GAUSS_HERMITE {
            add(node * sigma_rad, weight);
        }
    } else {
        // Shifts that lead through the field differ by at most its radius from the shift that leads through its centre.
        let through_rad = across(&track(nominal.closest_s)).map_or(0.0, |across| field.centre().dot(&across));
        let low_rad = (through_rad - radius_rad).max(-REACH_SIGMAS * sigma_rad);
        let high_rad = (through_rad + radius_rad).min(REACH_SIGMAS * sigma_rad);
        let (middle_rad, half_rad) = (0.5 * (low_rad + high_rad), 0.5 * (high_rad - low_rad));
        if half_rad > 0.0 {
            for (node, weight) in
                GAUSS_LEGENDRE.into_iter().flat_map(|(node, weight)| [(node, weight), (-node, weight)])
            {
                let shift_rad = middle_rad + half_rad * node;
                // N(x; σ_c) dx
                let z = shift_rad / sigma_rad;
                let density = (-0.5 * z * z).exp() / (sigma_rad * std::f64::consts::TAU.sqrt());
                add(shift_rad, weight * half_rad * density);
            }
        }
    }
    total.probability = total.probability.clamp(0.0, 1.0);
    total
}

/// Returns the unit vector across the track; `None` if the line of sight does not move.
fn across(sight: &Sight) -> Option<Vector3<f64>> {
    sight.vector.cross(&sight.rate_s).try_normalize(0.0)
}

/// Returns a function that computes the angle between both ends of a chord, radians.
fn length_on(track: &impl Fn(f64) -> Sight) -> impl Fn(&Chord) -> f64 {
    move |chord| {
        let (enter, exit) = (track(chord.enter_s).vector, track(chord.exit_s).vector);
        enter.cross(&exit).norm().atan2(enter.dot(&exit))
    }
}

/// Returns a line of sight that is shifted on the sky perpendicular to the track.
pub(super) fn shifted_across(sight: &Sight, shift_rad: f64) -> Sight {
    let unit = sight.vector.normalize();
    let across = unit.cross(&sight.rate_s);
    let norm = across.norm();
    let vector = if norm > 0.0 { unit + across * (shift_rad / norm) } else { unit };
    Sight { vector, rate_s: sight.rate_s }
}
