//! When satellites were on station, from the history of their element sets.

use std::collections::HashMap;

use hifitime::Epoch;

use crate::elements::{History, NoradId, OrbitPhase, StationRule, orbit_phases};

/// A stretch of time in which a satellite did one thing.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct StationInterval {
    /// Half way from the element set before, or the first element set.
    pub start: Epoch,
    /// Half way to the element set after, or the last element set.
    pub end: Epoch,
    /// What it did.
    pub phase: OrbitPhase,
    /// On how many element sets this rests.
    pub element_sets: usize,
}

/// What every satellite of a history did when.
#[derive(Clone, Debug, Default)]
pub struct Stations {
    phases: HashMap<NoradId, Vec<(Epoch, OrbitPhase)>>,
}

impl Stations {
    /// Judges every element set by the rule.
    pub fn new(history: &History, rule: &StationRule) -> Self {
        let of_one = |sets: &[crate::elements::ElementSet]| {
            let phases = sets.iter().map(|set| set.epoch).zip(orbit_phases(sets, rule)).collect();
            (sets[0].norad_id, phases)
        };
        Self { phases: history.objects().map(of_one).collect() }
    }

    /// What a satellite did at a moment: what it does at its element set nearest in time; [`OrbitPhase::Unknown`] where it has none.
    pub fn phase_at(&self, norad_id: NoradId, epoch: Epoch) -> OrbitPhase {
        let Some(phases) = self.phases.get(&norad_id) else { return OrbitPhase::Unknown };
        let after = phases.partition_point(|(at, _)| *at <= epoch);
        let (before, next) = (after.checked_sub(1).map(|at| phases[at]), phases.get(after));
        match (before, next) {
            (Some((past, phase)), Some((coming, other))) => {
                if *coming - epoch <= epoch - past {
                    *other
                } else {
                    phase
                }
            }
            (Some((_, phase)), None) => phase,
            (None, Some((_, phase))) => *phase,
            (None, None) => OrbitPhase::Unknown,
        }
    }

    /// What a satellite did, stretch by stretch, in time order; empty of one that is not in the history.
    pub fn intervals(&self, norad_id: NoradId) -> Vec<StationInterval> {
        let phases = self.phases.get(&norad_id).map(Vec::as_slice).unwrap_or_default();
        let mut intervals: Vec<StationInterval> = Vec::new();
        let mut last: Option<Epoch> = None;
        for &(epoch, phase) in phases {
            match intervals.last_mut() {
                Some(interval) if interval.phase == phase => {
                    interval.end = epoch;
                    interval.element_sets += 1;
                }
                open => {
                    let start = last.map_or(epoch, |last| last + (epoch - last) * 0.5);
                    if let Some(interval) = open {
                        interval.end = start;
                    }
                    intervals.push(StationInterval { start, end: epoch, phase, element_sets: 1 });
                }
            }
            last = Some(epoch);
        }
        intervals
    }
}
