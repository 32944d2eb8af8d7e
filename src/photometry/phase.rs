//! Phase functions: the magnitude at 1000 km as a polynomial of the angle Sun-satellite-observer.
//!
//! m(1000 km) = a0 + a1 φ + a2 φ² + …, φ in degrees. Such fits turn absurd outside the phases they were made on
//! (that of V1.5 gives 3.9 mag at 0° and 3.1 at 180°), so φ is clamped to the fitted range and the answer marked as
//! outside it.

use std::sync::Arc;

use super::magnitude::StandardMagnitude;

/// A polynomial in the phase angle, held constant outside its range.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFunction {
    coefficients: Arc<[f64]>,
    min_phase_deg: f64,
    max_phase_deg: f64,
}

impl PhaseFunction {
    /// From coefficients of φ⁰, φ¹, … (φ in degrees) and the fitted range of φ, degrees.
    ///
    /// `None` without a coefficient, with a value that is not finite, or unless 0 ≤ min < max ≤ 180.
    pub fn new(coefficients: &[f64], min_phase_deg: f64, max_phase_deg: f64) -> Option<Self> {
        let sound = !coefficients.is_empty()
            && coefficients.iter().all(|c| c.is_finite())
            && min_phase_deg >= 0.0
            && min_phase_deg < max_phase_deg
            && max_phase_deg <= 180.0;
        sound.then(|| Self { coefficients: coefficients.into(), min_phase_deg, max_phase_deg })
    }

    /// Magnitude at 1000 km, the phase clamped to the fitted range.
    pub fn standard_magnitude(&self, phase_angle_rad: f64) -> StandardMagnitude {
        let phase_deg = phase_angle_rad.to_degrees().clamp(self.min_phase_deg, self.max_phase_deg);
        StandardMagnitude(self.coefficients.iter().rev().fold(0.0, |sum, c| sum * phase_deg + c))
    }

    /// True where the phase lies in the fitted range.
    pub fn covers(&self, phase_angle_rad: f64) -> bool {
        (self.min_phase_deg..=self.max_phase_deg).contains(&phase_angle_rad.to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn valid_v15_polynomial_inside_and_clamped_outside() {
        let f = PhaseFunction::new(&[3.944, 0.06893, -0.0004089], 30.0, 150.0).unwrap();
        let at = |degrees: f64| f.standard_magnitude(degrees.to_radians()).0;
        assert!((at(90.0) - (3.944 + 0.06893 * 90.0 - 0.0004089 * 8100.0)).abs() < 1e-12);
        assert!((at(0.0) - at(30.0)).abs() < 1e-12 && (at(180.0) - at(150.0)).abs() < 1e-12);
        assert!(f.covers(1.0) && !f.covers(0.3) && !f.covers(2.8));
    }

    #[test]
    fn verif_unsound_functions_are_refused() {
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
}
