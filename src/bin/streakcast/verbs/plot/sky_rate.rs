//! `plot sky-rate`: plots the expected number of streaks per exposure over the sky of a site at one time.

use anyhow::{anyhow, bail};
use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::config::{
    Config, EXPOSURE, ExposureConfig, FIELD, PreparedSky, SATELLITES, SITE, START, parse_duration_s, parse_exposure_s,
};
use streakcast::frames::parse_moment;
use streakcast::frames::{Direction, Horizontal, mjd_utc, seconds_after};
use streakcast::math::healpix::{cell_count, ring_centre_rad};
use streakcast::output::{Column, Kind, Table, format_utc};
use streakcast::passes::{CountRequest, Counts, StreakCount};
use streakcast::plot::{Picture, SkyRate, sky_rate};

use super::arguments::PlotSkyRateArguments;
use crate::failure::Outcome;
use crate::help::check;
use crate::start::begin;

use super::columns::Columns;
use super::equatorial_rate;
use super::equatorial_rate::{BRIGHT, Rates, STREAKS, missing_statement};
use super::target::{self, Target};

/// Verb that writes the tables of this map, for errors.
const WRITER: &str = "plot sky-rate";
const MAX_NSIDE: u32 = 64;
const MAX_REPEATS: usize = 1000;
const LONGEST_S: f64 = 6.0 * 3600.0;

const COLUMNS: [Column; 6] = [
    Column::new(
        "healpix_cell",
        Kind::Integer,
        "Cell of azimuth and altitude, HEALPix in RING order; the provenance has nside.",
    ),
    Column::real("azimuth_deg", "deg", 6, "Azimuth of the cell's centre from north through east."),
    Column::real("altitude_deg", "deg", 6, "Altitude of the cell's centre without refraction."),
    Column::new("exposures", Kind::Integer, "Number of exposures averaged."),
    STREAKS,
    BRIGHT,
];

pub fn run(mut typed: PlotSkyRateArguments) -> anyhow::Result<Outcome> {
    let exposure =
        ExposureConfig { start: typed.start.clone(), duration: typed.exposure.clone(), ..ExposureConfig::default() };
    let config = Config { exposure, ..typed.config.clone() }.with_file()?;
    let notices = begin(&config)?;
    let title = typed.title.title.as_deref();
    if let Some(path) = &typed.from {
        let target = Target::of_table(&typed.picture)?;
        let columns = Columns::read(path, "directions")?;
        let drawn = match equatorial_rate::is_of(&columns) {
            true => equatorial_rate::picture(&columns, title)?,
            false => picture(&columns, title)?,
        };
        target.write_picture(&drawn, &columns.provenance(), &notices)?;
        return Ok(Outcome::Done);
    }
    let times = if typed.equatorial { &[][..] } else { &[&START, &EXPOSURE] };
    check(&config, &[&[&SATELLITES, &SITE, &FIELD], times].concat(), &[target::picture(&typed.picture)])?;
    typed.limit_mag = typed.limit_mag.or(config.limit_mag()?);
    let target = Target::new(&typed.picture)?;
    if !(1..=MAX_NSIDE).contains(&typed.nside) || !typed.nside.is_power_of_two() {
        bail!("nside is {}; allowed: 1, 2, 4, 8, 16, 32, 64", typed.nside);
    }
    if !(1..=MAX_REPEATS).contains(&typed.repeats) {
        bail!("repeats is {}; allowed: 1 to {MAX_REPEATS}", typed.repeats);
    }
    let directions = cells_above(typed.nside, typed.min_altitude)?;
    if typed.equatorial {
        let (table, provenance) = equatorial_rate::compute(&typed, &config, &directions, &notices)?;
        let drawn = equatorial_rate::picture(&Columns::from_table(&table, &provenance), title)?;
        target.write(&drawn, "directions", &table, &provenance, &notices)?;
        return Ok(Outcome::Done);
    }
    let over_s = parse_duration_s("over", &typed.over)?;
    if over_s > LONGEST_S {
        bail!("over is {}; allowed: at most 6h", typed.over);
    }
    let (start, duration_s) = start_and_length(&config)?;
    let field = config.field_of_view()?;
    let prepared = config.prepare(start, seconds_after(start, 86_400.0))?;
    let moment = match typed.sun_altitude_deg {
        None => start,
        Some(altitude) => sun_at(&prepared, altitude, start)?,
    };
    notices.warn(&prepared.warnings);
    let middle = |index: usize| ((index as f64 + 0.5) / typed.repeats as f64 - 0.5) * over_s;
    let moments: Vec<Epoch> = (0..typed.repeats).map(|index| seconds_after(moment, middle(index))).collect();
    let cells: Vec<_> = directions.iter().map(|(_, direction)| *direction).collect();
    let photometry = config.photometry()?;
    let request = CountRequest {
        directions: &cells,
        moments: &moments,
        duration_s,
        field: &field,
        photometry,
        limit_mag: typed.limit_mag,
    };
    let counts = prepared.sky.streak_counts(&request)?;
    notices.warn_left_out(&prepared, &counts.left_out, moment)?;
    let table = table(&directions, &counts, typed.limit_mag.is_some());
    let sun = prepared.sky.sun_altaz(moment)?;
    let mut provenance = prepared.provenance;
    streakcast::config::state_scales(&mut provenance, "utc", &photometry);
    provenance.state(
        "options",
        json!({
            "moment_utc": format_utc(moment, 3),
            "exposure_s": duration_s,
            "field": config.stated_field(),
            "nside": typed.nside,
            "repeats": typed.repeats,
            "over_s": over_s,
            "min_altitude_deg": typed.min_altitude,
            "limit_mag": typed.limit_mag,
            "sun_altitude_deg": (sun.altitude_rad.to_degrees() * 1e4).round() / 1e4,
            "sun_azimuth_deg": (sun.azimuth_rad.to_degrees() * 1e4).round() / 1e4,
        }),
    );
    let picture = picture(&Columns::from_table(&table, &provenance), title)?;
    target.write(&picture, "directions", &table, &provenance, &notices)?;
    Ok(Outcome::Done)
}

