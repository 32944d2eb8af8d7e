//! Stored numbers of pixels: their types, the conversion to physical values, and arrays of pixels.

use std::borrow::Cow;

use super::cfitsio::{CPixel, Handle, Rice};
use super::deltas::Outcome;
use crate::error::Error;
use crate::images::card::Card;
use crate::images::pixels::Plane;

/// Type of a stored number, given by BITPIX.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Bitpix {
    /// Unsigned 8-bit integer (8).
    U8,
    /// Signed 16-bit integer (16).
    I16,
    /// Signed 32-bit integer (32).
    I32,
    /// Signed 64-bit integer (64).
    I64,
    /// Single-precision number (-32).
    F32,
    /// Double-precision number (-64).
    F64,
}

impl Bitpix {
    /// Returns the type for a value of BITPIX; `None` for an invalid value.
    pub fn from_number(number: i64) -> Option<Self> {
        Some(match number {
            8 => Self::U8,
            16 => Self::I16,
            32 => Self::I32,
            64 => Self::I64,
            -32 => Self::F32,
            -64 => Self::F64,
            _ => return None,
        })
    }

    /// Returns the value of BITPIX.
    pub fn number(self) -> i64 {
        match self {
            Self::U8 => 8,
            Self::I16 => 16,
            Self::I32 => 32,
            Self::I64 => 64,
            Self::F32 => -32,
            Self::F64 => -64,
        }
    }

    /// Returns the length of one pixel, bytes.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::I16 => 2,
            Self::I32 | Self::F32 => 4,
            Self::I64 | Self::F64 => 8,
        }
    }

    /// Returns true if pixels are integers.
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Returns the smallest and the largest integer of the type; infinite for floating-point types.
    fn range(self) -> (f64, f64) {
        match self {
            Self::U8 => (0.0, 255.0),
            Self::I16 => (f64::from(i16::MIN), f64::from(i16::MAX)),
            Self::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
            Self::I64 => (i64::MIN as f64, i64::MAX as f64),
            Self::F32 | Self::F64 => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }
}

/// Conversion of stored numbers to physical values: physical = BZERO + BSCALE · stored.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PixelFormat {
    /// Type of the stored numbers.
    pub bitpix: Bitpix,
    /// BSCALE, the physical step of the stored numbers.
    pub scale: f64,
    /// BZERO, the physical value of the stored number 0; 32768 makes 16-bit integers unsigned.
    pub zero: f64,
    /// BLANK, the integer that marks pixels without a value.
    pub blank: Option<i64>,
}

/// Number to be stored for a physical value.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) enum Stored {
    /// The number for the value, rounded if the type is an integer.
    Exact(f64),
    /// The nearest end of the range of the type, because the value is outside the range.
    Clipped(f64),
}

impl PixelFormat {
    /// Returns the physical value of a stored number; NaN for BLANK.
    #[inline]
    pub fn physical(&self, stored: f64) -> f64 {
        if self.blank.is_some_and(|blank| self.bitpix.is_integer() && stored == blank as f64) {
            return f64::NAN;
        }
        self.zero + self.scale * stored
    }

    /// Returns true if values are stored in single precision without scaling.
    pub(super) fn is_plain_single(&self) -> bool {
        self.bitpix == Bitpix::F32 && self.scale == 1.0 && self.zero == 0.0
    }

    /// Returns the difference between adjacent physical values; 0 for floating-point numbers.
    pub(super) fn step(&self) -> f64 {
        if self.bitpix.is_integer() { self.scale.abs() } else { 0.0 }
    }

    /// Returns the smallest and largest physical value of integer pixels with BSCALE = 1; `None` for other pixels.
    pub fn whole_range(&self) -> Option<(f64, f64)> {
        let (least, greatest) = self.bitpix.range();
        (self.bitpix.is_integer() && self.scale == 1.0).then_some((self.zero + least, self.zero + greatest))
    }

