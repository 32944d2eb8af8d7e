//! Any of the laws, chosen by data.

use super::law::Brdf;
use super::{Abg, Binomial, Gaussian, Lambert, Phong};
use crate::photometry::panel::Incidence;

/// One of the known laws.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// Every direction sees the same radiance.
    Lambert(Lambert),
    /// A lobe that is a power of a cosine.
    Phong(Phong),
    /// A lobe with a shoulder and a power-law wing.
    Abg(Abg),
    /// A bell-shaped lobe.
    Gaussian(Gaussian),
    /// A logarithm expanded in reciprocal quantities.
    Binomial(Binomial),
}

impl Law {
    /// Exponent of the Phong lobe that is as narrow as this law's: how finely light from a wide source must be sampled.
    pub fn equivalent_exponent(&self) -> f64 {
        /// Binomials may hold lobes of any width; the narrowest that the rule for the Earth is tested for.
        const SHARP: f64 = 200.0;
        // cosⁿθ falls to half at θ² ≈ 2 ln 2 / n
        let of_half_width = |theta: f64| 2.0 * std::f64::consts::LN_2 / theta.powi(2);
        let exponent = match self {
            Self::Lambert(_) => 1.0,
            Self::Phong(law) => law.exponent,
            // e^((cos θ - 1)/w) ≈ e^(-θ²/2w)
            Self::Gaussian(law) => 1.0 / law.width,
            // Half at x^g = B.
            Self::Abg(law) => of_half_width(law.b.powf(1.0 / law.g.max(0.1))),
            Self::Binomial(_) => SHARP,
        };
        exponent.clamp(1.0, SHARP)
    }
}

impl Brdf for Law {
    fn value_per_sr(&self, incidence: &Incidence) -> f64 {
        match self {
            Self::Lambert(law) => law.value_per_sr(incidence),
            Self::Phong(law) => law.value_per_sr(incidence),
            Self::Abg(law) => law.value_per_sr(incidence),
            Self::Gaussian(law) => law.value_per_sr(incidence),
            Self::Binomial(law) => law.value_per_sr(incidence),
        }
    }
}
