//! Input files: only regular files of bounded size are read, so that no input blocks a run or exhausts the memory.

use std::collections::BTreeMap;
use std::fs::{self, File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use crate::units::{Unit, UnitError};

/// Largest number of bytes that are read from a file, or decompressed from one: 2 GB, above any catalogue or schedule.
/// Files are read into memory as a whole.
pub const LARGEST_INPUT: u64 = 2_000_000_000;

/// Opens a regular file, or an open stream of the process (see [`is_stream`]). Other code does not open input files
/// (`tests/imports.rs`).
///
/// # Errors
/// The file is a pipe, device, socket or directory, or the system reports an error.
pub fn open(path: &Path) -> io::Result<File> {
    if is_stream(path) {
        return File::open(path);
    }
    // The type is checked before, because opening a device can have an effect, and after, because another file can have
    // taken the name.
    check_regular(path)?;
    let mut options = File::options();
    // Opening does not wait for the writer of a pipe.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, rustix::fs::OFlags::NONBLOCK.bits() as i32);
    let file = options.read(true).open(path)?;
    check_kind(file.metadata()?.file_type())?;
    Ok(file)
}

/// Reads a file of at most [`LARGEST_INPUT`] bytes.
///
/// # Errors
/// The errors of [`open`], and a file that is too large.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    check_size(&file)?;
    read_at_most(file, LARGEST_INPUT)
}

/// Reads a text file in UTF-8 of at most [`LARGEST_INPUT`] bytes.
///
/// # Errors
/// The errors of [`read`], and invalid UTF-8, with its line.
pub fn read_to_string(path: &Path) -> io::Result<String> {
    text_of(read(path)?)
}

/// Returns the text of a file.
///
/// # Errors
/// Invalid UTF-8, with its line.
pub fn text_of(bytes: Vec<u8>) -> io::Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
        invalid(format!(
            "invalid UTF-8 in line {line} (byte {valid}); convert a Latin-1 file with iconv -f LATIN1 -t UTF-8"
        ))
    })
}

/// Largest number of rows of a table.
pub const MOST_ROWS: usize = 5_000_000;
/// Largest number of bytes of a row of a small table, such as a list of stars.
const LONGEST_ROW: usize = 10_000;

/// Rows of a small CSV or ECSV table with a line of names, read one by one. Lines that begin with `#` are comments, and
/// blanks around cells are ignored. Units are those of the header of ECSV, and of the names of the columns.
pub struct CsvRows {
    rows: csv::StringRecordsIntoIter<io::Cursor<String>>,
    names: Vec<String>,
    units: BTreeMap<String, String>,
    count: usize,
}

/// Column of numbers in a table.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct NumberColumn {
    index: usize,
    scale: f64,
}

impl NumberColumn {
    /// Returns the cell of a row; empty if it is missing.
    pub fn text(self, row: &csv::StringRecord) -> &str {
        row.get(self.index).unwrap_or_default()
    }

    /// Returns the number in a row, in the unit that the column was opened with; `None` if the cell is not a number.
    pub fn number(self, row: &csv::StringRecord) -> Option<f64> {
        self.text(row).parse::<f64>().ok().map(|number| number * self.scale)
    }
}

