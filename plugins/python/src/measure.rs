//! Measurement of the streaks of satellites in frames.

use hifitime::Epoch;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use streakcast::config::{Config, MeasureConfig, SkyOf};

use crate::columns::columns;
use crate::failure;
use crate::sky_cache::{SkyCache, setup_of};

/// Measures the frames in the request, or the streaks of its tables, which need no satellites. Returns `measurements`
/// as columns, `warnings` and `remarks`.
#[pyfunction]
#[pyo3(signature = (request, setup, config, sky_cache))]
pub fn measure<'py>(
    py: Python<'py>,
    request: &str,
    setup: &str,
    config: Option<&str>,
    sky_cache: Option<Py<SkyCache>>,
) -> PyResult<Bound<'py, PyDict>> {
    let measure: MeasureConfig = serde_json::from_str(request).map_err(failure::json)?;
    let setup: Config = setup_of(setup, config)?;
    let done = failure::without_lock(py, |watch| {
        let sky = sky_cache.as_ref().map(|sky_cache| move |moment: Epoch| sky_cache.get().prepared(moment));
        let sky = sky.as_ref().map(|sky| sky as SkyOf<'_>);
        measure.measure(&setup, sky, watch).map_err(failure::request)
    })?;
    let result = PyDict::new(py);
    result.set_item("measurements", columns(py, &done.table)?)?;
    result.set_item("warnings", failure::all_as_arguments(done.choices.iter().chain(&done.warnings)))?;
    result.set_item("remarks", failure::all_as_arguments(&done.remarks))?;
    Ok(result)
}
