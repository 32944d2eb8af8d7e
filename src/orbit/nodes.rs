//! States of an ephemeris through which its positions are interpolated.
//!
//! Position and velocity at a time are those of the Lagrange polynomial of degree 7 through the positions of eight
//! states. Its error on an orbit of radius r and rate ω is the sum of the neglected eighth derivative and of the errors
//! δ of the positions, which the basis polynomials ℓᵢ amplify:
//!
//! ```text
//! r ω⁸ / 8! · Π |t - tᵢ| + δ Σ |ℓᵢ(t)|
//! ```
//!
//! Where steps are equal, the eight states nearest to the time are used. With the longest step, a twentieth of a
//! revolution, the first term is then 0.7 m at a height of 550 km, and 9 m in the first and last interval. Where steps
//! are unequal, neighbouring states may be so close together that the second term is large, or all on one side of the
//! time, so that the first term is large. Then states with larger distances in time are also tried, and those with the
//! least sum are used. An interval with a longer step, or with a sum above 20 m for δ = 1 m, is a gap, across which
//! nothing is interpolated. So is an interval whose polynomial contains a wrong position: one that differs by more than
//! 100 m, and more than the two terms explain, from the polynomial through its eight neighbours.

use std::f64::consts::TAU;
use std::ops::Range;

use hifitime::Epoch;
use nalgebra::Vector3;

use crate::constants::WGS72_MU_KM3_S2;

/// Number of states of the polynomial.
pub(super) const NODES: usize = 8;
/// Longest step between two states across which positions are interpolated, as an angle about the Earth's centre.
const LONGEST_STEP_RAD: f64 = TAU / 20.0;
/// Largest error of the interpolation, km.
const LARGEST_ERROR_KM: f64 = 0.02;
/// Error of the interpolation below which no other states are tried, km.
const SMALL_ERROR_KM: f64 = 0.004;
/// Largest difference of a position from the polynomial through its neighbours, km, beside the error of that
/// polynomial.
const LARGEST_DIFFERENCE_KM: f64 = 0.1;
/// Error of the positions in a file, km: the rounding of the coarsest files, a metre.
const STATE_ERROR_KM: f64 = 0.001;
/// Least times between the states of the polynomial, tried in this order, as fractions of the step that contains the
/// time.
const SPACINGS: [f64; 4] = [0.0, 0.25, 0.5, 1.0];

/// Returns the states of the polynomial between each state and the next one; `None` for gaps.
pub(super) fn chosen_nodes(times_s: &[f64], positions: &[Vector3<f64>]) -> Vec<Option<[u32; NODES]>> {
    let is_gap = |step: usize| step_rad(times_s, positions, step, step + 1) > LONGEST_STEP_RAD;
    let wrong: Vec<bool> = (0..times_s.len()).map(|state| is_wrong(times_s, positions, state)).collect();
    let mut chosen = Vec::with_capacity(times_s.len() - 1);
    let mut part = 0..0;
    for step in 0..times_s.len() - 1 {
        if step + 1 >= part.end {
            // The states up to the next long step.
            let start = step + usize::from(is_gap(step));
            let end = (start..times_s.len() - 1).find(|&later| is_gap(later)).map_or(times_s.len(), |later| later + 1);
            part = start..end;
        }
        let is_inside = part.contains(&step) && step + 1 < part.end && part.len() >= NODES;
        let nodes = if is_inside { best_nodes(times_s, positions, &part, step) } else { None };
        chosen.push(nodes.filter(|nodes| !nodes.iter().any(|node| wrong[*node as usize])));
    }
    chosen
}

