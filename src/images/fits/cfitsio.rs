//! CFITSIO through the crate `fitsio`: the one file with unsafe code.
//!
//! `fitsio` owns the open files and writes pixels, columns and tiles. The calls below go to `fitsio-sys` because `fitsio` has none for
//! them: opening and creating files by plain names (brackets, parentheses, `!`, `mem://` mean nothing in a name), the result of the
//! last write, pixels with a mark for those without a value, cards as they stand (`fitsio` writes numbers with nine digits), the
//! parameters of compression, checksums, and the compaction of a heap.
//!
//! Threads: the bundled CFITSIO is configured with `--enable-reentrant`, so that threads may work on files of their own. Opening and
//! closing change tables that all files share; they are serialised by one lock.
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
use super::error::FrameError;

/// Codes of `fitsio.h`.
const READONLY: c_int = 0;
const READWRITE: c_int = 1;
const RICE_1: c_int = 11;
const SUBTRACTIVE_DITHER_1: c_int = 1;

/// Status of a write that failed.
const WRITE_ERROR: c_int = 106;

/// Longest message of CFITSIO with its closing zero.
const MESSAGE_LENGTH: usize = 96;

/// Serialises opening and closing.
static LOCK: Mutex<()> = Mutex::new(());

fn lock() -> MutexGuard<'static, ()> {
    // The lock guards no data that a panic could leave half changed.
    LOCK.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A floating type that CFITSIO reads pixels into and writes them from.
pub(super) trait CPixel: Copy {
    /// Code of the type in `fitsio.h`.
    const CODE: c_int;
    /// Value of a pixel without a value.
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

/// Compression of an image by RICE.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Rice {
    /// Steps per standard deviation of the noise, for floating pixels: 4 keeps photometry to a hundredth of the noise; 16 is finer. Whole
    /// numbers are kept exactly.
    pub steps_per_sigma: f32,
    /// Seed of the dither, 1 to 10000: the same frame and seed give the same file.
    pub dither_seed: u16,
}

impl Default for Rice {
    fn default() -> Self {
        Self { steps_per_sigma: 4.0, dither_seed: 1 }
    }
}

/// An open file. Dropping it closes it; [`close`](Handle::close) reports whether all that was written arrived.
pub(super) struct Handle<'a> {
    /// `None` once it is closed.
    file: Option<FitsFile>,
    path: &'a Path,
}

impl<'a> Handle<'a> {
    /// Opens a file for reading.
    pub fn open(path: &'a Path) -> Result<Self, FrameError> {
        // SAFETY: the name ends in a zero and lives through the call; the other pointers are valid places to write to.
        Self::begin(path, READONLY, |file, name, status| unsafe { ffdkopn(file, name, READONLY, status) })
    }

    /// Opens a file for reading and writing.
    pub fn edit(path: &'a Path) -> Result<Self, FrameError> {
        // SAFETY: as in `open`.
        Self::begin(path, READWRITE, |file, name, status| unsafe { ffdkopn(file, name, READWRITE, status) })
    }

    /// Creates a file; it must not exist.
    pub fn create(path: &'a Path) -> Result<Self, FrameError> {
        // SAFETY: as in `open`.
        Self::begin(path, READWRITE, |file, name, status| unsafe { ffdkinit(file, name, status) })
    }

