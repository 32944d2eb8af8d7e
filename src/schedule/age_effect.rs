//! Effect of the age of the element sets on the verdicts of a schedule.

use std::fmt;

use super::report::FlagReport;
use super::verdict::VerdictKind;
use crate::math::quantile::quantile;

/// Effect of the errors of element sets on the verdicts of a schedule.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AgeEffect {
    /// Median age of the element sets of the satellites that cross, days; negative if they are newer.
    pub median_age_days: f64,
    /// Median over these satellites of the half width that holds 68 % of the delays, early or late, seconds.
    pub lateness_s: f64,
    /// Expected share of the exposures whose verdict would change between clear and not clear if the positions were
    /// exact: the mean of `p_crossing` over the exposures without a nominal crossing, and of 1 - `p_crossing` over the
    /// others. Margins and near misses are not included.
    pub changed_share: f64,
}

impl AgeEffect {
    /// Share of changed verdicts above which a warning is given.
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
            "elements {age}: {:.1} s late (68 %, median of the satellites that cross), {:.1} % of the visits would change verdict \
             with exact positions",
            self.lateness_s,
            100.0 * self.changed_share
        )
    }
}

impl FlagReport {
    /// Returns the effect of the errors of the element sets on the verdicts; `None` if no satellite crosses.
    pub fn age_effect(&self) -> Option<AgeEffect> {
        let passes = || self.flags.iter().flat_map(|flag| &flag.passes);
        passes().next()?;
        let judged = self.flags.iter().filter(|flag| flag.kind != VerdictKind::Invalid);
        // The probability that the satellites cross, or do not cross, contrary to their nominal tracks.
        let changes: Vec<f64> =
            judged.map(|flag| if flag.n_streaks > 0 { 1.0 - flag.p_crossing } else { flag.p_crossing }).collect();
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5)
        };
        Some(AgeEffect {
            median_age_days: median(passes().map(|pass| pass.element_age_days).collect()),
            lateness_s: median(passes().map(|pass| pass.along_track_sigma_s).collect()),
            changed_share: changes.iter().sum::<f64>() / changes.len() as f64,
        })
    }

    /// Returns a warning with the effect of old element sets if it is larger than [`AgeEffect::LARGE_SHARE`].
    pub fn age_warning(&self) -> Option<String> {
        let effect = self.age_effect()?;
        (effect.changed_share >= AgeEffect::LARGE_SHARE).then(|| effect.to_string())
    }
}
