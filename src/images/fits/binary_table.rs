//! Columns of binary tables.

use std::io::{Read, Seek, SeekFrom};

use super::super::header::Header;
use super::frame_file::FrameFile;
use super::hdu::HduKind;
use super::tile_header::{Column, columns};
use crate::error::Error;
use crate::input::{self, MOST_ROWS};

/// Column of a binary table.
#[derive(Clone, Debug, PartialEq)]
pub struct BinaryColumn {
    /// Name, `TTYPEn`.
    pub name: String,
    /// Unit, `TUNITn`.
    pub unit: Option<String>,
    /// Cells of all rows.
    pub cells: BinaryCells,
}

/// Cells of a column of a binary table.
#[derive(Clone, Debug, PartialEq)]
pub enum BinaryCells {
    /// Text, without blanks at its end.
    Text(Vec<String>),
    /// Numbers, the same count in each row; those without a value are NaN.
    Numbers {
        /// Count in a row.
        in_row: usize,
        /// Numbers of all rows.
        values: Vec<f64>,
    },
}

impl FrameFile {
    /// Reads the columns of numbers and of text of a binary table. Columns of other types (truth values, bits, complex
    /// numbers, arrays of variable length) are left out.
    ///
    /// # Errors
    /// The HDU is no binary table, its header is invalid, or the file cannot be read.
    pub(crate) fn read_table(&self, hdu: usize) -> Result<Vec<BinaryColumn>, Error> {
        let (info, header) = (self.hdu(hdu)?, self.header(hdu)?);
        if info.kind != HduKind::Table {
            let error = Error::invalid(format!("HDU {hdu}"), info.words(), "a binary table");
            return Err(error.in_file("", self.path()));
        }
        let columns = columns(header).map_err(|error| error.in_hdu(self.path(), hdu))?;
        let io = Error::io(self.path());
        let count = |keyword: &str| header.integer(keyword).and_then(|number| usize::try_from(number).ok());
        let (row_length, rows) = (count("NAXIS1").unwrap_or(0), count("NAXIS2").unwrap_or(0));
        // The length of the data has been compared with that of the file.
        let length = row_length.checked_mul(rows).filter(|length| *length as u64 <= info.data_length);
        let Some(length) = length.filter(|_| row_length > 0 && rows <= MOST_ROWS) else {
            let given = format!("{rows} rows of {row_length} bytes");
            return Err(Error::invalid(
                "size of the table",
                given,
                format!("rows within the data, at most {MOST_ROWS}"),
            )
            .in_hdu(self.path(), hdu));
        };
        let mut bytes = vec![0; length];
        let mut file = input::open(self.path()).map_err(&io)?;
        file.seek(SeekFrom::Start(info.data_at)).map_err(&io)?;
        file.read_exact(&mut bytes).map_err(&io)?;
        let ends = columns.iter().skip(1).map(|next| next.at).chain([row_length]);
        let cells = columns.iter().zip(ends).map(|(column, end)| {
            let parts: Vec<&[u8]> = bytes.chunks_exact(row_length).filter_map(|row| row.get(column.at..end)).collect();
            Some(BinaryColumn {
                name: header.text(&format!("TTYPE{}", column.number)).unwrap_or_default(),
                unit: header.text(&format!("TUNIT{}", column.number)),
                cells: cells(header, column, end.saturating_sub(column.at), &parts)?,
            })
        });
        Ok(cells.flatten().collect())
    }
}

/// Returns the cells of a column, whose bytes are given row by row; `None` for types that are not read.
fn cells(header: &Header, column: &Column, width: usize, rows: &[&[u8]]) -> Option<BinaryCells> {
    let number: fn(&[u8]) -> Option<f64> = match column.letter {
        _ if column.variable.is_some() => return None,
        'A' => {
            let text = |row: &&[u8]| {
                let end = row.iter().position(|byte| *byte == 0).unwrap_or(row.len());
                String::from_utf8_lossy(&row[..end]).trim_end().to_owned()
            };
            return Some(BinaryCells::Text(rows.iter().map(text).collect()));
        }
        'B' => |bytes| bytes.first().map(|byte| f64::from(*byte)),
        'I' => |bytes| Some(f64::from(i16::from_be_bytes(bytes.try_into().ok()?))),
        'J' => |bytes| Some(f64::from(i32::from_be_bytes(bytes.try_into().ok()?))),
        'K' => |bytes| Some(i64::from_be_bytes(bytes.try_into().ok()?) as f64),
        'E' => |bytes| Some(f64::from(f32::from_be_bytes(bytes.try_into().ok()?))),
        'D' => |bytes| Some(f64::from_be_bytes(bytes.try_into().ok()?)),
        _ => return None,
    };
    let size = match column.letter {
        'B' => 1,
        'I' => 2,
        'J' | 'E' => 4,
        _ => 8,
    };
    let keyword = |name: &str| header.number(&format!("{name}{}", column.number));
    let (scale, zero, null) = (keyword("TSCAL").unwrap_or(1.0), keyword("TZERO").unwrap_or(0.0), keyword("TNULL"));
    let value = |bytes: &[u8]| {
        let stored = number(bytes).filter(|stored| Some(*stored) != null);
        stored.map_or(f64::NAN, |stored| zero + scale * stored)
    };
    Some(BinaryCells::Numbers {
        in_row: width / size,
        values: rows.iter().flat_map(|row| row.chunks_exact(size)).map(value).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Headers whose numbers of rows do not agree with the length of their data.
    #[test]
    fn rows_beyond_the_data_are_an_error() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("table.fits");
        let cards = |cards: &[&str]| {
            let mut block: String = cards.iter().map(|card| format!("{card:80}")).collect();
            block += &format!("{:80}", "END");
            block + &" ".repeat(2880 - 80 * (cards.len() + 1))
        };
        let primary = cards(&["SIMPLE  = T", "BITPIX  = 8", "NAXIS   = 0", "EXTEND  = T"]);
        for (axes, form) in [
            (["NAXIS   = 2", "NAXIS1  = 0", "NAXIS2  = 1000000000000000", "GCOUNT  = 1"], "0A"),
            (["NAXIS   = 1", "NAXIS1  = 8", "NAXIS2  = 1152921504606846976", "GCOUNT  = 1"], "1D"),
            (["NAXIS   = 2", "NAXIS1  = 8", "NAXIS2  = 1152921504606846977", "GCOUNT  = 0"], "1D"),
            (["NAXIS   = 3", "NAXIS1  = 8", "NAXIS2  = 1000000", "NAXIS3  = 0"], "1D"),
        ] {
            let form = format!("TFORM1  = '{form}'");
            let start = ["XTENSION= 'BINTABLE'", "BITPIX  = 8"];
            let end = ["PCOUNT  = 0", "TFIELDS = 1", "TTYPE1  = 'id'", &form];
            let data = if axes[0] == "NAXIS   = 1" { "\0".repeat(2880) } else { String::new() };
            std::fs::write(&path, primary.clone() + &cards(&[&start[..], &axes, &end].concat()) + &data).unwrap();
            let error = FrameFile::open(&path).and_then(|file| file.read_table(1)).expect_err("no table").to_string();
            assert!(error.contains("table.fits") && error.contains("allowed"), "{error}");
        }
    }
}
