//! Intervals of time in which a condition holds.

/// Tolerance of the ends of the intervals, seconds.
const BORDER_S: f64 = 1e-3;

/// Returns the intervals between two times, seconds, in which a condition holds. The condition is tested at even steps,
/// and the ends of the intervals are found by bisection to a millisecond, on the inside of the intervals.
pub fn intervals_where(begin_s: f64, end_s: f64, steps: usize, holds: impl Fn(f64) -> bool) -> Vec<(f64, f64)> {
    let time_s = |step: usize| begin_s + (end_s - begin_s) * step as f64 / steps as f64;
    let border = |mut in_s: f64, mut out_s: f64| {
        while (in_s - out_s).abs() > BORDER_S {
            let middle_s = 0.5 * (in_s + out_s);
            if holds(middle_s) { in_s = middle_s } else { out_s = middle_s }
        }
        in_s
    };
    let mut found = Vec::new();
    let mut began = holds(begin_s).then_some(begin_s);
    for step in 1..=steps {
        let (before_s, now_s) = (time_s(step - 1), time_s(step));
        match (began, holds(now_s)) {
            (None, true) => began = Some(border(now_s, before_s)),
            (Some(from_s), false) => {
                found.push((from_s, border(before_s, now_s)));
                began = None;
            }
            _ => {}
        }
    }
    found.extend(began.map(|from_s| (from_s, end_s)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_intervals_are_found() {
        let found = intervals_where(0.0, 100.0, 10, |time_s| (12.0..37.5).contains(&time_s) || time_s > 80.25);
        assert_eq!(found.len(), 2);
        for ((from_s, until_s), (first_s, last_s)) in found.iter().zip([(12.0, 37.5), (80.25, 100.0)]) {
            assert!(
                (from_s - first_s).abs() < 2.0 * BORDER_S && (until_s - last_s).abs() < 2.0 * BORDER_S,
                "{found:?}"
            );
        }
        assert_eq!(intervals_where(3.0, 3.0, 10, |_| true), [(3.0, 3.0)]);
    }
}
