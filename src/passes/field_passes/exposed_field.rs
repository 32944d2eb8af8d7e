//! A field during one exposure, and the evaluation of its candidate satellites.

use std::sync::Arc;

use super::super::candidates::CandidateInterval;
use super::super::evaluator::PassEvaluator;
use super::super::exposure::Exposure;
use super::super::field::{Field, FieldOnSky};
use super::super::scene::Scene;
use super::super::sky::Sky;
use super::super::track::{ObserverMotion, SightLine};
use crate::error::Error;
use crate::frames::{Orientation, seconds_after, seconds_between};
use crate::orbit::{CrossingCandidate, LeftOut, OrbitArc, OrbitUncertainty, Propagator};
use crate::photometry::PhotometryOptions;

/// Field on the sky during an exposure. Times are seconds after the start of the scene.
pub(super) struct ExposedField<'a> {
    pub sky: &'a Sky,
    pub scene: &'a Scene,
    pub exposure: &'a Exposure,
    pub field: FieldOnSky<'a>,
    /// Orbital arc of a telescope in orbit; `None` for a site.
    pub flight: Option<Arc<OrbitArc>>,
    pub opened_s: f64,
    pub closed_s: f64,
}

/// Propagator of a satellite, orientation of the Earth and motion of the observer near one time.
pub(super) struct NearSatellite<'a> {
    pub propagator: &'a Propagator,
    /// Time from the epoch of the elements to the start of the scene, minutes.
    pub minutes: f64,
    pub orientation: Orientation,
    pub observer: ObserverMotion,
    pub uncertainty: OrbitUncertainty,
}

impl NearSatellite<'_> {
    /// Returns the orbital arc of the satellite between two times.
    pub fn arc(&self, from_s: f64, to_s: f64) -> Result<OrbitArc, Error> {
        OrbitArc::new(self.propagator, self.minutes, from_s, to_s - from_s, &self.orientation.teme_to_gcrs)
    }
}

impl<'a> ExposedField<'a> {
    pub fn new(sky: &'a Sky, scene: &'a Scene, exposure: &'a Exposure, field: &'a Field) -> Result<Self, Error> {
        let opened_s = seconds_between(scene.start, exposure.start);
        Ok(Self {
            sky,
            scene,
            exposure,
            field: field.on_sky(&exposure.pointing, exposure.rotation_rad),
            flight: sky.flight(scene, exposure)?,
            opened_s,
            closed_s: opened_s + exposure.duration_s,
        })
    }

    /// Evaluates all candidates with the function `of`, or as many as give enough results according to `is_enough`.
    /// Returns the results and the satellites without a position. `seen` is a buffer that is reused.
    pub fn evaluate<T>(
        &self,
        include_dark: bool,
        seen: &mut Vec<CrossingCandidate>,
        of: impl Fn(&CandidateInterval) -> Result<Option<T>, Error>,
        is_enough: impl Fn(&[T]) -> bool,
    ) -> Result<(Vec<T>, Vec<LeftOut>), Error> {
        let flight = self.flight.as_ref();
        let (mut found, mut left_out) = (Vec::new(), Vec::new());
        for interval in
            self.sky.candidate_intervals(self.scene, self.exposure, &self.field, flight, include_dark, seen)?
        {
            self.sky.watch().check()?;
            match of(&interval) {
                Ok(Some(evaluated)) => {
                    found.push(evaluated);
                    if found.len().is_power_of_two() && is_enough(&found) {
                        break;
                    }
                }
                Ok(None) => {}
                Err(reason) => left_out.push(self.sky.failed(interval.element_index, reason)),
            }
        }
        Ok((found, left_out))
    }

    /// Returns the propagator of a satellite for this exposure; `None` if there is none.
    pub fn propagator(&self, element_index: usize) -> Option<&'a Propagator> {
        self.sky.propagator_over(self.scene.start, element_index, [self.opened_s, self.closed_s])
    }

    /// Returns the data of a satellite near a time; `None` without a propagator.
    pub fn satellite(&self, element_index: usize, mid_s: f64) -> Option<NearSatellite<'a>> {
        let propagator = self.propagator(element_index)?;
        let orientation = self.scene.orientation.at_s(mid_s);
        Some(NearSatellite {
            propagator,
            minutes: propagator.minutes_since_epoch(self.scene.start),
            observer: self.sky.motion(self.scene, &orientation, self.flight.as_ref(), mid_s)?,
            uncertainty: self.sky.uncertainty_of(element_index, propagator, seconds_after(self.scene.start, mid_s)),
            orientation,
        })
    }

    /// Returns the evaluator for the line of sight to a satellite.
    pub fn evaluator<'l>(
        &'l self,
        line: &'l SightLine<'l>,
        element_index: usize,
        photometry: Option<&'l PhotometryOptions>,
        uncertainty: OrbitUncertainty,
    ) -> PassEvaluator<'l> {
        PassEvaluator { sky: self.sky, scene: self.scene, line, element_index, photometry, uncertainty }
    }
}