    /// Stores a physical value in the bytes of a file.
    #[inline]
    pub(super) fn put(&self, bytes: &mut [u8], index: usize, physical: f64) -> Outcome {
        let (number, is_clipped) = match self.stored(physical) {
            Stored::Exact(number) => (number, false),
            Stored::Clipped(number) => (number, true),
        };
        let is_other = number != self.raw(bytes, index);
        if is_other {
            self.put_raw(bytes, index, number);
        }
        Outcome { is_other, is_clipped }
    }

    /// Returns the number to be stored for a physical value: rounded half to even, limited to the range of the type,
    /// and different from BLANK.
    #[inline]
    pub(super) fn stored(&self, physical: f64) -> Stored {
        let number = (physical - self.zero) / self.scale;
        if !self.bitpix.is_integer() {
            return Stored::Exact(number);
        }
        let (mut low, mut high) = self.bitpix.range();
        let blank = self.blank.map(|blank| blank as f64);
        // A physical value must not be stored as BLANK.
        if blank == Some(low) {
            low += 1.0;
        } else if blank == Some(high) {
            high -= 1.0;
        }
        let rounded = number.round_ties_even();
        if rounded < low || rounded > high {
            return Stored::Clipped(rounded.clamp(low, high));
        }
        if blank == Some(rounded) {
            return Stored::Exact(if number < rounded { rounded - 1.0 } else { rounded + 1.0 });
        }
        Stored::Exact(rounded)
    }

    /// Returns the stored number at an index. 64-bit integers beyond 2^53 lose their last digits.
    #[inline]
    pub(super) fn raw(&self, bytes: &[u8], index: usize) -> f64 {
        let size = self.bitpix.bytes();
        let at = |k: usize| bytes[index * size + k];
        match self.bitpix {
            Bitpix::U8 => f64::from(at(0)),
            Bitpix::I16 => f64::from(i16::from_be_bytes([at(0), at(1)])),
            Bitpix::I32 => f64::from(i32::from_be_bytes([at(0), at(1), at(2), at(3)])),
            Bitpix::I64 => i64::from_be_bytes(std::array::from_fn(at)) as f64,
            Bitpix::F32 => f64::from(f32::from_be_bytes([at(0), at(1), at(2), at(3)])),
            Bitpix::F64 => f64::from_be_bytes(std::array::from_fn(at)),
        }
    }

    /// Stores a number at an index.
    #[inline]
    pub(super) fn put_raw(&self, bytes: &mut [u8], index: usize, number: f64) {
        let size = self.bitpix.bytes();
        let target = &mut bytes[index * size..(index + 1) * size];
        match self.bitpix {
            Bitpix::U8 => target[0] = number as u8,
            Bitpix::I16 => target.copy_from_slice(&(number as i16).to_be_bytes()),
            Bitpix::I32 => target.copy_from_slice(&(number as i32).to_be_bytes()),
            Bitpix::I64 => target.copy_from_slice(&(number as i64).to_be_bytes()),
            Bitpix::F32 => target.copy_from_slice(&(number as f32).to_be_bytes()),
            Bitpix::F64 => target.copy_from_slice(&number.to_be_bytes()),
        }
    }
}

/// Number that marks a floating-point pixel without a value for CFITSIO; no sum of light equals it.
const NO_VALUE: f32 = -9.119_129e-36;

