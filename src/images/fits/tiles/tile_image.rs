//! A compressed image whose pixels are changed where they are.

use std::collections::BTreeMap;
use std::ops::Range;

use super::super::super::header::Header;
use super::super::changed::Outcome;
use super::super::hdu::{HduInfo, HduKind};
use super::super::pixel_format::{Bitpix, PixelFormat, Stored};
use super::dither::Dither;
use super::gzip;
use super::rice::Rice;
use super::tile_table::{Rebuilt, TileTable};

/// The number that stands for no value among quantised pixels (ZBLANK), and the one for exactly 0 (SUBTRACTIVE_DITHER_2).
const QUANTISED_BLANK: i64 = -2_147_483_648;
const QUANTISED_ZERO: i64 = -2_147_483_646;

/// Quantised pixels stay between these, beside the reserved numbers.
const QUANTISED_RANGE: (f64, f64) = (-2_147_483_600.0, 2_147_483_600.0);

/// What a tile is packed with.
#[derive(Copy, Clone, Debug, PartialEq)]
enum Algorithm {
    Rice(Rice),
    Gzip1,
    Gzip2,
    Plain,
}

/// Where a tile's bytes stand in the table.
const COMPRESSED: &str = "COMPRESSED_DATA";
const GZIPPED: &str = "GZIP_COMPRESSED_DATA";
const UNCOMPRESSED: &str = "UNCOMPRESSED_DATA";

/// How floating pixels became whole numbers.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Quantisation {
    /// They did not, or were whole numbers from the beginning.
    None,
    Plain,
    Dithered {
        zero_is_exact: bool,
    },
}

/// The pixels of one tile as they are stored.
#[derive(Clone, Debug, PartialEq)]
enum Numbers {
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Floating ones, kept without loss.
    Floating(Vec<f64>),
}

/// One tile that was unpacked.
#[derive(Clone, Debug)]
struct Tile {
    column: &'static str,
    /// Bytes of one pixel within gzip.
    size: usize,
    numbers: Numbers,
    /// Scale and zero of quantised pixels.
    scale: f64,
    zero: f64,
    blank: Option<i64>,
    /// Dither of quantised pixels.
    random: Vec<f64>,
    is_changed: bool,
}

/// A compressed image in the making.
#[derive(Debug)]
pub(in super::super) struct TileImage {
    table: TileTable,
    header: Header,
    format: PixelFormat,
    columns: usize,
    rows: usize,
    tile: [usize; 2],
    algorithm: Algorithm,
    quantisation: Quantisation,
    seed: usize,
    dither: Dither,
    tiles: BTreeMap<usize, Tile>,
}

