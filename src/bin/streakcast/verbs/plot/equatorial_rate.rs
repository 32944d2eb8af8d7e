//! `plot sky-rate --equatorial`: plots the mean number of streaks per exposure over right ascension and declination,
//! averaged over nights. The module also contains functions shared with the map over a site.

use std::collections::BTreeSet;

use anyhow::{anyhow, bail};
use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::config::{
    Config, EXPOSURE, Quantity, SITE, parse_duration_s, parse_exposure_s, state_scales, time_range,
};
use streakcast::frames::{Direction, Horizontal, seconds_after};
use streakcast::math::healpix::{cell_count, ring_cell, ring_centre_rad};
use streakcast::output::{Column, Kind, Provenance, Table};
use streakcast::passes::CountRequest;
use streakcast::plot::{EquatorialRate, Picture, equatorial_rate};

use super::arguments::PlotSkyRateArguments;
use super::columns::Columns;
use crate::notices::Notices;

const FRAME: &str = "equatorial";
const SHORTEST_STEP_S: f64 = 30.0;
const LONGEST_STEP_S: f64 = 3600.0;
/// Largest number of nights: a leap year.
const MAX_NIGHTS: usize = 366;

const COLUMNS: [Column; 6] = [
    Column::new(
        "healpix_cell",
        Kind::Integer,
        "Cell of right ascension and declination, HEALPix in RING order; the provenance has nside.",
    ),
    Column::real("ra_deg", "deg", 6, "Right ascension of the cell's centre, ICRS."),
    Column::real("dec_deg", "deg", 6, "Declination of the cell's centre, ICRS."),
    Column::new("exposures", Kind::Integer, "Number of exposures averaged."),
    STREAKS,
    BRIGHT,
];

/// Sums over the exposures of one cell.
#[derive(Copy, Clone, Default)]
struct Sum {
    exposures: usize,
    streaks: usize,
    bright: f64,
}

/// Counts the streaks of exposures in every cell of the local sky during the dark hours, and averages the counts in
/// cells of right ascension and declination.
pub fn compute(
    typed: &PlotSkyRateArguments,
    config: &Config,
    directions: &[(u64, Direction<Horizontal>)],
    notices: &Notices,
) -> anyhow::Result<(Table, Provenance)> {
    let exposure = config.exposure.duration.as_ref().map(Quantity::as_str);
    let exposure = exposure.ok_or_else(|| EXPOSURE.missing())?;
    let duration_s = parse_exposure_s(exposure)?;
    let step_s = parse_duration_s("step", &typed.step)?;
    if !(SHORTEST_STEP_S..=LONGEST_STEP_S).contains(&step_s) {
        bail!("step is {}; allowed: 30s to 1h", typed.step);
    }
    if !(-90.0..=90.0).contains(&typed.max_sun_altitude_deg) {
        bail!("max-sun-altitude-deg is {} deg; allowed: -90 to 90 deg", typed.max_sun_altitude_deg);
    }
    let mut nights: Vec<&String> = Vec::new();
    typed.night.iter().for_each(|night| {
        if !nights.contains(&night) {
            nights.push(night)
        }
    });
    if nights.len() > MAX_NIGHTS {
        bail!("--night has {} nights; allowed: 1 to {MAX_NIGHTS}", nights.len());
    }
    let (field, photometry) = (config.field_of_view()?, config.photometry()?);
    let cells: Vec<_> = directions.iter().map(|(_, direction)| *direction).collect();
    let mut sums = vec![Sum::default(); cell_count(typed.nside) as usize];
    let (mut provenance, mut printed) = (None, BTreeSet::new());
    for night in &nights {
        let (from, to) = time_range(Some(night), None, None, config)?;
        let prepared = config.prepare(from, to)?;
        let mut moments: Vec<Epoch> = Vec::new();
        let mut moment = from;
        while moment < to {
            if prepared.sky.sun_altaz(moment)?.altitude_rad <= typed.max_sun_altitude_deg.to_radians() {
                moments.push(moment);
            }
            moment = seconds_after(moment, step_s);
        }
        let request = CountRequest {
            directions: &cells,
            moments: &moments,
            duration_s,
            field: &field,
            photometry,
            limit_mag: typed.limit_mag,
        };
        let counts = prepared.sky.streak_counts(&request)?;
        let observer = prepared.sky.viewpoint().site().ok_or_else(|| SITE.missing())?;
        for (moment, all) in moments.iter().zip(&counts.by_moment) {
            let from_horizon =
                observer.state(&prepared.sky.orientation_over(*moment, *moment).at_s(0.0)).horizon.inverse();
            for (direction, count) in cells.iter().zip(all) {
                let star = from_horizon * *direction;
                let cell = ring_cell(typed.nside, star.longitude_rad(), star.latitude_rad());
                if let Some(sum) = cell.and_then(|cell| sums.get_mut(cell as usize)) {
                    sum.exposures += 1;
                    sum.streaks += count.streaks;
                    sum.bright += count.bright;
                }
            }
        }
        let new: Vec<String> =
            prepared.warnings.iter().filter(|text| printed.insert((*text).clone())).cloned().collect();
        notices.warn(&new);
        if prepared.left_out_warning(&counts.left_out, from)?.is_some_and(|warning| printed.insert(warning)) {
            notices.warn_left_out(&prepared, &counts.left_out, from)?;
        }
        provenance.get_or_insert(prepared.provenance);
    }
    if sums.iter().all(|sum| sum.exposures == 0) {
        bail!(
            "the Sun does not reach altitude {} deg in these nights; allowed: a higher --max-sun-altitude-deg",
            typed.max_sun_altitude_deg
        );
    }
    let mut provenance = provenance.unwrap_or_default();
    state_scales(&mut provenance, "utc", &photometry);
    provenance.state(
        "options",
        json!({
            "frame": FRAME,
            "nights": nights,
            "exposure_s": duration_s,
            "field": config.stated_field(),
            "nside": typed.nside,
            "step_s": step_s,
            "min_altitude_deg": typed.min_altitude,
            "max_sun_altitude_deg": typed.max_sun_altitude_deg,
            "limit_mag": typed.limit_mag,
        }),
    );
    Ok((table(typed.nside, &sums, typed.limit_mag.is_some()), provenance))
}

