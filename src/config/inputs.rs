//! Input files of a configuration: element sets, synthetic constellations, Earth orientation and brightness models.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hifitime::Epoch;

use super::document::Config;
use super::error;
use super::required::SATELLITES;
use super::values::ModelSource;
use crate::elements::{
    Constellation, Deployment, DeploymentFile, Generation, Keep, ReadOptions, Satellites, SourceFile,
};
use crate::error::Error;
use crate::frames::EopTable;
use crate::geometry::ShadowModel;
use crate::input;
use crate::orbit::DragModel;
use crate::passes::{LearnedFile, ModelChoice};
use crate::photometry::{BrightnessModel, ModelLibrary, StandardMagnitudes};
use crate::schedule::evening_mjd;

/// Inputs of a configuration, read once. Skies for any time can be prepared from them; only the element sets of a
/// telescope in orbit are read again for each sky.
#[derive(Clone, Debug)]
pub struct LoadedInputs {
    pub(super) config: Config,
    pub(super) drag: DragModel,
    pub(super) shadow: ShadowModel,
    pub(super) eop: EopTable,
    pub(super) deployment: Deployment,
    /// Element sets of the request, and those of the periods that replace them, by their files.
    pub(super) catalogues: BTreeMap<Vec<PathBuf>, Satellites>,
    pub(super) choice: ModelChoice,
    /// Files with settings, as they were read.
    pub(super) settings_files: Vec<serde_json::Value>,
}

impl LoadedInputs {
    /// Returns the files of element sets that were read; empty if all satellites are synthetic.
    pub fn sources(&self) -> impl Iterator<Item = &SourceFile> {
        self.catalogues.values().flat_map(|catalogue| &catalogue.sources)
    }

    /// Returns the element sets of the night that begins on an evening; `None` if all satellites are synthetic.
    pub(super) fn catalogue_at(&self, evening_mjd: i64) -> Option<&Satellites> {
        self.catalogues.get(&self.config.elements_in(&self.deployment, evening_mjd))
    }

    /// Returns the first and the last epoch of the element sets if the files have several of an object, of which each
    /// sky uses the closest.
    pub fn epochs_of_choice(&self) -> Option<[Epoch; 2]> {
        let has_several = |catalogue: &&Satellites| {
            catalogue.element_sets.windows(2).any(|pair| pair[0].norad_id == pair[1].norad_id)
        };
        let epochs = || self.catalogues.values().filter(has_several).filter_map(Satellites::epochs);
        let (first, last) = (epochs().map(|(first, _)| first).min()?, epochs().map(|(_, last)| last).max()?);
        Some([first, last])
    }
}

impl Config {
    /// Reads all inputs for skies of many nights. All element sets of every object are kept.
    ///
    /// # Errors
    /// Neither element sets nor simulated constellations are given, or an input is invalid.
    pub fn load(&self) -> Result<LoadedInputs, Error> {
        self.load_with(Keep::All, None)
    }

    /// Reads all inputs; if `moment` is given, only the element sets of its night.
    pub(super) fn load_with(&self, keep: Keep, moment: Option<Epoch>) -> Result<LoadedInputs, Error> {
        let deployment = self.deployment()?;
        let mut lists = deployment.all_elements();
        lists.insert(self.elements.clone());
        if let (Some(moment), true) = (moment, lists.len() > 1) {
            let used = self.element_files_at(moment)?;
            for path in lists.iter().flatten().filter(|path| !used.contains(path)) {
                std::fs::metadata(path).map_err(|source| Error::cannot("read", path, source))?;
            }
            lists = BTreeSet::from([used]);
        }
        lists.retain(|files| !files.is_empty());
        if lists.is_empty() && deployment.is_empty() {
            return Err(SATELLITES.missing());
        }
        let catalogues = Satellites::read_lists(lists, &self.read_options(keep))?;
        let (drag, shadow, eop) = (self.drag()?, self.shadow()?, self.eop_table()?);
        let choice = self.model_choice()?;
        let (config, settings_files) = (self.clone(), self.settings_json());
        Ok(LoadedInputs { config, drag, shadow, eop, deployment, catalogues, choice, settings_files })
    }

    /// Returns the files of element sets of the night at a time: those of its periods of constellations that grow, or
    /// else those of the request.
    ///
    /// # Errors
    /// The site or a file of constellations is invalid.
    pub fn element_files_at(&self, moment: Epoch) -> Result<Vec<PathBuf>, Error> {
        let evening = evening_mjd(moment, self.viewpoint_longitude_rad(Some(moment))?);
        Ok(self.elements_in(&self.deployment()?, evening))
    }

    pub(super) fn elements_in(&self, deployment: &Deployment, evening_mjd: i64) -> Vec<PathBuf> {
        match deployment.elements_at(evening_mjd) {
            files if files.is_empty() => self.elements.clone(),
            files => files,
        }
    }

    /// Returns the files of element sets of all nights.
    ///
    /// # Errors
    /// A file of constellations is invalid.
    pub fn element_files(&self) -> Result<BTreeSet<PathBuf>, Error> {
        let of_periods = self.deployment()?.all_elements().into_iter().flatten();
        Ok(self.elements.iter().cloned().chain(of_periods).collect())
    }

    /// Returns the model of drag in SGP4. If omitted, satellites that hold their orbits by thrust have no drag.
    ///
    /// # Errors
    /// The model is unknown.
    pub fn drag(&self) -> Result<DragModel, Error> {
        let Some(name) = &self.drag else { return Ok(DragModel::default()) };
        DragModel::by_name(name).ok_or_else(|| Error::malformed("drag", name, "station-keeping, published"))
    }

