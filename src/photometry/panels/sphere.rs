//! Parts without an orientation (antennas, radiators, clutter) as spheres with light that depends on the phase angle
//! only.
//!
//! They are never shaded or hidden, cast no shadow, and receive no earthshine.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::photometry::phase::lambert_sphere;

/// Dependence of the light of a sphere on the phase angle.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpherePhase {
    /// A sphere that reflects by Lambert's law.
    Lambert,
    /// Equal light in every direction.
    Isotropic,
}

/// A sphere, or many parts with the light of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    /// Name in the file.
    pub name: String,
    /// Cross-section, m².
    pub area_m2: f64,
    /// Fraction of the incident power that is reflected, in all directions together.
    pub albedo: f64,
    /// Dependence on the phase angle.
    pub phase: SpherePhase,
}

impl Sphere {
    /// Returns the reflected sunlight at a phase angle in [0, π], m² sr⁻¹.
    pub fn m2_sr(&self, phase_angle_rad: f64) -> f64 {
        let per_m2 = match self.phase {
            // 2/3, the geometric albedo of a white Lambertian sphere, and its phase function, 1 at full phase:
            // B = c A/π · 2/3 · (sin φ + (π - φ) cos φ)/π               Russell (1916), ApJ 43, 173
            SpherePhase::Lambert => 2.0 / (3.0 * PI * PI) * lambert_sphere(phase_angle_rad).max(0.0),
            // B = c A/4π
            SpherePhase::Isotropic => 0.25 / PI,
        };
        self.albedo * self.area_m2 * per_m2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::brdf::{Brdf, Incidence, Lambert};
    use crate::photometry::{DiffuseSphere, StandardMagnitude};
    use nalgebra::Vector3;

    fn sphere(phase: SpherePhase) -> Sphere {
        Sphere { name: "clutter".to_owned(), area_m2: 2.5, albedo: 0.4, phase }
    }

    #[test]
    fn verif_all_directions_together_receive_the_albedo() {
        for phase in [SpherePhase::Lambert, SpherePhase::Isotropic] {
            let (sphere, n) = (sphere(phase), 20_000);
            // ∫ B 2π sin φ dφ = c A
            let sum: f64 = (0..n)
                .map(|i| {
                    let angle = (f64::from(i) + 0.5) * PI / f64::from(n);
                    sphere.m2_sr(angle) * 2.0 * PI * angle.sin() * PI / f64::from(n)
                })
                .sum();
            assert!((sum - 0.4 * 2.5).abs() < 1e-7, "{phase:?}: {sum}");
        }
    }

    #[test]
    fn verif_lambert_sphere_is_a_ball_of_lambertian_plates() {
        let (sphere, n) = (sphere(SpherePhase::Lambert), 400);
        let law = Lambert { albedo: 0.4 };
        let to_sun = Vector3::z();
        for angle in [0.0_f64, 0.6, 1.5, 2.6] {
            let to_observer = Vector3::new(angle.sin(), 0.0, angle.cos());
            let mut sum = 0.0;
            for i in 0..n {
                let cos: f64 = (f64::from(i) + 0.5) / f64::from(n);
                let sin = (1.0 - cos * cos).sqrt();
                for j in 0..2 * n {
                    let psi = (f64::from(j) + 0.5) * PI / f64::from(n);
                    let normal = Vector3::new(sin * psi.cos(), sin * psi.sin(), cos);
                    let incidence = Incidence::new(&normal, &to_sun, &to_observer);
                    // R² = A/π; the lit half in cells of equal size
                    let cell_m2 = 2.5 / PI * PI / f64::from(n * n);
                    sum += law.value_per_sr(&incidence) * incidence.front() * cell_m2;
                }
            }
            // Cells of 1/400 at the terminator.
            assert!((sum - sphere.m2_sr(angle)).abs() < 1e-5, "{angle}: {sum} {}", sphere.m2_sr(angle));
        }
    }

    #[test]
    fn verif_lambert_sphere_equals_the_sphere_of_standard_magnitudes() {
        let sphere = sphere(SpherePhase::Lambert);
        let magnitude = |angle: f64| StandardMagnitude::from_reflection(sphere.m2_sr(angle), -26.76).map(|it| it.0);
        let known = DiffuseSphere { half_lit: StandardMagnitude(magnitude(PI / 2.0).unwrap()) };
        for degrees in 0..180 {
            let angle = f64::from(degrees).to_radians();
            let expected = known.standard_magnitude(angle).unwrap().0;
            assert!((magnitude(angle).unwrap() - expected).abs() < 1e-9, "{degrees}°");
        }
        assert_eq!(sphere.m2_sr(4.0), 0.0);
    }
}
