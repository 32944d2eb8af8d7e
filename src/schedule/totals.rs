//! Totals over the verdicts of a schedule, in bounded memory: counts, warnings, and an estimate of how many verdicts
//! are wrong because the element sets are old.

use std::collections::BTreeMap;
use std::fmt;

use super::report::{FlagReport, SatelliteAge};
use super::verdict::{Verdict, VerdictKind};
use crate::math::quantile::median;
use crate::orbit::LeftOut;
use crate::output::counted;

/// Estimate of how many verdicts would change if the satellite positions had no error.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AgeEffect {
    /// Median age of the element sets at the exposures, days, without signs; negative if most of their epochs are later
    /// than the exposures.
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

/// Totals over the reports on the parts of a schedule.
#[derive(Clone, Debug, Default)]
pub struct FlagTotals {
    /// For each kind of verdict that occurs, the number of exposures and the first of them, without its passes.
    kinds: BTreeMap<VerdictKind, (usize, Verdict)>,
    left_out: Vec<LeftOut>,
    by_daylight: usize,
    lower_limits: usize,
    crossing: AgeSample,
    may_cross: AgeSample,
    /// Sum of the probabilities that the verdict of an exposure changes, and the number of exposures in it.
    changes: (f64, usize),
}

impl FlagTotals {
    /// Adds the report on further rows.
    pub fn add(&mut self, report: &FlagReport) {
        for flag in &report.flags {
            let first = || Verdict { passes: Vec::new(), ..flag.clone() };
            self.kinds.entry(flag.kind).or_insert_with(|| (0, first())).0 += 1;
            self.lower_limits += usize::from(flag.p_any_is_lower_limit);
            self.crossing.extend(flag.passes.iter().map(SatelliteAge::from_pass));
            // Where positions are unknown, there is no probability.
            if flag.p_crossing.is_finite() {
                self.changes.0 += match flag.kind {
                    VerdictKind::Clear => flag.p_crossing,
                    VerdictKind::Streaked if flag.passes.is_empty() => 0.0,
                    _ => 1.0 - flag.p_crossing,
                };
                self.changes.1 += 1;
            }
        }
        self.may_cross.extend(report.may_cross.iter().copied());
        self.by_daylight += report.by_daylight;
        self.left_out.extend(report.left_out.iter().cloned());
        // Indices of element sets are those of one sky, and the rows of a schedule may have several.
        self.left_out.sort_by_key(|left_out| left_out.norad_id);
        self.left_out.dedup_by_key(|left_out| left_out.norad_id);
    }

    /// Returns the number of exposures.
    pub fn exposures(&self) -> usize {
        self.kinds.values().map(|(count, _)| count).sum()
    }

    /// Returns the number of exposures with this verdict.
    pub fn count(&self, kind: VerdictKind) -> usize {
        self.kinds.get(&kind).map_or(0, |(count, _)| *count)
    }

    /// Returns the first exposure with this verdict, without its passes.
    pub fn first(&self, kind: VerdictKind) -> Option<&Verdict> {
        self.kinds.get(&kind).map(|(_, first)| first)
    }

    /// Returns the satellites whose position cannot be computed for at least one exposure, each once.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// Returns the warnings: exposures by daylight, probabilities that are lower limits, and old elements.
    pub fn warnings(&self) -> Vec<String> {
        let age = self.age_effect().filter(|effect| effect.changed_share >= AgeEffect::LARGE_SHARE);
        let warnings = [self.daylight_warning(), self.lower_limit_warning(), age.map(|effect| effect.to_string())];
        warnings.into_iter().flatten().collect()
    }

    /// Returns a warning if exposures begin while the Sun is above the horizon, which suggests that the times are in a
    /// wrong time scale or zone.
    fn daylight_warning(&self) -> Option<String> {
        (self.by_daylight > 0).then(|| {
            let number = counted(self.by_daylight, "exposure begins", "exposures begin");
            format!("{number} while the Sun is above the horizon; check the times and the site of the schedule")
        })
    }

    /// Returns a warning if `p_any` of any exposure is a lower limit.
    pub fn lower_limit_warning(&self) -> Option<String> {
        (self.lower_limits > 0).then(|| {
            format!(
                "p_any and the expected loss are lower limits for {} of {} exposures: more than 10 % of the delays of a \
                 satellite are outside the range searched (3.5 sigmas without manoeuvres, at most 300 s), or more than \
                 10 % of the satellites are of unknown position",
                self.lower_limits,
                self.exposures()
            )
        })
    }

    /// Estimates the effect of along-track errors on the verdicts; `None` if no satellite crosses or may cross, or if
    /// no exposure was judged.
    pub fn age_effect(&self) -> Option<AgeEffect> {
        let is_of_crossings = !self.crossing.ages.is_empty();
        let ages = if is_of_crossings { &self.crossing.ages } else { &self.may_cross.ages };
        let (changed, judged) = self.changes;
        let median_of = |value: fn(&SatelliteAge) -> f64| median(ages.iter().map(value).collect());
        (judged > 0 && !ages.is_empty()).then(|| AgeEffect {
            median_age_days: median_of(|age| age.element_age_days.abs())
                .copysign(median_of(|age| age.element_age_days)),
            is_of_crossings,
            lateness_s: median_of(|age| age.along_track_sigma_s),
            changed_share: changed / judged as f64,
        })
    }
}

/// Ages of all satellites added or, if there are many, of every second, every fourth and so on.
#[derive(Clone, Debug)]
struct AgeSample {
    ages: Vec<SatelliteAge>,
    /// One of this number of satellites is kept.
    step: usize,
    /// Number of satellites added.
    added: usize,
}

impl Default for AgeSample {
    fn default() -> Self {
        Self { ages: Vec::new(), step: 1, added: 0 }
    }
}

impl AgeSample {
    /// Largest size of the sample. A sample of half of it has a median within 0.2 % of the standard deviation.
    const MOST: usize = 1 << 20;

    fn extend(&mut self, ages: impl Iterator<Item = SatelliteAge>) {
        for age in ages {
            if self.added.is_multiple_of(self.step) {
                if self.ages.len() == Self::MOST {
                    let mut index = 0;
                    self.ages.retain(|_| {
                        index += 1;
                        index % 2 == 1
                    });
                    self.step *= 2;
                }
                self.ages.push(age);
            }
            self.added += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample of a bounded size has the median of all values that were added.
    #[test]
    fn verif_sample_of_ages_is_bounded_and_even() {
        let mut sample = AgeSample::default();
        let values = 5 * AgeSample::MOST / 2;
        let age = |value: usize| SatelliteAge { element_age_days: value as f64, along_track_sigma_s: 1.0 };
        sample.extend((0..values).map(age));
        assert!(sample.ages.len() <= AgeSample::MOST);
        let middle = median(sample.ages.iter().map(|age| age.element_age_days).collect());
        assert!((middle / (values as f64 / 2.0) - 1.0).abs() < 1e-5, "{middle}");
    }
}
