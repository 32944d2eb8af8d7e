//! Where to begin: a grid over the exponents with the linear coefficients solved inside.
//!
//! The cost has several local minima, nearly all of them by the exponents. For given exponents light is linear in c1 to c5, and
//! with weights 1/(σ F) residuals of light stand for those of magnitudes near the solution; a quadratic form between bounds.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::fit::form::{BLOCK, Evaluated};
use crate::fit::inference::minimise_in_box;

use super::earth::Exponents;
use super::kernel::{At, Numbers};
use super::shape::EXPONENTS;

/// Exponents that are tried where one is free.
const GRID: [f64; 7] = [0.8, 2.0, 5.0, 12.0, 30.0, 70.0, 150.0];
/// How many of the best are handed on.
const KEPT: usize = 6;
/// c1 to c5.
const LINEAR: usize = 5;

/// Complete parameter sets, the least cost first.
pub(super) fn search(
    at: &At,
    exponents: &Exponents,
    x: &[f64],
    free: &[usize],
    observed: &[(f64, f64)],
) -> Vec<Vec<f64>> {
    let grid = |i: usize| if free.contains(&i) { GRID.to_vec() } else { vec![x[i].clamp(EXPONENTS[0], EXPONENTS[1])] };
    let pairs: Vec<(f64, f64)> =
        grid(5).iter().flat_map(|&sail| grid(6).into_iter().map(move |base| (sail, base))).collect();
    let mut found: Vec<(f64, Vec<f64>)> =
        pairs.into_par_iter().filter_map(|pair| solved(at, exponents, x, free, observed, pair)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(KEPT);
    found.into_iter().map(|(_, place)| place).collect()
}

fn solved(
    at: &At,
    exponents: &Exponents,
    x: &[f64],
    free: &[usize],
    observed: &[(f64, f64)],
    (n_sail, n_base): (f64, f64),
) -> Option<(f64, Vec<f64>)> {
    let weights = exponents.weights(n_base);
    // Σ ((F - Σ c_k b_k) / (σ F))², F the light that was observed
    let (mut a, mut b) = (DMatrix::zeros(LINEAR, LINEAR), DVector::zeros(LINEAR));
    for (block, observed) in observed.chunks(BLOCK).enumerate() {
        let basis = at.basis(block, n_sail, n_base, &weights);
        for (lane, &(magnitude, per_sigma)) in observed.iter().enumerate() {
            let per_light = at.numbers.per_light(magnitude) * per_sigma;
            let row: [f64; LINEAR] = std::array::from_fn(|k| basis[k][lane] * per_light);
            for i in 0..LINEAR {
                b[i] += row[i] * per_sigma;
                (0..LINEAR).for_each(|j| a[(i, j)] += row[i] * row[j]);
            }
        }
    }
    let is_free = |k: usize| free.contains(&k);
    let bound = |k: usize, end: f64| if is_free(k) { end } else { x[k] };
    let least: Vec<f64> = (0..LINEAR).map(|k| bound(k, 0.0)).collect();
    let greatest: Vec<f64> = (0..LINEAR).map(|k| bound(k, 1.0)).collect();
    let c = minimise_in_box(&a, &b, &least, &greatest, &least)?;
    let mut place = x.to_vec();
    place[..LINEAR].copy_from_slice(&c);
    (place[5], place[6]) = (n_sail, n_base);
    // Ranked by what it costs in magnitudes; some light must be left for a magnitude to be.
    let moved = At {
        numbers: Numbers::new(&place, at.numbers.zero_mag()),
        blocks: at.blocks.as_ref().into(),
        earth: at.earth,
        weights,
    };
    let mut out = [0.0; BLOCK];
    let mut cost = 0.0;
    for (block, observed) in observed.chunks(BLOCK).enumerate() {
        moved.magnitudes(block, &mut out);
        cost +=
            observed.iter().zip(&out).map(|((m, per_sigma), computed)| robust((m - computed) * per_sigma)).sum::<f64>();
    }
    Some((cost, place))
}

/// √(1 + r²) - 1: wrong points must not choose where to begin.
fn robust(r: f64) -> f64 {
    (1.0 + r * r).sqrt() - 1.0
}
