//! Altitudes of pointings above the horizon or the Earth's limb while the shutter is open.

use hifitime::Epoch;

use crate::error::Error;
use crate::frames::{EopTable, OrientationTable, seconds_after, seconds_between};
use crate::geometry::SunTable;
use crate::passes::{Exposure, Viewpoint};
use crate::watch::Watch;

/// Length of one table of the Earth's orientation, seconds. Exposures within this time share a table.
const GROUP_S: f64 = 43_200.0;

/// Sampling interval of a pointing's altitude for a telescope in orbit, seconds. From low orbit the altitude above the
/// limb changes by up to 0.6° in this time.
const LIMB_INTERVAL_S: f64 = 10.0;

/// Sampling interval of a pointing's altitude for a site, seconds.
const SITE_SAMPLES_S: f64 = 600.0;

/// Returns the lowest altitude of a pointing while the shutter is open, radians. Refraction and aberration (20") are
/// neglected.
///
/// From a site it is the lowest of the altitudes at opening, at closing and, in between, at intervals of at most ten
/// minutes; the altitude between them is lower by less than 0.02 degrees. From an orbit it is the lowest angle above
/// the Earth's limb, sampled every 10 s; NaN if the position of the telescope cannot be computed or no ephemeris covers
/// the whole exposure.
pub fn lowest_altitude_rad(exposure: &Exposure, viewpoint: &Viewpoint, eop: &EopTable) -> f64 {
    let end = seconds_after(exposure.start, exposure.duration_s);
    lowest_in(exposure, viewpoint, &OrientationTable::new(exposure.start, end, eop))
}

/// Function that returns a table of the Earth's orientation between two times.
pub(super) type Earth<'a> = &'a dyn Fn(Epoch, Epoch) -> OrientationTable;

/// Returns the result of [`lowest_altitude_rad`] for each exposure, with a function that computes the orientation of
/// the Earth.
pub(super) fn lowest_altitudes_over(
    exposures: &[&Exposure],
    viewpoint: &Viewpoint,
    earth: Earth<'_>,
    watch: &Watch,
) -> Result<Vec<f64>, Error> {
    let mut order: Vec<usize> = (0..exposures.len()).collect();
    order.sort_by_key(|&index| exposures[index].start);
    let mut altitudes = vec![f64::NAN; exposures.len()];
    let mut table: Option<OrientationTable> = None;
    for index in order {
        watch.check()?;
        let exposure = exposures[index];
        let start_s = |from: Epoch| seconds_between(from, exposure.start);
        let table = match &mut table {
            Some(table) if start_s(table.reference()) + exposure.duration_s <= GROUP_S => table,
            slot => {
                let length_s = exposure.duration_s.max(GROUP_S);
                let end = seconds_after(exposure.start, length_s);
                slot.insert(earth(exposure.start, end))
            }
        };
        altitudes[index] = lowest_in(exposure, viewpoint, table);
    }
    Ok(altitudes)
}

/// Returns the lowest altitude of a pointing during an exposure that `table` covers.
fn lowest_in(exposure: &Exposure, viewpoint: &Viewpoint, table: &OrientationTable) -> f64 {
    let opened_s = seconds_between(table.reference(), exposure.start);
    let interval = [exposure.start, seconds_after(exposure.start, exposure.duration_s)];
    if viewpoint.known_part(interval, 0.0, 0.0).is_none() {
        return f64::NAN;
    }
    let samples = match viewpoint {
        Viewpoint::Site(_) => (exposure.duration_s / SITE_SAMPLES_S).ceil().max(1.0),
        Viewpoint::Orbit(_) => (exposure.duration_s / LIMB_INTERVAL_S).ceil().max(1.0),
    };
    (0..=samples as usize)
        .map(|i| altitude_rad(exposure, viewpoint, table, opened_s + exposure.duration_s * i as f64 / samples))
        // NaN is kept if any sample is NaN.
        .fold(f64::INFINITY, |lowest, next| if next.is_nan() || next < lowest { next } else { lowest })
}

