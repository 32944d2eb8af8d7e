//! Compressed images with added light: CFITSIO decompresses the affected tiles and compresses them again.
//!
//! CFITSIO would quantise all pixels of an affected lossy tile again. It is therefore given another header for the same
//! table (a view), which declares the quantised integers to be the image: unchanged pixels keep their integers, and
//! changed pixels get the nearest step. Tiles of a lossy image that were stored without loss (GZIP_COMPRESSED_DATA) are
//! edited with a second view. The table is alone in its temporary file, because each tile that grows would move all
//! HDUs after it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use fitsio::FitsFile;
use fitsio::errors::Error as FitsioError;
use fitsio::hdu::FitsHdu;
use fitsio::images::{ReadImage, WriteImage};

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::cfitsio::Handle;
use super::deltas::Deltas;
use super::deltas::{Changed, Outcome};
use super::dither::{Dither, between_steps};
use super::hdu::{BLOCK, HduInfo, HduKind, copy_range, header_bytes, scan};
use super::new_hdu::empty_primary;
use super::pixel_format::{Bitpix, PixelFormat, Stored};
use super::tile_header::{COMPRESSED, GZIPPED};
use super::tile_table::TileTable;
use crate::error::Error;
use crate::input;

/// Quantised number of a pixel without a value (ZBLANK), and of a pixel that is exactly 0 (SUBTRACTIVE_DITHER_2).
const QUANTISED_BLANK: f64 = -2_147_483_648.0;
const QUANTISED_ZERO: f64 = -2_147_483_646.0;

/// Range of quantised numbers. The lower limit is next to the reserved numbers, because CFITSIO gives the faintest
/// pixel of a tile a number only ten above them.
const QUANTISED_RANGE: (f64, f64) = (-2_147_483_645.0, 2_147_483_600.0);

/// Table with recompressed tiles, as a byte range of a file.
#[derive(Debug)]
pub(super) struct Repacked {
    pub path: PathBuf,
    pub data: Range<u64>,
}

/// Pixel that is changed: its index in the tile, its random number for rounding, and the added light.
type Touched = (usize, f64, f64);

/// Quantisation of floating-point pixels.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
enum Quantisation {
    Plain,
    Dithered { zero_is_exact: bool },
}

/// Format of the numbers of one tile.
struct TileFormat {
    pixels: PixelFormat,
    /// Parameters of quantised pixels.
    quantised: Option<Quantised>,
}

struct Quantised {
    scale: f64,
    zero: f64,
    blank: f64,
    /// Random numbers of the dither; empty without dither.
    random: Vec<f64>,
    zero_is_exact: bool,
}

