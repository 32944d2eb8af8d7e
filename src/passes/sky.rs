//! A catalogue over one site, or around one telescope in orbit: the one thing that every outcome asks.

use std::sync::Arc as Shared;

use hifitime::Epoch;
use rayon::prelude::*;
use thiserror::Error;

use super::almanac::Almanac;
use super::expose::Run;
use super::exposure::Exposure;
use super::field::Field;
use super::models::ModelChoice;
use super::probability::{LONGEST_REACH_S, REACH_SIGMAS, reach_s};
use super::scene::{Scene, end_s, groups};
use super::sightline::ObserverMotion;
use super::track::FieldPass;
use super::viewpoint::{OrbitingObserver, Viewpoint};
use super::windows::{Wanted, Windows};
use crate::constants::DAY_S;
use crate::elements::ElementSet;
use crate::frames::{EopTable, Orientation, OrientationTable, seconds_after, seconds_between};
use crate::geometry::{Observer, ShadowModel};
use crate::orbit::{
    Arc, LeftOut, OrbitClass, OrbitError, OrbitUncertainty, Reach, SatelliteIndex, Window, uncertainty,
};
use crate::photometry::{BrightnessModel, PhotometryOptions};

/// First and last year for which Sun and Earth are computed.
const YEARS: (i32, i32) = (1957, 2099);

/// Why a question has no answer at all.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SkyError {
    /// No ephemeris of Sun and Earth, and no elements either.
    #[error("{epoch} is outside the years for which Sun and Earth are known (allowed: {} to {})", YEARS.0, YEARS.1)]
    NoEphemeris {
        /// What was asked for.
        epoch: Epoch,
    },
    /// The telescope's own elements give no place.
    #[error("the observer {observer} has no place: {reason}")]
    Observer {
        /// Its name.
        observer: String,
        /// Why.
        reason: OrbitError,
    },
    /// A question that only a site can be asked.
    #[error("the observer {observer} is in orbit and has no horizon (allowed: a site)")]
    NoHorizon {
        /// Its name.
        observer: String,
    },
    /// An exposure of no possible length or direction.
    #[error("exposure {id}: {problem}")]
    Exposure {
        /// The schedule's name of it.
        id: String,
        /// What is wrong, and what is allowed.
        problem: String,
    },
}

/// What is wanted of each pass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassOptions {
    /// Crossings that are dark all along too.
    pub include_dark: bool,
    /// Near misses that cross with at least this probability too; `None` keeps to nominal crossings.
    pub min_probability: Option<f64>,
    /// Points along the track, evenly spaced in time from entry to exit; 0 for none.
    pub samples: usize,
    /// Band, system, extinction.
    pub photometry: PhotometryOptions,
    /// When and where alone, and whether it is lit: no brightness at any point, and no peak. Several times faster.
    pub without_light: bool,
}

/// The answer to one question.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Passes {
    /// For each exposure asked, in its place, the passes in order of entry.
    pub by_exposure: Vec<Vec<FieldPass>>,
    /// Satellites without a position for at least one of the exposures, each once, in catalogue order. Nobody is asked for one while the field is below the ground.
    pub left_out: Vec<LeftOut>,
}

/// Satellites, an observer, and what is known of their light: ready for any number of questions, from any thread. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Sky {
    elements: Shared<Vec<ElementSet>>,
    index: Shared<SatelliteIndex>,
    classes: Shared<Vec<OrbitClass>>,
    models: Shared<Vec<Shared<BrightnessModel>>>,
    viewpoint: Viewpoint,
    shadow: ShadowModel,
    eop: EopTable,
    windows: Shared<Windows>,
    almanac: Shared<Almanac>,
}

impl Sky {
    /// Makes a catalogue ready over one site, or around one telescope in orbit. Takes about 2 µs a satellite and core. The shadow is geometric.
    pub fn new(
        elements: Vec<ElementSet>,
        viewpoint: impl Into<Viewpoint>,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let index = SatelliteIndex::new(&elements);
        let classes: Vec<OrbitClass> = elements.iter().map(OrbitClass::of).collect();
        let models: Vec<_> = elements.iter().map(|elements| choice.model_of(elements)).collect();
        Self {
            elements: Shared::new(elements),
            index: Shared::new(index),
            classes: Shared::new(classes),
            models: Shared::new(models),
            viewpoint: viewpoint.into(),
            shadow: ShadowModel::default(),
            eop,
            windows: Shared::default(),
            almanac: Shared::default(),
        }
    }

    /// The same satellites from elsewhere: costs nothing, and what is kept from question to question is kept for both.
    pub fn seen_from(&self, viewpoint: impl Into<Viewpoint>) -> Self {
        Self { viewpoint: viewpoint.into(), ..self.clone() }
    }

    /// The element sets, in the order of [`FieldPass::element_index`].
    pub fn elements(&self) -> &[ElementSet] {
        &self.elements
    }

