//! A copy of a frame with changes, and new frames.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::table::AtomicFile;

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::cfitsio::Rice;
use super::checksum;
use super::error::FrameError;
use super::frame_file::FrameFile;
use super::hdu::{BLOCK, HduInfo, HduKind, padded};
use super::image_values::ImageValues;
use super::new_hdu::{self, NewHdu, Place, TableColumn};
use super::overlay::Overlay;
use super::pixel_format::{Outcome, PixelFormat, Stored};
use super::tiles::TileImage;

/// What a change did to pixels.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// Pixels whose stored number is another now.
    pub pixels: usize,
    /// Pixels that would have left the range of their type and are at its end.
    pub clipped: usize,
    /// Pixels without a value (NaN, BLANK), which stayed so.
    pub without_value: usize,
}

impl std::ops::AddAssign for Changed {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.clipped += other.clipped;
        self.without_value += other.without_value;
    }
}

/// A copy of a frame in the making: every byte that is not changed is that of the input.
///
/// Changes are gathered in memory (the touched pixels alone) and written by [`finish`](FrameCopy::finish): the file is copied by the system, then what was
/// touched is written over it. Headers keep their cards and their order; CHECKSUM and DATASUM are made right where they stood in an HDU that changed.
/// Dropped without `finish`, nothing is left behind.
#[derive(Debug)]
pub struct FrameCopy {
    source: FrameFile,
    input: File,
    target: PathBuf,
    output: AtomicFile,
    edits: BTreeMap<usize, HduEdit>,
    appended: Vec<NewHdu>,
}

#[derive(Debug)]
struct HduEdit {
    header: Header,
    pixels: Option<ChangedPixels>,
}

/// Pixels that were changed.
#[derive(Debug)]
enum ChangedPixels {
    Plain(Overlay),
    Tiles(Box<TileImage>),
}

impl FrameCopy {
    /// Begins a copy that will stand at `target`.
    ///
    /// # Errors
    /// [`FrameError::SameFile`] where the target is the input, [`FrameError::Io`] where its folder is missing or cannot be written to.
    pub fn begin(source: &FrameFile, target: &Path) -> Result<Self, FrameError> {
        let input = File::open(source.path()).map_err(FrameError::io(source.path()))?;
        let is_same = |path: &Path| Some(path.canonicalize().ok()? == source.path().canonicalize().ok()?);
        if is_same(target) == Some(true) {
            return Err(FrameError::SameFile { path: target.to_owned() });
        }
        let output = AtomicFile::new(target).map_err(FrameError::io(target))?;
        Ok(Self {
            source: source.clone(),
            input,
            target: target.to_owned(),
            output,
            edits: BTreeMap::new(),
            appended: Vec::new(),
        })
    }

    /// Adds light to pixels of one row, from `first_column` on: physical values.
    ///
    /// # Errors
    /// As [`change`](FrameCopy::change).
    pub fn add(&mut self, hdu: usize, row: usize, first_column: usize, values: &[f32]) -> Result<Changed, FrameError> {
        self.change(hdu, row, first_column..first_column + values.len(), |pixels| {
            for (pixel, value) in pixels.iter_mut().zip(values) {
                *pixel += f64::from(*value);
            }
        })
    }

