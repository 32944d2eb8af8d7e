//! `windows`: lists time windows in which targets can be exposed without a crossing above the limits.

use std::path::{Path, PathBuf};

use crate::arguments::OutputArguments;
use crate::clock::{TONIGHT, set_night};
use anyhow::anyhow;
use clap::Args;
use hifitime::{Epoch, TimeScale, Unit};
use serde_json::json;
use streakcast::config::{
    Config, EXPOSURE, ExposureConfig, FIELD, Quantity, RequiredInput, RulesConfig, SATELLITES, SITE, TimeRangeConfig,
    parse_duration_s, parse_exposure_s,
};
use streakcast::forecast::Night;
use streakcast::frames::{Direction, Gcrs};
use streakcast::input::comments_warning;
use streakcast::message::known_step_s;
use streakcast::message::{Quoted, listed as listed_names};
use streakcast::output::{Column, Kind, Table, Value, counted, format_utc};
use streakcast::passes::Exposure;
use streakcast::schedule::{
    FoundWindows, ListedTarget, SchedulerFormat, WindowReport, WindowRequest, WindowTarget, clear_windows,
    read_targets, window_table, window_target_table,
};

use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::help::{VerbFlags, help};
use crate::local_time::{LocalTime, ZoneArguments};
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct WindowsArguments {
    /// Targets: CSV, ECSV or JSON with columns name, ra_deg, dec_deg, exposure_s (or ra and dec as 12h34m -30d30m)
    #[arg(long, value_name = "FILE")]
    pub targets: Option<PathBuf>,
    /// One target by name: a Messier or Caldwell object, also by NGC or IC number
    #[arg(long, value_name = "NAME", conflicts_with_all = ["targets", "ra", "dec"])]
    pub target: Option<String>,
    /// Right ascension of one target (ICRS): 188.5 (degrees) or 12h34m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, conflicts_with = "targets", requires = "dec")]
    pub ra: Option<Quantity>,
    /// Declination of one target (ICRS): -30.5 or -30d30m
    #[arg(long, value_name = "ANGLE", allow_hyphen_values = true, conflicts_with = "targets", requires = "ra")]
    pub dec: Option<Quantity>,
    #[command(flatten)]
    pub range: TimeRangeConfig,
    /// Exposure time of one target, and of rows that have none, with its unit
    #[arg(long, value_name = "TIME")]
    pub exposure: Option<String>,
    /// Lowest altitude of a target above the horizon of a site while the shutter is open, degrees; 20 if omitted
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub min_altitude: Option<f64>,
    /// Highest altitude of the Sun at a site while the shutter is open, degrees; -12 if omitted
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub max_sun_altitude_deg: Option<f64>,
    /// Time from the start of a request or observing block to its shutter opening, for lco and eso-p2, with its unit
    #[arg(long, value_name = "TIME")]
    pub overhead: Option<String>,
    #[command(flatten)]
    pub zone: ZoneArguments,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

const TARGETS: RequiredInput =
    RequiredInput::new("targets", &[&["--targets FILE"], &["--target NAME"], &["--ra ANGLE", "--dec ANGLE"]]);
const SPAN_IN_ORBIT: RequiredInput = RequiredInput::new("time range", &[&["--start TIME", "--end TIME"]]);

help! {
    WindowsArguments, "windows", asks [TARGETS, SATELLITES, SITE, FIELD],
    "--targets targets.csv --night 2024-08-13 --elements active.tle --mpc X05 --fov 1deg --limit-mag 7",
    "--targets targets.csv --night 2024-08-13 --shells oneweb --mpc X05 --fov 1deg --format astroq"
}

/// Default lowest altitude of targets at a site, degrees.
const LOWEST_TARGET_DEG: f64 = 20.0;
/// Default highest altitude of the Sun at a site, degrees.
const HIGHEST_SUN_DEG: f64 = -12.0;

const ON_SCREEN: &[Shown] = &[
    shown("name", "target"),
    shown("first_start_local", "first start (local)"),
    shown("last_start_local", "last start (local)"),
    rounded("first_start_utc", "first start (UTC)", 0),
    rounded("last_start_utc", "last start (UTC)", 0),
    rounded("length_s", "length s", 1),
    rounded("exposure_s", "exposure s", 1),
    rounded("elements_age_days", "age d", 1),
    rounded("late_s", "late s", 1),
];

pub fn run(typed: WindowsArguments) -> anyhow::Result<Outcome> {
    let mut config = Config { rules: typed.rules, ..typed.config }.with_file()?;
    if typed.target.is_some() || typed.ra.is_some() {
        config.exposure = ExposureConfig { target: typed.target, ra: typed.ra, dec: typed.dec, ..config.exposure };
    }
    let pointing = if typed.targets.is_none() { config.pointing()? } else { None };
    let in_orbit = config.is_in_orbit();
    let [min_altitude_deg, max_sun_altitude_deg] =
        altitudes_deg(in_orbit, typed.min_altitude, typed.max_sun_altitude_deg)?;
    if in_orbit && typed.range.night.is_some() {
        return Err(anyhow!("--night is for a site; allowed for a telescope in orbit: --start TIME and --end TIME"));
    }
    let mut range = if in_orbit { typed.range } else { typed.range.or_night(TONIGHT) };
    let has_exposure = pointing.is_none() || typed.exposure.is_some() || config.exposure.duration.is_some();
    let answers = [
        (&TARGETS, typed.targets.is_some() || pointing.is_some()),
        (&EXPOSURE, has_exposure),
        (&SPAN_IN_ORBIT, !in_orbit || range.start.is_some()),
    ];
    WindowsArguments::HELP.check(&config, &answers)?;
    let shape = typed.output.format.as_deref().and_then(SchedulerFormat::by_name);
    let output = match shape {
        Some(_) => Output::new(Some("json"), typed.output.output.clone())?,
        None => typed.output.clone().open_or(&config, "lco, eso-p2, astroq")?,
    };
    let notices = begin(&config)?;
    let zone = typed.zone.or_of(&config)?;
    if let Some(remark) = set_night(&mut range.night, &config, zone.as_ref())? {
        notices.info(&remark);
    }
    let (from, to) = range.resolve(&config)?;
    let plan = config.observation()?;
    if plan.policy.max_cost_s.is_some() {
        return Err(anyhow!(
            "the policy has max_cost_s, but windows are computed from the times of passes, without the cost of each start; allowed: \
             limit_mag or blocking in place of it, or flag and gate, which compute this cost"
        ));
    }
    let seconds = |what, text: &Option<String>| text.as_deref().map(|text| parse_duration_s(what, text)).transpose();
    let overhead_s = seconds("overhead", &typed.overhead)?.unwrap_or(0.0);
    let exposure = typed.exposure.or(config.exposure.duration.as_ref().map(|exposure| exposure.0.clone()));
    let duration_s = exposure.as_deref().map(parse_exposure_s).transpose()?;
    let (listed, targets_of) = match (&typed.targets, pointing.zip(duration_s)) {
        (Some(path), _) => {
            let list = read_targets(path, duration_s, plan.rotation_rad)?;
            notices.warn(comments_warning(list.comments_like_rows).as_slice());
            notices.warn(&list.warnings);
            warn_invalid(&list.targets, path, &notices)?;
            (list.targets, path.display().to_string())
        }
        (None, Some((pointing, duration_s))) => {
            let name = config.exposure.target.clone().unwrap_or_else(|| "target".to_owned());
            (vec![single_target(&name, pointing, duration_s, plan.rotation_rad)], name)
        }
        (None, None) => (Vec::new(), String::new()),
    };

    let mut prepared = config.prepare(from, to)?;
    notices.warn(&prepared.warnings);
    let targets: Vec<WindowTarget> = listed.iter().filter_map(|target| target.target.clone().ok()).collect();
    let request = WindowRequest {
        conditions: plan.request(&prepared.sky),
        min_altitude_rad: min_altitude_deg.unwrap_or(0.0).to_radians(),
        max_sun_altitude_rad: max_sun_altitude_deg.map(f64::to_radians),
    };
    let bands = targets.iter().map(|target| target.band.as_deref()).collect();
    notices.warn(&plan.policy.band_warnings(&bands));
    let report = clear_windows(&targets, from, to, &request)?;
    notices.warn_left_out(&prepared, &report.left_out, from)?;
    if let Some(site) = prepared.sky.viewpoint().site() {
        let night = Night::over(&prepared.sky, from, to, request.max_sun_altitude_rad)?;
        notices.warn(&night.why_never_dark(&site.site().name));
    }
    let found = found(&listed, &report, in_orbit);
    let without = found.iter().filter(|target| target.listed.target.is_ok()).filter_map(|target| {
        let name = Quoted::new(&target.listed.name);
        let what = if target.windows().is_empty() { " has no window" } else { "" };
        target.reason().map(|reason| format!("target {name}{what}: {reason}"))
    });
    notices.warn_first(without, "targets without a window or with unknown starts");
    config.state_scales(&mut prepared.provenance, &plan.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "targets": targets_of,
            "from_utc": format_utc(from, 3),
            "to_utc": format_utc(to, 3),
            "field": config.stated_field(),
            "telescope": plan.telescope.as_ref().map(|telescope| telescope.name.as_str()),
            "min_altitude_deg": min_altitude_deg,
            "max_sun_altitude_deg": max_sun_altitude_deg,
            "policy": plan.policy,
        }),
    );
    if let Some(shape) = shape {
        let (text, left_out) = shape.text(&found, overhead_s);
        output.write_text(&text, &notices)?;
        if !left_out.is_empty() {
            let names = left_out.iter().map(|listed| listed.name.as_str());
            notices.warn(&[format!(
                "targets without a window are omitted from the file, where no window would mean any time: {}",
                listed_names(names)
            )]);
        }
    } else {
        let mut windows = window_table(&found, &prepared.sky);
        if let Some(zone) = &zone {
            add_local_times(&mut windows, zone);
        }
        output.write(
            &VerbResult::new("windows", &windows, ON_SCREEN, &prepared.provenance)
                .with("targets", &window_target_table(&found))
                .with("left_out", &left_out_table(&report.left_out)),
            &notices,
        )?;
    }
    let count: usize = report.by_target.iter().map(|target| target.windows.len()).sum();
    let invalid = match listed.len() - report.by_target.len() {
        0 => String::new(),
        invalid => format!(" and {}", counted(invalid, "invalid row", "invalid rows")),
    };
    let targets = counted(report.by_target.len(), "target", "targets") + &invalid;
    notices.info(&format!("{targets}: {}", counted(count, "window", "windows")));
    Ok(Outcome::Done)
}

