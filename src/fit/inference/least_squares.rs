//! Levenberg and Marquardt between bounds.
//!
//! Each step minimises the quadratic model of the cost, damped along its own diagonal, within the box that is left
//! ([`minimise_in_box`]); unknowns at a bound are thus held or let go by the step itself. Damping follows the ratio of the
//! gained to the promised decrease (Nielsen 1999, IMM-REP-1999-05; Madsen, Nielsen and Tingleff 2004, eq. 3.17).

use nalgebra::{DMatrix, DVector};

use super::box_quadratic::minimise_in_box;

/// A cost C(x) = ½ Σ ρ(r²) with the slope and Gauss-Newton curvature that a step needs.
pub trait NormalEquations: Sync {
    /// C(x); +∞ where it has no value.
    fn cost(&self, x: &[f64]) -> f64;
    /// C(x), JᵀW r `(n)` and JᵀW J `(n, n)`, r = data - model, J its derivatives (so that the cost's slope is JᵀW r).
    fn equations(&self, x: &[f64]) -> (f64, DVector<f64>, DMatrix<f64>);
}

/// When to stop.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LeastSquares {
    /// Most evaluations of the cost.
    pub greatest_evaluations: usize,
    /// A step that gains and promises less than this share of the cost is the last.
    pub cost_tolerance: f64,
    /// So is one shorter than this share of each unknown.
    pub step_tolerance: f64,
}

impl Default for LeastSquares {
    /// 300 evaluations, 1e-12 of the cost, 1e-10 of the unknowns.
    fn default() -> Self {
        Self { greatest_evaluations: 300, cost_tolerance: 1e-12, step_tolerance: 1e-10 }
    }
}

/// Why it stopped.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The cost no longer falls.
    Cost,
    /// The unknowns no longer move.
    Step,
    /// No more evaluations were allowed.
    Evaluations,
    /// The cost has no finite value, or no step could be made.
    Failed,
}

/// Where it ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// The unknowns.
    pub x: Vec<f64>,
    /// The cost there.
    pub cost: f64,
    /// JᵀW J there, `(n, n)`.
    pub curvature: DMatrix<f64>,
    /// How often the cost was asked for.
    pub evaluations: usize,
    /// Why it is the end.
    pub stop: Stop,
}

