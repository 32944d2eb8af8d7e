//! Python bindings: arrays are converted to exposures, tables to columns, and errors to exceptions.

use pyo3::prelude::*;

mod annotation;
mod columns;
mod engine;
mod exposures;
mod failure;
#[cfg(unix)]
mod frames;
#[cfg(unix)]
mod injection;
mod learn;
mod light;
#[cfg(unix)]
mod mask;
#[cfg(unix)]
mod measure;
mod plots;
mod pool;
mod requests;
mod sky_cache;

/// Private extension module of the Python package `streakcast`.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("StreakcastError", py.get_type::<failure::StreakcastError>())?;
    module.add("SetupError", py.get_type::<failure::SetupError>())?;
    module.add("UnknownPositionsError", py.get_type::<failure::UnknownPositionsError>())?;
    module.add_class::<sky_cache::SkyCache>()?;
    module.add_class::<engine::Engine>()?;
    module.add_function(wrap_pyfunction!(exposures::times_from_text, module)?)?;
    module.add_function(wrap_pyfunction!(exposures::times_from_mjd, module)?)?;
    module.add_function(wrap_pyfunction!(sky_cache::setup_files, module)?)?;
    module.add_function(wrap_pyfunction!(sky_cache::replaced_keys, module)?)?;
    module.add_function(wrap_pyfunction!(exposures::utc_text, module)?)?;
    module.add_function(wrap_pyfunction!(exposures::out_of_range, module)?)?;
    // Frames require CFITSIO, which cannot be built on Windows.
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(frames::write_frame, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(frames::read_rows, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(frames::sky_of_pixels, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(injection::inject, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(mask::mask, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(measure::measure, module)?)?;
    module.add_function(wrap_pyfunction!(requests::forecast, module)?)?;
    module.add_function(wrap_pyfunction!(requests::ephemeris, module)?)?;
    module.add_function(wrap_pyfunction!(requests::identify, module)?)?;
    #[cfg(unix)]
    module.add_function(wrap_pyfunction!(requests::identify_streaks, module)?)?;
    module.add_function(wrap_pyfunction!(learn::learn, module)?)?;
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
