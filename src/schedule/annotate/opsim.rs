//! Annotation of an opsim database: a copy with three additional tables and a view.

use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::backup::Backup;
use rusqlite::types::Value as SqlValue;
use rusqlite::{Connection, params, params_from_iter};

use super::super::error;
use super::super::formats::{ID, open_read_only};
use super::annotation::Annotation;
use crate::error::{Error, ErrorKind};
use crate::output::{AtomicFile, Column, Kind, Provenance, Table, Value};

const STREAKS: &str = "streaks";
const FLAGS: &str = "streak_flags";
const PROVENANCE: &str = "streak_provenance";
/// View of the observations with their verdicts.
const JOINED: &str = "observations_streaks";
/// Number of database pages copied in one step.
const PAGES_PER_STEP: i32 = 16_384;

pub(super) fn annotate(input: &Path, output: &Path, annotation: &Annotation<'_>) -> Result<Vec<PathBuf>, Error> {
    let source = open_read_only(input)?;
    let of_input = |source| error::sqlite(input, source);
    if !annotation.replace {
        check_not_annotated(input)?;
    }
    let earlier = earlier_tables(&source).map_err(of_input)?;
    let rows: i64 = source.query_row("SELECT count(*) FROM observations", [], |row| row.get(0)).map_err(of_input)?;
    annotation.check_rows(input, usize::try_from(rows).unwrap_or(0))?;
    let write_error = |source| Error::cannot("write", output, source);
    let file = AtomicFile::new(output).map_err(write_error)?;
    write_copy(&source, file.path(), &earlier, annotation).map_err(|source| match source {
        // Texts and numbers of the input that cannot be read.
        rusqlite::Error::FromSqlConversionFailure(..)
        | rusqlite::Error::InvalidColumnType(..)
        | rusqlite::Error::Utf8Error(..) => of_input(source),
        source => Error::caused(ErrorKind::File, source).in_file("cannot write", output),
    })?;
    drop(source);
    file.finish().map_err(write_error)?;
    Ok(vec![output.to_owned()])
}

/// Checks that a database has no earlier annotation.
pub(super) fn check_not_annotated(input: &Path) -> Result<(), Error> {
    let earlier = earlier_tables(&open_read_only(input)?).map_err(|source| error::sqlite(input, source))?;
    if earlier.is_empty() {
        return Ok(());
    }
    let names: Vec<&str> = earlier.iter().map(|(_, name)| name.as_str()).collect();
    Err(error::already_there(input, &format!("tables {}", names.join(", "))))
}

/// Returns type and name of the tables and views of an earlier annotation.
fn earlier_tables(connection: &Connection) -> Result<Vec<(String, String)>, rusqlite::Error> {
    let mut statement = connection.prepare(
        "SELECT type, name FROM sqlite_master WHERE type IN ('table', 'view') AND name IN (?1, ?2, ?3, ?4) ORDER BY name",
    )?;
    statement.query_map(params![STREAKS, FLAGS, PROVENANCE, JOINED], |row| Ok((row.get(0)?, row.get(1)?)))?.collect()
}

fn write_copy(
    source: &Connection,
    target: &Path,
    earlier: &[(String, String)],
    annotation: &Annotation<'_>,
) -> Result<(), rusqlite::Error> {
    let mut copy = Connection::open(target)?;
    Backup::new(source, &mut copy)?.run_to_completion(PAGES_PER_STEP, Duration::ZERO, None)?;
    // Only the database file is renamed to the output, so there must be no separate journal file.
    copy.pragma_update(None, "journal_mode", "DELETE")?;
    let transaction = copy.transaction()?;
    for (kind, name) in earlier {
        transaction.execute(&format!("DROP {kind} {name}"), [])?;
    }
    if annotation.keep.is_some() {
        keep_rows(&transaction, annotation)?;
    }
    let id_type = id_type(&transaction)?;
    write_table(&transaction, STREAKS, annotation.streaks, id_type)?;
    write_table(&transaction, FLAGS, annotation.flags, id_type)?;
    merge_repeated(&transaction)?;
    write_view(&transaction, annotation.flags)?;
    write_provenance(&transaction, annotation.provenance)?;
    transaction.commit()?;
    copy.close().map_err(|(_, error)| error)
}