/// Returns the altitude of a pointing, radians, at a time in seconds after the reference time of `table`; NaN if the
/// position of the telescope cannot be computed.
pub(super) fn altitude_rad(exposure: &Exposure, viewpoint: &Viewpoint, table: &OrientationTable, seconds: f64) -> f64 {
    let epoch = seconds_after(table.reference(), seconds);
    viewpoint.pointing_altitude_rad(&exposure.pointing, epoch, &table.at_s(seconds)).unwrap_or(f64::NAN)
}

/// Returns the table of the Sun if the pointings of the observer have limits that need it; its reference is `start`.
pub(super) fn sun_of_limits(viewpoint: &Viewpoint, start: Epoch, end: Epoch) -> Option<SunTable> {
    viewpoint.orbit().filter(|observer| !observer.limits().is_empty()).map(|_| SunTable::new(start, end))
}

/// Returns the altitude of a pointing above `lowest_rad` or, if that is smaller, its margin from the limits of a
/// telescope in orbit, radians. The time is in seconds after the reference time of both tables; `sun` is that of
/// [`sun_of_limits`]. NaN if the position of the telescope cannot be computed.
pub(super) fn margin_rad(
    exposure: &Exposure,
    viewpoint: &Viewpoint,
    lowest_rad: f64,
    (table, sun): (&OrientationTable, Option<&SunTable>),
    seconds: f64,
) -> f64 {
    let (Some(observer), Some(sun)) = (viewpoint.orbit(), sun) else {
        return altitude_rad(exposure, viewpoint, table, seconds) - lowest_rad;
    };
    let epoch = seconds_after(table.reference(), seconds);
    let angles = observer.pointing_angles(&exposure.pointing, epoch, &table.at_s(seconds), &sun.at_s(seconds).sun);
    angles.map_or(f64::NAN, |angles| (angles.limb_rad - lowest_rad).min(observer.limits().margin_rad(&angles)))
}

/// Fastest descent of a pointing from a site, rad/s: the rotation rate of the Earth, rounded up.
const FASTEST_SINKING_RAD_S: f64 = 7.3e-5;
/// Sampling interval of a pointing from a site, seconds.
const SITE_INTERVAL_S: f64 = 60.0;
/// Fastest approach of a pointing to the Earth's limb from low orbit, rad/s.
const FASTEST_LIMB_RAD_S: f64 = 3e-3;
/// Returns the sampling interval of the altitude of a pointing, seconds.
pub(super) fn sampling_interval_s(viewpoint: &Viewpoint) -> f64 {
    if viewpoint.site().is_some() { SITE_INTERVAL_S } else { LIMB_INTERVAL_S }
}

/// Time between the end of the latest exposure and the setting of its pointing, seconds.
const BEFORE_SETTING_S: f64 = 0.01;

/// Returns for each exposure the longest delay, seconds, for which its pointing is still above the horizon and within
/// the limits of a telescope in orbit, and the position of the observer known, at closing; at most `max_delay_s`.
///
/// At the scheduled closing the pointings must be above the horizon.
pub(super) fn last_starts_s(
    exposures: &[&Exposure],
    viewpoint: &Viewpoint,
    earth: Earth<'_>,
    max_delay_s: f64,
    watch: &Watch,
) -> Result<Vec<f64>, Error> {
    let lowest_rad = lowest_altitudes_over(exposures, viewpoint, earth, watch)?;
    let fastest_rad_s = if viewpoint.site().is_some() { FASTEST_SINKING_RAD_S } else { FASTEST_LIMB_RAD_S };
    let each = exposures.iter().zip(lowest_rad);
    each.map(|(exposure, lowest_rad)| {
        watch.check()?;
        let end = seconds_after(exposure.start, exposure.duration_s);
        let known = viewpoint.known_part([exposure.start, end], 0.0, max_delay_s);
        let known_s = known.map_or(0.0, |[_, last]| seconds_between(end, last));
        // Epochs are rounded to a nanosecond.
        let max_delay_s = if known_s < max_delay_s - 1e-6 { known_s } else { max_delay_s };
        let has_limits = viewpoint.orbit().is_some_and(|observer| !observer.limits().is_empty());
        if !has_limits && lowest_rad > fastest_rad_s * max_delay_s {
            return Ok(max_delay_s);
        }
        Ok(last_start_s(exposure, viewpoint, earth, max_delay_s))
    })
    .collect()
}

