//! The skies of a setup's satellites: read once, made ready night by night, shared by all who ask.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use hifitime::{Epoch, Unit};
use pyo3::prelude::*;
use streakcast::config::{Config, ConfigError, LoadedInputs, PreparedSky};
use streakcast::frames::{mjd_utc, seconds_after};
use streakcast::output::{Section, write_json};

use crate::failure;
use crate::questions::start_of;

/// Nights that are kept ready.
const KEPT: usize = 3;

/// Satellites over a site, for any night.
#[pyclass(frozen, module = "streakcast._core", weakref)]
pub struct Skies {
    inputs: LoadedInputs,
    /// One moment for all questions, where the caller named one.
    epoch: Option<Epoch>,
    /// East longitude of the site, turns; 0 in orbit.
    longitude_turns: f64,
    site: Option<(String, f64, f64, f64)>,
    kept: Mutex<Vec<(i64, Arc<PreparedSky>)>>,
    /// Warnings of skies made since they were last asked for.
    news: Mutex<Vec<String>>,
}

impl Skies {
    /// The sky of the night that holds a moment.
    pub fn of(&self, moment: Epoch) -> PyResult<Arc<PreparedSky>> {
        self.prepared(moment).map_err(failure::setup)
    }

    /// The same, with the library's own error.
    pub fn prepared(&self, moment: Epoch) -> Result<Arc<PreparedSky>, ConfigError> {
        let night = self.night_of(moment);
        if let Some(prepared) = self.known(night) {
            return Ok(prepared);
        }
        // Made outside of the lock: a thread of the pool that waits for the others may take up another question, which would wait for this thread.
        let (first, last) = self.bounds(night);
        let prepared = self.made(first, last)?;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, other)) = kept.iter().find(|(known, _)| *known == night) {
            return Ok(other.clone());
        }
        kept.push((night, prepared.clone()));
        let surplus = kept.len().saturating_sub(KEPT);
        kept.drain(..surplus);
        Ok(prepared)
    }

    fn known(&self, night: i64) -> Option<Arc<PreparedSky>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| *known == night).map(|(_, prepared)| prepared.clone())
    }

    /// A sky for questions from one moment to another alone, as the command line makes it; that of the caller's one moment where there is one.
    pub fn over(&self, first: Epoch, last: Epoch) -> Result<Arc<PreparedSky>, ConfigError> {
        if self.epoch.is_some() { self.prepared(first) } else { self.made(first, last) }
    }

    fn made(&self, first: Epoch, last: Epoch) -> Result<Arc<PreparedSky>, ConfigError> {
        let prepared = Arc::new(self.inputs.prepare(first, last)?);
        let warnings = prepared.warnings.iter().map(|warning| failure::as_arguments(warning));
        self.news.lock().unwrap_or_else(PoisonError::into_inner).extend(warnings);
        Ok(prepared)
    }

    /// Nights go from noon to noon by the site's mean Sun; with a moment of the caller's own there is one only.
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
impl Skies {
    /// Reads what a setup (JSON) names.
    #[new]
    #[pyo3(signature = (setup, config=None, epoch=None))]
    fn new(py: Python<'_>, setup: &str, config: Option<&str>, epoch: Option<(f64, f64)>) -> PyResult<Self> {
        let epoch = epoch.map(|(jd1, jd2)| start_of(0, jd1, jd2)).transpose()?;
        failure::without_lock(py, || {
            let setup = setup_of(setup, config)?;
            let inputs = setup.load().map_err(failure::setup)?;
            // Elements of an orbit may be bad at any one time; a site is good or bad from the beginning.
            let orbit = setup.is_in_orbit();
            let site = if orbit { None } else { Some(setup.site().map_err(failure::setup)?) };
            Ok(Self {
                inputs,
                epoch,
                longitude_turns: site.as_ref().map_or(0.0, |site| site.longitude_rad / std::f64::consts::TAU),
                site: site.map(|site| {
                    (site.name, site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees(), site.height_m)
                }),
                kept: Mutex::default(),
                news: Mutex::default(),
            })
        })
    }

    /// Name, latitude and longitude (degrees), height (metres); `None` for a telescope in orbit.
    #[getter]
    fn site(&self) -> Option<(String, f64, f64, f64)> {
        self.site.clone()
    }

    /// Which night a moment belongs to: a number that grows by one from noon to noon.
    fn night(&self, jd1: f64, jd2: f64) -> PyResult<i64> {
        Ok(self.night_of(start_of(0, jd1, jd2)?))
    }

    /// What the answers of a night rest on, as JSON.
    fn provenance(&self, py: Python<'_>, jd1: f64, jd2: f64) -> PyResult<String> {
        let moment = start_of(0, jd1, jd2)?;
        failure::without_lock(py, || {
            let prepared = self.of(moment)?;
            let sections: &[Section<'_>] = &[];
            let mut text = Vec::new();
            write_json(&mut text, sections, &prepared.provenance).map_err(failure::asked)?;
            String::from_utf8(text).map_err(failure::asked)
        })
    }

    /// What the user should know of the skies made since this was last asked.
    fn news(&self) -> Vec<String> {
        std::mem::take(&mut self.news.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Names and SHA-256 of the files of elements, as read.
    fn element_files(&self) -> Vec<(String, String)> {
        self.inputs.sources().iter().map(|source| (source.name.to_string(), source.sha256.clone())).collect()
    }

    /// How many satellites a night's sky has.
    fn satellites(&self, py: Python<'_>, jd1: f64, jd2: f64) -> PyResult<usize> {
        let moment = start_of(0, jd1, jd2)?;
        failure::without_lock(py, || Ok(self.of(moment)?.sky.elements().len()))
    }
}

/// All files that a setup names.
#[pyfunction]
#[pyo3(signature = (setup, config=None))]
pub fn setup_files(setup: &str, config: Option<&str>) -> PyResult<Vec<PathBuf>> {
    let mut files: Vec<PathBuf> = setup_of(setup, config)?.files();
    files.extend(config.map(PathBuf::from));
    Ok(files)
}

/// A setup from JSON, over that of a configuration file where there is one.
pub fn setup_of(json: &str, config: Option<&str>) -> PyResult<Config> {
    let given: Config = serde_json::from_str(json).map_err(|error| {
        let text = error.to_string();
        // The place within JSON that nobody wrote says nothing.
        let end = text.find(" at line ").unwrap_or(text.len());
        failure::SetupError::new_err(text[..end].to_owned())
    })?;
    match config {
        Some(path) => Ok(given.over(Config::read(path.as_ref()).map_err(failure::setup)?)),
        None => Ok(given),
    }
}
