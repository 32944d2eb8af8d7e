//! CFITSIO, for compressed tiles of any algorithm: the one file with unsafe code.
//!
//! Files are opened and made by their plain names (`fits_open_diskfile`, `fits_create_diskfile`): brackets, parentheses and exclamation marks in a
//! name mean nothing. One handle serves one call and is closed before it returns.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_void};
use std::path::Path;
use std::ptr;

use fitsio_sys::{
    ffclos, ffcmsg, ffcrim, ffdkinit, ffdkopn, ffgerr, ffgmsg, ffgpxv, ffmahd, ffppn, fits_set_compression_type,
    fits_set_dither_seed, fits_set_quantize_dither, fits_set_quantize_level, fits_set_tile_dim, fitsfile,
};

use super::error::FrameError;
use super::image_values::ImageValues;

/// Codes of `fitsio.h`.
const READONLY: c_int = 0;
const RICE_1: c_int = 11;
const SUBTRACTIVE_DITHER_1: c_int = 1;

/// Longest message of CFITSIO with its closing zero.
const MESSAGE_LENGTH: usize = 96;

/// A number that CFITSIO reads pixels into.
pub(super) trait CPixel: Copy {
    /// Its code in `fitsio.h`.
    const CODE: c_int;
    /// What stands for no value.
    const NOTHING: Self;
}

impl CPixel for f32 {
    const CODE: c_int = 42;
    const NOTHING: Self = Self::NAN;
}

impl CPixel for f64 {
    const CODE: c_int = 82;
    const NOTHING: Self = Self::NAN;
}

/// How floating pixels are compressed by RICE.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Rice {
    /// Steps per standard deviation of the noise, for floating pixels: 4 keeps photometry to a hundredth of the noise; 16 is finer. Whole numbers are kept exactly.
    pub steps_per_sigma: f32,
    /// Seed of the dither, 1 to 10000: the same frame and seed give the same file.
    pub dither_seed: u16,
}

impl Default for Rice {
    fn default() -> Self {
        Self { steps_per_sigma: 4.0, dither_seed: 1 }
    }
}

/// A file opened by CFITSIO; closed when dropped.
struct Handle<'a> {
    file: *mut fitsfile,
    path: &'a Path,
}

impl<'a> Handle<'a> {
    /// Opens a file for reading, or makes a new one.
    fn begin(path: &'a Path, makes: bool) -> Result<Self, FrameError> {
        let name = c_name(path)?;
        let (mut file, mut status) = (ptr::null_mut(), 0);
        // SAFETY: `name` ends in a zero and lives through the call; `file` and `status` are valid places to write to.
        unsafe {
            if makes {
                ffdkinit(&mut file, name.as_ptr(), &mut status);
            } else {
                ffdkopn(&mut file, name.as_ptr(), READONLY, &mut status);
            }
        }
        check(path, status)?;
        Ok(Self { file, path })
    }

    fn check(&self, status: c_int) -> Result<(), FrameError> {
        check(self.path, status)
    }

    /// Closes it: what was written is in the file only if this succeeds.
    fn close(mut self) -> Result<(), FrameError> {
        let mut status = 0;
        let file = std::mem::replace(&mut self.file, ptr::null_mut());
        // SAFETY: `file` was opened by CFITSIO and is closed once: the field is null from here on.
        unsafe { ffclos(file, &mut status) };
        self.check(status)
    }
}

impl Drop for Handle<'_> {
    fn drop(&mut self) {
        if !self.file.is_null() {
            let mut status = 0;
            // SAFETY: it is open, and nobody uses it after this.
            unsafe { ffclos(self.file, &mut status) };
            clear_messages();
        }
    }
}