/// Returns why nothing is interpolated between a state and the next one; `epoch` returns the time of a state.
pub(super) fn gap_reason(
    times_s: &[f64],
    positions: &[Vector3<f64>],
    step: usize,
    epoch: impl Fn(usize) -> Epoch,
) -> String {
    let step_s = times_s[step + 1] - times_s[step];
    let longest_s = step_s * LONGEST_STEP_RAD / step_rad(times_s, positions, step, step + 1);
    let near = step.saturating_sub(NODES)..(step + NODES).min(times_s.len());
    // The neighbours of a wrong position differ too, but less.
    let off_km = |state: &usize| off_curve(times_s, positions, *state);
    let worst = near.max_by(|first, other| {
        let [first, other] = [first, other].map(|state| off_km(state).map_or(0.0, |(km, _)| km));
        first.total_cmp(&other)
    });
    let worst = worst.and_then(|state| Some((state, off_km(&state).filter(|(km, allowed_km)| km > allowed_km)?.0)));
    if step_s > longest_s {
        format!("states {step_s:.0} s apart; allowed: {longest_s:.0} s, a twentieth of a revolution")
    } else if let Some((state, km)) = worst {
        let state = epoch(state);
        format!(
            "the state of {state} is {km:.1} km off the curve through its neighbours; allowed: {LARGEST_DIFFERENCE_KM} km"
        )
    } else {
        let largest_m = 1e3 * LARGEST_ERROR_KM;
        format!("states {step_s:.0} s apart, and too few around them for an error below {largest_m} m")
    }
}

/// Returns true if the position of a state differs from the polynomial through its eight neighbours by more than their
/// errors. The neighbours of a wrong position may differ too, because their polynomials contain it.
fn is_wrong(times_s: &[f64], positions: &[Vector3<f64>], state: usize) -> bool {
    off_curve(times_s, positions, state).is_some_and(|(off_km, allowed_km)| off_km > allowed_km)
}

/// Returns the difference of the position of a state from the polynomial through its eight neighbours, and the allowed
/// one, km; `None` if there are too few neighbours.
fn off_curve(times_s: &[f64], positions: &[Vector3<f64>], state: usize) -> Option<(f64, f64)> {
    let latest = times_s.len().checked_sub(NODES + 1)?;
    let first = state.saturating_sub(NODES / 2).min(latest);
    let nodes: [usize; NODES] = std::array::from_fn(|node| first + node + usize::from(first + node >= state));
    let of_nodes = (nodes.map(|node| times_s[node]), nodes.map(|node| positions[node]));
    let (expected, _) = lagrange(of_nodes.0, of_nodes.1, times_s[state]);
    let allowed_km = LARGEST_DIFFERENCE_KM + error_at_km(times_s, positions, &nodes, times_s[state]);
    Some(((positions[state] - expected).norm(), allowed_km))
}

/// Returns the angle about the Earth's centre between two states: the larger of the angle between their directions and
/// the angle on a circular orbit at the smaller of the two radii. The latter includes whole revolutions.
fn step_rad(times_s: &[f64], positions: &[Vector3<f64>], from: usize, to: usize) -> f64 {
    let radius_km = positions[from].norm().min(positions[to].norm());
    // ω² = μ / r³
    let circular_rad = (WGS72_MU_KM3_S2 / radius_km.powi(3)).sqrt() * (times_s[to] - times_s[from]);
    // Accurate also for states that are close together.
    let seen_rad = positions[from].cross(&positions[to]).norm().atan2(positions[from].dot(&positions[to]));
    circular_rad.max(seen_rad)
}

/// Returns the eight states with the least error between a state and the next one; `None` if it is too large.
fn best_nodes(times_s: &[f64], positions: &[Vector3<f64>], part: &Range<usize>, step: usize) -> Option<[u32; NODES]> {
    let step_s = times_s[step + 1] - times_s[step];
    // With equal steps the states around the time are the best ones.
    let first = step.checked_sub(NODES / 2 - 1).filter(|first| part.start <= *first && first + NODES <= part.end);
    if let Some(first) = first
        && times_s[first..first + NODES].windows(2).all(|pair| (pair[1] - pair[0] - step_s).abs() < 1e-3 * step_s)
    {
        return Some(std::array::from_fn(|node| (first + node) as u32));
    }
    let mut best: Option<(f64, [usize; NODES])> = None;
    for spacing in SPACINGS {
        let Some(nodes) = spaced_nodes(times_s, part, step, spacing * step_s) else { continue };
        let error_km = error_km(times_s, positions, &nodes, step);
        if best.is_none_or(|(least, _)| error_km < least) {
            best = Some((error_km, nodes));
        }
        if error_km < SMALL_ERROR_KM {
            break;
        }
    }
    best.filter(|(error_km, _)| *error_km <= LARGEST_ERROR_KM).map(|(_, nodes)| nodes.map(|node| node as u32))
}