/// Returns start and exposure time for the exposures of a grid.
pub fn start_and_length(config: &Config) -> anyhow::Result<(Epoch, f64)> {
    let ExposureConfig { start, duration, .. } = &config.exposure;
    let start = start.as_ref().ok_or_else(|| START.missing())?;
    let start = parse_moment(start.as_str(), config.time_scale()?)?;
    let duration = duration.as_ref().ok_or_else(|| EXPOSURE.missing())?;
    Ok((start, parse_exposure_s(duration.as_str())?))
}

/// Returns the HEALPix cells whose centres are at or above an altitude in degrees.
pub fn cells_above(nside: u32, least_deg: f64) -> anyhow::Result<Vec<(u64, Direction<Horizontal>)>> {
    if !(0.0..=80.0).contains(&least_deg) {
        bail!("min-altitude is {least_deg} deg; allowed: 0 to 80 deg");
    }
    let centres = (0..cell_count(nside)).filter_map(|cell| Some((cell, ring_centre_rad(nside, cell)?)));
    let above = centres.filter(|(_, (_, altitude))| *altitude >= least_deg.to_radians());
    let cells: Vec<_> =
        above.map(|(cell, (azimuth, altitude))| (cell, Direction::from_lon_lat_rad(azimuth, altitude))).collect();
    if cells.is_empty() {
        bail!(
            "no cell of nside {nside} has its centre above {least_deg} deg; allowed: a lower --min-altitude or a larger --nside"
        );
    }
    Ok(cells)
}

fn sun_at(prepared: &PreparedSky, altitude_deg: f64, start: Epoch) -> anyhow::Result<Epoch> {
    if !(-90.0..=90.0).contains(&altitude_deg) {
        bail!("sun-altitude-deg is {altitude_deg} deg; allowed: -90 to 90 deg");
    }
    prepared.sky.sun_reaches(altitude_deg.to_radians(), start)?.ok_or_else(|| {
        anyhow!("the Sun does not reach altitude {altitude_deg} deg within a day after {}; allowed: an altitude that it reaches", format_utc(start, 0))
    })
}

fn table(directions: &[(u64, Direction<Horizontal>)], counts: &Counts, has_limit: bool) -> Table {
    let n = counts.by_moment.len();
    let mean = |index: usize, of: fn(&StreakCount) -> f64| {
        counts.by_moment.iter().fold(0.0, |sum, all| sum + of(&all[index])) / n as f64
    };
    let row = |(index, (cell, direction)): (usize, &(u64, Direction<Horizontal>))| {
        vec![
            (*cell as i64).into(),
            direction.longitude_rad().to_degrees().into(),
            direction.latitude_rad().to_degrees().into(),
            n.into(),
            mean(index, |count| count.streaks as f64).into(),
            has_limit.then(|| mean(index, |count| count.bright)).into(),
        ]
    };
    Table { columns: COLUMNS.to_vec(), rows: directions.iter().enumerate().map(row).collect() }
}

fn picture(columns: &Columns, title: Option<&str>) -> anyhow::Result<Picture> {
    let rates = Rates::from_columns(columns, WRITER)?;
    let sun_azimuth_deg = rates.number("sun_azimuth_deg");
    if !sun_azimuth_deg.is_finite() {
        return Err(missing_statement("Sun's azimuth", WRITER));
    }
    let field = match rates.option("field").and_then(|field| field.get("circle")).and_then(Value::as_str) {
        Some(circle) => format!(", field {circle}"),
        None => String::new(),
    };
    let sun = rates.angle("sun_altitude_deg", Some(1));
    let moment = rates.option("moment_utc").and_then(Value::as_str).and_then(|utc| parse_moment(utc, None).ok());
    let half_days = rates.number("over_s") / 2.0 / 86_400.0;
    let range = moment.map(|moment| [mjd_utc(moment) - half_days, mjd_utc(moment) + half_days]);
    Ok(sky_rate(&SkyRate {
        title: title.unwrap_or(&format!(
            "Streaks{} per exposure of {} s{field}",
            rates.bright,
            rates.number("exposure_s")
        )),
        subtitle: &columns.place_and_time(range.into_iter().flatten()),
        caption: &format!(
            "Sun at altitude {sun}°, azimuth {}°. Means of {} exposures over {:.0} min in HEALPix cells, nside {}.{}",
            rates.angle("sun_azimuth_deg", Some(1)),
            rates.number("repeats"),
            rates.number("over_s") / 60.0,
            rates.nside,
            columns.simulation_note()
        ),
        nside: rates.nside,
        cells: &rates.cells,
        rate: &rates.rate,
        sun_azimuth_deg,
    })?)
}
