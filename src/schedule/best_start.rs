//! Start of an exposure at which the cost of streaks plus the wait is smallest.

use crate::error::Error;
use crate::frames::seconds_after;
use crate::passes::Exposure;

use super::flag_request::FlagRequest;
use super::report::{TICK_S, judge_exposures};
use super::scheduled::ScheduledExposure;
use super::verdict::Verdict;

/// Number of later starts whose costs are compared.
pub const COMPARED_STARTS: u32 = 60;

/// Start of an exposure with its cost.
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct BestStart {
    /// Delay after the scheduled start, seconds.
    pub delay_s: f64,
    /// Expected cost of the streaks of the delayed exposure, seconds of open shutter.
    pub streak_cost_s: f64,
    /// Expected cost of the streaks of the exposure as scheduled, seconds of open shutter.
    pub scheduled_cost_s: f64,
}

/// Returns the start at which cost plus delay is smallest, among the scheduled start and 60 later ones at equal
/// intervals, and the verdict at the scheduled start. The start is `None` without a telescope, and if the exposure
/// cannot be judged.
///
/// A delay that is longer than the cost at the scheduled start saves nothing, so that the starts extend over this cost,
/// and at most over `longest_s`; a cost below 0.06 s is not reduced. If the cost at the scheduled start exceeds the
/// `max_cost_s` of the policy, they extend over `longest_s`, and a start that does not exceed it is better than all that
/// do. The `margin_s` and `blocking` of the policy are not applied.
///
/// # Errors
/// Passes cannot be computed.
pub fn best_start(
    row: &ScheduledExposure,
    longest_s: f64,
    request: &FlagRequest<'_>,
) -> Result<(Option<BestStart>, Option<Verdict>), Error> {
    let verdict = judge_exposures(&[row], request)?.flags.pop();
    let cost_s = verdict.as_ref().and_then(|verdict| verdict.streak_cost_s);
    let (Some(scheduled_cost_s), Ok(exposure)) = (cost_s, &row.exposure) else { return Ok((None, verdict)) };
    let exceeds = |cost_s: f64| request.policy.max_cost_s.is_some_and(|most_s| cost_s > most_s);
    let span_s = if exceeds(scheduled_cost_s) { longest_s } else { scheduled_cost_s.min(longest_s) };
    let step_s = span_s / f64::from(COMPARED_STARTS);
    let mut best = BestStart { delay_s: 0.0, streak_cost_s: scheduled_cost_s, scheduled_cost_s };
    if step_s >= TICK_S {
        let delays_s: Vec<f64> = (1..=COMPARED_STARTS).map(|number| step_s * f64::from(number)).collect();
        let delayed = |delay_s: &f64| ScheduledExposure {
            exposure: Ok(Exposure { start: seconds_after(exposure.start, *delay_s), ..exposure.clone() }),
            ..row.clone()
        };
        let rows: Vec<ScheduledExposure> = delays_s.iter().map(delayed).collect();
        let flags = judge_exposures(&rows.iter().collect::<Vec<_>>(), request)?.flags;
        for (delay_s, flag) in delays_s.into_iter().zip(flags) {
            let Some(streak_cost_s) = flag.streak_cost_s else { continue };
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
    Ok((Some(best), verdict))
}
