//! Structure of a FITS file: position and kind of each header and its data.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use super::super::card::{CARD_LENGTH, Card};
use super::super::header::{Header, is_end};
use super::pixel_format::{Bitpix, PixelFormat};
use super::tile_header::check_compressed;
use crate::error::Error;

/// Length of a block in a FITS file, bytes.
pub(super) const BLOCK: usize = 2880;

/// Largest accepted length of a header, in blocks.
const LONGEST_HEADER: usize = 20_000;

/// Contents of an HDU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HduKind {
    /// Only a header.
    Empty,
    /// An uncompressed image.
    Image,
    /// An image in compressed tiles, with the name of the algorithm (ZCMPTYPE).
    CompressedImage(String),
    /// A binary table (BINTABLE).
    Table,
    /// A text table (TABLE).
    TextTable,
    /// Another extension, by its name.
    Other(String),
}

/// One header-and-data unit.
#[derive(Clone, Debug, PartialEq)]
pub struct HduInfo {
    /// Number of the HDU, from 0.
    pub index: usize,
    /// EXTNAME, empty if it has none.
    pub name: String,
    /// Contents of the HDU.
    pub kind: HduKind,
    /// Lengths of the axes, NAXIS1 first. For a compressed image these are the lengths of the image, not of its table.
    pub shape: Vec<usize>,
    /// Format of the stored pixels. For a compressed image this is the format of the image.
    pub format: PixelFormat,
    /// Description of an image that is not of two axes, and how to get a frame from it.
    pub(super) cube: Option<(String, &'static str)>,
    /// Position of the header in the file, bytes.
    pub(super) header_at: u64,
    /// Position of the data in the file, bytes.
    pub(super) data_at: u64,
    /// Length of the data without padding, bytes.
    pub(super) data_length: u64,
}

/// Keywords and words of colour images: the programs of cameras, and the names of an axis of colours.
const COLOUR_KEYWORDS: &[&str] = &["BAYERPAT", "COLORTYP", "COLORSPC", "CSPACE"];
const COLOURS: &[&str] = &["RGB", "COLOR", "COLOUR"];

/// Returns a description of an image that is not of two axes, and how to get a frame from it; `None` for a frame, which
/// may have further axes of length 1.
fn cube_words(shape: &[usize], header: &Header) -> Option<(String, &'static str)> {
    shape.get(2..)?.iter().find(|length| **length != 1)?;
    let axes: Vec<usize> = (0..shape.len()).filter(|axis| shape[*axis] != 1).collect();
    let plane = "extract the plane of one exposure as an image of two axes";
    let green = "extract the green plane as an image of two axes";
    Some(match axes[..] {
        [first, _, third] => {
            // The colours of some programs are the first axis.
            let axis = if shape[first] < 5 { first } else { third };
            let (count, number) = (shape[axis], axis + 1);
            let axis_type = header.text(&format!("CTYPE{number}")).filter(|text| !text.trim().is_empty());
            let is_colour = |text: &String| COLOURS.iter().any(|name| text.to_ascii_uppercase().starts_with(name));
            let has_colours = COLOUR_KEYWORDS.iter().any(|keyword| header.contains(keyword));
            let (what, remedy) = match &axis_type {
                _ if !(3..=4).contains(&count) => ("a cube", plane),
                Some(text) if is_colour(text) => ("a colour image", green),
                Some(_) => ("a cube", "extract one plane as an image of two axes"),
                None if has_colours => ("a colour image", green),
                None => (
                    "a cube or a colour image",
                    "extract one plane, that of one exposure or the green one of a colour image, as an image of two axes",
                ),
            };
            let of_axis = axis_type.map(|text| format!(", CTYPE{number} = '{}'", text.trim())).unwrap_or_default();
            (format!("{what} of {count} planes (NAXIS{number} = {count}{of_axis})"), remedy)
        }
        [_, _, _, ..] => (format!("a cube of axes {shape:?}"), plane),
        _ => (format!("an image of axes {shape:?}"), "remove the axes of length 1"),
    })
}

impl HduInfo {
    /// Returns true for an image with any number of axes.
    pub(super) fn is_image(&self) -> bool {
        matches!(self.kind, HduKind::Image | HduKind::CompressedImage(_))
    }

    /// Returns rows and columns of a two-dimensional image (further axes of length 1 are ignored); `None` for other
    /// HDUs.
    pub fn image_size(&self) -> Option<[usize; 2]> {
        match self.shape[..] {
            [columns, rows, ref more @ ..] if self.is_image() && more.iter().all(|length| *length == 1) => {
                Some([rows, columns])
            }
            _ => None,
        }
    }

