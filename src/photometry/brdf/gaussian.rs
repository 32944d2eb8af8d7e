//! A Gaussian-like lobe about the mirror direction.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `peak_per_sr` | sr⁻¹ | 0 and up | height in the mirror direction |
//! | `width` | 1 | more than 0 | 1/e of the peak at cos θ = 1 - width; about √(2 width) rad if small |
//!
//! θ is the angle between the mirror direction and the observer. The law is reciprocal and, like Phong's, loses energy
//! below the surface at oblique incidence.
//!
//! Reference: Fankhauser, Tyson and Askari (2023, AJ 166, 59), the form of their published code.

use super::law::{Brdf, Incidence};

/// Gaussian-like lobe about the mirror direction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Gaussian {
    /// Peak value, sr⁻¹.
    pub peak_per_sr: f64,
    /// Width: the value of 1 - cos θ at which the lobe is 1/e of its peak.
    pub width: f64,
}

impl Brdf for Gaussian {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        // f = A exp((cos θ - 1) / w)
        self.peak_per_sr * ((incidence.cos_mirror - 1.0) / self.width).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::super::energy::{check_law, reflected_share};
    use super::*;

    #[test]
    fn verif_energy_at_normal_incidence_in_closed_form() {
        // ∫ A e^((c-1)/w) c 2π dc over 0 ≤ c ≤ 1 = 2π A w (1 - w + w e^(-1/w))
        let law = Gaussian { peak_per_sr: 2.0, width: 0.03 };
        let (a, w) = (law.peak_per_sr, law.width);
        let closed = std::f64::consts::TAU * a * w * (1.0 - w + w * (-1.0 / w).exp());
        assert!((reflected_share(&law, 1.0) / closed - 1.0).abs() < 1e-3);
    }

    #[test]
    fn verif_gaussian_is_reciprocal_and_finite() {
        check_law(&Gaussian { peak_per_sr: 2.0, width: 0.03 });
    }
}
