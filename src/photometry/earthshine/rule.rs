//! Quadrature rules on (0, 1) with any number of points, composed of equal panels of short precomputed rules.

use std::sync::LazyLock;

use crate::math::quadrature::gauss_legendre;

/// Number of points of the longest single rule; longer ones are composed of panels.
const LONGEST: usize = 32;

/// Gauss-Legendre rules of 0 to [`LONGEST`] points on (0, 1).
static GAUSS: LazyLock<Vec<Vec<(f64, f64)>>> = LazyLock::new(|| (0..=LONGEST).map(gauss_legendre).collect());

/// Positive half of Gauss-Legendre rules of 0, 2, 4 ... points on (-1, 1).
static HALF_GAUSS: LazyLock<Vec<Vec<(f64, f64)>>> = LazyLock::new(|| {
    let half = |n: usize| gauss_legendre(2 * n)[n..].iter().map(|(x, weight)| (2.0 * x - 1.0, 2.0 * weight)).collect();
    (0..=LONGEST).map(half).collect()
});

/// Equal panels of one short rule.
#[derive(Copy, Clone)]
pub(super) struct Rule {
    panels: usize,
    points: &'static [(f64, f64)],
}

impl Rule {
    /// Returns a Gauss-Legendre rule with about `n` points.
    pub fn gauss(n: usize) -> Self {
        let n = n.max(1);
        let panels = n.div_ceil(LONGEST);
        Self { panels, points: &GAUSS[n.div_ceil(panels)] }
    }

    /// Returns about `n` points for the half (0, 1) of an integral over (-1, 1); each represents its mirror image too.
    pub fn half_gauss(n: usize) -> Self {
        if n <= LONGEST { Self { panels: 1, points: &HALF_GAUSS[n.max(1)] } } else { Self::gauss(n) }
    }

    /// Returns the midpoints of `n` equal steps, for periodic functions.
    pub fn midpoints(n: usize) -> Self {
        Self { panels: n.max(1), points: &GAUSS[1] }
    }

    /// Returns abscissae and weights; the weights sum to 1.
    #[inline(always)]
    pub fn points(self) -> impl Iterator<Item = (f64, f64)> {
        let length = 1.0 / self.panels as f64;
        let panel =
            move |panel| self.points.iter().map(move |(x, weight)| ((panel as f64 + x) * length, weight * length));
        (0..self.panels).flat_map(panel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_powers_are_integrated_exactly() {
        for n in [1, 2, 5, 16, 32, 33, 70] {
            for power in 0..2 * n.min(LONGEST / 2) as i32 {
                let sum: f64 = Rule::gauss(n).points().map(|(x, weight)| weight * x.powi(power)).sum();
                assert!((sum * f64::from(power + 1) - 1.0).abs() < 1e-12, "{n} {power} {sum}");
                let even: f64 =
                    Rule::half_gauss(n).points().map(|(x, weight)| weight * (x.powi(power) + (-x).powi(power))).sum();
                let exact = if power % 2 == 0 { 2.0 } else { 0.0 };
                assert!((even * f64::from(power + 1) - exact).abs() < 1e-12, "{n} {power} {even}");
            }
            let turn: f64 = Rule::midpoints(n).points().map(|(x, weight)| weight * (6.0 * x - 3.0)).sum();
            assert!(turn.abs() < 1e-13);
        }
    }
}
