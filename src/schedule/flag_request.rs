//! Sky, field, policy, telescope and photometry for judging exposures.

use crate::images::Telescope;
use crate::passes::{Field, Pass, Sky};
use crate::photometry::PhotometryOptions;

use super::policy::{Blocking, Policy};
use super::verdict_rules::blocks;

/// Sky, field, policy, telescope and photometry for judging exposures.
#[derive(Copy, Clone)]
pub struct FlagRequest<'a> {
    /// Satellites and observer.
    pub sky: &'a Sky,
    /// Field of view.
    pub field: &'a Field,
    /// The policy.
    pub policy: &'a Policy,
    /// The telescope; needed for pixel losses and the cost of streaks.
    pub telescope: Option<&'a Telescope>,
    /// Band, magnitude system and extinction of predicted magnitudes.
    pub photometry: &'a PhotometryOptions,
}

impl FlagRequest<'_> {
    /// Returns true if a pass alone is sufficient for the verdict `avoid`: the probability that it crosses and is
    /// brighter at its peak than a limit is at least the `min_probability` of the policy (0.5 if omitted). `None` if no
    /// limit applies to the band.
    pub fn exceeds_limit(&self, pass: &Pass, band: Option<&str>) -> Option<bool> {
        self.policy.limit_mag_in(band).map(|_| blocks(pass, band, Blocking::Avoid, self.policy))
    }
}
