//! Rows of tables as CSV and ECSV, with typed cells, and errors that name line and column.

use std::collections::BTreeMap;
use std::io::{self, Cursor};
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use super::ecsv::{Ecsv, LineError, is_ecsv};
use super::file::{invalid, read_to_string};
use crate::error::Error;
use crate::message::Quoted;
use crate::units::Unit;

/// Largest number of rows of a table.
pub const MOST_ROWS: usize = 5_000_000;
/// Largest number of bytes of a row, for example of one that lists all satellites that cross an exposure.
const LONGEST_ROW: usize = 100_000;

/// Rows of a small CSV or ECSV table with a line of names, read one by one. Lines that begin with `#` are comments, and
/// blanks around cells are ignored. CSV is separated by commas, semicolons or tabs. Units are those of the header of
/// ECSV, and of the names of the columns.
pub struct TableRows {
    rows: Rows,
    names: Arc<[String]>,
    units: BTreeMap<String, String>,
    /// Lines that begin with `#` at the start of the file.
    pub comments: String,
    /// Number of comments below the line of names that have as many cells as it. A first cell that begins with `#` must
    /// be in quotation marks.
    pub comments_like_rows: usize,
    count: usize,
}

enum Rows {
    /// Reader, its text, and the number of lines up to an offset in the text.
    Csv(csv::StringRecordsIntoIter<Cursor<Arc<[u8]>>>, Arc<[u8]>, u64, usize),
    /// Text, its layout, the number of rows that were read, and the line and the offset of the last one.
    Ecsv(String, Box<Ecsv>, usize, u64, usize),
}

/// Column of a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Column {
    index: usize,
    /// Name in messages.
    name: &'static str,
    scale: f64,
    /// Another column of the same quantity.
    other: Option<OtherColumn>,
}

/// Column that is compared with the one that is read.
#[derive(Copy, Clone, Debug, PartialEq)]
struct OtherColumn {
    index: usize,
    scale: f64,
    unit: &'static Unit,
}

/// Row of a table.
#[derive(Clone, Debug)]
pub struct TableRow {
    /// Line in the file, from 1.
    pub line: u64,
    cells: csv::StringRecord,
    names: Arc<[String]>,
}

impl TableRow {
    /// Returns all cells.
    pub fn cells(&self) -> impl Iterator<Item = &str> {
        self.cells.iter()
    }

    /// Returns the cell of a column; empty if it is missing.
    pub fn text(&self, column: Column) -> &str {
        self.cells.get(column.index).unwrap_or_default()
    }

    /// Returns the number in a cell, in the unit that the column was found with; `None` if it is not a number.
    pub fn number(&self, column: Column) -> Option<f64> {
        self.text(column).parse::<f64>().ok().map(|number| number * column.scale)
    }

    /// Returns the contradiction of the number in a cell and that in another column of the same quantity; `None` if
    /// there is none. Cells that are not numbers are not compared.
    pub fn contradiction(&self, column: Column) -> Option<Error> {
        let OtherColumn { index, scale, unit } = column.other?;
        let cell = self.cells.get(index).unwrap_or_default();
        let other = cell.parse::<f64>().ok().map(|number| number * scale).filter(|number| number.is_finite())?;
        let [first, second] = [column.index, index].map(|index| &self.names[index]);
        self.number(column).filter(|number| number.is_finite() && !unit.is_same(first, *number, other))?;
        let [own, cell] = [self.text(column), cell].map(Quoted::new);
        let sentence = format!("{first} is {own} and {second} is {cell}: they contradict each other");
        Some(Error::format(sentence).allowing("one of these columns, or equal values"))
    }

    /// Returns a number in a range.
    ///
    /// # Errors
    /// The cell is not a number, is out of range, or contradicts another column of the same quantity.
    pub fn number_in(&self, column: Column, [least, most]: [f64; 2]) -> io::Result<f64> {
        if let Some(error) = self.contradiction(column) {
            return Err(invalid(format!("line {}: {error}", self.line)));
        }
        let number = self.number(column).filter(|number| number.is_finite() && (least..=most).contains(number));
        number.ok_or_else(|| match (least > f64::MIN, most < f64::MAX) {
            (true, true) => self.wrong(column, &format!("a number from {least} to {most}")),
            (true, false) => self.wrong(column, &format!("a number from {least}")),
            _ => self.wrong(column, "a number"),
        })
    }

