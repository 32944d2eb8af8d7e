//! Images in compressed tiles, changed tile by tile: what is not touched keeps its very bytes, and so do pixels that are not touched within a tile.
//!
//! `tile_table` knows the table that holds the tiles, `rice` and `gzip` the algorithms, `dither` the random numbers of quantised pixels, and `tile_image`
//! puts them together. Pixels are read for use through CFITSIO; here they are whole numbers as they are stored.

mod dither;
mod gzip;
mod rice;
mod tile_image;
mod tile_table;

pub(super) use tile_image::TileImage;
pub(super) use tile_table::Rebuilt;
