//! Which parts of a satellite's sky the points leave out.
//!
//! Each axis of the geometry is cut into cells: 5° of the Sun's latitude, 30° of the observer's longitude from the Sun (folded), 15° of the
//! observer's latitude. A cell with fewer than ten points is thin: what the model says there is drawn in from elsewhere. Longitudes are asked
//! for all the way from 0° to 180°. How far latitudes can reach depends on height and site, so only whole cells between the ends of
//! what was seen are asked for (one point in a thousand left out at each end), and these ends have to be two cells apart.

use crate::geometry::ViewingGeometry;
use crate::math::quantile::quantile;

use super::point::FitPoint;

/// Fewer points than this make a cell thin.
const LEAST_IN_CELL: usize = 10;
/// Share of the points that may lie beyond the ends of what was seen.
const STRAY_SHARE: f64 = 0.001;
/// Cells that the ends of a latitude have to be apart.
const LEAST_CELLS: f64 = 2.0;

/// One axis of the geometry.
struct Axis {
    name: &'static str,
    angle_rad: fn(&ViewingGeometry) -> f64,
    cell_deg: f64,
    /// Where it has to be covered; `None`: between the ends of what was seen.
    whole_deg: Option<[f64; 2]>,
}

const AXES: [Axis; 3] = [
    Axis { name: "Sun's latitudes", angle_rad: |g| g.sun_latitude_rad, cell_deg: 5.0, whole_deg: None },
    Axis {
        name: "observer's longitudes from the Sun",
        angle_rad: |g| g.folded().observer_longitude_rad,
        cell_deg: 30.0,
        whole_deg: Some([0.0, 180.0]),
    },
    Axis { name: "observer's latitudes", angle_rad: |g| g.observer_latitude_rad, cell_deg: 15.0, whole_deg: None },
];

/// What one axis lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct PoorAxis {
    /// Of what: `Sun's latitudes`.
    pub name: &'static str,
    /// Cells, from and to, degrees, with how few points each has.
    pub thin: Vec<([f64; 2], usize)>,
    /// All that was seen, degrees, where it is too little of the axis.
    pub narrow: Option<[f64; 2]>,
}

/// Axes that the points do not cover; none where all is well.
pub(super) fn poor_axes(points: &[FitPoint]) -> Vec<PoorAxis> {
    AXES.iter().filter_map(|axis| poor(axis, points)).collect()
}

fn poor(axis: &Axis, points: &[FitPoint]) -> Option<PoorAxis> {
    let mut angles_deg: Vec<f64> = points.iter().map(|point| (axis.angle_rad)(&point.geometry).to_degrees()).collect();
    angles_deg.sort_by(f64::total_cmp);
    let seen = [STRAY_SHARE, 1.0 - STRAY_SHARE].map(|share| quantile(&angles_deg, share));
    let cell = axis.cell_deg;
    let is_narrow = axis.whole_deg.is_none() && seen[1] - seen[0] < LEAST_CELLS * cell;
    // Rounding must not make the last degree of 180 a cell of its own.
    let [from, to] = axis.whole_deg.unwrap_or(seen).map(|end| end / cell);
    let counts = |k: i32| {
        let [low, high] = [f64::from(k) * cell, f64::from(k + 1) * cell];
        let below = |end: f64| angles_deg.partition_point(|angle| *angle < end);
        // The last cell of a whole axis holds its end.
        let beyond = if axis.whole_deg.is_some_and(|whole| high >= whole[1]) { angles_deg.len() } else { below(high) };
        ([low, high], beyond - below(low))
    };
    let thin: Vec<_> =
        (from.ceil() as i32..to.floor() as i32).map(counts).filter(|(_, count)| *count < LEAST_IN_CELL).collect();
    let narrow = is_narrow.then_some(seen);
    (narrow.is_some() || !thin.is_empty()).then_some(PoorAxis { name: axis.name, thin, narrow })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every degree of longitude at each of these latitudes of Sun and observer.
    fn seen(suns_deg: &[f64], latitudes_deg: &[f64], keep: impl Fn(f64) -> bool) -> Vec<FitPoint> {
        let longitudes = || (0..180).map(|i| f64::from(i) + 0.5).filter(|longitude| keep(*longitude));
        let all = suns_deg.iter().flat_map(|sun| latitudes_deg.iter().map(move |latitude| (*sun, *latitude)));
        all.flat_map(|(sun, latitude)| longitudes().map(move |longitude| [sun, longitude, latitude]))
            .map(|angles| {
                let [sun, longitude, latitude] = angles.map(f64::to_radians);
                let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 1000.0, 550.0);
                FitPoint { geometry: geometry.expect("a geometry"), magnitude: 6.0, sigma_mag: 0.1, group: 0 }
            })
            .collect()
    }

    const SUNS: [f64; 4] = [-21.0, -17.0, -12.0, -7.0];
    const LATITUDES: [f64; 4] = [-80.0, -65.0, -50.0, -35.0];

    #[test]
    fn verif_gaps_and_narrow_ranges_are_named() {
        assert_eq!(poor_axes(&seen(&SUNS, &LATITUDES, |_| true)), []);
        // Nine points of a sector are too few, ten are enough.
        for (end, count) in [(99.0, 9), (100.0, 10)] {
            let few =
                seen(&SUNS[1..2], &LATITUDES[1..2], |longitude| !(90.0..120.0).contains(&longitude) || longitude < end);
            let found = poor_axes(&few).into_iter().find(|axis| axis.name.contains("longitudes"));
            let expected = (count < 10).then(|| vec![([90.0, 120.0], count)]);
            assert_eq!(found.map(|axis| axis.thin), expected);
        }
        let gap = poor_axes(&seen(&[-21.0, -17.0, -7.0], &LATITUDES, |_| true));
        assert_eq!(gap, [PoorAxis { name: "Sun's latitudes", thin: vec![([-15.0, -10.0], 0)], narrow: None }]);
        let gap = poor_axes(&seen(&SUNS, &[-80.0, -50.0, -35.0], |_| true));
        assert_eq!(gap, [PoorAxis { name: "observer's latitudes", thin: vec![([-75.0, -60.0], 0)], narrow: None }]);
        let narrow = poor_axes(&seen(&[-12.0, -9.0], &LATITUDES, |_| true));
        assert_eq!((narrow.len(), narrow[0].name), (1, "Sun's latitudes"));
        assert!(narrow[0].narrow.is_some_and(|[from, to]| (from + 12.0).abs() < 0.1 && (to + 9.0).abs() < 0.1));
    }
}
