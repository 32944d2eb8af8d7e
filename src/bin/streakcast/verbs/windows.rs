//! `windows`: lists time windows in which targets can be exposed without a crossing above the limits.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::clock::set_tonight;
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use streakcast::config::parse_duration_s;
use streakcast::config::{Config, RulesConfig, state_scales, time_range};
use streakcast::forecast::Night;
use streakcast::message::{Quoted, listed as listed_names};
use streakcast::output::{Section, counted, format_utc};
use streakcast::schedule::{
    FoundWindows, ListedTarget, SchedulerFormat, WindowReport, WindowRequest, WindowTarget, clear_windows,
    read_targets, window_table, window_target_table,
};

use super::passes::left_out_table;
use super::schedule_verdicts::given_field;
use crate::failure::Outcome;
use crate::output::{FORMATS, Output, VerbResult};
use crate::required::Required;
use crate::screen::{Shown, Style, rounded, shown};
use crate::start::begin;

#[derive(Args)]
pub struct WindowsArguments {
    /// Targets: CSV, ECSV or JSON with columns name, ra_deg, dec_deg, exposure_s (or ra and dec as 12h34m -30d30m)
    #[arg(long, value_name = "FILE")]
    pub targets: Option<PathBuf>,
    /// Night that begins on this evening, local date of the site, for example 2024-08-14; or tonight
    #[arg(long, value_name = "DATE", conflicts_with_all = ["start", "end"])]
    pub night: Option<String>,
    /// Earliest shutter opening, for example 2024-08-14T23:30:00Z
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "end")]
    pub start: Option<String>,
    /// Latest shutter opening
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, requires = "start")]
    pub end: Option<String>,
    /// Exposure time for rows that have none, with its unit
    #[arg(long, value_name = "TIME")]
    pub exposure: Option<String>,
    /// Lowest altitude of a target while the shutter is open, degrees
    #[arg(long, value_name = "DEG", default_value_t = 20.0, allow_hyphen_values = true)]
    pub min_altitude: f64,
    /// Highest altitude of the Sun while the shutter is open, degrees
    #[arg(long, value_name = "DEG", default_value_t = -12.0, allow_hyphen_values = true)]
    pub max_sun_altitude_deg: f64,
    /// Time from the start of a request or observing block to its shutter opening, for lco and eso-p2, with its unit
    #[arg(long, value_name = "TIME")]
    pub overhead: Option<String>,
    #[command(flatten)]
    pub rules: RulesConfig,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

const ON_SCREEN: &[Shown] = &[
    shown("name", "target"),
    rounded("first_start_utc", "first start (UTC)", 0),
    rounded("last_start_utc", "last start (UTC)", 0),
    rounded("length_s", "length s", 1),
    rounded("exposure_s", "exposure s", 1),
];

