//! Clear starts of exposures, computed from the intervals in which satellites are in the field.

/// Closed time interval, seconds after a reference time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Interval {
    /// Start, seconds.
    pub start_s: f64,
    /// End, seconds, not before `start_s`.
    pub end_s: f64,
}

/// Returns the earliest clear start of an exposure, at least `from_s` and at most `from_s + max_delay_s`.
///
/// The exposure lasts `duration_s`, with `margin_s` before and after it. A start is clear if the exposure with its
/// margins overlaps no interval of `blocked`; touching counts as overlapping. The gap to each interval is at least
/// `guard_s`: entries and exits are accurate to about 1 ms, so 1 or 2 ms are sufficient.
///
/// Returns `None` if no such start is clear, or a number is not finite.
pub(super) fn next_clear_start(
    blocked: &[Interval],
    duration_s: f64,
    margin_s: f64,
    guard_s: f64,
    from_s: f64,
    max_delay_s: f64,
) -> Option<f64> {
    let forbidden = forbidden_starts(blocked, duration_s, margin_s, guard_s)?;
    if !from_s.is_finite() || max_delay_s.is_nan() {
        return None;
    }
    let mut start_s = from_s;
    for interval in forbidden {
        if interval.start_s > start_s {
            // Intervals are sorted by start: all others begin later.
            break;
        }
        start_s = start_s.max(interval.end_s);
    }
    (start_s - from_s <= max_delay_s).then_some(start_s)
}

/// Returns all clear starts within `allowed`, as intervals in time order; empty if a number is not finite.
///
/// Duration, margin and guard are those of [`next_clear_start`].
pub(super) fn clear_starts(
    blocked: &[Interval],
    duration_s: f64,
    margin_s: f64,
    guard_s: f64,
    allowed: Interval,
) -> Vec<Interval> {
    let forbidden = forbidden_starts(blocked, duration_s, margin_s, guard_s);
    let (Some(forbidden), true) = (forbidden, allowed.start_s.is_finite() && allowed.end_s.is_finite()) else {
        return Vec::new();
    };
    let mut clear = Vec::new();
    let mut start_s = allowed.start_s;
    for interval in forbidden {
        if start_s > allowed.end_s {
            break;
        }
        if interval.start_s > start_s {
            clear.push(Interval { start_s, end_s: interval.start_s.min(allowed.end_s) });
        }
        start_s = start_s.max(interval.end_s);
    }
    if start_s <= allowed.end_s {
        clear.push(Interval { start_s, end_s: allowed.end_s });
    }
    clear
}

