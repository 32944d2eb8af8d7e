//! Injection of streaks into files.

use std::path::PathBuf;

use hifitime::Epoch;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use streakcast::config::{Config, InjectionConfig, SkyOf, inject_frames};
use streakcast::streaks::Injections;

use crate::columns::columns;
use crate::failure;
use crate::sky_cache::{SkyCache, setup_of};

/// Adds streaks to the file in the request, and writes the result to `output`. Returns `summary`, `truth`, `points`,
/// `trails`, `bits`, `labels` (names and texts of files), `remarks` and `warnings`.
#[pyfunction]
pub fn inject<'py>(
    py: Python<'py>,
    request: &str,
    setup: &str,
    config: Option<&str>,
    sky_cache: Option<Py<SkyCache>>,
    output: PathBuf,
) -> PyResult<Bound<'py, PyDict>> {
    let injection: InjectionConfig = serde_json::from_str(request).map_err(failure::json)?;
    let setup: Config = setup_of(setup, config)?;
    let injections = failure::without_lock(py, |watch| {
        let sky = sky_cache.as_ref().map(|sky_cache| move |moment: Epoch| sky_cache.get().prepared(moment));
        let sky = sky.as_ref().map(|sky| sky as SkyOf<'_>);
        inject_frames(&injection, &setup, sky, &[output], watch).map_err(failure::request)
    })?;
    result_of(py, &injections)
}

fn result_of<'py>(py: Python<'py>, injections: &Injections) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    let mut warnings = failure::all_as_arguments(injections.choices.iter().chain(&injections.warnings));
    for frame in &injections.frames {
        result.set_item("summary", &frame.summary)?;
        result.set_item("truth", columns(py, &frame.truth)?)?;
        result.set_item("points", columns(py, &frame.points)?)?;
        result.set_item("trails", columns(py, &frame.trails)?)?;
        result.set_item("bits", (frame.planes.streak_bit, frame.planes.injected_bit))?;
        warnings.extend(failure::all_as_arguments(&frame.warnings));
    }
    let labels = injections.labels.iter().map(|file| {
        let name = file.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (name, file.text.clone())
    });
    result.set_item("labels", labels.collect::<Vec<_>>())?;
    result.set_item("remarks", failure::all_as_arguments(&injections.remarks))?;
    result.set_item("warnings", warnings)?;
    Ok(result)
}