impl CsvRows {
    /// Opens a table and reads its names.
    ///
    /// # Errors
    /// The errors of [`read_to_string`], and text that is not CSV.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::of_text(read_to_string(path)?)
    }

    /// Reads the names of a table that is in memory.
    ///
    /// # Errors
    /// Text that is not CSV.
    pub fn of_text(text: String) -> io::Result<Self> {
        let header: Vec<&str> = text.lines().take_while(|line| line.starts_with('#')).collect();
        let units = ecsv_units(&header);
        // The default delimiter of ECSV is a blank.
        let is_ecsv = header.first().is_some_and(|line| line.starts_with("# %ECSV "));
        let has_commas = header.iter().any(|line| line.starts_with("# delimiter: ") && line.contains(','));
        let delimiter = if is_ecsv && !has_commas { b' ' } else { b',' };
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .delimiter(delimiter)
            .trim(csv::Trim::All)
            .from_reader(io::Cursor::new(text));
        let names = reader.headers().map_err(csv_error)?.iter().map(str::to_owned).collect();
        Ok(Self { rows: reader.into_records(), names, units, count: 0 })
    }

    /// Returns the names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the index of a column.
    ///
    /// # Errors
    /// The column is missing; the message names `allowed`.
    pub fn column(&self, name: &str, allowed: &str) -> io::Result<usize> {
        self.find(name).ok_or_else(|| missing(name, allowed))
    }

    /// Returns the index of a column; `None` if it is missing.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|found| found == name)
    }

    /// Returns a column of numbers, which are converted to `unit`; `None` if it is missing. It has one of the names in
    /// `accepted`, or such a name with another unit at its end.
    ///
    /// # Errors
    /// The unit is unknown or contradicts the name of the column, or several columns have the quantity.
    pub fn optional_numbers(&self, accepted: &[&str], unit: &Unit) -> io::Result<Option<NumberColumn>> {
        let failed = |error: UnitError| invalid(error.to_string());
        let Some(index) = unit.find(accepted, &self.names).map_err(failed)? else { return Ok(None) };
        let scale = unit.scale(&self.names[index], &self.units).map_err(failed)?;
        Ok(Some(NumberColumn { index, scale }))
    }

    /// Same as [`CsvRows::optional_numbers`], for a column that the table must have.
    ///
    /// # Errors
    /// The errors of [`CsvRows::optional_numbers`], and a missing column; the message names `allowed`.
    pub fn numbers(&self, accepted: &[&str], unit: &Unit, allowed: &str) -> io::Result<NumberColumn> {
        self.optional_numbers(accepted, unit)?.ok_or_else(|| missing(accepted[0], allowed))
    }
}

/// Returns the units in the header of an ECSV file, by column name; none for other comments.
fn ecsv_units(header: &[&str]) -> BTreeMap<String, String> {
    // An entry is one flow mapping, which may continue on the next lines: `- {name: ra, unit: deg, datatype: float64}`.
    let text: String = header.iter().map(|line| line.trim_start_matches('#').trim()).collect::<Vec<_>>().join(" ");
    let value = |entry: &str, key: &str| {
        let (_, rest) = entry.split_once(&format!("{key}: "))?;
        Some(rest.split([',', '}']).next()?.trim().trim_matches(['\'', '"']).to_owned())
    };
    let entries = text.split("- {name: ").skip(1).filter_map(|entry| {
        let entry = format!("name: {entry}");
        let entry = entry.split(", description: ").next()?.split('}').next()?;
        Some((value(entry, "name")?, value(entry, "unit")?))
    });
    if text.starts_with("%ECSV ") { entries.collect() } else { BTreeMap::new() }
}

impl Iterator for CsvRows {
    /// Line, from 1, and cells of a row.
    type Item = io::Result<(u64, csv::StringRecord)>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = match self.rows.next()? {
            Ok(row) => row,
            Err(error) => return Some(Err(csv_error(error))),
        };
        self.count += 1;
        let line = row.position().map_or(0, csv::Position::line);
        Some(if self.count > MOST_ROWS {
            Err(invalid(format!("more than {MOST_ROWS} rows; allowed: at most {MOST_ROWS}")))
        } else if row.as_slice().len() > LONGEST_ROW {
            Err(invalid(format!("line {line} is longer than {LONGEST_ROW} bytes; allowed: at most {LONGEST_ROW}")))
        } else {
            Ok((line, row))
        })
    }
}

fn invalid(what: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, what)
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

/// Reads all bytes of a reader, for example of a decoder, if they are at most `limit`.
///
/// # Errors
/// [`ErrorKind::FileTooLarge`] above the limit, and the errors of the reader.
pub fn read_at_most(reader: impl Read, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit { Err(too_large(limit)) } else { Ok(bytes) }
}

