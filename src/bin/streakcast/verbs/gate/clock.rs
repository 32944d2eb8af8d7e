//! The clock: that of the machine, or one that stands at a given moment and lets waits pass at once.

use std::cell::Cell;
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime};

use hifitime::Epoch;
use streakcast::frames::seconds_between;

/// Between looks at the clock while waiting: a machine that slept or was set right is noticed.
const LONGEST_NAP: Duration = Duration::from_secs(1);

/// The time, and waiting.
pub enum Clock {
    /// The machine's own.
    Machine,
    /// A rehearsal's.
    Rehearsal(Cell<Epoch>),
}

impl Clock {
    pub fn now(&self) -> Epoch {
        match self {
            Clock::Machine => {
                let since_1970 = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
                // The machine counts days of 86400 s, as UTC does on paper.
                Epoch::from_unix_seconds(since_1970.as_secs_f64())
            }
            Clock::Rehearsal(now) => now.get(),
        }
    }

    /// True for the machine's own clock.
    pub fn is_real(&self) -> bool {
        matches!(self, Clock::Machine)
    }

    /// Waits until a moment; at once where it has passed. Never longer than it is away now, whatever becomes of the clock meanwhile.
    pub fn sleep_until(&self, moment: Epoch) {
        match self {
            Clock::Machine => {
                let until = |now: Epoch| Duration::try_from_secs_f64(seconds_between(now, moment)).unwrap_or_default();
                let (began, longest) = (Instant::now(), until(self.now()));
                loop {
                    let rest = longest.saturating_sub(began.elapsed()).min(until(self.now()));
                    if rest.is_zero() {
                        return;
                    }
                    sleep(rest.min(LONGEST_NAP));
                }
            }
            Clock::Rehearsal(now) => now.set(moment.max(now.get())),
        }
    }
}