/// Goes down from `start` (moved into the box). A local minimum: of many, take the least cost.
pub fn minimise(
    problem: &impl NormalEquations,
    start: &[f64],
    least: &[f64],
    greatest: &[f64],
    options: &LeastSquares,
) -> Minimum {
    let n = start.len();
    let mut x: Vec<f64> = (0..n).map(|i| start[i].clamp(least[i], greatest[i])).collect();
    let (mut cost, mut slope, mut curvature) = problem.equations(&x);
    let (mut evaluations, mut damping, mut growth) = (1, 1e-3, 2.0);
    let stop = loop {
        if !cost.is_finite() {
            break Stop::Failed;
        }
        if evaluations >= options.greatest_evaluations {
            break Stop::Evaluations;
        }
        // min ½ pᵀ (H + λ diag H) p + gᵀ p,  least - x ≤ p ≤ greatest - x
        let mut damped = curvature.clone();
        (0..n).for_each(|i| damped[(i, i)] += damping * curvature[(i, i)].max(f64::MIN_POSITIVE));
        let room = |bound: &[f64]| bound.iter().zip(&x).map(|(bound, x)| bound - x).collect::<Vec<f64>>();
        let Some(step) = minimise_in_box(&damped, &-&slope, &room(least), &room(greatest), &vec![0.0; n]) else {
            break Stop::Failed;
        };
        let still = |i: usize| step[i].abs() <= options.step_tolerance * (x[i].abs() + options.step_tolerance);
        if (0..n).all(still) {
            break Stop::Step;
        }
        let p = DVector::from_column_slice(&step);
        let promised = -(slope.dot(&p) + 0.5 * p.dot(&(&curvature * &p)));
        let tried: Vec<f64> = (0..n).map(|i| (x[i] + step[i]).clamp(least[i], greatest[i])).collect();
        let (new_cost, new_slope, new_curvature) = problem.equations(&tried);
        evaluations += 1;
        let gained = cost - new_cost;
        let small = options.cost_tolerance * cost;
        if gained > 0.0 && new_cost.is_finite() {
            let ratio = gained / promised.max(f64::MIN_POSITIVE);
            (x, cost, slope, curvature) = (tried, new_cost, new_slope, new_curvature);
            damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 9.0, 2.0);
            growth = 2.0;
            if gained <= small && promised <= small {
                break Stop::Cost;
            }
        } else {
            if promised <= small && gained.abs() <= small {
                break Stop::Cost;
            }
            damping *= growth;
            growth *= 2.0;
            if damping > 1e16 {
                break Stop::Failed;
            }
        }
    };
    Minimum { x, cost, curvature, evaluations, stop }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Data along t with a model and its derivatives.
    struct Curve<F: Fn(&[f64], f64) -> (f64, Vec<f64>) + Sync> {
        t: Vec<f64>,
        y: Vec<f64>,
        model: F,
    }

    impl<F: Fn(&[f64], f64) -> (f64, Vec<f64>) + Sync> NormalEquations for Curve<F> {
        fn cost(&self, x: &[f64]) -> f64 {
            self.equations(x).0
        }
        fn equations(&self, x: &[f64]) -> (f64, DVector<f64>, DMatrix<f64>) {
            let n = x.len();
            let (mut cost, mut slope, mut curvature) = (0.0, DVector::zeros(n), DMatrix::zeros(n, n));
            for (t, y) in self.t.iter().zip(&self.y) {
                let (value, gradient) = (self.model)(x, *t);
                let (r, j) = (y - value, -DVector::from_vec(gradient));
                cost += 0.5 * r * r;
                slope += &j * r;
                curvature += &j * j.transpose();
            }
            (cost, slope, curvature)
        }
    }

    /// MGH 17 of Moré, Garbow and Hillstrom (1981): Osborne's first function, least sum of squares 5.46489e-5.
    #[test]
    fn valid_osbornes_function_reaches_the_published_minimum() {
        let y = [
            0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658, 0.628,
            0.603, 0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431, 0.424, 0.420,
            0.414, 0.411, 0.406,
        ];
        let model = |x: &[f64], t: f64| {
            let (e, f) = ((-t * x[3]).exp(), (-t * x[4]).exp());
            (x[0] + x[1] * e + x[2] * f, vec![1.0, e, f, -t * x[1] * e, -t * x[2] * f])
        };
        let problem = Curve { t: (0..33).map(|i| 10.0 * f64::from(i)).collect(), y: y.to_vec(), model };
        let wide = ([-10.0; 5], [10.0; 5]);
        let found = minimise(&problem, &[0.5, 1.5, -1.0, 0.01, 0.02], &wide.0, &wide.1, &LeastSquares::default());
        /// The published figure has six digits.
        const DIGITS: f64 = 5e-11;
        assert!((2.0 * found.cost - 5.46489e-5).abs() < DIGITS, "{found:?}");
        assert_ne!(found.stop, Stop::Evaluations);
    }

    #[test]
    fn verif_a_bound_holds_where_the_minimum_lies_beyond() {
        // y = 3 t - 1 with a slope of at most 2: the best intercept for slope 2 is the mean of y - 2 t.
        let model = |x: &[f64], t: f64| (x[0] * t + x[1], vec![t, 1.0]);
        let t: Vec<f64> = (0..11).map(f64::from).collect();
        let y: Vec<f64> = t.iter().map(|t| 3.0 * t - 1.0).collect();
        let problem = Curve { t, y, model };
        let found = minimise(&problem, &[0.0, 0.0], &[0.0, -100.0], &[2.0, 100.0], &LeastSquares::default());
        assert!(found.x[0] == 2.0 && (found.x[1] - 4.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn verif_no_number_is_a_failure_not_an_answer() {
        let model = |_: &[f64], _: f64| (f64::NAN, vec![0.0]);
        let problem = Curve { t: vec![0.0], y: vec![0.0], model };
        assert_eq!(minimise(&problem, &[0.5], &[0.0], &[1.0], &LeastSquares::default()).stop, Stop::Failed);
    }
}
