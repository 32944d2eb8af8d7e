//! `/fov/satellite-passes/` and `/fov/satellites-above-horizon/`: compatible with the parameters and responses of IAU
//! CPS SatChecker (version 1.7, docs/source/fov.rst). Magnitudes are added; asynchronous tasks are not supported.

use std::collections::BTreeMap;

use hifitime::{Epoch, TimeScale};
use serde_json::{Value, json};
use streakcast::frames::{Direction, epoch_from_jd, seconds_after, seconds_between};
use streakcast::geometry::{Observer, Site};
use streakcast::orbit::LeftOut;
use streakcast::passes::{Exposure, Field, Pass, PassOptions, Sky, SnapshotOptions, SnapshotPositions};

use super::super::problem::Problem;
use super::super::query::{Kind, Parameter, Query, TRUTH, number, optional, required};
use super::super::state::{Caveats, RequestState};
use super::document::{
    caveat_schemas, count_schema, number_schema, object_schema, optional_number_schema, rounded, text_schema,
};
use super::satchecker_positions::{position, position_schema};

const LATITUDE: Parameter =
    optional("latitude", number(-90.0, 90.0, " deg"), "Latitude of the observer, degrees; required without site.");
const LONGITUDE: Parameter = optional(
    "longitude",
    number(-180.0, 360.0, " deg"),
    "Longitude of the observer, east positive, degrees; required without site.",
);
const ELEVATION: Parameter = optional(
    "elevation",
    number(-11_000.0, 100_000.0, " m"),
    "Height of the observer above the ellipsoid, metres; required without site.",
);
const SITE: Parameter = optional(
    "site",
    Kind::Text { longest: 100 },
    "Name or MPC code of a known site, instead of latitude, longitude and elevation.",
);
const ILLUMINATED: Parameter = optional("illuminated_only", TRUTH, "Only sunlit satellites; default false.");
const CONSTELLATION: Parameter = optional(
    "constellation",
    Kind::Text { longest: 50 },
    "Only satellites with names that begin with this, in upper or lower case.",
);

pub const PASSES: &[Parameter] = &[
    LATITUDE,
    LONGITUDE,
    ELEVATION,
    SITE,
    optional("start_time_jd", Kind::JulianDate, "Start, Julian date (UTC); this or mid_obs_time_jd."),
    optional("mid_obs_time_jd", Kind::JulianDate, "Middle, Julian date (UTC)."),
    required("duration", number(0.0, 3600.0, " s"), "Seconds."),
    required("ra", number(0.0, 360.0, " deg"), "Right ascension of the field's centre, ICRS, degrees."),
    required("dec", number(-90.0, 90.0, " deg"), "Declination of the field's centre, degrees."),
    required("fov_radius", number(0.0001, 45.0, " deg"), "Radius of the circular field, degrees."),
    optional(
        "group_by",
        Kind::Word(&["satellite", "time"]),
        "Positions by satellite, or in order of time; default time.",
    ),
    ILLUMINATED,
    CONSTELLATION,
    optional("data_source", Kind::Word(&["any"]), "Source of the elements: those of the server."),
    optional("include_orbital_data", TRUTH, "Whether the element sets are returned as two lines; default false."),
    optional("async", Kind::Word(&["false", "False"]), "Results are returned directly, never as tasks."),
];

pub const ABOVE: &[Parameter] = &[
    LATITUDE,
    LONGITUDE,
    ELEVATION,
    SITE,
    required("julian_date", Kind::JulianDate, "Time, Julian date (UTC)."),
    optional("min_altitude", number(0.0, 90.0, " deg"), "Lowest altitude, degrees; default 0."),
    optional("min_range", number(0.0, 1_500_000.0, " km"), "Least distance, km; default 0."),
    optional("max_range", number(0.0, 1_500_000.0, " km"), "Greatest distance, km; default 1500000."),
    ILLUMINATED,
    CONSTELLATION,
];

/// Name of the source in every response.
const SOURCE: &str = "streakcast";
/// Largest number of positions in one response.
const MAX_POSITIONS: f64 = 20_000.0;
/// Largest number of points along a pass. SatChecker has one point per second.
const MAX_SAMPLES: usize = 601;

