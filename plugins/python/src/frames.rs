//! Frames in memory: arrays are written to files, and images of files are read to arrays.

use std::borrow::Cow;
use std::path::PathBuf;

use numpy::{Element, IntoPyArray, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use streakcast::images::{FrameFile, Header, ImageValues, NewImage, PixelPosition, Pixels, Wcs};

use crate::failure;

/// Writes a file of images, each with its name (empty if it has none), its pixels and the cards of its header as text.
/// Contiguous arrays are not copied.
#[pyfunction]
pub fn write_frame(py: Python<'_>, path: PathBuf, images: Vec<(String, Bound<'_, PyAny>, String)>) -> PyResult<()> {
    // Other integers than those of `Array` arrive as int32.
    let allowed = "invalid frame array; allowed: two axes of float32, float64, or integers within the range of int32";
    let arrays: Vec<Array<'_>> = images
        .iter()
        .map(|(_, pixels, _)| pixels.extract().map_err(|_| PyTypeError::new_err(allowed)))
        .collect::<PyResult<_>>()?;
    let images = arrays.iter().zip(&images);
    let images: Vec<(&String, ImageValues<'_>, Header)> = images
        .map(|(array, (name, _, cards))| Ok((name, values_of(array)?, Header::from_text(cards))))
        .collect::<PyResult<_>>()?;
    failure::without_lock(py, |_| {
        let new = |(name, values, cards)| NewImage { name, values, cards: Header::cards(cards), rice: None };
        let images: Vec<NewImage<'_>> =
            images.iter().map(|(name, values, cards)| new((name.as_str(), values, cards))).collect();
        streakcast::images::write_frame(&path, &images).map_err(failure::request)
    })
}

/// Reads rows of an image of a file, from `first_row` to before `end_row`, as an array of the given type; `None` if the
/// HDU is missing or not an image.
#[pyfunction]
pub fn read_rows<'py>(
    py: Python<'py>,
    path: PathBuf,
    hdu: usize,
    dtype: &str,
    first_row: usize,
    end_row: usize,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let file = FrameFile::open(&path).map_err(failure::request)?;
    let Ok([_, columns]) = file.image_size(hdu) else { return Ok(None) };
    let values = failure::without_lock(py, |_| file.read_rows(hdu, first_row..end_row).map_err(failure::request))?;
    let image = match dtype {
        "uint8" => array(py, &values, columns, |value| value as u8)?,
        "int16" => array(py, &values, columns, |value| value as i16)?,
        "uint16" => array(py, &values, columns, |value| value as u16)?,
        "int32" => array(py, &values, columns, |value| value as i32)?,
        "float32" => array(py, &values, columns, |value| value as f32)?,
        "float64" => array(py, &values, columns, |value| value)?,
        other => return Err(PyValueError::new_err(format!("dtype is {other}; allowed: that of a frame"))),
    };
    Ok(Some(image))
}

/// Returns right ascension and declination (degrees) of pixels (column and row from 0) by the cards of a header, NaN
/// for pixels without a position, and the pixel scale (arcsec) at the first of them; `None` if the header has no valid
/// world coordinates.
#[pyfunction]
pub fn sky_of_pixels(cards: &str, pixels: Vec<[f64; 2]>) -> Option<(Vec<[f64; 2]>, f64)> {
    let wcs = Wcs::from_header(&Header::from_text(cards)).ok()?;
    let pixels: Vec<PixelPosition> = pixels.into_iter().map(|[x, y]| PixelPosition { x, y }).collect();
    let scale_arcsec = wcs.pixel_scale_arcsec(*pixels.first()?);
    let of_pixel = |at: &PixelPosition| {
        let seen = wcs.to_sky(*at);
        seen.map_or([f64::NAN; 2], |seen| [seen.longitude_rad().to_degrees(), seen.latitude_rad().to_degrees()])
    };
    Some((pixels.iter().map(of_pixel).collect(), scale_arcsec))
}

fn array<'py, T: Element>(
    py: Python<'py>,
    values: &[f64],
    columns: usize,
    converted: impl Fn(f64) -> T,
) -> PyResult<Bound<'py, PyAny>> {
    let pixels: Vec<T> = values.iter().map(|value| converted(*value)).collect();
    let size = [pixels.len() / columns, columns];
    Ok(pixels.into_pyarray(py).reshape(size)?.into_any())
}

/// Array of a type that a frame can have.
#[derive(FromPyObject)]
enum Array<'py> {
    F32(PyReadonlyArray2<'py, f32>),
    F64(PyReadonlyArray2<'py, f64>),
    U16(PyReadonlyArray2<'py, u16>),
    I16(PyReadonlyArray2<'py, i16>),
    I32(PyReadonlyArray2<'py, i32>),
    U8(PyReadonlyArray2<'py, u8>),
}

/// Converts an array to an image.
fn values_of<'a>(array: &'a Array<'_>) -> PyResult<ImageValues<'a>> {
    let (columns, pixels) = match array {
        Array::F32(array) => (array.as_array().ncols(), Pixels::F32(pixels_of(array))),
        Array::F64(array) => (array.as_array().ncols(), Pixels::F64(pixels_of(array))),
        Array::U16(array) => (array.as_array().ncols(), Pixels::U16(pixels_of(array))),
        Array::I16(array) => (array.as_array().ncols(), Pixels::I16(pixels_of(array))),
        Array::I32(array) => (array.as_array().ncols(), Pixels::I32(pixels_of(array))),
        Array::U8(array) => (array.as_array().ncols(), Pixels::U8(pixels_of(array))),
    };
    ImageValues::new(columns, pixels)
        .ok_or_else(|| failure::request("frame is empty; allowed: at least one row and one column"))
}

/// Returns the pixels of an array row by row; copied if they are stored in another order.
fn pixels_of<'a, T: Element + Copy>(array: &'a PyReadonlyArray2<'_, T>) -> Cow<'a, [T]> {
    let view = array.as_array();
    view.to_slice().map_or_else(|| view.iter().copied().collect(), Cow::Borrowed)
}