    fn begin(
        path: &'a Path,
        mode: c_int,
        call: impl FnOnce(*mut *mut fitsfile, *const c_char, *mut c_int) -> c_int,
    ) -> Result<Self, FrameError> {
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

    /// Works on the file by the functions of `fitsio`.
    pub fn fitsio<T>(&mut self, work: impl FnOnce(&mut FitsFile) -> Result<T, FitsioError>) -> Result<T, FrameError> {
        let path = self.path;
        let file = self.file.as_mut().ok_or_else(|| of_fitsio(path, FitsioError::NullPointer))?;
        work(file).map_err(|error| of_fitsio(path, error))
    }

    /// Calls functions of CFITSIO with the file and a status.
    fn call(&mut self, work: impl FnOnce(*mut fitsfile, &mut c_int)) -> Result<(), FrameError> {
        let path = self.path;
        let file = self.file.as_mut().ok_or_else(|| of_fitsio(path, FitsioError::NullPointer))?;
        let mut status = 0;
        // SAFETY: the pointer is used by `work` alone, while `file` is borrowed and open.
        work(unsafe { file.as_raw() }, &mut status);
        check(path, status)
    }

    /// Writes all that is held in buffers and closes the file.
    pub fn close(mut self) -> Result<(), FrameError> {
        // `fitsio` drops the status of closing; after this call there is nothing left that could fail.
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffflus(file, status);
        })
    }

    /// Goes to an HDU, counted from 0.
    pub fn go_to(&mut self, hdu: usize) -> Result<(), FrameError> {
        // SAFETY: the file is open; CFITSIO takes a null pointer for a type that is not wanted.
        self.call(|file, status| unsafe {
            ffmahd(file, hdu as c_int + 1, ptr::null_mut(), status);
        })
    }

    /// Reads pixels of the current image from one on, counted row after row from 0: physical values. With `is_marked` those without a
    /// value become NaN; floating pixels that are not compressed are NaN anyway.
    pub fn read_pixels<T: CPixel>(
        &mut self,
        first: usize,
        values: &mut [T],
        is_marked: bool,
    ) -> Result<(), FrameError> {
        let (mut nothing, mut any) = (T::NOTHING, 0);
        let mark = if is_marked { (&raw mut nothing).cast::<c_void>() } else { ptr::null_mut() };
        let (count, values) = (values.len(), values.as_mut_ptr().cast::<c_void>());
        // SAFETY: `values` has room for `count` numbers of the type that `T::CODE` names, `mark` points to one of them or is null.
        self.call(|file, status| unsafe {
            ffgpv(file, T::CODE, first as i64 + 1, count as i64, mark, values, &mut any, status);
        })
    }

    /// Adds an HDU behind all others from its whole header; the data are written after that.
    pub fn append_hdu(&mut self, cards: &[Card]) -> Result<(), FrameError> {
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffcrhd(file, status);
        })?;
        self.append_cards(cards)?;
        // SAFETY: the file is open; the header is read and the place of the data known from here on.
        self.call(|file, status| unsafe {
            ffrdef(file, status);
        })
    }

    /// Adds cards behind those of the current header.
    pub fn append_cards(&mut self, cards: &[Card]) -> Result<(), FrameError> {
        for card in cards {
            // Text of a card has no zeros: what is not ASCII is shown as `?`.
            let text = CString::new(card.text()).unwrap_or_default();
            // SAFETY: the file is open and the text ends in a zero.
            self.call(|file, status| unsafe {
                ffprec(file, text.as_ptr(), status);
            })?;
        }
        Ok(())
    }

    /// Adds an image to be compressed by RICE, one row a tile, without a name. `bitpix` is one of `fitsio.h`.
    pub fn append_rice(&mut self, rice: Rice, bitpix: c_int, [rows, columns]: [usize; 2]) -> Result<(), FrameError> {
        let mut tile: [c_long; 2] = [columns as c_long, 1];
        let mut axes: [c_long; 2] = [columns as c_long, rows as c_long];
        // SAFETY: the file is open and arrays have the two entries that are announced; each call does nothing where `status` is not 0.
        self.call(|file, status| unsafe {
            fits_set_compression_type(file, RICE_1, status);
            fits_set_tile_dim(file, 2, tile.as_mut_ptr(), status);
            fits_set_quantize_level(file, rice.steps_per_sigma, status);
            fits_set_quantize_dither(file, SUBTRACTIVE_DITHER_1, status);
            fits_set_dither_seed(file, c_int::from(rice.dither_seed.clamp(1, 10_000)), status);
            ffcrim(file, bitpix, 2, axes.as_mut_ptr(), status);
        })
    }

    /// Writes all pixels of the current image; those equal to `mark` get no value.
    pub fn write_marked<T: CPixel>(&mut self, values: &mut [T], mut mark: T) -> Result<(), FrameError> {
        let (count, values) = (values.len(), values.as_mut_ptr().cast::<c_void>());
        let mark = (&raw mut mark).cast::<c_void>();
        // SAFETY: `values` holds `count` numbers of the type that `T::CODE` names, `mark` points to one more.
        self.call(|file, status| unsafe {
            ffppn(file, T::CODE, 1, count as i64, values, mark, status);
        })
    }

    /// Removes gaps from the heap of the current table.
    pub fn compact_heap(&mut self) -> Result<(), FrameError> {
        // SAFETY: the file is open.
        self.call(|file, status| unsafe {
            ffcmph(file, status);
        })
    }

    /// Sums of the current HDU for DATASUM and CHECKSUM: of its data, and of all of it.
    pub fn sums(&mut self) -> Result<[c_ulong; 2], FrameError> {
        let [mut data, mut all] = [0, 0];
        // SAFETY: the file is open, and both sums are valid places to write to.
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

/// The 16 letters and digits of CHECKSUM that bring the sum of an HDU to all ones.
pub(super) fn checksum_text(sum: c_ulong) -> String {
    let mut text = [0; 17];
    // SAFETY: there is room for 16 characters and a zero.
    unsafe { ffesum(sum, 1, text.as_mut_ptr()) };
    text_of(&text)
}

fn c_name(path: &Path) -> Result<CString, FrameError> {
    // A blank or a tilde at the beginning has a meaning for CFITSIO; a folder before it takes that away.
    let path = if path.is_relative() { &Path::new(".").join(path) } else { path };
    CString::new(path.as_os_str().as_encoded_bytes()).map_err(|error| FrameError::Io {
        path: path.to_owned(),
        source: std::io::Error::new(std::io::ErrorKind::InvalidInput, error),
    })
}

fn of_fitsio(path: &Path, error: FitsioError) -> FrameError {
    let message = match error {
        FitsioError::Fits(error) => return failed(path, error.status),
        FitsioError::Utf8(_) => "names of files must be UTF-8".to_owned(),
        other => other.to_string(),
    };
    clear_messages();
    FrameError::Cfitsio { path: path.to_owned(), status: 0, message }
}

fn check(path: &Path, status: c_int) -> Result<(), FrameError> {
    if status == 0 { Ok(()) } else { Err(failed(path, status)) }
}

/// The error of a status, with CFITSIO's first message.
fn failed(path: &Path, status: c_int) -> FrameError {
    let mut buffer = [0; MESSAGE_LENGTH];
    // SAFETY: the short text of a status is at most 30 characters long.
    unsafe { ffgerr(status, buffer.as_mut_ptr()) };
    let mut message = text_of(&buffer);
    buffer = [0; MESSAGE_LENGTH];
    // SAFETY: messages are at most 80 characters long.
    if unsafe { ffgmsg(buffer.as_mut_ptr()) } != 0 {
        message = format!("{message}: {}", text_of(&buffer).trim_end_matches(':'));
    }
    if status == WRITE_ERROR {
        message.push_str("; is the disk full?");
    }
    clear_messages();
    FrameError::Cfitsio { path: path.to_owned(), status, message }
}

/// Text that ends in a zero; the last character of a buffer is always one.
fn text_of<const N: usize>(buffer: &[c_char; N]) -> String {
    // SAFETY: the buffer was all zero, and CFITSIO ends its texts with a zero within it.
    unsafe { CStr::from_ptr(buffer.as_ptr()) }.to_string_lossy().trim().to_owned()
}

fn clear_messages() {
    // SAFETY: it takes nothing and empties CFITSIO's list of messages.
    unsafe { ffcmsg() };
}
