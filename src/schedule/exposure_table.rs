//! Exposures as a table, so that an answer says what was asked.

use crate::output::{Column, Kind, Table};
use crate::passes::Exposure;

/// The exposures as a table, in their order: `id, start_utc, duration_s, ra_deg, dec_deg, rotation_deg`.
pub fn exposure_table<'a>(exposures: impl IntoIterator<Item = &'a Exposure>) -> Table {
    let row = |exposure: &Exposure| {
        vec![
            exposure.id.as_str().into(),
            exposure.start.into(),
            exposure.duration_s.into(),
            exposure.pointing.longitude_rad().to_degrees().into(),
            exposure.pointing.latitude_rad().to_degrees().into(),
            exposure.rotation_rad.to_degrees().into(),
        ]
    };
    Table {
        columns: vec![
            Column::new("id", Kind::Text, "The schedule's name of the exposure."),
            Column::time("start_utc", "Shutter opening."),
            Column::real("duration_s", "s", 3, "Length of the exposure."),
            Column::real("ra_deg", "deg", 7, "Right ascension of the field's centre, ICRS."),
            Column::real("dec_deg", "deg", 7, "Declination of the field's centre."),
            Column::real("rotation_deg", "deg", 4, "Position angle of the field's y axis."),
        ],
        rows: exposures.into_iter().map(row).collect(),
    }
}
