//! CSV and ECSV: a header line, then one row for each exposure. In CSV, lines that begin with `#` are comments. In ECSV
//! they contain a YAML header with units and, for astropy's `Time` columns, the time scale.

use std::path::Path;

use hifitime::TimeScale;
use saphyr::{LoadableYamlNode, ScanError, YamlOwned};
use saphyr_parser::{Event, Parser};

use super::super::error::ScheduleError;
use super::columns::{ScheduleFormat, display};
use super::csv_text::{CsvText, cells};
use super::raw_table::{RawTable, Rows};
use crate::input::MOST_ROWS;

/// Deepest accepted nesting of an ECSV header. Astropy writes about five levels. The YAML loader is recursive and
/// overflows the stack after some thousands of levels.
const DEEPEST_HEADER: usize = 64;

/// Reads CSV text.
///
/// # Errors
/// There is no line of names, or there are too many rows.
pub(super) fn read_csv(path: &Path, text: String) -> Result<RawTable, ScheduleError> {
    let (names, rows) = CsvText::new(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::Csv, names);
    table.rows = Rows::Csv(rows);
    Ok(table)
}

const SIGNATURE: &str = "# %ECSV ";

/// Returns true if the text has the signature of ECSV.
pub(super) fn is_ecsv(text: &str) -> bool {
    text.starts_with(SIGNATURE)
}

/// Byte ranges of the header, the line of names and the rows of an ECSV file.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::schedule) struct EcsvLayout {
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
}

/// Finds the header, the line of names and the rows of ECSV text.
///
/// # Errors
/// The header is not YAML, the delimiter is neither comma nor blank, the line of names is missing, or a quoted cell
/// spans two lines.
pub(in crate::schedule) fn ecsv_layout(path: &Path, text: &str) -> Result<EcsvLayout, ScheduleError> {
    parse_ecsv(path, text).map(|(layout, _)| layout)
}

