//! Input files: regular files of bounded size, texts of TOML, and tables as CSV and ECSV.

mod ecsv;
mod file;
mod table;

#[cfg(feature = "fit")]
pub(crate) use ecsv::blank_record;
pub use ecsv::{Ecsv, LineError, TimeColumn, is_ecsv};
pub use file::{
    LARGEST_INPUT, check_regular, check_size, is_stream, json_error, json_value_error, open, read, read_at_most,
    read_to_string, text_of, toml_error, toml_line, without_mark,
};
pub use table::{
    Column, MOST_ROWS, TableRow, TableRows, UNCLOSED, comments_like_rows, comments_warning, delimiter_of, first_line,
};
