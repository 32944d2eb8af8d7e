//! System clock, or simulated clock of a rehearsal, in which waits take no time.

use std::cell::Cell;
use std::thread::sleep;
use std::time::{Duration, Instant};

use hifitime::Epoch;
use streakcast::frames::seconds_between;

/// Longest sleep between two readings of the clock, so that a suspended machine or a changed clock is detected.
const MAX_SLEEP: Duration = Duration::from_secs(1);

/// Clock that can also wait.
#[derive(Clone)]
pub enum Clock {
    /// System clock.
    Machine,
    /// Simulated clock of a rehearsal.
    Rehearsal(Cell<Epoch>),
}

impl Clock {
    pub fn now(&self) -> Epoch {
        match self {
            Clock::Machine => crate::clock::now(),
            Clock::Rehearsal(now) => now.get(),
        }
    }

    /// Returns true for the system clock.
    pub fn is_real(&self) -> bool {
        matches!(self, Clock::Machine)
    }

    /// Waits until a given time. If the system clock is changed, the wait may end earlier, but not later.
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

/// Sleeps until `left` is zero, but not longer than its first value. `left` depends on the system clock, which may be
/// changed during the wait; `elapsed` is measured by the monotonic clock.
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

    /// Returns the duration of a wait of 40 s, seconds, if the clock is changed by `step_s` after 5 s.
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