/// Returns the eight states nearest in time to the middle of a step: both ends of the step, and further states, each
/// at least `spacing_s` from the previous one on its side. `None` if there are too few.
fn spaced_nodes(times_s: &[f64], part: &Range<usize>, step: usize, spacing_s: f64) -> Option<[usize; NODES]> {
    let middle_s = 0.5 * (times_s[step] + times_s[step + 1]);
    let (mut nodes, mut count) = ([step; NODES], 2);
    nodes[1] = step + 1;
    let before = |first: usize| {
        let count = times_s[part.start..first].partition_point(|time| *time <= times_s[first] - spacing_s);
        count.checked_sub(1).map(|index| part.start + index)
    };
    let after = |last: usize| {
        let skipped = times_s[last + 1..part.end].partition_point(|time| *time < times_s[last] + spacing_s);
        Some(last + 1 + skipped).filter(|index| *index < part.end)
    };
    let (mut below, mut above) = (before(step), after(step + 1));
    while count < NODES {
        let is_below = match (below, above) {
            (Some(below), Some(above)) => middle_s - times_s[below] < times_s[above] - middle_s,
            (below, None) => {
                below?;
                true
            }
            (None, Some(_)) => false,
        };
        let next = if is_below { below } else { above }?;
        nodes[count] = next;
        count += 1;
        if is_below { below = before(next) } else { above = after(next) }
    }
    nodes.sort_unstable();
    Some(nodes)
}

/// Returns the largest error of the polynomial through some states at three times within a step, km.
fn error_km(times_s: &[f64], positions: &[Vector3<f64>], nodes: &[usize; NODES], step: usize) -> f64 {
    let at = |share: f64| times_s[step] + share * (times_s[step + 1] - times_s[step]);
    let errors_km = [0.25, 0.5, 0.75].map(|share| error_at_km(times_s, positions, nodes, at(share)));
    errors_km.into_iter().fold(0.0, f64::max)
}

/// Returns the error of the polynomial through some states at a time, km.
fn error_at_km(times_s: &[f64], positions: &[Vector3<f64>], nodes: &[usize; NODES], time_s: f64) -> f64 {
    let rate_rad_s = nodes.windows(2).map(|pair| {
        let [from, to] = [pair[0], pair[1]];
        step_rad(times_s, positions, from, to) / (times_s[to] - times_s[from])
    });
    let rate_rad_s = rate_rad_s.fold(0.0, f64::max);
    let radius_km = nodes.iter().map(|node| positions[*node].norm()).fold(0.0, f64::max);
    // r ω⁸ / 8! · Π |t - tᵢ|, with 8! = 40320
    let neglected =
        nodes.iter().fold(radius_km / 40_320.0, |product, node| product * rate_rad_s * (time_s - times_s[*node]).abs());
    // Σ |ℓᵢ(t)|
    let amplification: f64 = nodes
        .iter()
        .map(|node| {
            let others = nodes.iter().filter(|other| *other != node);
            others.fold(1.0, |product, other| {
                product * ((time_s - times_s[*other]) / (times_s[*node] - times_s[*other])).abs()
            })
        })
        .sum();
    neglected + STATE_ERROR_KM * amplification
}

/// Returns value and derivative of the polynomial through some positions, by Newton's divided differences.
pub(super) fn lagrange(
    times_s: [f64; NODES],
    mut differences: [Vector3<f64>; NODES],
    time_s: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    for order in 1..NODES {
        for node in (order..NODES).rev() {
            differences[node] = (differences[node] - differences[node - 1]) / (times_s[node] - times_s[node - order]);
        }
    }
    let (mut value, mut slope) = (differences[NODES - 1], Vector3::zeros());
    for node in (0..NODES - 1).rev() {
        let since_s = time_s - times_s[node];
        slope = slope * since_s + value;
        value = value * since_s + differences[node];
    }
    (value, slope)
}