/// Checks the size of a regular file before any of it is read.
///
/// # Errors
/// More than [`LARGEST_INPUT`] bytes, or the system reports an error.
pub fn check_size(file: &File) -> io::Result<()> {
    if file.metadata()?.len() > LARGEST_INPUT { Err(too_large(LARGEST_INPUT)) } else { Ok(()) }
}

/// Returns true for the names of streams that the process has open: standard input, and the descriptors that shells
/// give as `<(command)`. Reading them can take as long as their writer takes.
pub fn is_stream(path: &Path) -> bool {
    path == Path::new("/dev/stdin") || path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd")
}

/// Checks that a path is a regular file, without opening it: opening a named pipe waits for its writer.
///
/// # Errors
/// A pipe, device, socket or directory, or the system reports an error.
pub fn check_regular(path: &Path) -> io::Result<()> {
    check_kind(fs::metadata(path)?.file_type())
}

fn check_kind(kind: FileType) -> io::Result<()> {
    if kind.is_file() {
        return Ok(());
    }
    let error = if kind.is_dir() { ErrorKind::IsADirectory } else { ErrorKind::InvalidInput };
    Err(io::Error::new(error, format!("is a {}; allowed: a file", kind_name(kind))))
}

#[cfg(unix)]
fn kind_name(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    if kind.is_dir() {
        "directory"
    } else if kind.is_fifo() {
        "named pipe"
    } else if kind.is_socket() {
        "socket"
    } else {
        "device"
    }
}

#[cfg(not(unix))]
fn kind_name(kind: FileType) -> &'static str {
    if kind.is_dir() { "directory" } else { "device" }
}

fn too_large(limit: u64) -> io::Error {
    io::Error::new(ErrorKind::FileTooLarge, format!("more than {limit} bytes; allowed: at most {limit}"))
}

/// Formats an error in a TOML text as one line with the line number.
pub fn toml_error(error: &toml::de::Error, text: &str) -> String {
    let what = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
    match error.span() {
        Some(span) => {
            let line = text.get(..span.start.min(text.len())).map_or(1, |before| before.matches('\n').count() + 1);
            format!("line {line}: {what}")
        }
        None => what,
    }
}

/// Returns the line of a key in a TOML text, from 1; `path` are the names of its tables and its own name, in which
/// hyphens and underscores are equivalent. `None` if the text lacks the key.
pub fn toml_line(text: &str, path: &[&str]) -> Option<usize> {
    let document = toml::de::DeTable::parse(text).ok()?;
    let (last, tables) = path.split_last()?;
    let find = |table: &toml::de::DeTable<'_>, name: &str| {
        table.iter().position(|(key, _)| key.get_ref().replace('-', "_") == name.replace('-', "_"))
    };
    let mut table = document.get_ref();
    for name in tables {
        table = table.iter().nth(find(table, name)?)?.1.get_ref().as_table()?;
    }
    let (key, _) = table.iter().nth(find(table, last)?)?;
    Some(text.get(..key.span().start)?.matches('\n').count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_their_lines() {
        let text = "lat = 3\n\n[plot.night]\nfov = '1deg'\ntime-zone = 'UTC'\n";
        let line = |path: &[&str]| toml_line(text, path);
        assert_eq!([line(&["lat"]), line(&["plot", "night", "time_zone"])], [Some(1), Some(5)]);
        assert_eq!([line(&["lon"]), line(&["lat", "x"])], [None, None]);
    }

    #[test]
    fn text_in_other_encodings_has_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        fs::write(&path, b"a,b\n1,2\nM\xfcnchen,3\n").unwrap();
        let error = read_to_string(&path).unwrap_err().to_string();
        assert!(error.starts_with("invalid UTF-8 in line 3 (byte 9); convert"), "{error}");
    }

    #[test]
    fn verif_endless_readers_are_cut_off() {
        assert_eq!(read_at_most(io::repeat(0).take(1000), 1000).unwrap().len(), 1000);
        let error = read_at_most(io::repeat(0), 1000).unwrap_err();
        assert_eq!(error.to_string(), "more than 1000 bytes; allowed: at most 1000");
    }
}