impl TileImage {
    /// From an HDU's header and the bytes of its data.
    ///
    /// # Errors
    /// Words: what about it is not known.
    pub fn new(info: &HduInfo, header: &Header, bytes: Vec<u8>) -> Result<Self, String> {
        let [columns, rows] = [info.shape[0], info.shape[1]];
        let count = |keyword: &str| {
            header.integer(keyword).and_then(|number| usize::try_from(number).ok()).filter(|number| *number > 0)
        };
        let tile = [count("ZTILE1").unwrap_or(columns), count("ZTILE2").unwrap_or(1)];
        let table = TileTable::new(header, bytes).ok_or("the table of its tiles cannot be made out")?;
        if table.rows() != columns.div_ceil(tile[0]) * rows.div_ceil(tile[1]) {
            return Err(format!(
                "{} tiles of {} by {} do not fill {columns} by {rows} pixels",
                table.rows(),
                tile[0],
                tile[1]
            ));
        }
        let HduKind::CompressedImage(name) = &info.kind else { return Err("it is not compressed".to_owned()) };
        let is_floating = !info.format.bitpix.is_integer();
        let is_scaled = table.has("ZSCALE") || header.contains("ZSCALE");
        let quantisation = match header.text("ZQUANTIZ").as_deref() {
            _ if !is_floating || !is_scaled => Quantisation::None,
            Some("NONE") => Quantisation::None,
            Some("SUBTRACTIVE_DITHER_1") => Quantisation::Dithered { zero_is_exact: false },
            Some("SUBTRACTIVE_DITHER_2") => Quantisation::Dithered { zero_is_exact: true },
            None | Some("NO_DITHER") => Quantisation::Plain,
            Some(other) => return Err(format!("its quantisation {other:?} is not known")),
        };
        let parameter = |wanted: &str| {
            (1..10).find_map(|n| (header.text(&format!("ZNAME{n}"))? == wanted).then(|| count(&format!("ZVAL{n}")))?)
        };
        let algorithm = match name.as_str() {
            "RICE_1" | "RICE_ONE" => Rice::new(parameter("BLOCKSIZE").unwrap_or(32), parameter("BYTEPIX").unwrap_or(4))
                .map(Algorithm::Rice)
                .ok_or("its BYTEPIX is not 1, 2 or 4")?,
            "GZIP_1" => Algorithm::Gzip1,
            "GZIP_2" => Algorithm::Gzip2,
            "NOCOMPRESS" => Algorithm::Plain,
            _ => {
                return Err(format!(
                    "pixels compressed by {name} are read but not changed (RICE_1, GZIP_1 and GZIP_2 are); unpack the file first (funpack)"
                ));
            }
        };
        Ok(Self {
            table,
            header: header.clone(),
            format: info.format,
            columns,
            rows,
            tile,
            algorithm,
            quantisation,
            seed: count("ZDITHER0").unwrap_or(1),
            dither: Dither::new(),
            tiles: BTreeMap::new(),
        })
    }

    /// The physical values of some pixels of a row as they are now.
    pub fn read(&mut self, row: usize, columns: Range<usize>) -> Result<Vec<f64>, String> {
        let mut values = Vec::with_capacity(columns.len());
        for column in columns {
            let (number, index) = self.place(row, column);
            self.unpacked(number)?;
            let tile = &self.tiles[&number];
            values.push(self.physical(tile, index));
        }
        Ok(values)
    }

    /// How far apart the values are that one pixel can take, physical; 0 where they lie as close as floating numbers do.
    pub fn step(&self, row: usize, column: usize) -> f64 {
        let (number, _) = self.place(row, column);
        let Some(tile) = self.tiles.get(&number).filter(|tile| matches!(tile.numbers, Numbers::Whole(_))) else {
            return 0.0;
        };
        let tile_scale = if self.quantisation == Quantisation::None { 1.0 } else { tile.scale };
        (self.format.scale * tile_scale).abs()
    }

    /// Sets the physical value of one pixel that was read before and has a value.
    pub fn set(&mut self, row: usize, column: usize, value: f64) -> Outcome {
        let (number, index) = self.place(row, column);
        let (format, quantisation) = (self.format, self.quantisation);
        let Some(tile) = self.tiles.get_mut(&number) else { return Outcome::default() };
        let outcome = match &mut tile.numbers {
            Numbers::Floating(numbers) => {
                let new = (value - format.zero) / format.scale;
                let new = if format.bitpix == Bitpix::F32 { f64::from(new as f32) } else { new };
                let old = std::mem::replace(&mut numbers[index], new);
                Outcome { is_other: old != new, is_clipped: false }
            }
            Numbers::Whole(numbers) => {
                let stored = if quantisation == Quantisation::None {
                    format.stored(value)
                } else {
                    let random = tile.random.get(index).map_or(0.0, |random| random - 0.5);
                    let number =
                        (((value - format.zero) / format.scale - tile.zero) / tile.scale + random).round_ties_even();
                    let (low, high) = QUANTISED_RANGE;
                    if number < low || number > high {
                        Stored::Clipped(number.clamp(low, high))
                    } else {
                        Stored::Exact(number)
                    }
                };
                let (new, is_clipped) = match stored {
                    Stored::Exact(number) => (number as i64, false),
                    Stored::Clipped(number) => (number as i64, true),
                };
                let old = std::mem::replace(&mut numbers[index], new);
                Outcome { is_other: old != new, is_clipped }
            }
        };
        tile.is_changed |= outcome.is_other;
        outcome
    }