/// Prints warnings about invalid rows.
///
/// # Errors
/// All rows are invalid.
fn warn_invalid(listed: &[ListedTarget], path: &Path, notices: &Notices) -> anyhow::Result<()> {
    let reasons: Vec<String> = listed
        .iter()
        .enumerate()
        .filter_map(|(index, target)| {
            let reason = target.target.as_ref().err()?;
            let place = format!("target list {}, row {}, target", path.display(), index + 1);
            Some(format!("{place} {} is invalid: {reason}", Quoted::new(&target.name)))
        })
        .collect();
    if reasons.len() == listed.len() {
        let (first, others) = (reasons.first().map_or("", String::as_str), reasons.len().saturating_sub(1));
        let others = if others > 0 { format!(" (and all {others} other rows)") } else { String::new() };
        return Err(anyhow!("{first}{others}"));
    }
    notices.warn_first(reasons, "invalid targets in the list");
    Ok(())
}

fn single_target(name: &str, pointing: Direction<Gcrs>, duration_s: f64, rotation_rad: f64) -> ListedTarget {
    // The start is not used: windows are computed for all start times of a range.
    let start = Epoch::from_gregorian_utc_at_midnight(2000, 1, 1);
    let exposure = Exposure { id: name.to_owned(), start, duration_s, pointing, rotation_rad };
    let target = Ok(WindowTarget { exposure, band: None });
    ListedTarget { name: name.to_owned(), unique_id: name.to_owned(), target }
}

