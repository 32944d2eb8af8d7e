//! Sky, field, policy, telescope and photometry for judging exposures.

use crate::images::Telescope;
use crate::passes::{Exposure, Field, Pass, Sky};
use crate::photometry::PhotometryOptions;

use super::limits::Limits;
use super::policy::{Blocking, Policy};
use super::tables::StreakRow;
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

impl<'a> FlagRequest<'a> {
    /// Returns the row of a pass in [`streak_table`](super::streak_table). `limit_mag` is the magnitude limit of
    /// the exposure, whose shutter is open for `open_s` if that is shorter.
    #[doc(hidden)]
    pub fn streak_row(
        &self,
        (exposure, open_s): (&'a Exposure, Option<f64>),
        pass: &'a Pass,
        band: Option<&str>,
        limit_mag: Option<f64>,
    ) -> StreakRow<'a> {
        StreakRow {
            exposure,
            pass,
            elements: &self.sky.elements()[pass.element_index],
            satellite_size_m: self.sky.model(pass.element_index).size_m(),
            telescope: self.telescope,
            photometry: self.photometry,
            limit_mag: self.limit_mag_of(pass, band, exposure.duration_s, limit_mag),
            cost: self.pass_cost((exposure, open_s), pass, band, limit_mag),
        }
    }

    /// Returns true if every lit crossing blocks a start, so that magnitudes and probabilities are not needed. In
    /// thermal bands satellites in the Earth's shadow count as lit.
    pub(super) fn every_crossing_blocks(&self, blocking: Blocking) -> bool {
        (blocking == Blocking::Any || !self.policy.has_limit())
            && self.policy.min_probability.is_none()
            && !self.policy.include_dark
            && !self.photometry.band.is_thermal()
    }

    /// Returns the limits for exposures of this length in a band.
    pub(super) fn limits(&self, band: Option<&str>, exposure_s: f64) -> Limits<'a> {
        Limits::new(self.policy, self.telescope, self.sky, band, exposure_s)
    }

    /// Returns true if a pass alone is sufficient for the verdict `avoid` on an exposure of this length: the
    /// probability that it crosses and is brighter at its peak than a limit is at least the `min_probability` of the
    /// policy (0.5 if omitted). `None` if no limit applies to the band.
    pub fn exceeds_limit(&self, pass: &Pass, band: Option<&str>, exposure_s: f64) -> Option<bool> {
        let limits = self.limits(band, exposure_s);
        (!limits.is_none()).then(|| blocks(pass, &limits, Blocking::Avoid, self.policy))
    }

    /// Returns the apparent magnitude than which the satellite of a pass is brighter than a limit: `limit_mag` or the
    /// limit of surface brightness of the policy. `None` without either.
    #[doc(hidden)]
    pub fn limit_mag_of(
        &self,
        pass: &Pass,
        band: Option<&str>,
        exposure_s: f64,
        limit_mag: Option<f64>,
    ) -> Option<f64> {
        let limits = self.limits(band, exposure_s).with_limit_mag(limit_mag);
        limits.of_pass(pass).map(|limit| limit.limit_mag)
    }
}