    /// The table with the changed tiles packed again, in the way they were packed.
    pub fn rebuilt(&self) -> Result<Rebuilt, String> {
        let mut packed = BTreeMap::new();
        for (number, tile) in self.tiles.iter().filter(|(_, tile)| tile.is_changed) {
            packed.insert(*number, (tile.column, self.packed(tile).map_err(|error| error.to_string())?));
        }
        self.table
            .rebuilt(&self.header, |column, row| {
                packed.get(&row).filter(|(name, _)| *name == column).map(|(_, bytes)| bytes.clone())
            })
            .ok_or_else(|| "its tiles grew beyond what their table can hold (2 GB)".to_owned())
    }

    /// Number of the tile of a pixel, and the pixel's within it.
    fn place(&self, row: usize, column: usize) -> (usize, usize) {
        let across = self.columns.div_ceil(self.tile[0]);
        let (tile_column, tile_row) = (column / self.tile[0], row / self.tile[1]);
        let width = self.tile[0].min(self.columns - tile_column * self.tile[0]);
        (tile_row * across + tile_column, row % self.tile[1] * width + column % self.tile[0])
    }

    fn pixels(&self, number: usize) -> usize {
        let across = self.columns.div_ceil(self.tile[0]);
        let width = self.tile[0].min(self.columns - number % across * self.tile[0]);
        let height = self.tile[1].min(self.rows - number / across * self.tile[1]);
        width * height
    }

    fn physical(&self, tile: &Tile, index: usize) -> f64 {
        match &tile.numbers {
            Numbers::Floating(numbers) => self.format.physical(numbers[index]),
            Numbers::Whole(numbers) if self.quantisation == Quantisation::None => {
                self.format.physical(numbers[index] as f64)
            }
            Numbers::Whole(numbers) => {
                let number = numbers[index];
                if tile.blank == Some(number) {
                    return f64::NAN;
                }
                if number == QUANTISED_ZERO && self.quantisation == (Quantisation::Dithered { zero_is_exact: true }) {
                    return self.format.physical(0.0);
                }
                let random = tile.random.get(index).map_or(0.0, |random| random - 0.5);
                let value = (number as f64 - random) * tile.scale + tile.zero;
                // In the type of the image, as everybody reads it.
                let value = if self.format.bitpix == Bitpix::F32 { f64::from(value as f32) } else { value };
                self.format.physical(value)
            }
        }
    }

