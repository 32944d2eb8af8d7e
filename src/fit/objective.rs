//! Cost of a form as a function of its parameters: loss functions, least-squares equations and likelihood.

use std::fmt;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::form::{BLOCK, Evaluated, Parameter, Prepared};
use super::inference::{LogProbability, NormalEquations};
use super::point::FitPoint;

/// Loss function ρ(r) of a residual r in units of its error; ½ w ρ, with the weight w of the point, is the negative
/// logarithm of a likelihood, up to a
/// constant.
#[derive(Copy, Clone, Debug, PartialEq, Default)]
#[non_exhaustive]
pub enum Loss {
    /// ρ = r², for normal errors.
    #[default]
    Squares,
    /// ρ = 2 (√(1 + r²) - 1), quadratic near 0 and linear for outliers; `soft_l1` of SciPy.
    SoftL1,
    /// ρ = (ν + 1) ln(1 + r²/ν), for Student's t distribution with ν degrees of freedom.
    Student(f64),
}

impl fmt::Display for Loss {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Squares => formatter.write_str("squares"),
            Self::SoftL1 => formatter.write_str("soft L1"),
            Self::Student(nu) => write!(formatter, "Student's t with {nu} degrees of freedom"),
        }
    }
}

impl Loss {
    /// Returns ρ for a given r².
    pub fn rho(self, r2: f64) -> f64 {
        match self {
            Self::Squares => r2,
            Self::SoftL1 => 2.0 * ((1.0 + r2).sqrt() - 1.0),
            Self::Student(nu) => (nu + 1.0) * (r2 / nu).ln_1p(),
        }
    }

    /// Returns dρ/d(r²), the weight of the residual in the normal equations.
    pub fn weight(self, r2: f64) -> f64 {
        match self {
            Self::Squares => 1.0,
            Self::SoftL1 => 1.0 / (1.0 + r2).sqrt(),
            Self::Student(nu) => (nu + 1.0) / (nu + r2),
        }
    }

    /// Returns the derivative ψ'(r) of the influence function ψ(r) = ρ'(r²) r. It gives the exact curvature of the
    /// cost, of which [`Self::weight`] is the Gauss-Newton approximation. It is negative for outliers under Student's
    /// t.
    pub fn influence_slope(self, r2: f64) -> f64 {
        // ψ' = ρ' + 2 r² ρ''
        match self {
            Self::Squares => 1.0,
            Self::SoftL1 => (1.0 + r2).powf(-1.5),
            Self::Student(nu) => (nu + 1.0) * (nu - r2) / (nu + r2).powi(2),
        }
    }
}

/// Number of blocks per task. Sums are made chunk by chunk, so that they do not depend on the number of threads.
const CHUNK_BLOCKS: usize = 16;

/// Magnitudes, 1/σ and weights of a block; 1/σ is 0 for elements beyond the last point.
struct ObservedBlock {
    magnitude: [f64; BLOCK],
    per_sigma: [f64; BLOCK],
    weight: [f64; BLOCK],
}

/// Cost of a form for given points, as a function of the free parameters.
pub struct Objective<'a> {
    prepared: &'a dyn Prepared,
    parameters: Vec<Parameter>,
    /// Indices of the free parameters.
    free: Vec<usize>,
    observed: Vec<ObservedBlock>,
    loss: Loss,
}

impl<'a> Objective<'a> {
    /// Creates the cost. `prepared` must be made from these points and give a magnitude for each of them; `free` are
    /// indices into `parameters`.
    pub(super) fn new(
        prepared: &'a dyn Prepared,
        parameters: Vec<Parameter>,
        free: Vec<usize>,
        points: &[FitPoint],
        loss: Loss,
    ) -> Self {
        let observed = points.chunks(BLOCK).map(|block| {
            let zero = [0.0; BLOCK];
            let mut observed = ObservedBlock { magnitude: zero, per_sigma: zero, weight: zero };
            for (lane, point) in block.iter().enumerate() {
                (observed.magnitude[lane], observed.per_sigma[lane]) = (point.magnitude, 1.0 / point.sigma_mag);
                observed.weight[lane] = point.weight;
            }
            observed
        });
        Self { prepared, parameters, free, observed: observed.collect(), loss }
    }

    /// Returns the values of all parameters, given those of the free parameters.
    pub(super) fn all(&self, free: &[f64]) -> Vec<f64> {
        let mut all: Vec<f64> = self.parameters.iter().map(|parameter| parameter.value).collect();
        self.free.iter().zip(free).for_each(|(&i, &value)| all[i] = value);
        all
    }

    /// Returns the free parameters.
    pub fn free_parameters(&self) -> impl Iterator<Item = &Parameter> {
        self.free.iter().map(|&i| &self.parameters[i])
    }

