//! Job of Ekos: one JSON object on standard input of the pre-capture script. Ekos may not close this input.

use std::io::{self, Read, Stdin, stdin};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde::Deserialize;
use serde_json::Deserializer;

use super::status_file::{Fault, FaultKind};

/// Job that Ekos sends to the script.
#[derive(Debug, Default, PartialEq, Deserialize)]
pub struct Job {
    /// Name of the filter.
    #[serde(default)]
    pub filter: Option<String>,
    /// Exposure time, seconds.
    #[serde(default)]
    pub exposure: Option<f64>,
    /// Frame type: `Light`, `Dark`, `Flat` or `Bias`.
    #[serde(default, rename = "type")]
    pub kind: Option<String>,
    /// Name of the target.
    #[serde(default)]
    pub target_name: Option<String>,
}

#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    script_type: Option<String>,
    #[serde(default)]
    job: Option<Job>,
}

impl Job {
    /// Returns the filter name as a band; `None` if there is no filter.
    pub fn band(&self) -> Option<String> {
        self.filter.clone().filter(|filter| !filter.trim().is_empty() && filter != "--")
    }

    /// Returns false for darks, flats and biases.
    pub fn is_light(&self) -> bool {
        self.kind.as_deref().is_none_or(|kind| kind.trim().is_empty() || kind.to_ascii_lowercase().contains("light"))
    }
}

/// Standard input, with a flag that is set when anything except blanks is read.
struct WatchedInput {
    input: Stdin,
    anything: Arc<AtomicBool>,
}

impl Read for WatchedInput {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        if !buffer[..read].trim_ascii().is_empty() {
            self.anything.store(true, Ordering::Relaxed);
        }
        Ok(read)
    }
}

/// Reads the first JSON value on standard input; `None` if there is no input, as with older versions of KStars.
pub fn read_job(timeout: Duration) -> Result<Option<Job>, Fault> {
    let (send, receive) = channel();
    let anything = Arc::new(AtomicBool::new(false));
    let watched = WatchedInput { input: stdin(), anything: anything.clone() };
    // If the pipe is not closed, the thread is blocked until the process ends.
    thread::spawn(move || {
        let mut messages = Deserializer::from_reader(watched).into_iter::<Message>();
        let _ = send.send(messages.next());
    });
    let bad = |what: String| Fault::new(FaultKind::Host, what);
    match receive.recv_timeout(timeout) {
        Ok(None) => Ok(None),
        Ok(Some(Ok(message))) => match message.script_type.as_deref() {
            None | Some("PRE_CAPTURE" | "PRE_JOB") => message
                .job
                .map(Some)
                .ok_or_else(|| bad("standard input: missing key job in the JSON object".to_owned())),
            Some(other) => {
                Err(bad(format!("standard input: invalid script_type {other}; allowed: PRE_CAPTURE, PRE_JOB")))
            }
        },
        Ok(Some(Err(error))) => Err(bad(format!("standard input: {error}"))),
        Err(RecvTimeoutError::Timeout) if !anything.load(Ordering::Relaxed) => Ok(None),
        Err(RecvTimeoutError::Timeout) => Err(bad(format!(
            "standard input: no complete JSON object within {} s (--timeout); allowed: one object",
            timeout.as_secs_f64()
        ))),
        Err(RecvTimeoutError::Disconnected) => Err(bad("standard input cannot be read".to_owned())),
    }
}
