//! The verdict on one exposure, with the numbers behind it.

use std::fmt;

use hifitime::Epoch;

use crate::elements::NoradId;

/// What an exposure is.
#[derive(Copy, Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// No lit satellite crosses it.
    Clear,
    /// A lit satellite crosses it, and no rule forbids that one.
    Streaked,
    /// A rule forbids what crosses it.
    Avoid,
    /// It cannot be judged.
    Invalid,
}

impl Verdict {
    /// The word in tables: `clear`, `streaked`, `avoid`, `invalid`.
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

/// One exposure judged.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureFlag {
    /// The schedule's name of the exposure.
    pub exposure_id: String,
    /// The word.
    pub verdict: Verdict,
    /// Lit satellites whose nominal tracks cross the field.
    pub n_streaks: usize,
    /// The brightest magnitude that any lit crossing reaches in the field; `None` without crossings, or where no model sees any light.
    pub brightest_mag: Option<f64>,
    /// Share of the field's pixels expected lost, each streak weighed with its probability; `None` without a telescope.
    pub expected_lost_pixel_fraction: Option<f64>,
    /// Probability that at least one lit satellite crosses, their errors taken as independent: 1 - Π(1 - p).
    pub p_any: f64,
    /// True where `p_any` and the expected loss are lower limits: elements are so old that delays beyond those searched are probable.
    pub p_any_is_lower_limit: bool,
    /// Length of all nominal lit streaks in the field, degrees.
    pub streak_length_deg: f64,
    /// Why it is so, in words.
    pub reasons: Vec<String>,
    /// The earliest start from the scheduled one on at which the verdict would be `clear`; `None` where there is none within the delay allowed.
    pub next_clear_start: Option<Epoch>,
    /// How much later than scheduled that is, seconds.
    pub delay_s: Option<f64>,
    /// The lit crossings in order of entry, near misses that count included.
    pub norad_ids: Vec<NoradId>,
}

impl ExposureFlag {
    /// The flag of a row that cannot be judged.
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