    /// Returns starting values of the free parameters, the best first.
    pub(super) fn starts(&self) -> Vec<Vec<f64>> {
        // For squares, a weight is equivalent to a larger error.
        let of_block = |block: &ObservedBlock| {
            let pair = |lane: usize| (block.magnitude[lane], block.per_sigma[lane] * block.weight[lane].sqrt());
            std::array::from_fn::<_, BLOCK, _>(pair)
        };
        let observed: Vec<(f64, f64)> = self.observed.iter().flat_map(of_block).collect();
        let starts = self.prepared.starts(&self.all(&[]), &self.free, &observed);
        starts.into_iter().map(|all| self.free.iter().map(|&i| all[i]).collect()).collect()
    }

    /// Returns the observed minus computed magnitude of every point.
    pub(super) fn residuals_mag(&self, free: &[f64], points: usize) -> Vec<f64> {
        let evaluated = self.prepared.at(&self.all(free));
        let mut out = [0.0; BLOCK];
        let mut residuals = Vec::with_capacity(self.observed.len() * BLOCK);
        for (block, observed) in self.observed.iter().enumerate() {
            evaluated.magnitudes(block, &mut out);
            residuals.extend(observed.magnitude.iter().zip(&out).map(|(observed, computed)| observed - computed));
        }
        residuals.truncate(points);
        residuals
    }

    /// Returns each point's term of the gradient JᵀW r, `n_point` vectors of length `n_free`, and the curvature Σ ψ'(r)
    /// J Jᵀ/σ² `(n_free, n_free)`.
    pub(super) fn scores(&self, free: &[f64], points: usize) -> (Vec<Vec<f64>>, DMatrix<f64>) {
        let n = self.free.len();
        let sloped = self.prepared.with_slopes(&self.all(free), &self.free, &self.parameters);
        let (mut out, mut slopes) = ([0.0; BLOCK], vec![[0.0; BLOCK]; n]);
        let mut scores = Vec::with_capacity(self.observed.len() * BLOCK);
        let mut bread = DMatrix::zeros(n, n);
        for (block, observed) in self.observed.iter().enumerate() {
            sloped.magnitudes_and_slopes(block, &mut out, &mut slopes);
            for (lane, computed) in out.iter().enumerate() {
                let per_sigma = observed.per_sigma[lane];
                let r = (observed.magnitude[lane] - computed) * per_sigma;
                let weight = observed.weight[lane];
                let pull = -weight * self.loss.weight(r * r) * r * per_sigma;
                let curvature = weight * self.loss.influence_slope(r * r) * per_sigma * per_sigma;
                for i in 0..n {
                    (0..n).for_each(|j| bread[(i, j)] += curvature * slopes[i][lane] * slopes[j][lane]);
                }
                scores.push(slopes.iter().map(|slope| pull * slope[lane]).collect());
            }
        }
        scores.truncate(points);
        (scores, bread)
    }

    fn cost_of_blocks(&self, evaluated: &dyn Evaluated, from: usize) -> f64 {
        let mut out = [0.0; BLOCK];
        let blocks = &self.observed[from..(from + CHUNK_BLOCKS).min(self.observed.len())];
        let mut cost = 0.0;
        for (block, observed) in blocks.iter().enumerate() {
            evaluated.magnitudes(from + block, &mut out);
            // C = ½ Σ w ρ(r²)
            for ((out, magnitude), per_sigma) in out.iter_mut().zip(&observed.magnitude).zip(&observed.per_sigma) {
                let r = (magnitude - *out) * per_sigma;
                *out = r * r;
            }
            if self.loss != Loss::Squares {
                out.iter_mut().for_each(|r2| *r2 = self.loss.rho(*r2));
            }
            cost += 0.5 * product(&out, &observed.weight);
        }
        cost
    }

    fn chunks(&self) -> impl IndexedParallelIterator<Item = usize> {
        (0..self.observed.len().div_ceil(CHUNK_BLOCKS)).into_par_iter().map(|chunk| chunk * CHUNK_BLOCKS)
    }

