//! Start of an exposure at which the cost of streaks plus the wait is smallest.

use crate::error::Error;
use crate::frames::seconds_after;
use crate::passes::Exposure;

use super::flag_request::FlagRequest;
use super::report::{TICK_S, judge_exposures};
use super::scheduled::ScheduledExposure;
use super::verdict::Verdict;

/// Largest number of parts of the margin that are judged for one start.
const MOST_PARTS: f64 = 10.0;
/// Number of later starts whose costs are compared.
pub const COMPARED_STARTS: u32 = 60;

/// Start of an exposure with its cost.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BestStart {
    /// Delay after the scheduled start, seconds.
    pub delay_s: f64,
    /// Expected cost of the streaks of the delayed exposure, seconds of open shutter: an upper limit for all openings
    /// of the shutter from the start to the `margin_s` of the policy later.
    pub streak_cost_s: f64,
    /// The same for the exposure as scheduled.
    pub scheduled_cost_s: f64,
}

/// Returns an upper limit of the cost of the streaks of an exposure for each delay, in seconds of open shutter, because
/// the shutter opens at an unknown time up to the `margin_s` of the policy later. `None` without a telescope, and if an
/// exposure cannot be judged.
///
/// For openings within a part of the margin, the streaks are those of an exposure from the first opening to the last
/// closing of the shutter. A part is at most as long as the exposure (for short exposures: a tenth of the margin); the
/// largest cost of all parts is returned.
///
/// # Errors
/// Passes cannot be computed.
pub fn delayed_costs_s(
    row: &ScheduledExposure,
    delays_s: &[f64],
    request: &FlagRequest<'_>,
) -> Result<Vec<Option<f64>>, Error> {
    let Ok(exposure) = &row.exposure else { return Ok(vec![None; delays_s.len()]) };
    let margin_s = request.policy.margin_or_default_s();
    // Not a number without margin and duration.
    let parts = ((margin_s / exposure.duration_s).ceil().clamp(1.0, MOST_PARTS) as u32).max(1);
    let part_s = margin_s / f64::from(parts);
    let duration_s = exposure.duration_s + part_s;
    let extended = |delay_s: f64| {
        let start = seconds_after(exposure.start, delay_s);
        ScheduledExposure {
            open_s: Some(row.open_s.unwrap_or(exposure.duration_s)),
            exposure: Ok(Exposure { start, duration_s, ..exposure.clone() }),
            ..row.clone()
        }
    };
    let begins_s = |delay_s: &f64| {
        let delay_s = *delay_s;
        (0..parts).map(move |number| delay_s + part_s * f64::from(number))
    };
    let rows: Vec<_> = delays_s.iter().flat_map(begins_s).map(extended).collect();
    let flags = judge_exposures(&rows.iter().collect::<Vec<_>>(), request)?.flags;
    let largest =
        |parts: &[Verdict]| parts.iter().try_fold(0.0, |largest: f64, part| Some(largest.max(part.streak_cost_s?)));
    Ok(flags.chunks_exact(parts as usize).map(largest).collect())
}

/// Returns the start at which cost plus delay is smallest, among the scheduled start and 60 later ones at equal
/// intervals. `None` without a telescope, and if the exposure cannot be judged.
///
/// The shutter opens up to `margin_s` of the policy after a start, whose cost is an upper limit for these openings.
///
/// A delay that is longer than the cost at the scheduled start saves nothing, so that the starts extend over this cost,
/// and at most over `longest_s`; a cost below 0.06 s is not reduced. If the cost at the scheduled start exceeds the
/// `max_cost_s` of the policy, they extend over `longest_s`, and a start that does not exceed it is better than all
/// that do. The `blocking` of the policy is not applied.
///
/// # Errors
/// Passes cannot be computed.
pub fn best_start(
    row: &ScheduledExposure,
    longest_s: f64,
    request: &FlagRequest<'_>,
) -> Result<Option<BestStart>, Error> {
    let Some(scheduled_cost_s) = delayed_costs_s(row, &[0.0], request)?[0] else { return Ok(None) };
    let exceeds = |cost_s: f64| request.policy.max_cost_s.is_some_and(|most_s| cost_s > most_s);
    let span_s = if exceeds(scheduled_cost_s) { longest_s } else { scheduled_cost_s.min(longest_s) };
    let step_s = span_s / f64::from(COMPARED_STARTS);
    let mut best = BestStart { delay_s: 0.0, streak_cost_s: scheduled_cost_s, scheduled_cost_s };
    if step_s >= TICK_S {
        let delays_s: Vec<f64> = (1..=COMPARED_STARTS).map(|number| step_s * f64::from(number)).collect();
        for (&delay_s, streak_cost_s) in delays_s.iter().zip(delayed_costs_s(row, &delays_s, request)?) {
            let Some(streak_cost_s) = streak_cost_s else { continue };
            let is_better = match (exceeds(streak_cost_s), exceeds(best.streak_cost_s)) {
                (false, true) => true,
                (true, false) => false,
                _ => streak_cost_s + delay_s < best.streak_cost_s + best.delay_s,
            };
            if is_better {
                best = BestStart { delay_s, streak_cost_s, scheduled_cost_s };
            }
        }
    }
    Ok(Some(best))
}
