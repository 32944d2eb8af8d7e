//! Work with a deadline: it runs in another thread, which is left behind if it does not end in time.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Reason why work has no result.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum NoResult {
    /// The deadline has passed. The thread still runs, and ends with the process.
    Late,
    /// The work has panicked.
    Failed,
}

/// Runs work in another thread, and returns its result if it ends before the deadline. A call that blocks, such as a
/// read from a hung network file system, cannot be interrupted; only the thread that made it waits for its end.
pub fn within<T: Send + 'static>(deadline: Instant, work: impl FnOnce() -> T + Send + 'static) -> Result<T, NoResult> {
    let (send, receive) = channel();
    // The receiver is gone if the deadline has passed.
    thread::spawn(move || send.send(work()));
    let left = deadline.saturating_duration_since(Instant::now());
    receive.recv_timeout(left).map_err(|error| match error {
        RecvTimeoutError::Timeout => NoResult::Late,
        RecvTimeoutError::Disconnected => NoResult::Failed,
    })
}

/// Returns the time until a deadline, at most `longest`.
pub fn left(deadline: Instant, longest: Duration) -> Duration {
    deadline.saturating_duration_since(Instant::now()).min(longest)
}

/// What the work is doing, for the message if it does not end in time.
#[derive(Clone, Debug, Default)]
pub struct Step(Arc<Mutex<String>>);

impl Step {
    /// Sets the step that begins.
    pub fn begin(&self, step: impl Into<String>) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = step.into();
    }

    /// Returns the step that began last.
    pub fn last(&self) -> String {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_that_blocks_is_left_behind() {
        let soon = || Instant::now() + Duration::from_millis(20);
        let step = Step::default();
        let of_thread = step.clone();
        let blocked = within(soon(), move || {
            of_thread.begin("reading a file");
            loop {
                thread::park();
            }
        });
        assert_eq!((blocked, step.last().as_str()), (Err(NoResult::Late), "reading a file"));
        assert_eq!(within(Instant::now() + Duration::from_secs(600), || 7), Ok(7));
    }
}
