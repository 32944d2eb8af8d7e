//! Cache of prepared skies: element sets are read once, and prepared for each night.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use hifitime::{Epoch, Unit};
use pyo3::prelude::*;
use streakcast::Watch;
use streakcast::config::{Config, LoadedInputs, PreparedSky};
use streakcast::frames::{mjd_utc, seconds_after};
use streakcast::input::json_value_error;
use streakcast::output::{Section, write_json};

use crate::exposures::start_of;
use crate::failure;
use streakcast::Error;

/// Number of cached nights.
const CACHED_NIGHTS: usize = 3;

/// Satellites over a site, prepared for any night.
#[pyclass(frozen, module = "streakcast._core", weakref)]
pub struct SkyCache {
    inputs: LoadedInputs,
    /// Fixed epoch for all calls; `None` if the epoch depends on the night.
    epoch: Option<Epoch>,
    /// Longitude of the site, turns, east positive; 0 for a telescope in orbit.
    longitude_turns: f64,
    site: Option<(String, f64, f64, f64)>,
    cached: Mutex<Vec<(i64, Arc<PreparedSky>)>>,
    /// Warnings of skies prepared since the last call of `news`.
    news: Mutex<Vec<String>>,
}

impl SkyCache {
    /// Returns the sky of the night that contains a time. Its queries stop with the watch.
    pub fn sky_at(&self, moment: Epoch, watch: &Watch) -> PyResult<PreparedSky> {
        watch.check().map_err(failure::request)?;
        Ok(self.prepared(moment).map_err(failure::setup)?.watched(watch))
    }

    /// Returns the cached sky, with an error of the library instead of a Python exception.
    pub fn prepared(&self, moment: Epoch) -> Result<Arc<PreparedSky>, Error> {
        let night = self.night_of(moment);
        if let Some(prepared) = self.find_cached(night) {
            return Ok(prepared);
        }
        // The lock is not held while a sky is prepared: a waiting pool thread may start another request, which would
        // wait for the lock.
        let (first, last) = self.bounds(night);
        let prepared = self.prepare(first, last)?;
        let mut cached = self.cached.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, existing)) = cached.iter().find(|(other, _)| *other == night) {
            return Ok(existing.clone());
        }
        cached.push((night, prepared.clone()));
        let surplus = cached.len().saturating_sub(CACHED_NIGHTS);
        cached.drain(..surplus);
        Ok(prepared)
    }

    fn find_cached(&self, night: i64) -> Option<Arc<PreparedSky>> {
        let cached = self.cached.lock().unwrap_or_else(PoisonError::into_inner);
        cached.iter().find(|(other, _)| *other == night).map(|(_, prepared)| prepared.clone())
    }

    /// Returns the sky for a time span, prepared as on the command line; with a fixed epoch, the sky of that epoch. Its
    /// queries stop with the watch.
    pub fn over(&self, first: Epoch, last: Epoch, watch: &Watch) -> PyResult<PreparedSky> {
        watch.check().map_err(failure::request)?;
        Ok(self.prepared_over(first, last).map_err(failure::setup)?.watched(watch))
    }

    /// Returns the sky for a time span, with an error of the library instead of a Python exception.
    pub fn prepared_over(&self, first: Epoch, last: Epoch) -> Result<Arc<PreparedSky>, Error> {
        if self.epoch.is_some() { self.prepared(first) } else { self.prepare(first, last) }
    }

    fn prepare(&self, first: Epoch, last: Epoch) -> Result<Arc<PreparedSky>, Error> {
        let prepared = Arc::new(self.inputs.prepare(first, last)?);
        let warnings = prepared.warnings.iter().map(|warning| failure::as_arguments(warning));
        self.news.lock().unwrap_or_else(PoisonError::into_inner).extend(warnings);
        Ok(prepared)
    }

    /// Returns the number of the night, from noon to noon in mean solar time of the site; 0 with a fixed epoch.
    pub fn night_of(&self, moment: Epoch) -> i64 {
        if self.epoch.is_some() { 0 } else { (mjd_utc(moment) + self.longitude_turns - 0.5).floor() as i64 }
    }

    fn bounds(&self, night: i64) -> (Epoch, Epoch) {
        match self.epoch {
            Some(epoch) => (epoch, epoch),
            None => {
                let noon_days = night as f64 + 0.5 - self.longitude_turns;
                let first = Epoch::from_mjd_utc(noon_days);
                (first, seconds_after(first, Unit::Day.in_seconds()))
            }
        }
    }
}

