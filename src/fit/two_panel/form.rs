//! Two-panel satellite to be fitted, and the bounds of its coefficients.

use crate::fit::form::{Form, Parameter, Prepared};
use crate::fit::point::FitPoint;
use crate::photometry::{Coefficients, Earthshine, SatelliteShape};

use super::prepared::PreparedPoints;

/// Order of the coefficients, as in model files.
const NAMES: [&str; 8] = ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base", "panel_offset_deg"];
/// Index of the panel offset.
pub(super) const OFFSET: usize = 7;
/// Bounds of the exponents: below, a lobe is a second diffuse law; above, it is narrower than the stability of
/// attitudes.
pub(super) const EXPONENTS: [f64; 2] = [0.5, 200.0];
/// Bounds of the panel offset, degrees.
const OFFSETS_DEG: [f64; 2] = [-30.0, 30.0];

/// Step of panel offsets for derivatives, degrees.
const OFFSET_STEP_DEG: f64 = 1e-4;

/// Chassis and sail of given sizes with eight parameters, of which any can be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct TwoPanelForm {
    /// Sizes, and the panel offset if it is not fitted.
    pub shape: SatelliteShape,
    /// Values of coefficients that are not fitted.
    pub coefficients: Coefficients,
    /// Earthshine on the chassis.
    pub earthshine: Earthshine,
    /// False ignores obstruction and shadow of the sail by the chassis, as in other published two-panel models.
    pub blocking: bool,
    /// Magnitude of the Sun, which sets the zero point.
    pub sun_magnitude: f64,
}

impl Form for TwoPanelForm {
    fn name(&self) -> String {
        "two_panel".to_owned()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let c = &self.coefficients;
        let values = [c.c1, c.c2, c.c3, c.c4, c.c5, c.n_sail, c.n_base, self.shape.panel_offset_deg];
        let bounds = |i: usize| match i {
            0..5 => [0.0, 1.0],
            OFFSET => OFFSETS_DEG,
            _ => EXPONENTS,
        };
        let parameter = |i: usize| {
            let parameter = Parameter::new(NAMES[i], values[i], bounds(i)[0], bounds(i)[1]);
            if i == OFFSET { Parameter { step: OFFSET_STEP_DEG, ..parameter } } else { parameter }
        };
        (0..NAMES.len()).map(parameter).collect()
    }

    fn prepare(&self, points: &[FitPoint]) -> Box<dyn Prepared> {
        Box::new(PreparedPoints::new(self, points))
    }
}
