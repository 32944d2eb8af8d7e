//! A catalogue made ready: one propagator each, and the list of those that cannot be propagated.

use hifitime::Epoch;
use rayon::prelude::*;

use super::propagator::{OrbitError, Propagator};
use super::window::Window;
use crate::elements::{ElementSet, NoradId};

/// A satellite that has no answer, and why. One such satellite never stops a night.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Who.
    pub norad_id: NoradId,
    /// Position of its element set in the catalogue.
    pub element_index: usize,
    /// Why.
    pub reason: OrbitError,
}

/// Every satellite of a catalogue, ready to be propagated. Building takes about 1 µs a satellite and core.
#[derive(Clone, Debug)]
pub struct SatelliteIndex {
    /// In the catalogue's order; `None` where SGP4 cannot start.
    propagators: Vec<Option<Propagator>>,
    left_out: Vec<LeftOut>,
}

impl SatelliteIndex {
    /// Makes every element set ready, on all threads.
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

    /// How many element sets stand behind it, those left out included.
    pub fn len(&self) -> usize {
        self.propagators.len()
    }

    /// True for an empty catalogue.
    pub fn is_empty(&self) -> bool {
        self.propagators.is_empty()
    }

    /// The propagator of the element set at this position; `None` where SGP4 cannot start or the position does not exist.
    pub fn propagator(&self, element_index: usize) -> Option<&Propagator> {
        self.propagators.get(element_index)?.as_ref()
    }

    /// Satellites that SGP4 cannot start from, whatever the time.
    pub fn left_out(&self) -> &[LeftOut] {
        &self.left_out
    }

    /// Orbit planes and phases for a stretch of time of at most [`MAX_WINDOW_S`](super::MAX_WINDOW_S).
    ///
    /// `reach` gives, for each satellite, how far it may be from its prediction: no candidate within that reach is lost.
    pub fn window(&self, start: Epoch, end: Epoch, reach: &(dyn Fn(usize) -> Reach + Sync)) -> Window {
        Window::new(self, start, end, reach)
    }

    pub(super) fn propagators(&self) -> &[Option<Propagator>] {
        &self.propagators
    }
}

/// How far from its predicted place a satellite is still looked for; zero for nominal crossings alone.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// Along the track, seconds.
    pub along_track_s: f64,
    /// Across the track, km.
    pub cross_track_km: f64,
}
