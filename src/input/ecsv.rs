//! ECSV: a YAML header in comments, with units and, for astropy's `Time` columns, the time scale; a line of names;
//! rows.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use hifitime::TimeScale;
use saphyr::{LoadableYamlNode, ScanError, YamlOwned};
use saphyr_parser::{Event, Parser};

use crate::message::Quoted;

/// Deepest accepted nesting of an ECSV header. Astropy writes about five levels. The YAML loader is recursive and
/// overflows the stack after some thousands of levels.
const DEEPEST_HEADER: usize = 64;

const SIGNATURE: &str = "# %ECSV ";

/// Returns true if the text has the signature of ECSV.
pub fn is_ecsv(text: &str) -> bool {
    text.starts_with(SIGNATURE)
}

/// Error in a line of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct LineError {
    /// Line, from 1.
    pub line: u64,
    /// Problem, and what is allowed.
    pub what: String,
}

impl LineError {
    pub(super) fn new(line: u64, what: String) -> Self {
        Self { line, what }
    }
}

impl fmt::Display for LineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.what)
    }
}

/// Column of astropy's `Time`.
pub struct TimeColumn<'a> {
    /// Name of the column.
    pub name: &'a str,
    /// Format, such as `mjd`.
    pub format: Option<&'a str>,
    /// Time scale, if it is one of UTC, TAI, TT and TDB.
    pub scale: Option<TimeScale>,
    /// Time scale as text, such as `tai`.
    pub scale_name: Option<&'a str>,
}

impl<'a> TimeColumn<'a> {
    /// Returns the column that an entry of the metadata describes; `None` if it is of another type.
    fn from_metadata(name: &'a str, column: &'a YamlOwned) -> Option<Self> {
        let text = |key| get(column, key).and_then(YamlOwned::as_str);
        let scale = match text("scale") {
            Some("utc") => Some(TimeScale::UTC),
            Some("tai") => Some(TimeScale::TAI),
            Some("tt") => Some(TimeScale::TT),
            Some("tdb") => Some(TimeScale::TDB),
            _ => None,
        };
        let is_time = text("__class__") == Some("astropy.time.core.Time");
        is_time.then(|| Self { name, format: text("format"), scale, scale_name: text("scale") })
    }
}

/// Byte ranges of the header, the line of names and the rows of an ECSV file, and its parsed header.
#[derive(Clone, Debug, PartialEq)]
pub struct Ecsv {
    /// Separator of cells: a comma or a blank.
    pub delimiter: u8,
    /// Column names.
    pub names: Vec<String>,
    /// End of the list `datatype` of the header, where entries for new columns are inserted.
    pub datatype_end: usize,
    /// Lines of the header, including line breaks.
    pub header_lines: Vec<(usize, usize)>,
    /// Line of names, without the line break.
    pub names_line: (usize, usize),
    /// Rows, without line breaks.
    pub rows: Vec<(usize, usize)>,
    /// Number of comments below the line of names that have as many cells as it.
    pub comments_like_rows: usize,
    header: Option<YamlOwned>,
}