    /// Returns a description of the HDU for messages.
    pub(super) fn words(&self) -> String {
        match &self.kind {
            HduKind::Empty => "only a header".to_owned(),
            HduKind::Image | HduKind::CompressedImage(_) => match &self.cube {
                Some((words, _)) => words.clone(),
                None => format!("an image of axes {:?}", self.shape),
            },
            HduKind::Table => "a table".to_owned(),
            HduKind::TextTable => "a text table".to_owned(),
            HduKind::Other(name) => format!("an extension {name:?}"),
        }
    }

    /// Returns the position of the next HDU, bytes.
    pub(super) fn end(&self) -> u64 {
        self.data_at + padded(self.data_length)
    }
}

/// Returns a length in bytes including the padding to a whole block.
pub(super) fn padded(length: u64) -> u64 {
    length.div_ceil(BLOCK as u64) * BLOCK as u64
}

/// Returns the bytes of a header as stored in a file: with END, padded with blanks.
pub(super) fn header_bytes(header: &Header) -> Vec<u8> {
    let mut bytes: Vec<u8> = header.cards().iter().flat_map(Card::bytes).copied().collect();
    bytes.extend_from_slice(b"END");
    bytes.resize(padded(bytes.len() as u64) as usize, b' ');
    bytes
}

/// Copies a byte range of a file to the current position of another, inside the kernel if the system supports that.
pub(super) fn copy_range(mut input: &File, mut output: &File, range: Range<u64>) -> io::Result<()> {
    input.seek(SeekFrom::Start(range.start))?;
    let length = range.end - range.start;
    let copied = io::copy(&mut input.take(length), &mut output)?;
    if copied < length {
        return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
    }
    Ok(())
}

/// Finds all HDUs of a file and reads their headers. Zeros and blanks after the last HDU are ignored.
pub(super) fn scan(path: &Path, file: &mut File) -> Result<Vec<(HduInfo, Header)>, Error> {
    let io = Error::io(path);
    let length = file.metadata().map_err(&io)?.len();
    let mut found: Vec<(HduInfo, Header)> = Vec::new();
    let mut at = 0;
    while at < length || found.is_empty() {
        let index = found.len();
        file.seek(SeekFrom::Start(at)).map_err(&io)?;
        let mut begin = vec![0; BLOCK.min((length - at) as usize)];
        file.read_exact(&mut begin).map_err(&io)?;
        if index == 0 {
            check_begin(path, &begin)?;
        } else if !begin.starts_with(b"XTENSION") {
            if is_padding(file, begin).map_err(&io)? {
                break;
            }
            file.seek(SeekFrom::Start(at)).map_err(&io)?;
            let mut shown = [0; 16];
            let count = file.read(&mut shown).map_err(&io)?;
            let allowed = format!("XTENSION or the end of the file (check the NAXISn of HDU {})", index - 1);
            return Err(Error::invalid(
                format!("data after HDU {} at byte {at}", index - 1),
                format!("{:?}", readable(&shown[..count])),
                allowed,
            )
            .in_file("", path));
        }
        let header = read_header(path, file, index, at, length)?;
        let data_at = file.stream_position().map_err(&io)?;
        let info = describe(path, index, &header, at, data_at)?;
        if data_at + info.data_length > length {
            let needed = data_at + info.data_length;
            return Err(truncated(path, index, "data", needed, length));
        }
        at = info.end();
        found.push((info, header));
    }
    Ok(found)
}

fn check_begin(path: &Path, begin: &[u8]) -> Result<(), Error> {
    let packers: [(&[u8], &str); 5] = [
        (b"\x1f\x8b", "gzip"),
        (b"BZh", "bzip2"),
        (b"\xfd7zXZ", "xz"),
        (b"PK\x03\x04", "zip"),
        (b"\x1f\x9d", "compress"),
    ];
    if let Some((_, packer)) = packers.iter().find(|(magic, _)| begin.starts_with(magic)) {
        let allowed = "a decompressed FITS file, or compressed tiles (.fz)";
        return Err(Error::about_file("", path, format!("is compressed with {packer}")).allowing(allowed));
    }
    if begin.starts_with(b"SIMPLE  =") {
        return Ok(());
    }
    let predicate = format!("is not a FITS file (it begins with {:?})", readable(&begin[..begin.len().min(16)]));
    Err(Error::about_file("", path, predicate).allowing("a file that begins with \"SIMPLE  =\""))
}

fn truncated(path: &Path, hdu: usize, part: &str, needed: u64, length: u64) -> Error {
    let allowed = format!("at least {needed} bytes for its {part} (the file has {length})");
    Error::invalid(format!("HDU {hdu}"), "truncated", allowed).in_file("", path)
}

fn readable(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns true if the rest of the file contains only zeros or blanks.
fn is_padding(file: &mut File, mut chunk: Vec<u8>) -> io::Result<bool> {
    loop {
        if chunk.iter().any(|byte| !matches!(byte, 0 | b' ')) {
            return Ok(false);
        }
        chunk.resize(BLOCK, 0);
        let count = file.read(&mut chunk)?;
        if count == 0 {
            return Ok(true);
        }
        chunk.truncate(count);
    }
}

fn read_header(path: &Path, file: &mut File, hdu: usize, at: u64, length: u64) -> Result<Header, Error> {
    let io = Error::io(path);
    file.seek(SeekFrom::Start(at)).map_err(&io)?;
    let mut cards = Vec::new();
    let mut block = vec![0; BLOCK];
    for number in 1..=LONGEST_HEADER as u64 {
        let needed = at + number * BLOCK as u64;
        if needed > length {
            return Err(truncated(path, hdu, "header", needed, length));
        }
        file.read_exact(&mut block).map_err(&io)?;
        for bytes in block.chunks(CARD_LENGTH) {
            let card = Card::from_bytes(bytes);
            if is_end(&card) {
                return Ok(Header::from_cards(cards));
            }
            cards.push(card);
        }
    }
    Err(Error::invalid("END", "missing", "a header that ends with END").in_hdu(path, hdu))
}

fn describe(path: &Path, index: usize, header: &Header, header_at: u64, data_at: u64) -> Result<HduInfo, Error> {
    let invalid_value =
        |keyword: &str, value: String, allowed: &str| Error::invalid(keyword, value, allowed).in_hdu(path, index);
    let given = |keyword: &str| {
        header.integer(keyword).map_or_else(|| "missing or not a number".to_owned(), |number| number.to_string())
    };
    let count = |keyword: &str, default: Option<u64>, allowed: &str| -> Result<u64, Error> {
        let number = header.integer(keyword).and_then(|number| u64::try_from(number).ok());
        let number = number.or(default.filter(|_| !header.contains(keyword)));
        number.ok_or_else(|| invalid_value(keyword, given(keyword), allowed))
    };
    let bitpix = |keyword: &str| -> Result<Bitpix, Error> {
        let known = header.integer(keyword).and_then(Bitpix::from_number);
        known.ok_or_else(|| invalid_value(keyword, given(keyword), "8, 16, 32, 64, -32 or -64"))
    };
    let stored = bitpix("BITPIX")?;
    let axes = count("NAXIS", None, "a number of axes from 0 to 999")?.min(999);
    let mut shape = (1..=axes)
        .map(|axis| count(&format!("NAXIS{axis}"), None, "a length of 0 or more").map(|length| length as usize))
        .collect::<Result<Vec<_>, _>>()?;
    let (parameters, groups) = (count("PCOUNT", Some(0), "0 or more")?, count("GCOUNT", Some(1), "0 or more")?);
    // In random groups the first axis has length 0 and is ignored.
    let sides =
        if shape.first() == Some(&0) && header.logical("GROUPS") == Some(true) { &shape[1..] } else { &shape[..] };
    let pixels = sides.iter().try_fold(1u64, |product, side| product.checked_mul(*side as u64));
    let pixels = if shape.is_empty() { Some(0) } else { pixels };
    // (|BITPIX| / 8) · GCOUNT · (PCOUNT + NAXIS1 · NAXIS2 · ...)             FITS standard 4.0, eq. 2
    let data_length = pixels
        .and_then(|pixels| pixels.checked_add(if shape.is_empty() { 0 } else { parameters }))
        .and_then(|elements| elements.checked_mul(groups)?.checked_mul(stored.bytes() as u64))
        .filter(|length| *length < 1 << 56)
        .ok_or_else(|| {
            invalid_value("NAXISn", format!("{shape:?}"), "lengths with a product that is a possible size of a file")
        })?;
    let extension = header.text("XTENSION").unwrap_or_default();
    let is_compressed = extension == "BINTABLE" && header.logical("ZIMAGE") == Some(true);
    let kind = match extension.as_str() {
        _ if is_compressed => HduKind::CompressedImage(header.text("ZCMPTYPE").unwrap_or_default()),
        "BINTABLE" | "A3DTABLE" => HduKind::Table,
        "TABLE" => HduKind::TextTable,
        _ if data_length == 0 => HduKind::Empty,
        "" | "IMAGE" | "IUEIMAGE" if groups == 1 => HduKind::Image,
        _ => HduKind::Other(extension),
    };
    let mut format = PixelFormat {
        bitpix: stored,
        scale: header.number("BSCALE").filter(|scale| *scale != 0.0).unwrap_or(1.0),
        zero: header.number("BZERO").unwrap_or(0.0),
        blank: header.integer("BLANK"),
    };
    if is_compressed {
        format.blank = format.blank.or(header.integer("ZBLANK"));
        [shape, _] = check_compressed(header).map_err(|error| error.in_hdu(path, index))?;
        format.bitpix = bitpix("ZBITPIX")?;
    }
    if !format.bitpix.is_integer() {
        format.blank = None;
    }
    let name = header.text("EXTNAME").unwrap_or_default();
    let cube = cube_words(&shape, header);
    Ok(HduInfo { index, name, kind, shape, format, cube, header_at, data_at, data_length })
}
