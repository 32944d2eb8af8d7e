//! Ages, expected errors and brightness models of the element sets of a catalogue at a given time.

use std::collections::BTreeMap;
use std::sync::Arc;

use hifitime::Epoch;

use super::super::prepared::without_elements;
use super::super::warnings::of_ephemerides_without_elements;
use super::finding::{Finding, MomentSource, Severity};
use crate::constants::DAY_S;
use crate::elements::{ElementSet, Ephemeris, Generation, GenerationTable, STARLINK_TABLE_DATE, Satellites};
use crate::frames::seconds_between;
use crate::math::quantile::median;
use crate::orbit::{DragModel, OrbitModel, uncertainty};
use crate::output::{counted, format_utc};
use crate::passes::ModelChoice;

/// Limits of the bins of the age histogram, days. Ages are negative for epochs in the future.
const BORDERS_DAYS: [f64; 9] = [-FUTURE_DAYS, 0.0, 0.5, 1.0, 2.0, 4.0, 7.0, 14.0, 30.0];
/// Largest usual time from now to the epoch of an element set that an operator has predicted, days.
const FUTURE_DAYS: f64 = 1.5;
/// Age above which element sets cause a warning, days.
const OLD_DAYS: f64 = 14.0;
/// Share of old element sets above which the finding is a warning.
const OLD_SHARE: f64 = 0.05;
/// Median along-track error above which the finding is a warning, seconds. A low satellite moves by more than a degree
/// in this time.
const LARGE_ERROR_S: f64 = 3.0;
/// Smallest number of satellites with the same prefix of their names that are reported as a constellation without a
/// model.
const CONSTELLATION: usize = 30;
/// Largest number of constellations listed in the finding.
const LISTED: usize = 10;

/// One bin of the age histogram.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct AgeBin {
    /// Lower limit of the age, days; negative for epochs in the future, minus infinity for the first bin.
    pub from_days: f64,
    /// Upper limit of the age, days; infinite for the last bin.
    pub to_days: f64,
    /// Number of element sets in the bin.
    pub count: usize,
}

/// Satellites with the same name, except for a number, that have only the default brightness model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unmatched {
    /// Name without the number.
    pub prefix: String,
    /// Number of satellites.
    pub count: usize,
}

/// State of the operator ephemerides at a given time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EphemerisState {
    /// Number of ephemerides.
    pub count: usize,
    /// Number of ephemerides with a covariance.
    pub with_covariance: usize,
    /// Number of ephemerides whose states cover the time.
    pub current: usize,
    /// Median time since the creation of the files (since the first state if the creation time is not stated), days; 0
    /// without ephemerides.
    pub median_age_days: f64,
    /// Satellites that have an ephemeris but no element set. Their ephemerides are not used.
    pub without_elements: Vec<String>,
}

impl EphemerisState {
    fn new(catalogue: &Satellites, now: Epoch) -> Self {
        let all = || catalogue.ephemerides.iter();
        let age_days = |ephemeris: &Arc<Ephemeris>| {
            seconds_between(ephemeris.created.unwrap_or(ephemeris.interval().0), now) / DAY_S
        };
        let is_current = |ephemeris: &&Arc<Ephemeris>| {
            let (first, last) = ephemeris.interval();
            seconds_between(first, now) >= 0.0 && seconds_between(now, last) >= 0.0
        };
        Self {
            count: catalogue.ephemerides.len(),
            with_covariance: all().filter(|ephemeris| !ephemeris.covariances.is_empty()).count(),
            current: all().filter(is_current).count(),
            median_age_days: median_or_0(all().map(age_days).collect()),
            without_elements: without_elements(&catalogue.ephemerides, &catalogue.element_sets),
        }
    }

    /// Returns the findings on ephemerides; empty if there are none.
    fn findings(&self, now: Epoch) -> Vec<Finding> {
        const SUBJECT: &str = "ephemerides";
        if self.count == 0 {
            return Vec::new();
        }
        let days = self.median_age_days;
        let age = if days < 0.0 { format!("{:.1} days in the future", -days) } else { format!("{days:.1} days") };
        let state = format!(
            "{}, {} with a covariance, median age {age}; {} cover {}",
            counted(self.count, "ephemeris", "ephemerides"),
            self.with_covariance,
            self.current,
            format_utc(now, 0)
        );
        let mut found = vec![if self.current == 0 {
            let remedy =
                "fetch newer ephemerides (streakcast fetch starlink-ephemerides); element sets are used until then";
            Finding::warning(SUBJECT, state, remedy)
        } else {
            Finding::fine(SUBJECT, state)
        }];
        found.extend(
            of_ephemerides_without_elements(&self.without_elements).map(|finding| {
                Finding::warning(SUBJECT, finding, "add element sets of these satellites to --elements")
            }),
        );
        found
    }
}