impl Ecsv {
    /// Finds the header, the line of names and the rows of ECSV text.
    ///
    /// # Errors
    /// The header is not YAML, the delimiter is neither comma nor blank, the line of names is missing, or a quoted cell
    /// spans two lines.
    pub fn parse(text: &str) -> Result<Self, LineError> {
        let error = |line: usize, what: String| LineError::new(line as u64, what);
        let mut lines: Vec<(usize, usize)> = Vec::new();
        for line in text.split_inclusive('\n') {
            let start = lines.last().map_or(0, |(_, end)| *end);
            lines.push((start, start + line.len()));
        }
        let of = |(start, end): (usize, usize)| text[start..end].trim_end_matches(['\r', '\n']);
        let header_count = lines.iter().take_while(|line| of(**line).starts_with('#')).count();
        let (header_lines, body) = lines.split_at(header_count);
        let yaml: Vec<&str> = header_lines.iter().skip(1).map(|line| uncommented(of(*line))).collect();
        let yaml = yaml.join("\n");
        let not_yaml =
            |problem: ScanError| error(problem.marker().line() + 1, format!("the ECSV header is not YAML: {problem}"));
        if let Some(line) = line_too_deep(&yaml).map_err(not_yaml)? {
            let what = format!("the ECSV header is nested too deeply; allowed: {DEEPEST_HEADER} levels");
            return Err(error(line + 1, what));
        }
        let documents = YamlOwned::load_from_str(&yaml).map_err(not_yaml)?;
        let header = documents.into_iter().next();
        let delimiter = header.as_ref().and_then(|header| get(header, "delimiter")).and_then(YamlOwned::as_str);
        let delimiter = match delimiter.unwrap_or(" ") {
            "," => b',',
            " " => b' ',
            other => return Err(error(2, format!("invalid ECSV delimiter '{other}'; allowed: comma and blank"))),
        };
        // The list ends at the next key that is not indented, or at the end of the header.
        let in_list = |line: &&(usize, usize)| uncommented(of(**line)).starts_with([' ', '-']);
        let list = header_lines.iter().position(|line| uncommented(of(*line)).trim_end() == "datatype:");
        let list_lines = list.map_or(0, |list| list + 1 + header_lines[list + 1..].iter().take_while(in_list).count());
        let datatype_end = list_lines.checked_sub(1).map_or(0, |last| header_lines[last].1);
        let mut records = body
            .iter()
            .enumerate()
            .filter(|(_, line)| !of(**line).trim().is_empty() && !of(**line).starts_with('#'))
            .map(|(number, line)| (number, (line.0, line.0 + of(*line).len())));
        let no_names = || error(header_count, "missing line of column names below the ECSV header".into());
        let (_, names_line) = records.next().ok_or_else(no_names)?;
        let mut rows = Vec::new();
        for (number, row) in records {
            if !text[row.0..row.1].matches('"').count().is_multiple_of(2) {
                return Err(error(
                    header_count + number + 1,
                    "a quoted cell continues on the next line, which is not supported in ECSV".into(),
                ));
            }
            rows.push(row);
        }
        let names = split(&text[names_line.0..names_line.1], delimiter);
        let is_like_a_row = |line: &&(usize, usize)| {
            let line = of(**line);
            line.starts_with('#') && names.len() > 1 && split(line, delimiter).len() == names.len()
        };
        let comments_like_rows = body.iter().filter(|line| line.0 > names_line.0).filter(is_like_a_row).count();
        let header_lines = header_lines.to_vec();
        Ok(Self { delimiter, names, datatype_end, header_lines, names_line, rows, comments_like_rows, header })
    }

    /// Splits a row into cells.
    pub fn record(&self, line: &str) -> Vec<String> {
        split(line, self.delimiter)
    }

    /// Returns the units in the header, by column name. Columns of astropy's `TimeDelta` are in days, or in seconds
    /// with the format `sec`.
    pub fn units(&self) -> BTreeMap<String, String> {
        let columns = self.header.as_ref().and_then(|header| get(header, "datatype"));
        let Some(YamlOwned::Sequence(columns)) = columns else { return BTreeMap::new() };
        let text = |column, key| get(column, key).and_then(YamlOwned::as_str).map(str::to_owned);
        let stated = columns.iter().filter_map(|column| Some((text(column, "name")?, text(column, "unit")?)));
        let intervals = self.serialized_columns().filter_map(|(name, column)| {
            let text = |key| get(column, key).and_then(YamlOwned::as_str);
            let unit = if text("format") == Some("sec") { "s" } else { "d" };
            (text("__class__") == Some("astropy.time.core.TimeDelta")).then(|| (name.to_owned(), unit.to_owned()))
        });
        stated.chain(intervals).collect()
    }

    /// Returns the names of the columns with numbers of single (or half) precision.
    pub fn single_precision(&self) -> BTreeSet<String> {
        let columns = self.header.as_ref().and_then(|header| get(header, "datatype"));
        let Some(YamlOwned::Sequence(columns)) = columns else { return BTreeSet::new() };
        let single = |column: &YamlOwned| -> Option<String> {
            let is_single = matches!(get(column, "datatype")?.as_str()?, "float32" | "float16");
            is_single.then(|| get(column, "name")?.as_str().map(str::to_owned)).flatten()
        };
        columns.iter().filter_map(single).collect()
    }

