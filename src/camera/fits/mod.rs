//! Frames in FITS files: read, and copied with changes.
//!
//! `hdu` knows where headers and data lie, `pixel_format` what numbers mean, `frame_file` reads, `cfitsio` unpacks and packs tiles, `image_values`
//! are pixels to be written, and `error` says what went wrong.

mod cfitsio;
mod error;
mod frame_file;
mod hdu;
mod image_values;
mod pixel_format;

pub use cfitsio::Rice;
pub use error::FrameError;
pub use frame_file::FrameFile;
pub use hdu::{HduInfo, HduKind};
pub use image_values::{ImageValues, Pixels};
pub use pixel_format::{Bitpix, PixelFormat};
