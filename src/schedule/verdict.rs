//! Verdict on one exposure, with the numbers that it is based on. The module `verdict_rules` computes it.

use std::fmt;

use hifitime::Epoch;

use crate::elements::NoradId;
use crate::output::format_utc;
use crate::passes::Pass;

use super::policy::Blocking;

/// Kind of a verdict on an exposure.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum VerdictKind {
    /// No lit satellite crosses the exposure.
    Clear,
    /// A lit satellite crosses or may cross the exposure or crosses its margins, and no limit of the policy is
    /// exceeded.
    Streaked,
    /// A limit of the policy is exceeded: magnitude, with at least the probability of the policy, or cost of
    /// streaks.
    Avoid,
    /// The positions of the satellites are unknown, because their elements are too old, and no satellite of
    /// known position exceeds a limit of the policy.
    Unknown,
    /// The exposure is invalid: it has no valid time, pointing or length, or its pointing is below the horizon.
    Invalid,
}

impl VerdictKind {
    /// Returns the kind as a word: `clear`, `streaked`, `avoid`, `unknown` or `invalid`.
    pub fn name(self) -> &'static str {
        match self {
            VerdictKind::Clear => "clear",
            VerdictKind::Streaked => "streaked",
            VerdictKind::Avoid => "avoid",
            VerdictKind::Unknown => "unknown",
            VerdictKind::Invalid => "invalid",
        }
    }
}

impl fmt::Display for VerdictKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// Verdict on one exposure, with its reasons and the passes that count.
///
/// `Display` writes one line: the kind, the reasons, and the next clear start.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Identifier of the exposure in the schedule.
    pub exposure_id: String,
    /// Kind of the verdict.
    pub kind: VerdictKind,
    /// Number of lit satellites whose nominal tracks cross the field.
    pub n_streaks: usize,
    /// Peak magnitude of the brightest pass that counts; `None` without such passes or without magnitudes.
    pub brightest_mag: Option<f64>,
    /// Expected fraction of pixels lost: the sum over all streaks, each weighted with its probability. `None` without a
    /// telescope.
    pub expected_lost_pixel_fraction: Option<f64>,
    /// Expected cost of all streaks, seconds of open shutter, [0, duration · max(1, bright share)]; see
    /// [`StreakCost`](crate::images::StreakCost). `None` without a telescope, and if the exposure cannot be judged.
    pub streak_cost_s: Option<f64>,
    /// Probability that at least one lit satellite crosses and is brighter than a limit of the policy: 1 - Π(1 - p),
    /// with independent errors. Equal to `p_crossing` if no limit applies.
    pub p_any: f64,
    /// Probability that at least one lit satellite crosses, of any brightness.
    pub p_crossing: f64,
    /// True if `p_any`, `p_crossing`, the expected loss and the cost are lower limits: for at least one satellite,
    /// more than 10 %
    /// of the possible delays are outside the range searched, or more than 10 % of the satellites are of unknown
    /// position.
    pub p_any_is_lower_limit: bool,
    /// Total length of all nominal lit streaks in the field, degrees.
    pub streak_length_deg: f64,
    /// Reasons for the verdict.
    pub reasons: Vec<String>,
    /// Earliest start, not before the scheduled one, at which the verdict is `clear`; `None` if there is none within
    /// the longest delay.
    pub next_clear_start: Option<Epoch>,
    /// Delay of `next_clear_start` after the scheduled start, seconds.
    pub delay_s: Option<f64>,
    /// Earliest start, not before the scheduled one, at which no limit of the policy is exceeded. Equal to
    /// `next_clear_start` if no limit applies to the exposure.
    pub next_acceptable_start: Option<Epoch>,
    /// Delay of `next_acceptable_start` after the scheduled start, seconds.
    pub acceptable_delay_s: Option<f64>,
    /// NORAD catalogue numbers of `passes`.
    pub norad_ids: Vec<NoradId>,
    /// Lit crossings in order of entry, and probable near misses if the policy has a `min_probability`.
    pub passes: Vec<Pass>,
    /// Age of the elements of the satellites that decide the verdict, days, negative if their epochs are later: the
    /// median over `passes`, or, if there are none, over the satellites that may cross, or, if there are none, over the
    /// catalogue. `None` if the exposure is invalid.
    pub elements_age_days: Option<f64>,
    /// Lateness of these satellites, seconds: the median of the half widths that contain 68 % of the delays. `None` if
    /// it is unknown.
    pub late_s: Option<f64>,
}

