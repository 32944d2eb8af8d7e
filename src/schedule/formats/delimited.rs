//! CSV and ECSV: a header line, then one row for each exposure. In CSV, lines that begin with `#` are comments. In ECSV
//! they contain a YAML header with units and, for astropy's `Time` columns, the time scale.

use std::path::Path;

use super::super::error;
use super::columns::ScheduleFormat;
use super::csv_text::{CsvText, cells};
use super::raw_table::{RawTable, Rows};
use crate::error::Error;
use crate::input::{Ecsv, MOST_ROWS};

/// Reads CSV text.
///
/// # Errors
/// There is no line of names, or there are too many rows.
pub(super) fn read_csv(path: &Path, text: String) -> Result<RawTable, Error> {
    let (names, rows) = CsvText::new(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::Csv, names);
    table.comments_like_rows = rows.comments_like_rows;
    table.rows = Rows::Csv(rows);
    Ok(table)
}

/// Finds the header, the line of names and the rows of ECSV text.
///
/// # Errors
/// The errors of [`Ecsv::parse`], and too many rows.
pub(in crate::schedule) fn ecsv_layout(path: &Path, text: &str) -> Result<Ecsv, Error> {
    if text.matches('\n').count() > MOST_ROWS {
        return Err(error::too_many_rows(path, MOST_ROWS));
    }
    Ecsv::parse(text).map_err(|error| Error::format(error.what).in_line("schedule", path, error.line as usize))
}

/// Reads ECSV text with commas or blanks as separators.
///
/// # Errors
/// Same as [`ecsv_layout`].
pub(super) fn read_ecsv(path: &Path, text: &str) -> Result<RawTable, Error> {
    let ecsv = ecsv_layout(path, text)?;
    let mut table = RawTable::new(ScheduleFormat::Ecsv, ecsv.names.clone());
    let width = table.names.len();
    let records = ecsv.rows.iter().map(|(start, end)| ecsv.record(&text[*start..*end]));
    table.rows = Rows::Cells(records.map(|record| cells(record.iter().map(String::as_str), width)).collect());
    table.comments_like_rows = ecsv.comments_like_rows;
    table.units = ecsv.units();
    table.single_precision = ecsv.single_precision();
    for time in ecsv.time_columns() {
        let mut name = time.name.to_owned();
        // The name `start` does not state whether times are MJD or JD; the format of the `Time` column does.
        if name == "start"
            && let Some(form @ ("mjd" | "jd")) = time.format
            && let Some(found) = table.names.iter_mut().find(|found| *found == "start")
        {
            *found = format!("start_{form}");
            name = found.clone();
        }
        if let Some(scale) = time.scale {
            table.time_scales.insert(name, scale);
        }
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::super::columns::Cell;
    use super::*;
    use hifitime::TimeScale;

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
