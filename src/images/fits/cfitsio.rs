//! Interface to CFITSIO through the crate `fitsio`. This is the only file with unsafe code.
//!
//! `fitsio` owns the open files and writes pixels, columns and tiles. The functions below call `fitsio-sys` directly
//! where `fitsio` has no equivalent: opening and creating files by literal names (brackets, parentheses, `!` and
//! `mem://` have no special meaning), the status of the last write, pixels with a mark for missing values, literal
//! cards (`fitsio` writes numbers with nine digits), compression parameters, checksums, and the removal of gaps in a
//! heap.
//!
//! Threads: the bundled CFITSIO is configured with `--enable-reentrant`, so that threads may work on different files.
//! Opening and closing a file change global tables and are serialised by a lock.
#![allow(unsafe_code)]

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_ulong, c_void};
use std::path::Path;
use std::ptr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use fitsio::errors::Error as FitsioError;
use fitsio::{FileOpenMode, FitsFile};

use fitsio_sys::{
    ffclos, ffcmph, ffcmsg, ffcrhd, ffcrim, ffdkinit, ffdkopn, ffesum, ffflus, ffgcks, ffgerr, ffgmsg, ffgpv, ffmahd,
    ffppn, ffprec, ffrdef, fits_set_compression_type, fits_set_dither_seed, fits_set_quantize_dither,
    fits_set_quantize_level, fits_set_tile_dim, fitsfile,
};

use super::super::card::Card;
use crate::error::{Error, ErrorKind};

/// Codes of `fitsio.h`.
const READONLY: c_int = 0;
const READWRITE: c_int = 1;
const RICE_1: c_int = 11;
const SUBTRACTIVE_DITHER_1: c_int = 1;

/// Status of a write that failed.
const WRITE_ERROR: c_int = 106;

/// Status of a compressed tile that cannot be read: of RICE, and of the other algorithms.
const TILE_ERRORS: [c_int; 2] = [1, 414];

/// Longest message of CFITSIO, including the closing zero byte.
const MESSAGE_LENGTH: usize = 96;

/// Serialises the opening and closing of files.
static LOCK: Mutex<()> = Mutex::new(());

fn lock() -> MutexGuard<'static, ()> {
    // The lock guards no data that a panic could leave half changed.
    LOCK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Floating-point type of pixels that CFITSIO reads and writes.
pub(super) trait CPixel: Copy {
    /// Code of the type in `fitsio.h`.
    const CODE: c_int;
    /// Number that marks a pixel without a value.
    const NO_VALUE: Self;
}

impl CPixel for f32 {
    const CODE: c_int = 42;
    const NO_VALUE: Self = Self::NAN;
}

impl CPixel for f64 {
    const CODE: c_int = 82;
    const NO_VALUE: Self = Self::NAN;
}

/// Compression of an image by the RICE algorithm.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Rice {
    /// Quantisation steps per standard deviation of the noise, for floating-point pixels. 4 preserves photometry to a
    /// hundredth of the noise; 16 is finer. Integers are stored exactly.
    pub steps_per_sigma: f32,
    /// Seed of the dither, 1 to 10000. The same frame and seed give the same file.
    pub dither_seed: u16,
}

impl Default for Rice {
    fn default() -> Self {
        Self { steps_per_sigma: 4.0, dither_seed: 1 }
    }
}

/// Open file. Dropping it closes the file; [`close`](Handle::close) also returns an error if not all data were written.
pub(super) struct Handle<'a> {
    /// `None` once the file is closed.
    file: Option<FitsFile>,
    path: &'a Path,
}

impl<'a> Handle<'a> {
    /// Opens a file for reading.
    pub fn open(path: &'a Path) -> Result<Self, Error> {
        // SAFETY: the name is NUL-terminated and lives until the call returns; the other pointers are valid for
        // writing.
        Self::begin(path, READONLY, |file, name, status| unsafe { ffdkopn(file, name, READONLY, status) })
    }

    /// Opens a file for reading and writing.
    pub fn edit(path: &'a Path) -> Result<Self, Error> {
        // SAFETY: as in `open`.
        Self::begin(path, READWRITE, |file, name, status| unsafe { ffdkopn(file, name, READWRITE, status) })
    }

    /// Creates a file, which must not exist.
    pub fn create(path: &'a Path) -> Result<Self, Error> {
        // SAFETY: as in `open`.
        Self::begin(path, READWRITE, |file, name, status| unsafe { ffdkinit(file, name, status) })
    }

