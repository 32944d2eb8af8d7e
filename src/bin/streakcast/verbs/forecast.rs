//! `forecast`: lists the visible passes of a night over a site.

use std::path::PathBuf;

use crate::arguments::OutputArguments;
use crate::clock::{TONIGHT, set_night, set_tonight};
use anyhow::anyhow;
use clap::Args;
use serde_json::json;
use streakcast::config::{Config, ForecastConfig, PreparedSky, SATELLITES, SITE, parse_duration_s};
use streakcast::forecast::{
    AngleType, EmptyNight, Forecast, ForecastRequest, PassColumns, calendar, forecast, light_curve_table, night_table,
    pass_table, readable_table, score_report, tdm,
};
use streakcast::geometry::Site;
use streakcast::output::{counted, format_utc};

use super::passes::left_out_table;
use crate::failure::Outcome;
use crate::help::{CAMERA_FLAGS, VerbFlags, help};
use crate::local_time::ZoneArguments;
use crate::output::{EXTENSIONS, FORMATS, Output, VerbResult};
use crate::screen::{Shown, rounded, shown};
use crate::start::begin;

/// Help of `--format`, with the additional formats of a forecast.
const FORMAT_HELP: &str = "Output format: table (default on a terminal), csv (default elsewhere), ecsv, json, jsonl, votable, \
     ics (calendar), tdm (CCSDS tracking data message), score (columns of SCORE)";