pub fn run(mut typed: WindowsArguments) -> anyhow::Result<Outcome> {
    let config = Config { rules: typed.rules, ..typed.config }.with_file()?;
    let has_range = typed.night.is_some() || typed.start.is_some();
    Required::of(&config)
        .input(typed.targets.is_some(), "targets", "--targets FILE")
        .input(has_range, "time range", "--night DATE, or --start TIME and --end TIME")
        .satellites()
        .site()
        .field()
        .check()?;
    let path = typed.targets.unwrap_or_default();
    let shape = typed.output.format.as_deref().and_then(SchedulerFormat::by_name);
    let output = match shape {
        Some(_) => Output::new(Some("json"), typed.output.output.clone())?,
        None => Output::new(typed.output.format.as_deref().or(config.format.as_deref()), typed.output.output.clone())
            .map_err(|error| {
            anyhow!("{}", error.to_string().replace(FORMATS, &format!("{FORMATS}, lco, eso-p2, astroq")))
        })?,
    };
    let notices = begin(&config)?;
    set_tonight(&mut typed.night, &config)?;
    let (from, to) = time_range(typed.night.as_deref(), typed.start.as_deref(), typed.end.as_deref(), &config)?;
    let plan = config.observation()?;
    if plan.policy.max_lost_fraction.is_some() {
        return Err(anyhow!("the policy has max_lost_fraction, which windows does not support; remove this key"));
    }
    let min_altitude_deg = in_degrees("min-altitude", typed.min_altitude)?;
    let max_sun_altitude_deg = in_degrees("max-sun-altitude-deg", typed.max_sun_altitude_deg)?;
    let seconds = |what, text: &Option<String>| text.as_deref().map(|text| parse_duration_s(what, text)).transpose();
    let overhead_s = seconds("overhead", &typed.overhead)?.unwrap_or(0.0);
    let exposure = typed.exposure.or(config.exposure.duration.as_ref().map(|exposure| exposure.0.clone()));
    let listed = read_targets(&path, seconds("exposure", &exposure)?, plan.rotation_rad)?;

    let mut prepared = config.prepare(from, to)?;
    notices.warn(&prepared.warnings);
    let targets: Vec<WindowTarget> = listed.iter().filter_map(|one| one.target.clone().ok()).collect();
    let request = WindowRequest {
        conditions: plan.request(&prepared.sky),
        min_altitude_rad: min_altitude_deg.to_radians(),
        max_sun_altitude_rad: Some(max_sun_altitude_deg.to_radians()),
    };
    let bands = targets.iter().map(|target| target.band.as_deref()).collect();
    notices.warn(&plan.policy.band_warnings(&bands, plan.telescope.as_ref()));
    let report = clear_windows(&targets, from, to, &request)?;
    notices.warn_left_out(&prepared, &report.left_out, from)?;
    if let Some(site) = prepared.sky.viewpoint().site() {
        let night = Night::over(&prepared.sky, from, to, request.max_sun_altitude_rad)?;
        notices.warn(&night.why_never_dark(&site.site().name));
    }
    let found = found(&listed, &report);
    let without = found.iter().filter_map(|one| {
        let name = Quoted::new(&one.listed.name);
        one.reason().map(|reason| format!("target {name} has no window: {reason}"))
    });
    notices.warn_first(without, "targets without a window");
    let scale = config.given_time_scale().unwrap_or("utc").to_ascii_lowercase();
    state_scales(&mut prepared.provenance, &scale, &plan.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "targets": path.display().to_string(),
            "from_utc": format_utc(from, 3),
            "to_utc": format_utc(to, 3),
            "field": given_field(&config),
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
        let windows = window_table(&found);
        output.write(
            &VerbResult {
                sections: vec![
                    Section { name: "windows", table: &windows },
                    Section { name: "targets", table: &window_target_table(&found) },
                    Section { name: "left_out", table: &left_out_table(&report.left_out) },
                ],
                main: &windows,
                provenance: &prepared.provenance,
                style: Style { columns: ON_SCREEN, bold_row: None },
            },
            &notices,
        )?;
    }
    let count: usize = report.by_target.iter().map(|one| one.windows.len()).sum();
    let targets = counted(listed.len(), "target", "targets");
    notices.info(&format!("{targets}: {}", counted(count, "window", "windows")));
    Ok(Outcome::Done)
}

/// Pairs every row of the target list with its windows.
fn found<'a>(listed: &'a [ListedTarget], report: &'a WindowReport) -> Vec<FoundWindows<'a>> {
    let mut results = report.by_target.iter();
    listed
        .iter()
        .map(|listed| FoundWindows { listed, found: listed.target.as_ref().ok().and_then(|_| results.next()) })
        .collect()
}

fn in_degrees(what: &str, angle_deg: f64) -> anyhow::Result<f64> {
    if (-90.0..=90.0).contains(&angle_deg) {
        Ok(angle_deg)
    } else {
        Err(anyhow!("{what} is {angle_deg} deg; allowed: -90 to 90 deg"))
    }
}
