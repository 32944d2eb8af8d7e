//! Which pointings stand above the horizon while the shutter is open.

use hifitime::Epoch;

use crate::frames::{EopTable, OrientationTable, seconds_between};
use crate::geometry::Observer;
use crate::passes::Exposure;

/// Exposures whose orientation of the Earth is sampled together, seconds.
const GROUP_S: f64 = 43_200.0;

/// The lowest altitude of each pointing at opening and closing, radians, without refraction and aberration (20").
///
/// Between the two a pointing can only stand higher, or lower by what an arc sags: below a degree for an hour.
pub fn lowest_altitudes_rad(exposures: &[&Exposure], observer: &Observer, eop: &EopTable) -> Vec<f64> {
    let mut order: Vec<usize> = (0..exposures.len()).collect();
    order.sort_by_key(|&index| exposures[index].start);
    let mut altitudes = vec![f64::NAN; exposures.len()];
    let mut table: Option<OrientationTable> = None;
    for index in order {
        let exposure = exposures[index];
        let start_s = |from: Epoch| seconds_between(from, exposure.start);
        let table = match &mut table {
            Some(table) if start_s(table.reference()) + exposure.duration_s <= GROUP_S => table,
            slot => {
                let length_s = exposure.duration_s.max(GROUP_S);
                let end = crate::frames::seconds_after(exposure.start, length_s);
                slot.insert(OrientationTable::new(exposure.start, end, eop))
            }
        };
        let opened_s = start_s(table.reference());
        altitudes[index] = [opened_s, opened_s + exposure.duration_s]
            .into_iter()
            .map(|seconds| (observer.state(&table.at_s(seconds)).horizon * exposure.pointing).latitude_rad())
            .fold(f64::INFINITY, f64::min);
    }
    altitudes
}

/// No pointing sinks faster than the Earth turns, rad/s (a little more than a turn in a sidereal day).
const FASTEST_SINKING_RAD_S: f64 = 7.3e-5;
/// Between looks at a sinking pointing, seconds.
const LOOK_EVERY_S: f64 = 60.0;
/// A last start is given so much too early rather than too late, seconds.
const BEFORE_SETTING_S: f64 = 0.01;

/// How much later each exposure may start, at most `max_delay_s`, so that its pointing is still up as it ends, seconds.
///
/// Pointings that are up at their scheduled closing; the sky position stays the same, so that a pointing that sinks sets.
pub fn last_starts_s(exposures: &[&Exposure], observer: &Observer, eop: &EopTable, max_delay_s: f64) -> Vec<f64> {
    let lowest_rad = lowest_altitudes_rad(exposures, observer, eop);
    let each = exposures.iter().zip(lowest_rad);
    each.map(|(exposure, lowest_rad)| {
        if lowest_rad > FASTEST_SINKING_RAD_S * max_delay_s {
            return max_delay_s;
        }
        last_start_s(exposure, observer, eop, max_delay_s)
    })
    .collect()
}

fn last_start_s(exposure: &Exposure, observer: &Observer, eop: &EopTable, max_delay_s: f64) -> f64 {
    let end = crate::frames::seconds_after(exposure.start, exposure.duration_s + max_delay_s);
    let table = OrientationTable::new(exposure.start, end, eop);
    let is_up = |delay_s: f64| {
        let horizon = observer.state(&table.at_s(exposure.duration_s + delay_s)).horizon;
        (horizon * exposure.pointing).latitude_rad() >= 0.0
    };
    let mut up_s = 0.0_f64;
    while up_s < max_delay_s {
        let next_s = (up_s + LOOK_EVERY_S).min(max_delay_s);
        if is_up(next_s) {
            up_s = next_s;
            continue;
        }
        let mut down_s = next_s;
        while down_s - up_s > 0.1 * BEFORE_SETTING_S {
            let middle_s = 0.5 * (up_s + down_s);
            if is_up(middle_s) { up_s = middle_s } else { down_s = middle_s }
        }
        return (up_s - BEFORE_SETTING_S).max(0.0);
    }
    max_delay_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Direction, Orientation};
    use crate::geometry::Site;

    #[test]
    fn the_last_start_ends_as_the_pointing_sets() {
        let observer = Observer::new(Site::new_deg("x", -30.2446, -70.7494, 2663.0).unwrap());
        let eop = EopTable::none();
        let midnight = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let of = |start| Exposure {
            id: String::new(),
            start,
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(4.0, -0.6),
            rotation_rad: 0.0,
        };
        let lowest = |exposure: &Exposure| lowest_altitudes_rad(&[exposure], &observer, &eop)[0];
        // Half an hour before the pointing is down, some time in the day.
        let hours = (0..24).map(|hour| of(crate::frames::seconds_after(midnight, f64::from(hour) * 3600.0)));
        let low: Vec<Exposure> = hours
            .filter(|exposure| {
                let later = of(crate::frames::seconds_after(exposure.start, 3600.0));
                lowest(exposure) > 0.0 && lowest(&later) < 0.0
            })
            .collect();
        assert_eq!(low.len(), 1);
        let last_s = last_starts_s(&[&low[0]], &observer, &eop, 7200.0)[0];
        assert!((0.0..3600.0).contains(&last_s), "{last_s}");
        let at = |delay_s| lowest(&of(crate::frames::seconds_after(low[0].start, delay_s)));
        assert!(at(last_s) >= 0.0 && at(last_s + 0.1) < 0.0, "{last_s}: {} {}", at(last_s), at(last_s + 0.1));
        assert_eq!(last_starts_s(&[&low[0]], &observer, &eop, 0.5 * last_s), [0.5 * last_s]);
    }

    #[test]
    fn grouped_altitudes_equal_those_of_the_exact_orientation() {
        let observer = Observer::new(Site::new_deg("x", -30.2446, -70.7494, 2663.0).unwrap());
        let eop = EopTable::none();
        let start = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let exposures: Vec<Exposure> = [(300.0, 0.0), (0.0, 30.0), (90_000.0, 600.0), (3.0e6, 0.0), (40_000.0, 7200.0)]
            .iter()
            .map(|&(after_s, duration_s)| Exposure {
                id: String::new(),
                start: crate::frames::seconds_after(start, after_s),
                duration_s,
                pointing: Direction::from_lon_lat_rad(4.0, -0.6),
                rotation_rad: 0.0,
            })
            .collect();
        let found = lowest_altitudes_rad(&exposures.iter().collect::<Vec<_>>(), &observer, &eop);
        for (exposure, altitude_rad) in exposures.iter().zip(found) {
            let exact =
                [exposure.start, crate::frames::seconds_after(exposure.start, exposure.duration_s)].map(|epoch| {
                    (observer.state(&Orientation::at(epoch, &eop)).horizon * exposure.pointing).latitude_rad()
                });
            let lowest = exact[0].min(exact[1]);
            assert!((altitude_rad - lowest).abs() < 1e-8, "{altitude_rad} {lowest}");
        }
    }
}
