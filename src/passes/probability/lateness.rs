//! Distribution of the delay of a satellite against its prediction.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Delays up to this many sigmas are searched.
const REACH_SIGMAS: f64 = 3.5;

/// Distribution of the delay δ along the track, seconds; positive where the satellite is late. A Gaussian about 0.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(in crate::passes) struct Lateness {
    sigma_s: f64,
}

impl Lateness {
    /// Largest delay that is searched, seconds.
    pub const LONGEST_S: f64 = 300.0;

    /// With this sigma; a sigma of 0 is a certain δ = 0.
    pub fn gaussian(sigma_s: f64) -> Self {
        Self { sigma_s }
    }

    /// Largest delay, of either sign, that is searched, seconds.
    pub fn reach_s(&self) -> f64 {
        (REACH_SIGMAS * self.sigma_s).min(Self::LONGEST_S)
    }

    /// True where longer delays are probable than those that are searched: probabilities are then lower limits.
    pub fn is_cut(&self) -> bool {
        REACH_SIGMAS * self.sigma_s > Self::LONGEST_S
    }

    /// P(δ ≤ x); the border counts as inside where the delay is certain.
    pub fn cumulative(&self, x_s: f64) -> f64 {
        if self.sigma_s > 0.0 {
            // Φ(x/σ)
            0.5 * libm::erfc(-x_s / self.sigma_s * FRAC_1_SQRT_2)
        } else {
            f64::from(u8::from(x_s >= 0.0))
        }
    }

    /// P(low < δ ≤ high).
    pub fn share(&self, low_s: f64, high_s: f64) -> f64 {
        self.cumulative(high_s) - self.cumulative(low_s)
    }

    /// Expected value of max(x - δ, 0), the integral of [`Lateness::cumulative`] up to x, seconds.
    pub fn cumulative_integral_s(&self, x_s: f64) -> f64 {
        if self.sigma_s > 0.0 {
            // ∫ Φ(x/σ) dx = x Φ(x/σ) + σ φ(x/σ)
            let z = x_s / self.sigma_s;
            x_s * self.cumulative(x_s) + self.sigma_s * (-0.5 * z * z).exp() / TAU.sqrt()
        } else {
            x_s.max(0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_shares_and_integrals_of_the_distribution() {
        let lateness = Lateness::gaussian(20.0);
        // Φ(1) - Φ(-1)
        assert!((lateness.share(-20.0, 20.0) - 0.682_689_492_137).abs() < 1e-12);
        // The mean of |δ| = 2 E max(-δ, 0) is σ √(2/π).
        assert!((2.0 * lateness.cumulative_integral_s(0.0) - 20.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-12);
        assert_eq!((lateness.reach_s(), lateness.is_cut()), (70.0, false));
        let old = Lateness::gaussian(100.0);
        assert_eq!((old.reach_s(), old.is_cut()), (300.0, true));
        let certain = Lateness::gaussian(0.0);
        assert_eq!(
            (certain.share(-1.0, 0.0), certain.share(0.1, 5.0), certain.cumulative_integral_s(-1.0)),
            (1.0, 0.0, 0.0)
        );
    }
}
