//! Conversion of errors and panics to Python exceptions.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use streakcast::Watch;
use streakcast::config::Config;
use streakcast::message::bounded;

pyo3::create_exception!(streakcast, StreakcastError, PyValueError, "Invalid request.");
pyo3::create_exception!(streakcast, SetupError, StreakcastError, "Invalid arguments of a model.");
pyo3::create_exception!(
    streakcast,
    UnknownPositionsError,
    StreakcastError,
    "The positions of the satellites are unknown, because their elements are too old."
);

/// Returns the exception for a request at a time at which the positions of the satellites are unknown.
pub fn unknown(reason: impl std::fmt::Display) -> PyErr {
    UnknownPositionsError::new_err(reason.to_string())
}

/// Returns the exception for an invalid request. Flags of the command line in the message become arguments.
pub fn request(error: impl std::fmt::Display) -> PyErr {
    StreakcastError::new_err(message_of(error))
}

/// Returns the exception for arguments of a request that have another type or name.
pub fn json(error: serde_json::Error) -> PyErr {
    request(streakcast::input::json_value_error(&error))
}

/// Returns the exception for invalid arguments of a model. Flags of the command line in the message become arguments.
pub fn setup(error: impl std::fmt::Display) -> PyErr {
    SetupError::new_err(message_of(error))
}

fn message_of(error: impl std::fmt::Display) -> String {
    bounded(&as_arguments(&error.to_string())).into_owned()
}

/// Returns messages with argument names in place of flags.
pub fn all_as_arguments<'a>(messages: impl IntoIterator<Item = &'a String>) -> Vec<String> {
    messages.into_iter().map(|message| as_arguments(message)).collect()
}

/// Replaces flags and names of settings by argument names, for example `--observer-elements` by `observer_elements` and
/// `bright-share` by `bright_share`.
pub fn as_arguments(message: &str) -> String {
    let is_end = |c: Option<char>| !c.is_some_and(|c| c.is_ascii_alphanumeric() || "-_./\\'".contains(c));
    let mut message = message.to_owned();
    for key in Config::QUESTIONS.iter().flat_map(|question| question.keys).filter(|key| key.contains('_')) {
        let setting = key.replace('_', "-");
        let mut at = 0;
        while let Some(found) = message[at..].find(&setting) {
            let (begin, end) = (at + found, at + found + setting.len());
            // Not in paths, other names and quoted values.
            let ends_sentence = message[end..].trim_start_matches('.').starts_with(char::is_whitespace);
            if is_end(message[..begin].chars().next_back()) && (ends_sentence || is_end(message[end..].chars().next()))
            {
                message.replace_range(begin..end, key);
            }
            at = end;
        }
    }
    let mut words = message.split("--");
    let mut converted = words.next().unwrap_or_default().to_owned();
    for word in words {
        // Not in the names of projections, as in DEC--TAN.
        if converted.ends_with(|c: char| c.is_ascii_alphanumeric())
            || !word.starts_with(|c: char| c.is_ascii_lowercase())
        {
            converted = converted + "--" + word;
            continue;
        }
        let end = word.find(|c: char| !c.is_ascii_alphabetic() && c != '-').unwrap_or(word.len());
        converted += &word[..end].replace('-', "_");
        converted += &word[end..];
    }
    converted
}

/// Interval between two checks for signals, such as that of Ctrl-C.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Runs a function in the thread pool without the interpreter lock. Panics are converted to exceptions.
///
/// If a signal handler of Python raises an exception (`KeyboardInterrupt` on Ctrl-C), the work is stopped by its watch,
/// and the exception is returned.
pub fn without_lock<T: Send>(py: Python<'_>, work: impl FnOnce(&Watch) -> PyResult<T> + Send) -> PyResult<T> {
    let pool = crate::pool::pool()?;
    let watch = Watch::default();
    py.detach(|| {
        let (sender, receiver) = mpsc::sync_channel(1);
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // The receiver is alive until the work has sent its result.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&watch))));
            });
            result_of(&receiver, Some(&watch))
        })
    })
}

/// Runs a function that tests no watch, such as the reading of files, in the thread pool without the interpreter lock.
/// Panics are converted to exceptions.
///
/// If a signal handler of Python raises an exception, it is returned at once. The work continues to its end, and its
/// result is dropped.
pub fn without_lock_or_watch<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let pool = crate::pool::pool()?;
    let (sender, receiver) = mpsc::sync_channel(1);
    pool.spawn(move || {
        // Without a receiver the result is not needed.
        let _ = sender.send(catch_unwind(AssertUnwindSafe(work)));
    });
    py.detach(move || result_of(&receiver, None))
}

/// Waits for the result of work in another thread. If a signal handler raises an exception, the watch is stopped;
/// without a watch the exception is returned at once.
fn result_of<T>(receiver: &Receiver<thread::Result<PyResult<T>>>, watch: Option<&Watch>) -> PyResult<T> {
    let mut raised = None;
    let result = loop {
        match receiver.recv_timeout(SIGNALS_EVERY) {
            Err(RecvTimeoutError::Timeout) => {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    match watch {
                        Some(watch) => watch.stop(),
                        None => return Err(error),
                    }
                    raised = Some(error);
                }
            }
            received => break received,
        }
    };
    if let Some(error) = raised {
        return Err(error);
    }
    let result = result.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    result.unwrap_or_else(|cause| {
        let text = cause.downcast_ref::<String>().map(String::as_str).or(cause.downcast_ref::<&str>().copied());
        Err(PyRuntimeError::new_err(format!("internal error, please report it: {}", text.unwrap_or("no message"))))
    })
}
