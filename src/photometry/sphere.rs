//! A diffuse sphere scaled to a standard magnitude: what is assumed of an object known by its brightness only.

use std::f64::consts::PI;

use super::magnitude::StandardMagnitude;

/// A white ball whose brightness at 1000 km and phase angle 90° (half of it lit) is known.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct DiffuseSphere {
    /// Magnitude at 1000 km and phase angle 90°.
    pub half_lit: StandardMagnitude,
}

impl DiffuseSphere {
    /// Magnitude at 1000 km for a phase angle in [0, π]; `None` at π, where nothing lit is seen.
    pub fn standard_magnitude(&self, phase_angle_rad: f64) -> Option<StandardMagnitude> {
        let f = lambert_sphere(phase_angle_rad);
        (f > 0.0).then(|| StandardMagnitude(self.half_lit.0 - 2.5 * f.log10()))
    }
}

/// Light of a Lambertian sphere against the phase angle in [0, π], 1 at 90°.
pub(super) fn lambert_sphere(phase_angle_rad: f64) -> f64 {
    // F(φ) ∝ sin φ + (π - φ) cos φ
    phase_angle_rad.sin() + (PI - phase_angle_rad) * phase_angle_rad.cos()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn verif_sphere_at_full_and_half_phase() {
        let sphere = DiffuseSphere { half_lit: StandardMagnitude(6.0) };
        assert!((sphere.standard_magnitude(FRAC_PI_2).unwrap().0 - 6.0).abs() < 1e-12);
        // A Lambertian sphere is π times brighter at full than at half phase.
        assert!((sphere.standard_magnitude(0.0).unwrap().0 - (6.0 - 2.5 * PI.log10())).abs() < 1e-12);
        assert!(sphere.standard_magnitude(3.0).unwrap().0 > 10.0);
        assert_eq!(sphere.standard_magnitude(4.0), None);
    }
}