/// All pixels of an image, physical values, into `values`; NaN where there is none.
pub(super) fn read_image<T: CPixel>(path: &Path, hdu: usize, axes: usize, values: &mut [T]) -> Result<(), FrameError> {
    let handle = Handle::begin(path, false)?;
    let mut status = 0;
    // SAFETY: the handle is open; CFITSIO counts HDUs from 1.
    unsafe { ffmahd(handle.file, hdu as c_int + 1, ptr::null_mut(), &mut status) };
    handle.check(status)?;
    let mut first: Vec<c_long> = vec![1; axes];
    let (mut nothing, mut any) = (T::NOTHING, 0);
    // SAFETY: `first` has one entry an axis, `values` room for as many pixels of type `T` (whose code is `T::CODE`) as are asked for, `nothing` is one.
    unsafe {
        ffgpxv(
            handle.file,
            T::CODE,
            first.as_mut_ptr(),
            values.len() as _,
            (&raw mut nothing).cast::<c_void>(),
            values.as_mut_ptr().cast::<c_void>(),
            &mut any,
            &mut status,
        )
    };
    handle.check(status)?;
    handle.close()
}

/// Makes a file with one image compressed by RICE, one row a tile, in HDU 1.
pub(super) fn write_rice(path: &Path, image: &ImageValues, rice: Rice) -> Result<(), FrameError> {
    let [rows, columns] = image.size();
    let handle = Handle::begin(path, true)?;
    let mut status = 0;
    let mut tile: [c_long; 2] = [columns as c_long, 1];
    let mut axes: [c_long; 2] = [columns as c_long, rows as c_long];
    let mut bytes = image.native_bytes();
    let mut nothing = image.native_nothing();
    let mark = nothing.as_mut().map_or(ptr::null_mut(), |bytes| bytes.as_mut_ptr().cast::<c_void>());
    // SAFETY: the handle is open, arrays have the two entries that are announced, and `bytes` holds rows times columns pixels of the type that
    // `cfitsio_codes` names, in the machine's order; `mark` points to one more or is null; each call does nothing where `status` is not zero.
    unsafe {
        let (bitpix, datatype) = image.cfitsio_codes();
        fits_set_compression_type(handle.file, RICE_1, &mut status);
        fits_set_tile_dim(handle.file, 2, tile.as_mut_ptr(), &mut status);
        fits_set_quantize_level(handle.file, rice.steps_per_sigma, &mut status);
        fits_set_quantize_dither(handle.file, SUBTRACTIVE_DITHER_1, &mut status);
        fits_set_dither_seed(handle.file, c_int::from(rice.dither_seed.clamp(1, 10_000)), &mut status);
        ffcrim(handle.file, bitpix, 2, axes.as_mut_ptr(), &mut status);
        ffppn(handle.file, datatype, 1, (rows * columns) as _, bytes.as_mut_ptr().cast::<c_void>(), mark, &mut status);
    }
    handle.check(status)?;
    handle.close()
}

fn c_name(path: &Path) -> Result<CString, FrameError> {
    CString::new(path.as_os_str().as_encoded_bytes()).map_err(|error| FrameError::Io {
        path: path.to_owned(),
        source: std::io::Error::new(std::io::ErrorKind::InvalidInput, error),
    })
}

fn check(path: &Path, status: c_int) -> Result<(), FrameError> {
    if status == 0 {
        return Ok(());
    }
    let text = |buffer: &[c_char; MESSAGE_LENGTH]| {
        // SAFETY: CFITSIO ends its messages with a zero, and the buffer was all zero before.
        unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().trim().to_owned()
    };
    let mut buffer = [0; MESSAGE_LENGTH];
    // SAFETY: the short text of a status is at most 30 characters long.
    unsafe { ffgerr(status, buffer.as_mut_ptr()) };
    let mut message = text(&buffer);
    buffer = [0; MESSAGE_LENGTH];
    // SAFETY: messages are at most 80 characters long.
    if unsafe { ffgmsg(buffer.as_mut_ptr()) } != 0 {
        message = format!("{message}: {}", text(&buffer));
    }
    clear_messages();
    Err(FrameError::Cfitsio { path: path.to_owned(), status, message })
}

fn clear_messages() {
    // SAFETY: it takes nothing and empties CFITSIO's list of messages.
    unsafe { ffcmsg() };
}