#[derive(Args)]
#[command(mut_arg("format", |format| format.help(FORMAT_HELP)))]
pub struct ForecastArguments {
    #[command(flatten)]
    pub forecast: ForecastConfig,
    /// Additional file of light curves, one row per point; format by extension (csv, ecsv, json, jsonl, vot)
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub light_curves: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Output")]
    pub zone: ZoneArguments,
    /// Alarm in the calendar this long before each pass, for example 5min
    #[arg(long, value_name = "TIME", help_heading = "Output")]
    pub alarm: Option<String>,
    /// Angles of a tracking data message: radec (default) or azel
    #[arg(long, value_name = "TYPE", help_heading = "Output")]
    pub angle_type: Option<String>,
    #[command(flatten)]
    pub config: Config,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Shared flags of a telescope in orbit.
const ORBIT_FLAGS: &[&str] =
    &["observer_elements", "observer_norad", "limb_height_km", "max_zenith_angle", "min_sun_angle", "min_limb_angle"];
const NO_ORBIT: &str = "cannot be used, because a telescope in orbit has no horizon; for satellites in its field use passes, flag or \
                        windows, for numbers statistics";

help! {
    ForecastArguments, "forecast", asks [SATELLITES, SITE],
    ignores [(CAMERA_FLAGS, "has no effect on passes over a site"), (ORBIT_FLAGS, NO_ORBIT)],
    "--start 2024-08-14T00:00:00Z --end 2024-08-14T00:10:00Z --shells oneweb --mpc X05 --max-mag 8",
    "--night 2024-08-14 --elements active.tle --lat 48.2 --lon 16.4 --format ics -o passes.ics"
}

/// Default number of points of a light curve.
const LIGHT_CURVE_SAMPLES: usize = 61;

const BY_UTC: &[Shown] = &on_screen("brightest (UTC)", "start (UTC)", "highest (UTC)", "end (UTC)");
const BY_LOCAL_TIME: &[Shown] = &on_screen("brightest (local)", "start (local)", "highest (local)", "end (local)");

const fn on_screen(
    brightest: &'static str,
    start: &'static str,
    highest: &'static str,
    end: &'static str,
) -> [Shown; 22] {
    [
        shown("date", "date"),
        shown("satellite", "satellite"),
        rounded("p_brighter", "P", 2),
        rounded("magnitude", "mag", 1),
        rounded("sigma", "sigma", 1),
        shown("brightest", brightest),
        shown("brightest_altitude", "alt"),
        shown("brightest_azimuth", "az"),
        shown("start", start),
        shown("start_altitude", "alt"),
        shown("start_azimuth", "az"),
        shown("highest", highest),
        shown("highest_altitude", "alt"),
        shown("highest_azimuth", "az"),
        shown("end", end),
        shown("end_altitude", "alt"),
        shown("end_azimuth", "az"),
        shown("ends_by", "ends by"),
        rounded("along_track_sigma_s", "late s", 1),
        rounded("element_age_days", "age d", 1),
        shown("norad_id", "norad"),
        shown("mag_source", "source"),
    ]
}

/// Formats that are not tables.
#[derive(Copy, Clone, PartialEq, Eq)]
enum Document {
    Calendar,
    TrackingData,
    Score,
}

impl Document {
    fn by_name(name: &str) -> Option<Self> {
        match name {
            "ics" | "ical" => Some(Self::Calendar),
            "tdm" => Some(Self::TrackingData),
            "score" => Some(Self::Score),
            _ => None,
        }
    }
}

pub fn run(mut typed: ForecastArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.clone().with_file()?;
    ForecastArguments::HELP.check(&config, &[])?;
    typed.forecast.range = typed.forecast.range.or_night(TONIGHT);
    let (output, document) = open(&typed, &config)?;
    let curves = typed.light_curves.clone().map(Output::additional).transpose()?;
    let alarm_s = typed.alarm.as_deref().map(|text| parse_duration_s("alarm", text)).transpose()?;
    let angles = angles(typed.angle_type.as_deref())?;
    reject_unused(&typed, document)?;
    let zone = typed.zone.or_of(&config)?;
    let notices = begin(&config)?;
    let default_samples = if curves.is_some() { LIGHT_CURVE_SAMPLES } else { 0 };
    // Measured magnitudes, with which these formats are compared, are corrected for extinction.
    let is_compared = matches!(document, Some(Document::TrackingData | Document::Score));
    typed.forecast.no_atmosphere |= is_compared && config.extinction.is_none();
    let mut of_mean_time = typed.forecast.clone();
    if let Some(remark) = set_night(&mut of_mean_time.range.night, &config, zone.as_ref())? {
        notices.info(&remark);
    }
    set_tonight(&mut typed.forecast.range.night, &config)?;
    let (request, selection) = of_mean_time.resolve(&config, default_samples)?;
    let (from, to) = (request.start, request.end);

    let mut prepared = config.prepare(from, to)?;
    let selected = selection.among(prepared.sky.elements());
    notices.warn(&prepared.warnings_of(from, to, &|elements| selected.contains(elements)));
    // This error counts all satellites; `found` counts the selected ones.
    let of_all = selection.is_all();
    if of_all {
        prepared.check_known(from, to, None)?;
    }
    let found = forecast(&prepared.sky, &request, &selection)?;
    if found.found.passes.is_empty() && found.unknown() == found.found.satellites {
        return Err(anyhow!(
            "the elements of {} are too old to predict passes; specify elements of about the date of the request",
            counted(found.unknown(), "selected satellite", "selected satellites")
        ));
    }
    let warning = prepared.left_out_warning_of_times(&found.found.left_out, from, found.found.has_passes())?;
    notices.list_left_out(warning, &found.found.left_out);
    if of_all || found.unknown() > 0 {
        notices.warn(&prepared.unknown_part_warning(from, to));
    }
    notices.warn(&selection.unknown_warning(prepared.sky.elements()));
    notices.warn(&found.prior_warning(&prepared.sky, request.max_magnitude));
    notices.warn(&found.fitted_range_warning());
    state(&mut prepared, &config, &typed.forecast, &request);
    let site = site_of(&prepared)?;
    let why_empty = found.why_empty(&prepared.sky, &request);

    let rows = || found.rows(&prepared.sky);
    // The formats of `Document` contain only visible passes.
    let is_invisible = found.found.passes.iter().all(|pass| pass.visible.is_none());
    let invisible = || is_invisible.then(|| "all passes are in the Earth's shadow or by daylight".to_owned());
    let why_invisible = why_empty.clone().or_else(invisible);
    // This error is returned before any file is written.
    if let (Some(Document::TrackingData), Some(why)) = (document, &why_invisible) {
        return Err(anyhow!(
            "no visible pass for a tracking data message, which needs at least one: {why}; allowed: another --format"
        ));
    }
    if let Some(curves) = &curves {
        let table = light_curve_table(rows());
        curves.write(&VerbResult::new("light_curves", &table, &[], &prepared.provenance), &notices)?;
    }
    let utc_offset_s = |epoch| zone.as_ref().map_or(0.0, |zone| zone.ahead_of_utc_h(epoch) * 3600.0);
    match document {
        Some(Document::Calendar) => {
            let empty = why_invisible.as_deref().map(|why| EmptyNight {
                start: request.start,
                end: request.end,
                why,
                is_unknown: found.may_have_passes(),
            });
            output.write_text(&calendar(rows(), &site, crate::clock::now(), alarm_s, empty, utc_offset_s), &notices)?;
        }
        Some(Document::TrackingData) => {
            output.write_text(&tdm(rows(), &site, crate::clock::now(), angles, &prepared.provenance), &notices)?
        }
        Some(Document::Score) => output.write_text(&score_report(rows(), &site, &request.photometry), &notices)?,
        None => {
            let readable = readable_table(rows(), utc_offset_s);
            let columns = PassColumns {
                p_brighter: request.max_magnitude.is_some(),
                more: output.is_json(),
                samples: output.is_json() && request.samples > 0,
            };
            let passes = pass_table(rows(), columns);
            let columns = if zone.is_some() { BY_LOCAL_TIME } else { BY_UTC };
            output.write(
                &VerbResult::new("passes", &passes, columns, &prepared.provenance)
                    .after("night", &night_table(&found, why_empty.as_deref()))
                    .with("left_out", &left_out_table(&found.found.left_out))
                    .shown_as(&readable)
                    .bold(brightest(&found)),
                &notices,
            )?;
        }
    }
    match why_empty {
        Some(why) => notices.info(&format!("no passes: {why}")),
        None => notices.info(&summary(&found, request.max_magnitude)),
    }
    Ok(Outcome::Done)
}

fn open(typed: &ForecastArguments, config: &Config) -> anyhow::Result<(Output, Option<Document>)> {
    let path = typed.output.output.clone();
    let extension = path.as_ref().and_then(|path| path.extension()).and_then(|name| name.to_str());
    let extension = extension.map(str::to_ascii_lowercase);
    let given = typed.output.format.as_deref().or(config.format.as_deref());
    match given.or(extension.as_deref()).and_then(Document::by_name) {
        // Documents are written as text; the format `json` is only used to open the file.
        Some(document) => Ok((Output::new(Some("json"), path)?, Some(document))),
        None => {
            let output = Output::new(given, path).map_err(|error| {
                let message = error.to_string().replace(FORMATS, &format!("{FORMATS}, ics, tdm, score"));
                anyhow!("{}", message.replace(EXTENSIONS, &format!("{EXTENSIONS}, .ics, .tdm, .score")))
            })?;
            Ok((output, None))
        }
    }
}

fn angles(given: Option<&str>) -> anyhow::Result<AngleType> {
    given.map_or(Ok(AngleType::default()), |name| {
        AngleType::by_name(name).ok_or_else(|| anyhow!("invalid angle-type '{name}'; allowed: radec, azel"))
    })
}

/// Rejects flags that apply only to other formats.
fn reject_unused(typed: &ForecastArguments, document: Option<Document>) -> anyhow::Result<()> {
    if typed.alarm.is_some() && document != Some(Document::Calendar) {
        return Err(anyhow!(
            "--alarm is given without a calendar; allowed: with --format ics or an output file with the extension .ics"
        ));
    }
    if typed.zone.time_zone.is_some() && matches!(document, Some(Document::TrackingData | Document::Score)) {
        return Err(anyhow!(
            "--time-zone has no effect on the formats tdm and score, which are in UTC; allowed: with table or ics"
        ));
    }
    if typed.angle_type.is_some() && document != Some(Document::TrackingData) {
        return Err(anyhow!(
            "--angle-type is given without a tracking data message; allowed: with --format tdm or an output file with the extension .tdm"
        ));
    }
    Ok(())
}

fn site_of(prepared: &PreparedSky) -> anyhow::Result<Site> {
    Ok(prepared.sky.viewpoint().required_site()?.site().clone())
}

fn state(prepared: &mut PreparedSky, config: &Config, forecast: &ForecastConfig, request: &ForecastRequest) {
    config.state_scales(&mut prepared.provenance, &request.photometry);
    prepared.provenance.state(
        "options",
        json!({
            "night": forecast.range.night,
            "start_utc": format_utc(request.start, 3),
            "end_utc": format_utc(request.end, 3),
            "sun_altitude_deg": forecast.sun_altitude_deg,
            "min_altitude_deg": forecast.min_altitude,
            "min_culmination_deg": forecast.min_culmination,
            "max_mag": forecast.max_mag,
            "min_p_brighter": request.min_probability,
            "twilight": request.twilight,
            "generation": forecast.selection.generation,
            "name": forecast.selection.name,
            "norad": forecast.selection.norad,
            "include_dark": request.include_dark,
            "samples": request.samples,
        }),
    );
}

/// Returns the row of the brightest pass.
fn brightest(found: &Forecast) -> Option<usize> {
    let magnitude =
        |row: usize| Some(found.found.passes[row].visible.as_ref()?.peak.as_ref()?.brightness.as_ref()?.magnitude.0);
    let bright = (0..found.found.passes.len()).filter_map(|row| Some((row, magnitude(row)?)));
    bright.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(row, _)| row)
}

fn summary(found: &Forecast, limit_mag: Option<f64>) -> String {
    let passes = &found.found.passes;
    let satellites: std::collections::BTreeSet<_> = passes.iter().map(|pass| pass.element_index).collect();
    let passes = counted(passes.len(), "pass", "passes");
    let shown = format!("{passes} of {}", counted(satellites.len(), "satellite", "satellites"));
    let listed = found.found.passes.iter().filter_map(|pass| pass.p_brighter).sum::<f64>();
    match (limit_mag, found.found.expected_brighter) {
        (Some(limit_mag), Some(expected)) => {
            let others = counted(found.found.not_shown.too_faint, "less probable pass", "less probable passes");
            format!(
                "{shown} probably brighter than mag {limit_mag} ({listed:.1} expected); with {others}, {expected:.1} are expected"
            )
        }
        _ => shown,
    }
}