pub fn passes(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let exposure = exposure(query)?;
    let state = &state.at(exposure.start)?;
    let sky = sky(state, query)?;
    let radius_rad = query.number("fov_radius").unwrap_or_default().to_radians();
    let field = Field::circle(2.0 * radius_rad)?;
    let passes_of = |samples: usize| {
        let options = pass_options(state, query, samples);
        let crossings = sky.field_passes(std::slice::from_ref(&exposure), &field, &options);
        let crossings = crossings?;
        let found = crossings.by_exposure.into_iter().flatten();
        let selected = found.filter(|pass| is_of_constellation(&sky, pass.element_index, query));
        Ok::<(Vec<Pass>, Vec<LeftOut>), Problem>((selected.collect(), crossings.left_out))
    };
    // The passes are first computed without points, to check the number of points.
    let (found, left_out) = passes_of(0)?;
    let mut caveats =
        state.caveats_at(exposure.start, seconds_after(exposure.start, exposure.duration_s), &left_out)?;
    // The format has no verdict: without this warning, an empty response for a field below the horizon means a clear
    // one.
    let below = state.prepared().check_altitude_from(sky.viewpoint(), "field", &exposure);
    caveats.warnings.extend(below.err().map(|error| error.to_string()));
    let expected: f64 = found.iter().map(|pass| length_s(pass).ceil().min(MAX_SAMPLES as f64) + 1.0).sum();
    if expected > MAX_POSITIONS {
        let detail = format!(
            "the response would have {expected} positions; allowed: at most {MAX_POSITIONS}, with a shorter duration or a smaller fov_radius"
        );
        return Err(Problem::new(400, detail));
    }
    let longest_s = found.iter().map(length_s).fold(0.0, f64::max);
    let samples = (longest_s.ceil() as usize + 1).clamp(2, MAX_SAMPLES);
    let (found, _) = passes_of(samples)?;
    let with_elements = query.truth("include_orbital_data").unwrap_or(false);
    let document = if query.text("group_by") == Some("satellite") {
        by_satellite(&sky, &exposure, &found, with_elements)
    } else {
        by_time(&sky, &exposure, &found, with_elements)
    };
    Ok(with_source(document, &caveats))
}

/// Returns time interval and direction of the query as an exposure.
fn exposure(query: &Query) -> Result<Exposure, Problem> {
    let number = |name: &str| query.number(name).unwrap_or_default();
    let duration_s = number("duration");
    let start = match (query.number("start_time_jd"), query.number("mid_obs_time_jd")) {
        (Some(jd), None) => moment(jd)?,
        (None, Some(jd)) => seconds_after(moment(jd)?, -0.5 * duration_s),
        (None, None) => return Err(Problem::missing("start_time_jd", "start_time_jd or mid_obs_time_jd, one of them")),
        (Some(_), Some(_)) => return Err(Problem::both("start_time_jd", "mid_obs_time_jd")),
    };
    Ok(Exposure {
        id: "fov".to_owned(),
        start,
        duration_s,
        pointing: Direction::from_lon_lat_rad(number("ra").to_radians(), number("dec").to_radians()),
        rotation_rad: 0.0,
    })
}

fn pass_options(state: &RequestState, query: &Query, samples: usize) -> PassOptions {
    PassOptions {
        include_dark: !query.truth("illuminated_only").unwrap_or(false),
        min_probability: None,
        samples,
        photometry: state.plan.photometry,
        ..PassOptions::default()
    }
}

fn length_s(pass: &Pass) -> f64 {
    seconds_between(pass.enter.epoch, pass.exit.epoch)
}

/// Returns the positions of a pass with their times, at most a second apart.
fn positions(sky: &Sky, exposure: &Exposure, pass: &Pass) -> Vec<(Epoch, Value)> {
    let last = pass.samples.len().saturating_sub(1);
    // Every `step`-th of the evenly spaced points is used.
    let step =
        if length_s(pass) > 0.0 { (last as f64 / length_s(pass)).floor().max(1.0) as usize } else { last.max(1) };
    let kept = pass.samples.iter().enumerate().filter(|(point, _)| point % step == 0 || *point == last);
    kept.map(|(_, point)| {
        let mut value = position(sky, pass.element_index, point, pass.element_age_days);
        let angle_rad = point.direction.separation_rad(&exposure.pointing);
        value["angle"] = json!(rounded(angle_rad.to_degrees(), 8));
        (point.epoch, value)
    })
    .collect()
}

