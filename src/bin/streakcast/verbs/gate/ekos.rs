//! What Ekos pipes into its pre-capture script: one JSON object, read without trusting the pipe ever to be closed.

use std::io::{self, Read, Stdin, stdin};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use serde::Deserialize;
use serde_json::Deserializer;

use super::status::{Fault, FaultKind};

/// The job behind a script.
#[derive(Debug, Default, PartialEq, Deserialize)]
pub struct Job {
    /// Name of the filter in the wheel.
    #[serde(default)]
    pub filter: Option<String>,
    /// Seconds.
    #[serde(default)]
    pub exposure: Option<f64>,
    /// `Light`, `Dark`, `Flat`, `Bias`.
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
    /// The filter as a band, where one is told.
    pub fn band(&self) -> Option<String> {
        self.filter.clone().filter(|filter| !filter.trim().is_empty() && filter != "--")
    }

    /// Darks, flats and biases see no sky, or do not care.
    pub fn is_light(&self) -> bool {
        self.kind.as_deref().is_none_or(|kind| kind.trim().is_empty() || kind.to_ascii_lowercase().contains("light"))
    }
}

/// Standard input, and whether anything but blanks came from it.
struct Heard {
    input: Stdin,
    anything: Arc<AtomicBool>,
}

impl Read for Heard {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(buffer)?;
        if !buffer[..read].trim_ascii().is_empty() {
            self.anything.store(true, Ordering::Relaxed);
        }
        Ok(read)
    }
}

/// The first JSON value on standard input; `None` where nothing comes, as from older KStars, whether they close it or not.
pub fn read_job(timeout: Duration) -> Result<Option<Job>, Fault> {
    let (send, receive) = channel();
    let anything = Arc::new(AtomicBool::new(false));
    let heard = Heard { input: stdin(), anything: anything.clone() };
    // A host that never closes the pipe must not stall the night: the reader is left behind.
    thread::spawn(move || {
        let mut messages = Deserializer::from_reader(heard).into_iter::<Message>();
        let _ = send.send(messages.next());
    });
    let bad = |what: String| Fault::new(FaultKind::Host, what);
    match receive.recv_timeout(timeout) {
        Ok(None) => Ok(None),
        Ok(Some(Ok(message))) => match message.script_type.as_deref() {
            None | Some("PRE_CAPTURE" | "PRE_JOB") => {
                message.job.map(Some).ok_or_else(|| bad("standard input: JSON without a job".to_owned()))
            }
            Some(other) => Err(bad(format!("standard input: script_type {other}; allowed: PRE_CAPTURE, PRE_JOB"))),
        },
        Ok(Some(Err(error))) => Err(bad(format!("standard input: {error}"))),
        Err(RecvTimeoutError::Timeout) if !anything.load(Ordering::Relaxed) => Ok(None),
        Err(RecvTimeoutError::Timeout) => {
            Err(bad(format!("standard input: no whole JSON object within {} s", timeout.as_secs_f64())))
        }
        Err(RecvTimeoutError::Disconnected) => Err(bad("standard input cannot be read".to_owned())),
    }
}
