//! Errors as exceptions; a bug of ours becomes one too, never a panic that takes the host down.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(streakcast, StreakcastError, PyValueError, "A question that has no answer.");
pyo3::create_exception!(streakcast, SetupError, StreakcastError, "A model that cannot be made of what was given.");

/// The exception of a question.
pub fn asked(error: impl std::fmt::Display) -> PyErr {
    StreakcastError::new_err(error.to_string())
}

/// The exception of a setup. Flags of the command line that messages name are arguments here.
pub fn setup(error: impl std::fmt::Display) -> PyErr {
    SetupError::new_err(as_arguments(&error.to_string()))
}

/// `--observer-elements` as `observer_elements`.
pub fn as_arguments(message: &str) -> String {
    let mut words = message.split("--");
    let mut answer = words.next().unwrap_or_default().to_owned();
    for word in words {
        let end = word.find(|c: char| !c.is_ascii_alphabetic() && c != '-').unwrap_or(word.len());
        answer += &word[..end].replace('-', "_");
        answer += &word[end..];
    }
    answer
}

/// Runs what takes long without the interpreter's lock.
pub fn without_lock<T: Send>(py: Python<'_>, work: impl FnOnce() -> PyResult<T> + Send) -> PyResult<T> {
    let pool = crate::pool::pool()?;
    let answer = py.detach(|| catch_unwind(AssertUnwindSafe(|| pool.install(work))));
    answer.unwrap_or_else(|cause| {
        let text = cause.downcast_ref::<String>().map(String::as_str).or(cause.downcast_ref::<&str>().copied());
        Err(PyRuntimeError::new_err(format!("internal error, please report it: {}", text.unwrap_or("no message"))))
    })
}