/// Returns the positions and streaks of each satellite, by name.
fn by_satellite(sky: &Sky, exposure: &Exposure, passes: &[Pass], with_elements: bool) -> Value {
    let mut satellites: BTreeMap<String, Value> = BTreeMap::new();
    let mut count = 0;
    for pass in passes {
        let elements = &sky.elements()[pass.element_index];
        let key = format!("{} ({})", elements.name, elements.norad_id);
        // A satellite may have several passes.
        let satellite = satellites.entry(key).or_insert_with(|| {
            let mut satellite =
                json!({"name": elements.name.as_ref(), "norad_id": elements.norad_id.0, "positions": [], "streaks": []});
            if with_elements {
                satellite["orbital_data"] = orbital_data(sky, pass.element_index);
            }
            satellite
        });
        let positions = positions(sky, exposure, pass);
        count += positions.len();
        if let Some(list) = satellite["positions"].as_array_mut() {
            list.extend(positions.into_iter().map(|(_, value)| value));
        }
        if let Some(list) = satellite["streaks"].as_array_mut() {
            list.push(streak(pass));
        }
    }
    let total = satellites.len();
    json!({"data": {"satellites": satellites, "total_satellites": total, "total_position_results": count}})
}

/// Returns the positions of all satellites in time order.
fn by_time(sky: &Sky, exposure: &Exposure, passes: &[Pass], with_elements: bool) -> Value {
    let mut all = Vec::new();
    for pass in passes {
        let elements = &sky.elements()[pass.element_index];
        for (epoch, mut value) in positions(sky, exposure, pass) {
            value["name"] = json!(elements.name.as_ref());
            value["norad_id"] = json!(elements.norad_id.0);
            if with_elements {
                value["orbital_data"] = orbital_data(sky, pass.element_index);
            }
            all.push((epoch, value));
        }
    }
    all.sort_by_key(|(epoch, _)| *epoch);
    listed(all.into_iter().map(|(_, value)| value).collect())
}

pub fn above(state: &RequestState, query: &Query) -> Result<String, Problem> {
    let at = moment(query.number("julian_date").unwrap_or_default())?;
    let state = &state.at(at)?;
    let sky = sky(state, query)?;
    let options = SnapshotOptions {
        min_altitude_rad: query.number("min_altitude").unwrap_or_default().to_radians(),
        include_dark: !query.truth("illuminated_only").unwrap_or(false),
        positions: SnapshotPositions::Predicted,
        photometry: Some(state.plan.photometry),
    };
    let (tracks, left_out) = sky.snapshots(at, &[0.0], &options)?;
    let caveats = state.caveats_at(at, at, &left_out)?;
    let ranges = query.number("min_range").unwrap_or(0.0)..=query.number("max_range").unwrap_or(1_500_000.0);
    let data: Vec<Value> = tracks
        .iter()
        .filter(|track| is_of_constellation(&sky, track.element_index, query))
        .filter_map(|track| {
            let point = track.snapshots.first().map(|snapshot| &snapshot.point);
            let point = point.filter(|point| ranges.contains(&point.range_km))?;
            let elements = &sky.elements()[track.element_index];
            let age_days = seconds_between(elements.epoch, at) / 86_400.0;
            let mut value = position(&sky, track.element_index, point, age_days);
            value["name"] = json!(elements.name.as_ref());
            value["norad_id"] = json!(elements.norad_id.0);
            value["range"] = value["range_km"].clone();
            Some(value)
        })
        .collect();
    Ok(with_source(listed(data), &caveats))
}

fn listed(data: Vec<Value>) -> Value {
    let count = data.len();
    json!({"data": data, "count": count, "total_position_results": count})
}

/// Adds the last members of SatChecker's responses, and the warnings.
fn with_source(mut document: Value, caveats: &Caveats) -> String {
    document["source"] = json!(SOURCE);
    document["version"] = json!(env!("CARGO_PKG_VERSION"));
    document["warnings"] = json!(caveats.warnings);
    document["left_out_count"] = json!(caveats.left_out_count);
    document.to_string()
}

