//! How likely a crossing is, given how wrong the element set may be.
//!
//! First form. The error of the predicted place is taken as a shift in time along the track (Gaussian, `along_track_s`) and an
//! independent shift across it (Gaussian, `cross_track_rad` as seen by the observer); both are constant over the exposure.
//! A satellite that is late by δ stands at time t where it was predicted for t - δ. The track shifted across by x meets the
//! field during chords [a, b] of its own time, so it crosses the exposure [0, T] when -b ≤ δ ≤ T - a:
//!
//! P = ∫ dx N(x; σ_c) Σ_chords [Φ((T - a)/σ_t) - Φ(-b/σ_t)]
//!
//! The integral over x is a Gauss-Hermite sum, that over δ is exact. Before the shutter opens and after it closes the site
//! stands still, so that a satellite brought in by its delay is seen from the right place.

use super::crossing::{Sight, cross};
use super::field::FieldOnSky;
use super::track::Chord;

/// Shifts further than this from the prediction are not looked for, in sigmas.
pub(super) const REACH_SIGMAS: f64 = 3.5;
/// Nor beyond this time, seconds: by then the elements say no more than that there is a satellite in this orbit.
pub(super) const LONGEST_REACH_S: f64 = 300.0;

/// Nodes and weights of the five-point Gauss-Hermite rule for a unit normal distribution (Abramowitz & Stegun, table 25.10).
const GAUSS_HERMITE: [(f64, f64); 5] = [
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
    (2.856_970_013_872_806, 0.011_257_411_327_720_69),
    (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
];

/// How far along the track a search for this sigma goes, seconds.
pub(super) fn reach_s(along_track_sigma_s: f64) -> f64 {
    (REACH_SIGMAS * along_track_sigma_s).min(LONGEST_REACH_S)
}

/// Probability that the satellite is inside the field at any time of [`start_s`, `end_s`].
///
/// `track` is that of the prediction over `searched_s`: the part of the exposure in which it may matter, widened by
/// [`reach_s`] on both sides.
pub(super) fn crossing_probability(
    track: &impl Fn(f64) -> Sight,
    searched_s: (f64, f64),
    (start_s, end_s): (f64, f64),
    field: &FieldOnSky,
    along_track_sigma_s: f64,
    cross_track_sigma_rad: f64,
) -> f64 {
    let chance = |shift_rad: f64| {
        let shifted = |time_s: f64| shifted_across(&track(time_s), shift_rad);
        let chords = cross(&shifted, searched_s.0, searched_s.1, field).chords;
        delay_probability(&chords, start_s, end_s, along_track_sigma_s)
    };
    let total: f64 = if cross_track_sigma_rad > 0.0 {
        GAUSS_HERMITE.iter().map(|(node, weight)| weight * chance(node * cross_track_sigma_rad)).sum()
    } else {
        chance(0.0)
    };
    total.clamp(0.0, 1.0)
}

/// Delays that are tried for an observer in orbit.
const DELAYS: usize = 81;

/// As [`crossing_probability`] for an observer that moves as fast as the satellites: a late satellite then takes another way through the field,
/// not the same one later.
///
/// `track` gives the line of sight at a time to a satellite that is late by a number of seconds. Delays of up to [`REACH_SIGMAS`] are tried in equal steps,
/// each for the stretch of the normal distribution around it: good to a few hundredths, no better than what a Gaussian says of an element set.
pub(super) fn crossing_probability_in_flight(
    track: &impl Fn(f64, f64) -> Sight,
    (start_s, end_s): (f64, f64),
    field: &FieldOnSky,
    along_track_sigma_s: f64,
    cross_track_sigma_rad: f64,
) -> f64 {
    let reach_s = reach_s(along_track_sigma_s);
    let step_s = 2.0 * reach_s / DELAYS as f64;
    let crosses = |late_s: f64, shift_rad: f64| {
        let shifted = |time_s: f64| shifted_across(&track(time_s, late_s), shift_rad);
        !cross(&shifted, start_s, end_s, field).chords.is_empty()
    };
    let chance = |shift_rad: f64| -> f64 {
        if reach_s <= 0.0 {
            return f64::from(u8::from(crosses(0.0, shift_rad)));
        }
        (0..DELAYS)
            .map(|delay| (step_s * (delay as f64 + 0.5) - reach_s, step_s))
            .filter(|(late_s, _)| crosses(*late_s, shift_rad))
            .map(|(late_s, width_s)| {
                normal_cdf(late_s + 0.5 * width_s, along_track_sigma_s)
                    - normal_cdf(late_s - 0.5 * width_s, along_track_sigma_s)
            })
            .sum()
    };
    let total: f64 = if cross_track_sigma_rad > 0.0 {
        GAUSS_HERMITE.iter().map(|(node, weight)| weight * chance(node * cross_track_sigma_rad)).sum()
    } else {
        chance(0.0)
    };
    total.clamp(0.0, 1.0)
}

/// A line of sight shifted square to the track, on the sky.
fn shifted_across(sight: &Sight, shift_rad: f64) -> Sight {
    let unit = sight.vector.normalize();
    let across = unit.cross(&sight.rate_s);
    let norm = across.norm();
    let vector = if norm > 0.0 { unit + across * (shift_rad / norm) } else { unit };
    Sight { vector, rate_s: sight.rate_s }
}

/// Share of delays that bring one of the chords into the exposure. Ranges of delay of neighbouring chords are joined.
fn delay_probability(chords: &[Chord], start_s: f64, end_s: f64, sigma_s: f64) -> f64 {
    let mut ranges: Vec<(f64, f64)> =
        chords.iter().map(|chord| (start_s - chord.exit_s, end_s - chord.enter_s)).collect();
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut total, mut done) = (0.0, f64::NEG_INFINITY);
    for (low, high) in ranges {
        if high > done {
            total += normal_cdf(high, sigma_s) - normal_cdf(low.max(done), sigma_s);
            done = high;
        }
    }
    total
}

/// Φ(x/σ); a step for σ = 0, the border counting as inside.
fn normal_cdf(x: f64, sigma: f64) -> f64 {
    if sigma > 0.0 {
        0.5 * libm::erfc(-x / sigma * std::f64::consts::FRAC_1_SQRT_2)
    } else if x >= 0.0 {
        1.0
    } else {
        0.0
    }
}
