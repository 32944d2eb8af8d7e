//! Light curves: one row a moment of a pass.

use super::pass_table::PassRow;
use crate::output::{Column, Kind, Table, Value};
use crate::passes::TrackPoint;

/// What a point of a pass says.
pub(super) const POINTS: &[Column] = &[
    Column::time("utc", "Moment of reception."),
    Column::real("altitude_deg", "deg", 4, "Altitude without refraction."),
    Column::real("azimuth_deg", "deg", 4, "Azimuth from north through east."),
    Column::real("ra_deg", "deg", 6, "Right ascension, ICRS astrometric topocentric."),
    Column::real("dec_deg", "deg", 6, "Declination."),
    Column::real("range_km", "km", 3, "Distance from the observer."),
    Column::real("phase_angle_deg", "deg", 3, "Sun-satellite-observer angle."),
    Column::new("illumination", Kind::Text, "sunlit, penumbra or umbra."),
    Column::real("lit_fraction", "", 4, "Share of the Sun's light that arrives."),
    Column::real("magnitude", "mag", 3, "Apparent magnitude; empty in the umbra and where nothing lit is seen."),
    Column::real("magnitude_sigma", "mag", 3, "One sigma of it."),
];

const WHOSE: [Column; 3] = [
    Column::new("norad_id", Kind::Integer, "NORAD catalogue number."),
    Column::new("name", Kind::Text, "Name in the element set."),
    Column::time("culmination_utc", "Highest point of the pass that the row belongs to."),
];

/// The cells of a point.
pub(super) fn cells(point: &TrackPoint) -> Vec<Value> {
    let light = point.brightness.as_ref();
    vec![
        point.epoch.into(),
        point.altitude_rad.map(f64::to_degrees).into(),
        point.azimuth_rad.map(f64::to_degrees).into(),
        point.direction.longitude_rad().to_degrees().into(),
        point.direction.latitude_rad().to_degrees().into(),
        point.range_km.into(),
        point.geometry.phase_angle_rad().to_degrees().into(),
        point.illumination.name().into(),
        point.illumination.lit_fraction().into(),
        light.map(|light| light.magnitude.0).into(),
        light.map(|light| light.sigma_mag).into(),
    ]
}

/// All samples of all passes, pass by pass in order of time.
pub fn light_curve_table<'a>(rows: impl IntoIterator<Item = PassRow<'a>>) -> Table {
    let mut table = Table { columns: WHOSE.iter().chain(POINTS).copied().collect(), rows: Vec::new() };
    for row in rows {
        let whose: Vec<Value> =
            vec![i64::from(row.pass.norad_id.0).into(), row.name().into(), row.pass.culmination.epoch.into()];
        table.rows.extend(row.pass.samples.iter().map(|point| whose.iter().cloned().chain(cells(point)).collect()));
    }
    table
}