    fn begin(
        path: &'a Path,
        mode: c_int,
        call: impl FnOnce(*mut *mut fitsfile, *const c_char, *mut c_int) -> c_int,
    ) -> Result<Self, Error> {
        let name = c_name(path)?;
        let _guard = lock();
        let (mut file, mut status) = (ptr::null_mut(), 0);
        call(&mut file, name.as_ptr(), &mut status);
        check(path, status)?;
        let mode = if mode == READONLY { FileOpenMode::READONLY } else { FileOpenMode::READWRITE };
        // SAFETY: CFITSIO opened `file`, and nothing else owns it.
        match unsafe { FitsFile::from_raw(file, mode) } {
            Ok(file) => Ok(Self { file: Some(file), path }),
            Err(error) => {
                // SAFETY: `file` is open, and nothing uses it after this.
                unsafe { ffclos(file, &mut status) };
                Err(of_fitsio(path, error))
            }
        }
    }

    /// Applies a function of `fitsio` to the file.
    pub fn fitsio<T>(&mut self, work: impl FnOnce(&mut FitsFile) -> Result<T, FitsioError>) -> Result<T, Error> {
        let path = self.path;
        let file = self.file.as_mut().ok_or_else(|| of_fitsio(path, FitsioError::NullPointer))?;
        work(file).map_err(|error| of_fitsio(path, error))
    }

    /// Calls a function of CFITSIO with the file and a status.
    fn call(&mut self, work: impl FnOnce(*mut fitsfile, &mut c_int)) -> Result<(), Error> {
        let path = self.path;
        let file = self.file.as_mut().ok_or_else(|| of_fitsio(path, FitsioError::NullPointer))?;
        let mut status = 0;
        // SAFETY: only `work` uses the pointer, while `file` is borrowed and open.
        work(unsafe { file.as_raw() }, &mut status);
        check(path, status)
    }

    /// Writes all buffered data and closes the file.
    pub fn close(mut self) -> Result<(), Error> {
        // `fitsio` ignores the status of closing. The buffers are therefore written before, so that closing cannot
        // fail.
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffflus(file, status);
        })
    }

    /// Moves to an HDU, with HDUs counted from 0.
    pub fn go_to(&mut self, hdu: usize) -> Result<(), Error> {
        // SAFETY: the file is open; CFITSIO accepts a null pointer for a type that is not needed.
        self.call(|file, status| unsafe {
            ffmahd(file, hdu as c_int + 1, ptr::null_mut(), status);
        })
    }

    /// Reads physical values of pixels of the current image from an index on; pixels are counted row by row from 0.
    /// With `is_marked`, pixels without a value become NaN. Uncompressed floating-point pixels without a value are NaN
    /// in any case.
    pub fn read_pixels<T: CPixel>(&mut self, first: usize, values: &mut [T], is_marked: bool) -> Result<(), Error> {
        let (mut no_value, mut any) = (T::NO_VALUE, 0);
        let mark = if is_marked { (&raw mut no_value).cast::<c_void>() } else { ptr::null_mut() };
        let (count, values) = (values.len(), values.as_mut_ptr().cast::<c_void>());
        // SAFETY: `values` has space for `count` numbers of the type of `T::CODE`, `mark` points to one of them or is
        // null.
        self.call(|file, status| unsafe {
            ffgpv(file, T::CODE, first as i64 + 1, count as i64, mark, values, &mut any, status);
        })
    }

    /// Appends an HDU, given by its complete header. The data must be written afterwards.
    pub fn append_hdu(&mut self, cards: &[Card]) -> Result<(), Error> {
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffcrhd(file, status);
        })?;
        self.append_cards(cards)?;
        // SAFETY: the file is open; this reads the header and sets the position of the data.
        self.call(|file, status| unsafe {
            ffrdef(file, status);
        })
    }

    /// Appends cards to the current header.
    pub fn append_cards(&mut self, cards: &[Card]) -> Result<(), Error> {
        for card in cards {
            // The text of a card has no zeros: characters that are not ASCII are `?`.
            let text = CString::new(card.text()).unwrap_or_default();
            // SAFETY: the file is open and the text ends in a zero.
            self.call(|file, status| unsafe {
                ffprec(file, text.as_ptr(), status);
            })?;
        }
        Ok(())
    }

    /// Appends an image without a name, compressed by RICE with one tile per row. `bitpix` is a code of `fitsio.h`.
    pub fn append_rice(&mut self, rice: Rice, bitpix: c_int, [rows, columns]: [usize; 2]) -> Result<(), Error> {
        let mut tile: [c_long; 2] = [columns as c_long, 1];
        let mut axes: [c_long; 2] = [columns as c_long, rows as c_long];
        // SAFETY: the file is open and the arrays have two entries as announced; each call does nothing if `status` is
        // not 0.
        self.call(|file, status| unsafe {
            fits_set_compression_type(file, RICE_1, status);
            fits_set_tile_dim(file, 2, tile.as_mut_ptr(), status);
            fits_set_quantize_level(file, rice.steps_per_sigma, status);
            fits_set_quantize_dither(file, SUBTRACTIVE_DITHER_1, status);
            fits_set_dither_seed(file, c_int::from(rice.dither_seed.clamp(1, 10_000)), status);
            ffcrim(file, bitpix, 2, axes.as_mut_ptr(), status);
        })
    }

    /// Writes all pixels of the current image. Pixels equal to `mark` are stored as pixels without a value.
    pub fn write_marked<T: CPixel>(&mut self, values: &mut [T], mut mark: T) -> Result<(), Error> {
        let (count, values) = (values.len(), values.as_mut_ptr().cast::<c_void>());
        let mark = (&raw mut mark).cast::<c_void>();
        // SAFETY: `values` contains `count` numbers of the type of `T::CODE`, `mark` points to one more.
        self.call(|file, status| unsafe {
            ffppn(file, T::CODE, 1, count as i64, values, mark, status);
        })
    }

    /// Removes gaps from the heap of the current table.
    pub fn compact_heap(&mut self) -> Result<(), Error> {
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffcmph(file, status);
        })
    }

    /// Returns the two sums of the current HDU: that of its data, for DATASUM, and that of the whole HDU, for CHECKSUM.
    pub fn sums(&mut self) -> Result<[c_ulong; 2], Error> {
        let [mut data, mut all] = [0, 0];
        // SAFETY: the file is open, and the pointers to both sums are valid for writing.
        self.call(|file, status| unsafe {
            ffgcks(file, &mut data, &mut all, status);
        })?;
        Ok([data, all])
    }
}

