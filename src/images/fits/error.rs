//! Errors of frames in files.

use std::io;
use std::path::{Path, PathBuf};

/// Invalid value in a header: keyword, value, and allowed values.
pub(super) type InvalidValue = (String, String, String);

/// Errors of reading and writing FITS files. Every message names the file. The input is never changed, and no partial
/// output remains.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// The system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The whole file is compressed.
    #[error("{}: compressed with {packer}; decompress it first (FITS files and compressed tiles in .fz files are supported)", path.display())]
    Packed {
        /// The file.
        path: PathBuf,
        /// gzip, bzip2, xz, zip, compress.
        packer: &'static str,
    },
    /// The file is not a FITS file.
    #[error("{}: not a FITS file (it begins with {begin:?}; FITS begins with \"SIMPLE  =\")", path.display())]
    NotFits {
        /// The file.
        path: PathBuf,
        /// Its first characters.
        begin: String,
    },
    /// The file is truncated.
    #[error("{}: HDU {hdu} is truncated: {what} needs {needed} bytes, the file has {length}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Its header or its data.
        what: &'static str,
        /// Length the file must have, bytes.
        needed: u64,
        /// Length it has, bytes.
        length: u64,
    },
    /// A header does not describe its data.
    #[error("{}: HDU {hdu}: {keyword} is {value}; allowed: {allowed}", path.display())]
    Keyword {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// The keyword.
        keyword: String,
        /// Given value; "missing" if there is none.
        value: String,
        /// Allowed values.
        allowed: String,
    },
    /// Bytes between or after HDUs belong to none.
    #[error("{}: no header begins after HDU {hdu} at byte {at} ({begin:?}); check the NAXISn of that HDU", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
        /// Number of the HDU before, from 0.
        hdu: usize,
        /// Position of the bytes.
        at: u64,
        /// First characters there.
        begin: String,
    },
    /// The file has no such HDU.
    #[error("{}: no HDU {hdu}; allowed: 0 to {last}", path.display())]
    NoHdu {
        /// The file.
        path: PathBuf,
        /// Requested number.
        hdu: usize,
        /// Last number in the file.
        last: usize,
    },
    /// An HDU is not an image of two axes.
    #[error("{}: HDU {hdu} is {is}, not an image of two axes; HDUs with images: {}", path.display(), if images.is_empty() { "none".to_owned() } else { format!("{images:?}") })]
    NoImage {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Description of the HDU.
        is: String,
        /// HDUs with images.
        images: Vec<usize>,
    },
    /// Pixels are outside of an image.
    #[error("{}: columns {first} to {last} of row {row} are outside HDU {hdu}, which has {columns} columns and {rows} rows", path.display())]
    Outside {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Columns of the image.
        columns: usize,
        /// Rows of the image.
        rows: usize,
        /// Requested row, from 0.
        row: usize,
        /// First requested column, from 0.
        first: usize,
        /// Last requested column, from 0.
        last: usize,
    },
    /// Compressed pixels cannot be decompressed or not be compressed again.
    #[error("{}: HDU {hdu}: {why}", path.display())]
    Tiles {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Cause, and a remedy.
        why: String,
    },
    /// CFITSIO reported an error.
    #[error("{}: CFITSIO: {message} (status {status})", path.display())]
    Cfitsio {
        /// The file.
        path: PathBuf,
        /// Status of CFITSIO.
        status: i32,
        /// Message of CFITSIO.
        message: String,
    },
    /// The output is the input.
    #[error("{}: the output is also the input; specify another output", path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// The parts of a table or image to be written are inconsistent.
    #[error("cannot write {name:?}: {why}")]
    Malformed {
        /// Name of the extension.
        name: String,
        /// The cause.
        why: String,
    },
}

impl FrameError {
    /// Creates the error of an invalid value in a header.
    pub(super) fn invalid_value(path: &Path, hdu: usize, (keyword, value, allowed): InvalidValue) -> Self {
        Self::Keyword { path: path.to_owned(), hdu, keyword, value, allowed }
    }

    /// Replaces the name of the file in an error of CFITSIO.
    pub(super) fn of_file(self, path: &Path) -> Self {
        match self {
            Self::Cfitsio { status, message, .. } => Self::Cfitsio { path: path.to_owned(), status, message },
            other => other,
        }
    }

    /// Returns a function that creates the error of the system for a file.
    pub(super) fn io(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }
}
