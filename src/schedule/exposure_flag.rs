//! Verdict on one exposure, with the numbers that it follows from.

use std::fmt;

use hifitime::Epoch;

use crate::elements::NoradId;

/// Verdict on an exposure.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// No lit satellite crosses it.
    Clear,
    /// A lit satellite crosses it, within the limits of the policy.
    Streaked,
    /// A crossing exceeds a limit of the policy.
    Avoid,
    /// It cannot be judged.
    Invalid,
}

impl Verdict {
    /// Returns the word in tables: `clear`, `streaked`, `avoid`, `invalid`.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Clear => "clear",
            Verdict::Streaked => "streaked",
            Verdict::Avoid => "avoid",
            Verdict::Invalid => "invalid",
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

/// Result for one exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureFlag {
    /// Identifier of the exposure in the schedule.
    pub exposure_id: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Lit satellites whose nominal tracks cross the field.
    pub n_streaks: usize,
    /// The brightest magnitude of all lit crossings in the field; `None` without crossings or magnitudes.
    pub brightest_mag: Option<f64>,
    /// Expected fraction of the pixels lost, each streak weighted with its probability; `None` without a telescope.
    pub expected_lost_pixel_fraction: Option<f64>,
    /// Probability that at least one lit satellite crosses, with independent errors: 1 - Π(1 - p).
    pub p_any: f64,
    /// True where `p_any` and the expected loss are lower limits: elements are so old that delays beyond those searched are probable.
    pub p_any_is_lower_limit: bool,
    /// Length of all nominal lit streaks in the field, degrees.
    pub streak_length_deg: f64,
    /// Reasons for the verdict.
    pub reasons: Vec<String>,
    /// The earliest start, not before the scheduled one, at which the verdict is `clear`; `None` if there is none within the allowed
    /// delay.
    pub next_clear_start: Option<Epoch>,
    /// Its delay after the scheduled start, seconds.
    pub delay_s: Option<f64>,
    /// Lit crossings in order of entry, with the near misses that count.
    pub norad_ids: Vec<NoradId>,
}

impl ExposureFlag {
    /// Returns the flag of a row that cannot be judged.
    pub fn invalid(exposure_id: &str, reason: String) -> Self {
        Self {
            exposure_id: exposure_id.to_owned(),
            verdict: Verdict::Invalid,
            n_streaks: 0,
            brightest_mag: None,
            expected_lost_pixel_fraction: None,
            p_any: f64::NAN,
            p_any_is_lower_limit: false,
            streak_length_deg: f64::NAN,
            reasons: vec![reason],
            next_clear_start: None,
            delay_s: None,
            norad_ids: Vec::new(),
        }
    }
}
