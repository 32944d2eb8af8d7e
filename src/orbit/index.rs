//! Propagators of a whole catalogue, and the satellites that cannot be propagated.

use rayon::prelude::*;

use super::propagator::{OrbitError, Propagator};
use super::station_keeping::DragModel;
use crate::elements::{ElementSet, NoradId};

/// A satellite without a position, and the reason. One such satellite never stops a night.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Position of its element set in the catalogue.
    pub element_index: usize,
    /// Why SGP4 has no position.
    pub reason: OrbitError,
}

/// Propagators of a catalogue. Building takes about 1 µs a satellite and core.
#[derive(Clone, Debug)]
pub struct SatelliteIndex {
    /// In the catalogue's order; `None` where SGP4 cannot start.
    propagators: Vec<Option<Propagator>>,
    left_out: Vec<LeftOut>,
}

impl SatelliteIndex {
    /// Initialises SGP4 for every element set, on all threads.
    pub fn new(elements: &[ElementSet], drag: DragModel) -> Self {
        let made: Vec<Result<Propagator, OrbitError>> =
            elements.par_iter().map(|set| Propagator::with_drag(set, drag)).collect();
        let mut left_out = Vec::new();
        let propagators = made
            .into_iter()
            .enumerate()
            .map(|(element_index, result)| {
                result
                    .map_err(|reason| {
                        left_out.push(LeftOut { norad_id: elements[element_index].norad_id, element_index, reason });
                    })
                    .ok()
            })
            .collect();
        Self { propagators, left_out }
    }

    /// Number of element sets, those that cannot be propagated included.
    pub fn len(&self) -> usize {
        self.propagators.len()
    }

    /// True for an empty catalogue.
    pub fn is_empty(&self) -> bool {
        self.propagators.is_empty()
    }

    /// The propagator of the element set at this position; `None` where SGP4 cannot start or the position does not
    /// exist.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        self.propagators.get(element_index)?.as_ref()
    }

    /// Satellites that SGP4 cannot start from, whatever the time.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    pub(super) fn propagators(&self) -> &[Option<Propagator>] {
        &self.propagators
    }
}
