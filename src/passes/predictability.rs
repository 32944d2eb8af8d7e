//! Whether the positions of a catalogue are known at a time: the rule that decides if exposures can be judged.
//!
//! A satellite whose elements are too old is left out of every search
//! ([`OrbitClass::is_known`](crate::orbit::OrbitClass::is_known)). An exposure cannot be
//! judged if the search finds less than half of all crossings ([`Predictability::is_unknown`]): "no crossing" would
//! then be wrong more often than right. Synthetic satellites are always known, and so is a satellite whose ephemeris
//! covers the time.

use std::sync::{Arc, Mutex, PoisonError};

use crate::math::quantile::median;
use crate::orbit::{LEAST_KNOWN_SHARE, Lateness, elements_of_age};

/// Number of cached times.
const CACHED: usize = 64;

/// How well the positions of the satellites of a catalogue are known at a time. All satellites count, wherever they
/// are.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictability {
    /// Number of satellites that can be propagated.
    pub satellites: usize,
    /// Number of these whose position is unknown, because their elements are too old.
    pub unknown: usize,
    /// Share of all crossings that the search finds, [0, 1]: the mean over the satellites; 0 for one of unknown
    /// position.
    pub searched_share: f64,
    /// Median age of the elements, days, negative if their epochs are later: of the satellites of unknown position if
    /// exposures cannot be judged, otherwise of those of known position. NaN without satellites.
    pub element_age_days: f64,
    /// Median lateness of the satellites of known position, seconds: 68 % of the delays of such a satellite are at most
    /// this long. `None` if there are none.
    pub late_s: Option<f64>,
    /// Distribution of the lateness of the satellite with the median.
    lateness: Option<Lateness>,
    /// Reason why the position of a telescope in orbit is unknown, and the age of its elements, days; `None` if it is
    /// known.
    pub(super) unknown_observer: Option<(String, f64)>,
}

/// Age of the elements of one satellite, and its lateness.
pub(super) struct SatelliteLateness {
    pub element_index: u32,
    pub age_days: f64,
    /// `None` if the position is unknown.
    pub known: Option<KnownLateness>,
}

/// Lateness of a satellite of known position.
pub(super) struct KnownLateness {
    /// Half width of 68 %, seconds.
    pub late_s: f64,
    /// Share of the crossings that the search finds.
    pub searched_share: f64,
}

impl Predictability {
    /// `lateness_of` returns the distribution of the lateness of a satellite of known position by its element index.
    pub(super) fn new(all: &[SatelliteLateness], lateness_of: impl FnOnce(usize) -> Option<Lateness>) -> Self {
        let satellites = all.len();
        let shares = all.iter().filter_map(|satellite| satellite.known.as_ref()).map(|known| known.searched_share);
        let searched_share = if satellites == 0 { 1.0 } else { shares.sum::<f64>() / satellites as f64 };
        let mut late: Vec<(f64, u32)> = all
            .iter()
            .filter_map(|satellite| Some((satellite.known.as_ref()?.late_s, satellite.element_index)))
            .collect();
        let unknown = satellites - late.len();
        let of_known = searched_share >= LEAST_KNOWN_SHARE;
        let ages = all.iter().filter(|satellite| satellite.known.is_some() == of_known);
        let ages: Vec<f64> = ages.map(|satellite| satellite.age_days).collect();
        let element_age_days = if ages.is_empty() { f64::NAN } else { median(ages) };
        let middle = (!late.is_empty()).then(|| {
            let half = late.len() / 2;
            *late.select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).1
        });
        Self {
            satellites,
            unknown,
            searched_share,
            element_age_days,
            late_s: middle.map(|(late_s, _)| late_s),
            lateness: middle.and_then(|(_, element_index)| lateness_of(element_index as usize)),
            unknown_observer: None,
        }
    }

    /// Returns true if exposures cannot be judged: the search finds less than half of the crossings, or the position of
    /// the telescope in orbit is unknown.
    pub fn is_unknown(&self) -> bool {
        self.searched_share < LEAST_KNOWN_SHARE || self.unknown_observer.is_some()
    }

    /// Returns the age of the elements that decide whether exposures can be judged, days: those of the telescope in
    /// orbit if its position is unknown, otherwise those of the satellites; `None` without satellites.
    pub fn deciding_age_days(&self) -> Option<f64> {
        let of_observer = self.unknown_observer.as_ref().map(|(_, age_days)| *age_days);
        of_observer.or_else(|| Some(self.element_age_days).filter(|age_days| age_days.is_finite()))
    }

    /// Returns true if probabilities are lower limits: more than 10 % of the satellites are of unknown position.
    pub fn misses_many(&self) -> bool {
        10 * self.unknown > self.satellites
    }

    /// Returns the reason why exposures cannot be judged; `None` if they can.
    pub fn reason(&self) -> Option<String> {
        if let Some((reason, _)) = &self.unknown_observer {
            return Some(reason.clone());
        }
        let of = if self.unknown < self.satellites {
            format!(" of {} of {} satellites", self.unknown, self.satellites)
        } else {
            String::new()
        };
        self.is_unknown().then(|| format!("{}: positions{of} unknown", elements_of_age(self.element_age_days)))
    }

    /// Returns the reason why the starts of exposures without a crossing cannot be computed from nominal tracks; `None`
    /// if they can. In addition to [`Predictability::reason`], this is the case if the nominal tracks predict less than
    /// half of the crossings of an exposure, because the satellites are early or late by more than the exposure
    /// (`duration_s`), the time of a crossing (`crossing_s`), and the margin before and after the exposure
    /// (`margin_s`), all in seconds.
    pub fn reason_for_starts(&self, duration_s: f64, crossing_s: f64, margin_s: f64) -> Option<String> {
        self.reason().or_else(|| {
            let share = self.lateness?.predicted_share(duration_s + crossing_s, margin_s);
            (share < LEAST_KNOWN_SHARE).then(|| {
                format!(
                    "{}, early or late by {:.0} s (68 %): {:.0} % of the crossings of an exposure of {duration_s} s with a \
                     margin of {margin_s} s are predicted, at least {:.0} % are needed",
                    elements_of_age(self.element_age_days),
                    self.late_s.unwrap_or_default(),
                    (100.0 * share).floor(),
                    100.0 * LEAST_KNOWN_SHARE
                )
            })
        })
    }
}