/// Adds the columns `first_start_local` and `last_start_local`, rounded to the lateness of the satellites.
fn add_local_times(table: &mut Table, zone: &LocalTime) {
    let at = |name: &str| table.columns.iter().position(|column| column.name == name);
    let (Some(first), Some(last), Some(late)) = (at("first_start_utc"), at("last_start_utc"), at("late_s")) else {
        return;
    };
    for (name, rounded) in [("first_start_local", "up"), ("last_start_local", "down")] {
        let description = match rounded {
            "up" => {
                "The same in local time, rounded up to 1 s, 10 s, 1 min or 10 min, whichever is next above late_s, or to a finer step in a short window."
            }
            _ => "The same in local time, rounded down.",
        };
        table.columns.push(Column::new(name, Kind::Text, description));
    }
    for row in &mut table.rows {
        let local = match (&row[first], &row[last]) {
            (Value::Time(first), Value::Time(last)) => {
                let late_s = if let Value::Real(late_s) = row[late] { late_s } else { f64::NAN };
                local_window(*first, *last, known_step_s(late_s), zone).map(Value::from)
            }
            _ => [Value::Null, Value::Null],
        };
        row.extend(local);
    }
}

/// Returns the ends of a window in local time, rounded inwards to a step in seconds, or to a finer step if the window
/// is shorter.
fn local_window(first: Epoch, last: Epoch, step_s: f64, zone: &LocalTime) -> [String; 2] {
    let inside = |step_s: f64| {
        let step = step_s * Unit::Second;
        [first.to_time_scale(TimeScale::UTC).ceil(step), last.to_time_scale(TimeScale::UTC).floor(step)]
    };
    let is_inside = |step_s: &f64| inside(*step_s)[0] <= inside(*step_s)[1];
    let step_s = [600.0, 60.0, 10.0, 1.0].into_iter().filter(|step| *step <= step_s).find(is_inside);
    step_s.map_or([first, last].map(|epoch| zone.text(epoch, 1.0)), |step_s| {
        inside(step_s).map(|epoch| zone.text(epoch, step_s))
    })
}

