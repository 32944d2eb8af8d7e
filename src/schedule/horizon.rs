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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::{Direction, Orientation};
    use crate::geometry::Site;

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
