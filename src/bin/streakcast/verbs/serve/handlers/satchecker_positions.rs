//! Position in the format of SatChecker, with a magnitude added.

use serde_json::{Value, json};
use streakcast::frames::utc_jd;
use streakcast::output::format_utc;
use streakcast::passes::{Sky, TrackPoint};

use super::document::object_schema;
use super::document::rounded;

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
    let (number, or_null, text) =
        (json!({"type": "number"}), json!({"type": ["number", "null"]}), json!({"type": "string"}));
    let mut members = vec![
        ("ra", number.clone()),
        ("dec", number.clone()),
        ("altitude", or_null.clone()),
        ("azimuth", or_null.clone()),
        ("range_km", number.clone()),
        ("julian_date", number.clone()),
        ("date_time", text.clone()),
        ("tle_epoch", text.clone()),
        ("orbital_data_epoch", text.clone()),
        ("illuminated", json!({"type": "boolean"})),
        ("phase_angle_deg", number.clone()),
        ("apparent_magnitude", or_null.clone()),
        ("apparent_magnitude_uncert", or_null),
        ("mag_source", json!({"type": ["string", "null"]})),
        ("epoch_age_days", number.clone()),
    ];
    members.extend(more.iter().map(|name| {
        let schema = match *name {
            "name" => text.clone(),
            "norad_id" => json!({"type": "integer"}),
            _ => number.clone(),
        };
        (*name, schema)
    }));
    object_schema(&members)
}
