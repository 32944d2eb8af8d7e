//! What can go wrong with frames in files.

use std::io;
use std::path::{Path, PathBuf};

/// A value of a header that is refused: keyword, value, and what is allowed.
pub(super) type Refused = (String, String, String);

/// A file that is no frame, or cannot be read or written. Every one names the file; whatever happens, the input stays as it is and no half output appears.
#[derive(Debug, thiserror::Error)]
pub enum FrameError {
    /// What the system said.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A compressed file that must be unpacked first.
    #[error("{}: is packed with {packer}; unpack it first (FITS and the tiles of .fz are read)", path.display())]
    Packed {
        /// The file.
        path: PathBuf,
        /// gzip, bzip2, xz, zip, compress.
        packer: &'static str,
    },
    /// No FITS at all.
    #[error("{}: is no FITS file (it begins with {begin:?}; FITS begins with \"SIMPLE  =\")", path.display())]
    NotFits {
        /// The file.
        path: PathBuf,
        /// Its first characters.
        begin: String,
    },
    /// The file ends too early.
    #[error("{}: HDU {hdu} is cut off: {what} needs {needed} bytes, the file has {length}", path.display())]
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
    /// A header that says nothing usable of its data.
    #[error("{}: HDU {hdu}: {keyword} is {value}: {allowed}", path.display())]
    Keyword {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// The keyword.
        keyword: String,
        /// What stands there; "missing" where nothing does.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// Bytes between or behind HDUs that belong to none.
    #[error("{}: at byte {at}, behind HDU {hdu}, no header begins ({begin:?}); are its NAXISn right?", path.display())]
    NoHeader {
        /// The file.
        path: PathBuf,
        /// Number of the HDU before, from 0.
        hdu: usize,
        /// Where, bytes.
        at: u64,
        /// The first characters there.
        begin: String,
    },
    /// An HDU that is not there.
    #[error("{}: has no HDU {hdu}; it has 0 to {last}", path.display())]
    NoHdu {
        /// The file.
        path: PathBuf,
        /// The number asked for.
        hdu: usize,
        /// The last number there is.
        last: usize,
    },
    /// An HDU that holds no image of two axes.
    #[error("{}: HDU {hdu} is {is}, no image of two axes; images are {}", path.display(), if images.is_empty() { "nowhere in it".to_owned() } else { format!("{images:?}") })]
    NoImage {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// What it is.
        is: String,
        /// HDUs that do hold images.
        images: Vec<usize>,
    },
    /// Pixels outside of an image.
    #[error("{}: HDU {hdu} has {columns} columns and {rows} rows; columns {first} to {last} of row {row} are not in it", path.display())]
    Outside {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// Its columns.
        columns: usize,
        /// Its rows.
        rows: usize,
        /// Row asked for, from 0.
        row: usize,
        /// First column asked for, from 0.
        first: usize,
        /// Last column asked for, from 0.
        last: usize,
    },
    /// Compressed pixels that cannot be unpacked, or not be packed again.
    #[error("{}: HDU {hdu}: {why}", path.display())]
    Tiles {
        /// The file.
        path: PathBuf,
        /// Number of the HDU, from 0.
        hdu: usize,
        /// The cause, and what can be done.
        why: String,
    },
    /// What CFITSIO said.
    #[error("{}: CFITSIO: {message} (status {status})", path.display())]
    Cfitsio {
        /// The file.
        path: PathBuf,
        /// Its number for it.
        status: i32,
        /// Its words.
        message: String,
    },
    /// The output would be the input.
    #[error("{}: is the input as well; the output needs another name", path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// A table or image to be written whose parts do not fit together.
    #[error("{name:?} cannot be written: {why}")]
    Malformed {
        /// Name of the extension.
        name: String,
        /// The cause.
        why: String,
    },
}

impl FrameError {
    /// A value of a header that is not allowed.
    pub(super) fn refused(path: &Path, hdu: usize, (keyword, value, allowed): Refused) -> Self {
        Self::Keyword { path: path.to_owned(), hdu, keyword, value, allowed }
    }

    /// The same error of CFITSIO with the name of the file that was meant.
    pub(super) fn of_file(self, path: &Path) -> Self {
        match self {
            Self::Cfitsio { status, message, .. } => Self::Cfitsio { path: path.to_owned(), status, message },
            other => other,
        }
    }

    /// Error of the system with a file.
    pub(super) fn io(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        |source| Self::Io { path: path.to_owned(), source }
    }
}
