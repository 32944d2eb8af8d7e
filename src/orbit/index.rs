//! Propagators of a whole catalogue, and the satellites that cannot be propagated.

use rayon::prelude::*;

use super::propagator::{OrbitError, Propagator};
use crate::elements::{ElementSet, NoradId};

/// A satellite without a position, and the reason. Such satellites never stop a computation.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Position of its element set in the catalogue.
    pub element_index: usize,
    /// Reason for the missing position.
    pub reason: OrbitError,
}

/// Propagators of a catalogue. Construction takes about 1 µs per satellite and core.
#[derive(Clone, Debug)]
pub struct SatelliteIndex {
    /// Propagators in catalogue order; `None` where SGP4 cannot be initialised.
    propagators: Vec<Option<Propagator>>,
    left_out: Vec<LeftOut>,
}

impl SatelliteIndex {
    /// Initialises SGP4 for every element set, on all threads.
    pub fn new(elements: &[ElementSet]) -> Self {
        let made: Vec<Result<Propagator, OrbitError>> = elements.par_iter().map(Propagator::new).collect();
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

    /// Returns the number of element sets, including those that cannot be propagated.
    pub fn len(&self) -> usize {
        self.propagators.len()
    }

    /// Returns true for an empty catalogue.
    pub fn is_empty(&self) -> bool {
        self.propagators.is_empty()
    }

    /// Returns the propagator of the element set at this position; `None` where SGP4 cannot be initialised or the
    /// position does not exist.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        self.propagators.get(element_index)?.as_ref()
    }

    /// Returns the satellites for which SGP4 cannot be initialised at any time.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    pub(super) fn propagators(&self) -> &[Option<Propagator>] {
        &self.propagators
    }
}
