//! Frames in memory: arrays are written to files, and images of files are read to arrays.

use std::path::PathBuf;

use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use streakcast::images::{FrameFile, Header, ImageValues, NewImage, Pixels};

use crate::failure;

/// Number of rows that are read at once, so that an image is not in memory in double precision.
const ROWS: usize = 256;

/// Writes a file of images, each with its name (empty if it has none), its pixels and the cards of its header as text.
#[pyfunction]
pub fn write_frame(py: Python<'_>, path: PathBuf, images: Vec<(String, Bound<'_, PyAny>, String)>) -> PyResult<()> {
    let read = |(name, pixels, cards): (String, Bound<'_, PyAny>, String)| {
        Ok((name, values_of(&pixels)?, Header::from_text(&cards)))
    };
    let images: Vec<(String, ImageValues, Header)> = images.into_iter().map(read).collect::<PyResult<_>>()?;
    failure::without_lock(py, |_| {
        let new = |(name, values, cards)| NewImage { name, values, cards: Header::cards(cards), rice: None };
        let images: Vec<NewImage<'_>> =
            images.iter().map(|(name, values, cards)| new((name.as_str(), values, cards))).collect();
        streakcast::images::write_frame(&path, &images).map_err(failure::request)
    })
}

/// Reads an image of a file as an array of the given type; `None` if the HDU is missing or not an image.
///
/// Pages of zeros take no memory until they are changed: only other values are written to the array.
#[pyfunction]
pub fn read_image<'py>(py: Python<'py>, path: PathBuf, hdu: usize, dtype: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
    let file = FrameFile::open(&path).map_err(failure::request)?;
    let Ok(size) = file.image_size(hdu) else { return Ok(None) };
    let image = match dtype {
        "uint8" => array(py, &file, hdu, size, |value| value as u8)?,
        "int16" => array(py, &file, hdu, size, |value| value as i16)?,
        "uint16" => array(py, &file, hdu, size, |value| value as u16)?,
        "int32" => array(py, &file, hdu, size, |value| value as i32)?,
        "float32" => array(py, &file, hdu, size, |value| value as f32)?,
        "float64" => array(py, &file, hdu, size, |value| value)?,
        other => return Err(PyValueError::new_err(format!("dtype is {other}; allowed: that of a frame"))),
    };
    Ok(Some(image))
}

fn array<'py, T: Element + Copy + Default>(
    py: Python<'py>,
    file: &FrameFile,
    hdu: usize,
    [rows, columns]: [usize; 2],
    converted: impl Fn(f64) -> T + Sync,
) -> PyResult<Bound<'py, PyAny>> {
    let pixels = failure::without_lock(py, |_| {
        let mut pixels = vec![T::default(); rows * columns];
        for first in (0..rows).step_by(ROWS) {
            let values = file.read_rows(hdu, first..rows.min(first + ROWS)).map_err(failure::request)?;
            for (pixel, value) in pixels[first * columns..].iter_mut().zip(values) {
                if value.to_bits() != 0 {
                    *pixel = converted(value);
                }
            }
        }
        Ok(pixels)
    })?;
    Ok(pixels.into_pyarray(py).reshape([rows, columns])?.into_any())
}

/// Converts an array to an image.
fn values_of(image: &Bound<'_, PyAny>) -> PyResult<ImageValues> {
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
