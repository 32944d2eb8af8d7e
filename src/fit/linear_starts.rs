//! Starting points of a fit: a grid over the nonlinear parameters, at each node of which the linear parameters are
//! solved for.
//!
//! The cost has several local minima, nearly all of which are caused by exponents and widths. For given exponents and
//! widths the light F is linear in the weights. Near the solution, residuals of light with errors σ F approximate
//! residuals of magnitudes, so that the best weights minimise a quadratic form within bounds.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::form::{LEAST_M2_SR, Parameter};
use super::inference::minimise_in_box;

/// A form whose light is linear in some of its parameters.
pub(super) trait Basis: Sync {
    /// Returns the light of every point, m² sr⁻¹, for these values of all parameters.
    fn light(&self, x: &[f64]) -> Vec<f64>;
}

/// Grid nodes of each nonlinear parameter, as fractions of the interval between its bounds. The interval is logarithmic
/// if the lower bound is positive.
const SHARES: [f64; 4] = [0.12, 0.37, 0.62, 0.87];
/// Largest number of grid nodes; larger grids are thinned out evenly.
const MOST_COMBINATIONS: usize = 96;
/// Number of nodes that are returned.
const KEPT: usize = 6;

/// Returns values of all parameters for the best nodes, in the order of increasing cost. `linear` and `nonlinear` are
/// the indices of the free parameters; the others keep their values in `x`.
pub(super) fn search(
    basis: &impl Basis,
    parameters: &[Parameter],
    x: &[f64],
    linear: &[usize],
    nonlinear: &[usize],
    observed: &[(f64, f64)],
    zero_mag: f64,
) -> Vec<Vec<f64>> {
    let mut grid = vec![x.to_vec()];
    for &i in nonlinear {
        let values = nodes(&parameters[i]);
        let with = |x: &Vec<f64>| {
            let set = |&value: &f64| {
                let mut x = x.clone();
                x[i] = value;
                x
            };
            values.iter().map(set).collect::<Vec<_>>()
        };
        grid = grid.iter().flat_map(with).collect();
    }
    let stride = grid.len().div_ceil(MOST_COMBINATIONS);
    let chosen: Vec<Vec<f64>> = grid.into_iter().step_by(stride).collect();
    let mut found: Vec<(f64, Vec<f64>)> =
        chosen.into_par_iter().filter_map(|x| solved(basis, parameters, x, linear, observed, zero_mag)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(KEPT);
    found.into_iter().map(|(_, x)| x).collect()
}

fn nodes(parameter: &Parameter) -> Vec<f64> {
    let (least, greatest) = (parameter.least, parameter.greatest);
    let at = |share: f64| match least > 0.0 {
        true => least * (greatest / least).powf(share),
        false => least + share * (greatest - least),
    };
    SHARES.map(at).to_vec()
}

fn solved(
    basis: &impl Basis,
    parameters: &[Parameter],
    mut x: Vec<f64>,
    linear: &[usize],
    observed: &[(f64, f64)],
    zero_mag: f64,
) -> Option<(f64, Vec<f64>)> {
    linear.iter().for_each(|&i| x[i] = 0.0);
    let dark = basis.light(&x);
    let column = |&i: &usize| {
        // The light is computed at the parameter's upper bound, beyond which a law may be undefined.
        let mut lit = x.clone();
        lit[i] = parameters[i].greatest;
        let light = basis.light(&lit);
        light.iter().zip(&dark).map(|(lit, dark)| (lit - dark) / parameters[i].greatest).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = linear.iter().map(column).collect();
    // Minimise Σ ((F - D - Σ c_k b_k) / (σ F))², where F is the observed light and D the light of the held parameters.
    let n = linear.len();
    let (mut a, mut b) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for (point, dark) in dark.iter().enumerate() {
        let (magnitude, per_sigma) = observed[point];
        let per_light = 10_f64.powf(0.4 * (magnitude - zero_mag)) * per_sigma;
        let target = per_sigma - dark * per_light;
        for i in 0..n {
            let row = columns[i][point] * per_light;
            b[i] += row * target;
            (0..n).for_each(|j| a[(i, j)] += row * columns[j][point] * per_light);
        }
    }
    let bounds = |end: fn(&Parameter) -> f64| linear.iter().map(|&i| end(&parameters[i])).collect::<Vec<f64>>();
    let least = bounds(|parameter| parameter.least);
    let c = minimise_in_box(&a, &b, &least, &bounds(|parameter| parameter.greatest), &least)?;
    linear.iter().zip(&c).for_each(|(&i, c)| x[i] = *c);
    // Nodes are ranked by a robust cost in magnitudes.
    let cost = |(point, light): (usize, f64)| {
        let (magnitude, per_sigma) = observed[point];
        let r = (magnitude - zero_mag + 2.5 * light.max(LEAST_M2_SR).log10()) * per_sigma;
        (1.0 + r * r).sqrt() - 1.0
    };
    let total = basis.light(&x).into_iter().enumerate().map(cost).sum::<f64>();
    Some((total, x))
}
