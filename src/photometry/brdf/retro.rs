//! A lobe about the direction back to the source.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `weight` | 1 | 0 and up | fraction of the incident power in the lobe, for light along the normal |
//! | `exponent` | 1 | 0 and up | narrowness: half maximum at acos(2^(-1/n)), 14.3° for n = 22 |
//!
//! The law describes surfaces that are brightest with the Sun behind the observer: crumpled foil, corners, or rough
//! ground whose shadows are then hidden. The lobe is Phong's lobe rotated by half a turn about the normal, with the
//! same energy: for light along the normal `weight` is reflected; at oblique incidence part of the lobe is below the
//! surface and less is reflected. The lobe depends only on the phase angle. It is reciprocal, and 0 at phase angles
//! beyond 90°.
//!
//! The law is empirical; it is included because fits to measured satellites require light in this direction.
//!
//! Reference: the lobe of Lu (2024), eq. 2, with its axis towards the source.

use super::law::{Brdf, Incidence, lobe_per_sr};

/// A lobe about the direction back to the source.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Retro {
    /// Fraction of the power in the lobe for light along the normal.
    pub weight: f64,
    /// Narrowness of the lobe.
    pub exponent: f64,
}

impl Brdf for Retro {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        // f = c (n + 2) / 2π · (s · o)ⁿ
        lobe_per_sr(self.weight, self.exponent, incidence.cos_phase())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Phong;
    use super::super::energy::{check_law, reflected_share};
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn verif_energy_that_leaves() {
        for exponent in [0.0, 1.0, 22.0, 300.0, 5000.0] {
            let law = Retro { weight: 0.7, exponent };
            assert!((reflected_share(&law, 1.0) - 0.7).abs() < 7e-4, "{exponent}");
            // The energy is that of Phong's lobe at every incidence, down to grazing.
            let turned = Phong { weight: 0.7, exponent };
            for cos_in in [1.0, 0.6, 0.2, 0.0] {
                let (back, forth) = (reflected_share(&law, cos_in), reflected_share(&turned, cos_in));
                assert!((back - forth).abs() < 1e-12 && back < 0.7007, "{exponent} {cos_in}: {back} {forth}");
            }
        }
    }

    #[test]
    fn verif_brightest_towards_the_source_and_dark_beyond_a_right_angle() {
        let law = Retro { weight: 0.2, exponent: 5.0 };
        let (normal, light) = (Vector3::z(), Vector3::new(0.6, 0.0, 0.8));
        let at = |eye: Vector3<f64>| law.value_per_sr(&Incidence::new(&normal, &light, &eye));
        assert!((at(light) - 0.2 * 7.0 / std::f64::consts::TAU).abs() < 1e-14);
        assert_eq!(at(-light), 0.0);
        assert_eq!(at(Vector3::new(-0.9, 0.0, 0.19_f64.sqrt())), 0.0);
    }

    #[test]
    fn verif_retro_is_reciprocal_and_finite() {
        check_law(&Retro { weight: 0.3, exponent: 4.0 });
        check_law(&Retro { weight: 0.0, exponent: 0.0 });
    }
}
