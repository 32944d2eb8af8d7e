//! New HDUs: images and tables.

use std::borrow::Cow;
use std::path::Path;

use crate::error::Error;
use crate::output::{AtomicFile, ScratchFolder};

use super::super::card::{Card, CardValue, to_ascii};
use super::super::header::Header;
use super::cfitsio::{Handle, Rice};
use super::pixel_format::ImageValues;

/// Keywords that describe the structure of a file. They are computed from the data, not taken from a caller.
const STRUCTURE: &[&str] = &[
    "SIMPLE", "XTENSION", "BITPIX", "NAXIS", "PCOUNT", "GCOUNT", "EXTEND", "BSCALE", "BZERO", "EXTNAME", "GROUPS",
    "END",
];

/// Image for [`write_frame`].
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NewImage<'a> {
    /// Name of the HDU (EXTNAME); empty if it has none.
    pub name: &'a str,
    /// Pixels.
    pub values: &'a ImageValues<'a>,
    /// Header cards; cards that describe the structure (NAXIS, BITPIX, ...) are ignored.
    pub cards: &'a [Card],
    /// Compression; `None` for an uncompressed image.
    pub rice: Option<Rice>,
}

/// Writes a file of images with their names and cards. The first image is in the primary HDU unless it is compressed;
/// the others follow as extensions.
///
/// # Errors
/// Errors of the operating system and of CFITSIO; no partial file remains.
pub fn write_frame(target: &Path, images: &[NewImage<'_>]) -> Result<(), Error> {
    let mut hdus: Vec<NewHdu> = images
        .iter()
        .map(|image| NewHdu::image(image.name, Cow::Borrowed(image.values), image.cards, image.rice))
        .collect();
    if let Some(NewHdu { data: NewData::Image(_), is_primary, .. }) = hdus.first_mut() {
        *is_primary = true;
    }
    write_hdus(target, &hdus)
}

/// Writes a file with one table, which follows an empty primary HDU.
///
/// # Errors
/// The errors of [`write_frame`], and columns of different lengths.
pub fn write_table(target: &Path, name: &str, columns: &[TableColumn], cards: &[Card]) -> Result<(), Error> {
    write_hdus(target, &[NewHdu::table(name, columns.to_vec(), cards)?])
}

fn write_hdus(target: &Path, hdus: &[NewHdu<'_>]) -> Result<(), Error> {
    let io = Error::io(target);
    let mut output = AtomicFile::new(target).map_err(&io)?;
    let folder = ScratchFolder::new(folder_of(output.path())).map_err(&io)?;
    let path = folder.path().join("new.fits");
    create(&path, hdus).map_err(|error| error.of_file(target))?;
    output.take(&path).map_err(&io)?;
    output.finish_lazily().map_err(&io)
}

/// Returns the folder that contains a file.
pub(super) fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Creates a file from HDUs. If the first of them is not a primary HDU, an empty primary HDU precedes them.
pub(super) fn create(path: &Path, hdus: &[NewHdu<'_>]) -> Result<(), Error> {
    let mut handle = Handle::create(path)?;
    let mut number = 0;
    if hdus.first().is_none_or(|hdu| !hdu.is_primary) {
        handle.append_hdu(empty_primary().cards())?;
        number += 1;
    }
    for hdu in hdus {
        hdu.write(&mut handle, number)?;
        number += 1;
    }
    handle.close()
}

/// Column of a table to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Name (TTYPEn).
    pub name: String,
    /// Unit (TUNITn); empty if it has none.
    pub unit: String,
    /// Description, written as the comment of TTYPEn.
    pub meaning: String,
    /// Cells of the column.
    pub cells: Cells,
}

/// Cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Numbers in double precision (1D); NaN for missing values.
    Real(Vec<f64>),
    /// 64-bit integers (1K). `None` for missing values, which are stored as TNULLn: -1, or the smallest 64-bit integer
    /// if -1 is one of the values.
    Integer(Vec<Option<i64>>),
    /// ASCII text (nA); other characters become `?`.
    Text(Vec<String>),
}

impl Cells {
    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(cells) => cells.len(),
            Self::Integer(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
        }
    }

    /// Returns true if there are no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the length of one cell, bytes.
    fn width(&self) -> usize {
        match self {
            Self::Real(_) | Self::Integer(_) => 8,
            Self::Text(cells) => cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0).max(1),
        }
    }

    /// Returns the format of the column (TFORMn).
    fn form(&self) -> String {
        match self {
            Self::Real(_) => "1D".to_owned(),
            Self::Integer(_) => "1K".to_owned(),
            Self::Text(_) => format!("{}A", self.width()),
        }
    }

    /// Returns the number that stands for missing values, if this is a column of integers with missing values.
    fn null(&self) -> Option<i64> {
        let Self::Integer(cells) = self else { return None };
        cells.contains(&None).then(|| if cells.contains(&Some(-1)) { i64::MIN } else { -1 })
    }

    fn write(&self, handle: &mut Handle<'_>, hdu: usize, name: &str) -> Result<(), Error> {
        let null = self.null().unwrap_or(-1);
        handle.fitsio(|file| {
            let table = file.hdu(hdu)?;
            match self {
                Self::Real(cells) => table.write_col(file, name, cells),
                Self::Integer(cells) => {
                    let cells: Vec<i64> = cells.iter().map(|cell| cell.unwrap_or(null)).collect();
                    table.write_col(file, name, &cells)
                }
                Self::Text(cells) => {
                    let cells: Vec<String> = cells.iter().map(|cell| to_ascii(cell)).collect();
                    table.write_col(file, name, &cells)
                }
            }
            .map(drop)
        })
    }
}

