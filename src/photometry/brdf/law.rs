//! What every law of reflection answers, and the conventions all of them share.

use crate::photometry::panel::Incidence;

/// A bidirectional reflectance distribution function.
///
/// Conventions, once for all laws: the value is in sr⁻¹ and does *not* contain the cosines of projection (a panel
/// multiplies them and its area); light comes from and leaves to the same side of the surface; all the direction a
/// law may depend on is in [`Incidence`]. A law answers for any incidence, lit or not: darkness is the panel's
/// business.
pub trait Brdf {
    /// Reflectance for this incidence, sr⁻¹, at least 0.
    fn value_per_sr(&self, incidence: &Incidence) -> f64;
}
