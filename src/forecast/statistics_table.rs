//! Counts of satellites as a table: one row for each night, latitude, altitude of the Sun and lowest altitude.

use super::statistics::{SkyCount, StatisticsRequest};
use crate::output::{Column, Kind, Table, Value};

const COLUMNS: [Column; 17] = [
    Column::time("utc", "Middle of the moments that are averaged."),
    Column::new("twilight", Kind::Text, "evening or morning."),
    Column::real("latitude_deg", "deg", 4, "Of the site."),
    Column::real("sun_altitude_deg", "deg", 2, "The Sun's centre, without refraction."),
    Column::real("min_altitude_deg", "deg", 1, "Satellites above this are counted, and pointings spread over it."),
    Column::real("above", "", 2, "Satellites above it, lit or not."),
    Column::real("lit", "", 2, "Those in any sunlight."),
    Column::real("brighter_than_3", "", 2, "Those brighter than magnitude 3."),
    Column::real("brighter_than_4", "", 2, "Brighter than magnitude 4."),
    Column::real("brighter_than_5", "", 2, "Brighter than magnitude 5."),
    Column::real("brighter_than_6", "", 2, "Brighter than magnitude 6."),
    Column::real("brighter_than_7", "", 2, "Brighter than magnitude 7."),
    Column::real("brighter_than_8", "", 2, "Brighter than magnitude 8."),
    Column::real("field_deg", "deg", 4, "Full diameter of the field."),
    Column::real("exposure_s", "s", 3, "Length of the exposure."),
    Column::real("trails_per_exposure", "", 5, "Expected trails of lit satellites."),
    Column::real("streaked_share", "", 5, "Share of exposures with at least one."),
];

/// The counts of one request at a latitude (radians) as rows.
pub fn statistics_table<'a>(counts: impl IntoIterator<Item = (f64, &'a StatisticsRequest, &'a SkyCount)>) -> Table {
    let row = |(latitude_rad, request, count): (f64, &StatisticsRequest, &SkyCount)| -> Vec<Value> {
        let mut row: Vec<Value> = vec![
            count.epoch.into(),
            if count.evening { "evening" } else { "morning" }.into(),
            latitude_rad.to_degrees().into(),
            count.sun_altitude_rad.to_degrees().into(),
            count.min_altitude_rad.to_degrees().into(),
            count.above.into(),
            count.lit.into(),
        ];
        row.extend(count.brighter_than.iter().map(|number| Value::Real(*number)));
        row.extend([
            request.field_rad.to_degrees().into(),
            request.exposure_s.into(),
            count.trails.into(),
            count.streaked_share().into(),
        ]);
        row
    };
    Table { columns: COLUMNS.to_vec(), rows: counts.into_iter().map(row).collect() }
}