    /// The same sky with another shadow of the Earth.
    pub fn with_shadow(self, shadow: ShadowModel) -> Self {
        Self { shadow, ..self }
    }

    /// What casts the Earth's shadow.
    pub fn shadow(&self) -> ShadowModel {
        self.shadow
    }

    /// Where the telescope is.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// The observer on a site, for questions that ask of a horizon.
    pub(super) fn site_observer(&self) -> Result<&Observer, SkyError> {
        self.viewpoint.site().ok_or_else(|| SkyError::NoHorizon { observer: self.viewpoint.name() })
    }

    /// The brightness model of an element set.
    ///
    /// # Panics
    /// Where the catalogue has no element set of this number.
    pub fn model(&self, element_index: usize) -> &BrightnessModel {
        &self.models[element_index]
    }

    /// Satellites that SGP4 cannot start from.
    pub fn left_out(&self) -> &[LeftOut] {
        self.index.left_out()
    }

    pub(super) fn index(&self) -> &SatelliteIndex {
        &self.index
    }

    /// The Earth's orientation from `start` to `end`, as every answer of this sky takes it.
    pub fn orientation_over(&self, start: Epoch, end: Epoch) -> OrientationTable {
        self.almanac.over(start, end, &self.eop).0
    }

    /// One-sigma errors of a satellite's prediction at an age of its elements.
    pub fn uncertainty(&self, element_index: usize, age_days: f64) -> OrbitUncertainty {
        uncertainty(self.classes[element_index], age_days)
    }

    /// Every satellite that crosses the field in each exposure, on all threads of the current pool.
    ///
    /// Exposures may come in any order and last from nothing to days; those of one night share their preparation. The answer
    /// does not depend on the number of threads. A satellite that comes back after leaving (an exposure of hours) is a
    /// pass of its own each time.
    ///
    /// # Errors
    /// [`SkyError`] where an exposure has no finite direction or length, or lies outside the years of the Sun's ephemeris; where the telescope is in orbit and its
    /// own elements give no place.
    pub fn field_passes(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
    ) -> Result<Passes, SkyError> {
        exposures.iter().try_for_each(check)?;
        let mut answer = Passes { by_exposure: vec![Vec::new(); exposures.len()], left_out: Vec::new() };
        answer.left_out.extend_from_slice(self.index.left_out());
        for group in groups(exposures) {
            let start = exposures[group[0]].start;
            let end_s = group.iter().map(|&one| end_s(start, &exposures[one])).fold(0.0, f64::max);
            let scene = self.scene(start, end_s, options.min_probability.is_some());
            for window in &scene.windows {
                answer.left_out.extend_from_slice(window.left_out());
            }
            let found: Vec<(usize, Vec<FieldPass>, Vec<LeftOut>)> = group
                .par_iter()
                .map_init(Vec::new, |seen, &one| {
                    let (passes, left_out) = self.expose(&scene, &exposures[one], field, options, seen)?;
                    Ok((one, passes, left_out))
                })
                .collect::<Result<_, SkyError>>()?;
            for (one, passes, left_out) in found {
                answer.by_exposure[one] = passes;
                answer.left_out.extend(left_out);
            }
        }
        answer.left_out.sort_by_key(|left_out| left_out.element_index);
        answer.left_out.dedup_by_key(|left_out| left_out.element_index);
        Ok(answer)
    }

    /// As [`Sky::field_passes`], without the cull: every satellite is asked of SGP4 for every slice. The authority that the
    /// cull is held against; thousands of times slower. It alone tells near misses of fields that are below the ground.
    ///
    /// # Errors
    /// As [`Sky::field_passes`].
    pub fn field_passes_by_brute_force(
        &self,
        exposures: &[Exposure],
        field: &Field,
        options: &PassOptions,
    ) -> Result<Vec<Vec<FieldPass>>, SkyError> {
        exposures.iter().try_for_each(check)?;
        exposures
            .par_iter()
            .map(|exposure| {
                let duration_s = end_s(exposure.start, exposure);
                let scene = self.scene_without_windows(exposure.start, duration_s);
                let flight = self.flight(&scene, exposure)?;
                let on_sky = field.on_sky(&exposure.pointing, exposure.rotation_rad);
                let mut passes: Vec<FieldPass> = (0..self.elements.len())
                    .filter(|&element_index| !self.is_observer(element_index))
                    .filter_map(|element_index| {
                        let run = Run::over(element_index, 0.0, duration_s);
                        self.pass(&scene, exposure, &on_sky, &run, flight.as_ref(), options).ok().flatten()
                    })
                    .collect();
                passes.sort_by(|a, b| a.enter.epoch.cmp(&b.enter.epoch).then(a.element_index.cmp(&b.element_index)));
                Ok(passes)
            })
            .collect()
    }

