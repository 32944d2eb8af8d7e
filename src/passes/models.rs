//! Choice of the brightness model of each satellite.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use super::learned::{LEARNED_ERRORS, LearnedFile};
use crate::elements::{ElementSet, Generation, GenerationTable, Origin};
use crate::error::Error;
use crate::photometry::{BrightObjects, BrightnessModel, ModelLibrary, StandardMagnitudes};

/// Mean motion below which an orbit is high: periods above 128 min, as usual in statistics of catalogues.
const HIGH_ORBIT_REV_DAY: f64 = 11.25;

/// Rule by which each element set gets a brightness model. The first of these that exists is used: the learned model of
/// the satellite, the model of its generation, the model of the built-in bright object, its standard magnitude in the
/// given table, the model of the built-in class of rocket bodies, the prior for rocket bodies, the prior for objects in
/// high orbits (periods above 128 min), the prior for any object.
#[derive(Clone, Debug)]
pub struct ModelChoice {
    by_generation: BTreeMap<Generation, Arc<BrightnessModel>>,
    /// The same models, whose source states that the kind is assumed.
    assumed: BTreeMap<Generation, Arc<BrightnessModel>>,
    standard_magnitudes: StandardMagnitudes,
    /// Models of the bright objects, by name.
    bright: BTreeMap<&'static str, Arc<BrightnessModel>>,
    rocket_body: Arc<BrightnessModel>,
    priors: Priors,
    learned: Learned,
}

/// Learned file, and the models that it corrects.
#[derive(Clone, Debug, Default)]
struct Learned {
    file: Option<Arc<LearnedFile>>,
    /// Models of the satellites in the file.
    satellites: HashMap<u32, (Generation, Arc<BrightnessModel>)>,
}

/// Returns the name of the default model of a generation; `None` if there is no default. Of several built-in models for
/// a generation, the default is the one with the best score on held-out photometry, if there is any
/// (`tests/fitting/default_models.rs`).
fn default_model(generation: Generation) -> Option<&'static str> {
    match generation {
        Generation::StarlinkV09 | Generation::StarlinkV10 => Some("starlink-v1.0"),
        Generation::StarlinkVisorSat => Some("visorsat-panels"),
        Generation::StarlinkV15 => Some("starlink-v1.5-facets"),
        Generation::StarlinkV2Mini => Some("v2mini-panels"),
        Generation::StarlinkDirectToCell => Some("direct-to-cell"),
        Generation::IridiumNext => Some("iridium-next"),
        Generation::OneWeb => Some("oneweb-panels"),
        Generation::Kuiper => Some("kuiper"),
        Generation::Qianfan => Some("qianfan"),
        Generation::Guowang => Some("guowang"),
        Generation::BlueBird => Some("bluebird"),
        Generation::Other => None,
    }
}

impl Default for ModelChoice {
    /// Returns the choice with the embedded models.
    fn default() -> Self {
        Self::new(&ModelLibrary::embedded()).expect("the embedded library has every default model, by a test below")
    }
}

impl ModelChoice {
    /// Creates the choice with the default models of a library.
    ///
    /// # Errors
    /// The library lacks one of them; the embedded library has all.
    pub fn new(library: &ModelLibrary) -> Result<Self, Error> {
        let mut by_generation = BTreeMap::new();
        for generation in Generation::ALL {
            if let Some(name) = default_model(generation) {
                by_generation.insert(generation, library.find(name)?);
            }
        }
        let assumed = by_generation.iter().map(|(kind, model)| (*kind, Arc::new(model.with_assumed_kind())));
        Ok(Self {
            assumed: assumed.collect(),
            by_generation,
            standard_magnitudes: StandardMagnitudes::default(),
            bright: BrightObjects::embedded().iter().map(|object| (object.name, Arc::new(object.model()))).collect(),
            rocket_body: library.find("rocket-body")?,
            priors: Priors { low_orbit: library.find("unknown")?, high_orbit: library.find("high-orbit")? },
            learned: Learned::default(),
        })
    }

    /// Applies a learned file to the magnitudes of its satellites and kinds, and to the errors along the track of its
    /// kinds. `origin` is the name of the file in errors. The models of these kinds must be set before.
    ///
    /// # Errors
    /// The model of a kind is not the one in the file.
    pub fn with_learned(mut self, file: LearnedFile, origin: &str) -> Result<Self, Error> {
        for (kind, magnitude) in
            file.kinds.iter().filter_map(|learned| Some((learned.kind, learned.magnitude.as_ref()?)))
        {
            let used = self.by_generation.get(&kind).cloned();
            let source = used.as_ref().map_or("none".to_owned(), |model| model.source().to_string());
            let Some(model) = used.filter(|_| source == magnitude.model) else {
                let learned = magnitude.model.clone();
                return Err(Error::format(format!(
                    "the offsets of {kind} are relative to the model {learned}, but its model is {source}"
                ))
                .allowing(format!("--model {kind}=MODEL with that model, or a file learned against {source}"))
                .in_file("learned file", origin));
            };
            let corrected = |model: &BrightnessModel, offset_mag, sigma_mag| {
                Arc::new(model.with_learned(offset_mag, sigma_mag, LEARNED_ERRORS))
            };
            for satellite in file.satellites.iter().filter(|satellite| satellite.kind == kind) {
                let own = corrected(&model, satellite.offset_mag, satellite.sigma_mag);
                self.learned.satellites.insert(satellite.norad_id, (kind, own));
            }
            for models in [&mut self.by_generation, &mut self.assumed] {
                if let Some(model) = models.get_mut(&kind) {
                    *model = corrected(model, magnitude.offset_mag, magnitude.sigma_mag);
                }
            }
        }
        self.learned.file = Some(Arc::new(file));
        Ok(self)
    }

