//! Parquet: columns of numbers and text. Nested columns are not read.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::cast;
use arrow_schema::DataType;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};
use parquet::file::metadata::ParquetMetaData;

use super::super::error::ScheduleError;
use super::columns::{Cell, RawTable, ScheduleFormat, display};

/// Returns the record batches of a file, with the metadata of its footer.
///
/// # Errors
/// The file cannot be read or is incomplete.
pub(in crate::schedule) fn batches(
    path: &Path,
) -> Result<(ParquetRecordBatchReader, std::sync::Arc<ParquetMetaData>), ScheduleError> {
    let file = File::open(path).map_err(|source| ScheduleError::Io { path: display(path), source })?;
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
    for batch in reader {
        let batch: RecordBatch = batch.map_err(|error| broken(path, &error))?;
        let columns: Vec<Vec<Cell>> = batch.columns().iter().map(cells).collect();
        table.rows.extend(
            (0..batch.num_rows()).map(|row| {
                Ok(columns.iter().map(|column| column.get(row).cloned().unwrap_or(Cell::Missing)).collect())
            }),
        );
    }
    Ok(table)
}

/// Returns the cells of a column: floating point numbers as numbers, integers as text with all digits, other types as
/// text. Cells whose type cannot be converted to text are missing.
fn cells(column: &ArrayRef) -> Vec<Cell> {
    if column.data_type().is_floating()
        && let Ok(numbers) = cast(column, &DataType::Float64)
    {
        let numbers = numbers.as_primitive::<Float64Type>();
        return numbers.iter().map(|number| number.map_or(Cell::Missing, Cell::Number)).collect();
    }
    match cast(column, &DataType::Utf8) {
        Ok(texts) => {
            let texts = texts.as_string::<i32>();
            texts.iter().map(|text| text.map_or(Cell::Missing, Cell::from_text)).collect()
        }
        Err(_) => vec![Cell::Missing; column.len()],
    }
}
