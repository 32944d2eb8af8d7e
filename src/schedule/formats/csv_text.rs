//! CSV: a line of names, then one row for each exposure. Lines that begin with `#` are comments.

use std::path::Path;

use super::super::error;
use super::columns::{Cell, ScheduleRow};
use crate::error::Error;
use crate::input::{MOST_ROWS, UNCLOSED, comments_like_rows, delimiter_of, first_line};

/// Byte positions of the header and the rows of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct CsvLayout {
    /// Separator of cells.
    pub delimiter: u8,
    /// Column names.
    pub names: Vec<String>,
    /// End of the line of names, without the line break.
    pub header_end: usize,
    /// End of each row, without the line break, and its number of cells.
    pub rows: Vec<(usize, usize)>,
}

/// Finds the line of names and the rows of CSV text.
///
/// # Errors
/// There is no line of names.
pub(in crate::schedule) fn csv_layout(path: &Path, text: &str) -> Result<CsvLayout, Error> {
    let mut rows = Vec::new();
    let (header, header_end) = visit(path, text, |record, end| rows.push((end, record.len())))?;
    Ok(CsvLayout { delimiter: delimiter_of(first_line(text)), names: names_of(&header), header_end, rows })
}

/// Calls `row` with the cells of each row and the end of its text. Returns the record of the names with its end.
fn visit(
    path: &Path,
    text: &str,
    mut row: impl FnMut(&csv::StringRecord, usize),
) -> Result<(csv::StringRecord, usize), Error> {
    if first_line(text).is_empty() {
        return Err(error::empty(path));
    }
    let mut reader = reader(text);
    let (mut header, mut record) = (None, csv::StringRecord::new());
    loop {
        let line = reader.position().line();
        let more = reader
            .read_record(&mut record)
            .map_err(|error| Error::format(error.to_string()).in_line("schedule", path, line as usize))?;
        if !more {
            break;
        }
        // The reader may stop between \r and \n; the record ends before both.
        let end = text[..reader.position().byte() as usize].trim_end_matches(['\r', '\n']).len();
        match header {
            None => header = Some((record.clone(), end)),
            Some(_) => row(&record, end),
        }
    }
    header.ok_or_else(|| error::empty(path))
}

fn reader(text: &str) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter_of(first_line(text)))
        .comment(Some(b'#'))
        .from_reader(text.as_bytes())
}

fn names_of(header: &csv::StringRecord) -> Vec<String> {
    header.iter().map(|name| name.trim().to_owned()).collect()
}

/// Text of a CSV file whose rows were counted.
#[derive(Clone, Debug)]
pub(in crate::schedule) struct CsvText {
    text: String,
    /// Number of columns.
    width: usize,
    /// Number of rows.
    pub rows: usize,
    /// Number of comments after the line of names that have as many cells as it.
    pub comments_like_rows: usize,
}

impl CsvText {
    /// Finds the column names and the rows of a text. Returns the names.
    ///
    /// # Errors
    /// There is no line of names, or there are too many rows.
    pub fn new(path: &Path, text: String) -> Result<(Vec<String>, Self), Error> {
        let mut rows = 0;
        let (header, _) = visit(path, &text, |_, _| rows += 1)?;
        if rows > MOST_ROWS {
            return Err(error::too_many_rows(path, MOST_ROWS));
        }
        let width = header.len();
        let comments_like_rows = comments_like_rows(&text, delimiter_of(first_line(&text)))
            .map_err(|line| Error::format(UNCLOSED).in_line("schedule", path, line))?;
        Ok((names_of(&header), Self { text, width, rows, comments_like_rows }))
    }

    /// Returns the rows in order.
    pub fn rows(&self) -> impl Iterator<Item = ScheduleRow> {
        // The text is UTF-8 and was read once, so that there are no errors.
        let records = reader(&self.text).into_records().skip(1).map_while(Result::ok);
        records.map(|record| cells(record.iter(), self.width))
    }
}

/// Returns the cells of one row, or the reason why it is invalid.
pub(super) fn cells<'a>(texts: impl Iterator<Item = &'a str>, width: usize) -> ScheduleRow {
    let cells: Vec<Cell> = texts.map(Cell::from_text).collect();
    if cells.len() == width {
        Ok(cells)
    } else {
        Err(format!("the row has {} cells but the header has {width}", cells.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_end_where_their_bytes_end() {
        let text = "# note\r\na,b\r\n1,\"x\r\ny\"\r\n\r\n# between\r\n2,z\n3,w";
        let layout = csv_layout(Path::new("t.csv"), text).unwrap();
        assert_eq!(layout.names, ["a", "b"]);
        assert!(text[..layout.header_end].ends_with("a,b"));
        let ends: Vec<&str> = layout.rows.iter().map(|&(end, _)| &text[end - 2..end]).collect();
        assert_eq!(ends, ["y\"", ",z", ",w"]);
        assert!(layout.rows.iter().all(|(_, cells)| *cells == 2));
        let (_, read) = CsvText::new(Path::new("t.csv"), text.to_owned()).unwrap();
        let rows: Vec<ScheduleRow> = read.rows().collect();
        let row = |cells: [&str; 2]| Ok(cells.map(|cell| Cell::Text(cell.to_owned())).to_vec());
        assert_eq!(rows, [row(["1", "x\r\ny"]), row(["2", "z"]), row(["3", "w"])]);
    }
}
