//! The ABg law of stray-light analysis: a lobe about the mirror direction with a shoulder and a power-law wing.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `a` | sr⁻¹ | 0 and up | height: the peak is A/B |
//! | `b` | 1 | more than 0 | the flat top ends where x^g = B |
//! | `g` | 1 | 0 and up | slope of the wing |
//!
//! x is the distance between the projections of the observer's direction and the mirror direction onto the surface (the
//! "direction sines" of scattering by small roughness). The law is therefore reciprocal, and its shape does not depend
//! on the angle of incidence. It is used for polished and painted surfaces; Fankhauser et al. fit it to satellite
//! materials.
//!
//! Reference: Pfisterer (2011), *Approximated scatter models for stray light analysis*, Optics & Photonics News 22(10);
//! Fankhauser, Tyson and Askari (2023, AJ 166, 59).

use super::law::{Brdf, Incidence};

/// Lobe about the mirror direction with a shoulder and a power-law wing.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Abg {
    /// Amplitude, sr⁻¹.
    pub a: f64,
    /// Value B that determines where the flat top ends: at x^g = B.
    pub b: f64,
    /// Slope g of the wing.
    pub g: f64,
}

impl Brdf for Abg {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        // f = A / (B + x^g)
        self.a / (self.b + incidence.sine_distance_squared().powf(0.5 * self.g))
    }
}

#[cfg(test)]
mod tests {
    use super::super::energy::{check_law, reflected_share};
    use super::*;

    #[test]
    fn verif_energy_at_normal_incidence_has_a_closed_form_for_g_2() {
        // ∫ A/(B + β²) 2π β dβ over the unit disk of direction sines = π A ln((B + 1)/B)
        let law = Abg { a: 0.02, b: 0.003, g: 2.0 };
        let closed = std::f64::consts::PI * law.a * ((law.b + 1.0) / law.b).ln();
        assert!((reflected_share(&law, 1.0) / closed - 1.0).abs() < 1e-3, "{}", reflected_share(&law, 1.0));
    }

    #[test]
    fn verif_abg_is_reciprocal_and_finite() {
        check_law(&Abg { a: 0.02, b: 0.003, g: 1.7 });
    }
}