/// Returns the starts excluded by each blocked interval, sorted; `None` if a number is not finite.
fn forbidden_starts(blocked: &[Interval], duration_s: f64, margin_s: f64, guard_s: f64) -> Option<Vec<Interval>> {
    // An exposure from s to s + D overlaps [a, b] with margin m if a - m - D <= s <= b + m.
    let mut forbidden: Vec<Interval> = blocked
        .iter()
        .map(|interval| Interval {
            start_s: interval.start_s - margin_s - duration_s - guard_s,
            end_s: interval.end_s + margin_s + guard_s,
        })
        .collect();
    forbidden.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    forbidden.iter().all(|interval| interval.start_s.is_finite() && interval.end_s.is_finite()).then_some(forbidden)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Returns the first clear start, found by trying equally spaced starts.
    fn brute_force(
        blocked: &[Interval],
        duration_s: f64,
        margin_s: f64,
        from_s: f64,
        max_delay_s: f64,
        step_s: f64,
    ) -> Option<f64> {
        let steps = (max_delay_s / step_s).floor() as usize;
        (0..=steps).map(|step| from_s + step as f64 * step_s).find(|start_s| {
            blocked.iter().all(|interval| {
                interval.end_s < start_s - margin_s || interval.start_s > start_s + duration_s + margin_s
            })
        })
    }

    #[test]
    fn clear_starts_are_the_starts_that_no_interval_forbids() {
        let blocked = [Interval { start_s: 50.0, end_s: 52.0 }, Interval { start_s: 51.0, end_s: 60.0 }];
        // An exposure of 10 s with a margin of 1 s cannot start from 39 to 61.
        let interval = |start_s, end_s| Interval { start_s, end_s };
        let stretches = |first_s, last_s| clear_starts(&blocked, 10.0, 1.0, 0.0, interval(first_s, last_s));
        assert_eq!(stretches(0.0, 100.0), [interval(0.0, 39.0), interval(61.0, 100.0)]);
        assert_eq!(stretches(40.0, 100.0), [interval(61.0, 100.0)]);
        assert_eq!(stretches(0.0, 30.0), [interval(0.0, 30.0)]);
        assert_eq!(stretches(45.0, 55.0), []);
        assert_eq!(clear_starts(&[interval(f64::NAN, 1.0)], 10.0, 0.0, 0.0, interval(0.0, 9.0)), []);
    }

    proptest! {
        #[test]
        fn verif_next_clear_start_begins_the_first_interval(
            starts in prop::collection::vec((0.0..500.0, 0.0..30.0), 0..12),
            duration_s in 0.0..60.0,
            margin_s in 0.0..5.0,
            from_s in 0.0..500.0,
        ) {
            let blocked: Vec<Interval> =
                starts.iter().map(|(start_s, length_s)| Interval { start_s: *start_s, end_s: start_s + length_s }).collect();
            let allowed = Interval { start_s: from_s, end_s: from_s + 700.0 };
            let stretches = clear_starts(&blocked, duration_s, margin_s, 0.0, allowed);
            let first = next_clear_start(&blocked, duration_s, margin_s, 0.0, from_s, 700.0);
            prop_assert_eq!(stretches.first().map(|interval| interval.start_s), first);
            for interval in &stretches {
                // An exposure can start at any time inside an interval.
                let middle_s = 0.5 * (interval.start_s + interval.end_s);
                prop_assert_eq!(next_clear_start(&blocked, duration_s, margin_s, 0.0, middle_s, 700.0), Some(middle_s));
            }
            for pair in stretches.windows(2) {
                // No exposure can start between two intervals.
                let between_s = 0.5 * (pair[0].end_s + pair[1].start_s);
                let next = next_clear_start(&blocked, duration_s, margin_s, 0.0, between_s, 700.0);
                prop_assert_eq!(next, Some(pair[1].start_s));
            }
        }
    }

    #[test]
    fn next_clear_start_follows_the_last_overlapping_interval() {
        let blocked = [
            Interval { start_s: 5.0, end_s: 6.0 },
            Interval { start_s: 34.0, end_s: 40.0 },
            Interval { start_s: 100.0, end_s: 101.0 },
        ];
        // From 0 the first interval blocks, from 6 the second, and from 40 to 70 none.
        assert_eq!(next_clear_start(&blocked, 30.0, 0.0, 0.0, 0.0, 600.0), Some(40.0));
        assert_eq!(next_clear_start(&blocked, 30.0, 0.0, 0.0, 0.0, 39.0), None);
        assert_eq!(next_clear_start(&blocked, 20.0, 0.0, 0.0, 0.0, 600.0), Some(6.0));
        assert_eq!(next_clear_start(&blocked, 20.0, 5.0, 0.0, 0.0, 600.0), Some(45.0));
        assert_eq!(next_clear_start(&[], 30.0, 3.0, 0.0, 7.0, 0.0), Some(7.0));
        assert_eq!(next_clear_start(&[Interval { start_s: f64::NAN, end_s: 1.0 }], 30.0, 3.0, 0.0, 7.0, 9.0), None);
    }

    proptest! {
        #[test]
        fn clear_starts_agree_with_brute_force(
            ticks in prop::collection::vec((-400_i32..4000, 0_i32..300), 0..40),
            duration in 0_i32..600,
            margin in 0_i32..50,
            length in 0_i32..3000,
        ) {
            // Interval ends are half way between the steps, so that no step coincides with an end.
            let seconds = |ticks: i32| f64::from(ticks) * 0.1;
            let blocked: Vec<Interval> = ticks
                .iter()
                .map(|&(start, length)| Interval { start_s: seconds(start) + 0.05, end_s: seconds(start + length) + 0.05 })
                .collect();
            let (duration_s, margin_s) = (seconds(duration), seconds(margin));
            let allowed = Interval { start_s: 0.0, end_s: seconds(length) };
            let clear = clear_starts(&blocked, duration_s, margin_s, 0.0, allowed);
            prop_assert!(clear.iter().all(|interval| interval.start_s <= interval.end_s));
            prop_assert!(clear.windows(2).all(|pair| pair[0].end_s < pair[1].start_s));
            for tick in 0..=length {
                let start_s = seconds(tick);
                let inside = clear.iter().any(|interval| (interval.start_s..=interval.end_s).contains(&start_s));
                let brute = brute_force(&blocked, duration_s, margin_s, start_s, 0.0, 0.1).is_some();
                prop_assert_eq!(inside, brute, "{}", start_s);
            }
        }

        #[test]
        fn agrees_with_brute_force_at_a_tenth_of_a_second(
            ticks in prop::collection::vec((-400_i32..4000, 0_i32..300), 0..40),
            duration in 0_i32..600,
            margin in 0_i32..50,
            from in -100_i32..100,
            max_delay in 0_i32..3000,
        ) {
            // Interval ends are half way between the steps, so that no step coincides with an end.
            let blocked: Vec<Interval> = ticks
                .iter()
                .map(|&(start, length)| Interval {
                    start_s: f64::from(start) * 0.1 + 0.05,
                    end_s: f64::from(start + length) * 0.1 + 0.05,
                })
                .collect();
            let seconds = |ticks: i32| f64::from(ticks) * 0.1;
            let (duration_s, margin_s, from_s, max_delay_s) = (seconds(duration), seconds(margin), seconds(from), seconds(max_delay));
            let found = next_clear_start(&blocked, duration_s, margin_s, 0.0, from_s, max_delay_s);
            let brute = brute_force(&blocked, duration_s, margin_s, from_s, max_delay_s, 0.1);
            // The steps may miss a gap that is shorter than a step. The start found must still be clear.
            if let Some(found) = found {
                let clear = blocked.iter().all(|interval| {
                    interval.end_s <= found - margin_s + 1e-9 || interval.start_s >= found + duration_s + margin_s - 1e-9
                });
                prop_assert!(clear && found >= from_s && found <= from_s + max_delay_s + 1e-9, "{found}");
            }
            if let Some(brute) = brute {
                prop_assert!(found.is_some_and(|found| found <= brute + 1e-9), "{found:?} {brute}");
            }
        }
    }
}