    /// Changes pixels of one row: `change` is given their physical values as they are now, NaN where there is none, and sets new ones.
    ///
    /// Whole numbers are rounded half to even and held within their type; a pixel without a value stays so, whatever is set, and one that is given no
    /// finite value stays as it was; a value that is not changed keeps its very bytes. In compressed images the touched tiles are packed again as they were
    /// (algorithm, scale and dither): pixels that are not changed keep their exact numbers, in lossy tiles too, and those that are get the nearest step.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`], [`FrameError::NoImage`], [`FrameError::Outside`], [`FrameError::Tiles`] where an algorithm is not known or tiles are broken,
    /// and whatever the system reports.
    pub fn change(
        &mut self,
        hdu: usize,
        row: usize,
        columns: Range<usize>,
        change: impl FnOnce(&mut [f64]),
    ) -> Result<Changed, FrameError> {
        let (info, [row_count, column_count]) = self.source.image(hdu)?;
        if row >= row_count || columns.end > column_count || columns.start >= columns.end {
            return Err(FrameError::Outside {
                path: self.source.path().to_owned(),
                hdu,
                columns: column_count,
                rows: row_count,
                row,
                first: columns.start,
                last: columns.end.max(1) - 1,
            });
        }
        let path = self.source.path();
        let io = FrameError::io(path);
        let of_tiles = |why: String| FrameError::Tiles { path: path.to_owned(), hdu, why };
        let edit = edit_of(&mut self.edits, &self.source, hdu)?;
        let pixels = match &mut edit.pixels {
            Some(pixels) => pixels,
            None if info.kind == HduKind::Image => {
                edit.pixels.insert(ChangedPixels::Plain(Overlay::new(info.data_at, info.data_length, info.format.bitpix.bytes())))
            }
            None => {
                let mut bytes = vec![0; info.data_length as usize];
                self.input.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
                self.input.read_exact(&mut bytes).map_err(&io)?;
                let tiles = TileImage::new(info, self.source.header(hdu)?, bytes).map_err(of_tiles)?;
                edit.pixels.insert(ChangedPixels::Tiles(Box::new(tiles)))
            }
        };
        match pixels {
            ChangedPixels::Plain(overlay) => {
                let size = info.format.bitpix.bytes();
                let start = row * column_count;
                let range = (start + columns.start) * size..(start + columns.end) * size;
                let mut bytes = overlay.read(&mut self.input, range.clone()).map_err(&io)?;
                let mut values = Vec::with_capacity(columns.len());
                info.format.decode(&bytes, &mut values);
                let changed = apply(&mut values, change, |index, value| set_stored(&info.format, &mut bytes, index, value));
                overlay.write(range, &bytes);
                Ok(changed)
            }
            ChangedPixels::Tiles(tiles) => {
                let mut values = tiles.read(row, columns.clone()).map_err(of_tiles)?;
                Ok(apply(&mut values, change, |index, value| tiles.set(row, columns.start + index, value)))
            }
        }
    }

