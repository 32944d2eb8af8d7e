//! Binomial law: the logarithm of the reflectance is expanded in quantities for which the law is reciprocal.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `b` | 1 | any | coefficients b\[k\]\[i\] of D^i V^k |
//! | `c` | 1 | any | coefficients c\[k\]\[j\] of ½ log₁₀(1 + d^(j+l) D²) V^k |
//! | `d` | 1 | more than 0 | ratio of the widths of successive lobes |
//! | `first` | 1 | any integer | l, the index of the widest lobe |
//!
//! D is the distance between the projections of the observer's direction and the mirror direction onto the surface, and
//! V their scalar product. Both are unchanged if source and observer are exchanged, so that the law is reciprocal for
//! any coefficients. The law is a fit to laboratory data that does not ensure energy conservation; `reflected_share`
//! computes the fraction of the light that is reflected.
//!
//! Reference: Greynolds (2015, Proc. SPIE 9577, 95770A); Fankhauser, Tyson and Askari (2023, AJ 166, 59), with fits to
//! a satellite's chassis and solar array.

use super::law::{Brdf, Incidence};

/// Coefficients of a binomial expansion.
#[derive(Clone, Debug, PartialEq)]
pub struct Binomial {
    /// Coefficients of the powers of D; shape `(n_k, n_i)`.
    pub b: Vec<Vec<f64>>,
    /// Coefficients of the logarithms; shape `(n_k, n_j)`, with as many rows as `b`.
    pub c: Vec<Vec<f64>>,
    /// Ratio of the widths of successive lobes.
    pub d: f64,
    /// Index of the widest lobe.
    pub first: i32,
}

impl Brdf for Binomial {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        let squared = incidence.sine_distance_squared();
        let distance = squared.sqrt();
        let product = incidence.sine_product();
        // log₁₀ f = Σ_k (Σ_i b_ki D^i + ½ Σ_j c_kj log₁₀(1 + d^(j+l) D²)) V^k
        let polynomial = |row: &Vec<f64>| row.iter().rev().fold(0.0, |sum, b| sum * distance + b);
        let lobes = |row: &Vec<f64>| {
            let lobe = |(j, c): (usize, &f64)| 0.5 * c * (1.0 + self.d.powi(j as i32 + self.first) * squared).log10();
            row.iter().enumerate().map(lobe).sum::<f64>()
        };
        let logarithm =
            self.b.iter().zip(&self.c).rev().fold(0.0, |sum, (b, c)| sum * product + polynomial(b) + lobes(c));
        10.0_f64.powf(logarithm)
    }
}

#[cfg(test)]
mod tests {
    use super::super::energy::{check_law, reflected_share};
    use super::*;
    use nalgebra::Vector3;

    fn law() -> Binomial {
        Binomial {
            b: vec![vec![-0.6, -0.3], vec![0.2, 0.1]],
            c: vec![vec![-0.4, -0.5, -0.1], vec![0.05, 0.0, 0.02]],
            d: 5.0,
            first: -1,
        }
    }

    #[test]
    fn valid_binomial_against_numbers_worked_by_hand() {
        // Normal z, source 30° from it, observer 30° on the other side (the mirror): D = 0, V = sin² 30° = 1/4, so
        // log₁₀ f = -0.6 + 0.2/4 = -0.55.
        let normal = Vector3::z();
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let (light, mirror) = (Vector3::new(sin, 0.0, cos), Vector3::new(-sin, 0.0, cos));
        let at = |eye: &Vector3<f64>| law().value_per_sr(&Incidence::new(&normal, &light, eye));
        // D² is 0 within rounding, D within its square root.
        assert!((at(&mirror).log10() + 0.55).abs() < 1e-7);
        // Observer along the normal: D = 1/2, V = 0, log₁₀ f = -0.6 - 0.15 + ½ (-0.4 log(1 + 0.2/4) - 0.5 log(1 + 1/4)
        // - 0.1 log(1 + 5/4)).
        let expected: f64 = -0.75 + 0.5 * (-0.4 * 1.05_f64.log10() - 0.5 * 1.25_f64.log10() - 0.1 * 2.25_f64.log10());
        assert!((at(&normal).log10() - expected).abs() < 1e-12);
    }

    #[test]
    fn verif_binomial_is_reciprocal_and_finite() {
        check_law(&law());
        assert!(reflected_share(&law(), 1.0) > 0.1);
    }
}
