//! Position in the format of SatChecker, with a magnitude added.

use serde_json::{Value, json};
use streakcast::frames::utc_jd;
use streakcast::output::format_utc;
use streakcast::passes::{Sky, TrackPoint};

use super::document::{number_schema, object_schema, optional_number_schema, rounded, text_schema};

/// Decimals of angles and dates in SatChecker.
const DECIMALS: i32 = 8;

pub fn position(sky: &Sky, element_index: usize, point: &TrackPoint, age_days: f64) -> Value {
    let degrees = |radians: f64| rounded(radians.to_degrees(), DECIMALS);
    let (day, fraction) = utc_jd(point.epoch);
    let elements = &sky.elements()[element_index];
    let epoch = date_time(elements.epoch);
    let brightness = point.brightness.as_ref();
    json!({
        "ra": degrees(point.direction.longitude_rad()),
        "dec": degrees(point.direction.latitude_rad()),
        "altitude": point.altitude_rad.map(degrees),
        "azimuth": point.azimuth_rad.map(degrees),
        "range_km": rounded(point.range_km, 6),
        "julian_date": rounded(day + fraction, DECIMALS),
        "date_time": date_time(point.epoch),
        "tle_epoch": epoch,
        "orbital_data_epoch": epoch,
        "illuminated": point.illumination.is_lit(),
        "phase_angle_deg": degrees(point.geometry.phase_angle_rad()),
        "apparent_magnitude": brightness.map(|brightness| rounded(brightness.magnitude.0, 3)),
        "apparent_magnitude_uncert": brightness.map(|brightness| rounded(brightness.sigma_mag, 3)),
        "mag_source": brightness.map(|brightness| brightness.source.to_string()),
        "epoch_age_days": rounded(age_days, 4),
    })
}

/// Formats a time as `2024-11-08 21:28:28 UTC`.
fn date_time(epoch: hifitime::Epoch) -> String {
    format_utc(epoch, 0).replace('T', " ").replace('Z', " UTC")
}

/// Returns the schema of a position with additional members.
pub fn position_schema(more: &[&'static str]) -> Value {
    let mut members = vec![
        ("ra", number_schema()),
        ("dec", number_schema()),
        ("altitude", optional_number_schema()),
        ("azimuth", optional_number_schema()),
        ("range_km", number_schema()),
        ("julian_date", number_schema()),
        ("date_time", text_schema()),
        ("tle_epoch", text_schema()),
        ("orbital_data_epoch", text_schema()),
        ("illuminated", json!({"type": "boolean"})),
        ("phase_angle_deg", number_schema()),
        ("apparent_magnitude", optional_number_schema()),
        ("apparent_magnitude_uncert", optional_number_schema()),
        ("mag_source", json!({"type": ["string", "null"]})),
        ("epoch_age_days", number_schema()),
    ];
    members.extend(more.iter().map(|name| {
        let schema = match *name {
            "name" => text_schema(),
            "norad_id" => json!({"type": "integer"}),
            _ => number_schema(),
        };
        (*name, schema)
    }));
    object_schema(&members)
}
