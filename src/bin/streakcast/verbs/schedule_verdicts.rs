//! Computes the verdicts of a schedule, for `flag`, `annotate`, `serve` and plots.

use std::path::Path;

use hifitime::{Epoch, TimeScale};
use serde_json::{Value, json};
use streakcast::config::{Config, NameOrTable, ObservationPlan, PreparedSky, state_scales};
use streakcast::frames::seconds_after;
use streakcast::images::Telescope;
use streakcast::output::{Provenance, Table, counted, format_utc};
use streakcast::passes::Exposure;
use streakcast::schedule::{
    FlagReport, Policy, Schedule, ScheduleFormat, ScheduledExposure, Shard, StreakColumns, StreakRow, Verdict,
    VerdictKind, check_extension, flag_exposures, streak_table,
};

use crate::notices::Notices;
use crate::start::begin;

/// Number of rows judged between two updates of the progress bar. Rows of one night in a chunk share computations.
const ROWS_AT_A_TIME: usize = 1000;

/// Schedule with its verdicts.
pub struct Judged {
    pub schedule: Schedule,
    pub report: FlagReport,
    /// Provenance of the verdicts.
    pub provenance: Provenance,
    pub notices: Notices,
    /// Streaks, if an annotated file is written: one row for each exposure and satellite.
    pub streaks: Table,
    /// For a batch share: for each row of the file, true if it is in `schedule`.
    pub keep: Option<Vec<bool>>,
}

/// Reads and judges a schedule, or a batch share of it. `annotated` is the name of the annotated file, if one is
/// written; it is checked before the computation.
pub fn judge(config: &Config, path: &Path, shard: Option<Shard>, annotated: Option<&Path>) -> anyhow::Result<Judged> {
    let notices = begin(config)?;
    let plan = config.observation()?;
    let mut schedule = Schedule::read(path, &config.schedule_options()?)?;
    if let Some(annotated) = annotated {
        check_extension(path, schedule.format, annotated)?;
    }
    // The sky is prepared for the whole schedule, so that all batch shares use the same element sets.
    let judgeable = span(&schedule);
    let all_rows = schedule.exposures.len();
    let keep = match shard {
        Some(shard) => {
            let keep = shard.rows(&schedule, config.viewpoint_longitude_rad(judgeable.map(|(first, _)| first))?);
            let mut kept = keep.iter();
            schedule.exposures.retain(|_| kept.next().copied().unwrap_or(false));
            Some(keep)
        }
        None => None,
    };
    let (report, streaks, mut provenance) = match judgeable {
        Some(_) if schedule.exposures.is_empty() => {
            // If there are more shares than nights, some shares have no rows.
            (FlagReport::default(), streak_table(std::iter::empty(), streak_columns(&plan.policy)), Provenance::new())
        }
        Some(span) => judge_rows(config, &schedule, span, &plan, annotated.is_some(), &notices)?,
        None => {
            // Without a valid time the sky cannot be prepared. All rows are invalid, each with its reason.
            (invalid_rows(&schedule), streak_table(std::iter::empty(), streak_columns(&plan.policy)), Provenance::new())
        }
    };
    let ObservationPlan { policy, telescope, photometry, .. } = &plan;
    notices.warn(&schedule_warnings(&schedule, policy, telescope.as_ref()));
    let telescope = telescope.as_ref().map(|telescope| telescope.name.as_str());
    state_scales(&mut provenance, &schedule.time_scale.to_string().to_ascii_lowercase(), photometry);
    provenance.state(
        "schedule",
        json!({
            "file": path.display().to_string(),
            "format": schedule.format.to_string(),
            "exposures": all_rows,
            "shard": shard.map(|shard| shard.to_string()),
            "start_column": schedule.start_column,
            "first_start_utc": judgeable.map(|(first, _)| format_utc(first, 3)),
        }),
    );
    provenance.state("options", options_json(config, policy, telescope));
    summary(&notices, &report);
    Ok(Judged { schedule, report, provenance, notices, streaks, keep })
}

/// Returns a report for a schedule in which no row can be judged.
fn invalid_rows(schedule: &Schedule) -> FlagReport {
    let reasons = schedule.exposures.iter().filter_map(|row| Some((row, row.exposure.as_ref().err()?)));
    let flags: Vec<_> = reasons.map(|(row, reason)| Verdict::invalid(&row.id, reason.clone())).collect();
    FlagReport { flags, ..FlagReport::default() }
}

/// Judges all rows of a schedule from `first` to `last`. Returns the report, the streaks if they are wanted, and their
/// provenance.
fn judge_rows(
    config: &Config,
    schedule: &Schedule,
    (first, last): (Epoch, Epoch),
    plan: &ObservationPlan,
    with_streaks: bool,
    notices: &Notices,
) -> anyhow::Result<(FlagReport, Table, Provenance)> {
    let ObservationPlan { telescope, photometry, policy, .. } = plan;
    let prepared = config.prepare(first, last)?;
    notices.warn(&prepared.warnings);
    let report = flag_rows(&prepared, schedule, first, plan, notices)?;

    let limit_mag = |row: &ScheduledExposure| policy.limit_mag.as_ref().and_then(|limit| limit.of(row.band.as_deref()));
    let rows = if with_streaks { &schedule.exposures[..] } else { &[] };
    let judged: Vec<(&Exposure, Option<f64>, &Vec<_>)> = rows
        .iter()
        .zip(&report.flags)
        .filter_map(|(row, flag)| row.exposure.as_ref().ok().map(|exposure| (exposure, limit_mag(row), &flag.passes)))
        .collect();
    let streaks = streak_table(
        judged.iter().flat_map(|(exposure, limit_mag, passes)| {
            passes.iter().map(|pass| StreakRow {
                exposure,
                pass,
                elements: &prepared.sky.elements()[pass.element_index],
                satellite_size_m: prepared.sky.model(pass.element_index).size_m(),
                telescope: telescope.as_ref(),
                photometry,
                limit_mag: *limit_mag,
            })
        }),
        streak_columns(policy),
    );
    Ok((report, streaks, prepared.provenance))
}

