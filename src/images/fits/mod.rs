//! Frames in FITS files: reading, copies with changes, and new files.
//!
//! `hdu` finds headers and data; `tile_header` and `tile_table` check compressed images. These checks precede CFITSIO
//! (`cfitsio`). `frame_file` reads a file, `binary_table` its tables, and `planes` distinguishes frames from masks and
//! maps. `frame_copy` writes a copy with changes: `deltas` collects the added light and counts changed pixels,
//! `pixel_format` converts stored numbers, `tiles` changes compressed images, and `dither` provides random numbers for
//! rounding. `new_hdu` creates images and tables.

mod binary_table;
mod cfitsio;
mod deltas;
mod dither;
mod frame_copy;
mod frame_file;
mod hdu;
mod new_hdu;
mod pixel_format;
mod planes;
mod tile_header;
mod tile_table;
mod tiles;

pub use binary_table::{BinaryCells, BinaryColumn};
pub use cfitsio::Rice;
pub use deltas::Changed;
pub use frame_copy::FrameCopy;
pub use frame_file::FrameFile;
pub use hdu::HduKind;
pub use new_hdu::{Cells, NewImage, TableColumn, write_frame, write_table};
pub use pixel_format::{Bitpix, ImageValues, Pixels};
pub use planes::{CompanionPlane, FrameImages, PlaneKind};
