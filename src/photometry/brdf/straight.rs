//! A lobe about the continued ray: light that goes through a panel and is little turned.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `weight` | 1 | 0 and up | share of the incident power in the lobe, for light along the normal |
//! | `exponent` | 1 | 0 and up | narrowness: the lobe is down to half at acos(2^(-1/n)), 14.3° for n = 22 |
//!
//! For light that leaks forward through a solar array, between its cells and through thin blankets: a law for the face
//! `through`, lit from the front and seen from behind. It stands where Phong's lobe stands after the panel's plane has
//! mirrored it, so it shares Phong's budget: under light along the normal `weight` leaves on the far side, at slant
//! incidence part of the lobe lies on the lit side, where `through` sends nothing, and less leaves; at grazing
//! incidence half of the lobe is lost and the rest lies in the plane. The lobe depends on the angle between Sun and
//! observer alone: it is reciprocal, and dark where they stand less than 90° apart. On a `front` it gives what lies
//! above the plane, some light near grazing.
//!
//! It is empirical: fits to measured satellites need light there.
//!
//! Reference: the lobe is that of Lu (2024), eq. 2, turned to the other direction.

use super::law::{Brdf, Incidence, lobe_per_sr};

/// A lobe about the continued ray.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Straight {
    /// Share of the power in the lobe under light along the normal.
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
            // Phong's budget at every slant, down to grazing.
            let mirrored = Phong { weight: 0.7, exponent };
            for cos_in in [1.0, 0.6, 0.2, 0.0] {
                let (far, near) = (transmitted_share(&law, cos_in), reflected_share(&mirrored, cos_in));
                assert!((far - near).abs() < 1e-12 && far < 0.7007, "{exponent} {cos_in}: {far} {near}");
            }
        }
        // Nearly nothing on the lit side, and the two sides share a narrow lobe at grazing.
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
