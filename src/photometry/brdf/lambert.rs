//! Lambert's law: equal radiance in every direction.
//!
//! | parameter | unit | range | meaning |
//! |---|---|---|---|
//! | `albedo` | 1 | 0 and up, at most 1 where energy is conserved | fraction of the incident power that is reflected |
//!
//! Lambert's law is valid for a rough surface with multiple scattering, and inaccurate near grazing incidence. Lu
//! (2024) uses it for the diffuse light of chassis and solar array and for the light that leaks through the gaps of the
//! solar array.
//!
//! Reference: Lu (2024), eqs. 3, 4 and 6; Lambert, *Photometria* (1760).

use std::f64::consts::FRAC_1_PI;

use super::law::{Brdf, Incidence};

/// A Lambertian surface.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Lambert {
    /// Fraction of the incident power that is reflected.
    pub albedo: f64,
}

impl Brdf for Lambert {
    fn value_per_sr(&self, _incidence: &Incidence) -> f64 {
        // f = c / π                                                      Lu (2024), eq. 3
        self.albedo * FRAC_1_PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn verif_energy_leaving_a_lambertian_plate_is_its_albedo() {
        // ∫ f cos θ dω over the hemisphere, midpoint rule in cos θ (azimuth is symmetric).
        let law = Lambert { albedo: 0.3 };
        let to_sun = Vector3::new(0.6, 0.0, 0.8);
        let n = 2000;
        let sum: f64 = (0..n)
            .map(|i| {
                let cos = (i as f64 + 0.5) / n as f64;
                let to_observer = Vector3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let incidence = Incidence::new(&Vector3::z(), &to_sun, &to_observer);
                law.value_per_sr(&incidence) * incidence.cos_out * std::f64::consts::TAU / n as f64
            })
            .sum();
        assert!((sum - 0.3).abs() < 1e-9, "{sum}");
    }
}
