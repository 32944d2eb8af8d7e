//! Rubin opsim databases: SQLite with a table `observations`.

use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};

use super::super::error::ScheduleError;
use super::columns::{Cell, ColumnMap, RawTable, ScheduleFormat, display};

/// Opens a database read-only.
///
/// # Errors
/// Any error of SQLite.
pub(in crate::schedule) fn open_read_only(path: &Path) -> Result<Connection, ScheduleError> {
    Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX)
        .map_err(|source| ScheduleError::Sqlite { path: display(path), source })
}

/// Reads the columns of `observations` that a schedule needs, in the order of the rows.
///
/// # Errors
/// No table `observations`, missing columns, or any error of SQLite.
pub(super) fn read(path: &Path) -> Result<RawTable, ScheduleError> {
    let sqlite = |source| ScheduleError::Sqlite { path: display(path), source };
    let connection = open_read_only(path)?;
    let names = column_names(&connection).map_err(sqlite)?;
    if names.is_empty() {
        let what =
            format!("SQLite without a table 'observations'; found tables: {}", tables(&connection).map_err(sqlite)?);
        return Err(ScheduleError::Format { path: display(path), what });
    }
    let map = ColumnMap::find(path, &names)?;
    let needed: Vec<usize> = [map.start.index, map.duration, map.right_ascension, map.declination]
        .into_iter()
        .chain(map.id)
        .chain(map.rotation)
        .chain(map.band)
        .collect();
    let mut table = RawTable::new(ScheduleFormat::Opsim, needed.iter().map(|&index| names[index].clone()).collect());
    let quoted: Vec<String> = table.names.iter().map(|name| format!("\"{}\"", name.replace('"', "\"\""))).collect();
    let query = format!("SELECT {} FROM observations", quoted.join(", "));
    let mut statement = connection.prepare(&query).map_err(sqlite)?;
    let mut rows = statement.query([]).map_err(sqlite)?;
    while let Some(row) = rows.next().map_err(sqlite)? {
        let cells: Result<Vec<Cell>, rusqlite::Error> =
            (0..table.names.len()).map(|index| row.get_ref(index).map(cell)).collect();
        table.rows.push(Ok(cells.map_err(sqlite)?));
    }
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
