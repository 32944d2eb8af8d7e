//! Levenberg-Marquardt minimisation with bounds.
//!
//! Each step minimises the quadratic model of the cost, damped along its diagonal, within the bounds
//! ([`minimise_in_box`]), so that unknowns are held at a bound or released by the step itself. The damping follows the
//! ratio of the actual to the predicted decrease (Nielsen 1999, IMM-REP-1999-05; Madsen, Nielsen and Tingleff 2004, eq.
//! 3.17).
//!
//! The step minimises q(x) = ½ xᵀ A x - bᵀ x for least ≤ x ≤ greatest, where A is symmetric and positive definite, by
//! an active-set method (Stark and Parker 1995, Computational Statistics 10, 129, applied to the normal equations).
//! Unknowns are held at a bound while the gradient points beyond it, and the others are solved for. The method is
//! suitable for about ten unknowns.

use nalgebra::{DMatrix, DVector};

/// Cost C(x) = ½ Σ ρ(r²), with its gradient and Gauss-Newton curvature.
pub trait NormalEquations: Sync {
    /// Returns C(x); +∞ where it is undefined.
    fn cost(&self, x: &[f64]) -> f64;
    /// Returns C(x), the gradient JᵀW r `(n)` and the curvature JᵀW J `(n, n)`, where r = data - model and J is its
    /// Jacobian.
    fn equations(&self, x: &[f64]) -> (f64, DVector<f64>, DMatrix<f64>);
}

/// Rules that end a descent.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct LeastSquares {
    /// Largest number of evaluations of the cost.
    pub greatest_evaluations: usize,
    /// The descent stops if the actual and the predicted relative decrease of the cost are below this.
    pub cost_tolerance: f64,
    /// The descent stops if the relative change of each unknown is below this.
    pub step_tolerance: f64,
}

impl Default for LeastSquares {
    /// Returns 300 evaluations, 1e-12 of the cost and 1e-10 of the unknowns.
    fn default() -> Self {
        Self { greatest_evaluations: 300, cost_tolerance: 1e-12, step_tolerance: 1e-10 }
    }
}

/// Reason for which a descent stopped.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Stop {
    /// The cost no longer decreases.
    Cost,
    /// The unknowns no longer change.
    Step,
    /// The limit of evaluations was reached.
    Evaluations,
    /// The cost is not finite, or no step decreases it.
    Failed,
}

/// Result of a descent.
#[derive(Clone, Debug, PartialEq)]
pub struct Minimum {
    /// Values of the unknowns.
    pub x: Vec<f64>,
    /// Cost at the minimum.
    pub cost: f64,
    /// Curvature JᵀW J at the minimum, `(n, n)`.
    pub curvature: DMatrix<f64>,
    /// Reason for which the descent stopped.
    pub stop: Stop,
}