/// Returns the sky with the satellites of the server for the site of the query.
fn sky(state: &RequestState, query: &Query) -> Result<Sky, Problem> {
    let numbers = ["latitude", "longitude", "elevation"].map(|name| query.number(name));
    let site = match (query.text("site"), numbers) {
        (Some(name), [None, None, None]) => Site::by_name(name)?,
        (None, [Some(latitude), Some(longitude), Some(elevation)]) => {
            Site::new_deg("observer", latitude, longitude, elevation)?
        }
        (Some(_), _) => {
            return Err(Problem::parameter("site", "with coordinates", "site, or latitude, longitude and elevation"));
        }
        _ => return Err(Problem::missing("site", "site, or latitude, longitude and elevation")),
    };
    Ok(state.sky().seen_from(Observer::new(site)))
}

fn moment(jd: f64) -> Result<Epoch, Problem> {
    epoch_from_jd(jd, TimeScale::UTC).map_err(|error| Problem::new(400, error.to_string()))
}

fn is_of_constellation(sky: &Sky, element_index: usize, query: &Query) -> bool {
    let Some(prefix) = query.text("constellation") else { return true };
    sky.elements()[element_index].name.to_lowercase().starts_with(&prefix.to_lowercase())
}

fn orbital_data(sky: &Sky, element_index: usize) -> Value {
    match streakcast::elements::format_tle(&sky.elements()[element_index]) {
        Ok([line1, line2]) => json!({"tle_line1": line1, "tle_line2": line2}),
        // The values do not fit the columns of a TLE.
        Err(error) => json!({"error": error.to_string()}),
    }
}

/// Returns the streak of a pass; SatChecker has only single points.
fn streak(pass: &Pass) -> Value {
    let utc = |epoch| streakcast::output::format_utc(epoch, 3);
    let peak = pass.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
    json!({
        "enter_utc": utc(pass.enter.epoch),
        "exit_utc": utc(pass.exit.epoch),
        "streak_length_deg": rounded(pass.streak_length_rad.to_degrees(), 6),
        "position_angle_deg": rounded(pass.position_angle_rad.to_degrees(), 4),
        "angular_rate_deg_s": rounded(pass.angular_rate_rad_s.to_degrees(), 6),
        "magnitude_peak": peak.map(|brightness| rounded(brightness.magnitude.0, 3)),
        "probability": rounded(pass.probability, 4),
    })
}

pub fn passes_schema() -> Value {
    let streak = object_schema(&[
        ("enter_utc", text_schema()),
        ("exit_utc", text_schema()),
        ("streak_length_deg", number_schema()),
        ("position_angle_deg", number_schema()),
        ("angular_rate_deg_s", number_schema()),
        ("magnitude_peak", optional_number_schema()),
        ("probability", number_schema()),
    ]);
    let orbital = json!({"type": "object", "additionalProperties": text_schema()});
    let mut satellite = object_schema(&[
        ("name", text_schema()),
        ("norad_id", json!({"type": "integer"})),
        ("positions", json!({"type": "array", "items": position_schema(&["angle"])})),
        ("streaks", json!({"type": "array", "items": streak})),
    ]);
    satellite["properties"]["orbital_data"] = orbital.clone();
    let grouped = object_schema(&[
        ("satellites", json!({"type": "object", "additionalProperties": satellite})),
        ("total_satellites", count_schema()),
        ("total_position_results", count_schema()),
    ]);
    let mut each = position_schema(&["angle", "name", "norad_id"]);
    each["properties"]["orbital_data"] = orbital;
    json!({"oneOf": [with_source_schema(&[("data", grouped)]), listed_schema(each)]})
}

pub fn above_schema() -> Value {
    listed_schema(position_schema(&["name", "norad_id", "range"]))
}

fn listed_schema(item: Value) -> Value {
    with_source_schema(&[
        ("data", json!({"type": "array", "items": item})),
        ("count", count_schema()),
        ("total_position_results", count_schema()),
    ])
}

fn with_source_schema(members: &[(&str, Value)]) -> Value {
    let ends = [("source", text_schema()), ("version", text_schema())];
    object_schema(&[members, &ends, &caveat_schemas()].concat())
}
