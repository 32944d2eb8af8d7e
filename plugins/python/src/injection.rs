//! Streaks into files and arrays.

use std::path::{Path, PathBuf};

use hifitime::Epoch;
use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use streakcast::config::{Config, InjectionConfig, ConfigError, SkyOf, inject_frames, inject_into_array};
use streakcast::images::{Header, ImageValues, Pixels};
use streakcast::output::format_utc;
use streakcast::streaks::{ArrayInjected, Injections};

use crate::columns::columns;
use crate::failure;
use crate::questions::start_of;
use crate::skies::{Skies, setup_of};

/// A moment as the text that the library reads, to the nanosecond.
#[pyfunction]
pub fn utc_text(jd1: f64, jd2: f64) -> PyResult<String> {
    Ok(format_utc(start_of(0, jd1, jd2)?, 9))
}

/// Puts streaks into the file that is said, or into an image: `summary`, `truth`, `points`, `trails`, `bits`, `warnings`, and for
/// an image `image` and `mask`. `output` is the file to write; for an image a folder for what is in between.
#[pyfunction]
#[expect(clippy::too_many_arguments)]
#[pyo3(signature = (said, setup, config, skies, output, image=None, header=None))]
pub fn inject<'py>(
    py: Python<'py>,
    said: &str,
    setup: &str,
    config: Option<&str>,
    skies: Option<Py<Skies>>,
    output: PathBuf,
    image: Option<Bound<'py, PyAny>>,
    header: Option<&str>,
) -> PyResult<Bound<'py, PyDict>> {
    let injection: InjectionConfig = serde_json::from_str(said).map_err(failure::asked)?;
    let setup: Config = setup_of(setup, config)?;
    let image = image.map(|image| values_of(&image)).transpose()?;
    let cards = Header::from_text(header.unwrap_or_default());
    let (told, changed) = failure::without_lock(py, || {
        let sky = skies.as_ref().map(|skies| move |moment: Epoch| skies.get().prepared(moment));
        let sky = sky.as_ref().map(|sky| sky as SkyOf<'_>);
        match &image {
            None => Ok((inject_frames(&injection, &setup, sky, &[output]).map_err(exception)?, None)),
            Some(image) => {
                let ArrayInjected { image, mask, injections } =
                    inject_into_array(&injection, &setup, sky, image, &cards, Path::new(&output)).map_err(exception)?;
                Ok((injections, Some((image, mask))))
            }
        }
    })?;
    let answer = answer_of(py, &told)?;
    if let Some((image, mask)) = changed {
        let [rows, columns] = image.size();
        answer.set_item("image", array_of(py, image)?)?;
        let mask = mask.map(|mask| mask.into_pyarray(py).reshape([rows, columns])).transpose()?;
        answer.set_item("mask", mask)?;
    }
    Ok(answer)
}

/// A setup's error is one of the setup here too.
fn exception(error: ConfigError) -> PyErr {
    match error {
        error if !error.is_of_request() => failure::setup(error),
        other => failure::asked(failure::as_arguments(&other.to_string())),
    }
}

fn answer_of<'py>(py: Python<'py>, told: &Injections) -> PyResult<Bound<'py, PyDict>> {
    let answer = PyDict::new(py);
    let mut warnings: Vec<String> = told.warnings.iter().map(|warning| failure::as_arguments(warning)).collect();
    for frame in &told.frames {
        answer.set_item("summary", &frame.summary)?;
        answer.set_item("truth", columns(py, &frame.truth)?)?;
        answer.set_item("points", columns(py, &frame.points)?)?;
        answer.set_item("trails", columns(py, &frame.trails)?)?;
        answer.set_item("bits", (frame.planes.streak_bit, frame.planes.injected_bit))?;
        warnings.extend(frame.warnings.iter().map(|warning| failure::as_arguments(warning)));
    }
    answer.set_item("warnings", warnings)?;
    Ok(answer)
}

fn values_of(image: &Bound<'_, PyAny>) -> PyResult<ImageValues> {
    let read = |columns: usize, pixels: Pixels| {
        ImageValues::new(columns, pixels)
            .ok_or_else(|| failure::asked("frame has no pixels; allowed: rows and columns"))
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
        "frame is no such array; allowed: two axes of float32, float64, uint8, int16, uint16 or int32",
    ))
}

/// Columns and pixels of an array of one type.
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
