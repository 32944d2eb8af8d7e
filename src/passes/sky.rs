//! A catalogue of satellites seen by an observer at a site or by a telescope in orbit; all queries start from it.

use std::collections::BTreeMap;
use std::sync::Arc;

use hifitime::{Epoch, Unit};
use rayon::prelude::*;

use super::error;
use super::exposure::Exposure;
use super::measured::MeasuredPasses;
use super::models::{ModelChoice, Priors};
use super::predictability::PredictabilityCache;
use super::probability::REACH_SIGMAS;
use super::scene::{Almanac, Scene, WindowCache};
use super::track::ObserverMotion;
use super::viewpoint::{OrbitingObserver, Viewpoint};
use crate::elements::{ElementSet, Ephemeris, Satellites};
use crate::error::{Error, ErrorKind};
use crate::frames::{EopTable, Orientation, OrientationTable, seconds_after, seconds_between};
use crate::geometry::{Observer, ShadowModel, SunTable};
use crate::orbit::{
    DragModel, EphemerisCoverage, Lateness, LeftOut, MAX_WINDOW_S, MeanMotion, OrbitArc, OrbitClass, OrbitModel,
    OrbitUncertainty, Propagator, Reach, SatelliteIndex, SearchScope, TooOld, uncertainty,
};
use crate::photometry::BrightnessModel;
use crate::watch::Watch;

/// Time by which the arc of a telescope in orbit extends beyond both ends of an exposure, seconds: the margin of
/// delayed tracks.
const FLIGHT_MARGIN_S: f64 = 60.0;

/// Satellites, an observer and brightness models, from which all queries start.
///
/// Queries may be made from any thread. A clone shares the satellites and the caches, so cloning is fast.
#[derive(Clone, Debug)]
pub struct Sky {
    elements: Arc<Vec<ElementSet>>,
    others: Arc<OtherEpochs>,
    index: Arc<SatelliteIndex>,
    ephemerides: Arc<Vec<Arc<Ephemeris>>>,
    classes: Arc<Vec<OrbitClass>>,
    models: Arc<Vec<Arc<BrightnessModel>>>,
    /// Models of satellites of unknown brightness, by orbit.
    pub(super) priors: Priors,
    /// Measured magnitudes, which correct those of their passes.
    pub(super) measured: Arc<MeasuredPasses>,
    viewpoint: Viewpoint,
    drag: DragModel,
    shadow: ShadowModel,
    eop: EopTable,
    /// True if satellites are not left out for the age of their elements.
    of_any_age: bool,
    windows: Arc<WindowCache>,
    predictabilities: Arc<PredictabilityCache>,
    almanac: Arc<Almanac>,
    watch: Watch,
}

/// Element sets of other epochs than those in use, from which mean motions are computed.
#[derive(Clone, Debug)]
struct OtherEpochs {
    /// Sorted by catalogue number.
    sets: Vec<ElementSet>,
    /// Time at which the predictions are best.
    moment: Epoch,
}

impl OtherEpochs {
    fn new(mut sets: Vec<ElementSet>, moment: Epoch) -> Self {
        sets.sort_by_key(|set| set.norad_id);
        Self { sets, moment }
    }

    /// Returns the propagators and classes of a catalogue.
    fn orbits_of(&self, elements: &[ElementSet], drag: DragModel) -> Orbits {
        if self.sets.is_empty() {
            // One by one, because planned constellations have millions of satellites.
            let of = |set| initialised(OrbitModel::from_sets(set, &[], self.moment, drag));
            return elements.par_iter().map(of).unzip();
        }
        let models = OrbitModel::of_catalogue(elements, &self.sets, self.moment, drag);
        models.into_par_iter().map(initialised).unzip()
    }
}

impl Sky {
    /// Creates a sky from satellites and an observer, with the embedded brightness models and Earth orientation table.
    ///
    /// This takes about 2 µs of processor time per satellite. The model of the Earth's shadow includes the atmosphere.
    pub fn new(satellites: Satellites, viewpoint: impl Into<Viewpoint>) -> Self {
        let Satellites { element_sets, other_epochs, ephemerides, selected_for, .. } = satellites;
        let others = OtherEpochs::new(other_epochs, selected_for.unwrap_or_default());
        let (eop, choice) = (EopTable::embedded(), ModelChoice::default());
        Self::from_parts(element_sets, others, DragModel::default(), viewpoint.into(), eop, &choice)
            .with_ephemerides(ephemerides)
    }

