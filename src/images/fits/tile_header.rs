//! Header of a compressed image: the columns of its table, and checks that CFITSIO does not make.
//!
//! CFITSIO divides by ZTILEn and allocates memory according to ZNAXISn. The checks compare these keywords with one
//! another and with the size of the table.

use super::super::header::Header;
use crate::error::Error;

/// Supported compression algorithms.
const ALGORITHMS: [&str; 7] = ["RICE_1", "RICE_ONE", "GZIP_1", "GZIP_2", "PLIO_1", "HCOMPRESS_1", "NOCOMPRESS"];

/// Largest number of axes of an image that CFITSIO decompresses.
const MOST_AXES: u64 = 6;

/// Largest accepted side of a tile that is larger than its image, pixels.
const LONGEST_SIDE: u64 = 4096;

/// Largest accepted tile of a small image, pixels.
const LARGEST_TILE: u64 = 1 << 24;

/// Largest accepted number of pixels per byte of the heap. PLIO stores 4095 equal pixels in two bytes, HCOMPRESS a
/// constant tile in about 30 bytes.
const PIXELS_PER_BYTE: u64 = 2048;
const PIXELS_PER_BYTE_HCOMPRESS: u64 = 20_000;

/// Keywords, without their numbers, that must occur only once in the header of a compressed image, because CFITSIO may
/// use any of several.
const ONCE: [&str; 14] = [
    "NAXIS", "PCOUNT", "THEAP", "TFIELDS", "TFORM", "TTYPE", "ZIMAGE", "ZBITPIX", "ZNAXIS", "ZTILE", "ZCMPTYPE",
    "ZNAME", "ZVAL", "ZDITHER0",
];

/// Names of the columns that contain tiles.
pub(super) const COMPRESSED: &str = "COMPRESSED_DATA";
pub(super) const GZIPPED: &str = "GZIP_COMPRESSED_DATA";
pub(super) const UNCOMPRESSED: &str = "UNCOMPRESSED_DATA";

/// Column of a table, with its position in a row and its type.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    pub number: usize,
    pub name: String,
    pub at: usize,
    /// For a variable-length column: the bytes of half a descriptor, and the bytes of one element.
    pub variable: Option<(usize, usize)>,
    pub letter: char,
}

/// Reads the columns of a binary table and checks that their widths fill its rows.
pub(super) fn columns(header: &Header) -> Result<Vec<Column>, Error> {
    let count = integer(header, "TFIELDS", 0, 999)?;
    let mut columns = Vec::new();
    let mut at: usize = 0;
    for number in 1..=count as usize {
        let keyword = format!("TFORM{number}");
        let form = header.text(&keyword).unwrap_or_default().to_ascii_uppercase();
        let widths = parse_form(&form).and_then(|form| Some((at.checked_add(form.0)?, form)));
        let Some((end, (_, letter, variable))) = widths else {
            return Err(Error::invalid(
                keyword,
                format!("{form:?}"),
                "a form of a binary table such as 1D, 12A or 1PB(260)",
            ));
        };
        let name = header.text(&format!("TTYPE{number}")).unwrap_or_default().to_ascii_uppercase();
        columns.push(Column { number, name, at, variable, letter });
        at = end;
    }
    if header.integer("NAXIS1") != i64::try_from(at).ok() {
        let given = header.integer("NAXIS1").unwrap_or_default();
        return Err(Error::invalid("NAXIS1", given.to_string(), format!("{at}, the sum of the widths of the columns")));
    }
    Ok(columns)
}