/// Adds light to a compressed image: writes a table with the recompressed tiles to a separate file at `scratch`, and
/// updates `header`. `seed` is that of the rounding.
///
/// # Errors
/// Tiles are invalid, or their algorithm is not supported; errors of CFITSIO and of the operating system.
pub(super) fn repack(
    source: &Path,
    info: &HduInfo,
    header: &mut Header,
    (light, seed): (&Deltas<'_>, u64),
    scratch: &Path,
) -> Result<(Changed, Repacked), Error> {
    let failed = |problem: String| Error::format(problem).in_hdu(source, info.index);
    let io = Error::io(source);
    let table = TileTable::read(source, info, header)?;
    let HduKind::CompressedImage(algorithm) = &info.kind else {
        return Err(failed("the image is not compressed".to_owned()));
    };
    if !["RICE_1", "RICE_ONE", "GZIP_1", "GZIP_2"].contains(&algorithm.as_str()) {
        return Err(failed(format!(
            "pixels compressed by {algorithm} cannot be changed (supported: RICE_1, GZIP_1 and GZIP_2); unpack the file first with funpack"
        )));
    }
    let quantisation = quantisation(info, header, &table).map_err(failed)?;
    let (mut packed, mut lossless) = (BTreeMap::new(), BTreeMap::new());
    for (number, touched) in touched_tiles(&table, light, seed) {
        if table.holds(COMPRESSED, number) {
            packed.insert(number, touched);
        } else if table.holds(GZIPPED, number) {
            lossless.insert(number, touched);
        } else {
            return Err(failed(format!("tile {} is not compressed; unpack the file first with funpack", number + 1)));
        }
    }
    let mut changed = Changed::default();
    let stored = stored_bitpix(info, header, quantisation);
    let passes = [
        (packed, stored, quantisation, view(header, stored, COMPRESSED, None)),
        (lossless, info.format.bitpix, None, view(header, info.format.bitpix, GZIPPED, Some("GZIP_1"))),
    ];
    let mut is_new = true;
    let mut data = 0..0;
    for (tiles, stored, quantisation, view) in passes {
        if tiles.is_empty() && !is_new {
            continue;
        }
        // The sizes of the table change when the first view is edited.
        let mut view = view;
        copy_sizes(header, &mut view);
        write_view(source, info, &view, scratch, is_new).map_err(&io)?;
        is_new = false;
        let dither = quantisation.is_some_and(|q| q != Quantisation::Plain).then(Dither::new);
        let format_of = |number: usize| tile_format(info, header, &table, quantisation, dither.as_ref(), number);
        edit(scratch, &table, stored, &tiles, format_of, &mut changed).map_err(|error| error.of_file(source))?;
        let made = scan(scratch, &mut input::open(scratch).map_err(&io)?)?;
        let (made, made_header) =
            made.get(1).ok_or_else(|| failed("the scratch file has no table of tiles".to_owned()))?;
        copy_sizes(made_header, header);
        data = made.data_at..made.data_at + made.data_length;
    }
    Ok((changed, Repacked { path: scratch.to_owned(), data }))
}

/// Returns the pixels to which light is added, by tile.
fn touched_tiles(table: &TileTable, light: &Deltas<'_>, seed: u64) -> BTreeMap<usize, Vec<Touched>> {
    let [sides, tile] = table.sizes();
    let across = sides[0].div_ceil(tile[0]);
    let mut touched: BTreeMap<usize, Vec<Touched>> = BTreeMap::new();
    light.each(0..usize::MAX, |pixel, sum| {
        let (row, column) = (pixel / sides[0], pixel % sides[0]);
        let (tile_row, tile_column) = (row / tile[1], column / tile[0]);
        let width = tile[0].min(sides[0] - tile_column * tile[0]);
        let index = row % tile[1] * width + column % tile[0];
        touched.entry(tile_row * across + tile_column).or_default().push((index, between_steps(seed, pixel), sum));
    });
    touched
}

fn quantisation(info: &HduInfo, header: &Header, table: &TileTable) -> Result<Option<Quantisation>, String> {
    let is_scaled = table.has("ZSCALE") || header.contains("ZSCALE");
    Ok(match header.text("ZQUANTIZ").as_deref() {
        _ if info.format.bitpix.is_integer() || !is_scaled => None,
        Some("NONE") => None,
        Some("SUBTRACTIVE_DITHER_1") => Some(Quantisation::Dithered { zero_is_exact: false }),
        Some("SUBTRACTIVE_DITHER_2") => Some(Quantisation::Dithered { zero_is_exact: true }),
        None | Some("NO_DITHER") => Some(Quantisation::Plain),
        Some(other) => {
            return Err(format!(
                "unknown quantisation {other:?}; allowed: NONE, NO_DITHER, SUBTRACTIVE_DITHER_1, SUBTRACTIVE_DITHER_2"
            ));
        }
    })
}

/// Returns the type of the compressed numbers.
fn stored_bitpix(info: &HduInfo, header: &Header, quantisation: Option<Quantisation>) -> Bitpix {
    // RICE compresses integers of BYTEPIX bytes (by default 4), whatever the type of the image.
    let is_rice = matches!(&info.kind, HduKind::CompressedImage(name) if name.starts_with("RICE"));
    let bytes = if header.text("ZNAME2").as_deref() == Some("NOISEBIT") { None } else { header.integer("ZVAL2") };
    match (quantisation, bytes) {
        (None, _) if !is_rice => info.format.bitpix,
        (_, Some(1)) if is_rice => Bitpix::U8,
        (_, Some(2)) if is_rice => Bitpix::I16,
        _ => Bitpix::I32,
    }
}

/// Returns the header with which CFITSIO reads the column `tiles` as an image of plain numbers. Cards of scale and
/// quantisation become comments, and the other columns are renamed.
fn view(header: &Header, bitpix: Bitpix, tiles: &str, algorithm: Option<&str>) -> Header {
    const OMITTED: [&str; 9] =
        ["BSCALE", "BZERO", "BLANK", "ZBLANK", "ZSCALE", "ZZERO", "ZQUANTIZ", "CHECKSUM", "DATASUM"];
    let cards = header.cards().iter().map(|card| {
        if OMITTED.contains(&card.keyword().as_str()) { Card::from_bytes(b"COMMENT") } else { card.clone() }
    });
    let mut view = Header::from_cards(cards.collect());
    view.set("ZBITPIX", &bitpix.number().into(), "");
    if let Some(algorithm) = algorithm {
        view.set("ZCMPTYPE", &algorithm.into(), "");
    }
    for number in 1..=header.integer("TFIELDS").unwrap_or(0) {
        let keyword = format!("TTYPE{number}");
        let is_tiles = header.text(&keyword).is_some_and(|name| name.eq_ignore_ascii_case(tiles));
        let name = if is_tiles { COMPRESSED.to_owned() } else { format!("COLUMN{number}") };
        view.set(&keyword, &CardValue::Text(name), "");
    }
    view
}

/// Copies the keywords that compression changes from one header to another.
fn copy_sizes(from: &Header, to: &mut Header) {
    for card in from.cards() {
        let keyword = card.keyword();
        let is_size = keyword == "PCOUNT" || keyword == "THEAP" || keyword.starts_with("TFORM");
        if let Some(value) = from.value(&keyword).filter(|value| is_size && to.value(&keyword).as_ref() != Some(value))
        {
            to.set(&keyword, &value, "");
        }
    }
}

/// Writes the header of a view; for the first view, also the rest of the file.
fn write_view(source: &Path, info: &HduInfo, view: &Header, scratch: &Path, is_new: bool) -> io::Result<()> {
    let mut file = File::options().create(true).truncate(false).read(true).write(true).open(scratch)?;
    file.write_all(&header_bytes(&empty_primary()))?;
    let bytes = header_bytes(view);
    if !is_new {
        // The header and the table have the same length as in the first view.
        return file.write_all(&bytes);
    }
    file.write_all(&bytes)?;
    copy_range(&input::open(source)?, &file, info.data_at..info.data_at + info.data_length)?;
    let end = file.seek(SeekFrom::End(0))?;
    file.set_len(end.next_multiple_of(BLOCK as u64))
}

/// Adds light to the pixels of the tiles in the file at `scratch`.
fn edit(
    scratch: &Path,
    table: &TileTable,
    stored: Bitpix,
    tiles: &BTreeMap<usize, Vec<Touched>>,
    format_of: impl Fn(usize) -> TileFormat,
    changed: &mut Changed,
) -> Result<(), Error> {
    let mut handle = Handle::edit(scratch)?;
    handle.fitsio(|file| {
        let image = file.hdu(1)?;
        for (number, touched) in tiles {
            let (format, ranges) = (format_of(*number), ranges(table, *number));
            let ranges: Vec<&Range<usize>> = ranges.iter().collect();
            match stored {
                Bitpix::U8 => edit_tile::<u8>(file, &image, &ranges, touched, &format, changed),
                Bitpix::I16 => edit_tile::<i16>(file, &image, &ranges, touched, &format, changed),
                Bitpix::I32 | Bitpix::I64 => edit_tile::<i32>(file, &image, &ranges, touched, &format, changed),
                Bitpix::F32 => edit_tile::<f32>(file, &image, &ranges, touched, &format, changed),
                Bitpix::F64 => edit_tile::<f64>(file, &image, &ranges, touched, &format, changed),
            }?;
        }
        Ok(())
    })?;
    handle.compact_heap()?;
    handle.close()
}

/// Returns the range of pixels that a tile covers along each axis of the image.
fn ranges(table: &TileTable, number: usize) -> Vec<Range<usize>> {
    let [sides, tile] = table.sizes();
    let mut number = number;
    let along = |(side, tile): (&usize, &usize)| {
        let tiles = side.div_ceil(*tile);
        let start = number % tiles * tile;
        number /= tiles;
        start..(start + tile).min(*side)
    };
    sides.iter().zip(tile).map(along).collect()
}

/// Type of the compressed numbers.
trait Number: Copy + WriteImage {
    fn to_f64(self) -> f64;
    fn from_f64(number: f64) -> Self;
}

macro_rules! number {
    ($($kind:ty)*) => {$(
        impl Number for $kind {
            fn to_f64(self) -> f64 {
                self as f64
            }
            fn from_f64(number: f64) -> Self {
                number as $kind
            }
        }
    )*};
}
number!(u8 i16 i32 f32 f64);

fn edit_tile<T: Number>(
    file: &mut FitsFile,
    image: &FitsHdu,
    ranges: &[&Range<usize>],
    touched: &[Touched],
    format: &TileFormat,
    changed: &mut Changed,
) -> Result<(), FitsioError>
where
    Vec<T>: ReadImage,
{
    let mut numbers: Vec<T> = image.read_region(file, ranges)?;
    let before = changed.pixels;
    for &(index, share, sum) in touched {
        let number = numbers[index].to_f64();
        let old = format.physical(number, index);
        changed.set(old, old + sum + share * format.step(), |new| {
            let (stored, is_clipped) = match format.stored(new, index) {
                Stored::Exact(stored) => (stored, false),
                Stored::Clipped(stored) => (stored, true),
            };
            let stored = T::from_f64(stored);
            numbers[index] = stored;
            Outcome { is_other: stored.to_f64() != number, is_clipped }
        });
    }
    if changed.pixels > before { image.write_region(file, ranges, &numbers) } else { Ok(()) }
}

fn tile_format(
    info: &HduInfo,
    header: &Header,
    table: &TileTable,
    quantisation: Option<Quantisation>,
    dither: Option<&Dither>,
    number: usize,
) -> TileFormat {
    let of_tile = |name: &str| table.number(name, number).or_else(|| header.number(name));
    let quantised = quantisation.map(|quantisation| {
        let seed = header.integer("ZDITHER0").unwrap_or(1) as usize;
        let pixels = ranges(table, number).iter().map(Range::len).product();
        Quantised {
            scale: of_tile("ZSCALE").filter(|scale| *scale != 0.0).unwrap_or(1.0),
            zero: of_tile("ZZERO").unwrap_or(0.0),
            blank: of_tile("ZBLANK").unwrap_or(QUANTISED_BLANK),
            random: dither.map_or(Vec::new(), |dither| dither.of_tile(number + seed).take(pixels).collect()),
            zero_is_exact: quantisation == Quantisation::Dithered { zero_is_exact: true },
        }
    });
    TileFormat { pixels: info.format, quantised }
}

impl TileFormat {
    /// Returns the physical value of a stored number; NaN for a pixel without a value.
    fn physical(&self, number: f64, index: usize) -> f64 {
        let Some(quantised) = &self.quantised else { return self.pixels.physical(number) };
        if number == quantised.blank {
            return f64::NAN;
        }
        if number == QUANTISED_ZERO && quantised.zero_is_exact {
            return self.pixels.physical(0.0);
        }
        // value = (number - random + 0.5) · ZSCALE + ZZERO                  FITS standard 4.0, eq. 13
        let value = (number - quantised.offset(index)) * quantised.scale + quantised.zero;
        // Every reader rounds the value to the type of the image, so this function does the same.
        self.pixels.physical(if self.pixels.bitpix == Bitpix::F32 { f64::from(value as f32) } else { value })
    }

    /// Returns the difference between adjacent physical values of a pixel; 0 for floating-point numbers.
    fn step(&self) -> f64 {
        match &self.quantised {
            Some(quantised) => (self.pixels.scale * quantised.scale).abs(),
            None => self.pixels.step(),
        }
    }

    /// Returns the number to be stored for a physical value.
    fn stored(&self, physical: f64, index: usize) -> Stored {
        let Some(quantised) = &self.quantised else { return self.pixels.stored(physical) };
        let value = (physical - self.pixels.zero) / self.pixels.scale;
        let number = ((value - quantised.zero) / quantised.scale + quantised.offset(index)).round_ties_even();
        let (low, high) = QUANTISED_RANGE;
        if (low..=high).contains(&number) { Stored::Exact(number) } else { Stored::Clipped(number.clamp(low, high)) }
    }
}

impl Quantised {
    /// Returns the dither of a pixel, in quantisation steps.
    fn offset(&self, index: usize) -> f64 {
        self.random.get(index).map_or(0.0, |random| random - 0.5)
    }
}