    /// Returns the value in a cell.
    ///
    /// # Errors
    /// The cell is not such a value; the message names `allowed`.
    pub fn parsed<T: FromStr>(&self, column: Column, allowed: &str) -> io::Result<T> {
        self.text(column).parse().map_err(|_| self.wrong(column, allowed))
    }

    /// Returns the truth value in a cell, in the spelling of this project (`true`) or of Python and ECSV (`True`).
    ///
    /// # Errors
    /// The cell is neither true nor false.
    pub fn truth(&self, column: Column) -> io::Result<bool> {
        match self.text(column) {
            "true" | "True" | "TRUE" => Ok(true),
            "false" | "False" | "FALSE" => Ok(false),
            _ => Err(self.wrong(column, "true or false")),
        }
    }

    /// Returns true if a cell has no value: it is empty, or the `nan` that astropy writes for a missing number.
    pub fn is_missing(&self, column: Column) -> bool {
        let text = self.text(column);
        text.is_empty() || text.eq_ignore_ascii_case("nan") || text == "--"
    }

    /// Returns the error for an invalid cell.
    pub fn wrong(&self, column: Column, allowed: &str) -> io::Error {
        let Column { name, .. } = column;
        invalid(format!("line {}: {name} is '{}'; allowed: {allowed}", self.line, Quoted::new(self.text(column))))
    }
}

