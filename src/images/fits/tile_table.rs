//! The table that holds the tiles of a compressed image, and the checks of it that CFITSIO does not make.
//!
//! CFITSIO divides by ZTILEn, allocates what ZNAXISn and the descriptors of tiles announce, and writes as many pixels as a stream says. All
//! of these are compared with one another and with the size of the file before it reads the table.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

use super::super::header::Header;
use super::error::FrameError;
use super::hdu::{HduInfo, HduKind};

/// Algorithms of compression.
const ALGORITHMS: [&str; 7] = ["RICE_1", "RICE_ONE", "GZIP_1", "GZIP_2", "PLIO_1", "HCOMPRESS_1", "NOCOMPRESS"];

/// Axes of an image that CFITSIO unpacks.
const MOST_AXES: u64 = 6;

/// Longest side of a tile that is larger than its image.
const LONGEST_SIDE: u64 = 4096;

/// Pixels of the largest tile of a small image.
const LARGEST_TILE: u64 = 1 << 24;

/// Pixels of a byte of the heap: PLIO packs 4095 of one value into two bytes, HCOMPRESS a constant tile into some 30.
const PIXELS_PER_BYTE: u64 = 2048;
const PIXELS_PER_BYTE_HCOMPRESS: u64 = 20_000;

/// Keywords, their numbers left out, that may stand once in the header of a compressed image: CFITSIO takes any of several.
const ONCE: [&str; 14] = [
    "NAXIS", "PCOUNT", "THEAP", "TFIELDS", "TFORM", "TTYPE", "ZIMAGE", "ZBITPIX", "ZNAXIS", "ZTILE", "ZCMPTYPE",
    "ZNAME", "ZVAL", "ZDITHER0",
];

/// Columns that hold tiles.
pub(super) const COMPRESSED: &str = "COMPRESSED_DATA";
pub(super) const GZIPPED: &str = "GZIP_COMPRESSED_DATA";
pub(super) const UNCOMPRESSED: &str = "UNCOMPRESSED_DATA";

/// A value of a header that is refused: keyword, value, and what is allowed.
pub(super) type Refused = (String, String, String);

/// A column: where it is in a row and what it holds.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub number: usize,
    pub name: String,
    at: usize,
    /// For a variable-length one: bytes of half a descriptor, and of one element.
    variable: Option<(usize, usize)>,
    letter: char,
}

/// The columns of a binary table, whose widths fill its rows.
pub(super) fn columns(header: &Header) -> Result<Vec<Column>, Refused> {
    let count = integer(header, "TFIELDS", 0, 999)?;
    let mut columns = Vec::new();
    let mut at: usize = 0;
    for number in 1..=count as usize {
        let keyword = format!("TFORM{number}");
        let form = header.text(&keyword).unwrap_or_default().to_ascii_uppercase();
        let widths = parse_form(&form).and_then(|form| Some((at.checked_add(form.0)?, form)));
        let Some((end, (_, letter, variable))) = widths else {
            return Err((keyword, format!("{form:?}"), "a form of a binary table such as 1D, 12A or 1PB(260)".into()));
        };
        let name = header.text(&format!("TTYPE{number}")).unwrap_or_default().to_ascii_uppercase();
        columns.push(Column { number, name, at, variable, letter });
        at = end;
    }
    if header.integer("NAXIS1") != i64::try_from(at).ok() {
        let given = header.integer("NAXIS1").unwrap_or_default();
        return Err(("NAXIS1".into(), given.to_string(), format!("{at}, the sum of the widths of the columns")));
    }
    Ok(columns)
}