    /// Creates a sky like [`Sky::new`] does, but with the given brightness models and Earth orientation table, and
    /// without ephemerides.
    pub fn with_models(
        elements: Vec<ElementSet>,
        viewpoint: impl Into<Viewpoint>,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let others = OtherEpochs::new(Vec::new(), Epoch::default());
        Self::from_parts(elements, others, DragModel::default(), viewpoint.into(), eop, choice)
    }

    /// As [`Sky::with_models`], with a treatment of atmospheric drag, and with element sets of other epochs of the same
    /// satellites, in any order, which improve the mean motions of Starlinks near the time `moment` ([`OrbitModel`]).
    #[doc(hidden)]
    pub fn with_models_and_others(
        elements: Vec<ElementSet>,
        (others, moment): (Vec<ElementSet>, Epoch),
        drag: DragModel,
        viewpoint: impl Into<Viewpoint>,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        Self::from_parts(elements, OtherEpochs::new(others, moment), drag, viewpoint.into(), eop, choice)
    }

    /// As [`Sky::with_models`], with given orbits, one for each element set. They are those of a larger catalogue, from
    /// which this sky has a part.
    #[doc(hidden)]
    pub fn with_orbits(
        elements: Vec<ElementSet>,
        orbits: Vec<OrbitModel>,
        viewpoint: impl Into<Viewpoint>,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let others = OtherEpochs::new(Vec::new(), Epoch::default());
        let orbits = orbits.into_par_iter().map(initialised).unzip();
        Self::from_orbits(elements, (others, orbits), DragModel::default(), viewpoint.into(), eop, choice)
    }

    fn from_parts(
        elements: Vec<ElementSet>,
        others: OtherEpochs,
        drag: DragModel,
        viewpoint: Viewpoint,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let orbits = others.orbits_of(&elements, drag);
        Self::from_orbits(elements, (others, orbits), drag, viewpoint, eop, choice)
    }

    fn from_orbits(
        elements: Vec<ElementSet>,
        (others, orbits): (OtherEpochs, Orbits),
        drag: DragModel,
        viewpoint: Viewpoint,
        eop: EopTable,
        choice: &ModelChoice,
    ) -> Self {
        let factors = elements.iter().map(|set| choice.lateness_factor(set)).collect::<Vec<_>>();
        let (index, classes) = indexed(&elements, orbits, drag, |index| factors[index]);
        let models: Vec<_> = elements.iter().map(|elements| choice.model_of(elements)).collect();
        Self {
            elements: Arc::new(elements),
            others: Arc::new(others),
            index: Arc::new(index),
            ephemerides: Arc::default(),
            classes: Arc::new(classes),
            models: Arc::new(models),
            priors: choice.priors().clone(),
            measured: Arc::default(),
            viewpoint,
            drag,
            shadow: ShadowModel::default(),
            eop,
            of_any_age: false,
            windows: Arc::default(),
            predictabilities: Arc::default(),
            almanac: Arc::default(),
            watch: Watch::default(),
        }
    }

    /// Returns a sky with the same satellites for another observer, without measured magnitudes. Both skies share their
    /// caches.
    pub fn seen_from(&self, viewpoint: impl Into<Viewpoint>) -> Self {
        Self { viewpoint: viewpoint.into(), measured: Arc::default(), ..self.clone() }
    }

    /// Returns the sky with a changed description of the same observer.
    pub(super) fn seen_by_same(self, observer: OrbitingObserver) -> Self {
        Self { viewpoint: observer.into(), predictabilities: Arc::default(), ..self }
    }

    /// Returns a sky with the same satellites and observer whose queries stop after [`Watch::stop`], with an error
    /// of the kind [`Cancelled`](crate::ErrorKind::Cancelled). Both skies share their caches.
    pub fn watched(&self, watch: &Watch) -> Self {
        Self { watch: watch.clone(), ..self.clone() }
    }

