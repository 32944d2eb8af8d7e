//! Errors of a configuration and of requests that use it.

use std::path::Path;

use crate::error::{Error, ErrorKind};

/// Two options exclude each other.
pub(super) fn both(first: &str, second: &str) -> Error {
    Error::new(ErrorKind::Invalid, format!("{first} and {second} exclude each other; specify one of them"))
}

/// The request is incomplete or contradictory.
pub(super) fn request(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::Invalid, message)
}

/// A file of the configuration cannot be read.
pub(super) fn unreadable(purpose: &str, path: &Path, source: std::io::Error) -> Error {
    Error::system(source).in_file(purpose, path)
}
