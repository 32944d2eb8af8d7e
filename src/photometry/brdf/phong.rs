//! Phong's glossy lobe about the mirror direction, normalised as in Lu (2024).
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `weight` | 1 | 0 and up | fraction of the incident power in the lobe, for light along the normal |
//! | `exponent` | 1 | 0 and up | narrowness: half maximum at acos(2^(-1/n)), 14.3° for n = 22 |
//!
//! θ is the angle between the mirror direction of the incident light and the observer; beyond 90° the lobe is 0. With
//! the factor (n+2)/2π, the reflected power for light along the normal is `weight` (the integral includes the cosine of
//! projection). At oblique incidence part of the lobe is below the surface and less light is reflected. The law is
//! reciprocal, because θ is unchanged if source and observer are exchanged.
//!
//! The law is empirical: it has no Fresnel increase towards grazing incidence and no masking, and its exponent has no
//! physical meaning.
//!
//! Reference: Lu (2024), eqs. 2 and 5; Phong (1975), CACM 18, 311.

use super::law::{Brdf, Incidence, lobe_per_sr};

/// Glossy lobe about the mirror direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Phong {
    /// Fraction of the power in the lobe for light along the normal.
    pub weight: f64,
    /// Narrowness of the lobe.
    pub exponent: f64,
}

impl Brdf for Phong {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        // f = c (n + 2) / 2π · cosⁿθ                                     Lu (2024), eq. 2
        lobe_per_sr(self.weight, self.exponent, incidence.cos_mirror)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn up(longitude: f64, cos: f64) -> Vector3<f64> {
        let sin = (1.0 - cos * cos).sqrt();
        Vector3::new(sin * longitude.cos(), sin * longitude.sin(), cos)
    }

    #[test]
    fn verif_energy_of_the_lobe_under_light_along_the_normal() {
        let normal = Vector3::z();
        for exponent in [0.0, 1.0, 5.0, 22.0, 300.0] {
            let law = Phong { weight: 0.7, exponent };
            let n = 200_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let cos = (i as f64 + 0.5) / n as f64;
                    let incidence = Incidence::new(&normal, &normal, &up(0.0, cos));
                    law.value_per_sr(&incidence) * incidence.cos_out * TAU / n as f64
                })
                .sum();
            // Midpoint rule in 2·10⁵ cells, for exponents up to 300.
            assert!((sum - 0.7).abs() < 1e-6, "n {exponent}: {sum}");
        }
    }

    #[test]
    fn verif_half_width_of_the_lobe() {
        let law = Phong { weight: 1.0, exponent: 22.0 };
        let normal = Vector3::z();
        let at =
            |degrees: f64| law.value_per_sr(&Incidence::new(&normal, &normal, &up(0.0, degrees.to_radians().cos())));
        assert!((at(14.3) / at(0.0) - 0.5).abs() < 2e-3);
    }

    proptest! {
        #[test]
        fn verif_phong_is_reciprocal(a in 0.0..6.3, b in 0.0..6.3, ca in 0.01..1.0, cb in 0.01..1.0, n in 0.0..200.0) {
            let (law, normal) = (Phong { weight: 0.4, exponent: n }, Vector3::z());
            let there = law.value_per_sr(&Incidence::new(&normal, &up(a, ca), &up(b, cb)));
            let back = law.value_per_sr(&Incidence::new(&normal, &up(b, cb), &up(a, ca)));
            prop_assert!((there - back).abs() <= 1e-9 * there.max(1.0));
        }
    }
}
