//! Frames in FITS files: read, and copied with changes.
//!
//! `hdu` knows where headers and data lie, `pixel_format` what numbers mean, `frame_file` reads, `cfitsio` unpacks and packs tiles. `frame_copy` copies
//! with changes: `pixel_edit` holds those of an image (`deltas` light to be added, `overlay` changed bytes, `tiles` compressed images, `changed` what came
//! of it), `output` with `checksum` writes headers and data, `chunks` pixels, several chunks at once. `new_frame` makes files of `new_hdu`s, whose pixels are `image_values`.

mod cfitsio;
mod changed;
mod checksum;
mod chunks;
mod deltas;
mod error;
mod frame_copy;
mod frame_file;
mod hdu;
mod image_values;
mod new_frame;
mod new_hdu;
mod output;
mod overlay;
mod pixel_edit;
mod pixel_format;
mod positioned;
mod room;
mod tiles;

pub use cfitsio::Rice;
pub use changed::Changed;
pub use error::FrameError;
pub use frame_copy::FrameCopy;
pub use frame_file::FrameFile;
pub use hdu::{HduInfo, HduKind};
pub use image_values::{ImageValues, Pixels};
pub use new_frame::{NewImage, write_frame};
pub use new_hdu::{Cells, TableColumn};
pub use pixel_format::{Bitpix, PixelFormat};
