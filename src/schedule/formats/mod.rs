//! Schedules in several syntaxes, all read into one raw table of named columns.

mod columns;
mod delimited;
mod ecsv;
mod json;
#[cfg(feature = "sqlite")]
mod opsim;
mod raw;
mod sniff;

#[cfg(feature = "sqlite")]
pub(super) use columns::ID;
pub(super) use columns::{ColumnMap, StartColumn, StartForm};
pub(super) use delimited::{CsvLayout, csv_layout};
#[cfg(feature = "sqlite")]
pub(super) use opsim::open_read_only;
pub(super) use raw::{Cell, RawTable};
pub use sniff::ScheduleFormat;
pub(super) use sniff::{display, read_raw};
