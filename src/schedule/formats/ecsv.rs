//! ECSV: CSV below a YAML header that names units and, for astropy's `Time` columns, the time scale.

use std::path::Path;

use hifitime::TimeScale;
use saphyr::{LoadableYamlNode, YamlOwned};

use super::super::error::ScheduleError;
use super::delimited::cells;
use super::raw::RawTable;
use super::sniff::{ScheduleFormat, display};

const SIGNATURE: &str = "# %ECSV ";

/// True where the text says of itself that it is ECSV.
pub(super) fn is_ecsv(text: &str) -> bool {
    text.starts_with(SIGNATURE)
}

/// Reads ECSV text, separated by commas or blanks.
///
/// # Errors
/// A header that is not YAML, another delimiter, or no line of names.
pub(super) fn read(path: &Path, text: &str) -> Result<RawTable, ScheduleError> {
    let error = |line: usize, what: String| ScheduleError::Line { path: display(path), line: line as u64, what };
    let header_lines = text.lines().take_while(|line| line.starts_with('#')).count();
    let yaml: Vec<&str> = text.lines().skip(1).take(header_lines.saturating_sub(1)).map(uncommented).collect();
    let documents = YamlOwned::load_from_str(&yaml.join("\n"))
        .map_err(|problem| error(problem.marker().line() + 1, format!("the ECSV header is not YAML: {problem}")))?;
    let header = documents.first();
    let delimiter = header.and_then(|header| get(header, "delimiter")).and_then(YamlOwned::as_str).unwrap_or(" ");
    let comma = match delimiter {
        "," => true,
        " " => false,
        other => return Err(error(2, format!("ECSV delimiter '{other}'; allowed: comma and blank"))),
    };
    let mut records = text
        .lines()
        .skip(header_lines)
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'))
        .map(|line| if comma { comma_record(line) } else { blank_record(line) });
    let names = records.next().ok_or_else(|| error(header_lines, "no line of column names below the header".into()))?;
    let mut table = RawTable::new(ScheduleFormat::Ecsv, names);
    let width = table.names.len();
    table.rows = records.map(|record| cells(record.iter().map(String::as_str), width)).collect();
    if let Some(header) = header {
        read_units(header, &mut table);
        read_time_columns(header, &mut table);
    }
    Ok(table)
}

fn uncommented(line: &str) -> &str {
    let line = line.strip_prefix('#').unwrap_or(line);
    line.strip_prefix(' ').unwrap_or(line)
}

/// A member of a map, or of an ordered map (a list of maps with one key each), as astropy writes `meta`.
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

/// astropy writes a `Time` column under its plain name and says form and scale in the metadata.
fn read_time_columns(header: &YamlOwned, table: &mut RawTable) {
    let Some(meta) = get(header, "meta") else { return };
    let Some(YamlOwned::Mapping(columns)) = get(meta, "__serialized_columns__") else { return };
    for (name, column) in columns {
        let text = |key| get(column, key).and_then(YamlOwned::as_str);
        let (Some(name), Some("astropy.time.core.Time")) = (name.as_str(), text("__class__")) else { continue };
        let mut name = name.to_owned();
        // `start` says nothing about its form: its format does.
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

/// Cells between blanks, any number of them; a quoted cell may hold blanks, be empty, and doubles its own quotes.
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
    use super::super::raw::Cell;
    use super::*;

    /// As astropy 8.0.2 writes a QTable with a Time column (folded description, ordered map, tags and anchors included).
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
    fn astropys_header_gives_units_and_time_scale() {
        let table = read(Path::new("t.ecsv"), ASTROPY).unwrap();
        assert_eq!(table.names, ["exposure_id", "duration_s", "ra_deg", "start_mjd"]);
        assert_eq!(table.units.get("ra_deg").map(String::as_str), Some("deg"));
        assert_eq!(table.units.get("duration_s").map(String::as_str), Some("s"));
        assert_eq!(table.time_scales.get("start_mjd"), Some(&TimeScale::TAI));
        let second = table.rows[1].as_ref().unwrap();
        assert_eq!(second[0], Cell::Text("b \"c\"".to_owned()));
        assert_eq!(second[2], Cell::Missing);
    }

    #[test]
    fn commas_where_the_header_says_so() {
        let text =
            "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n# - {name: a, datatype: string}\na,b\n\"x, y\",2\n";
        let table = read(Path::new("t.ecsv"), text).unwrap();
        assert_eq!(table.names, ["a", "b"]);
        assert_eq!(table.rows[0].as_ref().unwrap()[0], Cell::Text("x, y".to_owned()));
    }

    #[test]
    fn a_header_that_is_no_yaml_is_an_error_with_its_line() {
        let message = read(Path::new("t.ecsv"), "# %ECSV 1.0\n# ---\n# datatype: [\na,b\n").unwrap_err().to_string();
        assert!(message.starts_with("schedule t.ecsv, line "), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
}
