//! Estimate of how many verdicts of a schedule are wrong because the element sets are old.

use std::fmt;

use super::report::{FlagReport, SatelliteAge};
use super::verdict::VerdictKind;
use crate::math::quantile::median;

/// Estimate of how many verdicts would change if the satellite positions had no error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AgeEffect {
    /// Median age of the element sets at the exposures, days; negative if their epochs are later than the exposures.
    /// The median is over the satellites listed in verdicts or, if no verdict lists one, over all that may cross.
    pub median_age_days: f64,
    /// True if the medians are over satellites listed in verdicts, false if over all that may cross.
    pub is_of_crossings: bool,
    /// Median over these satellites of the along-track error, seconds: 68 % of the delays are at most this long, early
    /// or late.
    pub lateness_s: f64,
    /// Expected share of the exposures whose verdict changes between clear and not clear if the positions are exact:
    /// the mean of `p_crossing` over the clear exposures and of 1 - `p_crossing` over the others. Exposures that are
    /// not clear only because of a crossing in their margins count as unchanged.
    pub changed_share: f64,
}

impl AgeEffect {
    /// Value of `changed_share` from which a warning is given.
    pub const LARGE_SHARE: f64 = 0.01;
}

impl fmt::Display for AgeEffect {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let age = match self.median_age_days {
            days if days < -0.05 => format!("{:.1} days newer than the exposures", -days),
            days => format!("{:.1} days old", days.max(0.0)),
        };
        write!(
            formatter,
            "elements {age}: {:.1} s late (68 %, median of the satellites that {}), {:.1} % of the visits would change verdict \
             with exact positions",
            self.lateness_s,
            if self.is_of_crossings { "cross" } else { "may cross" },
            100.0 * self.changed_share
        )
    }
}

impl FlagReport {
    /// Estimates the effect of along-track errors on the verdicts; `None` if no satellite crosses or may cross.
    pub fn age_effect(&self) -> Option<AgeEffect> {
        let passes = self.flags.iter().flat_map(|flag| &flag.passes);
        let crossing: Vec<SatelliteAge> = passes.map(SatelliteAge::of).collect();
        let is_of_crossings = !crossing.is_empty();
        let satellites = if is_of_crossings { &crossing } else { &self.may_cross };
        satellites.first()?;
        // Where positions are unknown, there is no probability.
        let judged = self.flags.iter().filter(|flag| flag.p_crossing.is_finite());
        let changes: Vec<f64> = judged
            .map(|flag| match flag.kind {
                VerdictKind::Clear => flag.p_crossing,
                VerdictKind::Streaked if flag.passes.is_empty() => 0.0,
                _ => 1.0 - flag.p_crossing,
            })
            .collect();
        if changes.is_empty() {
            return None;
        }
        Some(AgeEffect {
            median_age_days: median(satellites.iter().map(|one| one.element_age_days).collect()),
            is_of_crossings,
            lateness_s: median(satellites.iter().map(|one| one.along_track_sigma_s).collect()),
            changed_share: changes.iter().sum::<f64>() / changes.len() as f64,
        })
    }

    /// Returns a warning that describes the effect if `changed_share` is at least [`AgeEffect::LARGE_SHARE`].
    pub fn age_warning(&self) -> Option<String> {
        let effect = self.age_effect()?;
        (effect.changed_share >= AgeEffect::LARGE_SHARE).then(|| effect.to_string())
    }
}