/// Returns the optional columns of the streak table of a schedule.
fn streak_columns(policy: &Policy) -> StreakColumns {
    StreakColumns { p_brighter: policy.limit_mag.is_some(), ..StreakColumns::default() }
}

/// Returns the verdicts of all rows for a prepared sky. If there are many rows, a progress bar is shown.
pub fn flag_rows(
    prepared: &PreparedSky,
    schedule: &Schedule,
    first: Epoch,
    plan: &ObservationPlan,
    notices: &Notices,
) -> anyhow::Result<FlagReport> {
    let request = plan.request(&prepared.sky);
    let rows: Vec<_> = schedule.exposures.iter().collect();
    let mut report = FlagReport::default();
    let bar = notices.progress(rows.len());
    for rows in rows.chunks(ROWS_AT_A_TIME) {
        report.append(flag_exposures(rows, &request)?);
        bar.inc(rows.len() as u64);
    }
    bar.finish_and_clear();
    notices.warn_left_out(prepared, &report.left_out, first)?;
    notices.warn(&report.daylight_warning());
    notices.warn(&report.lower_limit_warning());
    notices.warn(&report.age_warning());
    Ok(report)
}

/// Returns warnings about the schedule.
pub fn schedule_warnings(schedule: &Schedule, policy: &Policy, telescope: Option<&Telescope>) -> Vec<String> {
    let mut warnings = Vec::new();
    if schedule.format == ScheduleFormat::Opsim && schedule.time_scale != TimeScale::UTC {
        warnings.push(format!(
            "opsim databases have {} in UTC, but it is read as {}: crossings are those of other times unless the file was converted",
            schedule.start_column, schedule.time_scale
        ));
    }
    let repeated = schedule.repeated_ids();
    if repeated > 0 {
        let exposures = counted(repeated, "exposure has", "exposures have");
        warnings.push(format!(
            "{exposures} the exposure_id of an earlier one, so that it does not identify the exposure of a streak"
        ));
    }
    warnings.extend(policy.band_warnings(&schedule.bands(), telescope));
    warnings
}

/// Returns the first shutter opening and the last shutter closing of the valid rows; `None` if no row is valid.
pub fn span(schedule: &Schedule) -> Option<(Epoch, Epoch)> {
    let exposures = || schedule.valid_exposures().map(|(_, exposure)| exposure);
    let first = exposures().map(|exposure| exposure.start).min();
    let last = exposures().map(|exposure| seconds_after(exposure.start, exposure.duration_s)).max();
    first.zip(last)
}

/// Returns the message for a schedule without a valid time, with the reason of its first row.
pub fn none_judged(schedule: &Schedule, path: &Path) -> String {
    let why = schedule.exposures.iter().find_map(|row| row.exposure.as_ref().err().map(|reason| (row, reason)));
    let example = why.map(|(row, reason)| format!("; row {}: {reason}", row.row + 1)).unwrap_or_default();
    let rows = schedule.exposures.len();
    let none = if rows == 1 { "its only row cannot".to_owned() } else { format!("none of its {rows} rows can") };
    format!("schedule {}: {none} be judged{example}", path.display())
}

pub fn options_json(config: &Config, policy: &Policy, telescope: Option<&str>) -> Value {
    json!({
        "field": given_field(config),
        "default_rotation_deg": config.rotation.unwrap_or(0.0),
        "telescope": telescope,
        "policy": policy,
    })
}

/// Returns the field as given in the configuration, for the provenance.
pub fn given_field(config: &Config) -> Value {
    match (&config.fov, &config.field) {
        (Some(size), _) if size.as_str().contains(['x', '×']) => json!({ "rectangle": size.as_str() }),
        (Some(diameter), _) => json!({ "circle": diameter.as_str() }),
        (None, Some(NameOrTable::Name(path))) => json!({ "file": path.display().to_string() }),
        (None, Some(NameOrTable::Table(table))) => json!(table),
        (None, None) => json!("of the telescope"),
    }
}

pub fn summary(notices: &Notices, report: &FlagReport) {
    let count = |verdict| report.flags.iter().filter(|flag| flag.kind == verdict).count();
    let counts: Vec<String> =
        [VerdictKind::Clear, VerdictKind::Streaked, VerdictKind::Avoid, VerdictKind::Unknown, VerdictKind::Invalid]
            .into_iter()
            .filter(|verdict| count(*verdict) > 0)
            .map(|verdict| format!("{} {verdict}", count(verdict)))
            .collect();
    let all = report.flags.len();
    for kind in [VerdictKind::Unknown, VerdictKind::Invalid] {
        if let Some(first) = report.flags.iter().find(|flag| flag.kind == kind) {
            let (number, reasons) = (counted(all, "exposure", "exposures"), first.reasons.join("; "));
            notices.warn(&[format!(
                "{} of {number} cannot be judged; first exposure {}: {reasons}",
                count(kind),
                first.exposure_id
            )]);
        }
    }
    notices.info(&format!("{}: {}", counted(all, "exposure", "exposures"), counts.join(", ")));
}
