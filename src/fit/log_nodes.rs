//! Interpolation in the logarithm of a parameter.
//!
//! The nodes are Chebyshev's points of the first kind in ln x. The barycentric formula (Berrut and Trefethen 2004, SIAM
//! Review 46, 501, eqs. 4.2 and 5.4) evaluates the polynomial of degree N - 1 through the values at the nodes.

use std::f64::consts::PI;

/// N values of a positive parameter, used as nodes of an interpolation.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LogNodes<const N: usize> {
    /// Values of the parameter at the nodes, increasing.
    pub at: [f64; N],
    logarithms: [f64; N],
    barycentric: [f64; N],
}

impl<const N: usize> LogNodes<N> {
    /// Creates nodes between two positive ends.
    pub fn new([least, greatest]: [f64; 2]) -> Self {
        let [least, greatest] = [least.ln(), greatest.ln()];
        let angle = |k: usize| PI * (k as f64 + 0.5) / N as f64;
        let logarithms: [f64; N] =
            std::array::from_fn(|k| 0.5 * (least + greatest) - 0.5 * (greatest - least) * angle(k).cos());
        // w_k = (-1)^k sin((2k + 1) π / 2N)
        let barycentric = std::array::from_fn(|k| if k % 2 == 0 { angle(k).sin() } else { -angle(k).sin() });
        Self { at: logarithms.map(f64::exp), logarithms, barycentric }
    }

    /// Returns the weights of the nodes for a value of the parameter.
    pub fn weights(&self, value: f64) -> [f64; N] {
        let x = value.ln();
        if let Some(at) = self.logarithms.iter().position(|node| *node == x) {
            return std::array::from_fn(|k| f64::from(u8::from(k == at)));
        }
        let parts: [f64; N] = std::array::from_fn(|k| self.barycentric[k] / (x - self.logarithms[k]));
        let sum: f64 = parts.iter().sum();
        parts.map(|part| part / sum)
    }

    /// Returns the derivatives of the weights with respect to the parameter.
    pub fn slopes(&self, value: f64) -> [f64; N] {
        // Central differences of polynomials in ln x have a relative error of 1e-9.
        let h = 1e-4;
        let (up, down) = (self.weights(value * f64::exp(h)), self.weights(value * f64::exp(-h)));
        std::array::from_fn(|k| (up[k] - down[k]) / (2.0 * h * value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_polynomials_of_the_logarithm_are_reproduced() {
        let nodes = LogNodes::<6>::new([0.5, 200.0]);
        let value = |x: f64| 1.0 + 0.5 * x.ln() - 0.1 * x.ln().powi(3) + 0.01 * x.ln().powi(5);
        let slope = |x: f64| (0.5 - 0.3 * x.ln().powi(2) + 0.05 * x.ln().powi(4)) / x;
        let sum = |weights: &[f64]| weights.iter().zip(&nodes.at).map(|(w, x)| w * value(*x)).sum::<f64>();
        for x in [0.5, 0.9, 7.0, nodes.at[2], 199.0] {
            assert!((sum(&nodes.weights(x)) - value(x)).abs() < 1e-10, "{x}");
            assert!((sum(&nodes.slopes(x)) - slope(x)).abs() < 1e-6 * (1.0 + slope(x).abs()), "{x}");
        }
    }
}
