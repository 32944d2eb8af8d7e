//! The element set nearest in time, kept as long as it is.

use hifitime::{Epoch, Unit};

use crate::elements::{ElementSet, History, NoradId};
use crate::orbit::Propagator;

/// The orbit last asked for: rows of a track mostly want the same one.
#[derive(Default)]
pub(super) struct Orbits {
    pub last: Option<Orbit>,
}

/// An element set made ready.
pub(super) struct Orbit {
    norad_id: NoradId,
    /// Minutes from its epoch between which no other element set is nearer.
    nearest_min: [f64; 2],
    /// `None` where SGP4 cannot start.
    pub propagator: Option<Propagator>,
}

impl Orbit {
    /// The element set nearest to a moment.
    pub fn nearest(history: &History, norad_id: NoradId, epoch: Epoch) -> Option<Self> {
        let nearest = history.nearest(norad_id, epoch)?;
        let sets = history.of(norad_id);
        // Half way to the neighbours in time.
        let half_min = |other: Option<&ElementSet>, sign: f64| {
            other.map_or(sign * f64::INFINITY, |other| 0.5 * (other.epoch - nearest.epoch).to_unit(Unit::Minute))
        };
        let before = sets[..sets.partition_point(|set| set.epoch < nearest.epoch)].last();
        let after = sets.get(sets.partition_point(|set| set.epoch <= nearest.epoch));
        let nearest_min = [half_min(before, -1.0), half_min(after, 1.0)];
        Some(Self { norad_id, nearest_min, propagator: Propagator::new(nearest).ok() })
    }

    /// Whether it is still the one to ask.
    pub fn serves(&self, norad_id: NoradId, epoch: Epoch) -> bool {
        let [from, to] = self.nearest_min;
        let minutes = self.propagator.as_ref().map(|propagator| propagator.minutes_since_epoch(epoch));
        self.norad_id == norad_id && minutes.is_some_and(|minutes| from < minutes && minutes < to)
    }
}
