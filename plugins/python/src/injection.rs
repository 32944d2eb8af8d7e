//! Injection of streaks into files and arrays.

use std::path::{Path, PathBuf};

use hifitime::Epoch;
use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use streakcast::config::{Config, ConfigError, InjectionConfig, SkyOf, inject_frames, inject_into_array};
use streakcast::images::{Header, ImageValues, Pixels};
use streakcast::streaks::{ArrayInjected, Injections};

use crate::columns::columns;
use crate::failure;
use crate::sky_cache::{SkyCache, setup_of};

/// Adds streaks to the file in the request, or to an image. Returns `summary`, `truth`, `points`, `trails`, `bits` and
/// `warnings`, and for an image also `image` and `mask`. `output` is the output file, or for an image a folder for
/// temporary files.
#[pyfunction]
#[pyo3(signature = (request, setup, config, sky_cache, output, image=None, header=None))]
pub fn inject<'py>(
    py: Python<'py>,
    request: &str,
    setup: &str,
    config: Option<&str>,
    sky_cache: Option<Py<SkyCache>>,
    output: PathBuf,
    image: Option<Bound<'py, PyAny>>,
    header: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let injection: InjectionConfig = serde_json::from_str(request).map_err(failure::request)?;
    let setup: Config = setup_of(setup, config)?;
    let image = image.map(|image| values_of(&image)).transpose()?;
    let cards = Header::from_text(header.unwrap_or_default());
    let (injections, image_and_mask) = failure::without_lock(py, |watch| {
        let sky = sky_cache.as_ref().map(|sky_cache| move |moment: Epoch| sky_cache.get().prepared(moment));
        let sky = sky.as_ref().map(|sky| sky as SkyOf<'_>);
        match &image {
            None => Ok((inject_frames(&injection, &setup, sky, &[output], watch).map_err(exception)?, None)),
            Some(image) => {
                let ArrayInjected { image, mask, injections } =
                    inject_into_array(&injection, &setup, sky, image, &cards, Path::new(&output), watch)
                        .map_err(exception)?;
                Ok((injections, Some((image, mask))))
            }
        }
    })?;
    let result = result_of(py, &injections)?;
    if let Some((image, mask)) = image_and_mask {
        let [rows, columns] = image.size();
        result.set_item("image", array_of(py, image)?)?;
        let mask = mask.map(|mask| mask.into_pyarray(py).reshape([rows, columns])).transpose()?;
        result.set_item("mask", mask)?;
    }
    Ok(result)
}

/// Converts an error of the library. Errors in the configuration become `SetupError`.
pub fn exception(error: ConfigError) -> PyErr {
    match error {
        error if !error.is_of_request() => failure::setup(error),
        other => failure::request(failure::as_arguments(&other.to_string())),
    }
}

fn result_of<'py>(py: Python<'py>, injections: &Injections) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    let mut warnings: Vec<String> = injections.warnings.iter().map(|warning| failure::as_arguments(warning)).collect();
    for frame in &injections.frames {
        result.set_item("summary", &frame.summary)?;
        result.set_item("truth", columns(py, &frame.truth)?)?;
        result.set_item("points", columns(py, &frame.points)?)?;
        result.set_item("trails", columns(py, &frame.trails)?)?;
        result.set_item("bits", (frame.planes.streak_bit, frame.planes.injected_bit))?;
        warnings.extend(frame.warnings.iter().map(|warning| failure::as_arguments(warning)));
    }
    result.set_item("warnings", warnings)?;
    Ok(result)
}

/// Converts an array to an image.
pub fn values_of(image: &Bound<'_, PyAny>) -> PyResult<ImageValues> {
    let read = |columns: usize, pixels: Pixels| {
        ImageValues::new(columns, pixels)
            .ok_or_else(|| failure::request("frame is empty; allowed: at least one row and one column"))
    };
    if let Some((columns, pixels)) = pixels_of::<f32>(image) {
        return read(columns, Pixels::F32(pixels));
    }
    if let Some((columns, pixels)) = pixels_of::<f64>(image) {
        return read(columns, Pixels::F64(pixels));
    }
    if let Some((columns, pixels)) = pixels_of::<u16>(image) {
        return read(columns, Pixels::U16(pixels));
    }
    if let Some((columns, pixels)) = pixels_of::<i16>(image) {
        return read(columns, Pixels::I16(pixels));
    }
    if let Some((columns, pixels)) = pixels_of::<i32>(image) {
        return read(columns, Pixels::I32(pixels));
    }
    if let Some((columns, pixels)) = pixels_of::<u8>(image) {
        return read(columns, Pixels::U8(pixels));
    }
    Err(PyTypeError::new_err(
        "invalid frame array; allowed: two axes of float32, float64, uint8, int16, uint16 or int32",
    ))
}

/// Returns the number of columns and the pixels of an array of type `T`; `None` for another type.
fn pixels_of<T: Element + Copy>(image: &Bound<'_, PyAny>) -> Option<(usize, Vec<T>)> {
    let array: PyReadonlyArray2<'_, T> = image.extract().ok()?;
    let view = array.as_array();
    Some((view.ncols(), view.iter().copied().collect()))
}

fn array_of<'py>(py: Python<'py>, image: ImageValues) -> PyResult<Bound<'py, PyAny>> {
    let size = image.size();
    Ok(match image.into_pixels() {
        Pixels::U8(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
        Pixels::I16(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
        Pixels::U16(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
        Pixels::I32(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
        Pixels::F32(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
        Pixels::F64(pixels) => pixels.into_pyarray(py).reshape(size)?.into_any(),
    })
}