impl Drop for Handle<'_> {
    fn drop(&mut self) {
        let _guard = lock();
        drop(self.file.take());
        clear_messages();
    }
}

/// Returns the 16 letters and digits of CHECKSUM with which the sum of the HDU becomes all ones.
pub(super) fn checksum_text(sum: c_ulong) -> String {
    let mut text = [0; 17];
    // SAFETY: the buffer has space for 16 characters and a zero.
    unsafe { ffesum(sum, 1, text.as_mut_ptr()) };
    text_of(&text)
}

fn c_name(path: &Path) -> Result<CString, Error> {
    // CFITSIO interprets a blank or a tilde at the beginning of a name; a folder before the name prevents that.
    let path = if path.is_relative() { &Path::new(".").join(path) } else { path };
    CString::new(path.as_os_str().as_encoded_bytes()).map_err(|error| {
        Error::caused(ErrorKind::File, std::io::Error::new(std::io::ErrorKind::InvalidInput, error)).in_file("", path)
    })
}

fn of_fitsio(path: &Path, error: FitsioError) -> Error {
    let message = match error {
        FitsioError::Fits(error) => return failed(path, error.status),
        FitsioError::Utf8(_) => "the name of the file is not UTF-8".to_owned(),
        other => other.to_string(),
    };
    clear_messages();
    Error::new(ErrorKind::File, format!("CFITSIO: {message} (status 0)")).in_file("", path)
}

fn check(path: &Path, status: c_int) -> Result<(), Error> {
    if status == 0 { Ok(()) } else { Err(failed(path, status)) }
}

/// Returns an error for a status, with the first message of CFITSIO.
fn failed(path: &Path, status: c_int) -> Error {
    let mut buffer = [0; MESSAGE_LENGTH];
    // SAFETY: the short text of a status is at most 30 characters long.
    unsafe { ffgerr(status, buffer.as_mut_ptr()) };
    let mut message =
        if TILE_ERRORS.contains(&status) { "damaged compressed data".to_owned() } else { text_of(&buffer) };
    buffer = [0; MESSAGE_LENGTH];
    // SAFETY: messages are at most 80 characters long.
    if unsafe { ffgmsg(buffer.as_mut_ptr()) } != 0 {
        message = format!("{message}: {}", text_of(&buffer).trim_end_matches(':'));
    }
    if status == WRITE_ERROR {
        message.push_str("; the disk may be full");
    }
    clear_messages();
    Error::new(ErrorKind::File, format!("CFITSIO: {message} (status {status})")).in_file("", path)
}

/// Converts a text that ends in a zero byte; the last byte of the buffer is always zero.
fn text_of<const N: usize>(buffer: &[c_char; N]) -> String {
    // SAFETY: the buffer was all zero, and CFITSIO ends its texts with a zero within it.
    unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().trim().to_owned()
}

fn clear_messages() {
    // SAFETY: the function has no arguments and clears CFITSIO's list of messages.
    unsafe { ffcmsg() };
}