    /// Unpacks a tile where that was not done before.
    fn unpacked(&mut self, number: usize) -> Result<(), String> {
        if self.tiles.contains_key(&number) {
            return Ok(());
        }
        let broken = || format!("tile {} cannot be unpacked", number + 1);
        let found = [COMPRESSED, GZIPPED, UNCOMPRESSED].into_iter().find_map(|column| {
            self.table.variable(column, number).filter(|bytes| !bytes.is_empty()).map(|bytes| (column, bytes))
        });
        let (column, bytes) = found.ok_or_else(broken)?;
        let count = self.pixels(number);
        let algorithm = match column {
            COMPRESSED => self.algorithm,
            GZIPPED => Algorithm::Gzip1,
            _ => Algorithm::Plain,
        };
        let is_floating =
            !self.format.bitpix.is_integer() && (self.quantisation == Quantisation::None || column != COMPRESSED);
        let (numbers, size) = match algorithm {
            Algorithm::Rice(_) if is_floating => {
                return Err(format!("tile {} holds floating pixels in RICE", number + 1));
            }
            Algorithm::Rice(rice) => (Numbers::Whole(rice.unpack(bytes, count).ok_or_else(broken)?), 0),
            Algorithm::Gzip1 | Algorithm::Gzip2 | Algorithm::Plain => {
                let plain = match algorithm {
                    Algorithm::Plain => bytes.to_vec(),
                    _ => gzip::unpack(bytes, 8 * count).map_err(|_| broken())?,
                };
                let size = plain.len() / count.max(1);
                if plain.len() != size * count {
                    return Err(broken());
                }
                let plain = if algorithm == Algorithm::Gzip2 { gzip::gathered(&plain, size) } else { plain };
                (numbers_of(&plain, size, is_floating).ok_or_else(broken)?, size)
            }
        };
        let of_tile = |name: &str| self.table.number(name, number).or_else(|| self.header.number(name));
        let is_quantised = matches!(numbers, Numbers::Whole(_)) && self.quantisation != Quantisation::None;
        let random = match self.quantisation {
            Quantisation::Dithered { .. } if is_quantised => {
                self.dither.of_tile(number + self.seed).take(count).collect()
            }
            _ => Vec::new(),
        };
        let blank = of_tile("ZBLANK").map_or(QUANTISED_BLANK, |blank| blank as i64);
        let tile = Tile {
            column,
            size,
            numbers,
            scale: of_tile("ZSCALE").filter(|scale| *scale != 0.0).unwrap_or(1.0),
            zero: of_tile("ZZERO").unwrap_or(0.0),
            blank: Some(blank),
            random,
            is_changed: false,
        };
        self.tiles.insert(number, tile);
        Ok(())
    }

    fn packed(&self, tile: &Tile) -> std::io::Result<Vec<u8>> {
        let algorithm = match tile.column {
            COMPRESSED => self.algorithm,
            GZIPPED => Algorithm::Gzip1,
            _ => Algorithm::Plain,
        };
        if let (Algorithm::Rice(rice), Numbers::Whole(numbers)) = (algorithm, &tile.numbers) {
            return Ok(rice.pack(numbers));
        }
        let bytes = bytes_of(&tile.numbers, tile.size);
        match algorithm {
            Algorithm::Plain | Algorithm::Rice(_) => Ok(bytes),
            Algorithm::Gzip1 => gzip::pack(&bytes),
            Algorithm::Gzip2 => gzip::pack(&gzip::parted(&bytes, tile.size)),
        }
    }
}

/// Numbers of big-endian bytes.
fn numbers_of(bytes: &[u8], size: usize, is_floating: bool) -> Option<Numbers> {
    let bitpix = bitpix_of(size, is_floating)?;
    let format = PixelFormat { bitpix, scale: 1.0, zero: 0.0, blank: None };
    let numbers = (0..bytes.len() / size).map(|index| format.raw(bytes, index));
    Some(if is_floating {
        Numbers::Floating(numbers.collect())
    } else {
        Numbers::Whole(numbers.map(|number| number as i64).collect())
    })
}

fn bytes_of(numbers: &Numbers, size: usize) -> Vec<u8> {
    let (values, is_floating): (Vec<f64>, bool) = match numbers {
        Numbers::Whole(numbers) => (numbers.iter().map(|number| *number as f64).collect(), false),
        Numbers::Floating(numbers) => (numbers.clone(), true),
    };
    let Some(bitpix) = bitpix_of(size, is_floating) else { return Vec::new() };
    let format = PixelFormat { bitpix, scale: 1.0, zero: 0.0, blank: None };
    let mut bytes = vec![0; size * values.len()];
    for (index, value) in values.into_iter().enumerate() {
        format.put_raw(&mut bytes, index, value);
    }
    bytes
}

fn bitpix_of(size: usize, is_floating: bool) -> Option<Bitpix> {
    Some(match (size, is_floating) {
        (1, false) => Bitpix::U8,
        (2, false) => Bitpix::I16,
        (4, false) => Bitpix::I32,
        (4, true) => Bitpix::F32,
        (8, true) => Bitpix::F64,
        _ => return None,
    })
}