/// Returns the local minimum that is reached from `start`, which is first moved into the bounds.
pub(in crate::fit) fn minimise(
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
        let margin = |bound: &[f64]| bound.iter().zip(&x).map(|(bound, x)| bound - x).collect::<Vec<f64>>();
        let Some(step) = minimise_in_box(&damped, &-&slope, &margin(least), &margin(greatest), &vec![0.0; n]) else {
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
    Minimum { x, cost, curvature, stop }
}

/// Largest number of rounds, far above the usual number.
const GREATEST_ROUNDS: usize = 200;
/// A slope that is smaller than this fraction of its terms is a rounding error.
const SLOPE_ROUNDING: f64 = 1e-13;

#[derive(Copy, Clone, PartialEq)]
enum At {
    Least,
    Greatest,
    Between,
}

/// Returns the minimum of q, starting from `start` moved into the bounds.
///
/// If A is singular, a ridge of 1e-12 of its diagonal is added, which selects one of many minima. `None` if a number is
/// not finite.
pub(in crate::fit) fn minimise_in_box(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    least: &[f64],
    greatest: &[f64],
    start: &[f64],
) -> Option<Vec<f64>> {
    let n = b.len();
    if a.iter().chain(b.iter()).any(|number| !number.is_finite()) {
        return None;
    }
    let mut x: Vec<f64> = (0..n).map(|i| start[i].clamp(least[i], greatest[i])).collect();
    let slope = |x: &[f64], i: usize| (0..n).map(|j| a[(i, j)] * x[j]).sum::<f64>() - b[i];
    let scale = |x: &[f64], i: usize| (0..n).map(|j| (a[(i, j)] * x[j]).abs()).sum::<f64>() + b[i].abs();
    let mut at: Vec<At> = (0..n)
        .map(|i| match slope(&x, i) {
            s if x[i] <= least[i] && s >= 0.0 => At::Least,
            s if x[i] >= greatest[i] && s <= 0.0 => At::Greatest,
            _ => At::Between,
        })
        .collect();
    for _ in 0..GREATEST_ROUNDS {
        // 1. Solve for the free unknowns with the others held.
        let free: Vec<usize> = (0..n).filter(|&i| at[i] == At::Between).collect();
        let target = solve_free(a, b, &x, &free)?;
        // 2. Move towards the solution as far as the bounds allow, and hold unknowns that meet one.
        let share = |(&i, &target): (&usize, &f64)| {
            let step = target - x[i];
            match target {
                w if w < least[i] => ((least[i] - x[i]) / step).max(0.0),
                w if w > greatest[i] => ((greatest[i] - x[i]) / step).max(0.0),
                _ => 1.0,
            }
        };
        let shares: Vec<f64> = free.iter().zip(&target).map(share).collect();
        let first = shares.iter().copied().fold(1.0, f64::min);
        let mut met = false;
        for (k, &i) in free.iter().enumerate() {
            if shares[k] <= first && first < 1.0 {
                (at[i], met) = (if target[k] < least[i] { At::Least } else { At::Greatest }, true);
            }
            let moved = x[i] + first * (target[k] - x[i]);
            x[i] = match at[i] {
                At::Least => least[i],
                At::Greatest => greatest[i],
                At::Between => moved.clamp(least[i], greatest[i]),
            };
        }
        if met {
            continue;
        }
        // 3. Release the held unknown with the largest expected decrease.
        let held = (0..n).filter(|&i| at[i] != At::Between && least[i] < greatest[i]).filter_map(|i| {
            let s = slope(&x, i);
            let inward = if at[i] == At::Least { -s } else { s };
            (inward > SLOPE_ROUNDING * scale(&x, i)).then(|| (i, inward * inward / a[(i, i)].max(f64::MIN_POSITIVE)))
        });
        match held.max_by(|this, other| this.1.total_cmp(&other.1)) {
            Some((i, _)) => at[i] = At::Between,
            None => return Some(x),
        }
    }
    Some(x)
}

/// Solves A_ff x_f = b_f - A_fh x_h for the free unknowns.
fn solve_free(a: &DMatrix<f64>, b: &DVector<f64>, x: &[f64], free: &[usize]) -> Option<Vec<f64>> {
    let k = free.len();
    let is_free = |j: usize| free.contains(&j);
    let right = DVector::from_fn(k, |r, _| {
        let held: f64 = (0..x.len()).filter(|&j| !is_free(j)).map(|j| a[(free[r], j)] * x[j]).sum();
        b[free[r]] - held
    });
    let inner = DMatrix::from_fn(k, k, |r, c| a[(free[r], free[c])]);
    let ridge = |share: f64| {
        let mut raised = inner.clone();
        (0..k).for_each(|i| raised[(i, i)] += share * inner[(i, i)].abs().max(f64::MIN_POSITIVE));
        raised.cholesky().map(|factors| factors.solve(&right))
    };
    let solved = inner
        .clone()
        .cholesky()
        .map(|factors| factors.solve(&right))
        .or_else(|| ridge(1e-12))
        .or_else(|| ridge(1e-6))?;
    solved.iter().all(|number| number.is_finite()).then(|| solved.iter().copied().collect())
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
        /// Tolerance of the published figure, which has six digits.
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
    fn verif_nan_is_a_failure() {
        let model = |_: &[f64], _: f64| (f64::NAN, vec![0.0]);
        let problem = Curve { t: vec![0.0], y: vec![0.0], model };
        assert_eq!(minimise(&problem, &[0.5], &[0.0], &[1.0], &LeastSquares::default()).stop, Stop::Failed);
    }
}

#[cfg(test)]
mod tests_of_minimise_in_box {
    use super::*;
    use proptest::prelude::*;

    fn value(a: &DMatrix<f64>, b: &DVector<f64>, x: &[f64]) -> f64 {
        let x = DVector::from_column_slice(x);
        0.5 * x.dot(&(a * &x)) - b.dot(&x)
    }

    proptest! {
        /// Slopes are 0 inside and point outward at a bound (Karush, Kuhn and Tucker's conditions, sufficient for a
        /// convex form).
        #[test]
        fn verif_slopes_at_the_least_point(
            rows in prop::collection::vec(-2.0..2.0_f64, 35), b in prop::collection::vec(-3.0..3.0_f64, 5),
            low in prop::collection::vec(-1.0..0.5_f64, 5), wide in prop::collection::vec(0.0..2.0_f64, 5),
        ) {
            let j = DMatrix::from_row_slice(7, 5, &rows);
            let a = j.transpose() * &j + DMatrix::identity(5, 5) * 1e-3;
            let b = DVector::from_vec(b);
            let high: Vec<f64> = low.iter().zip(&wide).map(|(l, w)| l + w).collect();
            let x = minimise_in_box(&a, &b, &low, &high, &[0.0; 5]).expect("finite");
            let slope = &a * DVector::from_column_slice(&x) - &b;
            /// Tolerance for slopes of order one, computed in double precision for condition numbers up to 1e4.
            const SLOPE: f64 = 1e-8;
            for i in 0..5 {
                prop_assert!(low[i] <= x[i] && x[i] <= high[i]);
                if x[i] > low[i] { prop_assert!(slope[i] < SLOPE, "{i} {}", slope[i]); }
                if x[i] < high[i] { prop_assert!(slope[i] > -SLOPE, "{i} {}", slope[i]); }
            }
        }
    }

    #[test]
    fn verif_singular_forms_and_held_unknowns() {
        // Only the sum of the first two unknowns matters; the third is held.
        let a = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 2.0]);
        let b = DVector::from_vec(vec![1.0, 1.0, 4.0]);
        let x = minimise_in_box(&a, &b, &[0.0, 0.0, 0.5], &[1.0, 1.0, 0.5], &[0.0; 3]).expect("finite");
        assert!((x[0] + x[1] - 1.0).abs() < 1e-6 && x[2] == 0.5, "{x:?}");
        assert!(value(&a, &b, &x) < value(&a, &b, &[0.0, 0.0, 0.5]));
        assert_eq!(
            minimise_in_box(
                &DMatrix::from_element(1, 1, f64::NAN),
                &DVector::from_element(1, 0.0),
                &[0.0],
                &[1.0],
                &[0.0]
            ),
            None
        );
    }
}