impl Verdict {
    /// Returns the earliest start that no satellite selected by `blocking` blocks, with its delay in seconds.
    pub fn next_start(&self, blocking: Blocking) -> Option<(Epoch, f64)> {
        match blocking {
            Blocking::Any => self.next_clear_start.zip(self.delay_s),
            Blocking::Avoid => self.next_acceptable_start.zip(self.acceptable_delay_s),
        }
    }

    /// Sets the earliest start that no satellite selected by `blocking` blocks, with its delay in seconds.
    pub(super) fn set_next_start(&mut self, blocking: Blocking, start: Option<(Epoch, f64)>) {
        let (epoch, delay_s) = match blocking {
            Blocking::Any => (&mut self.next_clear_start, &mut self.delay_s),
            Blocking::Avoid => (&mut self.next_acceptable_start, &mut self.acceptable_delay_s),
        };
        (*epoch, *delay_s) = start.unzip();
    }

    /// Returns the verdict for a row that cannot be judged.
    pub fn invalid(exposure_id: &str, reason: String) -> Self {
        Self {
            exposure_id: exposure_id.to_owned(),
            kind: VerdictKind::Invalid,
            n_streaks: 0,
            brightest_mag: None,
            expected_lost_pixel_fraction: None,
            streak_cost_s: None,
            p_any: f64::NAN,
            p_crossing: f64::NAN,
            p_any_is_lower_limit: false,
            streak_length_deg: f64::NAN,
            reasons: vec![reason],
            next_clear_start: None,
            delay_s: None,
            next_acceptable_start: None,
            acceptable_delay_s: None,
            norad_ids: Vec::new(),
            passes: Vec::new(),
            elements_age_days: None,
            late_s: None,
        }
    }

    /// Returns the verdict with its probabilities, losses and starts unknown, and the kind `unknown` unless a satellite
    /// of known position exceeds a limit.
    pub(super) fn without_known_positions(self, reason: String) -> Self {
        let (kind, reasons) = match self.kind {
            VerdictKind::Avoid => (VerdictKind::Avoid, [self.reasons, vec![reason]].concat()),
            _ => (VerdictKind::Unknown, vec![reason]),
        };
        Self {
            kind,
            reasons,
            expected_lost_pixel_fraction: None,
            streak_cost_s: None,
            p_any: f64::NAN,
            p_crossing: f64::NAN,
            p_any_is_lower_limit: false,
            streak_length_deg: if kind == VerdictKind::Unknown { f64::NAN } else { self.streak_length_deg },
            next_clear_start: None,
            delay_s: None,
            next_acceptable_start: None,
            acceptable_delay_s: None,
            ..self
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.kind)?;
        if !self.reasons.is_empty() {
            write!(formatter, ": {}", self.reasons.join("; "))?;
        }
        let clear = self.next_start(Blocking::Any);
        let acceptable = self.next_start(Blocking::Avoid).filter(|start| Some(*start) != clear);
        for (state, start) in [("within the limits", acceptable), ("clear", clear)] {
            if let Some((start, delay_s)) = start.filter(|(_, delay_s)| *delay_s > 0.0) {
                write!(formatter, "; {state} when started {delay_s:.1} s later, at {}", format_utc(start, 3))?;
            }
        }
        Ok(())
    }
}
