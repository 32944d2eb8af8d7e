//! Masks of the streaks of satellites in files.

use hifitime::Epoch;
use numpy::{IntoPyArray, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use streakcast::config::{Config, MaskConfig, SkyOf};

use crate::columns::columns;
use crate::failure;
use crate::sky_cache::{SkyCache, setup_of};

/// Masks the file in the request. Returns `masks`, a dictionary of boolean arrays by the numbers of their HDUs,
/// `streaks` and `left_out` as columns, `summary`, `remarks` and `warnings`.
#[pyfunction]
pub fn mask<'py>(
    py: Python<'py>,
    request: &str,
    setup: &str,
    config: Option<&str>,
    sky_cache: Py<SkyCache>,
) -> PyResult<Bound<'py, PyDict>> {
    let request: MaskConfig = serde_json::from_str(request).map_err(failure::json)?;
    let setup: Config = setup_of(setup, config)?;
    let done = failure::without_lock(py, |watch| {
        let sky = |moment: Epoch| sky_cache.get().prepared(moment);
        request.mask(&setup, Some(&sky as SkyOf<'_>), &[], watch).map_err(failure::request)
    })?;
    let (result, masks) = (PyDict::new(py), PyDict::new(py));
    // The request has one frame.
    let masked = &done.frames[0];
    for (index, target) in masked.frame.chips.iter().enumerate() {
        let size = [target.chip.rows, target.chip.columns];
        let pixels = masked.mask.area(index).values(size, [false, true]);
        masks.set_item(target.chip.hdu, pixels.into_pyarray(py).reshape(size)?)?;
    }
    result.set_item("summary", &masked.summary)?;
    result.set_item("masks", masks)?;
    result.set_item("streaks", columns(py, &done.corridors())?)?;
    result.set_item("left_out", columns(py, &done.left_out())?)?;
    result.set_item("remarks", failure::all_as_arguments(&done.remarks))?;
    result.set_item("warnings", failure::all_as_arguments(done.choices.iter().chain(&done.warnings)))?;
    Ok(result)
}