/// Checks the header of a compressed image; the lengths of its axes and of its tiles.
pub(super) fn check_compressed(header: &Header) -> Result<[Vec<usize>; 2], Refused> {
    for (index, card) in header.cards().iter().enumerate() {
        let keyword = card.keyword();
        let is_once = ONCE.contains(&keyword.trim_end_matches(|c: char| c.is_ascii_digit())) || keyword == "ZDITHER0";
        if is_once && header.cards()[..index].iter().any(|other| other.keyword() == keyword) {
            return Err((keyword, "given twice".into(), "once in the header of a compressed image".into()));
        }
    }
    for (keyword, value) in [("BITPIX", 8), ("NAXIS", 2), ("GCOUNT", 1)] {
        integer(header, keyword, value, value)?;
    }
    let algorithm = header.text("ZCMPTYPE").unwrap_or_default();
    if !ALGORITHMS.contains(&algorithm.as_str()) {
        return Err(("ZCMPTYPE".into(), format!("{algorithm:?}"), ALGORITHMS.join(", ")));
    }
    let bitpix = header.integer("ZBITPIX").unwrap_or_default();
    if ![8, 16, 32, -32, -64].contains(&bitpix) {
        return Err(("ZBITPIX".into(), shown(header, "ZBITPIX"), "8, 16, 32, -32 or -64".into()));
    }
    let axes = integer(header, "ZNAXIS", 1, MOST_AXES)?;
    let (mut sides, mut tile) = (Vec::new(), Vec::new());
    for axis in 1..=axes {
        let side = integer(header, &format!("ZNAXIS{axis}"), 1, i32::MAX as u64)?;
        let keyword = format!("ZTILE{axis}");
        tile.push(match header.contains(&keyword) {
            true => integer(header, &keyword, 1, side.max(LONGEST_SIDE))?,
            false if axis == 1 => side,
            false => 1,
        });
        sides.push(side);
    }
    let product = |sides: &[u64]| sides.iter().try_fold(1u64, |product, side| product.checked_mul(*side));
    let too_large = |keyword: &str, allowed: String| (keyword.to_owned(), format!("{sides:?}"), allowed);
    let pixels = product(&sides).filter(|pixels| *pixels < 1 << 40);
    let pixels = pixels.ok_or_else(|| too_large("ZNAXISn", "lengths of fewer than 2^40 pixels".into()))?;
    if product(&tile).is_none_or(|tile| tile > pixels.max(LARGEST_TILE)) {
        return Err(("ZTILEn".into(), format!("{tile:?}"), "tiles that are no larger than the image".into()));
    }
    let tiles: u64 = sides.iter().zip(&tile).map(|(side, tile)| side.div_ceil(*tile)).product();
    if header.integer("NAXIS2") != i64::try_from(tiles).ok() {
        let allowed = format!("{tiles}, the number of tiles of {tile:?} pixels in an image of {sides:?}");
        return Err(("NAXIS2".into(), shown(header, "NAXIS2"), allowed));
    }
    let per_byte = if algorithm == "HCOMPRESS_1" { PIXELS_PER_BYTE_HCOMPRESS } else { PIXELS_PER_BYTE };
    let heap = integer(header, "PCOUNT", 0, i64::MAX as u64)?;
    if pixels > heap.saturating_mul(per_byte) {
        return Err(too_large("ZNAXISn", format!("no more pixels than {heap} compressed bytes can hold")));
    }
    if algorithm.starts_with("RICE") {
        integer(header, "ZVAL1", 1, 4096)?;
        let has_bytes = header.contains("ZVAL2") && header.text("ZNAME2").as_deref() != Some("NOISEBIT");
        // Some writers give both in the other order.
        if has_bytes && !matches!(header.integer("ZVAL2"), Some(1 | 2 | 4 | 8 | 16 | 32)) {
            return Err(("ZVAL2".into(), shown(header, "ZVAL2"), "1, 2 or 4 (bytes of a pixel)".into()));
        }
    }
    if header.contains("ZDITHER0") {
        integer(header, "ZDITHER0", 1, 10_000)?;
    }
    let columns = columns(header)?;
    if !columns.iter().any(|column| column.name == COMPRESSED && column.variable.is_some()) {
        let allowed = format!("a column {COMPRESSED} of variable length");
        return Err(("TTYPEn".into(), "without it".into(), allowed));
    }
    let rows = integer(header, "NAXIS1", 0, u64::MAX >> 1)?.saturating_mul(tiles);
    if header.contains("THEAP") {
        integer(header, "THEAP", rows, rows.saturating_add(heap))?;
    }
    let sizes = |sides: Vec<u64>| sides.into_iter().map(|side| side as usize).collect();
    Ok([sizes(sides), sizes(tile)])
}