/// HDU to be written: header and data.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NewHdu<'a> {
    name: String,
    cards: Vec<Card>,
    data: NewData<'a>,
    /// True if this is the first HDU of its file.
    is_primary: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum NewData<'a> {
    Image(Cow<'a, ImageValues<'a>>),
    Rice(Cow<'a, ImageValues<'a>>, Rice),
    Table(Vec<TableColumn>),
}

impl<'a> NewHdu<'a> {
    /// Creates an image extension.
    pub fn image(name: &str, values: Cow<'a, ImageValues<'a>>, cards: &[Card], rice: Option<Rice>) -> Self {
        let data = match rice {
            None => NewData::Image(values),
            Some(rice) => NewData::Rice(values, rice),
        };
        Self { name: name.to_owned(), cards: free_cards(cards), data, is_primary: false }
    }

    /// Creates a table.
    ///
    /// # Errors
    /// Columns differ in length, or there are more than 999 columns.
    pub fn table(name: &str, columns: Vec<TableColumn>, cards: &[Card]) -> Result<Self, Error> {
        let rows = columns.first().map_or(0, |column| column.cells.len());
        if let Some(column) = columns.iter().find(|column| column.cells.len() != rows) {
            let what = format!("table {name:?}: length of column {}", column.name);
            return Err(Error::invalid(what, column.cells.len(), format!("{rows}, the length of the first column")));
        }
        if columns.len() > 999 {
            let what = format!("table {name:?}: number of columns");
            return Err(Error::invalid(what, columns.len(), "at most 999 in a FITS table"));
        }
        let data = NewData::Table(columns);
        Ok(Self { name: name.to_owned(), cards: free_cards(cards), data, is_primary: false })
    }