/// Pairs every row of the target list with its windows.
fn found<'a>(listed: &'a [ListedTarget], report: &'a WindowReport, is_in_orbit: bool) -> Vec<FoundWindows<'a>> {
    let mut results = report.by_target.iter();
    listed
        .iter()
        .map(|listed| {
            let found = listed.target.as_ref().ok().and_then(|_| results.next());
            FoundWindows { listed, found, is_in_orbit }
        })
        .collect()
}

/// Returns the lowest altitude of targets and the highest of the Sun for a site, degrees; `None` for a telescope in
/// orbit, which has other limits.
fn altitudes_deg(in_orbit: bool, target_deg: Option<f64>, sun_deg: Option<f64>) -> anyhow::Result<[Option<f64>; 2]> {
    let given =
        [("min-altitude", target_deg, "--min-limb-angle"), ("max-sun-altitude-deg", sun_deg, "--min-sun-angle")];
    if in_orbit {
        return match given.iter().find(|(_, angle_deg, _)| angle_deg.is_some()) {
            Some((flag, _, other)) => {
                Err(anyhow!("--{flag} is for a site; allowed for a telescope in orbit: {other} DEG"))
            }
            None => Ok([None, None]),
        };
    }
    let target_deg = in_degrees("min-altitude", target_deg.unwrap_or(LOWEST_TARGET_DEG))?;
    let sun_deg = in_degrees("max-sun-altitude-deg", sun_deg.unwrap_or(HIGHEST_SUN_DEG))?;
    Ok([Some(target_deg), Some(sun_deg)])
}

fn in_degrees(what: &str, angle_deg: f64) -> anyhow::Result<f64> {
    if (-90.0..=90.0).contains(&angle_deg) {
        Ok(angle_deg)
    } else {
        Err(anyhow!("{what} is {angle_deg} deg; allowed: -90 to 90 deg"))
    }
}