fn last_start_s(exposure: &Exposure, viewpoint: &Viewpoint, earth: Earth<'_>, max_delay_s: f64) -> f64 {
    let end = seconds_after(exposure.start, exposure.duration_s + max_delay_s);
    let table = earth(exposure.start, end);
    let sun = sun_of_limits(viewpoint, exposure.start, end);
    let is_up = |delay_s: f64| {
        margin_rad(exposure, viewpoint, 0.0, (&table, sun.as_ref()), exposure.duration_s + delay_s) >= 0.0
    };
    let interval_s = sampling_interval_s(viewpoint);
    let mut up_s = 0.0_f64;
    while up_s < max_delay_s {
        let next_s = (up_s + interval_s).min(max_delay_s);
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
    use crate::geometry::{Observer, Site};

    #[test]
    fn the_last_exposure_ends_when_the_pointing_sets() {
        let observer = Observer::new(Site::new_deg("x", -30.2446, -70.7494, 2663.0).unwrap());
        let viewpoint = Viewpoint::from(observer);
        let eop = EopTable::none();
        let midnight = Epoch::from_gregorian_utc_at_midnight(2024, 8, 14);
        let of = |start| Exposure {
            id: String::new(),
            start,
            duration_s: 30.0,
            pointing: Direction::from_lon_lat_rad(4.0, -0.6),
            rotation_rad: 0.0,
        };
        let lowest = |exposure: &Exposure| lowest_altitude_rad(exposure, &viewpoint, &eop);
        // One start an hour; one of them precedes the setting of the pointing by less than an hour.
        let hours = (0..24).map(|hour| of(crate::frames::seconds_after(midnight, f64::from(hour) * 3600.0)));
        let low: Vec<Exposure> = hours
            .filter(|exposure| {
                let later = of(crate::frames::seconds_after(exposure.start, 3600.0));
                lowest(exposure) > 0.0 && lowest(&later) < 0.0
            })
            .collect();
        assert_eq!(low.len(), 1);
        let earth = |start, end| OrientationTable::new(start, end, &eop);
        let last_starts_s =
            |most_s: f64| last_starts_s(&[&low[0]], &viewpoint, &earth, most_s, &Watch::default()).unwrap();
        let last_s = last_starts_s(7200.0)[0];
        assert!((0.0..3600.0).contains(&last_s), "{last_s}");
        let at = |delay_s| lowest(&of(crate::frames::seconds_after(low[0].start, delay_s)));
        assert!(at(last_s) >= 0.0 && at(last_s + 0.1) < 0.0, "{last_s}: {} {}", at(last_s), at(last_s + 0.1));
        assert_eq!(last_starts_s(0.5 * last_s), [0.5 * last_s]);
    }

    #[test]
    fn grouped_altitudes_equal_those_of_the_exact_orientation() {
        let observer = Observer::new(Site::new_deg("x", -30.2446, -70.7494, 2663.0).unwrap());
        let viewpoint = Viewpoint::from(observer.clone());
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
        let earth = |start, end| OrientationTable::new(start, end, &eop);
        let exposures: Vec<&Exposure> = exposures.iter().collect();
        let found = lowest_altitudes_over(&exposures, &viewpoint, &earth, &Watch::default()).unwrap();
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