    /// Appends the HDU to a file in which it becomes HDU number `hdu`.
    fn write(&self, handle: &mut Handle<'_>, hdu: usize) -> Result<(), Error> {
        let mut header = match &self.data {
            NewData::Image(values) => image_header(values, self.is_primary),
            NewData::Rice(..) => Header::default(),
            NewData::Table(columns) => table_header(columns),
        };
        if !self.name.is_empty() {
            header.set("EXTNAME", &self.name.as_str().into(), "name of this HDU");
        }
        header.extend(self.cards.iter().cloned());
        match &self.data {
            NewData::Rice(values, rice) => values.write_rice(handle, hdu, *rice, header.cards()),
            NewData::Image(values) => {
                handle.append_hdu(header.cards())?;
                values.write(handle, hdu)
            }
            NewData::Table(columns) => {
                handle.append_hdu(header.cards())?;
                let filled = columns.iter().filter(|column| !column.cells.is_empty());
                filled.into_iter().try_for_each(|column| column.cells.write(handle, hdu, &column.name))
            }
        }
    }
}

/// Returns the header of an empty primary HDU that is followed by extensions.
pub(super) fn empty_primary() -> Header {
    let mut header = Header::default();
    header.set("SIMPLE", &true.into(), "file conforms to the FITS standard");
    header.set("BITPIX", &8_i64.into(), "bits of a value");
    header.set("NAXIS", &0_i64.into(), "no data here");
    header.set("EXTEND", &true.into(), "extensions follow");
    header
}

fn image_header(values: &ImageValues<'_>, is_primary: bool) -> Header {
    let [rows, columns] = values.size();
    let format = values.format();
    let mut header = Header::default();
    if is_primary {
        header.set("SIMPLE", &true.into(), "file conforms to the FITS standard");
    } else {
        header.set("XTENSION", &"IMAGE".into(), "image extension");
    }
    header.set("BITPIX", &format.bitpix.number().into(), "bits of a value, negative for floating point");
    header.set("NAXIS", &2_i64.into(), "number of axes");
    header.set("NAXIS1", &(columns as i64).into(), "columns");
    header.set("NAXIS2", &(rows as i64).into(), "rows");
    if is_primary {
        header.set("EXTEND", &true.into(), "extensions may follow");
    } else {
        header.set("PCOUNT", &0_i64.into(), "");
        header.set("GCOUNT", &1_i64.into(), "");
    }
    if format.zero != 0.0 {
        header.set("BZERO", &(format.zero as i64).into(), "numbers without sign");
        header.set("BSCALE", &1_i64.into(), "");
    }
    header
}

fn table_header(columns: &[TableColumn]) -> Header {
    let rows = columns.first().map_or(0, |column| column.cells.len());
    let width: usize = columns.iter().map(|column| column.cells.width()).sum();
    let mut header = Header::default();
    header.set("XTENSION", &"BINTABLE".into(), "binary table extension");
    header.set("BITPIX", &8_i64.into(), "bytes");
    header.set("NAXIS", &2_i64.into(), "");
    header.set("NAXIS1", &(width as i64).into(), "bytes of a row");
    header.set("NAXIS2", &(rows as i64).into(), "rows");
    header.set("PCOUNT", &0_i64.into(), "");
    header.set("GCOUNT", &1_i64.into(), "");
    header.set("TFIELDS", &(columns.len() as i64).into(), "columns");
    for (number, column) in columns.iter().enumerate().map(|(index, column)| (index + 1, column)) {
        header.set(&format!("TTYPE{number}"), &column.name.as_str().into(), &column.meaning);
        header.set(&format!("TFORM{number}"), &CardValue::Text(column.cells.form()), "");
        if let Some(null) = column.cells.null() {
            header.set(&format!("TNULL{number}"), &null.into(), "no value");
        }
        if !column.unit.is_empty() {
            header.set(&format!("TUNIT{number}"), &column.unit.as_str().into(), "");
        }
    }
    header
}

/// Returns the cards that do not describe the structure, so that the header of another frame can be passed on
/// unchanged.
fn free_cards(cards: &[Card]) -> Vec<Card> {
    let is_structure = |card: &Card| {
        let keyword = card.keyword();
        let is_axis = keyword.strip_prefix("NAXIS").is_some_and(|rest| rest.parse::<u32>().is_ok());
        is_axis || STRUCTURE.contains(&keyword.as_str())
    };
    cards.iter().filter(|card| !is_structure(card)).cloned().collect()
}