    fn equations_of_blocks(&self, sloped: &dyn super::form::Sloped, from: usize) -> (f64, DVector<f64>, DMatrix<f64>) {
        let n = self.free.len();
        let (mut out, mut slopes, mut pulled) = ([0.0; BLOCK], vec![[0.0; BLOCK]; n], vec![[0.0; BLOCK]; n]);
        let (mut cost, mut gradient, mut curvature) = (0.0, DVector::zeros(n), DMatrix::zeros(n, n));
        let blocks = &self.observed[from..(from + CHUNK_BLOCKS).min(self.observed.len())];
        for (block, observed) in blocks.iter().enumerate() {
            sloped.magnitudes_and_slopes(from + block, &mut out, &mut slopes);
            let (mut losses, mut pull, mut weight) = ([0.0; BLOCK], [0.0; BLOCK], [0.0; BLOCK]);
            for lane in 0..BLOCK {
                let per_sigma = observed.per_sigma[lane];
                let r = (observed.magnitude[lane] - out[lane]) * per_sigma;
                let (loss, share) = match self.loss {
                    Loss::Squares => (r * r, 1.0),
                    other => (other.rho(r * r), other.weight(r * r)),
                };
                let share = observed.weight[lane] * share;
                losses[lane] = loss;
                // dr/dp = -dm/dp/σ
                pull[lane] = -share * r * per_sigma;
                weight[lane] = share * per_sigma * per_sigma;
            }
            cost += 0.5 * product(&losses, &observed.weight);
            for i in 0..n {
                gradient[i] += product(&pull, &slopes[i]);
                for lane in 0..BLOCK {
                    pulled[i][lane] = weight[lane] * slopes[i][lane];
                }
                for j in 0..=i {
                    curvature[(i, j)] += product(&pulled[i], &slopes[j]);
                }
            }
        }
        for i in 0..n {
            for j in 0..i {
                curvature[(j, i)] = curvature[(i, j)];
            }
        }
        (cost, gradient, curvature)
    }
}

impl NormalEquations for Objective<'_> {
    fn cost(&self, x: &[f64]) -> f64 {
        let evaluated = self.prepared.at(&self.all(x));
        let parts: Vec<f64> = self.chunks().map(|from| self.cost_of_blocks(&*evaluated, from)).collect();
        parts.into_iter().sum()
    }

    fn equations(&self, x: &[f64]) -> (f64, DVector<f64>, DMatrix<f64>) {
        let n = self.free.len();
        let sloped = self.prepared.with_slopes(&self.all(x), &self.free, &self.parameters);
        let parts: Vec<_> = self.chunks().map(|from| self.equations_of_blocks(&*sloped, from)).collect();
        let none = (0.0, DVector::zeros(n), DMatrix::zeros(n, n));
        parts.into_iter().fold(none, |sum, part| (sum.0 + part.0, sum.1 + part.1, sum.2 + part.2))
    }
}

/// Posterior: the likelihood exp(-C) times a prior that is flat between the bounds.
impl LogProbability for Objective<'_> {
    fn of_many(&self, positions: &[Vec<f64>]) -> Vec<f64> {
        let inside = |position: &[f64]| {
            self.free_parameters()
                .zip(position)
                .all(|(parameter, x)| (parameter.least..=parameter.greatest).contains(x))
        };
        let possible: Vec<usize> = (0..positions.len()).filter(|&i| inside(&positions[i])).collect();
        let evaluated: Vec<_> = possible.iter().map(|&i| self.prepared.at(&self.all(&positions[i]))).collect();
        // All walkers evaluate a chunk of points while it is in the cache.
        let parts: Vec<Vec<f64>> = self
            .chunks()
            .map(|from| evaluated.iter().map(|evaluated| self.cost_of_blocks(&**evaluated, from)).collect())
            .collect();
        let mut values = vec![f64::NEG_INFINITY; positions.len()];
        for (k, &i) in possible.iter().enumerate() {
            let cost: f64 = parts.iter().map(|part| part[k]).sum();
            values[i] = if cost.is_finite() { -cost } else { f64::NEG_INFINITY };
        }
        values
    }
}

/// Returns the scalar product, computed with eight accumulators, so that no addition has to wait for the previous one.
fn product(a: &[f64; BLOCK], b: &[f64; BLOCK]) -> f64 {
    let mut lanes = [0.0; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for lane in 0..8 {
            lanes[lane] += a[lane] * b[lane];
        }
    }
    lanes.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_weights_are_derivatives_of_losses() {
        for loss in [Loss::Squares, Loss::SoftL1, Loss::Student(4.0)] {
            assert_eq!(loss.rho(0.0), 0.0);
            for r2 in [0.01, 1.0, 30.0] {
                let h = 1e-5 * r2;
                let slope = (loss.rho(r2 + h) - loss.rho(r2 - h)) / (2.0 * h);
                assert!((slope - loss.weight(r2)).abs() < 1e-8, "{loss:?} {r2}");
                let (r, h) = (r2.sqrt(), 1e-5 * r2.sqrt());
                let pull = |r: f64| loss.weight(r * r) * r;
                let slope = (pull(r + h) - pull(r - h)) / (2.0 * h);
                assert!((slope - loss.influence_slope(r2)).abs() < 1e-8, "{loss:?} {r2}");
            }
        }
    }
}
