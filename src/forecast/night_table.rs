//! The night itself as a table of one row: when it is dark, what was found and what was not shown, and why there is nothing.

use super::outlook::Forecast;
use crate::output::{Column, Kind, Table, Value};

const COLUMNS: [Column; 12] = [
    Column::time("start_utc", "First moment asked about."),
    Column::time("end_utc", "Last moment asked about."),
    Column::real("sun_altitude_limit_deg", "deg", 3, "Darkness is a Sun below this; empty where day counts too."),
    Column::time("dark_from_utc", "It first gets dark; empty where it never does."),
    Column::time("dark_until_utc", "It was dark for the last time."),
    Column::real("dark_h", "h", 4, "How long it is dark, all stretches together."),
    Column::real("lowest_sun_altitude_deg", "deg", 3, "The Sun's centre at its lowest, without refraction."),
    Column::time("lowest_sun_utc", "When that is."),
    Column::new(
        "passes_in_shadow",
        Kind::Integer,
        "Passes left out because the satellite is in the Earth's shadow whenever it is up while it is dark.",
    ),
    Column::new("passes_too_faint", Kind::Integer, "Passes left out because of the magnitude asked for."),
    Column::new("passes_too_low", Kind::Integer, "Passes left out because they culminate too low."),
    Column::new("why_empty", Kind::Text, "Where there is no pass: why."),
];

/// The night of a forecast, with the reason where it is empty.
pub fn night_table(forecast: &Forecast, why_empty: Option<&str>) -> Table {
    let (night, count) = (&forecast.night, &forecast.found.not_shown);
    let row: Vec<Value> = vec![
        night.start.into(),
        night.end.into(),
        night.max_sun_altitude_rad.map(f64::to_degrees).into(),
        night.dark.first().map(|dark| dark.0).into(),
        night.dark.last().map(|dark| dark.1).into(),
        (night.dark_s() / 3600.0).into(),
        night.lowest_sun_rad.to_degrees().into(),
        night.lowest_sun_at.into(),
        count.in_shadow.into(),
        count.too_faint.into(),
        count.too_low.into(),
        why_empty.into(),
    ];
    Table { columns: COLUMNS.to_vec(), rows: vec![row] }
}
