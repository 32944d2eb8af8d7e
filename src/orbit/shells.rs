//! Mean motions that many satellites of one inclination share: the shells of a constellation.
//!
//! The Starlinks of a shell keep the same mean motion, so that they do not drift apart. The median over a shell is
//! better than the mean motion between two element sets of one satellite, and it is also that of satellites which have
//! just arrived (docs/explanation/uncertainty.md).

use crate::constants::DAY_S;

/// Least number of satellites in a shell.
const LEAST_SATELLITES: usize = 50;
/// Range of mean motions that are counted, s/day.
const WIDTH_S_DAY: f64 = 1.0;
/// Satellites this close to a shell are not in another one, s/day.
const APART_S_DAY: f64 = 2.0;
/// Largest difference between the inclinations of neighbours in the order of inclinations, and between a satellite and
/// its shell, degrees.
const INCLINATION_DEG: f64 = 0.25;

/// Shells of a catalogue.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shells(Vec<Shell>);

#[derive(Copy, Clone, Debug, PartialEq)]
struct Shell {
    inclination_deg: f64,
    mean_motion_rev_day: f64,
}

impl Shells {
    /// Finds shells from the inclinations (degrees) and mean motions (rev/day) of satellites that hold their orbits.
    pub(super) fn new(mut satellites: Vec<(f64, f64)>) -> Self {
        satellites.sort_by(|a, b| a.0.total_cmp(&b.0));
        let groups = satellites.chunk_by(|a, b| b.0 - a.0 <= INCLINATION_DEG);
        Self(groups.flat_map(shells_of_group).collect())
    }

    /// Returns the mean motion of the shell of this inclination with the nearest mean motion, rev/day.
    pub(super) fn nearest(&self, inclination_deg: f64, mean_motion_rev_day: f64) -> Option<f64> {
        let of_inclination =
            self.0.iter().filter(|shell| (shell.inclination_deg - inclination_deg).abs() <= INCLINATION_DEG);
        let distance = |mean_motion: &f64| (mean_motion - mean_motion_rev_day).abs();
        of_inclination.map(|shell| shell.mean_motion_rev_day).min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}

/// Returns the shells of satellites of about one inclination, the largest shell first. `group` is sorted by
/// inclination.
fn shells_of_group(group: &[(f64, f64)]) -> Vec<Shell> {
    let inclination_deg = group[group.len() / 2].0;
    let mut values: Vec<f64> = group.iter().map(|(_, mean_motion)| *mean_motion).collect();
    values.sort_by(f64::total_cmp);
    // 1 s/day in rev/day: Δn P = 1 s/day.
    let unit = values[values.len() / 2] / DAY_S;
    let mut shells = Vec::new();
    loop {
        let count = |first: usize| values.partition_point(|value| *value <= values[first] + WIDTH_S_DAY * unit) - first;
        let Some((count, first)) = (0..values.len()).map(|first| (count(first), first)).max_by_key(|(count, _)| *count)
        else {
            return shells;
        };
        if count < LEAST_SATELLITES {
            return shells;
        }
        let mean_motion_rev_day = values[first + count / 2];
        shells.push(Shell { inclination_deg, mean_motion_rev_day });
        values.retain(|value| (value - mean_motion_rev_day).abs() > APART_S_DAY * unit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_shells_of_two_inclinations() {
        let spread = |inclination_deg: f64, mean_motion: f64, count: usize| {
            (0..count).map(move |k| {
                let offset = (k as f64 + 0.5) / count as f64 - 0.5;
                // 1e-5 rev/day are 0.06 s/day.
                (inclination_deg + 0.01 * offset, mean_motion + 1e-5 * offset)
            })
        };
        let all: Vec<(f64, f64)> = spread(53.16, 15.30, 400)
            .chain(spread(53.16, 15.34, 60))
            .chain(spread(53.05, 15.06, 40))
            .chain(spread(43.0, 15.27, 70))
            // On their way from one shell to the other.
            .chain((0..80).map(|k| (53.16, 15.30 + 0.0005 * f64::from(k))))
            .collect();
        let shells = Shells::new(all);
        assert_eq!(shells.0.len(), 3, "{shells:?}");
        for (inclination_deg, near, expected) in [
            (53.16, 15.301, Some(15.30)),
            (53.16, 15.33, Some(15.34)),
            (53.0, 15.06, Some(15.30)),
            (43.1, 15.34, Some(15.27)),
            (70.0, 15.30, None),
        ] {
            let found = shells.nearest(inclination_deg, near);
            assert_eq!(found.is_some(), expected.is_some());
            assert!(found.zip(expected).is_none_or(|(found, expected)| (found - expected).abs() < 1e-5), "{found:?}");
        }
        assert_eq!(Shells::new(Vec::new()), Shells::default());
    }
}
