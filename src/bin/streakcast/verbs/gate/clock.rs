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
                let began = Instant::now();
                let left = || Duration::try_from_secs_f64(seconds_between(self.now(), moment)).unwrap_or_default();
                wait(left, || began.elapsed(), sleep);
            }
            Clock::Rehearsal(now) => now.set(moment.max(now.get())),
        }
    }
}

/// Naps until nothing is left, and no longer than is left now: what is left goes by a clock that may be set, `elapsed` by one that is not.
fn wait(left: impl Fn() -> Duration, elapsed: impl Fn() -> Duration, nap: impl Fn(Duration)) {
    let longest = left();
    loop {
        let rest = longest.saturating_sub(elapsed()).min(left());
        if rest.is_zero() {
            return;
        }
        nap(rest.min(LONGEST_NAP));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wait of 40 s with the clock set after 5 s: waited, seconds.
    fn waited_s(step_s: f64) -> f64 {
        let elapsed_s = Cell::new(0.0);
        let left = || {
            let step_s = if elapsed_s.get() >= 5.0 { step_s } else { 0.0 };
            Duration::try_from_secs_f64(40.0 - elapsed_s.get() - step_s).unwrap_or_default()
        };
        let elapsed = || Duration::from_secs_f64(elapsed_s.get());
        wait(left, elapsed, |nap| elapsed_s.set(elapsed_s.get() + nap.as_secs_f64()));
        elapsed_s.get()
    }

    #[test]
    fn a_clock_that_is_set_stalls_nobody() {
        assert_eq!([0.0, -3600.0, 30.0, 3600.0].map(waited_s), [40.0, 40.0, 10.0, 5.0]);
    }
}