    /// Returns the model of the Earth's shadow; with the atmosphere if omitted.
    ///
    /// # Errors
    /// The model is unknown.
    pub fn shadow(&self) -> Result<ShadowModel, Error> {
        let Some(name) = &self.shadow else { return Ok(ShadowModel::default()) };
        ShadowModel::by_name(name).ok_or_else(|| Error::malformed("shadow", name, "geometric, atmosphere"))
    }

    /// Returns the table of Earth orientation: from the given file, or else the bundled table of UT1 and polar motion.
    /// The provenance states which table is used.
    ///
    /// # Errors
    /// The file cannot be read or is invalid.
    pub fn eop_table(&self) -> Result<EopTable, Error> {
        match &self.eop {
            Some(path) => parse_file("Earth orientation", path, EopTable::from_finals2000a),
            None => Ok(EopTable::embedded()),
        }
    }

    /// Reads the files of element sets, with the set of each object closest to `moment`; `None` if no file is given.
    ///
    /// # Errors
    /// A file cannot be read or has no element sets.
    pub fn catalogue(&self, moment: Epoch) -> Result<Option<Satellites>, Error> {
        self.read_elements(&self.elements, Keep::Nearest(moment))
    }

    pub(super) fn read_elements(&self, files: &[PathBuf], keep: Keep) -> Result<Option<Satellites>, Error> {
        if files.is_empty() {
            return Ok(None);
        }
        Ok(Some(Satellites::read(files, &self.read_options(keep))?))
    }

    pub(super) fn read_options(&self, keep: Keep) -> ReadOptions {
        ReadOptions { accept_bad_checksums: self.accept_bad_checksums.unwrap_or(false), keep }
    }

    /// Returns the simulated constellations, and the files of element sets of periods, by night.
    ///
    /// # Errors
    /// A name is unknown, or a file is invalid.
    pub fn deployment(&self) -> Result<Deployment, Error> {
        let (mut bundled, mut files): (Vec<Constellation>, _) = (Vec::new(), Vec::new());
        for name in &self.shells {
            if name.is_file() {
                files.push(parse_file("shells", Path::new(&**name), |text| DeploymentFile::from_toml(text, name))?);
            } else {
                // A constellation and a set that contains it, or two such sets, have it once.
                for constellation in Constellation::by_name_or_set(name)? {
                    if !bundled.iter().any(|other| other.name == constellation.name) {
                        bundled.push(constellation);
                    }
                }
            }
        }
        Deployment::new(bundled, files)
    }

    /// Returns the bundled brightness models and those of the model files, by name.
    ///
    /// # Errors
    /// A file cannot be read or is invalid.
    pub fn model_library(&self) -> Result<ModelLibrary, Error> {
        let mut library = ModelLibrary::embedded();
        for path in self.models.iter().flat_map(|models| &models.files) {
            library.add_json(&read_text("model", path)?, &path.display().to_string())?;
        }
        Ok(library)
    }

    /// Returns the assignment of brightness models to satellites.
    ///
    /// # Errors
    /// Same as [`Config::model_library`]; a generation or model is unknown; the table of standard magnitudes is
    /// invalid; the learned file is invalid, or its offsets are relative to other models.
    pub fn model_choice(&self) -> Result<ModelChoice, Error> {
        let library = self.model_library()?;
        let mut choice = ModelChoice::new(&library)?;
        for (generation, model) in self.models.iter().flat_map(|models| &models.generations) {
            let generation = Generation::by_name(generation).ok_or_else(|| {
                Error::unknown("generation", generation, Generation::ALL.map(Generation::name).join(", "))
            })?;
            choice = choice.with_model(generation, library.find(model)?);
        }
        // A model for all satellites is set first, so that a model for one generation replaces it.
        let (for_all, by_kind): (Vec<_>, Vec<_>) = self.model.iter().partition(|assigned| assigned.kind.is_none());
        for assigned in for_all.into_iter().chain(by_kind) {
            let model = match &assigned.model {
                ModelSource::Name(name) => library.find(name)?,
                ModelSource::File(path) => {
                    let text = read_text("model", path)?;
                    Arc::new(BrightnessModel::from_json(&text, &path.display().to_string())?)
                }
            };
            choice = match assigned.kind {
                Some(kind) => choice.with_model(kind, model),
                None => choice.with_model_for_all(&model),
            };
        }
        let qs_mag = self.qs_mag.as_deref().or(self.models.as_ref().and_then(|models| models.qs_mag.as_deref()));
        if let Some(path) = qs_mag {
            let magnitudes = parse_file("standard magnitudes", path, StandardMagnitudes::from_qs_mag)?;
            choice = choice.with_standard_magnitudes(magnitudes);
        }
        // Learned offsets are checked against the models that are set above.
        if let Some(path) = &self.learned {
            choice = choice.with_learned(LearnedFile::read(path)?, &path.display().to_string())?;
        }
        Ok(choice)
    }
}

/// Reads and parses a text file. Errors begin with its purpose `what` and its path.
pub(super) fn parse_file<T>(
    what: &'static str,
    path: &Path,
    parse: impl FnOnce(&str) -> Result<T, Error>,
) -> Result<T, Error> {
    parse(&read_text(what, path)?).map_err(|error| error.in_file(what, path))
}

/// Reads a text file. `what` is its purpose, for errors.
pub(super) fn read_text(what: &'static str, path: &Path) -> Result<String, Error> {
    input::read_to_string(path).map_err(|source| error::unreadable(what, path, source))
}
