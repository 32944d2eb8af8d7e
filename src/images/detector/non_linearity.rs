//! Non-linearity of a detector: signals that are not proportional to the light.

use serde::Deserialize;

use crate::error::Error;

/// Polynomial non-linearity. The measured signal of e electrons is e (1 + c₀ s + c₁ s² + ...) with s = e / scale. Above
/// the scale, the signal follows the tangent at the scale; below 0 it is e.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NonLinearity {
    /// Charge at which s is 1, electrons, \[1, 1e9\]; usually the full well.
    pub scale_e: f64,
    /// Coefficients c₀, c₁, ..., at least one, each in \[-1, 1\]. The signal must increase with the light up to the
    /// scale.
    pub coefficients: Vec<f64>,
}

impl NonLinearity {
    pub(super) fn validate(&self) -> Result<(), Error> {
        Error::check_range("non_linearity.scale_e", self.scale_e, 1.0, 1e9)?;
        self.coefficients.iter().try_for_each(|c| Error::check_range("non_linearity.coefficients", *c, -1.0, 1.0))?;
        let invalid = |given: &str, allowed: &str| Err(Error::invalid("non_linearity.coefficients", given, allowed));
        if self.coefficients.is_empty() {
            return invalid("empty", "at least one number");
        }
        // The inverse is not computed reliably for slopes below 0.01, so they are rejected.
        if (0..=1000).any(|step| self.value_and_slope(f64::from(step) / 1000.0).1 < 0.01) {
            let given = format!("{:?}", self.coefficients);
            return invalid(&given, "numbers with which the signal grows with the light up to scale_e");
        }
        Ok(())
    }

    /// Returns the signal and its slope at s = e / scale from 0 to 1, in units of the scale.
    fn value_and_slope(&self, s: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0, 0.0);
        for coefficient in self.coefficients.iter().rev() {
            slope = slope * s + value;
            value = value * s + coefficient;
        }
        // value = p(s), slope = p'(s); f = s (1 + s p), f' = 1 + 2 s p + s² p'
        (s * (1.0 + s * value), 1.0 + 2.0 * s * value + s * s * slope)
    }

    /// Returns the signal, in electrons, that is measured for a charge of `e` electrons.
    pub(super) fn measured(&self, e: f64) -> f64 {
        let s = e / self.scale_e;
        if s <= 0.0 {
            return e;
        }
        let (value, slope) = self.value_and_slope(s.min(1.0));
        self.scale_e * (value + slope * (s - 1.0).max(0.0))
    }

    /// Returns the charge, in electrons, for a measured signal; the inverse of [`measured`](Self::measured).
    pub(super) fn true_e(&self, measured_e: f64) -> f64 {
        let target = measured_e / self.scale_e;
        let (end, end_slope) = self.value_and_slope(1.0);
        if target <= 0.0 {
            return measured_e;
        }
        if target >= end {
            return self.scale_e * (1.0 + (target - end) / end_slope);
        }
        // Newton's method, kept within bounds that shrink at each step.
        let (mut bounds, mut s) = ([0.0, 1.0], target.min(1.0));
        for _ in 0..50 {
            let (value, slope) = self.value_and_slope(s);
            bounds[usize::from(value > target)] = s;
            let next = s - (value - target) / slope;
            let next = if next > bounds[0] && next < bounds[1] { next } else { 0.5 * (bounds[0] + bounds[1]) };
            if (next - s).abs() < 1e-14 {
                break;
            }
            s = next;
        }
        self.scale_e * s
    }
}
