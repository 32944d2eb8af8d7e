//! HDUs made from nothing: images and tables.

use std::fs;
use std::path::Path;

use crate::output::ScratchFolder;

use super::super::card::{Card, CardValue};
use super::super::header::Header;
use super::cfitsio::{Rice, write_rice};
use super::error::FrameError;
use super::frame_file::FrameFile;
use super::image_values::ImageValues;

/// Keywords that say how data lie in a file: given by the data themselves, not by a caller.
const STRUCTURE: &[&str] = &[
    "SIMPLE", "XTENSION", "BITPIX", "NAXIS", "PCOUNT", "GCOUNT", "EXTEND", "BSCALE", "BZERO", "EXTNAME", "GROUPS",
    "END",
];

/// A header with its data, ready to be written.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NewHdu {
    pub header: Header,
    pub data: Vec<u8>,
}

/// A column of a table to be written.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumn {
    /// Its name (TTYPEn).
    pub name: String,
    /// Unit (TUNITn); empty for none.
    pub unit: String,
    /// What it is, for the comment of its name.
    pub meaning: String,
    /// Its cells.
    pub cells: Cells,
}

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Numbers in double precision (1D); NaN where nothing is known.
    Real(Vec<f64>),
    /// Whole numbers of 64 bits (1K); `None` where nothing is known, which the file shows as the value of TNULLn: -1, or the least of all numbers where -1 is one of
    /// the others.
    Integer(Vec<Option<i64>>),
    /// Text (nA), ASCII; other characters become `?`.
    Text(Vec<String>),
}

impl Cells {
    /// Number of cells.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(cells) => cells.len(),
            Self::Integer(cells) => cells.len(),
            Self::Text(cells) => cells.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of one cell.
    fn width(&self) -> usize {
        match self {
            Self::Real(_) | Self::Integer(_) => 8,
            Self::Text(cells) => cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0).max(1),
        }
    }

    /// TFORMn.
    fn form(&self) -> String {
        match self {
            Self::Real(_) => "1D".to_owned(),
            Self::Integer(_) => "1K".to_owned(),
            Self::Text(_) => format!("{}A", self.width()),
        }
    }

    /// What stands for nothing in a column of whole numbers that has such cells.
    fn null(&self) -> Option<i64> {
        let Self::Integer(cells) = self else { return None };
        cells.contains(&None).then(|| if cells.contains(&Some(-1)) { i64::MIN } else { -1 })
    }

    fn write(&self, row: usize, null: Option<i64>, out: &mut Vec<u8>) {
        match self {
            Self::Real(cells) => out.extend(cells[row].to_be_bytes()),
            Self::Integer(cells) => out.extend(cells[row].or(null).unwrap_or(-1).to_be_bytes()),
            Self::Text(cells) => {
                let end = out.len() + self.width();
                out.extend(cells[row].chars().map(|c| if (' '..='~').contains(&c) { c as u8 } else { b'?' }));
                out.resize(end, b' ');
            }
        }
    }
}

/// Where an HDU stands in its file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub(super) enum Place {
    Primary,
    Extension,
}

/// A header alone, to stand before extensions.
pub(super) fn empty_primary() -> NewHdu {
    let mut header = Header::default();
    header.set("SIMPLE", &true.into(), "file conforms to the FITS standard");
    header.set("BITPIX", &8_i64.into(), "bits of a value");
    header.set("NAXIS", &0_i64.into(), "no data here");
    header.set("EXTEND", &true.into(), "extensions follow");
    NewHdu { header, data: Vec::new() }
}

