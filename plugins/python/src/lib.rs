//! Python face of streakcast. It translates: arrays to exposures, tables to columns, errors to exceptions; every answer is the library's.

use pyo3::prelude::*;

mod asked;
mod columns;
mod engine;
mod failure;
mod injection;
mod light;
mod plots;
mod pool;
mod questions;
mod skies;

/// What `streakcast` (the Python package) is built on; not for use by itself.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("StreakcastError", py.get_type::<failure::StreakcastError>())?;
    module.add("SetupError", py.get_type::<failure::SetupError>())?;
    module.add_class::<skies::Skies>()?;
    module.add_class::<engine::Engine>()?;
    module.add_function(wrap_pyfunction!(questions::times_from_text, module)?)?;
    module.add_function(wrap_pyfunction!(questions::times_from_mjd, module)?)?;
    module.add_function(wrap_pyfunction!(skies::setup_files, module)?)?;
    module.add_function(wrap_pyfunction!(injection::utc_text, module)?)?;
    module.add_function(wrap_pyfunction!(injection::inject, module)?)?;
    module.add_function(wrap_pyfunction!(asked::forecast, module)?)?;
    module.add_function(wrap_pyfunction!(asked::identify, module)?)?;
    module.add_function(wrap_pyfunction!(light::body_map, module)?)?;
    module.add_function(wrap_pyfunction!(light::sky_map, module)?)?;
    module.add_function(wrap_pyfunction!(light::standard_magnitudes, module)?)?;
    module.add_function(wrap_pyfunction!(light::sky_magnitudes, module)?)?;
    module.add_function(wrap_pyfunction!(light::model_names, module)?)?;
    module.add_class::<plots::Picture>()?;
    module.add_function(wrap_pyfunction!(plots::utc_mjd, module)?)?;
    module.add_function(wrap_pyfunction!(plots::draw, module)?)?;
    Ok(())
}