    /// Returns the handle that stops the queries of this sky. Functions that use its results in long loops test it.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    /// Returns the sky with another model of the Earth's shadow.
    pub fn with_shadow(self, shadow: ShadowModel) -> Self {
        Self { shadow, ..self }
    }

    /// Returns the sky with another treatment of atmospheric drag. Satellites whose treatment changes are initialised
    /// again.
    #[doc(hidden)]
    pub fn with_drag(self, drag: DragModel) -> Self {
        if drag == self.drag {
            return self;
        }
        Self { drag, ..self }.with_new_orbits()
    }

    fn with_new_orbits(self) -> Self {
        let factor = |index: usize| self.classes[index].lateness_factor;
        let orbits = self.others.orbits_of(&self.elements, self.drag);
        let (index, classes) = indexed(&self.elements, orbits, self.drag, factor);
        Self {
            index: Arc::new(index.with_ephemerides(&self.elements, &self.ephemerides, &self.eop)),
            classes: Arc::new(classes),
            windows: Arc::default(),
            predictabilities: Arc::default(),
            ..self
        }
    }

    /// Returns the number of satellites by the source of their mean motion.
    #[doc(hidden)]
    pub fn mean_motions(&self) -> BTreeMap<MeanMotion, usize> {
        let mut counts = BTreeMap::new();
        for class in &*self.classes {
            *counts.entry(class.mean_motion()).or_default() += 1;
        }
        counts
    }

    /// Returns the uncertainty that a prediction would have with one element set of the satellite.
    pub(crate) fn uncertainty_of_one_set(&self, element_index: usize, age_days: f64) -> OrbitUncertainty {
        let alone = OrbitClass::from_elements(&self.elements[element_index], self.drag);
        uncertainty(alone.with_lateness_factor(self.classes[element_index].lateness_factor), age_days)
    }

    /// Returns the sky with ephemerides. They are used for the exposures that they cover; SGP4 is used for all others.
    ///
    /// An ephemeris of a satellite without an element set is ignored, because the element set determines the class and
    /// the brightness model of a satellite.
    pub fn with_ephemerides(self, ephemerides: Vec<Arc<Ephemeris>>) -> Self {
        if ephemerides.is_empty() && self.ephemerides.is_empty() {
            return self;
        }
        Self { ephemerides: Arc::new(ephemerides), ..self }.with_new_orbits()
    }

    /// Returns the sky with all satellites, whatever the age of their elements. By default, satellites whose position
    /// along the orbit is unknown ([`OrbitClass::is_known`]) are left out of all results.
    ///
    /// Statistics of many satellites, and comparisons with measured positions, do not need the position along the
    /// orbit.
    pub fn with_elements_of_any_age(self) -> Self {
        Self { of_any_age: true, windows: Arc::default(), predictabilities: Arc::default(), ..self }
    }

