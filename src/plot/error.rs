//! Errors of pictures.

use crate::error::{Error, ErrorKind};

/// Columns differ in length.
pub(super) fn length(what: &str, given: usize, expected: usize) -> Error {
    Error::new(ErrorKind::Invalid, format!("{what}: {given} values"))
        .allowing(format!("{expected}, as in the other columns"))
}

/// A value of a column is NaN or infinite.
pub(super) fn not_finite(what: &str, index: usize, value: f64) -> Error {
    Error::invalid(format!("{what}: value {index} (counted from 0)"), value, "a finite number")
}
