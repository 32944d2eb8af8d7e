//! Frames in FITS files: read, and copied with changes.
//!
//! `hdu` knows where headers and data lie, `pixel_format` what numbers mean, `frame_file` reads, `cfitsio` unpacks and packs tiles. `frame_copy` copies
//! with changes (`overlay` holds the touched pixels, `checksum` keeps the sums right, `tiles` changes compressed images) and makes new files, of `new_hdu`s with `image_values`.

mod cfitsio;
mod checksum;
mod error;
mod frame_copy;
mod frame_file;
mod hdu;
mod image_values;
mod new_hdu;
mod overlay;
mod pixel_format;
mod tiles;

pub use cfitsio::Rice;
pub use error::FrameError;
pub use frame_copy::{Changed, FrameCopy, NewImage, write_frame};
pub use frame_file::FrameFile;
pub use hdu::{HduInfo, HduKind};
pub use image_values::{ImageValues, Pixels};
pub use new_hdu::{Cells, TableColumn};
pub use pixel_format::{Bitpix, PixelFormat};
