//! Correction of a predicted magnitude by measurements of the same pass.
//!
//! Attitude, flares and errors of a model change slowly along a pass, so that residuals of one pass are correlated:
//!
//! ```text
//! c(D) = 0.9 exp(-D / 12°),    D² = (angle between the directions to the observer)² + (change of the Sun's latitude)²
//! ```
//!
//! with both angles in the body frame. After one measurement with the residual r the magnitude changes by c r, and
//! sigma is multiplied by √(1 - c²). Several measurements are combined as those of a Gaussian process.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::brightness::Brightness;
use super::magnitude::Magnitude;
use crate::geometry::ViewingGeometry;

/// Correlation of two residuals of one pass in the same geometry.
const SAME_GEOMETRY: f64 = 0.9;
/// Distance at which the correlation is 1/e of that, radians (`tests/fitting/pass_update.rs`).
const SCALE_RAD: f64 = 12.0 * std::f64::consts::PI / 180.0;

/// Returns the correlation of the residuals of two magnitudes of one pass, 0 to 0.9.
pub fn pass_correlation(first: &ViewingGeometry, other: &ViewingGeometry) -> f64 {
    let observer = first.to_observer().separation_rad(&other.to_observer());
    let distance = observer.hypot(first.sun_latitude_rad - other.sun_latitude_rad);
    SAME_GEOMETRY * (-distance / SCALE_RAD).exp()
}

/// Measured magnitude of a satellite, compared with its prediction.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PassResidual {
    /// Viewing geometry.
    pub geometry: ViewingGeometry,
    /// Observed less predicted magnitude, mag.
    pub residual_mag: f64,
    /// Predicted scatter about the model, mag; positive.
    pub scatter_mag: f64,
    /// Error (one sigma) of the measurement, and of the prediction apart from the scatter, mag.
    pub error_mag: f64,
}

/// Correction by the measurements of one pass.
#[derive(Clone, Debug)]
pub struct PassUpdate {
    measured: Vec<PassResidual>,
    covariance: Cholesky<f64, Dyn>,
    /// Inverse covariance times the residuals.
    pull: DVector<f64>,
}

impl PassUpdate {
    /// Prepares the correction; `None` without measurements, or if a value is not finite or a scatter not positive.
    pub fn new(measured: Vec<PassResidual>) -> Option<Self> {
        let n = measured.len();
        // K_ij = s_i s_j c_ij, K_ii = s_i² + e_i²
        let covariance = DMatrix::from_fn(n, n, |i, j| {
            let (first, other) = (&measured[i], &measured[j]);
            match i == j {
                true => first.scatter_mag * first.scatter_mag + first.error_mag * first.error_mag,
                false => first.scatter_mag * other.scatter_mag * pass_correlation(&first.geometry, &other.geometry),
            }
        });
        let residuals = DVector::from_iterator(n, measured.iter().map(|residual| residual.residual_mag));
        let is_sound = n > 0 && residuals.iter().chain(covariance.iter()).all(|value| value.is_finite());
        let covariance = Cholesky::new(covariance).filter(|_| is_sound)?;
        let pull = covariance.solve(&residuals);
        Some(Self { measured, covariance, pull })
    }

    /// Returns the corrected brightness of the same pass in another geometry.
    pub fn apply(&self, geometry: &ViewingGeometry, light: Brightness) -> Brightness {
        // k_i = s s_i c_i;  m' = m + kᵀ K⁻¹ r,  s'² = s² - kᵀ K⁻¹ k             Rasmussen and Williams (2006), eq. 2.19
        let with = |residual: &PassResidual| {
            light.scatter_mag * residual.scatter_mag * pass_correlation(geometry, &residual.geometry)
        };
        let k = DVector::from_iterator(self.measured.len(), self.measured.iter().map(with));
        // The correlation is at most 0.9, so that some scatter always remains.
        let known = k.dot(&self.covariance.solve(&k));
        let remaining = |sigma: f64| (sigma * sigma - known).max(0.0).sqrt();
        Brightness {
            magnitude: Magnitude(light.magnitude.0 + k.dot(&self.pull)),
            scatter_mag: remaining(light.scatter_mag).max(f64::MIN_POSITIVE),
            sigma_mag: remaining(light.sigma_mag),
            ..light
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::brightness::MagnitudeSource;
    use super::super::error_distribution::ErrorDistribution;
    use super::*;

    fn geometry(observer_deg: f64) -> ViewingGeometry {
        ViewingGeometry::from_angles(-0.2, 0.0, observer_deg.to_radians(), 700.0, 550.0).unwrap()
    }

    fn light(sigma_mag: f64) -> Brightness {
        Brightness {
            magnitude: Magnitude(6.0),
            sigma_mag,
            scatter_mag: 0.4,
            error_distribution: ErrorDistribution::SATELLITES,
            source: MagnitudeSource::Prior,
            in_fitted_range: true,
            grey_reflectance: false,
        }
    }

    fn measured(observer_deg: f64, residual_mag: f64, error_mag: f64) -> PassResidual {
        PassResidual { geometry: geometry(observer_deg), residual_mag, scatter_mag: 0.4, error_mag }
    }

    #[test]
    fn verif_one_measurement_moves_by_the_correlation() {
        let update = PassUpdate::new(vec![measured(-50.0, 0.8, 0.0)]).unwrap();
        for apart_deg in [0.0_f64, 5.0, 12.0, 60.0] {
            let found = update.apply(&geometry(-50.0 + apart_deg), light(0.4));
            let c = 0.9 * (-apart_deg / 12.0).exp();
            assert!((found.magnitude.0 - 6.0 - c * 0.8).abs() < 1e-9, "{apart_deg}: {found:?}");
            assert!((found.scatter_mag - 0.4 * (1.0 - c * c).sqrt()).abs() < 1e-9, "{apart_deg}: {found:?}");
            assert!((found.sigma_mag - found.scatter_mag).abs() < 1e-9);
        }
        // Errors other than the scatter remain.
        let found = update.apply(&geometry(-50.0), light(0.5));
        assert!((found.sigma_mag - 0.3_f64.hypot(found.scatter_mag)).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn verif_uncertain_and_repeated_measurements() {
        let at = |measured: Vec<PassResidual>| PassUpdate::new(measured).unwrap().apply(&geometry(-50.0), light(0.4));
        let (exact, uncertain) = (at(vec![measured(-48.0, 0.8, 0.0)]), at(vec![measured(-48.0, 0.8, 2.0)]));
        assert!(uncertain.magnitude.0 < 6.1 && uncertain.sigma_mag > 0.39 && exact.magnitude.0 > 6.5);
        // Two exposures of a pass are not two independent events: the second adds little.
        let two = at(vec![measured(-48.0, 0.8, 0.0), measured(-48.1, 0.8, 0.0)]);
        assert!(two.sigma_mag < exact.sigma_mag && two.sigma_mag > 0.8 * exact.sigma_mag, "{two:?} {exact:?}");
        assert!(PassUpdate::new(Vec::new()).is_none());
        assert!(PassUpdate::new(vec![measured(-48.0, f64::NAN, 0.0)]).is_none());
    }
}
