//! Parquet: columns of numbers and text. Nested columns are not read.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, TimestampMicrosecondType};
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::cast;
use arrow_schema::{ArrowError, DataType, TimeUnit};
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::file::metadata::ParquetMetaData;

use super::super::error::ScheduleError;
use super::columns::{Cell, ScheduleFormat, display};
use super::raw_table::{RawTable, Rows};

/// Returns the record batches of a file, with the metadata of its footer.
///
/// # Errors
/// The file cannot be read or is incomplete.
pub(in crate::schedule) fn batches(
    path: &Path,
) -> Result<(ParquetRecordBatchReader, std::sync::Arc<ParquetMetaData>), ScheduleError> {
    let file = crate::input::open(path).map_err(|source| ScheduleError::Io { path: display(path), source })?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| broken(path, &error))?;
    let metadata = builder.metadata().clone();
    let reader = builder.build().map_err(|error| broken(path, &error))?;
    Ok((reader, metadata))
}

fn broken(path: &Path, error: &dyn std::fmt::Display) -> ScheduleError {
    ScheduleError::Format { path: display(path), what: format!("invalid Parquet: {error}") }
}

/// Reads all rows of a file.
///
/// # Errors
/// Same as [`batches`]; also damage at which the Parquet library panics (version 60.1: 31 of 1,000,000 damaged files).
pub(super) fn read(path: &Path) -> Result<RawTable, ScheduleError> {
    catch_unwind(AssertUnwindSafe(|| read_batches(path)))
        .unwrap_or_else(|_| Err(broken(path, &"the Parquet library failed on a damaged page or footer")))
}

fn read_batches(path: &Path) -> Result<RawTable, ScheduleError> {
    let (reader, _) = batches(path)?;
    let schema = arrow_array::RecordBatchReader::schema(&reader);
    let names = schema.fields().iter().map(|field| field.name().clone()).collect();
    let mut table = RawTable::new(ScheduleFormat::Parquet, names);
    let mut rows = Vec::new();
    for batch in reader {
        let batch: RecordBatch = batch.map_err(|error| broken(path, &error))?;
        let columns: Vec<Vec<Cell>> = batch.columns().iter().map(cells).collect();
        rows.extend(
            (0..batch.num_rows()).map(|row| {
                Ok(columns.iter().map(|column| column.get(row).cloned().unwrap_or(Cell::Missing)).collect())
            }),
        );
    }
    table.rows = Rows::Cells(rows);
    Ok(table)
}

/// Returns the cells of a column: floating point numbers as numbers, integers as text with all digits, other types as
/// text; times with a time zone in UTC with a `Z`. Cells whose type cannot be converted to text are missing.
fn cells(column: &ArrayRef) -> Vec<Cell> {
    if column.data_type().is_floating()
        && let Ok(numbers) = cast(column, &DataType::Float64)
    {
        let numbers = numbers.as_primitive::<Float64Type>();
        return numbers.iter().map(|number| number.map_or(Cell::Missing, Cell::Number)).collect();
    }
    let (texts, zone) = match column.data_type() {
        DataType::Timestamp(_, Some(_)) => (utc(column), "Z"),
        _ => (cast(column, &DataType::Utf8), ""),
    };
    match texts {
        Ok(texts) => {
            let texts = texts.as_string::<i32>();
            texts
                .iter()
                .map(|text| text.map_or(Cell::Missing, |text| Cell::from_text(&format!("{text}{zone}"))))
                .collect()
        }
        Err(_) => vec![Cell::Missing; column.len()],
    }
}

/// Returns times with a time zone as text in UTC, in which Parquet stores them. Text in their own time zone would
/// require a table of all zone names.
fn utc(column: &ArrayRef) -> Result<ArrayRef, ArrowError> {
    let DataType::Timestamp(_, zone) = column.data_type() else { return cast(column, &DataType::Utf8) };
    let microseconds = cast(column, &DataType::Timestamp(TimeUnit::Microsecond, zone.clone()))?;
    let times = microseconds.as_primitive::<TimestampMicrosecondType>().clone().with_timezone_opt(None::<&str>);
    cast(&times, &DataType::Utf8)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow_array::{TimestampMillisecondArray, TimestampNanosecondArray};

    use super::*;

    #[test]
    fn verif_times_with_a_zone_are_read_in_utc() {
        // 2026-08-14T23:29:05.25Z.
        const UNIX_MS: i64 = 1_786_750_145_250;
        for zone in ["UTC", "+00:00", "+02:00", "Europe/Paris"] {
            let columns: [ArrayRef; 2] = [
                Arc::new(TimestampMillisecondArray::from(vec![Some(UNIX_MS), None]).with_timezone(zone)),
                Arc::new(TimestampNanosecondArray::from(vec![Some(UNIX_MS * 1_000_000), None]).with_timezone(zone)),
            ];
            for column in columns {
                let read = cells(&column);
                assert_eq!(read[0], Cell::from_text("2026-08-14T23:29:05.250Z"), "{zone}");
                assert_eq!(read[1], Cell::Missing, "{zone}");
            }
        }
    }
}
