//! Rubin opsim databases: SQLite files with a table `observations`.

use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, ErrorCode, OpenFlags};

use super::super::error;
use super::columns::{Cell, ColumnMap, ScheduleFormat};
use super::raw_table::RawTable;
use crate::error::Error;
use crate::input::MOST_ROWS;

/// Largest total length of text, bytes: 100 bytes for each of the largest number of rows. Rubin's ten-year simulations
/// have 2.1 million rows. The limits stop views that return rows endlessly.
const MOST_TEXT: u64 = 500_000_000;
/// Largest number of instructions of SQLite's virtual machine: 20 times those for the largest number of rows, about 10
/// s. The limit stops views that compute endlessly without returning a row.
const MOST_INSTRUCTIONS: i32 = 1_000_000_000;

/// Opens a database read-only.
///
/// # Errors
/// SQLite reports an error.
pub(in crate::schedule) fn open_read_only(path: &Path) -> Result<Connection, Error> {
    Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX)
        .map_err(|source| error::sqlite(path, source))
}

/// Reads the columns of `observations` that a schedule needs, in row order.
///
/// # Errors
/// There is no table `observations`, columns are missing, a limit is exceeded, or SQLite reports an error.
pub(super) fn read(path: &Path) -> Result<RawTable, Error> {
    read_bounded(path, MOST_ROWS, MOST_INSTRUCTIONS)
}

fn read_bounded(path: &Path, most_rows: usize, most_instructions: i32) -> Result<RawTable, Error> {
    let sqlite = |source| error::sqlite(path, source);
    let without_end = |what: String| error::format(path, what);
    let mut connection = open_read_only(path)?;
    connection.progress_handler(most_instructions, Some(|| true)).map_err(sqlite)?;
    let names = column_names(&connection).map_err(sqlite)?;
    if names.is_empty() {
        let what =
            format!("SQLite without a table 'observations'; found tables: {}", tables(&connection).map_err(sqlite)?);
        return Err(error::format(path, what));
    }
    let map = ColumnMap::find(path, &names)?;
    let needed: Vec<usize> = [map.start.index, map.duration, map.right_ascension, map.declination]
        .into_iter()
        .chain(map.id)
        .chain(map.rotation)
        .chain(map.band)
        .chain(map.snaps)
        .chain(map.visit)
        .chain(map.altitude)
        .collect();
    let mut table = RawTable::new(ScheduleFormat::Opsim, needed.iter().map(|&index| names[index].clone()).collect());
    let quoted: Vec<String> = table.names.iter().map(|name| format!("\"{}\"", name.replace('"', "\"\""))).collect();
    let query = format!("SELECT {} FROM observations", quoted.join(", "));
    let mut statement = connection.prepare(&query).map_err(sqlite)?;
    let mut rows = statement.query([]).map_err(sqlite)?;
    let next_error = |error: rusqlite::Error| match error.sqlite_error_code() {
        Some(ErrorCode::OperationInterrupted) => without_end(format!(
            "its rows take more than {most_instructions} instructions of SQLite; copy them into a table observations"
        )),
        _ => sqlite(error),
    };
    let (mut text_bytes, mut cells_of_rows) = (0, Vec::new());
    while let Some(row) = rows.next().map_err(next_error)? {
        if cells_of_rows.len() == most_rows {
            return Err(error::too_many_rows(path, most_rows));
        }
        let cells: Result<Vec<Cell>, rusqlite::Error> =
            (0..table.names.len()).map(|index| row.get_ref(index).map(cell)).collect();
        let cells = cells.map_err(sqlite)?;
        text_bytes +=
            cells.iter().map(|cell| if let Cell::Text(text) = cell { text.len() as u64 } else { 0 }).sum::<u64>();
        if text_bytes > MOST_TEXT {
            return Err(without_end(format!("SQLite with more than {MOST_TEXT} bytes of text; split it")));
        }
        cells_of_rows.push(Ok(cells));
    }
    table.rows = cells_of_rows.into();
    Ok(table)
}

fn cell(value: ValueRef<'_>) -> Cell {
    match value {
        ValueRef::Null | ValueRef::Blob(_) => Cell::Missing,
        ValueRef::Integer(number) => Cell::Text(number.to_string()),
        ValueRef::Real(number) => Cell::Number(number),
        ValueRef::Text(text) => Cell::from_text(&String::from_utf8_lossy(text)),
    }
}

fn column_names(connection: &Connection) -> Result<Vec<String>, rusqlite::Error> {
    let mut statement = connection.prepare("SELECT name FROM pragma_table_info('observations') ORDER BY cid")?;
    statement.query_map([], |row| row.get(0))?.collect()
}

fn tables(connection: &Connection) -> Result<String, rusqlite::Error> {
    let mut statement = connection.prepare("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")?;
    let names: Vec<String> = statement.query_map([], |row| row.get(0))?.collect::<Result<_, _>>()?;
    Ok(if names.is_empty() { "none".to_owned() } else { names.join(", ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a view `observations` that contains the positive integers selected by `condition`.
    fn read_view(condition: &str, most_rows: usize) -> Result<RawTable, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("view.db");
        let query = format!(
            "CREATE VIEW observations AS WITH RECURSIVE numbers(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM numbers)
             SELECT n AS observationId, 60000.0 AS observationStartMJD, 30.0 AS visitExposureTime, 10.0 AS fieldRA,
             -10.0 AS fieldDec, 0.0 AS rotSkyPos, 'r' AS band FROM numbers {condition}"
        );
        Connection::open(&path).unwrap().execute_batch(&query).unwrap();
        read_bounded(&path, most_rows, 1_000_000)
    }

    #[test]
    fn verif_views_without_end_are_refused() {
        assert_eq!(read_view("LIMIT 1000", 1000).unwrap().rows.iter().count(), 1000);
        let error = |condition, most_rows| read_view(condition, most_rows).unwrap_err().to_string();
        assert!(error("", 1000).contains("more than 1000 rows; allowed: at most 1000"));
        assert!(error("WHERE n < 0", 1000).contains("its rows take more than 1000000 instructions of SQLite"));
        assert!(error("", usize::MAX).contains("its rows take more than 1000000 instructions of SQLite"));
    }
}
