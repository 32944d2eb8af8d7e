//! Annotation of Parquet: verdicts are added as columns, streaks are written to a second file. All columns and metadata
//! are kept.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{BooleanArray, RecordBatch, RecordBatchReader};
use arrow_schema::{Field, Schema, SchemaRef};
use arrow_select::filter::filter_record_batch;
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::{KeyValue, ParquetMetaData};
use parquet::file::properties::WriterProperties;

use super::super::error::ScheduleError;
use super::super::formats::{batches, display};
use super::annotation::{Annotation, finish, streaks_path};
use crate::output::{AtomicFile, parquet_columns, parquet_fields, write_parquet};

/// Metadata key that the Parquet writer sets itself.
const ARROW_SCHEMA: &str = "ARROW:schema";

pub(super) fn annotate(
    input: &Path,
    output: &Path,
    annotation: &Annotation<'_>,
) -> Result<Vec<PathBuf>, ScheduleError> {
    let (reader, metadata) = batches(input)?;
    let schema = reader.schema();
    let names: Vec<String> = schema.fields().iter().map(|field| field.name().clone()).collect();
    let flags = annotation.flags_for(names.iter().map(String::as_str));
    let old = annotation.earlier_columns(input, &names, &flags)?;
    let own: Vec<usize> = (0..names.len()).filter(|index| !old.contains(index)).collect();
    annotation.check_rows(input, usize::try_from(metadata.file_metadata().num_rows()).unwrap_or(0))?;

    let fields: Vec<Arc<Field>> =
        own.iter().map(|&index| schema.fields()[index].clone()).chain(parquet_fields(&flags).map(Arc::new)).collect();
    // Schema metadata is copied to the file metadata, from which pyarrow reads it.
    let new_schema: SchemaRef = Arc::new(Schema::new(fields));
    let file = AtomicFile::new(output).map_err(|source| ScheduleError::Write { path: display(output), source })?;
    let broken = |error: &dyn std::fmt::Display| ScheduleError::AnnotateParquet {
        path: display(output),
        what: error.to_string(),
    };
    let mut writer = ArrowWriter::try_new(file.file(), new_schema.clone(), Some(properties(&metadata, &schema)))
        .map_err(|error| broken(&error))?;
    let (mut row, mut flag_row) = (0, 0);
    for batch in reader {
        let unreadable = |error: &dyn std::fmt::Display| ScheduleError::Format {
            path: display(input),
            what: format!("invalid Parquet: {error}"),
        };
        let batch = batch.map_err(|error| unreadable(&error))?;
        let kept: Vec<bool> = (row..row + batch.num_rows()).map(|row| annotation.is_kept(row)).collect();
        row += batch.num_rows();
        let batch = batch.project(&own).map_err(|error| unreadable(&error))?;
        let batch = if annotation.keep.is_some() {
            filter_record_batch(&batch, &BooleanArray::from(kept)).map_err(|error| unreadable(&error))?
        } else {
            batch
        };
        let next = flag_row + batch.num_rows();
        let arrays = parquet_columns(&flags.columns, flags.rows.get(flag_row..next).unwrap_or_default());
        flag_row = next;
        let columns = batch.columns().iter().cloned().chain(arrays).collect();
        let batch = RecordBatch::try_new(new_schema.clone(), columns).map_err(|error| broken(&error))?;
        writer.write(&batch).map_err(|error| broken(&error))?;
    }
    writer.close().map_err(|error| broken(&error))?;

    let beside = streaks_path(output, "parquet");
    let streaks = write_streaks(&beside, annotation)?;
    finish(vec![(streaks, beside), (file, output.to_owned())])
}

/// Returns writer properties with the compression and metadata of the input.
fn properties(metadata: &ParquetMetaData, of_schema: &Schema) -> WriterProperties {
    let entries = metadata.file_metadata().key_value_metadata().cloned().unwrap_or_default();
    let mut entries: Vec<KeyValue> = entries.into_iter().filter(|one| one.key != ARROW_SCHEMA).collect();
    for (key, value) in of_schema.metadata() {
        if !entries.iter().any(|one| one.key == *key) {
            entries.push(KeyValue::new(key.clone(), value.clone()));
        }
    }
    let first = metadata.row_groups().first().and_then(|group| group.columns().first());
    let compression = first.map_or(Compression::SNAPPY, |column| column.compression());
    let compression = match compression {
        // These codecs cannot be written by every build.
        Compression::BROTLI(_) | Compression::LZO => Compression::SNAPPY,
        known => known,
    };
    WriterProperties::builder()
        .set_compression(compression)
        .set_key_value_metadata((!entries.is_empty()).then_some(entries))
        .build()
}

fn write_streaks(path: &Path, annotation: &Annotation<'_>) -> Result<AtomicFile, ScheduleError> {
    let broken =
        |error: &dyn std::fmt::Display| ScheduleError::AnnotateParquet { path: display(path), what: error.to_string() };
    let file = AtomicFile::new(path).map_err(|source| ScheduleError::Write { path: display(path), source })?;
    write_parquet(file.file(), annotation.streaks, annotation.provenance).map_err(|error| broken(&error))?;
    Ok(file)
}