/// Pixels row by row, in the type in which they are stored.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels<'a> {
    /// Unsigned 8-bit integers.
    U8(Cow<'a, [u8]>),
    /// Signed 16-bit integers.
    I16(Cow<'a, [i16]>),
    /// Unsigned 16-bit integers (BZERO = 32768).
    U16(Cow<'a, [u16]>),
    /// Signed 32-bit integers.
    I32(Cow<'a, [i32]>),
    /// Single precision; NaN for pixels without a value.
    F32(Cow<'a, [f32]>),
    /// Double precision; NaN for pixels without a value.
    F64(Cow<'a, [f64]>),
}

/// Image to be written: pixels and the length of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageValues<'a> {
    columns: usize,
    pixels: Pixels<'a>,
}

impl From<Plane> for ImageValues<'static> {
    fn from(plane: Plane) -> Self {
        Self { columns: plane.columns(), pixels: Pixels::F32(plane.into_values().into()) }
    }
}

impl<'a> ImageValues<'a> {
    /// Creates an image from pixels row by row, beginning with the first row of a FITS file; `None` if the number of
    /// pixels is not a multiple of `columns`.
    pub fn new(columns: usize, pixels: Pixels<'a>) -> Option<Self> {
        let image = Self { columns, pixels };
        let count = image.count();
        (columns > 0 && count > 0 && count.is_multiple_of(columns)).then_some(image)
    }

    /// Returns the numbers of rows and columns.
    pub fn size(&self) -> [usize; 2] {
        [self.count() / self.columns.max(1), self.columns]
    }

    /// Returns the pixels, row by row.
    pub fn pixels(&self) -> &Pixels<'a> {
        &self.pixels
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

    /// Returns the format of the pixels in the file.
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

    /// Writes the pixels to the current image of CFITSIO; `hdu` is its number.
    pub(super) fn write(&self, handle: &mut Handle<'_>, hdu: usize) -> Result<(), Error> {
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

    /// Compresses the image by RICE and appends it to a file, in which it becomes HDU number `hdu`.
    pub(super) fn write_rice(
        &self,
        handle: &mut Handle<'_>,
        hdu: usize,
        rice: Rice,
        cards: &[Card],
    ) -> Result<(), Error> {
        // USHORT_IMG of `fitsio.h`: 16 bits with BZERO.
        let bitpix = if let Pixels::U16(_) = self.pixels { 20 } else { self.format().bitpix.number() as i32 };
        handle.append_rice(rice, bitpix, self.size())?;
        handle.append_cards(cards)?;
        match &self.pixels {
            Pixels::F32(values) => handle.write_marked(&mut marked(values, NO_VALUE, |value| value.is_nan()), NO_VALUE),
            Pixels::F64(values) => {
                let mark = f64::from(NO_VALUE);
                handle.write_marked(&mut marked(values, mark, |value| value.is_nan()), mark)
            }
            _ => self.write(handle, hdu),
        }
    }
}

/// Returns the pixels with `mark` in place of pixels without a value.
fn marked<T: CPixel>(values: &[T], mark: T, is_missing: impl Fn(&T) -> bool) -> Vec<T> {
    values.iter().map(|value| if is_missing(value) { mark } else { *value }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_unsigned_and_blank() {
        let format = PixelFormat { bitpix: Bitpix::I16, scale: 1.0, zero: 32_768.0, blank: Some(-32_768) };
        assert_eq!(format.physical(-32_767.0), 1.0);
        assert!(format.physical(-32_768.0).is_nan());
        assert_eq!(format.stored(2.5), Stored::Exact(-32_766.0));
        assert_eq!(format.stored(3.5), Stored::Exact(-32_764.0));
        assert_eq!(format.stored(70_000.0), Stored::Clipped(32_767.0));
        // 0 would be stored as BLANK.
        assert_eq!(format.stored(0.2), Stored::Clipped(-32_767.0));
    }

    #[test]
    fn verif_every_type_comes_back() {
        for bitpix in [Bitpix::U8, Bitpix::I16, Bitpix::I32, Bitpix::I64, Bitpix::F32, Bitpix::F64] {
            assert_eq!(Bitpix::from_number(bitpix.number()), Some(bitpix));
            let format = PixelFormat { bitpix, scale: 0.5, zero: 10.0, blank: None };
            let mut bytes = vec![0; 3 * bitpix.bytes()];
            let Stored::Exact(number) = format.stored(42.0) else { panic!("{bitpix:?}") };
            format.put_raw(&mut bytes, 1, number);
            let values = [0, 1, 2].map(|index| format.physical(format.raw(&bytes, index)));
            assert_eq!(values, [10.0, 42.0, 10.0], "{bitpix:?}");
        }
    }
}
