//! Schedules in several syntaxes, all read into one raw table of named columns.

mod columns;
mod delimited;
mod ecsv;
mod json;
#[cfg(feature = "sqlite")]
mod opsim;
#[cfg(feature = "parquet")]
mod parquet;
mod raw;
mod sniff;
mod votable;

pub(super) use columns::{ColumnMap, ID, StartColumn, StartForm};
pub(super) use delimited::{CsvLayout, csv_layout};
pub(super) use ecsv::ecsv_layout;
pub(super) use json::{JsonRow, Members, json_layout};
#[cfg(feature = "sqlite")]
pub(super) use opsim::open_read_only;
#[cfg(feature = "parquet")]
pub(super) use parquet::batches;
pub(super) use raw::{Cell, RawTable};
pub use sniff::ScheduleFormat;
pub(super) use sniff::{display, read_raw};
pub(super) use votable::{Span, VoTableLayout, votable_layout};
