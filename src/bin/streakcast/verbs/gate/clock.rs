//! Clock of the machine, or of a rehearsal in which waits take no time.

use std::cell::Cell;
use std::thread::sleep;
use std::time::{Duration, Instant};

use hifitime::Epoch;
use streakcast::frames::seconds_between;

/// Longest sleep without reading the clock, to detect a suspended machine or a changed clock.
const MAX_SLEEP: Duration = Duration::from_secs(1);

/// Source of the time, which also waits.
pub enum Clock {
    /// Clock of the machine.
    Machine,
    /// Time of a rehearsal.
    Rehearsal(Cell<Epoch>),
}

impl Clock {
    pub fn now(&self) -> Epoch {
        match self {
            Clock::Machine => crate::clock::now(),
            Clock::Rehearsal(now) => now.get(),
        }
    }

    /// Returns true for the clock of the machine.
    pub fn is_real(&self) -> bool {
        matches!(self, Clock::Machine)
    }

    /// Waits until a moment. A change of the clock may shorten the wait, but not extend it.
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

/// Sleeps until `left` is zero, at most for its first value. The clock behind `left` may be changed meanwhile; the
/// monotonic clock behind `elapsed` may not.
fn wait(left: impl Fn() -> Duration, elapsed: impl Fn() -> Duration, pause: impl Fn(Duration)) {
    let longest = left();
    loop {
        let rest = longest.saturating_sub(elapsed()).min(left());
        if rest.is_zero() {
            return;
        }
        pause(rest.min(MAX_SLEEP));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the time spent in a wait of 40 s if the clock is set by `step_s` after 5 s, seconds.
    fn waited_s(step_s: f64) -> f64 {
        let elapsed_s = Cell::new(0.0);
        let left = || {
            let step_s = if elapsed_s.get() >= 5.0 { step_s } else { 0.0 };
            Duration::try_from_secs_f64(40.0 - elapsed_s.get() - step_s).unwrap_or_default()
        };
        let elapsed = || Duration::from_secs_f64(elapsed_s.get());
        wait(left, elapsed, |pause| elapsed_s.set(elapsed_s.get() + pause.as_secs_f64()));
        elapsed_s.get()
    }

    #[test]
    fn setting_the_clock_does_not_extend_a_wait() {
        assert_eq!([0.0, -3600.0, 30.0, 3600.0].map(waited_s), [40.0, 40.0, 10.0, 5.0]);
    }
}