/// State of the element sets of a catalogue at a given time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ElementState {
    /// Number of satellites, each with one element set.
    pub satellites: usize,
    /// Age histogram.
    pub ages: Vec<AgeBin>,
    /// Median age of the element sets, days.
    pub median_age_days: f64,
    /// Number of satellites whose position is unknown, because their elements are too old.
    pub unknown: usize,
    /// Median along-track error (one sigma) of all others, seconds; 0 if there are none.
    pub median_along_track_sigma_s: f64,
    /// The same error if only the element set closest to the time were used; `None` without those of other epochs.
    pub median_of_one_set_s: Option<f64>,
    /// State of the operator ephemerides.
    pub ephemerides: EphemerisState,
    /// Number of satellites of each generation that has a brightness model.
    pub kinds: Vec<(Generation, usize)>,
    /// Number of satellites in `kinds` whose generation is assumed.
    pub assumed: usize,
    /// Satellites with the default model, grouped by name, the largest group first.
    pub unmatched: Vec<Unmatched>,
}

impl ElementState {
    /// Computes the state of a catalogue at `now` with the models of `choice`.
    pub fn new(catalogue: &Satellites, choice: &ModelChoice, drag: DragModel, now: Epoch) -> Self {
        let sets = &catalogue.element_sets;
        let age_days = |set: &ElementSet| seconds_between(set.epoch, now) / DAY_S;
        let ages: Vec<f64> = sets.iter().map(age_days).collect();
        let others = &catalogue.other_epochs;
        // Errors along the track of the satellites whose position is known.
        let sigmas = |others: &[ElementSet]| -> Vec<f64> {
            let models = OrbitModel::of_catalogue(sets, others, now, drag);
            let known = models.iter().zip(&ages).filter(|(model, age)| model.class.is_known(**age));
            known.map(|(model, age)| uncertainty(model.class, *age).along_track_s).collect()
        };
        let median_of_one_set_s = (!others.is_empty()).then(|| median_or_0(sigmas(&[])));
        let sigmas = sigmas(others);
        let table = GenerationTable::embedded();
        let mut kinds = BTreeMap::new();
        let mut unmatched: BTreeMap<String, usize> = BTreeMap::new();
        for set in sets {
            let kind = table.generation(set);
            if kind == Generation::Other {
                if choice.is_unknown(set) {
                    *unmatched.entry(prefix(&set.name)).or_default() += 1;
                }
            } else {
                *kinds.entry(kind).or_default() += 1;
            }
        }
        let mut unmatched: Vec<Unmatched> =
            unmatched.into_iter().map(|(prefix, count)| Unmatched { prefix, count }).collect();
        unmatched.sort_by(|a, b| b.count.cmp(&a.count).then_with(|| a.prefix.cmp(&b.prefix)));
        Self {
            satellites: sets.len(),
            ages: histogram(&ages),
            median_age_days: median_or_0(ages),
            unknown: sets.len() - sigmas.len(),
            median_along_track_sigma_s: median_or_0(sigmas),
            median_of_one_set_s,
            ephemerides: EphemerisState::new(catalogue, now),
            kinds: kinds.into_iter().collect(),
            assumed: sets.iter().filter(|set| table.is_assumed(set)).count(),
            unmatched,
        }
    }

    /// Returns true if most epochs are so far in the future that the system clock may be wrong.
    pub fn is_mostly_ahead(&self) -> bool {
        2 * self.ages.first().map_or(0, |bin| bin.count) > self.satellites
    }