#[pymethods]
impl SkyCache {
    /// Reads the files of a configuration document (JSON).
    #[new]
    #[pyo3(signature = (setup, config=None, epoch=None))]
    fn new(py: Python<'_>, setup: &str, config: Option<&str>, epoch: Option<(f64, f64)>) -> PyResult<Self> {
        let epoch = epoch.map(|(jd1, jd2)| start_of(0, jd1, jd2)).transpose()?;
        let (setup, config) = (setup.to_owned(), config.map(str::to_owned));
        failure::without_lock_or_watch(py, move || {
            let setup = setup_of(&setup, config.as_deref())?;
            let inputs = setup.load().map_err(failure::setup)?;
            // A site can be checked now. The orbit of a telescope may be invalid at certain times only.
            let orbit = setup.is_in_orbit();
            let site = if orbit { None } else { Some(setup.site().map_err(failure::setup)?) };
            Ok(Self {
                inputs,
                epoch,
                longitude_turns: site.as_ref().map_or(0.0, |site| site.longitude_rad / std::f64::consts::TAU),
                site: site.map(|site| {
                    (site.name, site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees(), site.height_m)
                }),
                cached: Mutex::default(),
                news: Mutex::default(),
            })
        })
    }

    /// Returns name, latitude and longitude (degrees), height (metres); `None` for a telescope in orbit.
    #[getter]
    fn site(&self) -> Option<(String, f64, f64, f64)> {
        self.site.clone()
    }

    /// Returns the number of the night that contains a time.
    fn night(&self, jd1: f64, jd2: f64) -> PyResult<i64> {
        Ok(self.night_of(start_of(0, jd1, jd2)?))
    }

    /// Returns the provenance of a night's results as JSON.
    fn provenance(&self, py: Python<'_>, jd1: f64, jd2: f64) -> PyResult<String> {
        let moment = start_of(0, jd1, jd2)?;
        failure::without_lock(py, |watch| {
            let prepared = self.sky_at(moment, watch)?;
            let sections: &[Section<'_>] = &[];
            let mut text = Vec::new();
            write_json(&mut text, sections, &prepared.provenance).map_err(failure::request)?;
            String::from_utf8(text).map_err(failure::request)
        })
    }

    /// Returns the warnings of skies prepared since the last call.
    fn news(&self) -> Vec<String> {
        std::mem::take(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns names and SHA-256 of the element files, as read.
    fn element_files(&self) -> Vec<(String, String)> {
        self.inputs.sources().map(|source| (source.name.to_string(), source.sha256.clone())).collect()
    }

    /// Returns the number of satellites prepared for a night.
    fn satellites(&self, py: Python<'_>, jd1: f64, jd2: f64) -> PyResult<usize> {
        let moment = start_of(0, jd1, jd2)?;
        failure::without_lock(py, |watch| Ok(self.sky_at(moment, watch)?.sky.elements().len()))
    }
}

/// Returns all files in a configuration document.
#[pyfunction]
#[pyo3(signature = (setup, config=None))]
pub fn setup_files(setup: &str, config: Option<&str>) -> PyResult<Vec<PathBuf>> {
    let setup = setup_of(setup, config)?;
    let mut files: BTreeSet<PathBuf> = setup.files().into_iter().chain(config.map(PathBuf::from)).collect();
    // Errors in a file of constellations are reported when it is loaded.
    files.extend(setup.element_files().unwrap_or_default());
    Ok(files.into_iter().collect())
}

/// Returns the keys that an earlier setup no longer needs if these are changed: those that answer the same questions.
#[pyfunction]
pub fn replaced_keys(changed: Vec<String>) -> Vec<&'static str> {
    let changed: Vec<&str> = changed.iter().map(String::as_str).collect();
    let answered = Config::QUESTIONS.iter().filter(|question| question.is_answered_by(&changed));
    answered.flat_map(|question| question.keys).copied().collect()
}

/// Parses a configuration document (JSON), with defaults from a configuration file if one is given.
pub fn setup_of(json: &str, config: Option<&str>) -> PyResult<Config> {
    let mut given: Config = serde_json::from_str(json).map_err(|error| failure::setup(json_value_error(&error)))?;
    match config {
        Some(path) => {
            given.run.file = Some(path.into());
            Ok(given.over(Config::read(path.as_ref()).map_err(failure::setup)?))
        }
        None => Ok(given),
    }
}
