//! Pixels of an image to be written, in the type they are to have in the file.

use super::super::card::Card;
use super::super::plane::Plane;
use super::cfitsio::{CPixel, Handle, Rice};
use super::error::FrameError;
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

/// An image to be written: its pixels and the length of its rows.
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

    /// The pixels, out of the image.
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

    /// Type in the file.
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

    /// Writes the pixels into the image that CFITSIO is at, the last of `hdu` + 1.
    pub(super) fn write(&self, handle: &mut Handle<'_>, hdu: usize) -> Result<(), FrameError> {
        handle.fitsio(|file| {
            let image = file.hdu(hdu)?;
            match &self.pixels {
                Pixels::U8(values) => image.write_image(file, values),
                Pixels::I16(values) => image.write_image(file, values),
                Pixels::U16(values) => image.write_image(file, values),
                Pixels::I32(values) => image.write_image(file, values),
                Pixels::F32(values) => image.write_image(file, values),
                Pixels::F64(values) => image.write_image(file, values),
            }
        })
    }

    /// Adds the image compressed by RICE behind all HDUs of a file, the last of which becomes `hdu`.
    pub(super) fn write_rice(
        &self,
        handle: &mut Handle<'_>,
        hdu: usize,
        rice: Rice,
        cards: &[Card],
    ) -> Result<(), FrameError> {
        // USHORT_IMG of `fitsio.h`: 16 bits with BZERO.
        let bitpix = if let Pixels::U16(_) = self.pixels { 20 } else { self.format().bitpix.number() as i32 };
        handle.append_rice(rice, bitpix, self.size())?;
        handle.append_cards(cards)?;
        match &self.pixels {
            Pixels::F32(values) => handle.write_marked(&mut marked(values, NOTHING, |value| value.is_nan()), NOTHING),
            Pixels::F64(values) => {
                let mark = f64::from(NOTHING);
                handle.write_marked(&mut marked(values, mark, |value| value.is_nan()), mark)
            }
            _ => self.write(handle, hdu),
        }
    }
}

/// Pixels with a mark in place of those without a value.
fn marked<T: CPixel>(values: &[T], mark: T, is_nothing: impl Fn(&T) -> bool) -> Vec<T> {
    values.iter().map(|value| if is_nothing(value) { mark } else { *value }).collect()
}