    /// The telescope's own arc over an exposure, and as long before and after it as late satellites are looked for; none for a site.
    pub(super) fn flight(&self, scene: &Scene, exposure: &Exposure) -> Result<Option<Shared<Arc>>, SkyError> {
        let Some(observer) = self.viewpoint.orbit() else { return Ok(None) };
        let failed = |reason| SkyError::Observer { observer: observer.name(), reason };
        let opened_s = seconds_between(scene.start, exposure.start);
        let orientation = scene.orientation.at_s(opened_s + 0.5 * exposure.duration_s);
        let minutes = observer.propagator().minutes_since_epoch(scene.start);
        Arc::new(
            observer.propagator(),
            minutes,
            opened_s - LONGEST_REACH_S,
            exposure.duration_s + 2.0 * LONGEST_REACH_S,
            &orientation.teme_to_gcrs,
        )
        .map(|arc| Some(Shared::new(arc)))
        .map_err(failed)
    }

    /// The observer near a moment.
    pub(super) fn motion(
        &self,
        scene: &Scene,
        orientation: &Orientation,
        flight: Option<&Shared<Arc>>,
        time_s: f64,
    ) -> Option<ObserverMotion> {
        let earth_velocity = scene.sun.at_s(time_s).earth_velocity;
        match &self.viewpoint {
            Viewpoint::Site(observer) => Some(ObserverMotion::of_site(observer, orientation, earth_velocity, time_s)),
            Viewpoint::Orbit(_) => Some(ObserverMotion::of_flight(flight?.clone(), earth_velocity)),
        }
    }

    /// True for the telescope's own elements, which it does not see.
    pub(super) fn is_observer(&self, element_index: usize) -> bool {
        let own = self.viewpoint.orbit().map(OrbitingObserver::norad_id);
        own == Some(self.elements[element_index].norad_id)
    }

    /// Sun and Earth alone.
    pub(super) fn scene_without_windows(&self, start: Epoch, span_s: f64) -> Scene {
        let end = seconds_after(start, span_s);
        let (orientation, sun) = self.almanac.over(start, end, &self.eop);
        Scene { start, orientation, sun, windows: Vec::new() }
    }

    pub(super) fn scene(&self, start: Epoch, span_s: f64, near_misses: bool) -> Scene {
        let mut scene = self.scene_without_windows(start, span_s);
        let end = seconds_after(start, span_s);
        scene.windows = if near_misses {
            let reach = |sigma: OrbitUncertainty| Reach {
                along_track_s: reach_s(sigma.along_track_s),
                cross_track_km: REACH_SIGMAS * sigma.cross_track_km,
            };
            self.windows_over(start, end, Wanted::NearMisses, reach)
        } else {
            self.windows.over(&self.index, start, end, Wanted::Crossings, &|_, _| Reach::default())
        };
        scene
    }

    /// Windows that want satellites as far from their predictions as their errors reach.
    pub(super) fn windows_over(
        &self,
        start: Epoch,
        end: Epoch,
        wanted: Wanted,
        reach: impl Fn(OrbitUncertainty) -> Reach + Sync,
    ) -> Vec<Shared<Window>> {
        let reach_of = |element_index: usize, ends: [Epoch; 2]| {
            // Errors grow away from the epoch: the end of the window that is farther from it has the larger ones.
            let [first, last] = ends.map(|epoch| {
                let age_days = seconds_between(self.elements[element_index].epoch, epoch) / DAY_S;
                self.uncertainty(element_index, age_days)
            });
            reach(OrbitUncertainty {
                along_track_s: first.along_track_s.max(last.along_track_s),
                cross_track_km: first.cross_track_km.max(last.cross_track_km),
            })
        };
        self.windows.over(&self.index, start, end, wanted, &reach_of)
    }
}

/// Refuses an exposure whose numbers are none, or that lies outside the years of the Sun's ephemeris.
pub(super) fn check(exposure: &Exposure) -> Result<(), SkyError> {
    let fail = |problem: String| Err(SkyError::Exposure { id: exposure.id.clone(), problem });
    if !(exposure.duration_s >= 0.0 && exposure.duration_s.is_finite()) {
        return fail(format!("a duration of {} s (allowed: 0 or more)", exposure.duration_s));
    }
    if !(exposure.pointing.vector().norm() - 1.0).abs().lt(&1e-6) || !exposure.rotation_rad.is_finite() {
        return fail("a pointing or rotation that is not a number".to_owned());
    }
    check_epoch(exposure.start)
}

/// Holds a moment against the years of the Sun's ephemeris.
pub(super) fn check_epoch(epoch: Epoch) -> Result<(), SkyError> {
    let (year, ..) = epoch.to_gregorian_utc();
    if year < YEARS.0 || year > YEARS.1 { Err(SkyError::NoEphemeris { epoch }) } else { Ok(()) }
}
