//! `plot sun-altitude`: plots trails per exposure against the Sun's altitude, for a schedule or a grid over the sky.

use anyhow::bail;
use hifitime::Epoch;
use serde_json::{Value, json};
use streakcast::config::{
    Config, EXPOSURE, ExposureConfig, FIELD, SATELLITES, SITE, START, parse_duration_s, state_scales,
};
use streakcast::frames::seconds_after;
use streakcast::output::{Column, Kind, Provenance, Table};
use streakcast::passes::CountRequest;
use streakcast::plot::{Picture, SunAltitude, sun_altitude};

use super::arguments::PlotSunAltitudeArguments;
use crate::failure::Outcome;
use crate::help::check;
use crate::notices::Notices;
use crate::start::begin;
use crate::verbs::map::site_of;

use super::columns::Columns;
use super::exposures::compute;
use super::sky_rate::{cells_above, start_and_length};
use super::target::{self, Target};

/// HEALPix resolution of the grid. Cells are 14.7° wide, and 48 cells are above 30°.
const NSIDE: u32 = 4;
const DAY_S: f64 = 86_400.0;
const SHORTEST_STEP_S: f64 = 30.0;

const COLUMNS: [Column; 6] = [
    Column::time("start_utc", "Shutter opening."),
    Column::real("azimuth_deg", "deg", 6, "Azimuth of the field's centre from north through east."),
    Column::real("altitude_deg", "deg", 6, "Altitude of the field's centre without refraction."),
    Column::new("n_streaks", Kind::Integer, "Number of lit satellites that cross the field."),
    Column::real(
        "n_bright",
        "",
        3,
        "Expected number of these satellites brighter than the limiting magnitude; empty without a limit.",
    ),
    Column::real("sun_altitude_deg", "deg", 4, "Altitude of the Sun's centre in the middle of the exposure."),
];

pub fn run(typed: PlotSunAltitudeArguments) -> anyhow::Result<Outcome> {
    let exposure =
        ExposureConfig { start: typed.start.clone(), duration: typed.exposure.clone(), ..ExposureConfig::default() };
    let flags = Config { exposure, rules: typed.rules.clone(), ..typed.config.clone() }.with_configuration_file()?;
    let limit_of = |config: &Config| -> anyhow::Result<Option<f64>> {
        Ok(config.policy()?.limit_mag.and_then(|limit| limit.limit_in(config.light.band.as_deref())))
    };
    let of_flags = limit_of(&flags)?;
    let config = flags.with_home_file()?;
    let title = typed.title.title.as_deref();
    let limit = limit_of(&config)?;
    if let Some(path) = &typed.from {
        let notices = begin(&config)?;
        let target = Target::of_table(&typed.picture)?;
        let columns = Columns::read(path, "exposures")?;
        let stored = columns.limit_mag();
        if let Some(limit) = of_flags.filter(|limit| Some(*limit) != stored) {
            let allowed =
                stored.map_or("no limit".to_owned(), |stored| format!("{stored}, that of the counts in the data"));
            bail!("limit-mag is {limit} mag; allowed with these data: {allowed}");
        }
        let limit = stored;
        let drawn = picture(&columns, limit, typed.bin, title)?;
        target.write_picture(&drawn, &columns.provenance(), &notices)?;
        return Ok(Outcome::Done);
    }
    let times = if typed.schedule.is_some() { &[][..] } else { &[&START, &EXPOSURE] };
    check(&config, &[&[&SATELLITES, &SITE, &FIELD], times].concat(), &[target::picture(&typed.picture)])?;
    let target = Target::new(&typed.picture)?;
    let (table, provenance) = match &typed.schedule {
        Some(schedule) => {
            let site = site_of(&config)?.ok_or_else(|| SITE.missing())?;
            let exposures = compute(&config, schedule, Some(&site), &config.eop_table()?)?;
            (exposures.table, exposures.provenance)
        }
        None => grid(&typed, &config, limit)?,
    };
    let picture = picture(&Columns::from_table(&table, &provenance), limit, typed.bin, title)?;
    target.write(&picture, "exposures", &table, &provenance, &Notices::from_config(&config))?;
    Ok(Outcome::Done)
}

