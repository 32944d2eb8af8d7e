//! Magnitudes and maps of brightness models, without satellites.

use std::sync::Arc;

use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyList;
use rayon::prelude::*;
use streakcast::config::Config;
use streakcast::maps::{BodyView, Earth, Fact, Grid, SkyView};
use streakcast::output::Provenance;
use streakcast::photometry::{BrightnessModel, PhotometryOptions};

use crate::columns::columns;
use crate::exposures::{Column, within};
use crate::failure;
use crate::sky_cache::setup_of;

/// Columns of a map and its metadata as JSON.
type Map<'py> = (Bound<'py, PyList>, String);

/// Inputs common to all photometry functions.
struct Inputs {
    setup: Config,
    model: Arc<BrightnessModel>,
    options: PhotometryOptions,
}

fn inputs(setup: &str, model: &str) -> PyResult<Inputs> {
    let setup = setup_of(setup, None)?;
    let mut library = setup.model_library().map_err(failure::setup)?;
    let name = if model.ends_with(".json") {
        let text = std::fs::read_to_string(model)
            .map_err(|error| failure::SetupError::new_err(format!("model {model}: {error}")))?;
        library.add_json(&text, model).map_err(failure::setup)?
    } else {
        model.to_owned()
    };
    let found = library.get(&name).ok_or_else(|| {
        let names = library.names().collect::<Vec<_>>().join(", ");
        failure::SetupError::new_err(format!("unknown model '{name}'; allowed: {names}"))
    })?;
    let options = setup.photometry().map_err(failure::setup)?;
    Ok(Inputs { setup, model: found, options })
}

fn grid(step_deg: Option<f64>, nside: Option<u32>) -> PyResult<Grid> {
    match (step_deg, nside) {
        (Some(_), Some(_)) => Err(PyValueError::new_err("step and nside exclude each other; specify one of them")),
        (Some(step), None) => Grid::regular(step).map_err(failure::request),
        (None, Some(nside)) => Grid::healpix(nside).map_err(failure::request),
        (None, None) => Grid::regular(streakcast::maps::DEFAULT_STEP_DEG).map_err(failure::request),
    }
}

fn facts_json(facts: &[Fact]) -> PyResult<String> {
    let mut provenance = Provenance::new();
    facts.iter().for_each(|fact| fact.state(&mut provenance));
    serde_json::to_string(&provenance).map_err(failure::request)
}

/// Returns the names of the bundled models and of those in the setup's files.
#[pyfunction]
pub fn model_names(setup: &str) -> PyResult<Vec<String>> {
    let library = setup_of(setup, None)?.model_library().map_err(failure::setup)?;
    Ok(library.names().map(str::to_owned).collect())
}

/// Returns standard magnitudes over all directions of a satellite's body frame.
#[pyfunction]
#[pyo3(signature = (setup, model, sun_latitude_deg, height_km, step_deg=None, nside=None))]
pub fn body_map<'py>(
    py: Python<'py>,
    setup: &str,
    model: &str,
    sun_latitude_deg: f64,
    height_km: f64,
    step_deg: Option<f64>,
    nside: Option<u32>,
) -> PyResult<Map<'py>> {
    let (table, facts) = failure::without_lock(py, |watch| {
        let Inputs { model, options, .. } = inputs(setup, model)?;
        let view =
            BodyView::new(&model, sun_latitude_deg.to_radians(), height_km, options).map_err(failure::request)?;
        let map = view.watched(watch).map(grid(step_deg, nside)?).map_err(failure::request)?;
        Ok((map.table(), facts_json(&map.facts)?))
    })?;
    Ok((columns(py, &table)?, facts))
}

/// Returns apparent magnitudes over the sky of a site.
#[pyfunction]
#[pyo3(signature = (setup, model, sun_altitude_deg, sun_azimuth_deg, height_km, step_deg=None, nside=None))]
pub fn sky_map<'py>(
    py: Python<'py>,
    setup: &str,
    model: &str,
    sun_altitude_deg: f64,
    sun_azimuth_deg: f64,
    height_km: f64,
    step_deg: Option<f64>,
    nside: Option<u32>,
) -> PyResult<Map<'py>> {
    let (table, facts) = failure::without_lock(py, |watch| {
        let inputs = inputs(setup, model)?;
        let view = sky_view(&inputs, sun_altitude_deg, sun_azimuth_deg, height_km)?.watched(watch);
        let map = view.map(grid(step_deg, nside)?).map_err(failure::request)?;
        Ok((map.table(), facts_json(&map.facts)?))
    })?;
    Ok((columns(py, &table)?, facts))
}

