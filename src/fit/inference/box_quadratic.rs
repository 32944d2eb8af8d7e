//! The least value of a quadratic form between bounds.
//!
//! q(x) = ½ xᵀ A x - bᵀ x, least ≤ x ≤ greatest, A symmetric and positive definite. An active-set method (Stark and Parker 1995,
//! Computational Statistics 10, 129, on the normal equations): unknowns at a bound are held there while the slope presses them
//! against it, the others are solved for. Made for ten unknowns or so.

use nalgebra::{DMatrix, DVector};

/// More rounds than sets of bounds are ever tried.
const GREATEST_ROUNDS: usize = 200;
/// A slope this much smaller than its terms is rounding, and releases nothing.
const SLOPE_ROUNDING: f64 = 1e-13;

#[derive(Copy, Clone, PartialEq)]
enum At {
    Least,
    Greatest,
    Between,
}

/// Where q is least. Starts from `start`, which is moved into the box.
///
/// A singular A gets a ridge of 1e-12 of its diagonal: of many least points one is returned. `None` where a number is not finite.
pub fn minimise_in_box(
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
        // 1. Solve for the free unknowns with the others where they are.
        let free: Vec<usize> = (0..n).filter(|&i| at[i] == At::Between).collect();
        let wanted = solve_free(a, b, &x, &free)?;
        // 2. Go as far towards it as the box allows; whoever meets a bound stays there.
        let share = |(&i, &wanted): (&usize, &f64)| {
            let step = wanted - x[i];
            match wanted {
                w if w < least[i] => ((least[i] - x[i]) / step).max(0.0),
                w if w > greatest[i] => ((greatest[i] - x[i]) / step).max(0.0),
                _ => 1.0,
            }
        };
        let shares: Vec<f64> = free.iter().zip(&wanted).map(share).collect();
        let first = shares.iter().copied().fold(1.0, f64::min);
        let mut met = false;
        for (k, &i) in free.iter().enumerate() {
            if shares[k] <= first && first < 1.0 {
                (at[i], met) = (if wanted[k] < least[i] { At::Least } else { At::Greatest }, true);
            }
            let moved = x[i] + first * (wanted[k] - x[i]);
            x[i] = match at[i] {
                At::Least => least[i],
                At::Greatest => greatest[i],
                At::Between => moved.clamp(least[i], greatest[i]),
            };
        }
        if met {
            continue;
        }
        // 3. Release the one that its bound holds back most.
        let held = (0..n).filter(|&i| at[i] != At::Between && least[i] < greatest[i]).filter_map(|i| {
            let s = slope(&x, i);
            let inward = if at[i] == At::Least { -s } else { s };
            (inward > SLOPE_ROUNDING * scale(&x, i)).then(|| (i, inward * inward / a[(i, i)].max(f64::MIN_POSITIVE)))
        });
        match held.max_by(|one, other| one.1.total_cmp(&other.1)) {
            Some((i, _)) => at[i] = At::Between,
            None => return Some(x),
        }
    }
    Some(x)
}

/// A_ff x_f = b_f - A_fh x_h for the free unknowns.
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
    use proptest::prelude::*;

    fn value(a: &DMatrix<f64>, b: &DVector<f64>, x: &[f64]) -> f64 {
        let x = DVector::from_column_slice(x);
        0.5 * x.dot(&(a * &x)) - b.dot(&x)
    }

    proptest! {
        /// Slopes decide: 0 inside, pressing outward at a bound (the conditions of Karush, Kuhn and Tucker, enough for a convex form).
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
            /// Of slopes of some units, by elimination in double precision on conditions up to 1e4.
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
        // Two unknowns that only their sum matters for, one held.
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
