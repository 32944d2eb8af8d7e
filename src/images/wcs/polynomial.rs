//! Polynomials of two variables with their slopes: what all distortions are made of.

/// Highest power of a radius in TPV: r, r³, r⁵, r⁷.
const RADIAL_TERMS: usize = 4;

/// A sum of c·uᵐ·vⁿ, and of odd powers of the radius √(u² + v²).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polynomial {
    /// Row n holds the coefficients of uᵐ·vⁿ by m; all rows are as long as the first.
    rows: Vec<Vec<f64>>,
    /// Coefficients of r, r³, r⁵, r⁷; empty where none is given.
    radial: Vec<f64>,
}

/// A value and its slopes along both variables.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub(super) struct Sloped {
    /// The value.
    pub value: f64,
    /// ∂/∂u.
    pub du: f64,
    /// ∂/∂v.
    pub dv: f64,
}

impl Polynomial {
    /// All zero, with room for powers up to `order` of each variable.
    pub fn zero(order: usize) -> Self {
        Self { rows: vec![vec![0.0; order + 1]; order + 1], radial: Vec::new() }
    }

    /// Adds to the coefficient of uᵐ·vⁿ; powers beyond the order are added to it.
    pub fn add(&mut self, m: usize, n: usize, coefficient: f64) {
        let order = self.rows.len().max(m + 1).max(n + 1);
        self.rows.resize(order, Vec::new());
        for row in &mut self.rows {
            row.resize(order, 0.0);
        }
        self.rows[n][m] += coefficient;
    }

    /// Adds to the coefficient of r^(2k+1), k from 0 to 3.
    pub fn add_radial(&mut self, k: usize, coefficient: f64) {
        if coefficient != 0.0 {
            self.radial.resize(RADIAL_TERMS.max(k + 1), 0.0);
            self.radial[k] += coefficient;
        }
    }

    /// Value and slopes, by Horner's rule in both variables.
    pub fn at(&self, u: f64, v: f64) -> Sloped {
        let mut sum = Sloped::default();
        for row in self.rows.iter().rev() {
            let (mut value, mut slope) = (0.0, 0.0);
            for coefficient in row.iter().rev() {
                slope = slope * u + value;
                value = value * u + coefficient;
            }
            sum.dv = sum.dv * v + sum.value;
            sum.value = sum.value * v + value;
            sum.du = sum.du * v + slope;
        }
        if !self.radial.is_empty() {
            let square = u * u + v * v;
            let r = square.sqrt();
            // Σ c r^(2k+1), and its slope along r divided by r: Σ (2k+1) c r^(2k-1), without the first term at the centre.
            let (mut value, mut slope) = (0.0, 0.0);
            for (k, coefficient) in self.radial.iter().enumerate().rev() {
                value = value * square + coefficient;
                slope = slope * square + (2 * k + 1) as f64 * coefficient;
            }
            sum.value += value * r;
            if r > 0.0 {
                sum.du += slope * u / r;
                sum.dv += slope * v / r;
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_slopes_are_those_of_the_values() {
        let mut polynomial = Polynomial::zero(1);
        for (m, n, c) in [(0, 0, 0.3), (1, 0, 1.1), (0, 1, -0.2), (2, 1, 0.07), (0, 3, -0.4), (4, 1, 0.9)] {
            polynomial.add(m, n, c);
        }
        polynomial.add_radial(0, 0.05);
        polynomial.add_radial(2, -0.3);
        let direct = |u: f64, v: f64| {
            let r = u.hypot(v);
            0.3 + 1.1 * u - 0.2 * v + 0.07 * u * u * v - 0.4 * v.powi(3) + 0.9 * u.powi(4) * v + 0.05 * r
                - 0.3 * r.powi(5)
        };
        let (u, v, h) = (0.7, -0.4, 1e-6);
        let at = polynomial.at(u, v);
        assert!((at.value - direct(u, v)).abs() < 1e-15);
        // Central differences are good to h² and to rounding over h.
        assert!((at.du - (direct(u + h, v) - direct(u - h, v)) / (2.0 * h)).abs() < 1e-9);
        assert!((at.dv - (direct(u, v + h) - direct(u, v - h)) / (2.0 * h)).abs() < 1e-9);
    }
}
