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
