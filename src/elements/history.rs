//! Element sets of every object in time order, and selection of the one nearest to a time.

use std::collections::HashSet;

use hifitime::{Epoch, Unit};

use super::element_set::{ElementSet, NoradId};

/// Element sets sorted by object, then by epoch. Records with equal epochs stay in reading order, and the one read last
/// is preferred.
///
/// Exact duplicates (same object, same epoch, same seven numbers for SGP4) are stored once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History {
    sets: Vec<ElementSet>,
}

impl History {
    /// Sorts the records and removes exact duplicates.
    pub fn new(mut sets: Vec<ElementSet>) -> Self {
        // The sort is stable: records of equal epochs stay in reading order.
        sets.sort_by(|a, b| a.norad_id.cmp(&b.norad_id).then_with(|| a.epoch.cmp(&b.epoch)));
        drop_duplicates(&mut sets);
        Self { sets }
    }

    /// Returns the number of records.
    pub fn len(&self) -> usize {
        self.sets.len()
    }

    /// Returns true if there are no records.
    pub fn is_empty(&self) -> bool {
        self.sets.is_empty()
    }

    /// Returns all records by object, then by epoch.
    pub fn element_sets(&self) -> &[ElementSet] {
        &self.sets
    }

    /// Returns all records by object, then by epoch.
    pub fn into_element_sets(self) -> Vec<ElementSet> {
        self.sets
    }

    /// Returns the records of one object in time order; empty if the object is unknown.
    pub fn sets_of(&self, norad_id: NoradId) -> &[ElementSet] {
        others_of(&self.sets, norad_id)
    }

    /// Returns the records of each object, in time order.
    pub fn objects(&self) -> impl Iterator<Item = &[ElementSet]> {
        self.sets.chunk_by(|a, b| a.norad_id == b.norad_id)
    }

    /// Returns the element set of an object with the epoch nearest to a time, before or after it; of two equally near
    /// ones the later one.
    pub fn nearest(&self, norad_id: NoradId, epoch: Epoch) -> Option<&ElementSet> {
        let sets = self.sets_of(norad_id);
        sets.get(nearest_index(sets, epoch)?)
    }

    /// Returns the element set nearest to a time for every object, sorted by catalogue number.
    pub fn at(&self, epoch: Epoch) -> Vec<ElementSet> {
        nearest_of_each(&self.sets, epoch)
    }

    /// Returns the latest element set of every object, sorted by catalogue number.
    pub fn newest(&self) -> Vec<ElementSet> {
        self.objects().filter_map(|sets| sets.last()).cloned().collect()
    }

    /// Returns the element set of every object nearest to a time, as [`at`](Self::at), and those of the same object
    /// within 18 days of it.
    pub fn into_nearest(self, epoch: Epoch) -> Chosen {
        self.into_chosen(|sets| nearest_index(sets, epoch).unwrap_or(0))
    }

    /// Returns the latest element set of every object, as [`newest`](Self::newest), and those of the same object within
    /// 18 days of it.
    pub fn into_newest(self) -> Chosen {
        self.into_chosen(|sets| sets.len() - 1)
    }

    fn into_chosen(self, choose: impl Fn(&[ElementSet]) -> usize) -> Chosen {
        if self.sets.windows(2).all(|pair| pair[0].norad_id != pair[1].norad_id) {
            return Chosen { sets: self.sets, others: Vec::new() };
        }
        let mut roles = Vec::with_capacity(self.sets.len());
        for sets in self.objects() {
            let chosen = choose(sets);
            roles.extend((0..sets.len()).map(|index| match index == chosen {
                true => Role::Chosen,
                false if is_near(&sets[index], &sets[chosen]) => Role::Other,
                false => Role::Unused,
            }));
        }
        let mut found = Chosen::default();
        for (set, role) in self.sets.into_iter().zip(roles) {
            match role {
                Role::Chosen => found.sets.push(set),
                Role::Other => found.others.push(set),
                Role::Unused => {}
            }
        }
        found
    }
}

/// Returns the element sets of one object from a list that is sorted by catalogue number.
pub(crate) fn others_of(sets: &[ElementSet], norad_id: NoradId) -> &[ElementSet] {
    let start = sets.partition_point(|set| set.norad_id < norad_id);
    let length = sets[start..].partition_point(|set| set.norad_id == norad_id);
    &sets[start..start + length]
}