    /// Returns the `Time` columns, which astropy describes in the metadata.
    pub fn time_columns(&self) -> Vec<TimeColumn<'_>> {
        self.serialized_columns().filter_map(|(name, column)| TimeColumn::from_metadata(name, column)).collect()
    }

    /// Returns the columns that astropy describes in the metadata, with their names.
    fn serialized_columns(&self) -> impl Iterator<Item = (&str, &YamlOwned)> {
        let meta = self.header.as_ref().and_then(|header| get(header, "meta"));
        let columns = meta.and_then(|meta| get(meta, "__serialized_columns__"));
        let columns = columns.and_then(|columns| if let YamlOwned::Mapping(map) = columns { Some(map) } else { None });
        columns.into_iter().flatten().filter_map(|(name, column)| Some((name.as_str()?, column)))
    }

    /// Checks that no column of astropy's `Time` with a name that ends with `_utc` is in another time scale.
    ///
    /// # Errors
    /// A sentence that names the column and its time scale.
    pub fn check_utc(&self) -> Result<(), String> {
        let is_other = |time: &&TimeColumn<'_>| {
            time.name.to_ascii_lowercase().ends_with("_utc") && time.scale_name.is_some_and(|scale| scale != "utc")
        };
        match self.time_columns().iter().find(is_other) {
            Some(TimeColumn { name, scale_name, .. }) => Err(format!(
                "column {} is in the time scale {}; allowed: utc, as its name says",
                Quoted::new(name),
                Quoted::new(scale_name.unwrap_or_default())
            )),
            None => Ok(()),
        }
    }
}

/// Returns the line of the YAML text, from 1, in which the nesting exceeds the limit. The event parser used here is not
/// recursive.
fn line_too_deep(yaml: &str) -> Result<Option<usize>, ScanError> {
    let mut depth = 0_usize;
    for event in Parser::new_from_str(yaml) {
        let (event, span) = event?;
        match event {
            Event::SequenceStart(..) | Event::MappingStart(..) => depth += 1,
            Event::SequenceEnd | Event::MappingEnd => depth -= 1,
            _ => {}
        }
        if depth > DEEPEST_HEADER {
            return Ok(Some(span.start.line()));
        }
    }
    Ok(None)
}

/// Splits one line into cells.
fn split(line: &str, delimiter: u8) -> Vec<String> {
    if delimiter == b',' { comma_record(line) } else { blank_record(line) }
}

fn uncommented(line: &str) -> &str {
    let line = line.strip_prefix('#').unwrap_or(line);
    line.strip_prefix(' ').unwrap_or(line)
}

/// Returns a member of a map, or of an ordered map (a list of maps with one key each), as written by astropy for
/// `meta`.
fn get<'a>(node: &'a YamlOwned, key: &str) -> Option<&'a YamlOwned> {
    match node {
        YamlOwned::Tagged(_, inner) => get(inner, key),
        YamlOwned::Sequence(items) => items.iter().find_map(|item| get(item, key)),
        YamlOwned::Mapping(map) => map.iter().find(|(name, _)| name.as_str() == Some(key)).map(|(_, value)| value),
        _ => None,
    }
}

fn comma_record(line: &str) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(line.as_bytes());
    match reader.records().next() {
        Some(Ok(record)) => record.iter().map(|cell| cell.trim().to_owned()).collect(),
        _ => Vec::new(),
    }
}

/// Splits at one or more blanks. A quoted cell may contain blanks or be empty; quotes in it are doubled.
pub fn blank_record(line: &str) -> Vec<String> {
    let mut cells = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() {
        if let Some(quoted) = rest.strip_prefix('"') {
            let mut cell = String::new();
            let mut characters = quoted.char_indices().peekable();
            let mut end = quoted.len();
            while let Some((at, character)) = characters.next() {
                if character != '"' {
                    cell.push(character);
                } else if characters.next_if(|(_, next)| *next == '"').is_some() {
                    cell.push('"');
                } else {
                    end = at + 1;
                    break;
                }
            }
            cells.push(cell);
            rest = quoted[end..].trim_start();
        } else {
            let end = rest.find(char::is_whitespace).unwrap_or(rest.len());
            cells.push(rest[..end].to_owned());
            rest = rest[end..].trim_start();
        }
    }
    cells
}