/// Deletes the observations that are not kept. Rows are numbered in reading order.
fn keep_rows(connection: &Connection, annotation: &Annotation<'_>) -> Result<(), rusqlite::Error> {
    let mut statement = connection.prepare("SELECT rowid FROM observations")?;
    let rows: Vec<i64> = statement.query_map([], |row| row.get(0))?.collect::<Result<_, _>>()?;
    let mut delete = connection.prepare("DELETE FROM observations WHERE rowid = ?")?;
    for (_, rowid) in rows.into_iter().enumerate().filter(|(row, _)| !annotation.is_kept(*row)) {
        delete.execute([rowid])?;
    }
    Ok(())
}

fn write_table(
    connection: &Connection,
    name: &str,
    table: &Table,
    id_type: &'static str,
) -> Result<(), rusqlite::Error> {
    let columns: Vec<String> =
        table.columns.iter().map(|column| format!("\"{}\" {}", column.name, affinity(column, id_type))).collect();
    connection.execute(&format!("CREATE TABLE {name} ({})", columns.join(", ")), [])?;
    let placeholders = vec!["?"; table.columns.len()].join(", ");
    let mut insert = connection.prepare(&format!("INSERT INTO {name} VALUES ({placeholders})"))?;
    for row in &table.rows {
        insert.execute(params_from_iter(table.columns.iter().zip(row).map(|(column, value)| cell(column, value))))?;
    }
    if table.columns.iter().any(|column| column.name == "exposure_id") {
        connection.execute(&format!("CREATE INDEX {name}_exposure_id ON {name} (exposure_id)"), [])?;
    }
    Ok(())
}

/// Returns true if no two rows of the flags have the same identifier.
fn has_unique_ids(connection: &Connection) -> Result<bool, rusqlite::Error> {
    let query = format!("SELECT count(*) = count(DISTINCT exposure_id) FROM {FLAGS}");
    connection.query_row(&query, [], |row| row.get(0))
}

/// Merges the rows of observations that are in the database several times.
fn merge_repeated(connection: &Connection) -> Result<(), rusqlite::Error> {
    if has_unique_ids(connection)? {
        return Ok(());
    }
    for table in [STREAKS, FLAGS] {
        let mut statement = connection.prepare("SELECT '\"' || name || '\"' FROM pragma_table_info(?)")?;
        let columns: Vec<String> = statement.query_map([table], |row| row.get(0))?.collect::<Result<_, _>>()?;
        let columns = columns.join(", ");
        let first = format!("SELECT min(rowid) FROM {table} GROUP BY {columns}");
        connection.execute(&format!("DELETE FROM {table} WHERE rowid NOT IN ({first})"), [])?;
    }
    Ok(())
}

/// Returns the SQL type of the exposure identifiers.
///
/// It is `INTEGER` if the column of the schedule is declared as an integer (in SQLite, a type name that contains
/// `INT`), or has no declared type (as after `CREATE TABLE ... AS`) and contains only integers. Otherwise it is `TEXT`:
/// texts such as '007', '1e3' or '7.0' that were converted to integers would not match the original texts in a join.
fn id_type(connection: &Connection) -> Result<&'static str, rusqlite::Error> {
    let columns = columns_of_observations(connection)?;
    let declared = id_column(&columns);
    let is_integer = match declared {
        None => false,
        Some((name, declared)) if declared.is_empty() => {
            let others = format!("SELECT count(*) FROM observations WHERE typeof(\"{name}\") <> 'integer'");
            connection.query_row(&others, [], |row| row.get::<_, i64>(0))? == 0
        }
        Some((_, declared)) => declared.to_ascii_uppercase().contains("INT"),
    };
    Ok(if is_integer { "INTEGER" } else { "TEXT" })
}

/// Returns names and declared types of the columns of `observations`.
fn columns_of_observations(connection: &Connection) -> Result<Vec<(String, String)>, rusqlite::Error> {
    let mut statement = connection.prepare("SELECT name, type FROM pragma_table_info('observations')")?;
    statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?.collect()
}

/// Returns the column of the exposure identifiers.
fn id_column(columns: &[(String, String)]) -> Option<&(String, String)> {
    ID.iter().find_map(|id| columns.iter().find(|(name, _)| name == id))
}