/// One element set of each object, and element sets of the same objects with other epochs.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Chosen {
    /// One element set of each object, sorted by catalogue number.
    pub sets: Vec<ElementSet>,
    /// Element sets of the same objects within 18 days of the chosen ones, sorted by catalogue number,
    /// then by epoch.
    pub others: Vec<ElementSet>,
}

/// Largest difference between the epochs of an element set and of others that are kept with it, days. The mean motion
/// between two epochs is used up to 16 days.
const OTHERS_WITHIN_DAYS: f64 = 18.0;

/// Use of one record of a history.
enum Role {
    Chosen,
    Other,
    Unused,
}

fn is_near(set: &ElementSet, chosen: &ElementSet) -> bool {
    (set.epoch - chosen.epoch).abs() <= Unit::Day * OTHERS_WITHIN_DAYS
}

/// Returns the element set nearest to a time for every object; `sets` must be sorted.
pub(super) fn nearest_of_each(sets: &[ElementSet], epoch: Epoch) -> Vec<ElementSet> {
    let objects = sets.chunk_by(|a, b| a.norad_id == b.norad_id);
    objects.filter_map(|sets| sets.get(nearest_index(sets, epoch)?)).cloned().collect()
}

/// Returns the element sets nearest to a time, and the others near them; `sets` must be sorted.
pub(super) fn chosen_of_each(sets: &[ElementSet], epoch: Epoch) -> Chosen {
    let mut found = Chosen::default();
    for sets in sets.chunk_by(|a, b| a.norad_id == b.norad_id) {
        let Some(index) = nearest_index(sets, epoch) else { continue };
        let chosen = &sets[index];
        found.sets.push(chosen.clone());
        let others = sets.iter().enumerate().filter(|(other, set)| *other != index && is_near(set, chosen));
        found.others.extend(others.map(|(_, set)| set.clone()));
    }
    found
}

/// Returns the index of the nearest epoch; `sets` must be in time order.
fn nearest_index(sets: &[ElementSet], epoch: Epoch) -> Option<usize> {
    let after = sets.partition_point(|set| set.epoch <= epoch);
    if after == 0 {
        // Of several records with the first epoch, the last one is used.
        let first = sets.first()?.epoch;
        return Some(sets.partition_point(|set| set.epoch <= first) - 1);
    }
    let Some(next) = sets.get(after) else { return Some(after - 1) };
    // Differences are computed in TAI: UTC durations across a leap second are too short by one second.
    let tai = |epoch: Epoch| epoch.to_tai_duration();
    if tai(next.epoch) - tai(epoch) <= tai(epoch) - tai(sets[after - 1].epoch) {
        Some(sets.partition_point(|set| set.epoch <= next.epoch) - 1)
    } else {
        Some(after - 1)
    }
}

/// Keeps the first of several exact duplicates in sorted records. If it lacks a name or a designator, that of a removed
/// duplicate is used.
fn drop_duplicates(sets: &mut Vec<ElementSet>) {
    let same_instant = |a: &ElementSet, b: &ElementSet| a.norad_id == b.norad_id && a.epoch == b.epoch;
    if !sets.windows(2).any(|pair| same_instant(&pair[0], &pair[1])) {
        return;
    }
    let mut kept: Vec<ElementSet> = Vec::with_capacity(sets.len());
    let mut seen = HashSet::new();
    for set in sets.drain(..) {
        if !kept.last().is_some_and(|last| same_instant(last, &set)) {
            seen.clear();
        }
        if seen.insert(elements(&set)) {
            kept.push(set);
        } else if let Some(twin) = kept.iter_mut().rev().find(|twin| elements(twin) == elements(&set)) {
            if twin.name.is_empty() {
                twin.name = set.name;
            }
            if twin.international_designator.is_empty() {
                twin.international_designator = set.international_designator;
            }
        }
    }
    *sets = kept;
}

/// Returns the bits of the seven numbers for SGP4; a minus zero is converted to zero.
fn elements(set: &ElementSet) -> [u64; 7] {
    [
        set.mean_motion_rev_day,
        set.eccentricity,
        set.inclination_deg,
        set.right_ascension_of_node_deg,
        set.argument_of_perigee_deg,
        set.mean_anomaly_deg,
        set.bstar_per_earth_radius,
    ]
    .map(|value| (value + 0.0).to_bits())
}