impl TableRows {
    /// Opens a table and reads its names.
    ///
    /// # Errors
    /// The errors of [`read_to_string`], and text that is neither CSV nor ECSV.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::new(read_to_string(path)?)
    }

    /// Reads the names of a table in a text.
    ///
    /// # Errors
    /// The text is neither CSV nor ECSV.
    pub fn new(text: String) -> io::Result<Self> {
        let comments: Vec<&str> = text.lines().take_while(|line| line.starts_with('#')).collect();
        let comments = comments.join("\n");
        if text.trim_start().starts_with('<') {
            return Err(invalid("is XML, such as a VOTable; allowed: CSV or ECSV".to_owned()));
        }
        if is_ecsv(&text) {
            let ecsv = Ecsv::parse(&text).map_err(|error| invalid(error.to_string()))?;
            ecsv.check_utc().map_err(invalid)?;
            let (names, units, comments_like_rows) =
                (unique(ecsv.names.clone())?.into(), ecsv.units(), ecsv.comments_like_rows);
            let rows = Rows::Ecsv(text, Box::new(ecsv), 0, 1, 0);
            return Ok(Self { rows, names, units, comments, comments_like_rows, count: 0 });
        }
        let delimiter = delimiter_of(first_line(&text));
        let comments_like_rows =
            comments_like_rows(&text, delimiter).map_err(|line| invalid(format!("line {line}: {UNCLOSED}")))?;
        let text: Arc<[u8]> = text.into_bytes().into();
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .from_reader(Cursor::new(text.clone()));
        let names = unique(reader.headers().map_err(csv_error)?.iter().map(str::to_owned).collect())?.into();
        let (rows, units) = (Rows::Csv(reader.into_records(), text, 1, 0), BTreeMap::new());
        Ok(Self { rows, names, units, comments, comments_like_rows, count: 0 })
    }

    /// Writes the names of the columns in lower case. If several names differ only in upper and lower case, they are
    /// kept: the column is the one in lower case, or else it is ambiguous ([`TableRows::check_unambiguous`]).
    pub fn in_lower_case(self) -> Self {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        for name in self.names.iter() {
            *counts.entry(name.to_ascii_lowercase()).or_default() += 1;
        }
        let renamed = |name: &str| {
            let lower = name.to_ascii_lowercase();
            let is_ambiguous = counts.get(&lower).is_some_and(|count| *count > 1);
            if is_ambiguous { name.to_owned() } else { lower }
        };
        // The header of an ECSV file may have units of columns that its line of names lacks.
        let names = self.names.iter().map(|name| renamed(name)).collect();
        let units = self.units.iter().map(|(name, unit)| (renamed(name), unit.clone())).collect();
        Self { names, units, ..self }
    }

    /// Checks that not several columns have this name in other upper and lower case, and none in this one.
    ///
    /// # Errors
    /// There are several; the message has their names.
    pub fn check_unambiguous(&self, name: &str) -> io::Result<()> {
        let mut alike = self.names.iter().filter(|own| own.eq_ignore_ascii_case(name));
        match (alike.next(), alike.next()) {
            (Some(first), Some(other)) if !self.names.iter().any(|own| own == name) => {
                let [first, other] = [first, other].map(Quoted::new);
                Err(invalid(format!("columns {first} and {other} have the same name; allowed: one of them, or {name}")))
            }
            _ => Ok(()),
        }
    }

    /// Returns the names of all columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns a column.
    ///
    /// # Errors
    /// The column is missing; the message names `allowed`.
    pub fn column(&self, name: &'static str, allowed: &str) -> io::Result<Column> {
        self.find(name).ok_or_else(|| missing(name, allowed))
    }

    /// Returns a column; `None` if it is missing.
    pub fn find(&self, name: &'static str) -> Option<Column> {
        let index = self.names.iter().position(|found| found == name)?;
        Some(Column { index, name, scale: 1.0, other: None })
    }

    /// Returns a column of numbers, which are converted to `unit`; `None` if it is missing. It has one of the names in
    /// `accepted`, in order of preference, or such a name with another unit at its end. A second column with an
    /// accepted name and an accepted unit is compared with it, row by row.
    ///
    /// # Errors
    /// The unit is unknown or contradicts the name of the column.
    pub fn optional_numbers(&self, accepted: &[&'static str], unit: &'static Unit) -> io::Result<Option<Column>> {
        let failed = |error: Error| invalid(error.to_string());
        let Some(index) = unit.find(accepted, &self.names).map_err(failed)? else { return Ok(None) };
        let scale = unit.scale(&self.names[index], &self.units).map_err(failed)?;
        let others = unit.columns(accepted, &self.names).into_iter().filter(|other| *other != index);
        let other = others.into_iter().find_map(|other| {
            let scale = unit.scale(&self.names[other], &self.units).ok()?;
            Some(OtherColumn { index: other, scale, unit })
        });
        Ok(Some(Column { index, name: accepted[0], scale, other }))
    }

    /// Same as [`TableRows::optional_numbers`], for a column that the table must have.
    ///
    /// # Errors
    /// The errors of [`TableRows::optional_numbers`], and a missing column; the message names `allowed`.
    pub fn numbers(&self, accepted: &[&'static str], unit: &'static Unit, allowed: &str) -> io::Result<Column> {
        self.optional_numbers(accepted, unit)?.ok_or_else(|| missing(accepted[0], allowed))
    }
}

impl Iterator for TableRows {
    type Item = io::Result<TableRow>;

    fn next(&mut self) -> Option<Self::Item> {
        let names = self.names.clone();
        let row = match &mut self.rows {
            Rows::Csv(rows, text, line, at) => {
                let row = rows.next()?;
                let position = row.as_ref().map_or_else(csv::Error::position, csv::StringRecord::position);
                // The position of a row is before the end of the previous line, and before comments.
                let end = position.map_or(*at, |position| position.byte() as usize).clamp(*at, text.len());
                let start = end + blank_or_comment(&text[end..]);
                *line += text[*at..start].iter().filter(|byte| **byte == b'\n').count() as u64;
                *at = start;
                match row {
                    Ok(cells) => Ok(TableRow { line: *line, cells, names }),
                    Err(error) => Err(match error.kind() {
                        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => invalid(format!(
                            "line {line}: {len} cells, but {expected_len} columns; allowed: one cell for each column"
                        )),
                        _ => csv_error(error),
                    }),
                }
            }
            Rows::Ecsv(text, ecsv, read, line, at) => {
                let (start, end) = *ecsv.rows.get(*read)?;
                *line += text[*at..start].matches('\n').count() as u64;
                (*read, *at) = (*read + 1, start);
                let cells = ecsv.record(&text[start..end]);
                let (found, expected) = (cells.len(), self.names.len());
                let error = || LineError::new(*line, format!("{found} cells, but {expected} columns"));
                if found == expected {
                    Ok(TableRow { line: *line, cells: cells.into(), names })
                } else {
                    Err(invalid(error().to_string()))
                }
            }
        };
        self.count += 1;
        let count = self.count;
        Some(row.and_then(|row| {
            if count > MOST_ROWS {
                return Err(invalid(format!("more than {MOST_ROWS} rows; allowed: at most {MOST_ROWS}")));
            }
            if row.cells.as_slice().len() > LONGEST_ROW {
                let line = row.line;
                return Err(invalid(format!(
                    "line {line} is longer than {LONGEST_ROW} bytes; allowed: at most {LONGEST_ROW}"
                )));
            }
            Ok(row)
        }))
    }
}

/// Returns the number of bytes of line ends and comments at the beginning of a text.
fn blank_or_comment(text: &[u8]) -> usize {
    let mut length = 0;
    while let Some(byte) = text.get(length) {
        length += match byte {
            b'\r' | b'\n' => 1,
            b'#' => text[length..].iter().position(|byte| *byte == b'\n').unwrap_or(text.len() - length),
            _ => break,
        };
    }
    length
}

/// Returns the first line that is neither blank nor a comment; empty if there is none.
pub fn first_line(text: &str) -> &str {
    text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default()
}

/// Returns the names if there is one column of each.
fn unique(names: Vec<String>) -> io::Result<Vec<String>> {
    match names.iter().enumerate().find(|(index, name)| !name.is_empty() && names[..*index].contains(name)) {
        Some((_, name)) => Err(invalid(format!("two columns have the name {}; allowed: one", Quoted::new(name)))),
        None => Ok(names),
    }
}

/// Problem of a cell whose quotation mark is not closed.
pub const UNCLOSED: &str = "the cell that begins with a quotation mark has no other one at its end";

/// Returns a warning about comments that have as many cells as a row; `None` if there are none.
pub fn comments_warning(comments_like_rows: usize) -> Option<String> {
    let comments = match comments_like_rows {
        0 => return None,
        1 => "1 comment has".to_owned(),
        several => format!("{several} comments have"),
    };
    Some(format!("{comments} as many cells as a row: a first cell that begins with # must be in quotation marks"))
}

/// Returns the number of comments below the line of names of CSV that have as many cells as it.
///
/// # Errors
/// The line, from 1, in which a quoted cell begins that ends nowhere. Readers would take all following rows for a part
/// of it.
pub fn comments_like_rows(text: &str, delimiter: u8) -> Result<usize, usize> {
    let names = first_line(text).bytes().filter(|byte| *byte == delimiter).count();
    let mut line = 1;
    let (mut is_row_start, mut is_cell_start, mut is_comment) = (true, true, false);
    let (mut separators, mut has_names, mut like_rows) = (0, false, 0);
    let mut opened = None;
    let mut bytes = text.bytes().peekable();
    while let Some(byte) = bytes.next() {
        if byte == b'\n' {
            line += 1;
        }
        if opened.is_some() {
            // Two quotation marks are one character of the cell.
            if byte == b'"' && bytes.next_if_eq(&b'"').is_none() {
                opened = None;
            }
            continue;
        }
        is_comment |= is_row_start && byte == b'#';
        separators = if is_row_start { 0 } else { separators } + usize::from(byte == delimiter);
        if byte == b'\n' || bytes.peek().is_none() {
            like_rows += usize::from(is_comment && has_names && names > 0 && separators == names);
            is_comment = false;
        }
        has_names |= !is_comment && !byte.is_ascii_whitespace();
        if byte == b'"' && is_cell_start && !is_comment {
            opened = Some(line);
        }
        is_row_start = byte == b'\n';
        is_cell_start = is_row_start || byte == delimiter;
    }
    opened.map_or(Ok(like_rows), Err)
}

/// Returns the most frequent separator of the line of names; a comma if it has none.
pub fn delimiter_of(header: &str) -> u8 {
    let count = |delimiter: u8| header.bytes().filter(|byte| *byte == delimiter).count();
    [b',', b';', b'\t'].into_iter().rev().max_by_key(|delimiter| count(*delimiter)).unwrap_or(b',')
}

fn missing(column: &str, allowed: &str) -> io::Error {
    invalid(format!("missing column {column}; allowed: {allowed}"))
}

fn csv_error(error: csv::Error) -> io::Error {
    let text = error.to_string();
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        _ => invalid(text),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{DEGREES, SECONDS};

    /// Blanks separate the cells of ECSV, and quoted cells contain blanks; in CSV the separator is that of the names.
    #[test]
    fn all_forms_give_the_same_cells() {
        let header = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: name, datatype: string}\n\
            # - {description: 'position, {ICRS}', name: ra, unit: hourangle, datatype: float64}\n";
        for (text, scale, line) in [
            (format!("{header}name ra\n\"a b\"   1.5\n"), 15.0, 7),
            (format!("{header}# delimiter: ','\nname,ra\n\"a b\", 1.5\n"), 15.0, 8),
            ("# note\nname; ra\na b ;1.5\n".to_owned(), 1.0, 3),
            ("name\tra\na b\t1.5\n".to_owned(), 1.0, 2),
        ] {
            let mut rows = TableRows::new(text.clone()).unwrap();
            let [name, ra] = [rows.find("name").unwrap(), rows.numbers(&["ra_deg", "ra"], &DEGREES, "").unwrap()];
            let row = rows.next().unwrap().unwrap();
            assert_eq!((row.text(name), row.number(ra), row.line), ("a b", Some(1.5 * scale), line), "{text}");
            let error = row.number_in(ra, [0.0, 1.0]).unwrap_err().to_string();
            assert_eq!(error, format!("line {line}: ra_deg is '1.5'; allowed: a number from 0 to 1"));
            assert!(rows.next().is_none());
        }
    }

    #[test]
    fn units_of_columns_that_a_table_lacks_are_ignored() {
        // A QTable of astropy with a TimeDelta in two columns, and a header with one column more.
        let header = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: RA, unit: hourangle, datatype: float64}\n";
        for (more, names, row) in [
            (
                "# - {name: dt.jd1, unit: d, datatype: float64}\n# - {name: dt.jd2, unit: d, datatype: float64}\n\
                 # meta: !!omap\n# - __serialized_columns__:\n#     dt: {__class__: astropy.time.core.TimeDelta, \
                 format: jd, unit: d, jd1: !astropy.table.SerializedColumn {name: dt.jd1}, \
                 jd2: !astropy.table.SerializedColumn {name: dt.jd2}}\n",
                "RA dt.jd1 dt.jd2",
                "1.5 0.0 0.1",
            ),
            ("# - {name: WIDTH, unit: pix, datatype: float64}\n", "RA", "1.5"),
        ] {
            let text = format!("{header}{more}{names}\n{row}\n");
            let mut rows = TableRows::new(text).unwrap().in_lower_case();
            let ra = rows.numbers(&["ra_deg", "ra"], &DEGREES, "").unwrap();
            assert_eq!(rows.next().unwrap().unwrap().number(ra), Some(22.5), "{names}");
        }
    }

    #[test]
    fn rows_have_their_lines() {
        let text = "# c\r\na,b\r\n1,2\r\n# d\r\n\r\n3,4\r\n\"5\r\n\",6\r\n7,8\r\n";
        for text in [text.to_owned(), text.replace("\r\n", "\n")] {
            let lines: Vec<u64> = TableRows::new(text.clone()).unwrap().map(|row| row.unwrap().line).collect();
            assert_eq!(lines, [3, 6, 7, 9], "{text:?}");
        }
    }

    #[test]
    fn two_columns_of_a_quantity_are_compared() {
        let text = "ra,ra_deg,dec_deg\n12h40m,190,0\n12.6666667,190.0,0\n-170,190.001,0\n,190,0\n10,190,0\n";
        let rows = TableRows::new(text.to_owned()).unwrap();
        let ra = rows.numbers(&["ra_deg", "ra"], &DEGREES, "").unwrap();
        let read: Vec<_> = rows.map(|row| row.unwrap().number_in(ra, [0.0, 360.0])).collect();
        assert_eq!(read[..4].iter().flatten().copied().collect::<Vec<_>>(), [190.0, 190.0, 190.001, 190.0]);
        let error = read[4].as_ref().unwrap_err().to_string();
        assert!(
            error.starts_with("line 6: ra_deg is 190 and ra is 10: they contradict each other; allowed"),
            "{error}"
        );
        let text = "exposure_s,exposure_min\n60,1\n60,5\n".to_owned();
        let rows = TableRows::new(text).unwrap();
        let exposure = rows.numbers(&["exposure_s"], &SECONDS, "").unwrap();
        let read: Vec<_> = rows.map(|row| row.unwrap().number_in(exposure, [0.0, 1e6]).ok()).collect();
        assert_eq!(read, [Some(60.0), None]);
        let mut rows = TableRows::new("# c\r\na,b\r\n1,2\r\n# d\r\n3\r\n".to_owned()).unwrap();
        let error = rows.nth(1).unwrap().unwrap_err().to_string();
        assert_eq!(error, "line 5: 1 cells, but 2 columns; allowed: one cell for each column");
        // The unit of a column that is only compared may be any.
        let header = "# %ECSV 1.0\n# ---\n# datatype:\n# - {name: ra, unit: 'h:m:s', datatype: string}\n\
            # - {name: ra_deg, unit: deg, datatype: float64}\n";
        let mut rows = TableRows::new(format!("{header}ra ra_deg\n12:40:00 190\n")).unwrap();
        let ra = rows.numbers(&["ra_deg", "ra"], &DEGREES, "").unwrap();
        assert_eq!(rows.next().unwrap().unwrap().number(ra), Some(190.0));
    }

    #[test]
    fn unclosed_quotation_marks_have_their_line_and_comments_like_rows_are_counted() {
        for (text, found) in [
            ("a,b\n1,\"x\"\n", Ok(0)),
            ("a,b\n1,\"x\ny\"\n", Ok(0)),
            ("a,b\n# it's a \"comment\n5\" tube,\"x \"\"y\"\"\"\n", Ok(0)),
            ("# c,d\na,b\n# it is, one\n#2,x\n1,y\n#3,z", Ok(3)),
            ("a,b\n1,\"x\n#2,y\"\n\"#3\",z\n# note\n#a,b,c\n", Ok(0)),
            ("a\n1\n# note\n", Ok(0)),
            ("a,b\n1,\"x\n2,y\n3,z\n", Err(2)),
            ("a,b\n1,x\n\"2,\"\"y\n3,z", Err(3)),
        ] {
            assert_eq!(comments_like_rows(text, b','), found, "{text:?}");
            let rows = TableRows::new(text.to_owned());
            match found {
                Ok(count) => assert_eq!(rows.unwrap().comments_like_rows, count),
                Err(line) => assert_eq!(rows.err().unwrap().to_string(), format!("line {line}: {UNCLOSED}")),
            }
        }
        let ecsv = "# %ECSV 1.0\n# ---\n# datatype: []\na b\n1 2\n#3 4\n# a longer note\n";
        assert_eq!(TableRows::new(ecsv.to_owned()).unwrap().comments_like_rows, 1);
    }

    #[test]
    fn tables_of_other_formats_and_repeated_names_are_errors() {
        let error = |text: &str| TableRows::new(text.to_owned()).err().unwrap().to_string();
        assert_eq!(error("<?xml version='1.0'?>\n<VOTABLE/>"), "is XML, such as a VOTable; allowed: CSV or ECSV");
        assert_eq!(error("a,b,a\n1,2,3\n"), "two columns have the name a; allowed: one");
        assert_eq!(error("# %ECSV 1.0\n# ---\n# datatype: []\na b a\n"), "two columns have the name a; allowed: one");
    }

    #[test]
    fn separators_are_found_in_the_line_of_names() {
        assert_eq!(["a,b,c", "a;b;c", "a\tb", "only"].map(delimiter_of), [b',', b';', b'\t', b',']);
    }
}