fn table(nside: u32, sums: &[Sum], has_limit: bool) -> Table {
    let row = |(cell, sum): (usize, &Sum)| {
        let (right_ascension, declination) = ring_centre_rad(nside, cell as u64)?;
        let mean = |count: f64| count / sum.exposures as f64;
        (sum.exposures > 0).then(|| {
            vec![
                (cell as i64).into(),
                right_ascension.to_degrees().into(),
                declination.to_degrees().into(),
                sum.exposures.into(),
                mean(sum.streaks as f64).into(),
                has_limit.then(|| mean(sum.bright)).into(),
            ]
        })
    };
    Table { columns: COLUMNS.to_vec(), rows: sums.iter().enumerate().filter_map(row).collect() }
}

/// Returns true if the table was written by this plot.
pub fn is_of(columns: &Columns) -> bool {
    columns.stated("options").and_then(|options| options.get("frame")).and_then(Value::as_str) == Some(FRAME)
}

pub fn picture(columns: &Columns, title: Option<&str>) -> anyhow::Result<Picture> {
    let rates = Rates::from_columns(columns, "plot sky-rate --equatorial")?;
    let nights = rates.option("nights").and_then(Value::as_array).into_iter().flatten();
    let nights: Vec<&str> = nights.filter_map(Value::as_str).collect();
    let nights = match nights.as_slice() {
        [night] => format!("the night of {night}"),
        [first, .., last] => format!("{} nights from {first} to {last}", nights.len()),
        [] => "nights".to_owned(),
    };
    Ok(equatorial_rate(&EquatorialRate {
        title: title.unwrap_or(&format!("Streaks{} per exposure of {} s", rates.bright, rates.number("exposure_s"))),
        caption: &format!(
            "Site: {}. Means over the hours of {nights} with the Sun below {}° and the cell above {}°, every {:.0} min, HEALPix nside {}.{}",
            rates.site,
            rates.angle("max_sun_altitude_deg", None),
            rates.angle("min_altitude_deg", None),
            rates.number("step_s") / 60.0,
            rates.nside,
            columns.simulation_note()
        ),
        nside: rates.nside,
        cells: &rates.cells,
        rate: &rates.rate,
    })?)
}

pub const STREAKS: Column = Column::real(
    "streaks_per_exposure",
    "",
    5,
    "Mean number of lit satellites that cross the field during an exposure.",
);
pub const BRIGHT: Column = Column::real(
    "bright_per_exposure",
    "",
    5,
    "Mean expected number of these satellites brighter than the limiting magnitude; empty without a limit.",
);

/// Rates read from a table of either sky-rate map.
pub struct Rates {
    pub nside: u32,
    pub cells: Vec<u64>,
    /// Rates of all streaks; if a magnitude limit is given, of brighter streaks.
    pub rate: Vec<f64>,
    /// Part of the title that states the limit, for example ` brighter than 7 mag`; empty without a limit.
    pub bright: String,
    pub site: String,
    options: Value,
}

impl Rates {
    /// Reads a table. `allowed` is the verb that writes such tables, for errors.
    pub fn from_columns(columns: &Columns, allowed: &str) -> anyhow::Result<Self> {
        let options = columns.stated("options").cloned().unwrap_or_default();
        let number = |name: &str| options.get(name).and_then(Value::as_f64);
        let nside = number("nside").ok_or_else(|| missing_statement("nside", allowed))? as u32;
        let limit = number("limit_mag");
        Ok(Self {
            nside,
            cells: columns.numbers("healpix_cell")?.into_iter().map(|cell| cell as u64).collect(),
            rate: columns.numbers(if limit.is_some() { BRIGHT.name } else { STREAKS.name })?,
            bright: limit.map(|limit| format!(" brighter than {limit} mag")).unwrap_or_default(),
            site: columns.observer_name().unwrap_or_default(),
            options,
        })
    }

    /// Returns an option stored in the provenance.
    pub fn option(&self, name: &str) -> Option<&Value> {
        self.options.get(name)
    }

    /// Returns a numeric option; NaN if it is missing.
    pub fn number(&self, name: &str) -> f64 {
        self.option(name).and_then(Value::as_f64).unwrap_or(f64::NAN)
    }

    /// Formats an angle in degrees, with the minus sign U+2212; empty if it is missing.
    pub fn angle(&self, name: &str, decimals: Option<usize>) -> String {
        let Some(angle) = self.option(name).and_then(Value::as_f64) else { return String::new() };
        let text = decimals.map_or_else(|| angle.to_string(), |decimals| format!("{angle:.decimals$}"));
        text.replace('-', "−")
    }
}

/// Returns the error for a table whose provenance lacks a required value.
pub fn missing_statement(what: &str, allowed: &str) -> anyhow::Error {
    anyhow!("the table has no {what}; allowed: data written by {allowed}")
}
