//! Distribution of single magnitudes about their prediction, as a sum of normal distributions.
//!
//! Satellites flare, and some have another attitude than the model: magnitudes far from the prediction are more
//! frequent than those of a normal distribution, and more frequent on the bright side. The density of x = (observed -
//! predicted) / σ is
//!
//! ```text
//! Σ share · N(x; centre, width)
//! ```
//!
//! with the sigma σ of the prediction. The median of x is 0, and 68.3 % of x are within ±1. An independent normal error
//! e is added by convolution: each width becomes √(width² + e²).

use std::f64::consts::FRAC_1_SQRT_2;

/// Normal distribution that is part of an [`ErrorDistribution`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NormalPart {
    /// Share of the magnitudes, 0 to 1.
    pub share: f64,
    /// Centre, in units of sigma; positive is fainter.
    pub centre: f64,
    /// Standard deviation, in units of sigma, positive.
    pub width: f64,
}

const fn part(share: f64, centre: f64, width: f64) -> NormalPart {
    NormalPart { share, centre, width }
}

/// Distribution of observed less predicted magnitude, in units of sigma; positive is fainter.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ErrorDistribution {
    /// Parts, whose shares sum to 1; parts with a share of 0 are not used.
    pub parts: [NormalPart; 3],
}

impl ErrorDistribution {
    /// Distribution of the magnitudes of all kinds of satellites about their models: a core, a wing of brighter
    /// magnitudes, and flares.
    ///
    /// It is fitted to held-out residuals of five kinds with equal weights (`tests/fitting/error_distributions.rs`).
    pub const SATELLITES: Self =
        Self { parts: [part(0.721, 0.216, 0.714), part(0.25, -1.327, 1.545), part(0.029, -3.119, 4.113)] };

    /// Normal distribution with a standard deviation of one sigma.
    pub const NORMAL: Self = Self { parts: [part(1.0, 0.0, 1.0), part(0.0, 0.0, 1.0), part(0.0, 0.0, 1.0)] };

    /// Returns the probability of a value below `x` if an independent normal error of standard deviation `more` is
    /// added. `x` and `more` are in units of sigma.
    pub fn cumulative(&self, x: f64, more: f64) -> f64 {
        // Σ share · Φ((x - centre) / √(width² + e²))
        let below = |part: &NormalPart| {
            part.share * 0.5 * libm::erfc((part.centre - x) / part.width.hypot(more) * FRAC_1_SQRT_2)
        };
        self.parts.iter().filter(|part| part.share > 0.0).map(below).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_cumulative_of_the_parts() {
        let normal = ErrorDistribution::NORMAL;
        assert!((normal.cumulative(1.0, 0.0) - normal.cumulative(-1.0, 0.0) - 0.682_689_492).abs() < 1e-9);
        // An independent error of √3 sigma doubles the width.
        assert!((normal.cumulative(2.0, 3_f64.sqrt()) - normal.cumulative(1.0, 0.0)).abs() < 1e-12);
        let winged = ErrorDistribution { parts: [part(0.7, 0.1, 0.7), part(0.2, -1.0, 2.0), part(0.1, -3.0, 4.0)] };
        // Sum of the density over a fine grid.
        let density = |x: f64| -> f64 {
            let normal = |p: &NormalPart| {
                p.share * (-0.5 * ((x - p.centre) / p.width).powi(2)).exp() / (p.width * std::f64::consts::TAU.sqrt())
            };
            winged.parts.iter().map(normal).sum()
        };
        let step = 1e-3;
        let below = |x: f64| (0..40_000).map(|i| density(x - step * (f64::from(i) + 0.5)) * step).sum::<f64>();
        for x in [-3.0, -1.0, 0.0, 0.5, 4.0] {
            assert!((winged.cumulative(x, 0.0) - below(x)).abs() < 1e-6, "{x}");
        }
        assert_eq!(winged.cumulative(-1e3, 0.0), 0.0);
        assert!((winged.cumulative(1e3, 0.0) - 1.0).abs() < 1e-12);
    }

    /// The prediction is the median, and sigma the half width with 68.3 % about it.
    #[test]
    fn verif_median_and_sigma_of_satellites() {
        let of = |x: f64| ErrorDistribution::SATELLITES.cumulative(x, 0.0);
        assert!((of(0.0) - 0.5).abs() < 0.01, "{}", of(0.0));
        assert!((of(1.0) - of(-1.0) - 0.6827).abs() < 0.01, "{}", of(1.0) - of(-1.0));
        assert!((of(f64::INFINITY) - 1.0).abs() < 1e-12);
    }
}
