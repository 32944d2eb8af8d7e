//! What a hook before each exposure asks: whether to wait, until when, and whether the elements are worth asking.

use hifitime::Epoch;

use super::windows::ClearWindow;
use crate::constants::DAY_S;
use crate::elements::ElementSet;
use crate::frames::seconds_between;

/// What is left of the first window that is open at `now` or opens until `last`; `None` where there is none.
pub fn wait_for(windows: &[ClearWindow], now: Epoch, last: Epoch) -> Option<ClearWindow> {
    let window = windows.iter().find(|window| window.last >= now)?;
    (window.first <= last).then(|| ClearWindow { first: window.first.max(now), last: window.last })
}

/// Share of the element sets whose epoch is more than `days` from a moment, either way, [0, 1]; 1 where there are none.
pub fn share_of_stale(elements: &[ElementSet], moment: Epoch, days: f64) -> f64 {
    if elements.is_empty() {
        return 1.0;
    }
    let stale = elements.iter().filter(|set| seconds_between(set.epoch, moment).abs() > days * DAY_S).count();
    stale as f64 / elements.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::seconds_after;

    #[test]
    fn the_first_window_that_is_not_over() {
        let zero = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let at = |seconds| seconds_after(zero, seconds);
        let windows = [(0.0, 10.0), (20.0, 30.0), (90.0, 95.0)]
            .map(|(first, last)| ClearWindow { first: at(first), last: at(last) });
        let wait = |now, last| {
            wait_for(&windows, at(now), at(last))
                .map(|window| (seconds_between(zero, window.first), seconds_between(zero, window.last)))
        };
        assert_eq!(wait(5.0, 5.0), Some((5.0, 10.0)));
        assert_eq!(wait(10.5, 100.0), Some((20.0, 30.0)));
        assert_eq!(wait(31.0, 89.0), None);
        assert_eq!(wait(31.0, 90.0), Some((90.0, 95.0)));
        assert_eq!(wait(96.0, 900.0), None);
    }
}
