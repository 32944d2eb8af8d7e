//! Whether the starts of exposures can be computed from nominal tracks, given the lateness of the satellites.

use hifitime::Epoch;

use crate::passes::{Field, Sky};

use super::policy::Policy;

/// Allowance for early and late satellites if the policy has a `min_probability`, in sigmas along the track. A
/// satellite is late by more than this with a probability of 0.00135.
pub(super) const LATE_SIGMAS: f64 = 3.0;
/// Largest such allowance, seconds. At least half of the delays of a satellite of known position are at most 300 s
/// (`Lateness::LONGEST_S`), and three sigmas of a Gaussian are then at most 1,334 s.
pub(super) const LONGEST_ALLOWANCE_S: f64 = 1800.0;
/// Typical angular rate of a satellite in low orbit, deg/s.
const TYPICAL_RATE_DEG_S: f64 = 0.5;

/// Returns the reason why the starts of an exposure without a crossing are unknown at a time; `None` if they are known.
/// A `min_probability` of the policy extends its margin by three sigmas.
pub fn reason_for_unknown_starts(
    sky: &Sky,
    field: &Field,
    policy: &Policy,
    epoch: Epoch,
    duration_s: f64,
) -> Option<String> {
    let known = sky.predictability(epoch, Some(field));
    let allowance_s = policy.min_probability.and(known.late_s).unwrap_or(0.0) * LATE_SIGMAS;
    // The mean chord of a circle is π/2 times its radius.
    let crossing_s = std::f64::consts::FRAC_PI_2 * field.bounding_radius_rad().to_degrees() / TYPICAL_RATE_DEG_S;
    known.reason_for_starts(duration_s, crossing_s, policy.margin_or_default_s() + allowance_s)
}
