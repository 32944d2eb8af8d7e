//! Parquet files: units and descriptions are in the metadata of the columns, the provenance in the metadata of the
//! file.

use std::collections::HashMap;
use std::io::{self, Write};
use std::sync::Arc;

use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use super::provenance::Provenance;
use super::table::{Column, Kind, Table, Value};

/// Writes a table. Integers, real numbers and booleans are stored as such, all other values as text. Real numbers are
/// rounded to the same decimals as in the other formats. The metadata of the file contain the provenance as JSON under
/// the key `provenance`.
///
/// # Errors
/// Any error of `out`.
pub fn write_parquet(out: impl Write + Send, table: &Table, provenance: &Provenance) -> io::Result<()> {
    let broken = |error: ParquetError| io::Error::other(error);
    let schema: SchemaRef = Arc::new(Schema::new(parquet_fields(table).collect::<Vec<_>>()));
    let statements = serde_json::to_string(provenance).unwrap_or_default();
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_key_value_metadata(Some(vec![KeyValue::new("provenance".to_owned(), statements)]))
        .build();
    let mut writer = ArrowWriter::try_new(out, schema.clone(), Some(properties)).map_err(broken)?;
    let columns = parquet_columns(&table.columns, &table.rows);
    let batch = RecordBatch::try_new(schema, columns).map_err(io::Error::other)?;
    writer.write(&batch).map_err(broken)?;
    writer.close().map_err(broken)?;
    Ok(())
}

/// Returns the columns of a table as Arrow fields, with units and descriptions in their metadata.
pub(crate) fn parquet_fields(table: &Table) -> impl Iterator<Item = Field> + '_ {
    table.columns.iter().map(|column| {
        let kind = match column.kind {
            Kind::Integer => DataType::Int64,
            Kind::Real { .. } => DataType::Float64,
            Kind::Boolean => DataType::Boolean,
            Kind::Text | Kind::Time { .. } | Kind::List { .. } | Kind::Rows(_) => DataType::Utf8,
        };
        let entries = [("unit", column.unit), ("description", column.description)];
        let entries = entries.into_iter().filter(|(_, text)| !text.is_empty());
        let entries: HashMap<String, String> = entries.map(|(key, text)| (key.to_owned(), text.to_owned())).collect();
        Field::new(column.name, kind, true).with_metadata(entries)
    })
}

/// Returns the rows as Arrow columns, with real numbers rounded to the same decimals as in the other formats.
pub(crate) fn parquet_columns(columns: &[Column], rows: &[Vec<Value>]) -> Vec<ArrayRef> {
    let column = |(index, column): (usize, &Column)| -> ArrayRef {
        let texts =
            rows.iter().map(|row| row.get(index).map(|value| column.text(value)).filter(|text| !text.is_empty()));
        match column.kind {
            Kind::Integer => Arc::new(texts.map(|text| text?.parse().ok()).collect::<Int64Array>()),
            Kind::Real { .. } => Arc::new(texts.map(|text| text?.parse().ok()).collect::<Float64Array>()),
            Kind::Boolean => Arc::new(texts.map(|text| text?.parse().ok()).collect::<BooleanArray>()),
            Kind::Text | Kind::Time { .. } | Kind::List { .. } | Kind::Rows(_) => {
                Arc::new(texts.collect::<StringArray>())
            }
        }
    };
    columns.iter().enumerate().map(column).collect()
}
