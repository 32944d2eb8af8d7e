//! A copy of a frame with changes.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::output::AtomicFile;

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::cfitsio::Rice;
use super::changed::Changed;
use super::checksum;
use super::error::FrameError;
use super::frame_file::FrameFile;
use super::image_values::ImageValues;
use super::new_frame::folder_of;
use super::new_hdu::{self, NewHdu, Place, TableColumn};
use super::output::{copy_range, has_sums, header_bytes, pad, pad_byte, sealed, write_hdu};
use super::pixel_edit::PixelEdit;

/// A copy of a frame in the making: every byte that is not changed is that of the input.
///
/// Changes are gathered in memory (the touched pixels alone) and written by [`finish`](FrameCopy::finish). Headers keep their cards and their order;
/// CHECKSUM and DATASUM are made right where they stand in an HDU that changed, and EXTEND = F where extensions came. Dropped without `finish`, nothing is left behind.
#[derive(Debug)]
pub struct FrameCopy<'a> {
    source: FrameFile,
    input: File,
    target: PathBuf,
    output: AtomicFile,
    headers: BTreeMap<usize, Header>,
    pixels: BTreeMap<usize, PixelEdit<'a>>,
    appended: Vec<NewHdu>,
}

impl<'a> FrameCopy<'a> {
    /// Begins a copy that will stand at `target`.
    ///
    /// # Errors
    /// [`FrameError::SameFile`] where the target is the input, [`FrameError::Io`] where its folder is missing or cannot be written to.
    pub fn begin(source: &FrameFile, target: &Path) -> Result<Self, FrameError> {
        let input = File::open(source.path()).map_err(FrameError::io(source.path()))?;
        if let (Ok(here), Ok(there)) = (source.path().canonicalize(), target.canonicalize())
            && here == there
        {
            return Err(FrameError::SameFile { path: target.to_owned() });
        }
        Ok(Self {
            source: source.clone(),
            input,
            target: target.to_owned(),
            output: AtomicFile::new(target).map_err(FrameError::io(target))?,
            headers: BTreeMap::new(),
            pixels: BTreeMap::new(),
            appended: Vec::new(),
        })
    }

    /// Adds light to pixels of one row, from `first_column` on: physical values. What is added several times to one pixel is summed up and stored once in
    /// the end; [`finish`](FrameCopy::finish) says what came of it. Where pixels can take certain values alone (whole numbers, quantised tiles), light between
    /// two of them goes to one or the other, by a fraction that belongs to the pixel: its sum over many pixels is right, however faint it is.
    ///
    /// # Errors
    /// As [`change`](FrameCopy::change).
    pub fn add(
        &mut self,
        hdu: usize,
        row: usize,
        first_column: usize,
        values: impl Into<Cow<'a, [f32]>>,
    ) -> Result<(), FrameError> {
        let values = values.into();
        self.check_part(hdu, row, &(first_column..first_column + values.len()))?;
        self.edit(hdu)?.0.add(row, first_column, values);
        Ok(())
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
        self.check_part(hdu, row, &columns)?;
        let (edit, input) = self.edit(hdu)?;
        edit.change(input, row, columns, change)
    }