    /// Returns the findings on age, rejected records and duplicates.
    pub fn findings(&self, catalogue: &Satellites, now: Epoch, source: MomentSource) -> Vec<Finding> {
        // A request for another time requires elements near that time, not the newest ones.
        let nearer = match source {
            MomentSource::Clock => "fetch newer elements (streakcast fetch)",
            MomentSource::Given => {
                "use elements closer to that time (streakcast fetch satchecker --epoch downloads old ones)"
            }
        };
        const SUBJECT: &str = "elements";
        let share = |count: usize| format!("{count} of {}", self.satellites);
        let mut found = Vec::new();

        let sigma_s = self.median_along_track_sigma_s;
        let median = match self.median_age_days {
            days if days < -0.05 => format!("half of them more than {:.1} days in the future", -days),
            days => format!("median age {:.1} days", days.max(0.0)),
        };
        let satellites = counted(self.satellites, "satellite", "satellites");
        let without = match self.median_of_one_set_s {
            Some(one_set_s) => format!(", without the sets of other epochs by {one_set_s:.1} s"),
            None => String::new(),
        };
        let lateness = match self.unknown {
            0 => format!("early or late by {sigma_s:.1} s{without} (68 %, median)"),
            all if all == self.satellites => "positions unknown".to_owned(),
            unknown => format!(
                "positions of {unknown} unknown, the others early or late by {sigma_s:.1} s{without} (68 %, median)"
            ),
        };
        let age = format!("{satellites}; {median}; {lateness}");
        found.push(if 2 * self.unknown > self.satellites {
            Finding::error(SUBJECT, age, nearer)
        } else if sigma_s > LARGE_ERROR_S {
            let older = match self.median_of_one_set_s {
                Some(_) => "",
                None => ", or add element sets of a week before to --elements",
            };
            let remedy = format!("{nearer}{older}; or use flag with --min-probability or a margin_s of that size");
            Finding::warning(SUBJECT, age, remedy)
        } else {
            Finding::fine(SUBJECT, age)
        });

        let old =
            catalogue.element_sets.iter().filter(|set| seconds_between(set.epoch, now) > OLD_DAYS * DAY_S).count();
        if old > 0 {
            let is_many = old as f64 > OLD_SHARE * self.satellites as f64;
            let severity = if is_many { Severity::Warning } else { Severity::Note };
            let are = if old == 1 { "is" } else { "are" };
            let finding = format!("{} {are} older than {OLD_DAYS:.0} days", share(old));
            let remedy = match 2 * old > self.satellites {
                true => nearer.to_owned(),
                false => "nothing if the satellites have decayed; otherwise fetch newer elements".to_owned(),
            };
            found.push(Finding::new(severity, SUBJECT, finding, remedy));
        }

        let future: Vec<&ElementSet> =
            catalogue.element_sets.iter().filter(|set| seconds_between(now, set.epoch) > FUTURE_DAYS * DAY_S).collect();
        if let Some(farthest) = future.iter().max_by(|a, b| a.epoch.cmp(&b.epoch)) {
            let is_most = self.is_mostly_ahead();
            let severity = if is_most { Severity::Error } else { Severity::Warning };
            let have = if future.len() == 1 { "has an epoch" } else { "have epochs" };
            let finding = format!(
                "{} {have} more than {FUTURE_DAYS} days after {}: up to {}",
                share(future.len()),
                format_utc(now, 0),
                format_utc(farthest.epoch, 0)
            );
            let remedy = match (is_most, source) {
                (true, MomentSource::Clock) => "correct the clock (chrony, w32time), or use older elements",
                (true, MomentSource::Given) => nearer,
                (false, _) => "remove them: predictions that far ahead are not reliable",
            };
            found.push(Finding::new(severity, SUBJECT, finding, remedy));
        }

        let records: usize = catalogue.sources.iter().map(|source| source.records + source.rejected).sum();
        if let Some(first) = catalogue.rejected.first() {
            let rejected = catalogue.rejected.len();
            let severity = if 2 * rejected > records { Severity::Error } else { Severity::Warning };
            let records = counted(records, "record", "records");
            let finding = format!("{rejected} of {records} rejected, the first: {first}");
            found.push(Finding::new(
                severity,
                SUBJECT,
                finding,
                "the satellites of these records are missing from all results: fetch the file again",
            ));
        }
        if catalogue.duplicates > 0 {
            let finding = counted(catalogue.duplicates, "duplicate record", "duplicate records");
            found.push(Finding::note(SUBJECT, finding, "nothing: each is used once"));
        }
        if catalogue.superseded > 0 {
            let older = counted(catalogue.superseded, "older record", "older records");
            let finding = format!("{older} of objects with a newer one");
            found.push(Finding::note(SUBJECT,
                finding,
                "nothing: the set closest to the time of the request gives the position, the others the mean motion of Starlinks",
            ));
        }
        found.extend(self.ephemerides.findings(now));
        found
    }