/// Creates the view of the observations with their verdicts, unless identifiers are missing or repeated, so that they
/// do not assign a verdict to each observation.
fn write_view(connection: &Connection, flags: &Table) -> Result<(), rusqlite::Error> {
    let columns = columns_of_observations(connection)?;
    let Some((id, _)) = id_column(&columns) else { return Ok(()) };
    let missing = format!("SELECT EXISTS (SELECT 1 FROM observations WHERE \"{id}\" IS NULL)");
    if !has_unique_ids(connection)? || connection.query_row(&missing, [], |row| row.get::<_, bool>(0))? {
        return Ok(());
    }
    let names: Vec<&str> =
        flags.columns.iter().map(|column| column.name).filter(|name| *name != "exposure_id").collect();
    // Columns of the observations with the name of one of these are left out, so that the name has one meaning.
    let is_kept = |name: &&String| !names.iter().any(|own| own.eq_ignore_ascii_case(name));
    let kept =
        columns.iter().map(|(name, _)| name).filter(is_kept).map(|name| format!("o.\"{}\"", name.replace('"', "\"\"")));
    let added = names.iter().map(|name| format!("f.\"{name}\""));
    let view = format!(
        "CREATE VIEW {JOINED} AS SELECT {} FROM observations o LEFT JOIN {FLAGS} f ON o.\"{id}\" = f.exposure_id",
        kept.chain(added).collect::<Vec<_>>().join(", ")
    );
    connection.execute(&view, []).map(drop)
}