/// Checks the header of a compressed image. Returns the lengths of the image's axes and of the tiles' axes.
pub(super) fn check_compressed(header: &Header) -> Result<[Vec<usize>; 2], Error> {
    for (index, card) in header.cards().iter().enumerate() {
        let keyword = card.keyword();
        let is_once = ONCE.contains(&keyword.trim_end_matches(|c: char| c.is_ascii_digit())) || keyword == "ZDITHER0";
        if is_once && header.cards()[..index].iter().any(|other| other.keyword() == keyword) {
            return Err(Error::invalid(keyword, "given twice", "once in the header of a compressed image"));
        }
    }
    for (keyword, value) in [("BITPIX", 8), ("NAXIS", 2), ("GCOUNT", 1)] {
        integer(header, keyword, value, value)?;
    }
    let algorithm = header.text("ZCMPTYPE").unwrap_or_default();
    if !ALGORITHMS.contains(&algorithm.as_str()) {
        return Err(Error::invalid("ZCMPTYPE", format!("{algorithm:?}"), ALGORITHMS.join(", ")));
    }
    let bitpix = header.integer("ZBITPIX").unwrap_or_default();
    if ![8, 16, 32, -32, -64].contains(&bitpix) {
        return Err(Error::invalid("ZBITPIX", shown(header, "ZBITPIX"), "8, 16, 32, -32 or -64"));
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
    let too_large = |keyword: &str, allowed: String| Error::invalid(keyword, format!("{sides:?}"), allowed);
    let pixels = product(&sides).filter(|pixels| *pixels < 1 << 40);
    let pixels = pixels.ok_or_else(|| too_large("ZNAXISn", "lengths of fewer than 2^40 pixels".into()))?;
    if product(&tile).is_none_or(|tile| tile > pixels.max(LARGEST_TILE)) {
        return Err(Error::invalid("ZTILEn", format!("{tile:?}"), "tiles that are no larger than the image"));
    }
    let tiles: u64 = sides.iter().zip(&tile).map(|(side, tile)| side.div_ceil(*tile)).product();
    if header.integer("NAXIS2") != i64::try_from(tiles).ok() {
        let allowed = format!("{tiles}, the number of tiles of {tile:?} pixels in an image of {sides:?}");
        return Err(Error::invalid("NAXIS2", shown(header, "NAXIS2"), allowed));
    }
    let per_byte = if algorithm == "HCOMPRESS_1" { PIXELS_PER_BYTE_HCOMPRESS } else { PIXELS_PER_BYTE };
    let heap = integer(header, "PCOUNT", 0, i64::MAX as u64)?;
    if pixels > heap.saturating_mul(per_byte) {
        return Err(too_large("ZNAXISn", format!("at most the pixels that {heap} compressed bytes can contain")));
    }
    if algorithm.starts_with("RICE") {
        integer(header, "ZVAL1", 1, 4096)?;
        let has_bytes = header.contains("ZVAL2") && header.text("ZNAME2").as_deref() != Some("NOISEBIT");
        // Some writers exchange the two parameters of RICE.
        if has_bytes && !matches!(header.integer("ZVAL2"), Some(1 | 2 | 4 | 8 | 16 | 32)) {
            return Err(Error::invalid("ZVAL2", shown(header, "ZVAL2"), "1, 2 or 4 (bytes of a pixel)"));
        }
    }
    if header.contains("ZDITHER0") {
        integer(header, "ZDITHER0", 1, 10_000)?;
    }
    let columns = columns(header)?;
    if !columns.iter().any(|column| column.name == COMPRESSED && column.variable.is_some()) {
        let allowed = format!("a column {COMPRESSED} of variable length");
        return Err(Error::invalid("TTYPEn", "missing", allowed));
    }
    let rows = integer(header, "NAXIS1", 0, u64::MAX >> 1)?.saturating_mul(tiles);
    if header.contains("THEAP") {
        integer(header, "THEAP", rows, rows.saturating_add(heap))?;
    }
    let sizes = |sides: Vec<u64>| sides.into_iter().map(|side| side as usize).collect();
    Ok([sizes(sides), sizes(tile)])
}

/// Reads an integer and checks its range.
fn integer(header: &Header, keyword: &str, least: u64, most: u64) -> Result<u64, Error> {
    let number = header.integer(keyword).and_then(|number| u64::try_from(number).ok());
    number.filter(|number| (least..=most).contains(number)).ok_or_else(|| {
        let allowed = if most > i64::MAX as u64 >> 1 {
            format!("a whole number of {least} or more")
        } else {
            format!("a whole number from {least} to {most}")
        };
        Error::invalid(keyword, shown(header, keyword), allowed)
    })
}

/// Returns a value as written on its card.
pub(super) fn shown(header: &Header, keyword: &str) -> String {
    let Some(card) = header.card(keyword) else { return "missing".to_owned() };
    card.text()[9..].split('/').next().unwrap_or_default().trim().to_owned()
}

/// Parsed TFORMn: number of bytes in a row, letter of the type, and, for a variable-length column, the bytes of half a
/// descriptor and of an element.
type Form = (usize, char, Option<(usize, usize)>);

/// Parses a TFORMn.
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
