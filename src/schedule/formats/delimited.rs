//! CSV: a header line, then one row an exposure. Lines that begin with `#` are comments.

use std::path::Path;

use super::super::error::ScheduleError;
use super::raw::{Cell, RawTable};
use super::sniff::{ScheduleFormat, display};

/// Where the header and the rows stand in the bytes of a CSV file.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct CsvLayout {
    /// What stands between cells.
    pub delimiter: u8,
    /// The columns' names.
    pub names: Vec<String>,
    /// Where the header record ends, its line end not counted.
    pub header_end: usize,
    /// Where each row ends, its line end not counted.
    pub row_ends: Vec<usize>,
    /// The cells of each row.
    pub rows: Vec<Vec<String>>,
    /// The line each row begins on, from 1.
    pub lines: Vec<u64>,
}

/// Finds header and rows. The byte places count from the beginning of `text`.
///
/// # Errors
/// No header line.
pub(in crate::schedule) fn csv_layout(path: &Path, text: &str) -> Result<CsvLayout, ScheduleError> {
    let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let Some(header) = header else { return Err(ScheduleError::Empty { path: display(path) }) };
    let delimiter = delimiter_of(header);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let mut layout = CsvLayout {
        delimiter,
        names: Vec::new(),
        header_end: 0,
        row_ends: Vec::new(),
        rows: Vec::new(),
        lines: Vec::new(),
    };
    let mut record = csv::StringRecord::new();
    loop {
        let line = reader.position().line();
        let more = reader.read_record(&mut record).map_err(|error| ScheduleError::Line {
            path: display(path),
            line,
            what: error.to_string(),
        })?;
        if !more {
            break;
        }
        // The reader may stop between \r and \n; the record itself ends before either.
        let end = text[..reader.position().byte() as usize].trim_end_matches(['\r', '\n']).len();
        if layout.names.is_empty() {
            layout.names = record.iter().map(|name| name.trim().to_owned()).collect();
            layout.header_end = end;
        } else {
            layout.row_ends.push(end);
            layout.rows.push(record.iter().map(str::to_owned).collect());
            layout.lines.push(record.position().map_or(line, csv::Position::line));
        }
    }
    Ok(layout)
}

/// The separator that the header shows most often; a comma where it shows none.
fn delimiter_of(header: &str) -> u8 {
    let count = |delimiter: u8| header.bytes().filter(|byte| *byte == delimiter).count();
    [b',', b';', b'\t'].into_iter().rev().max_by_key(|delimiter| count(*delimiter)).unwrap_or(b',')
}

/// Reads CSV text.
///
/// # Errors
/// No header or no rows.
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, ScheduleError> {
    let layout = csv_layout(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::Csv, layout.names);
    let width = table.names.len();
    table.rows = layout.rows.iter().map(|row| cells(row.iter().map(String::as_str), width)).collect();
    Ok(table)
}

/// The cells of one row, or why they cannot be told apart.
pub(super) fn cells<'a>(texts: impl Iterator<Item = &'a str>, width: usize) -> Result<Vec<Cell>, String> {
    let cells: Vec<Cell> = texts.map(Cell::from_text).collect();
    if cells.len() == width { Ok(cells) } else { Err(format!("the row has {} cells, the header {width}", cells.len())) }
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
        let ends: Vec<&str> = layout.row_ends.iter().map(|&end| &text[end - 2..end]).collect();
        assert_eq!(ends, ["y\"", ",z", ",w"]);
        assert_eq!(layout.rows[0], ["1", "x\r\ny"]);
    }

    #[test]
    fn the_separator_is_found_in_the_header() {
        assert_eq!(delimiter_of("a,b,c"), b',');
        assert_eq!(delimiter_of("a;b;c"), b';');
        assert_eq!(delimiter_of("a\tb"), b'\t');
        assert_eq!(delimiter_of("only"), b',');
    }
}