fn sky_view(inputs: &Inputs, sun_altitude_deg: f64, sun_azimuth_deg: f64, height_km: f64) -> PyResult<SkyView<'_>> {
    let setup = &inputs.setup;
    let is_given = setup.site.is_given();
    let earth = if is_given { Earth::Ellipsoid(setup.site().map_err(failure::setup)?) } else { Earth::Sphere };
    let (azimuth, altitude) = (sun_azimuth_deg.to_radians(), sun_altitude_deg.to_radians());
    let view =
        SkyView::new(&inputs.model, earth, height_km, azimuth, altitude, inputs.options).map_err(failure::request)?;
    Ok(view.with_shadow(setup.shadow().map_err(failure::setup)?))
}

/// Returns standard magnitudes for directions in the satellite's body frame; NaN where no lit surface is visible.
#[pyfunction]
pub fn standard_magnitudes<'py>(
    py: Python<'py>,
    setup: &str,
    model: &str,
    sun_latitude_deg: Column<'py>,
    observer_longitude_deg: Column<'py>,
    observer_latitude_deg: Column<'py>,
    height_km: Column<'py>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (sun, longitude) = (sun_latitude_deg.as_array(), observer_longitude_deg.as_array());
    let (latitude, height) = (observer_latitude_deg.as_array(), height_km.as_array());
    for index in 0..sun.len() {
        within("sun_latitude", index, sun[index], -90.0, 90.0, "deg")?;
        within("observer_longitude", index, longitude[index], -360.0, 360.0, "deg")?;
        within("observer_latitude", index, latitude[index], -90.0, 90.0, "deg")?;
        within("height", index, height[index], 1e-3, 100_000.0, "km")?;
    }
    let magnitudes = failure::without_lock(py, |watch| {
        let Inputs { model, options, .. } = inputs(setup, model)?;
        (0..sun.len())
            .into_par_iter()
            .map(|index| {
                watch.check().map_err(failure::request)?;
                let view = BodyView::new(&model, sun[index].to_radians(), height[index], options);
                let magnitude =
                    view.map_err(failure::request)?.at(longitude[index].to_radians(), latitude[index].to_radians());
                Ok(magnitude.map_or(f64::NAN, |magnitude| magnitude.0))
            })
            .collect::<PyResult<Vec<f64>>>()
    })?;
    Ok(magnitudes.into_pyarray(py))
}

/// Returns apparent magnitudes for directions above a site (NaN in the shadow) and distances, km.
#[pyfunction]
pub fn sky_magnitudes<'py>(
    py: Python<'py>,
    setup: &str,
    model: &str,
    azimuth_deg: Column<'py>,
    altitude_deg: Column<'py>,
    sun_altitude_deg: f64,
    sun_azimuth_deg: f64,
    height_km: f64,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
    let (azimuth, altitude) = (azimuth_deg.as_array(), altitude_deg.as_array());
    for index in 0..azimuth.len() {
        within("azimuth", index, azimuth[index], -360.0, 360.0, "deg")?;
        within("altitude", index, altitude[index], 0.0, 90.0, "deg")?;
    }
    let (magnitudes, ranges): (Vec<f64>, Vec<f64>) = failure::without_lock(py, |watch| {
        let inputs = inputs(setup, model)?;
        let view = sky_view(&inputs, sun_altitude_deg, sun_azimuth_deg, height_km)?;
        let points = (0..azimuth.len())
            .into_par_iter()
            .map(|index| {
                watch.check().map_err(failure::request)?;
                let point = view.at(azimuth[index].to_radians(), altitude[index].to_radians());
                Ok((point.magnitude.map_or(f64::NAN, |magnitude| magnitude.0), point.range_km))
            })
            .collect::<PyResult<Vec<_>>>()?;
        Ok(points.into_iter().unzip())
    })?;
    Ok((magnitudes.into_pyarray(py), ranges.into_pyarray(py)))
}
