//! Passes of measurements without times: rows whose geometries follow one another are of one pass.

use super::record::{Record, Sighting};
use super::rows::UNKNOWN_PASS;
use crate::frames::{Direction, Horizontal};

/// Largest differences between neighbouring rows of a pass: altitude of the Sun (radians), height of the satellite
/// (km), and angle on the sky (radians). In the survey of Slingshot they separate 33 passes in 16 degrees of the Sun's
/// altitude.
const SUN_RAD: f64 = 0.35 * std::f64::consts::PI / 180.0;
const HEIGHT_KM: f64 = 0.3;
const SKY_RAD: f64 = 14.0 * std::f64::consts::PI / 180.0;

/// One row that is linked with others.
struct SightingRow {
    /// Index of the record.
    record: usize,
    sun_altitude_rad: f64,
    height_km: f64,
    direction: Direction<Horizontal>,
}

/// Returns the indices of the records of each pass, in the order of their first records. Records whose
/// group is known are omitted.
pub(super) fn passes_without_times(records: &[Record]) -> Vec<Vec<usize>> {
    let row = |(record, measured): (usize, &Record)| match measured.sighting {
        Sighting::SunRelative { sun_altitude_rad, altitude_rad, azimuth_from_sun_rad, height_km } => {
            let direction = Direction::from_lon_lat_rad(azimuth_from_sun_rad, altitude_rad);
            (measured.group == UNKNOWN_PASS).then_some(SightingRow { record, sun_altitude_rad, height_km, direction })
        }
        _ => None,
    };
    let mut rows: Vec<SightingRow> = records.iter().enumerate().filter_map(row).collect();
    rows.sort_by(|a, b| a.sun_altitude_rad.total_cmp(&b.sun_altitude_rad).then(a.record.cmp(&b.record)));
    // Each row refers to another row of its pass, or to itself.
    let mut linked: Vec<usize> = (0..rows.len()).collect();
    fn root(linked: &mut [usize], mut row: usize) -> usize {
        while linked[row] != row {
            linked[row] = linked[linked[row]];
            row = linked[row];
        }
        row
    }
    for (i, first) in rows.iter().enumerate() {
        let near = rows[..i].iter().enumerate().rev();
        for (j, other) in near.take_while(|(_, other)| first.sun_altitude_rad - other.sun_altitude_rad < SUN_RAD) {
            let is_near = (first.height_km - other.height_km).abs() < HEIGHT_KM
                && first.direction.separation_rad(&other.direction) < SKY_RAD;
            if is_near {
                let (a, b) = (root(&mut linked, i), root(&mut linked, j));
                linked[a.max(b)] = a.min(b);
            }
        }
    }
    let mut passes = std::collections::BTreeMap::<usize, Vec<usize>>::new();
    for (i, row) in rows.iter().enumerate() {
        passes.entry(root(&mut linked, i)).or_default().push(row.record);
    }
    let mut passes: Vec<Vec<usize>> = passes.into_values().collect();
    passes.iter_mut().for_each(|pass| pass.sort_unstable());
    passes.sort_unstable_by_key(|pass| pass[0]);
    passes
}