fn affinity(column: &Column, id_type: &'static str) -> &'static str {
    match column.kind {
        Kind::Integer | Kind::Boolean => "INTEGER",
        Kind::Real { .. } | Kind::Small { .. } => "REAL",
        Kind::Text if column.name == "exposure_id" => id_type,
        Kind::Text | Kind::Time { .. } | Kind::List { .. } | Kind::Rows(_) => "TEXT",
    }
}

fn cell(column: &Column, value: &Value) -> SqlValue {
    let text = column.text(value);
    match value {
        Value::Null => SqlValue::Null,
        Value::Integer(number) => SqlValue::Integer(*number),
        Value::Boolean(truth) => SqlValue::Integer(i64::from(*truth)),
        // Rounded as in the text formats; NULL if it is not finite.
        Value::Real(_) => text.parse().map_or(SqlValue::Null, SqlValue::Real),
        Value::Text(_) | Value::Time(_) | Value::List(_) | Value::Integers(_) | Value::Rows(_) => SqlValue::Text(text),
    }
}

fn write_provenance(connection: &Connection, provenance: &Provenance) -> Result<(), rusqlite::Error> {
    connection.execute(&format!("CREATE TABLE {PROVENANCE} (name TEXT, value TEXT)"), [])?;
    let mut insert = connection.prepare(&format!("INSERT INTO {PROVENANCE} VALUES (?, ?)"))?;
    for (name, value) in provenance.entries() {
        insert.execute(params![name, value.to_string()])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(exposure_ids: &[&str]) -> (Table, Table) {
        let column = Column::new("exposure_id", Kind::Text, "");
        let flags = Table {
            columns: vec![column, Column::real("p_any", "", 2, "")],
            rows: exposure_ids.iter().map(|id| vec![(*id).into(), 0.5.into()]).collect(),
        };
        let streaks = Table {
            columns: vec![column, Column::new("norad_id", Kind::Integer, ""), Column::real("magnitude", "mag", 1, "")],
            rows: vec![vec!["7".into(), 44713_i64.into(), f64::NAN.into()]],
        };
        (flags, streaks)
    }

    fn dump(path: &Path) -> Vec<(i64, Vec<SqlValue>)> {
        let connection = open_read_only(path).unwrap();
        let mut statement = connection.prepare("SELECT rowid, * FROM observations ORDER BY rowid").unwrap();
        let rows = statement.query_map([], |row| {
            Ok((row.get(0)?, (1..5).map(|index| row.get(index)).collect::<Result<Vec<SqlValue>, _>>()?))
        });
        rows.unwrap().collect::<Result<_, _>>().unwrap()
    }

    #[test]
    fn ids_that_are_texts_join_as_texts() {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.db"), folder.path().join("out.db"));
        Connection::open(&input)
            .unwrap()
            .execute_batch(
                "CREATE TABLE observations (observationId TEXT);
                 INSERT INTO observations VALUES ('007'), ('7'), ('1e3'), ('7.0'), ('x');",
            )
            .unwrap();
        let (flags, streaks) = tables(&["007", "7", "1e3", "7.0", "x"]);
        let provenance = Provenance::default();
        let annotation =
            Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace: false, keep: None };
        annotate(&input, &output, &annotation).unwrap();
        let query = "SELECT count(*) FROM observations JOIN streak_flags ON exposure_id = observationId";
        let joined: i64 = Connection::open(&output).unwrap().query_row(query, [], |row| row.get(0)).unwrap();
        assert_eq!(joined, 5);
    }

    #[test]
    fn ids_without_a_declared_type_join_by_their_values() {
        let folder = tempfile::tempdir().unwrap();
        for (number, (values, ids)) in
            [("(7), (8)", ["7", "8"]), ("('007'), ('8')", ["007", "8"])].into_iter().enumerate()
        {
            let input = folder.path().join(format!("in{number}.db"));
            let output = folder.path().join(format!("out{number}.db"));
            Connection::open(&input)
                .unwrap()
                .execute_batch(&format!(
                    "CREATE TABLE observations (observationId); INSERT INTO observations VALUES {values};"
                ))
                .unwrap();
            let (flags, streaks) = tables(&ids);
            let provenance = Provenance::default();
            let annotation =
                Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace: false, keep: None };
            annotate(&input, &output, &annotation).unwrap();
            let copy = Connection::open(&output).unwrap();
            let query = "SELECT count(*) FROM observations JOIN streak_flags ON exposure_id = observationId";
            let joined: i64 = copy.query_row(query, [], |row| row.get(0)).unwrap();
            let kind: String =
                copy.query_row("SELECT typeof(exposure_id) FROM streak_flags", [], |row| row.get(0)).unwrap();
            assert_eq!((joined, kind.as_str()), if number == 0 { (2, "integer") } else { (2, "text") });
        }
    }

    /// The view has the verdict of each observation, or does not exist: without an identifier, and with one of two
    /// verdicts, there is none. Observations that are in the database twice have one verdict.
    #[test]
    fn the_view_needs_identifiers() {
        let folder = tempfile::tempdir().unwrap();
        let cases = [
            ("(7), (8)", ["7", "8"], 0.5, 1),
            ("(7), (NULL)", ["7", "2"], 0.5, 0),
            ("(7), (7)", ["7", "7"], 0.5, 1),
            ("(7), (7)", ["7", "7"], 0.6, 0),
        ];
        for (number, (values, ids, p_any, expected)) in cases.into_iter().enumerate() {
            let [input, output] = ["in", "out"].map(|name| folder.path().join(format!("{name}{number}.db")));
            let table = "CREATE TABLE observations (observationId INTEGER); INSERT INTO observations VALUES";
            Connection::open(&input).unwrap().execute_batch(&format!("{table} {values};")).unwrap();
            let (mut flags, streaks) = tables(&ids);
            flags.rows[1][1] = p_any.into();
            let provenance = Provenance::default();
            let annotation =
                Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace: false, keep: None };
            annotate(&input, &output, &annotation).unwrap();
            let query = "SELECT count(*) FROM sqlite_schema WHERE type = 'view'";
            let views: i64 = Connection::open(&output).unwrap().query_row(query, [], |row| row.get(0)).unwrap();
            assert_eq!(views, expected, "{values}, {p_any}");
        }
    }

    /// A column of the observations with the name of one of the verdicts is not in the view.
    #[test]
    fn names_in_the_view_are_those_of_the_verdicts() {
        let folder = tempfile::tempdir().unwrap();
        let [input, output] = ["in.db", "out.db"].map(|name| folder.path().join(name));
        let (flags, streaks) = tables(&["7", "8"]);
        let rows = "CREATE TABLE observations (observationId INTEGER, P_any REAL, \"a \"\"b\" TEXT);
                    INSERT INTO observations VALUES (7, -5, 'x'), (8, -5, 'y');";
        Connection::open(&input).unwrap().execute_batch(rows).unwrap();
        let provenance = Provenance::default();
        let annotation =
            Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace: false, keep: None };
        annotate(&input, &output, &annotation).unwrap();
        let copy = Connection::open(&output).unwrap();
        let query = "SELECT count(*), max(v.p_any = f.p_any), max(\"a \"\"b\") FROM observations_streaks v
                     JOIN streak_flags f ON f.exposure_id = observationId";
        let found: (i64, bool, String) =
            copy.query_row(query, [], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?))).unwrap();
        assert_eq!(found, (2, true, "y".to_owned()));
        let query = "SELECT count(*) FROM pragma_table_info('observations_streaks') WHERE name LIKE 'p_any%'";
        assert_eq!(copy.query_row(query, [], |row| row.get::<_, i64>(0)).unwrap(), 1);
    }

    #[test]
    fn every_cell_is_kept_and_the_tables_join() {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (folder.path().join("in.db"), folder.path().join("out.db"));
        let connection = Connection::open(&input).unwrap();
        // Cells of every storage class, a gap in the row numbers, and a write-ahead log that contains the last rows.
        connection
            .execute_batch(
                "PRAGMA journal_mode = WAL;
                 CREATE TABLE observations (observationId INTEGER, a REAL, b TEXT, c);
                 INSERT INTO observations VALUES (7, 0.1, 'x', x'00ff'), (8, 1e300, NULL, 3), (9, -0.0, '', 'tail');
                 DELETE FROM observations WHERE observationId = 8;
                 CREATE TABLE other (x); INSERT INTO other VALUES (1);",
            )
            .unwrap();
        let (flags, streaks) = tables(&["7", "9"]);
        let mut provenance = Provenance::default();
        provenance.state("version", "0");
        let annotation =
            |replace| Annotation { flags: &flags, streaks: &streaks, provenance: &provenance, replace, keep: None };
        annotate(&input, &output, &annotation(false)).unwrap();
        assert_eq!(dump(&input), dump(&output));
        let beside = |entry: &std::fs::DirEntry| entry.file_name().to_string_lossy().contains("out");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().flatten().filter(beside).count(), 1);
        let copy = Connection::open(&output).unwrap();
        let joined: (i64, Option<f64>, f64) = copy
            .query_row(
                "SELECT norad_id, magnitude, p_any FROM observations
                 JOIN streaks ON streaks.exposure_id = observationId
                 JOIN streak_flags ON streak_flags.exposure_id = observationId",
                [],
                |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?)),
            )
            .unwrap();
        assert_eq!(joined, (44713, None, 0.5));
        drop(copy);

        // A second annotation requires `replace`; input and output may be the same file.
        let error = annotate(&output, &output, &annotation(false)).unwrap_err().to_string();
        assert!(
            error.contains("already has tables observations_streaks, streak_flags, streak_provenance, streaks"),
            "{error}"
        );
        annotate(&output, &output, &annotation(true)).unwrap();
        assert_eq!(dump(&input), dump(&output));
        let copy = Connection::open(&output).unwrap();
        let count = |copy: &Connection, query: &str| copy.query_row(query, [], |row| row.get::<_, i64>(0)).unwrap();
        assert_eq!(count(&copy, "SELECT count(*) FROM streak_flags"), 2);
        // The view of an earlier annotation, or of a scheduler plugin, is replaced.
        let joined = "SELECT count(*) FROM observations_streaks WHERE p_any = 0.5 AND observationId IN (7, 9)";
        assert_eq!(count(&copy, joined), 2);
        let other =
            "DROP VIEW observations_streaks; CREATE VIEW observations_streaks AS SELECT 1 AS other FROM streak_flags";
        copy.execute_batch(other).unwrap();
        drop(copy);
        annotate(&output, &output, &annotation(true)).unwrap();
        let copy = Connection::open(&output).unwrap();
        assert_eq!(count(&copy, joined), 2);
        // Without an identifier an observation has no verdict in the view, which is therefore missing.
        copy.execute_batch("UPDATE observations SET observationId = NULL WHERE observationId = 9").unwrap();
        drop(copy);
        annotate(&output, &output, &annotation(true)).unwrap();
        let views = "SELECT count(*) FROM sqlite_master WHERE type = 'view'";
        assert_eq!(count(&Connection::open(&output).unwrap(), views), 0);
    }
}
