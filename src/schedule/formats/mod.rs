//! Schedule files in several formats, each read into a raw table of named columns.

mod checks;
mod columns;
mod csv_text;
mod delimited;
mod json;
#[cfg(feature = "sqlite")]
mod opsim;
mod raw_table;
mod read;
mod votable;

pub(super) use checks::Checks;
pub use columns::ScheduleFormat;
pub(super) use columns::{
    Cell, ColumnMap, DECLINATIONS, DURATIONS, ID, RIGHT_ASCENSIONS, ROTATIONS, ScheduleRow, StartColumn, StartForm,
    TARGET_DURATIONS, display, end_columns, start_columns,
};
pub(super) use csv_text::csv_layout;
pub(super) use delimited::ecsv_layout;
pub(super) use json::{Members, json_layout};
#[cfg(feature = "sqlite")]
pub(super) use opsim::open_read_only;
pub(super) use raw_table::RawTable;
pub(super) use read::read_raw;
pub(super) use votable::{Span, votable_layout};
