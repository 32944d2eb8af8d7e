//! Gauss-Legendre quadrature for integrals of smooth functions.

use std::f64::consts::PI;

/// Returns `count` pairs of a node in (0, 1) and its weight; the weights sum to 1. The rule is exact for polynomials up
/// to degree 2 `count` - 1.
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    (0..count)
        .map(|node| {
            // The nodes are the roots of Pₙ, found by Newton's method from Tricomi's estimate; Pₙ and Pₙ₋₁ follow from
            // their recurrence.
            let mut x = (PI * (node as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut before, mut now) = (1.0, x);
                for degree in 2..=count {
                    let k = degree as f64;
                    (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
                }
                slope = n * (x * now - before) / (x * x - 1.0);
                x -= now / slope;
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for count in [4, 24, 48] {
            let rule = gauss_legendre(count);
            for degree in [0, 1, 3, 7] {
                let sum: f64 = rule.iter().map(|(x, weight)| weight * x.powi(degree)).sum();
                assert!((sum - 1.0 / f64::from(degree + 1)).abs() < 1e-14, "{count} {degree}: {sum}");
            }
        }
    }
}