/// Computes exposures on a grid over the sky, at equal time steps during a day while the Sun is below the limit.
fn grid(typed: &PlotSunAltitudeArguments, config: &Config, limit: Option<f64>) -> anyhow::Result<(Table, Provenance)> {
    let notices = begin(config)?;
    let (start, duration_s) = start_and_length(config)?;
    let step_s = parse_duration_s("step", &typed.step)?;
    if !(SHORTEST_STEP_S..=DAY_S).contains(&step_s) {
        bail!("step is {}; allowed: 30s to 24h", typed.step);
    }
    let field = config.field_of_view()?;
    let prepared = config.prepare(start, seconds_after(start, DAY_S))?;
    notices.warn(&prepared.warnings);
    let mut moments: Vec<Epoch> = Vec::new();
    for step in 0..(DAY_S / step_s).ceil() as usize {
        let moment = seconds_after(start, step as f64 * step_s);
        let middle = seconds_after(moment, duration_s / 2.0);
        if prepared.sky.sun_altaz(middle)?.altitude_rad <= typed.max_sun_altitude_deg.to_radians() {
            moments.push(moment);
        }
    }
    if moments.is_empty() {
        bail!(
            "the Sun does not go below {} deg within a day after the start; allowed: a higher --max-sun-altitude-deg",
            typed.max_sun_altitude_deg
        );
    }
    let cells = cells_above(NSIDE, typed.min_altitude)?;
    let directions: Vec<_> = cells.iter().map(|(_, direction)| *direction).collect();
    let photometry = config.photometry()?;
    let request = CountRequest {
        directions: &directions,
        moments: &moments,
        duration_s,
        field: &field,
        photometry,
        limit_mag: limit,
    };
    let counts = prepared.sky.streak_counts(&request)?;
    notices.warn_left_out(&prepared, &counts.left_out, start)?;
    let mut rows = Vec::new();
    for ((moment, all), sun) in moments.iter().zip(&counts.by_moment).zip(&counts.sun) {
        for (direction, count) in directions.iter().zip(all) {
            rows.push(vec![
                (*moment).into(),
                direction.longitude_rad().to_degrees().into(),
                direction.latitude_rad().to_degrees().into(),
                count.streaks.into(),
                limit.map(|_| count.bright).into(),
                sun.altitude_rad.to_degrees().into(),
            ]);
        }
    }
    let mut provenance = prepared.provenance;
    state_scales(&mut provenance, "utc", &photometry);
    provenance.state(
        "options",
        json!({
            "exposure_s": duration_s,
            "field": config.stated_field(),
            "nside": NSIDE,
            "step_s": step_s,
            "min_altitude_deg": typed.min_altitude,
            "max_sun_altitude_deg": typed.max_sun_altitude_deg,
            "limit_mag": limit,
        }),
    );
    Ok((Table { columns: COLUMNS.to_vec(), rows }, provenance))
}

/// Returns the sentence of the caption about the exposures of a grid; `None` for those of a schedule.
fn grid_caption(columns: &Columns) -> Option<String> {
    let options = columns.stated("options")?;
    let number = |name: &str| options.get(name).and_then(Value::as_f64);
    let (duration_s, least_deg, step_s) = (number("exposure_s")?, number("min_altitude_deg")?, number("step_s")?);
    let step_min = step_s / 60.0;
    Some(format!("Exposures of {duration_s} s evenly over the sky above {least_deg}°, every {step_min:.0} min."))
}

fn picture(columns: &Columns, limit: Option<f64>, bin_deg: f64, title: Option<&str>) -> anyhow::Result<Picture> {
    let (sun, streaks, bright) =
        (columns.numbers("sun_altitude_deg")?, columns.numbers("n_streaks")?, columns.numbers("n_bright")?);
    // Invalid rows have neither streaks nor an altitude of the Sun.
    let kept: Vec<usize> = (0..columns.len()).filter(|&k| sun[k].is_finite() && streaks[k].is_finite()).collect();
    let of = |column: &[f64]| kept.iter().map(|&k| column[k]).collect::<Vec<f64>>();
    let (sun, streaks, bright) = (of(&sun), of(&streaks), of(&bright));
    let has_bright = limit.is_some() && bright.iter().all(|count| count.is_finite());
    let caption = format!("{}{}", grid_caption(columns).unwrap_or_default(), columns.simulation_note());
    let starts = columns.moments("start_utc")?;
    let subtitle = columns.place_and_time(kept.iter().map(|&k| starts[k]));
    let drawn = sun_altitude(&SunAltitude {
        title: title.unwrap_or("Trails per exposure"),
        caption: caption.trim_start(),
        sun_altitude_deg: &sun,
        n_trails: &streaks,
        n_bright: limit.filter(|_| has_bright).map(|limit| (bright.as_slice(), limit)),
        bin_deg,
    })?;
    Ok(drawn.with_subtitle(&subtitle))
}