    /// Returns the finding on the brightness models of the satellites.
    pub fn model_finding(&self) -> Finding {
        const SUBJECT: &str = "models";
        let known: usize = self.kinds.iter().map(|(_, count)| count).sum();
        let without: usize = self.unmatched.iter().map(|group| group.count).sum();
        let satellites = counted(self.satellites, "satellite", "satellites");
        let have = if known == 1 { "has a model of its generation" } else { "have a model of their generation" };
        let mut finding = format!("{known} of {satellites} {have}");
        if self.assumed > 0 {
            finding += &format!(
                " ({} of an assumed kind: launched after the table of {STARLINK_TABLE_DATE}, or without a name)",
                self.assumed
            );
        }
        let others = self.satellites.saturating_sub(known + without);
        if others > 0 {
            let have = if others == 1 { "has" } else { "have" };
            finding += &format!(", {others} {have} a standard magnitude or the model of rocket bodies and debris");
        }
        if without == 0 {
            return Finding::fine(SUBJECT, finding);
        }
        let have = if without == 1 { "has" } else { "have" };
        finding += &format!(", {without} {have} the default model (6.5 mag at 1000 km, sigma 1.7 mag)");
        let constellations: Vec<String> = self
            .unmatched
            .iter()
            .filter(|group| group.count >= CONSTELLATION && !group.prefix.is_empty())
            .take(LISTED)
            .map(|group| format!("{} ({})", group.prefix, group.count))
            .collect();
        if !constellations.is_empty() {
            finding += &format!(", including {}", constellations.join(", "));
        }
        let remedy = "specify standard magnitudes with --qs-mag, or models in [models] of the configuration file";
        Finding::note(SUBJECT, finding, remedy)
    }
}

fn histogram(ages_days: &[f64]) -> Vec<AgeBin> {
    let mut bins = vec![AgeBin { from_days: f64::NEG_INFINITY, to_days: BORDERS_DAYS[0], count: 0 }];
    for (index, from_days) in BORDERS_DAYS.into_iter().enumerate() {
        let to_days = BORDERS_DAYS.get(index + 1).copied().unwrap_or(f64::INFINITY);
        bins.push(AgeBin { from_days, to_days, count: 0 });
    }
    for age in ages_days {
        if let Some(bin) = bins.iter_mut().find(|bin| *age < bin.to_days) {
            bin.count += 1;
        }
    }
    bins
}

/// Returns the median; 0 for an empty list.
fn median_or_0(values: Vec<f64>) -> f64 {
    if values.is_empty() { 0.0 } else { median(values) }
}

/// Returns the letters at the start of a name, in upper case: `LEMUR-2 JEROEN` gives LEMUR, `FLOCK 4V-12` gives FLOCK.
fn prefix(name: &str) -> String {
    let word: String = name.chars().take_while(|character| character.is_alphabetic()).collect();
    word.to_ascii_uppercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_every_age_is_in_one_bin() {
        let ages = [-3.0, -1.5, -0.001, 0.0, 0.49, 0.5, 1.9, 6.99, 13.9, 14.0, 29.0, 30.0, 9_999.0];
        let bins = histogram(&ages);
        assert_eq!(bins.iter().map(|bin| bin.count).collect::<Vec<_>>(), [1, 2, 2, 1, 1, 0, 1, 1, 2, 2]);
        for (low, high) in bins.iter().zip(&bins[1..]) {
            assert_eq!(low.to_days, high.from_days);
        }
        assert_eq!((median_or_0(vec![3.0, 1.0, 2.0]), median_or_0(Vec::new())), (2.0, 0.0));
    }

    #[test]
    fn names_without_numbers() {
        for (name, expected) in [("LEMUR-2 JEROEN", "LEMUR"), ("Flock 4v-12", "FLOCK"), ("2024-001A", ""), ("", "")] {
            assert_eq!(prefix(name), expected);
        }
    }
}