/// An image as it is.
pub(super) fn image(place: Place, name: &str, image: &ImageValues, cards: &[Card]) -> NewHdu {
    let [rows, columns] = image.size();
    let format = image.format();
    let mut header = Header::default();
    match place {
        Place::Primary => header.set("SIMPLE", &true.into(), "file conforms to the FITS standard"),
        Place::Extension => header.set("XTENSION", &"IMAGE".into(), "image extension"),
    }
    header.set("BITPIX", &format.bitpix.number().into(), "bits of a value, negative for floating point");
    header.set("NAXIS", &2_i64.into(), "number of axes");
    header.set("NAXIS1", &(columns as i64).into(), "columns");
    header.set("NAXIS2", &(rows as i64).into(), "rows");
    match place {
        Place::Primary => header.set("EXTEND", &true.into(), "extensions may follow"),
        Place::Extension => {
            header.set("PCOUNT", &0_i64.into(), "");
            header.set("GCOUNT", &1_i64.into(), "");
        }
    }
    if format.zero != 0.0 {
        header.set("BZERO", &(format.zero as i64).into(), "numbers without sign");
        header.set("BSCALE", &1_i64.into(), "");
    }
    if !name.is_empty() {
        header.set("EXTNAME", &name.into(), "name of this HDU");
    }
    header.extend(free_cards(cards));
    NewHdu { header, data: image.file_bytes() }
}

/// An image compressed by RICE, one row a tile: CFITSIO makes it in a folder of its own within `scratch`.
pub(super) fn rice_image(
    name: &str,
    image: &ImageValues,
    cards: &[Card],
    rice: Rice,
    scratch: &Path,
) -> Result<NewHdu, FrameError> {
    let folder = ScratchFolder::new(scratch).map_err(FrameError::io(scratch))?;
    let path = folder.path().join("image.fits");
    write_rice(&path, image, rice)?;
    let made = FrameFile::open(&path)?;
    let info = made.hdu(1)?;
    let (from, to) = (info.data_at as usize, (info.data_at + info.data_length) as usize);
    let bytes = fs::read(&path).map_err(FrameError::io(&path))?;
    let mut header = made.header(1)?.clone();
    header.remove("EXTNAME");
    if !name.is_empty() {
        header.set("EXTNAME", &name.into(), "name of this HDU");
    }
    header.extend(free_cards(cards));
    Ok(NewHdu { header, data: bytes[from..to].to_vec() })
}

/// A table.
pub(super) fn table(name: &str, columns: &[TableColumn], cards: &[Card]) -> Result<NewHdu, FrameError> {
    let malformed = |why: String| FrameError::Malformed { name: name.to_owned(), why };
    let rows = columns.first().map_or(0, |column| column.cells.len());
    if let Some(column) = columns.iter().find(|column| column.cells.len() != rows) {
        return Err(malformed(format!(
            "column {} has {} cells, the first one {rows}",
            column.name,
            column.cells.len()
        )));
    }
    if columns.len() > 999 {
        return Err(malformed(format!("{} columns; a FITS table has 999 at most", columns.len())));
    }
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
            header.set(&format!("TNULL{number}"), &null.into(), "nothing known");
        }
        if !column.unit.is_empty() {
            header.set(&format!("TUNIT{number}"), &column.unit.as_str().into(), "");
        }
    }
    if !name.is_empty() {
        header.set("EXTNAME", &name.into(), "name of this HDU");
    }
    header.extend(free_cards(cards));
    let mut data = Vec::with_capacity(rows * width);
    let nulls: Vec<Option<i64>> = columns.iter().map(|column| column.cells.null()).collect();
    for row in 0..rows {
        for (column, null) in columns.iter().zip(&nulls) {
            column.cells.write(row, *null, &mut data);
        }
    }
    Ok(NewHdu { header, data })
}

/// Cards that say nothing of the structure: a header taken from another frame may be handed on as it is.
fn free_cards(cards: &[Card]) -> Vec<Card> {
    let is_structure = |card: &Card| {
        let keyword = card.keyword();
        let is_axis = keyword.strip_prefix("NAXIS").is_some_and(|rest| rest.parse::<u32>().is_ok());
        is_axis || STRUCTURE.contains(&keyword.as_str())
    };
    cards.iter().filter(|card| !is_structure(card)).cloned().collect()
}
