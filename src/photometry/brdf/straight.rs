//! A lobe about the transmitted direction: light that passes through a panel with little deflection.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `weight` | 1 | 0 and up | fraction of the incident power in the lobe, for light along the normal |
//! | `exponent` | 1 | 0 and up | narrowness: half maximum at acos(2^(-1/n)), 14.3° for n = 22 |
//!
//! The law describes light that leaks forward through a solar array, between its photovoltaic cells or through thin
//! blankets. It is a law for the face `through`, which is lit from the front and seen from behind. The lobe is Phong's
//! lobe mirrored in the plane of the panel, with the same energy: for light along the normal `weight` is transmitted.
//! At oblique incidence part of the lobe is on the lit side, where `through` has no light, and less is transmitted; at
//! grazing incidence the axis of the lobe lies in the plane and half of the lobe is lost. The lobe depends only on the
//! angle between Sun and observer. It is reciprocal, and 0 for angles below 90°. As a law of a `front` it contributes
//! only the part of the lobe above the plane of the panel: some light near grazing incidence.
//!
//! The law is empirical; it is included because fits to measured satellites require light in this direction.
//!
//! Reference: the lobe of Lu (2024), eq. 2, with its axis along the transmitted light.

use super::law::{Brdf, Incidence, lobe_per_sr};

/// A lobe about the transmitted direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Straight {
    /// Fraction of the power in the lobe for light along the normal.
    pub weight: f64,
    /// Narrowness of the lobe.
    pub exponent: f64,
}

impl Brdf for Straight {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        // f = c (n + 2) / 2π · (-s · o)ⁿ
        lobe_per_sr(self.weight, self.exponent, -incidence.cos_phase())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Phong;
    use super::super::energy::{check_law, reflected_share, transmitted_share};
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn verif_energy_on_the_far_side() {
        for exponent in [0.0, 1.0, 22.0, 300.0] {
            let law = Straight { weight: 0.7, exponent };
            assert!((transmitted_share(&law, 1.0) - 0.7).abs() < 7e-4, "{exponent}");
            // The energy is that of Phong's lobe at every incidence, down to grazing.
            let mirrored = Phong { weight: 0.7, exponent };
            for cos_in in [1.0, 0.6, 0.2, 0.0] {
                let (far, near) = (transmitted_share(&law, cos_in), reflected_share(&mirrored, cos_in));
                assert!((far - near).abs() < 1e-12 && far < 0.7007, "{exponent} {cos_in}: {far} {near}");
            }
        }
        // Almost no light on the lit side; a narrow lobe at grazing incidence is shared between both sides.
        let narrow = Straight { weight: 1.0, exponent: 300.0 };
        assert!(reflected_share(&narrow, 1.0) < 1e-12);
        let (far, lit) = (transmitted_share(&narrow, 0.0), reflected_share(&narrow, 0.0));
        assert!((far / lit - 1.0).abs() < 1e-9 && far < 0.05, "{far} {lit}");
    }

    #[test]
    fn verif_brightest_straight_ahead_and_dark_towards_the_source() {
        let law = Straight { weight: 0.2, exponent: 5.0 };
        let (normal, light) = (Vector3::z(), Vector3::new(0.6, 0.0, 0.8));
        let at = |eye: Vector3<f64>| law.value_per_sr(&Incidence::new(&normal, &light, &eye));
        assert!((at(-light) - 0.2 * 7.0 / std::f64::consts::TAU).abs() < 1e-14);
        assert_eq!(at(light), 0.0);
        assert_eq!(at(Vector3::new(0.8, 0.0, -0.6)), 0.0);
    }

    #[test]
    fn verif_straight_is_reciprocal_and_finite() {
        check_law(&Straight { weight: 0.3, exponent: 4.0 });
        check_law(&Straight { weight: 0.0, exponent: 0.0 });
    }
}
