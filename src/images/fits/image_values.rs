//! Pixels of an image to be written, in the type they are to have in the file.

use super::super::plane::Plane;
use super::pixel_format::{Bitpix, PixelFormat};

/// CFITSIO's own mark of a floating pixel without a value: no sum of light is this number.
const NOTHING: f32 = -9.119_129e-36;

/// Pixels row after row, and what they are stored as.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Whole numbers of 8 bits, without sign.
    U8(Vec<u8>),
    /// Whole numbers of 16 bits.
    I16(Vec<i16>),
    /// Whole numbers of 16 bits without sign (BZERO = 32768).
    U16(Vec<u16>),
    /// Whole numbers of 32 bits.
    I32(Vec<i32>),
    /// Single precision; NaN for no value.
    F32(Vec<f32>),
    /// Double precision; NaN for no value.
    F64(Vec<f64>),
}

/// An image to be written: its pixels and how many stand in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageValues {
    columns: usize,
    pixels: Pixels,
}

impl From<Plane> for ImageValues {
    fn from(plane: Plane) -> Self {
        Self { columns: plane.columns(), pixels: Pixels::F32(plane.into_values()) }
    }
}

impl ImageValues {
    /// From pixels row after row, the row that FITS holds first at the beginning; `None` where they do not fill whole rows.
    pub fn new(columns: usize, pixels: Pixels) -> Option<Self> {
        let image = Self { columns, pixels };
        let count = image.count();
        (columns > 0 && count > 0 && count.is_multiple_of(columns)).then_some(image)
    }

    /// Rows and columns.
    pub fn size(&self) -> [usize; 2] {
        [self.count() / self.columns.max(1), self.columns]
    }

    /// The pixels, row after row.
    pub fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// The pixels themselves.
    pub fn into_pixels(self) -> Pixels {
        self.pixels
    }

    fn count(&self) -> usize {
        match &self.pixels {
            Pixels::U8(values) => values.len(),
            Pixels::I16(values) => values.len(),
            Pixels::U16(values) => values.len(),
            Pixels::I32(values) => values.len(),
            Pixels::F32(values) => values.len(),
            Pixels::F64(values) => values.len(),
        }
    }

    /// How they are stored.
    pub(super) fn format(&self) -> PixelFormat {
        let (bitpix, zero) = match self.pixels {
            Pixels::U8(_) => (Bitpix::U8, 0.0),
            Pixels::I16(_) => (Bitpix::I16, 0.0),
            Pixels::U16(_) => (Bitpix::I16, 32_768.0),
            Pixels::I32(_) => (Bitpix::I32, 0.0),
            Pixels::F32(_) => (Bitpix::F32, 0.0),
            Pixels::F64(_) => (Bitpix::F64, 0.0),
        };
        PixelFormat { bitpix, scale: 1.0, zero, blank: None }
    }

    /// As a file holds them: the highest byte first.
    pub(super) fn file_bytes(&self) -> Vec<u8> {
        match &self.pixels {
            Pixels::U8(values) => values.clone(),
            Pixels::I16(values) => values.iter().flat_map(|value| value.to_be_bytes()).collect(),
            // 0 becomes -32768: the highest bit is turned over.
            Pixels::U16(values) => values.iter().flat_map(|value| (value ^ 0x8000).to_be_bytes()).collect(),
            Pixels::I32(values) => values.iter().flat_map(|value| value.to_be_bytes()).collect(),
            Pixels::F32(values) => values.iter().flat_map(|value| value.to_be_bytes()).collect(),
            Pixels::F64(values) => values.iter().flat_map(|value| value.to_be_bytes()).collect(),
        }
    }

    /// As the machine holds them, with CFITSIO's mark for NaN.
    pub(super) fn native_bytes(&self) -> Vec<u8> {
        match &self.pixels {
            Pixels::U8(values) => values.clone(),
            Pixels::I16(values) => values.iter().flat_map(|value| value.to_ne_bytes()).collect(),
            Pixels::U16(values) => values.iter().flat_map(|value| value.to_ne_bytes()).collect(),
            Pixels::I32(values) => values.iter().flat_map(|value| value.to_ne_bytes()).collect(),
            Pixels::F32(values) => {
                let marked = |value: &f32| if value.is_nan() { NOTHING } else { *value };
                values.iter().flat_map(|value| marked(value).to_ne_bytes()).collect()
            }
            Pixels::F64(values) => {
                let marked = |value: &f64| if value.is_nan() { f64::from(NOTHING) } else { *value };
                values.iter().flat_map(|value| marked(value).to_ne_bytes()).collect()
            }
        }
    }

    /// CFITSIO's mark in the machine's order; none for whole numbers.
    pub(super) fn native_nothing(&self) -> Option<Vec<u8>> {
        match self.pixels {
            Pixels::F32(_) => Some(NOTHING.to_ne_bytes().to_vec()),
            Pixels::F64(_) => Some(f64::from(NOTHING).to_ne_bytes().to_vec()),
            Pixels::U8(_) | Pixels::I16(_) | Pixels::U16(_) | Pixels::I32(_) => None,
        }
    }

    /// Codes of `fitsio.h`: the image's type and the pixels'.
    pub(super) fn cfitsio_codes(&self) -> (i32, i32) {
        match self.pixels {
            Pixels::U8(_) => (8, 11),
            Pixels::I16(_) => (16, 21),
            Pixels::U16(_) => (20, 20),
            Pixels::I32(_) => (32, 31),
            Pixels::F32(_) => (-32, 42),
            Pixels::F64(_) => (-64, 82),
        }
    }
}