    /// Sets a keyword in the header of an HDU: in its place where it is there, else behind all others. A comment of nothing keeps the old one.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn set_card(&mut self, hdu: usize, keyword: &str, value: &CardValue, comment: &str) -> Result<(), FrameError> {
        edit_of(&mut self.edits, &self.source, hdu)?.header.set(keyword, value, comment);
        Ok(())
    }

    /// Adds HISTORY to the header of an HDU, behind what is there of it.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn add_history(&mut self, hdu: usize, text: &str) -> Result<(), FrameError> {
        edit_of(&mut self.edits, &self.source, hdu)?.header.add_remark("HISTORY", text);
        Ok(())
    }

    /// Puts an image behind all HDUs; compressed where `rice` says how.
    ///
    /// # Errors
    /// What CFITSIO and the system report for compressed ones.
    pub fn append_image(&mut self, name: &str, image: &ImageValues, cards: &[Card], rice: Option<Rice>) -> Result<(), FrameError> {
        let hdu = match rice {
            Some(rice) => new_hdu::rice_image(name, image, cards, rice, folder_of(&self.target))?,
            None => new_hdu::image(Place::Extension, name, image, cards),
        };
        self.appended.push(hdu);
        Ok(())
    }

    /// Puts a table behind all HDUs.
    ///
    /// # Errors
    /// [`FrameError::Malformed`] where columns differ in length.
    pub fn append_table(&mut self, name: &str, columns: &[TableColumn], cards: &[Card]) -> Result<(), FrameError> {
        self.appended.push(new_hdu::table(name, columns, cards)?);
        Ok(())
    }

    /// Writes the copy and puts it in its place.
    ///
    /// # Errors
    /// Whatever the system reports; a file that stood at the target is then still there, and nothing else.
    pub fn finish(mut self) -> Result<(), FrameError> {
        let rebuilt = self.rebuilt_tiles()?;
        let written = self.write(&rebuilt);
        let io = FrameError::io(&self.target);
        written.map_err(&io)?;
        self.output.finish().map_err(&io)
    }

    /// The data of compressed images that changed, packed again, with what their headers must say.
    fn rebuilt_tiles(&mut self) -> Result<BTreeMap<usize, Vec<u8>>, FrameError> {
        let mut found = BTreeMap::new();
        for (hdu, edit) in &mut self.edits {
            let Some(ChangedPixels::Tiles(tiles)) = &edit.pixels else { continue };
            let rebuilt =
                tiles.rebuilt().map_err(|why| FrameError::Tiles { path: self.source.path().to_owned(), hdu: *hdu, why })?;
            edit.header.set("PCOUNT", &(rebuilt.heap_length as i64).into(), "");
            if edit.header.contains("THEAP") {
                edit.header.set("THEAP", &((rebuilt.bytes.len() - rebuilt.heap_length) as i64).into(), "");
            }
            for (keyword, form) in &rebuilt.forms {
                edit.header.set(keyword, &form.as_str().into(), "");
            }
            found.insert(*hdu, rebuilt.bytes);
        }
        Ok(found)
    }

    fn write(&mut self, rebuilt: &BTreeMap<usize, Vec<u8>>) -> io::Result<()> {
        let mut output = self.output.file();
        let mut at = 0;
        for info in self.source.hdus() {
            let Some(edit) = self.edits.get(&info.index) else {
                copy_range(&mut self.input, output, info.header_at..info.data_at + info.data_length)?;
                at += info.data_at - info.header_at + info.data_length;
                at = pad(output, at, pad_byte(info))?;
                continue;
            };
            let mut header = header_bytes(&edit.header);
            let data_at = at + header.len() as u64;
            output.write_all(&header)?;
            let mut length = info.data_length;
            match rebuilt.get(&info.index) {
                Some(bytes) => {
                    output.write_all(bytes)?;
                    length = bytes.len() as u64;
                }
                None => copy_range(&mut self.input, output, info.data_at..info.data_at + info.data_length)?,
            }
            let end = pad(output, data_at + length, pad_byte(info))?;
            if let Some(ChangedPixels::Plain(overlay)) = &edit.pixels {
                overlay.flush(&mut output, data_at)?;
            }
            if edit.header.contains("CHECKSUM") || edit.header.contains("DATASUM") {
                let datasum = sum_of(output, self.output.path(), data_at..end)?;
                header = sealed(edit.header.clone(), datasum);
                output.seek(SeekFrom::Start(at))?;
                output.write_all(&header)?;
            }
            output.seek(SeekFrom::Start(end))?;
            at = end;
        }
        for hdu in &self.appended {
            write_hdu(&mut output, hdu)?;
        }
        Ok(())
    }
}

/// Makes a file of images: the first one in the primary HDU unless it is compressed, the others behind it. Each has its name and its cards.
///
/// # Errors
/// Whatever the system or CFITSIO reports; nothing half-written stays.
pub fn write_frame(target: &Path, images: &[NewImage<'_>]) -> Result<(), FrameError> {
    let io = FrameError::io(target);
    let output = AtomicFile::new(target).map_err(&io)?;
    let mut hdus = Vec::new();
    if images.first().is_none_or(|image| image.rice.is_some()) {
        hdus.push(new_hdu::empty_primary(&[]));
    }
    for image in images {
        let place = if hdus.is_empty() { Place::Primary } else { Place::Extension };
        hdus.push(match image.rice {
            Some(rice) => new_hdu::rice_image(image.name, image.values, image.cards, rice, folder_of(target))?,
            None => new_hdu::image(place, image.name, image.values, image.cards),
        });
    }
    let mut file = output.file();
    hdus.iter().try_for_each(|hdu| write_hdu(&mut file, hdu)).map_err(&io)?;
    output.finish().map_err(&io)
}

/// An image for [`write_frame`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NewImage<'a> {
    /// EXTNAME; empty for none.
    pub name: &'a str,
    /// Its pixels.
    pub values: &'a ImageValues,
    /// Its cards; those that say how data lie (NAXIS, BITPIX, ...) are left out.
    pub cards: &'a [Card],
    /// How it is compressed, if it is.
    pub rice: Option<Rice>,
}