/// Cache of the most recently computed windows of six hours, by their numbers, the newest last.
#[derive(Debug, Default)]
pub(super) struct PredictabilityCache {
    kept: Mutex<Vec<(i64, Arc<Predictability>)>>,
}

impl PredictabilityCache {
    /// Returns the value of a window; `None` if it is not cached.
    pub fn find(&self, number: i64) -> Option<Arc<Predictability>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| *known == number).map(|(_, found)| found.clone())
    }

    /// Adds the value of a window.
    pub fn keep(&self, number: i64, found: &Arc<Predictability>) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push((number, found.clone()));
        let surplus = kept.len().saturating_sub(CACHED);
        kept.drain(..surplus);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the value for groups of satellites: number, age of the elements in days, and sigma of their lateness in
    /// seconds, `None` if their position is unknown.
    fn predictability(groups: &[(usize, f64, Option<f64>)]) -> Predictability {
        let of_one = |&(count, age_days, sigma_s): &(usize, f64, Option<f64>)| {
            let known = move || Some(KnownLateness { late_s: sigma_s?, searched_share: 1.0 });
            (0..count).map(move |_| SatelliteLateness { element_index: 0, age_days, known: known() })
        };
        let all: Vec<_> = groups.iter().flat_map(of_one).collect();
        Predictability::new(&all, |_| groups.iter().find_map(|(_, _, sigma_s)| sigma_s.map(Lateness::gaussian)))
    }

    #[test]
    fn exposures_are_unknown_if_half_of_the_crossings_are_missed() {
        let mixed = |fresh: usize, old: usize| predictability(&[(fresh, 1.0, Some(2.0)), (old, 216.0, None)]);
        let few = mixed(90, 10);
        assert_eq!((few.reason(), few.unknown, few.element_age_days, few.late_s), (None, 10, 1.0, Some(2.0)));
        assert!(!few.misses_many() && mixed(89, 11).misses_many());
        let many = mixed(400, 1600);
        let reason = "elements 216 days old: positions of 1600 of 2000 satellites unknown";
        assert_eq!((many.reason().as_deref(), many.element_age_days), (Some(reason), 216.0));
        let all = mixed(0, 3);
        assert_eq!(all.reason().as_deref(), Some("elements 216 days old: positions unknown"));
        assert_eq!((all.late_s, all.searched_share), (None, 0.0));
        let newer = predictability(&[(1, -40.0, None)]);
        assert_eq!(newer.reason().as_deref(), Some("elements 40 days newer than the exposure: positions unknown"));
        assert_eq!(predictability(&[]).reason(), None);
    }

    #[test]
    fn starts_need_nominal_tracks_that_predict_half_of_the_crossings() {
        let late = predictability(&[(9, 13.0, Some(37.0))]);
        assert_eq!(late.reason(), None);
        assert_eq!(
            late.reason_for_starts(10.0, 0.0, 2.0).as_deref(),
            Some(
                "elements 13 days old, early or late by 37 s (68 %): 14 % of the crossings of an exposure of 10 s with a \
                 margin of 2 s are predicted, at least 50 % are needed"
            )
        );
        for (duration_s, crossing_s, margin_s) in [(300.0, 0.0, 2.0), (10.0, 60.0, 2.0), (10.0, 0.0, 60.0)] {
            assert_eq!(late.reason_for_starts(duration_s, crossing_s, margin_s), None);
        }
    }
}
