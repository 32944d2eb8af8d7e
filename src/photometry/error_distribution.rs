//! Distribution of single magnitudes about a brightness model: a normal core and a wing to one side of it.
//!
//! Satellites flare, and some have another attitude than the model: magnitudes far from the prediction are more
//! frequent than those of a normal distribution, and more frequent on one side. The density of x = (observed -
//! predicted) / σ is
//!
//! ```text
//! (1 - w) N(x; a, c) + w N(x; b, d)
//! ```
//!
//! with the `sigma_mag` σ of the model, the core (a, c) and the share w, shift b and width d of the wing.

use std::f64::consts::FRAC_1_SQRT_2;

use serde::{Deserialize, Serialize};

use super::error::{Check, PhotometryError};

/// Distribution of observed less predicted magnitude, in units of the model's `sigma_mag`; positive is fainter.
#[derive(Copy, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorDistribution {
    /// Centre of the core.
    pub core_shift: f64,
    /// Standard deviation of the core, positive.
    pub core_sigma: f64,
    /// Fraction of the magnitudes in the wing, 0 to 0.5.
    pub wing_share: f64,
    /// Centre of the wing.
    pub wing_shift: f64,
    /// Standard deviation of the wing, positive.
    pub wing_sigma: f64,
}

impl Default for ErrorDistribution {
    /// Returns the distribution of models without photometry of their own: that of the held-out residuals of the other
    /// models, each in units of its sigma and with the same weight (`tests/fitting/error_distributions.rs` fits it).
    fn default() -> Self {
        Self { core_shift: 0.263, core_sigma: 0.652, wing_share: 0.285, wing_shift: -0.808, wing_sigma: 1.703 }
    }
}

impl ErrorDistribution {
    /// Normal distribution with a standard deviation of one sigma.
    pub const NORMAL: Self =
        Self { core_shift: 0.0, core_sigma: 1.0, wing_share: 0.0, wing_shift: 0.0, wing_sigma: 1.0 };

    /// Returns the probability of a value below `x` if an independent normal error of standard deviation `more` is
    /// added. `x` and `more` are in units of sigma.
    pub fn cumulative(&self, x: f64, more: f64) -> f64 {
        // Φ((x - a) / √(c² + e²))
        let part = |shift: f64, sigma: f64| 0.5 * libm::erfc((shift - x) / sigma.hypot(more) * FRAC_1_SQRT_2);
        let core = part(self.core_shift, self.core_sigma);
        if self.wing_share == 0.0 {
            return core;
        }
        core + self.wing_share * (part(self.wing_shift, self.wing_sigma) - core)
    }

    /// Checks the ranges of all values.
    pub(super) fn validate(&self, check: &Check) -> Result<(), PhotometryError> {
        for (key, value, least, greatest) in [
            ("core_shift", self.core_shift, -2.0, 2.0),
            ("core_sigma", self.core_sigma, 0.05, 5.0),
            ("wing_share", self.wing_share, 0.0, 0.5),
            ("wing_shift", self.wing_shift, -10.0, 10.0),
            ("wing_sigma", self.wing_sigma, 0.05, 20.0),
        ] {
            check.range(&format!("error_distribution.{key}"), value, least, greatest)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_cumulative_of_core_and_wing() {
        let normal = ErrorDistribution::NORMAL;
        assert!((normal.cumulative(1.0, 0.0) - normal.cumulative(-1.0, 0.0) - 0.682_689_492).abs() < 1e-9);
        // An independent error of √3 sigma doubles the width.
        assert!((normal.cumulative(2.0, 3_f64.sqrt()) - normal.cumulative(1.0, 0.0)).abs() < 1e-12);
        let winged =
            ErrorDistribution { core_shift: 0.1, core_sigma: 0.7, wing_share: 0.2, wing_shift: -1.0, wing_sigma: 2.0 };
        // Sum of the density over a fine grid.
        let density = |x: f64| {
            let normal = |x: f64, shift: f64, sigma: f64| {
                (-0.5 * ((x - shift) / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
            };
            0.8 * normal(x, 0.1, 0.7) + 0.2 * normal(x, -1.0, 2.0)
        };
        let step = 1e-3;
        let below = |x: f64| (0..20_000).map(|i| density(x - step * (f64::from(i) + 0.5)) * step).sum::<f64>();
        for x in [-3.0, -1.0, 0.0, 0.5, 4.0] {
            assert!((winged.cumulative(x, 0.0) - below(x)).abs() < 1e-6, "{x}");
        }
        assert_eq!((winged.cumulative(-1e3, 0.0), winged.cumulative(1e3, 0.0)), (0.0, 1.0));
    }
}