    /// Returns the learned file that is applied.
    pub fn learned(&self) -> Option<&LearnedFile> {
        self.learned.file.as_deref()
    }

    /// Returns the learned factor of the error along the track of a satellite; 1 without one.
    pub fn lateness_factor(&self, elements: &ElementSet) -> f64 {
        self.learned().map_or(1.0, |file| file.lateness_factor(GenerationTable::embedded().generation(elements)))
    }

    /// Sets another model for one generation. A model for [`Generation::Other`] takes precedence over standard
    /// magnitudes and the priors for rocket bodies and unknown objects.
    pub fn with_model(mut self, generation: Generation, model: Arc<BrightnessModel>) -> Self {
        self.assumed.insert(generation, Arc::new(model.with_assumed_kind()));
        self.by_generation.insert(generation, model);
        self
    }

    /// Sets one model for all satellites, of any kind.
    pub fn with_model_for_all(mut self, model: &Arc<BrightnessModel>) -> Self {
        self.by_generation = Generation::ALL.map(|generation| (generation, model.clone())).into();
        // The kind does not matter.
        self.assumed.clone_from(&self.by_generation);
        self
    }

    /// Sets the standard magnitudes that are used for objects without a generation and without a built-in magnitude of
    /// their own.
    pub fn with_standard_magnitudes(mut self, standard_magnitudes: StandardMagnitudes) -> Self {
        self.standard_magnitudes = standard_magnitudes;
        self
    }

    /// Returns the objects of the table of standard magnitudes without a usable magnitude.
    pub(crate) fn magnitude_placeholders(&self) -> &[u32] {
        self.standard_magnitudes.placeholders()
    }

    /// Returns the model of a generation; `None` if it has none.
    pub fn of_kind(&self, generation: Generation) -> Option<&BrightnessModel> {
        self.by_generation.get(&generation).map(|model| &**model)
    }

    /// Returns the models of objects of unknown brightness.
    pub(super) fn priors(&self) -> &Priors {
        &self.priors
    }

    /// Returns true if the brightness of a satellite is unknown: it has no generation and no standard magnitude and is
    /// not a rocket body.
    pub fn is_unknown(&self, elements: &ElementSet) -> bool {
        let model = self.model_of(elements);
        Arc::ptr_eq(&model, self.priors.model(elements))
    }

    /// Returns the brightness model of one satellite.
    pub fn model_of(&self, elements: &ElementSet) -> Arc<BrightnessModel> {
        let table = GenerationTable::embedded();
        // The catalogue number of a simulated satellite may be that of a real one.
        if let Some((kind, model)) = self.learned.satellites.get(&elements.norad_id.0)
            && elements.origin != Origin::Synthetic
            && *kind == table.generation(elements)
        {
            return model.clone();
        }
        let models = if table.is_assumed(elements) { &self.assumed } else { &self.by_generation };
        if let Some(model) = models.get(&table.generation(elements)) {
            return model.clone();
        }
        let built_in = BrightObjects::embedded().get(elements.norad_id.0, &elements.name);
        // Magnitudes of classes are means over the list of which the user's table may be a newer version.
        let is_object = built_in.is_some_and(|object| object.norad_id.is_some());
        let listed = self.standard_magnitudes.get(elements.norad_id.0).filter(|_| !is_object);
        if let Some(half_lit) = listed {
            return Arc::new(BrightnessModel::from_standard_magnitude(half_lit));
        }
        if let Some(model) = built_in.and_then(|object| self.bright.get(object.name)) {
            return model.clone();
        }
        if is_rocket_body(&elements.name) { self.rocket_body.clone() } else { self.priors.model(elements).clone() }
    }
}

/// Models of objects of unknown brightness.
#[derive(Clone, Debug)]
pub(super) struct Priors {
    low_orbit: Arc<BrightnessModel>,
    high_orbit: Arc<BrightnessModel>,
}

impl Priors {
    /// Returns the model for an orbit.
    pub(super) fn model(&self, elements: &ElementSet) -> &Arc<BrightnessModel> {
        if elements.mean_motion_rev_day < HIGH_ORBIT_REV_DAY { &self.high_orbit } else { &self.low_orbit }
    }
}

/// Returns true for a rocket body, which catalogues mark as `R/B`, with or without a number or bracket around it.
fn is_rocket_body(name: &str) -> bool {
    name.split(|mark: char| mark.is_whitespace() || mark == '(' || mark == ')').any(|word| word == "R/B")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_rocket_bodies_by_name() {
        assert!(is_rocket_body("CZ-3B R/B") && is_rocket_body("ARIANE 5 R/B(1)") && is_rocket_body("SL-16 R/B"));
        assert!(!is_rocket_body("STARLINK-1007") && !is_rocket_body("ORB/BIT"));
    }

    #[test]
    fn verif_the_embedded_library_has_a_model_for_every_generation() {
        let library = ModelLibrary::embedded();
        let choice = ModelChoice::new(&library).expect("all usual models are shipped");
        assert_eq!(choice.by_generation.len(), Generation::ALL.len() - 1);
    }
}
