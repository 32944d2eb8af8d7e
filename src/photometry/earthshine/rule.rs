//! Gauss-Legendre rules of any length, made once.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Longest single rule; longer ones are made of equal panels of shorter ones.
pub(super) const LONGEST: usize = 32;

/// 0, 1, 2 … and 1, 1, 1 …: equal steps in the form of a rule.
pub(super) const COUNT: [f64; LONGEST] = {
    let mut count = [0.0; LONGEST];
    let mut i = 0;
    while i < LONGEST {
        count[i] = i as f64;
        i += 1;
    }
    count
};
pub(super) const ONES: [f64; LONGEST] = [1.0; LONGEST];

/// Abscissae on (0, 1) and weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Rule {
    pub at: Vec<f64>,
    pub weight: Vec<f64>,
}

/// Rules of 1 to [`LONGEST`] points on (0, 1), their weights adding up to 1.
static WHOLE: LazyLock<Vec<Rule>> = LazyLock::new(|| {
    (0..=LONGEST)
        .map(|n| {
            let (at, weight) = legendre(n);
            Rule { at: at.iter().map(|x| 0.5 * (1.0 + x)).collect(), weight: weight.iter().map(|w| 0.5 * w).collect() }
        })
        .collect()
});

/// The half with positive abscissae of rules of 2, 4 … points on (-1, 1), for what is symmetric in its weights but not
/// in its integrand: each point stands for itself and its mirror image.
static HALF: LazyLock<Vec<Rule>> = LazyLock::new(|| {
    (0..=LONGEST)
        .map(|n| {
            let (at, weight) = legendre(2 * n);
            Rule { at: at[n..].to_vec(), weight: weight[n..].to_vec() }
        })
        .collect()
});

/// Calls back with abscissa and weight of a rule of about `n` points (at least one) on (0, 1).
pub(super) fn whole(n: usize, mut point: impl FnMut(f64, f64)) {
    let panels = n.max(1).div_ceil(LONGEST);
    let rule = &WHOLE[n.max(1).div_ceil(panels)];
    for panel in 0..panels {
        for (at, weight) in rule.at.iter().zip(&rule.weight) {
            point((panel as f64 + at) / panels as f64, weight / panels as f64);
        }
    }
}

/// Calls back with rules (at most [`LONGEST`] points) as (start, length, rule) that together are about `n` points on
/// (0, 1), for an integral over (-1, 1) folded at 0.
pub(super) fn half(n: usize, mut panel: impl FnMut(f64, f64, &Rule)) {
    let n = n.max(1);
    if n <= LONGEST {
        return panel(0.0, 1.0, &HALF[n]);
    }
    let panels = n.div_ceil(LONGEST);
    let (rule, length) = (&WHOLE[n.div_ceil(panels)], 1.0 / panels as f64);
    (0..panels).for_each(|i| panel(i as f64 * length, length, rule));
}

/// Abscissae (ascending) and weights on (-1, 1).
fn legendre(n: usize) -> (Vec<f64>, Vec<f64>) {
    (0..n)
        .map(|i| {
            // Newton's method from Tricomi's estimate of the root.
            let mut x = -(PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..10 {
                let (value, derivative) = polynomial(n, x);
                slope = derivative;
                x -= value / derivative;
            }
            // w = 2 / ((1 - x²) P'ₙ(x)²)
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .unzip()
}

/// Legendre's polynomial and its derivative.
fn polynomial(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut now) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        // k P_k = (2k - 1) x P_{k-1} - (k - 1) P_{k-2}
        (before, now) = (now, ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k);
    }
    // (1 - x²) P'_n = n (P_{n-1} - x P_n)
    (now, n as f64 * (before - x * now) / (1.0 - x * x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_powers_are_integrated_exactly() {
        for n in [1, 2, 5, 16, 32, 33, 70] {
            for power in 0..(2 * n.min(LONGEST / 2)) as i32 {
                let (mut sum, mut folded) = (0.0, 0.0);
                whole(n, |x, w| sum += w * x.powi(power));
                half(n, |start, length, rule| {
                    for (x, w) in rule.at.iter().zip(&rule.weight) {
                        let (x, w) = (start + length * x, length * w);
                        folded += w * (x.powi(power) + (-x).powi(power));
                    }
                });
                let even = if power % 2 == 0 { 2.0 } else { 0.0 };
                assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-12, "{n} {power} {sum}");
                assert!((folded * f64::from(power + 1) - even).abs() < 1e-12, "{n} {power} {folded}");
            }
        }
    }
}