/// A whole number of a header within a range.
fn integer(header: &Header, keyword: &str, least: u64, most: u64) -> Result<u64, Refused> {
    let number = header.integer(keyword).and_then(|number| u64::try_from(number).ok());
    number.filter(|number| (least..=most).contains(number)).ok_or_else(|| {
        let allowed = if most > i64::MAX as u64 >> 1 {
            format!("a whole number of {least} or more")
        } else {
            format!("a whole number from {least} to {most}")
        };
        (keyword.to_owned(), shown(header, keyword), allowed)
    })
}

/// A value as its card gives it.
pub(super) fn shown(header: &Header, keyword: &str) -> String {
    let Some(card) = header.card(keyword) else { return "missing".to_owned() };
    card.text()[9..].split('/').next().unwrap_or_default().trim().to_owned()
}

/// The rows of the table and the sizes of its tiles.
#[derive(Debug)]
pub(super) struct TileTable {
    columns: Vec<Column>,
    bytes: Vec<u8>,
    row_length: usize,
    /// Pixels of the image along each axis, and of a tile.
    sides: Vec<usize>,
    tile: Vec<usize>,
}

impl TileTable {
    /// Reads the rows of a compressed image and checks that each tile lies in the heap and is as long as its pixels need.
    ///
    /// # Errors
    /// [`FrameError::Keyword`], [`FrameError::Tiles`] with the number of the tile, and what the system reports.
    pub fn read(path: &Path, info: &HduInfo, header: &Header) -> Result<Self, FrameError> {
        let io = FrameError::io(path);
        let refused = |refused| FrameError::refused(path, info.index, refused);
        let [sides, tile] = check_compressed(header).map_err(refused)?;
        let columns = columns(header).map_err(refused)?;
        let count = |keyword: &str| header.integer(keyword).map_or(0, |number| number as usize);
        let (row_length, rows) = (count("NAXIS1"), count("NAXIS2"));
        let mut file = File::open(path).map_err(&io)?;
        file.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
        let mut bytes = vec![0; row_length * rows];
        file.read_exact(&mut bytes).map_err(&io)?;
        let table = Self { columns, bytes, row_length, sides, tile };
        let heap = if header.contains("THEAP") { count("THEAP") } else { row_length * rows };
        let heap_length = info.data_length - heap as u64;
        let mut begin = |offset: u64, length: usize| -> Result<Vec<u8>, FrameError> {
            let mut bytes = vec![0; length];
            file.seek(SeekFrom::Start(info.data_at + heap as u64 + offset)).map_err(&io)?;
            file.read_exact(&mut bytes).map_err(&io)?;
            Ok(bytes)
        };
        for row in 0..rows {
            let pixels = table.pixels(row);
            for column in table.columns.iter().filter(|column| column.variable.is_some()) {
                let broken = |why: &str| FrameError::Tiles {
                    path: path.to_owned(),
                    hdu: info.index,
                    why: format!("{} of tile {}: {why}", column.name, row + 1),
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
                    return Err(broken("its stream does not describe its pixels"));
                }
            }
        }
        Ok(table)
    }

    /// Pixels of the image along each axis, and of a tile.
    pub fn sizes(&self) -> [&[usize]; 2] {
        [&self.sides, &self.tile]
    }

    /// Whether there is a column of this name.
    pub fn has(&self, name: &str) -> bool {
        self.column(name).is_some()
    }

    fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Whether a column holds something of a tile.
    pub fn holds(&self, name: &str, row: usize) -> bool {
        self.column(name).is_some_and(|column| column.variable.is_some() && self.length(column, row).0 > 0)
    }

    /// A number of a column of fixed length.
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

    /// Pixels of a tile; those at the ends of axes are smaller.
    fn pixels(&self, number: usize) -> u64 {
        let (mut number, mut pixels) = (number, 1);
        for (side, tile) in self.sides.iter().zip(&self.tile) {
            let tiles = side.div_ceil(*tile);
            pixels *= (*tile).min(side - number % tiles * tile) as u64;
            number /= tiles;
        }
        pixels
    }

    /// How many elements a variable-length column has in a row, and bytes of each.
    fn length(&self, column: &Column, row: usize) -> (u64, u64) {
        column.variable.map_or((0, 1), |(half, size)| (self.half(column, row, 0, half), size as u64))
    }

    /// Where the elements begin in the heap, bytes.
    fn offset(&self, column: &Column, row: usize) -> u64 {
        column.variable.map_or(0, |(half, _)| self.half(column, row, half, half))
    }

    fn half(&self, column: &Column, row: usize, from: usize, length: usize) -> u64 {
        let at = row * self.row_length + column.at + from;
        self.bytes[at..at + length].iter().fold(0, |number, byte| number << 8 | u64::from(*byte))
    }
}

/// Whether a stream of HCOMPRESS holds no more pixels than its tile: magic, two lengths, scale, sum, and three numbers of bit planes.
fn is_sound_hcompress(begin: &[u8], pixels: u64) -> bool {
    let length = |at: usize| begin[at..at + 4].iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
    begin[..2] == [0xdd, 0x99]
        && (1..=pixels).contains(&(length(2) * length(6)))
        && begin[22..].iter().all(|n| *n <= 62)
}

/// Whether a line list of PLIO is as long as it says: in its third word, or in the fourth and fifth where that is not positive.
fn is_sound_plio(begin: &[u8], count: u64) -> bool {
    let word = |number: usize| i64::from(i16::from_be_bytes([begin[2 * number], begin[2 * number + 1]]));
    let (length, first) = if word(2) > 0 { (word(2), 4) } else { ((word(4) << 15) + word(3), word(1) + 1) };
    (0..=count as i64).contains(&length) && first >= 1
}

/// A TFORMn: bytes in a row, the letter, and for a variable-length column the bytes of half a descriptor and of an element.
type Form = (usize, char, Option<(usize, usize)>);

/// Reads a TFORMn.
fn parse_form(form: &str) -> Option<Form> {
    let digits = form.len() - form.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let count: usize = if digits == 0 { 1 } else { form[..digits].parse().ok()? };
    let mut letters = form[digits..].chars();
    let letter = letters.next()?;
    let size = |letter: char| {
        Some(match letter {
            'L' | 'B' | 'A' | 'X' => 1,
            'I' => 2,
            'J' | 'E' => 4,
            'K' | 'D' | 'C' => 8,
            'M' => 16,
            _ => return None,
        })
    };
    Some(match letter {
        'X' => (count.div_ceil(8), letter, None),
        'P' | 'Q' => {
            let half = if letter == 'P' { 4 } else { 8 };
            (count.checked_mul(2 * half)?, letter, (count == 1).then_some((half, size(letters.next()?)?)))
        }
        _ => (count.checked_mul(size(letter)?)?, letter, None),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_forms() {
        assert_eq!(parse_form("1PB(260)"), Some((8, 'P', Some((4, 1)))));
        assert_eq!(parse_form("QI"), Some((16, 'Q', Some((8, 2)))));
        assert_eq!(parse_form("1D"), Some((8, 'D', None)));
        assert_eq!(parse_form("12A"), Some((12, 'A', None)));
        assert_eq!(parse_form("11X"), Some((2, 'X', None)));
        assert_eq!(parse_form("5"), None);
        assert_eq!(parse_form("9999999999999999999M"), None);
    }
}
