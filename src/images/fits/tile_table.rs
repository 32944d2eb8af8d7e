//! Table with the tiles of a compressed image, and checks of its rows that CFITSIO does not make.
//!
//! CFITSIO allocates the lengths that the descriptors of tiles give, and writes as many pixels as a compressed stream
//! announces. Before CFITSIO reads the table, both are compared with the size of the file and of the tiles.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::super::header::Header;
use super::hdu::{HduInfo, HduKind};
use super::tile_header::{COMPRESSED, Column, UNCOMPRESSED, check_compressed, columns};
use crate::error::Error;
use crate::input;

/// Rows of the table, and sizes of the image and its tiles.
#[derive(Debug)]
pub(super) struct TileTable {
    columns: Vec<Column>,
    bytes: Vec<u8>,
    row_length: usize,
    /// Numbers of pixels along each axis, of the image and of a tile.
    sides: Vec<usize>,
    tile: Vec<usize>,
}

impl TileTable {
    /// Reads the rows of the table of a compressed image and checks that each tile lies in the heap and has a length
    /// that is possible for its pixels.
    ///
    /// # Errors
    /// Invalid keywords, invalid tiles, and errors of the operating system.
    pub fn read(path: &Path, info: &HduInfo, header: &Header) -> Result<Self, Error> {
        let io = Error::io(path);
        let of_hdu = |error: Error| error.in_hdu(path, info.index);
        let [sides, tile] = check_compressed(header).map_err(of_hdu)?;
        let columns = columns(header).map_err(of_hdu)?;
        let count = |keyword: &str| header.integer(keyword).map_or(0, |number| number as usize);
        let (row_length, rows) = (count("NAXIS1"), count("NAXIS2"));
        let mut file = input::open(path).map_err(&io)?;
        file.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
        let mut bytes = vec![0; row_length * rows];
        file.read_exact(&mut bytes).map_err(&io)?;
        let table = Self { columns, bytes, row_length, sides, tile };
        let heap = if header.contains("THEAP") { count("THEAP") } else { row_length * rows };
        let heap_length = info.data_length - heap as u64;
        let mut begin = |offset: u64, length: usize| -> Result<Vec<u8>, Error> {
            let mut bytes = vec![0; length];
            file.seek(SeekFrom::Start(info.data_at + heap as u64 + offset)).map_err(&io)?;
            file.read_exact(&mut bytes).map_err(&io)?;
            Ok(bytes)
        };
        for row in 0..rows {
            let pixels = table.pixels(row);
            for column in table.columns.iter().filter(|column| column.variable.is_some()) {
                let broken = |why: &str| {
                    Error::format(format!("{} of tile {}: {why}", column.name, row + 1)).in_hdu(path, info.index)
                };
                let (count, size) = table.length(column, row);
                let (offset, length) = (table.offset(column, row), count.saturating_mul(size));
                if offset.checked_add(length).is_none_or(|end| end > heap_length) {
                    return Err(broken(&format!(
                        "{length} bytes from byte {offset} on are not in the heap of {heap_length} bytes"
                    )));
                }
                let most = if column.name == UNCOMPRESSED { pixels } else { 16 * pixels + 4096 };
                if count > most {
                    return Err(broken(&format!("{count} elements for {pixels} pixels")));
                }
                let is_packed = column.name == COMPRESSED && count > 0;
                let is_sound = match &info.kind {
                    HduKind::CompressedImage(name) if is_packed && name == "HCOMPRESS_1" => {
                        count >= 25 && is_sound_hcompress(&begin(offset, 25)?, pixels)
                    }
                    HduKind::CompressedImage(name) if is_packed && name == "PLIO_1" => {
                        count >= 5 && is_sound_plio(&begin(offset, 10)?, count)
                    }
                    HduKind::CompressedImage(name) if is_packed && name == "NOCOMPRESS" => count <= pixels,
                    _ => true,
                };
                if !is_sound {
                    return Err(broken("the compressed stream does not match the pixels of the tile"));
                }
            }
        }
        Ok(table)
    }

    /// Returns the numbers of pixels along each axis, of the image and of a tile.
    pub fn sizes(&self) -> [&[usize]; 2] {
        [&self.sides, &self.tile]
    }

    /// Returns true if the table has a column of this name.
    pub fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Returns true if a column contains data for a tile.
    pub fn holds(&self, name: &str, row: usize) -> bool {
        self.column(name).is_some_and(|column| column.variable.is_some() && self.length(column, row).0 > 0)
    }

    /// Returns a number from a column of fixed length.
    pub fn number(&self, name: &str, row: usize) -> Option<f64> {
        let column = self.column(name)?;
        let at = row * self.row_length + column.at;
        let bytes = |length: usize| self.bytes.get(at..at + length);
        Some(match column.letter {
            'D' => f64::from_be_bytes(bytes(8)?.try_into().ok()?),
            'E' => f64::from(f32::from_be_bytes(bytes(4)?.try_into().ok()?)),
            'J' => f64::from(i32::from_be_bytes(bytes(4)?.try_into().ok()?)),
            'I' => f64::from(i16::from_be_bytes(bytes(2)?.try_into().ok()?)),
            _ => return None,
        })
    }

    /// Returns the number of pixels of a tile; tiles at the ends of the axes are smaller.
    fn pixels(&self, number: usize) -> u64 {
        let (mut number, mut pixels) = (number, 1);
        for (side, tile) in self.sides.iter().zip(&self.tile) {
            let tiles = side.div_ceil(*tile);
            pixels *= (*tile).min(side - number % tiles * tile) as u64;
            number /= tiles;
        }
        pixels
    }

    /// Returns the number of elements in one row of a variable-length column, and the bytes of an element.
    fn length(&self, column: &Column, row: usize) -> (u64, u64) {
        column.variable.map_or((0, 1), |(half, size)| (self.half(column, row, 0, half), size as u64))
    }

    /// Returns the position of the elements in the heap, bytes.
    fn offset(&self, column: &Column, row: usize) -> u64 {
        column.variable.map_or(0, |(half, _)| self.half(column, row, half, half))
    }

    fn half(&self, column: &Column, row: usize, from: usize, length: usize) -> u64 {
        let at = row * self.row_length + column.at + from;
        self.bytes[at..at + length].iter().fold(0, |number, byte| number << 8 | u64::from(*byte))
    }
}

/// Checks that an HCOMPRESS stream does not have more pixels than its tile. The stream begins with a magic number, two
/// lengths, a scale, a sum, and three numbers of bit planes.
fn is_sound_hcompress(begin: &[u8], pixels: u64) -> bool {
    let length = |at: usize| begin[at..at + 4].iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
    begin[..2] == [0xdd, 0x99]
        && (1..=pixels).contains(&(length(2) * length(6)))
        && begin[22..].iter().all(|n| *n <= 62)
}

/// Checks the length of a PLIO line list, which is its third word, or the fourth and fifth word if the third is not
/// positive.
fn is_sound_plio(begin: &[u8], count: u64) -> bool {
    let word = |number: usize| i64::from(i16::from_be_bytes([begin[2 * number], begin[2 * number + 1]]));
    let (length, first) = if word(2) > 0 { (word(2), 4) } else { ((word(4) << 15) + word(3), word(1) + 1) };
    (0..=count as i64).contains(&length) && first >= 1
}