fn edit_of<'a>(edits: &'a mut BTreeMap<usize, HduEdit>, source: &FrameFile, hdu: usize) -> Result<&'a mut HduEdit, FrameError> {
    let header = source.header(hdu)?;
    Ok(edits.entry(hdu).or_insert_with(|| HduEdit { header: header.clone(), pixels: None }))
}

/// Where a file's neighbours lie.
fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Lets `change` set physical values, and `store`s those that are others now.
fn apply(values: &mut [f64], change: impl FnOnce(&mut [f64]), mut store: impl FnMut(usize, f64) -> Outcome) -> Changed {
    let before = values.to_vec();
    change(values);
    let mut changed = Changed::default();
    for (index, (new, old)) in values.iter().zip(&before).enumerate() {
        if old.is_nan() {
            changed.without_value += 1;
        } else if new != old && new.is_finite() {
            let outcome = store(index, *new);
            changed.pixels += usize::from(outcome.is_other);
            changed.clipped += usize::from(outcome.is_clipped);
        }
    }
    changed
}

/// Stores a physical value among bytes of a file.
fn set_stored(format: &PixelFormat, bytes: &mut [u8], index: usize, value: f64) -> Outcome {
    let (number, is_clipped) = match format.stored(value) {
        Stored::Exact(number) => (number, false),
        Stored::Clipped(number) => (number, true),
    };
    let is_other = number != format.raw(bytes, index);
    if is_other {
        format.put_raw(bytes, index, number);
    }
    Outcome { is_other, is_clipped }
}

/// Copies a range of a file to where another one stands; by the kernel where it can.
fn copy_range(input: &mut File, mut output: &File, range: Range<u64>) -> io::Result<()> {
    input.seek(SeekFrom::Start(range.start))?;
    let length = range.end - range.start;
    let copied = io::copy(&mut input.take(length), &mut output)?;
    if copied < length {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the input became shorter while it was copied"));
    }
    Ok(())
}

/// Fills up a block; the end.
fn pad(mut output: &File, length: u64, byte: u8) -> io::Result<u64> {
    let end = padded(length);
    output.write_all(&vec![byte; (end - length) as usize])?;
    Ok(end)
}

/// What stands behind data: blanks for text, else zeros.
fn pad_byte(info: &HduInfo) -> u8 {
    if info.kind == HduKind::TextTable { b' ' } else { 0 }
}

/// A header as it stands in a file: with END, filled up with blanks.
fn header_bytes(header: &Header) -> Vec<u8> {
    let mut bytes: Vec<u8> = header.cards().iter().flat_map(Card::bytes).copied().collect();
    bytes.extend_from_slice(b"END");
    bytes.resize(padded(bytes.len() as u64) as usize, b' ');
    bytes
}

/// A header's bytes with the right sums, in those of both cards that it has.
fn sealed(mut header: Header, datasum: u32) -> Vec<u8> {
    if header.contains("DATASUM") {
        header.set("DATASUM", &CardValue::Text(datasum.to_string()), "");
    }
    if header.contains("CHECKSUM") {
        header.set("CHECKSUM", &"0000000000000000".into(), "");
    }
    let mut bytes = header_bytes(&header);
    checksum::seal(&mut bytes, datasum);
    bytes
}

/// The sum of a range of a file that was written.
fn sum_of(mut output: &File, path: &Path, range: Range<u64>) -> io::Result<u32> {
    output.flush()?;
    let mut reader = File::open(path)?;
    reader.seek(SeekFrom::Start(range.start))?;
    let mut chunk = vec![0; BLOCK * 100];
    let (mut left, mut sum) = (range.end - range.start, 0);
    while left > 0 {
        let count = left.min(chunk.len() as u64) as usize;
        reader.read_exact(&mut chunk[..count])?;
        sum = checksum::sum(sum, &chunk[..count]);
        left -= count as u64;
    }
    Ok(sum)
}

fn write_hdu(output: &mut &File, hdu: &NewHdu) -> io::Result<()> {
    output.write_all(&header_bytes(&hdu.header))?;
    output.write_all(&hdu.data)?;
    pad(output, hdu.data.len() as u64, 0).map(drop)
}