    /// Sets a keyword in the header of an HDU: in its place where it is there, else behind all others. A comment of nothing keeps the old one.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn set_card(&mut self, hdu: usize, keyword: &str, value: &CardValue, comment: &str) -> Result<(), FrameError> {
        self.header_mut(hdu)?.set(keyword, value, comment);
        Ok(())
    }

    /// Adds HISTORY to the header of an HDU, behind what is there of it.
    ///
    /// # Errors
    /// [`FrameError::NoHdu`].
    pub fn add_history(&mut self, hdu: usize, text: &str) -> Result<(), FrameError> {
        self.header_mut(hdu)?.add_remark("HISTORY", text);
        Ok(())
    }

    /// Puts an image behind all HDUs; compressed where `rice` says how.
    ///
    /// # Errors
    /// What CFITSIO and the system report for compressed ones.
    pub fn append_image(
        &mut self,
        name: &str,
        image: &ImageValues,
        cards: &[Card],
        rice: Option<Rice>,
    ) -> Result<(), FrameError> {
        let hdu = match rice {
            Some(rice) => new_hdu::rice_image(name, image, cards, rice, folder_of(self.output.path()))?,
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

    /// Writes the copy and puts it in its place. What came of the changes to pixels, by HDU.
    ///
    /// # Errors
    /// Whatever the system reports; a file that stood at the target is then still there, and nothing else.
    pub fn finish(mut self) -> Result<BTreeMap<usize, Changed>, FrameError> {
        let mut tables = BTreeMap::new();
        for (hdu, edit) in &mut self.pixels {
            let Some(rebuilt) = edit.rebuilt()? else { continue };
            let header = entry_of(&mut self.headers, &self.source, *hdu)?;
            header.set("PCOUNT", &(rebuilt.heap_length as i64).into(), "");
            if header.contains("THEAP") {
                header.set("THEAP", &((rebuilt.bytes.len() - rebuilt.heap_length) as i64).into(), "");
            }
            for (keyword, form) in &rebuilt.forms {
                header.set(keyword, &form.as_str().into(), "");
            }
            tables.insert(*hdu, rebuilt.bytes);
        }
        // A primary header that denies extensions is wrong once there are some.
        if !self.appended.is_empty() && self.source.header(0)?.logical("EXTEND") == Some(false) {
            self.set_card(0, "EXTEND", &true.into(), "")?;
        }
        self.write(&tables).map_err(|source| match source.kind() {
            io::ErrorKind::UnexpectedEof => {
                let why = "the input became shorter while it was copied";
                FrameError::Io { path: self.source.path().to_owned(), source: io::Error::new(source.kind(), why) }
            }
            _ => FrameError::Io { path: self.target.clone(), source },
        })?;
        self.output.finish_lazily().map_err(FrameError::io(&self.target))?;
        Ok(self.pixels.into_iter().map(|(hdu, edit)| (hdu, edit.changed)).collect())
    }

    fn write(&mut self, tables: &BTreeMap<usize, Vec<u8>>) -> io::Result<()> {
        let is_flushed = self.output.is_replacing();
        let mut output = self.output.file();
        let mut at = 0;
        for info in self.source.hdus() {
            let hdu = info.index;
            let header = self.headers.get(&hdu);
            let edit = self.pixels.get_mut(&hdu);
            let data = info.data_at..info.data_at + info.data_length;
            let is_summed = (header.is_some() || edit.is_some()) && self.source.header(hdu).is_ok_and(has_sums);
            let header_length = match header {
                Some(header) => {
                    let bytes = header_bytes(header);
                    output.write_all(&bytes)?;
                    bytes.len() as u64
                }
                None => {
                    copy_range(&mut self.input, output, info.header_at..info.data_at)?;
                    info.data_at - info.header_at
                }
            };
            let mut length = info.data_length;
            let mut sum = None;
            match (tables.get(&hdu), edit) {
                (Some(table), _) => {
                    output.write_all(table)?;
                    length = table.len() as u64;
                    sum = Some(checksum::sum_padded(0, table));
                }
                (None, Some(edit)) => {
                    let start = at + header_length;
                    sum = edit.stream(&self.input, output, start, is_summed, is_flushed)?;
                    output.seek(SeekFrom::Start(start + length))?;
                }
                (None, None) => copy_range(&mut self.input, output, data.clone())?,
            }
            let end = pad(output, at + header_length + length, pad_byte(info))?;
            if is_summed {
                let sum = match sum {
                    Some(sum) => sum,
                    None => checksum::sum_of(&mut self.input, data, pad_byte(info))?,
                };
                let header = header.or(self.source.header(hdu).ok()).cloned().unwrap_or_default();
                output.seek(SeekFrom::Start(at))?;
                output.write_all(&sealed(&header, sum))?;
                output.seek(SeekFrom::Start(end))?;
            }
            at = end;
        }
        self.appended.iter().try_for_each(|hdu| write_hdu(output, hdu))?;
        let end = output.stream_position()?;
        output.set_len(end)
    }

    /// The changes to an image, and the file that it is read from.
    fn edit(&mut self, hdu: usize) -> Result<(&mut PixelEdit<'a>, &mut File), FrameError> {
        let edit = match self.pixels.entry(hdu) {
            std::collections::btree_map::Entry::Occupied(entry) => entry.into_mut(),
            std::collections::btree_map::Entry::Vacant(entry) => {
                let (info, header) = (self.source.hdu(hdu)?, self.source.header(hdu)?);
                entry.insert(PixelEdit::new(self.source.path(), info, header, &mut self.input)?)
            }
        };
        Ok((edit, &mut self.input))
    }

    fn header_mut(&mut self, hdu: usize) -> Result<&mut Header, FrameError> {
        entry_of(&mut self.headers, &self.source, hdu)
    }

    /// Whether an image has these pixels.
    fn check_part(&self, hdu: usize, row: usize, columns: &Range<usize>) -> Result<(), FrameError> {
        let (_, [row_count, column_count]) = self.source.image(hdu)?;
        if row < row_count && columns.end <= column_count && columns.start < columns.end {
            return Ok(());
        }
        Err(FrameError::Outside {
            path: self.source.path().to_owned(),
            hdu,
            columns: column_count,
            rows: row_count,
            row,
            first: columns.start,
            last: columns.end.max(1) - 1,
        })
    }
}

/// The header of an HDU to be changed.
fn entry_of<'a>(
    headers: &'a mut BTreeMap<usize, Header>,
    source: &FrameFile,
    hdu: usize,
) -> Result<&'a mut Header, FrameError> {
    let header = source.header(hdu)?;
    Ok(headers.entry(hdu).or_insert_with(|| header.clone()))
}
