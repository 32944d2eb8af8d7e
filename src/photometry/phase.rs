//! Brightness as a function of the phase angle only: published polynomials, diffuse spheres, and objects of which only
//! a standard magnitude is known.
//!
//! The polynomials are m(1000 km) = a0 + a1 φ + a2 φ² + …, with φ in degrees. They are invalid outside the phase angles
//! of the fit (that of Starlink V1.5 gives 3.9 mag at 0° and 3.1 mag at 180°), so φ is clamped to the fitted range.

use std::f64::consts::PI;
use std::sync::Arc;

use super::magnitude::StandardMagnitude;

/// Polynomial in the phase angle, constant outside the fitted range.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFunction {
    coefficients: Arc<[f64]>,
    min_phase_deg: f64,
    max_phase_deg: f64,
}

impl PhaseFunction {
    /// Creates a function from coefficients of φ⁰, φ¹, … (φ in degrees) and the fitted range of φ, degrees.
    ///
    /// `None` if there is no coefficient, if a value is not finite, or unless 0 ≤ min < max ≤ 180.
    pub fn new(coefficients: &[f64], min_phase_deg: f64, max_phase_deg: f64) -> Option<Self> {
        let sound = !coefficients.is_empty()
            && coefficients.iter().all(|c| c.is_finite())
            && min_phase_deg >= 0.0
            && min_phase_deg < max_phase_deg
            && max_phase_deg <= 180.0;
        sound.then(|| Self { coefficients: coefficients.into(), min_phase_deg, max_phase_deg })
    }

    /// Returns the magnitude at 1000 km. The phase angle is clamped to the fitted range.
    pub fn standard_magnitude(&self, phase_angle_rad: f64) -> StandardMagnitude {
        let phase_deg = phase_angle_rad.to_degrees().clamp(self.min_phase_deg, self.max_phase_deg);
        StandardMagnitude(self.coefficients.iter().rev().fold(0.0, |sum, c| sum * phase_deg + c))
    }
}

/// An object with no other data than its standard magnitude: its light falls linearly with the phase angle φ, as
/// 1 - φ/180°.
///
/// This is the rule of Heavens-Above's predictions from 20° to 161° (`tests/library/standard_magnitudes.rs`); a
/// Lambertian sphere is up to two magnitudes fainter at large phase angles.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StandardObject {
    /// Magnitude at 1000 km and phase angle 90°.
    pub half_lit: StandardMagnitude,
}

impl StandardObject {
    /// Returns the magnitude at 1000 km for a phase angle in [0, π]; `None` at π, where no lit surface is visible.
    pub fn standard_magnitude(&self, phase_angle_rad: f64) -> Option<StandardMagnitude> {
        // m = m(90°) - 2.5 log10(2 (1 - φ/180°))
        let light = linear_phase_law(phase_angle_rad);
        (light > 0.0).then(|| StandardMagnitude(self.half_lit.0 - 2.5 * light.log10()))
    }
}

/// Returns the light of a [`StandardObject`] at a phase angle in [0, π], relative to that at 90°.
pub(super) fn linear_phase_law(phase_angle_rad: f64) -> f64 {
    2.0 * (1.0 - phase_angle_rad / PI)
}

/// A diffuse sphere scaled to a standard magnitude: the simplest form to compare fits with.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct DiffuseSphere {
    /// Magnitude at 1000 km and a phase angle of 90°.
    pub half_lit: StandardMagnitude,
}

impl DiffuseSphere {
    /// Returns the magnitude at 1000 km for a phase angle in [0, π]; `None` at π, where no lit surface is visible.
    pub fn standard_magnitude(&self, phase_angle_rad: f64) -> Option<StandardMagnitude> {
        let f = lambert_sphere(phase_angle_rad);
        (f > 0.0).then(|| StandardMagnitude(self.half_lit.0 - 2.5 * f.log10()))
    }
}

/// Returns the light of a Lambertian sphere at a phase angle in [0, π], relative to that at 90°.
pub(super) fn lambert_sphere(phase_angle_rad: f64) -> f64 {
    // F(φ) ∝ sin φ + (π - φ) cos φ
    phase_angle_rad.sin() + (PI - phase_angle_rad) * phase_angle_rad.cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn valid_v15_polynomial_inside_and_clamped_outside() {
        let f = PhaseFunction::new(&[3.944, 0.06893, -0.0004089], 30.0, 150.0).unwrap();
        let at = |degrees: f64| f.standard_magnitude(degrees.to_radians()).0;
        assert!((at(90.0) - (3.944 + 0.06893 * 90.0 - 0.0004089 * 8100.0)).abs() < 1e-12);
        assert!((at(0.0) - at(30.0)).abs() < 1e-12 && (at(180.0) - at(150.0)).abs() < 1e-12);
    }

    #[test]
    fn verif_invalid_functions_are_rejected() {
        for (c, lo, hi) in [
            (&[][..], 30.0, 150.0),
            (&[f64::NAN][..], 30.0, 150.0),
            (&[5.0][..], 150.0, 30.0),
            (&[5.0][..], -1.0, 30.0),
            (&[5.0][..], 0.0, 181.0),
        ] {
            assert_eq!(PhaseFunction::new(c, lo, hi), None);
        }
    }

    #[test]
    fn verif_sphere_at_full_and_half_phase() {
        let sphere = DiffuseSphere { half_lit: StandardMagnitude(6.0) };
        assert!((sphere.standard_magnitude(FRAC_PI_2).unwrap().0 - 6.0).abs() < 1e-12);
        // A Lambertian sphere is π times brighter at full than at half phase.
        assert!((sphere.standard_magnitude(0.0).unwrap().0 - (6.0 - 2.5 * PI.log10())).abs() < 1e-12);
        assert!(sphere.standard_magnitude(3.0).unwrap().0 > 10.0);
        assert_eq!(sphere.standard_magnitude(4.0), None);
    }

    #[test]
    fn verif_light_of_a_standard_object_is_linear_in_the_phase() {
        let object = StandardObject { half_lit: StandardMagnitude(4.0) };
        let at = |degrees: f64| object.standard_magnitude(degrees.to_radians()).map(|magnitude| magnitude.0);
        assert!((at(90.0).unwrap() - 4.0).abs() < 1e-12);
        assert!((at(0.0).unwrap() - (4.0 - 2.5 * 2_f64.log10())).abs() < 1e-12);
        assert!((at(135.0).unwrap() - (4.0 + 2.5 * 2_f64.log10())).abs() < 1e-12);
        assert_eq!(at(180.0), None);
    }
}