    /// Returns the satellites with ephemerides, by the index of their element sets, and the part of the time between
    /// two epochs for which the ephemerides are used.
    pub(crate) fn ephemeris_coverage(
        &self,
        first: Epoch,
        last: Epoch,
    ) -> impl Iterator<Item = (usize, EphemerisCoverage)> + '_ {
        self.index.ephemeris_coverage([first, last])
    }

    /// Returns the satellites with ephemerides of one message that contradict each other, by the index of their element
    /// sets; see
    /// [`SatelliteIndex::contradictory_ephemerides`](crate::orbit::SatelliteIndex::contradictory_ephemerides).
    pub(crate) fn contradictory_ephemerides(&self) -> &[usize] {
        self.index.contradictory_ephemerides()
    }

    /// Returns the treatment of atmospheric drag in SGP4.
    #[doc(hidden)]
    pub fn drag(&self) -> DragModel {
        self.drag
    }

    /// Returns the element sets of the catalogue; [`Pass::element_index`](super::Pass::element_index) is an index into
    /// them.
    pub fn elements(&self) -> &[ElementSet] {
        &self.elements
    }

    /// Returns the model of the Earth's shadow.
    pub fn shadow(&self) -> ShadowModel {
        self.shadow
    }

    /// Returns the observer: a site or a telescope in orbit.
    pub fn viewpoint(&self) -> &Viewpoint {
        &self.viewpoint
    }

    /// Returns the brightness model of an element set.
    ///
    /// # Panics
    /// If the catalogue has no element set of this index.
    pub fn model(&self, element_index: usize) -> &BrightnessModel {
        &self.models[element_index]
    }

    /// Returns the satellites whose elements SGP4 cannot initialise.
    pub fn left_out(&self) -> &[LeftOut] {
        self.index.left_out()
    }

    /// Returns the table of the Earth's orientation from `start` to `end` that all queries of this sky use.
    pub fn orientation_over(&self, start: Epoch, end: Epoch) -> OrientationTable {
        self.almanac.over(start, end, &self.eop).0
    }

    /// Returns the tables of Earth orientation and Sun from `start` to `end`. Both count seconds from `start`.
    pub(super) fn almanac_over(&self, start: Epoch, end: Epoch) -> (OrientationTable, SunTable) {
        self.almanac.over(start, end, &self.eop)
    }

    /// Returns the uncertainty (one sigma) of a satellite's predicted position when its elements have this age.
    #[doc(hidden)]
    pub fn uncertainty(&self, element_index: usize, age_days: f64) -> OrbitUncertainty {
        uncertainty(self.classes[element_index], age_days)
    }

    /// Returns true if the position of a satellite is known when its elements have this age ([`OrbitClass::is_known`]).
    pub fn is_known(&self, element_index: usize, age_days: f64) -> bool {
        self.of_any_age || self.classes[element_index].is_known(age_days)
    }

    /// Returns the reason why an element set does not determine a position at a time; `None` if it does.
    pub(super) fn too_old(&self, element_index: usize, epoch: Epoch) -> Option<Error> {
        let age_days = self.element_age_days(element_index, epoch);
        (!self.is_known(element_index, age_days)).then(|| {
            Error::caused(
                ErrorKind::UnknownPosition,
                TooOld { norad_id: self.elements[element_index].norad_id, age_days },
            )
        })
    }

    /// Returns the days from the epoch of an element set to a time, leap seconds not counted; negative if the elements
    /// are newer.
    pub(crate) fn element_age_days(&self, element_index: usize, epoch: Epoch) -> f64 {
        (epoch.to_utc_duration() - self.elements[element_index].epoch.to_utc_duration()).to_unit(Unit::Day)
    }

    /// Returns the uncertainty (one sigma) of a satellite's predicted position at a time.
    pub(super) fn uncertainty_at(&self, element_index: usize, epoch: Epoch) -> OrbitUncertainty {
        self.uncertainty(element_index, self.element_age_days(element_index, epoch))
    }

    /// Returns the propagator of a satellite between two times, in seconds after `start`: its ephemeris if that covers
    /// both times, otherwise SGP4.
    pub(super) fn propagator_over(
        &self,
        start: Epoch,
        element_index: usize,
        [from_s, to_s]: [f64; 2],
    ) -> Option<&Propagator> {
        // The search prepares ephemerides only for exposures up to this length.
        if !self.index.has_ephemerides() || to_s - from_s > MAX_WINDOW_S {
            return self.index.propagator(element_index);
        }
        self.index.propagator_over(element_index, [from_s, to_s].map(|time_s| seconds_after(start, time_s)))
    }

    /// Returns the uncertainty (one sigma) of the prediction by a propagator of this satellite.
    pub(super) fn uncertainty_of(
        &self,
        element_index: usize,
        propagator: &Propagator,
        epoch: Epoch,
    ) -> OrbitUncertainty {
        propagator.stated_uncertainty(epoch).unwrap_or_else(|| self.uncertainty_at(element_index, epoch))
    }

    /// Returns the observer at a site, for queries that require a horizon.
    pub(super) fn site_observer(&self) -> Result<&Observer, Error> {
        self.viewpoint.required_site()
    }

    pub(super) fn predictabilities(&self) -> &PredictabilityCache {
        &self.predictabilities
    }

    pub(super) fn index(&self) -> &SatelliteIndex {
        &self.index
    }

    /// Returns an entry for the list of satellites without a position.
    pub(super) fn failed(&self, element_index: usize, reason: Error) -> LeftOut {
        LeftOut { norad_id: self.elements[element_index].norad_id, element_index, reason }
    }

    /// Returns true for the element set of the observing telescope itself, which is never searched for.
    pub(super) fn is_observer(&self, element_index: usize) -> bool {
        self.viewpoint.orbit().is_some_and(|observer| observer.is(&self.elements[element_index]))
    }

    /// Returns the orbital arc of a telescope in orbit during an exposure, extended on both sides by the margin of
    /// tracks. `None` for a site.
    pub(super) fn flight(&self, scene: &Scene, exposure: &Exposure) -> Result<Option<Arc<OrbitArc>>, Error> {
        let Some(observer) = self.viewpoint.orbit() else { return Ok(None) };
        let failed = |reason| error::no_observer(&observer.name(), &reason);
        let opened_s = seconds_between(scene.start, exposure.start);
        let orientation = scene.orientation.at_s(opened_s + 0.5 * exposure.duration_s);
        let interval = [exposure.start, seconds_after(exposure.start, exposure.duration_s)];
        let arc = observer.orbit().arc(scene.start, interval, FLIGHT_MARGIN_S, &orientation.teme_to_gcrs);
        arc.map(|arc| Some(Arc::new(arc))).map_err(failed)
    }

    /// Returns the motion of the observer near a time.
    pub(super) fn motion(
        &self,
        scene: &Scene,
        orientation: &Orientation,
        flight: Option<&Arc<OrbitArc>>,
        time_s: f64,
    ) -> Option<ObserverMotion> {
        let earth_velocity = scene.sun.at_s(time_s).earth_velocity;
        match &self.viewpoint {
            Viewpoint::Site(observer) => Some(ObserverMotion::of_site(observer, orientation, earth_velocity, time_s)),
            Viewpoint::Orbit(_) => Some(ObserverMotion::of_flight(flight?.clone(), earth_velocity)),
        }
    }

    /// Returns a scene with Sun and Earth orientation but without search windows.
    pub(super) fn scene_without_windows(&self, start: Epoch, span_s: f64) -> Scene {
        let end = seconds_after(start, span_s);
        let (orientation, sun) = self.almanac.over(start, end, &self.eop);
        Scene { start, orientation, sun, windows: Vec::new(), scope: SearchScope::Nominal }
    }

    /// Returns a scene with Sun, Earth orientation and search windows.
    pub(super) fn scene(&self, start: Epoch, span_s: f64, scope: SearchScope) -> Result<Scene, Error> {
        let reach = |element_index: usize, ends: [Epoch; 2]| {
            let class = &self.classes[element_index];
            let ages_days = ends.map(|epoch| self.element_age_days(element_index, epoch));
            let age_days = ages_days[0].abs().max(ages_days[1].abs());
            let (stated_s, stated_km) = self.index.largest_stated_errors(element_index);
            let stated = Lateness::gaussian(stated_s);
            Reach {
                along_track_s: class.largest_reach_s(ages_days).max(stated.reach_s()),
                cross_track_km: REACH_SIGMAS * class.cross_track_km(age_days).max(stated_km),
            }
        };
        let unknown = |element_index: usize, middle: Epoch| self.too_old(element_index, middle);
        let end = seconds_after(start, span_s);
        let windows = self.windows.over(&self.index, [start, end], &unknown, &reach, &self.watch)?;
        Ok(Scene { windows, scope, ..self.scene_without_windows(start, span_s) })
    }
}

/// Propagators of the satellites of a catalogue, or the reasons why they have none, and classes.
type Orbits = (Vec<Result<Propagator, Error>>, Vec<OrbitClass>);

fn initialised(model: OrbitModel) -> (Result<Propagator, Error>, OrbitClass) {
    (Propagator::new(&model.elements), model.class)
}

/// Returns the propagators and classes of satellites; `factor` gives the factor of the lateness of each.
fn indexed(
    elements: &[ElementSet],
    (made, classes): Orbits,
    drag: DragModel,
    factor: impl Fn(usize) -> f64,
) -> (SatelliteIndex, Vec<OrbitClass>) {
    let classes = classes.into_iter().enumerate().map(|(index, class)| class.with_lateness_factor(factor(index)));
    (SatelliteIndex::of_propagators(elements, made, drag), classes.collect())
}