fn parse_ecsv(path: &Path, text: &str) -> Result<(EcsvLayout, Option<YamlOwned>), ScheduleError> {
    let error = |line: usize, what: String| ScheduleError::Line { path: display(path), line: line as u64, what };
    let mut lines: Vec<(usize, usize)> = Vec::new();
    if text.matches('\n').count() > MOST_ROWS {
        return Err(ScheduleError::TooManyRows { path: display(path), most: MOST_ROWS });
    }
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
    let names = record(&text[names_line.0..names_line.1], delimiter);
    let header_lines = header_lines.to_vec();
    Ok((EcsvLayout { delimiter, names, datatype_end, header_lines, names_line, rows }, header))
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

/// Reads ECSV text with commas or blanks as separators.
///
/// # Errors
/// Same as [`ecsv_layout`].
pub(super) fn read_ecsv(path: &Path, text: &str) -> Result<RawTable, ScheduleError> {
    let (layout, header) = parse_ecsv(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::Ecsv, layout.names);
    let width = table.names.len();
    let records = layout.rows.iter().map(|(start, end)| record(&text[*start..*end], layout.delimiter));
    table.rows = Rows::Cells(records.map(|record| cells(record.iter().map(String::as_str), width)).collect());
    if let Some(header) = &header {
        read_units(header, &mut table);
        read_time_columns(header, &mut table);
    }
    Ok(table)
}

/// Splits one line into cells.
fn record(line: &str, delimiter: u8) -> Vec<String> {
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

fn read_units(header: &YamlOwned, table: &mut RawTable) {
    let Some(YamlOwned::Sequence(columns)) = get(header, "datatype") else { return };
    for column in columns {
        let text = |key| get(column, key).and_then(YamlOwned::as_str).map(str::to_owned);
        if let (Some(name), Some(unit)) = (text("name"), text("unit")) {
            table.units.insert(name, unit);
        }
    }
}

/// Reads the format and scale of `Time` columns, which astropy writes into the metadata.
fn read_time_columns(header: &YamlOwned, table: &mut RawTable) {
    let Some(meta) = get(header, "meta") else { return };
    let Some(YamlOwned::Mapping(columns)) = get(meta, "__serialized_columns__") else { return };
    for (name, column) in columns {
        let text = |key| get(column, key).and_then(YamlOwned::as_str);
        let (Some(name), Some("astropy.time.core.Time")) = (name.as_str(), text("__class__")) else { continue };
        let mut name = name.to_owned();
        // The name `start` does not state whether times are MJD or JD; the format of the `Time` column does.
        if name == "start"
            && let Some(form @ ("mjd" | "jd")) = text("format")
            && let Some(found) = table.names.iter_mut().find(|found| *found == "start")
        {
            *found = format!("start_{form}");
            name = found.clone();
        }
        let scale = match text("scale") {
            Some("utc") => TimeScale::UTC,
            Some("tai") => TimeScale::TAI,
            Some("tt") => TimeScale::TT,
            Some("tdb") => TimeScale::TDB,
            _ => continue,
        };
        table.time_scales.insert(name, scale);
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
fn blank_record(line: &str) -> Vec<String> {
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

#[cfg(test)]
mod tests {
    use super::super::columns::Cell;
    use super::*;

    /// QTable with a Time column, written by astropy 8.0.2: folded description, ordered map, tags and anchors.
    const ASTROPY: &str = "# %ECSV 1.0
# ---
# datatype:
# - {name: exposure_id, datatype: string}
# - {name: duration_s, unit: s, datatype: float64, description: 'exposure time of the visit, which is a long description that the yaml
#     dumper folds somewhere'}
# - {name: ra_deg, unit: deg, datatype: float64}
# - {name: start, datatype: float64}
# meta: !!omap
# - comments: ['hello: x']
# - __serialized_columns__:
#     ra_deg:
#       __class__: astropy.units.quantity.Quantity
#       unit: &id001 !astropy.units.Unit {unit: deg}
#       value: !astropy.table.SerializedColumn {name: ra_deg}
#     start:
#       __class__: astropy.time.core.Time
#       format: mjd
#       in_subfmt: '*'
#       scale: tai
#       value: !astropy.table.SerializedColumn {name: start}
# schema: astropy-2.0
exposure_id duration_s ra_deg start
a 30.0 1.5 60536.02083
\"b \"\"c\"\"\"   nan \"\" 60536.03
";

    #[test]
    fn units_and_time_scale_come_from_the_header_of_astropy() {
        let table = read_ecsv(Path::new("t.ecsv"), ASTROPY).unwrap();
        assert_eq!(table.names, ["exposure_id", "duration_s", "ra_deg", "start_mjd"]);
        assert_eq!(table.units.get("ra_deg").map(String::as_str), Some("deg"));
        assert_eq!(table.units.get("duration_s").map(String::as_str), Some("s"));
        assert_eq!(table.time_scales.get("start_mjd"), Some(&TimeScale::TAI));
        let second = table.rows.iter().nth(1).unwrap().into_owned().unwrap();
        assert_eq!(second[0], Cell::Text("b \"c\"".to_owned()));
        assert_eq!(second[2], Cell::Missing);
    }

    #[test]
    fn commas_separate_cells_if_the_header_sets_them() {
        let text =
            "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - {name: a, datatype: string}\na,b\n\"x, y\",2\n";
        let table = read_ecsv(Path::new("t.ecsv"), text).unwrap();
        assert_eq!(table.names, ["a", "b"]);
        assert_eq!(table.rows.iter().next().unwrap().into_owned().unwrap()[0], Cell::Text("x, y".to_owned()));
    }

    #[test]
    fn an_invalid_yaml_header_is_an_error_with_its_line() {
        let message =
            read_ecsv(Path::new("t.ecsv"), "# %ECSV 1.0\n# ---\n# datatype: [\na,b\n").unwrap_err().to_string();
        assert!(message.starts_with("schedule t.ecsv, line "), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
}
