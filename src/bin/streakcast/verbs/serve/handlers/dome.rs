//! `/api/v1/dome`: returns the sky over the site during an exposure.

use serde_json::{Value, json};
use streakcast::frames::seconds_after;
use streakcast::maps::{Earth, Grid, SkyView};
use streakcast::passes::{SatelliteTrack, SnapshotOptions, SnapshotPositions};

use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, number, optional, required};
use super::super::state::RequestState;
use super::document::{
    Document, degrees, document_schema, number_schema, object_schema, optional_number_schema, rounded, text_schema,
};

pub const PARAMETERS: &[Parameter] = &[
    required("start_utc", Kind::Moment, "Start."),
    required("duration_s", number(0.0, 3600.0, " s"), "Length, seconds."),
    optional(
        "height_km",
        number(160.0, 40_000.0, " km"),
        "Height of the satellites of map and shadow, km; default 550.",
    ),
    optional(
        "model",
        Kind::Text { longest: 100 },
        "Brightness model of the map, one of those that /api/v1/night lists; default starlink-v1.5.",
    ),
    optional("min_altitude_deg", number(0.0, 90.0, " deg"), "Lowest altitude of satellites, degrees; default 0."),
];

const DEFAULT_HEIGHT_KM: f64 = 550.0;
const DEFAULT_MODEL: &str = "starlink-v1.5";
/// Grid step of the magnitude map, degrees.
const STEP_DEG: f64 = 5.0;
/// Number of points of the outline of the Earth's shadow.
const EDGE_POINTS: usize = 180;
/// Number of points along a track.
const TRACK_POINTS: usize = 5;

pub fn handle(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let start = query.moment("start_utc").ok_or_else(|| Problem::missing("start_utc", "UTC"))?;
    let state = &state.at(start)?;
    let duration_s = query.number("duration_s").unwrap_or_default();
    let height_km = query.number("height_km").unwrap_or(DEFAULT_HEIGHT_KM);
    let name = query.text("model").unwrap_or(DEFAULT_MODEL);
    let known = || state.library.names().collect::<Vec<_>>().join(", ");
    let model = state.library.get(name).ok_or_else(|| Problem::parameter("model", name, &known()))?;

    let mid = seconds_after(start, 0.5 * duration_s);
    let sun = state.sky().sun_altaz(mid)?;
    let earth = Earth::Ellipsoid(state.site.clone());
    let photometry = state.plan.photometry;
    let view = SkyView::new(&model, earth, height_km, sun.azimuth_rad, sun.altitude_rad, photometry)?
        .with_shadow(state.sky().shadow());
    let grid = Grid::regular(STEP_DEG).map_err(|error| Problem::new(500, error.to_string()))?;
    let points = view.map(grid).map_err(|error| Problem::new(500, error.to_string()))?.points;
    let row_length = (360.0 / STEP_DEG) as usize;
    let magnitudes: Vec<Vec<Value>> = points
        .chunks(row_length)
        .map(|row| row.iter().map(|point| json!(point.magnitude.map(|magnitude| rounded(magnitude.0, 2)))).collect())
        .collect();
    let edge: Vec<[f64; 2]> = view
        .shadow_edge(EDGE_POINTS)
        .iter()
        .map(|point| [rounded(point.azimuth_rad.to_degrees(), 3), rounded(point.altitude_rad.to_degrees(), 3)])
        .collect();

    let min_altitude_rad = query.number("min_altitude_deg").unwrap_or_default().to_radians();
    let count = if duration_s > 0.0 { TRACK_POINTS } else { 1 };
    let times_s: Vec<f64> = (0..count).map(|number| duration_s * number as f64 / (TRACK_POINTS - 1) as f64).collect();
    let options = SnapshotOptions {
        min_altitude_rad,
        include_dark: state.pass_options(0).include_dark || photometry.band.is_thermal(),
        positions: SnapshotPositions::WholeTrack,
        photometry: Some(photometry),
    };
    let (tracks, left_out) = state.sky().snapshots(start, &times_s, &options)?;
    let caveats = state.caveats_at(start, seconds_after(start, duration_s), &left_out)?;
    let satellites: Vec<Value> = tracks.iter().map(|track| satellite(state, track)).collect();

    let (sun_altitude_deg, sun_azimuth_deg) = degrees(&sun);
    let mut document = Document::with_provenance(&state.provenance());
    document.caveats(&caveats);
    document.value(
        "sun",
        json!({"altitude_deg": rounded(sun_altitude_deg, 4), "azimuth_deg": rounded(sun_azimuth_deg, 4)}),
    );
    document
        .value("map", json!({"model": name, "height_km": height_km, "step_deg": STEP_DEG, "magnitudes": magnitudes}));
    document.value("shadow_edge_deg", json!(edge));
    document.value("satellites", satellites);
    Ok(document.into_json())
}

fn satellite(state: &RequestState, track: &SatelliteTrack) -> Value {
    let degrees = |radians: Option<f64>| rounded(radians.unwrap_or(f64::NAN).to_degrees(), 3);
    let points = || track.snapshots.iter().map(|snapshot| &snapshot.point);
    let track_deg: Vec<[f64; 2]> =
        points().map(|point| [degrees(point.azimuth_rad), degrees(point.altitude_rad)]).collect();
    let brightness = points().filter_map(|point| point.brightness.as_ref());
    let brightest = brightness.min_by(|a, b| a.magnitude.0.total_cmp(&b.magnitude.0));
    json!({
        "norad_id": track.norad_id.0,
        "name": state.sky().elements()[track.element_index].name.as_ref(),
        "magnitude": brightest.map(|brightness| rounded(brightness.magnitude.0, 2)),
        "magnitude_sigma": brightest.map(|brightness| rounded(brightness.sigma_mag, 2)),
        "track_deg": track_deg,
    })
}

pub fn schema() -> Value {
    let directions = json!({
        "type": "array",
        "items": {"type": "array", "items": number_schema(), "minItems": 2, "maxItems": 2},
        "description": "Azimuth from north through east and altitude [deg].",
    });
    let sun = object_schema(&[("altitude_deg", number_schema()), ("azimuth_deg", number_schema())]);
    let magnitudes = json!({
        "type": "array",
        "items": {"type": "array", "items": optional_number_schema()},
        "description": "Rows from the horizon to the zenith, in each the azimuths from 0, every step_deg; null where a satellite is not sunlit [mag].",
    });
    let map = object_schema(&[
        ("model", text_schema()),
        ("height_km", number_schema()),
        ("step_deg", number_schema()),
        ("magnitudes", magnitudes),
    ]);
    let satellite = object_schema(&[
        ("norad_id", json!({"type": "integer"})),
        ("name", text_schema()),
        ("magnitude", optional_number_schema()),
        ("magnitude_sigma", optional_number_schema()),
        ("track_deg", directions.clone()),
    ]);
    document_schema(&[
        ("sun", sun),
        ("map", map),
        ("shadow_edge_deg", directions),
        ("satellites", json!({"type": "array", "items": satellite})),
    ])
}
