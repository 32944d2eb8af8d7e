//! Computes the verdicts of a schedule, for `flag`, `annotate`, `serve` and plots.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use hifitime::{Epoch, TimeScale};
use serde_json::{Value, json};
use streakcast::config::{Config, NameOrTable, ObservationPlan, PreparedSky, state_scales};
use streakcast::frames::seconds_after;
use streakcast::input::comments_warning;
use streakcast::message::Quoted;
use streakcast::output::{Provenance, Table, counted, format_utc};
use streakcast::schedule::{
    FlagReport, FlagTotals, Policy, Schedule, ScheduleFormat, ScheduledExposure, Shard, StreakColumns, StreakRow,
    Verdict, VerdictKind, check_extension, evening_mjd, flag_exposures, streak_table,
};

use crate::notices::Notices;
use crate::start::begin;

/// Number of rows judged between two updates of the progress bar. Rows of one night in a chunk share computations.
const ROWS_AT_A_TIME: usize = 1000;

/// Schedule, or a batch share of it, that can be judged.
pub struct PreparedSchedule {
    pub schedule: Schedule,
    plan: ObservationPlan,
    /// Parts of the rows in their order. Only constellations that grow, or a schedule without a valid row, make more or
    /// less than one part.
    parts: Vec<Part>,
    /// Provenance of the verdicts.
    pub provenance: Provenance,
    pub notices: Notices,
    /// Path of the schedule.
    path: PathBuf,
    /// For a batch share: for each row of the file, true if it is in `schedule`.
    pub keep: Option<Vec<bool>>,
}

/// Successive rows of a schedule with the same satellites.
struct Part {
    rows: Range<usize>,
    sky: Rc<PreparedSky>,
    /// First shutter opening of all rows with these satellites.
    first: Epoch,
}

impl PreparedSchedule {
    /// Reads a schedule, or a batch share of it, and prepares the sky. `annotated` is the name of the annotated file,
    /// if one is written; it is checked before the computation.
    pub fn read(config: &Config, path: &Path, shard: Option<Shard>, annotated: Option<&Path>) -> anyhow::Result<Self> {
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
        // Without a valid time the sky cannot be prepared. If there are more shares than nights, some have no rows.
        let parts = match judgeable.filter(|_| !schedule.exposures.is_empty()) {
            Some(span) => parts(config, &schedule, span)?,
            None => Vec::new(),
        };
        let mut provenance = provenance_of(&parts);
        let ObservationPlan { policy, telescope, photometry, .. } = &plan;
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
        Ok(Self { schedule, plan, parts, provenance, notices, path: path.to_owned(), keep })
    }

    /// Judges the rows in parts, calls `take` with the rows and the report of each part, and prints the warnings and
    /// the number of exposures with each verdict.
    pub fn judge_in_parts(
        &self,
        take: &mut dyn FnMut(&[ScheduledExposure], FlagReport) -> anyhow::Result<()>,
    ) -> anyhow::Result<FlagTotals> {
        let Self { schedule, plan, notices, parts, .. } = self;
        let totals = match parts.first() {
            Some(first) => {
                let mut warned = BTreeSet::new();
                let new = |warning: &&String| warned.insert((*warning).clone());
                let warnings = parts.iter().flat_map(|part| &part.sky.warnings).filter(new).cloned();
                notices.warn(&warnings.collect::<Vec<_>>());
                let skies = parts.iter().map(|part| (&*part.sky, part.rows.clone()));
                flag_rows(skies, schedule, first.first, plan, notices, take)?
            }
            None => invalid_rows(schedule, take)?,
        };
        notices.warn(&schedule_warnings(schedule, &plan.policy));
        summary(notices, &totals, schedule, &self.path);
        Ok(totals)
    }

    /// Judges all rows.
    pub fn judge(&self) -> anyhow::Result<(Vec<Verdict>, FlagTotals)> {
        let mut flags = Vec::with_capacity(self.schedule.exposures.len());
        let totals = self.judge_in_parts(&mut |_, report| {
            flags.extend(report.flags);
            Ok(())
        })?;
        Ok((flags, totals))
    }

    /// Returns the streaks of judged rows: one row for each exposure and satellite.
    pub fn streaks(&self, flags: &[Verdict]) -> Table {
        let ObservationPlan { telescope, photometry, policy, .. } = &self.plan;
        let p_brighter = policy.limit_mag.is_some() || policy.limit_surface_brightness.is_some();
        let columns = StreakColumns { p_brighter, ..StreakColumns::default() };
        let judged = self.parts.iter().flat_map(|part| {
            let rows = self.schedule.exposures[part.rows.clone()].iter().zip(&flags[part.rows.clone()]);
            rows.filter_map(|(row, flag)| {
                row.exposure.as_ref().ok().map(|exposure| (&part.sky.sky, row, exposure, flag))
            })
        });
        let rows = judged.flat_map(|(sky, row, exposure, flag)| {
            let band = row.band.as_deref();
            let limit_mag = policy.limit_mag.as_ref().and_then(|limit| limit.of(band));
            let request = self.plan.request(sky);
            flag.passes.iter().map(move |pass| StreakRow {
                exposure,
                pass,
                elements: &sky.elements()[pass.element_index],
                satellite_size_m: sky.model(pass.element_index).size_m(),
                telescope: telescope.as_ref(),
                photometry,
                limit_mag: request.limit_mag_of(pass, band, exposure.duration_s, limit_mag),
                streak_cost_s: request.pass_cost_s(exposure, pass, band, limit_mag),
            })
        });
        streak_table(rows, columns)
    }
}

/// Divides the rows of a schedule from `first` to `last` into parts with the same satellites, and prepares their skies.
fn parts(config: &Config, schedule: &Schedule, (first, last): (Epoch, Epoch)) -> anyhow::Result<Vec<Part>> {
    let deployment = config.deployment()?;
    if deployment.periods().next().is_none() {
        let rows = 0..schedule.exposures.len();
        return Ok(vec![Part { rows, sky: Rc::new(config.prepare(first, last)?), first }]);
    }
    let longitude_rad = config.viewpoint_longitude_rad(Some(first))?;
    let period_of = |epoch| deployment.periods_begun(evening_mjd(epoch, longitude_rad));
    // Rows without a valid time are in the part of the row before them.
    let mut previous = period_of(first);
    let periods = schedule.exposures.iter().map(|row| {
        previous = row.exposure.as_ref().map_or(previous, |exposure| period_of(exposure.start));
        previous
    });
    let periods: Vec<usize> = periods.collect();
    let mut spans: BTreeMap<usize, (Epoch, Epoch)> = BTreeMap::new();
    for (exposure, period) in schedule.exposures.iter().zip(&periods) {
        let Ok(exposure) = &exposure.exposure else { continue };
        let (start, end) = (exposure.start, seconds_after(exposure.start, exposure.duration_s));
        let span = spans.entry(*period).or_insert((start, end));
        *span = (span.0.min(start), span.1.max(end));
    }
    let inputs = config.load()?;
    let mut skies: BTreeMap<usize, (Rc<PreparedSky>, Epoch)> = BTreeMap::new();
    for (period, (first, last)) in spans {
        skies.insert(period, (Rc::new(inputs.prepare(first, last)?), first));
    }
    let mut parts: Vec<Part> = Vec::new();
    let mut begin = 0;
    for rows in periods.chunk_by(|one, next| one == next) {
        if let Some((sky, first)) = skies.get(&rows[0]) {
            parts.push(Part { rows: begin..begin + rows.len(), sky: Rc::clone(sky), first: *first });
        }
        begin += rows.len();
    }
    Ok(parts)
}

/// Returns the provenance of the first sky, with the simulated constellations of each.
fn provenance_of(parts: &[Part]) -> Provenance {
    let Some(first) = parts.first() else { return Provenance::new() };
    let mut provenance = first.sky.provenance.clone();
    let mut skies: Vec<&Part> = parts.iter().collect();
    skies.sort_by_key(|part| part.first);
    skies.dedup_by(|one, other| Rc::ptr_eq(&one.sky, &other.sky));
    if skies.len() > 1 {
        let stated = skies.iter().map(|part| {
            json!({
                "first_start_utc": format_utc(part.first, 3),
                "satellites": part.sky.sky.elements().len(),
                "shells": part.sky.provenance.get("shells"),
            })
        });
        provenance.state("periods", stated.collect::<Vec<_>>());
    }
    provenance
}

/// Reports on a schedule in which no row can be judged.
fn invalid_rows(
    schedule: &Schedule,
    take: &mut dyn FnMut(&[ScheduledExposure], FlagReport) -> anyhow::Result<()>,
) -> anyhow::Result<FlagTotals> {
    let mut totals = FlagTotals::default();
    for rows in schedule.exposures.chunks(ROWS_AT_A_TIME) {
        let reasons = rows.iter().filter_map(|row| Some((row, row.exposure.as_ref().err()?)));
        let flags = reasons.map(|(row, reason)| Verdict::invalid(&row.id, reason.clone())).collect();
        let report = FlagReport { flags, ..FlagReport::default() };
        totals.add(&report);
        take(rows, report)?;
    }
    Ok(totals)
}

/// Judges all rows, each range for its sky, in parts, and prints warnings about the satellites and the times. If there
/// are many rows, a progress bar is shown.
pub fn flag_rows<'a>(
    skies: impl Iterator<Item = (&'a PreparedSky, Range<usize>)>,
    schedule: &Schedule,
    first: Epoch,
    plan: &ObservationPlan,
    notices: &Notices,
    take: &mut dyn FnMut(&[ScheduledExposure], FlagReport) -> anyhow::Result<()>,
) -> anyhow::Result<FlagTotals> {
    let mut totals = FlagTotals::default();
    let bar = notices.progress(schedule.exposures.len());
    let mut last_sky = None;
    for (prepared, range) in skies {
        let request = plan.request(&prepared.sky);
        for rows in schedule.exposures[range].chunks(ROWS_AT_A_TIME) {
            let report = flag_exposures(&rows.iter().collect::<Vec<_>>(), &request)?;
            totals.add(&report);
            take(rows, report)?;
            bar.inc(rows.len() as u64);
        }
        last_sky = Some(prepared);
    }
    bar.finish_and_clear();
    if let Some(prepared) = last_sky {
        notices.warn_left_out(prepared, totals.left_out(), first)?;
    }
    notices.warn(&totals.warnings());
    Ok(totals)
}

/// Returns warnings about the schedule.
pub fn schedule_warnings(schedule: &Schedule, policy: &Policy) -> Vec<String> {
    let mut warnings = Vec::new();
    if schedule.format == ScheduleFormat::Opsim && schedule.time_scale != TimeScale::UTC {
        warnings.push(format!(
            "opsim databases have {} in UTC, but it is read as {}: crossings are those of other times unless the file was converted",
            schedule.start_column, schedule.time_scale
        ));
    }
    warnings.extend(comments_warning(schedule.comments_like_rows));
    let repeated = schedule.repeated_ids();
    if repeated > 0 {
        let exposures = counted(repeated, "exposure has", "exposures have");
        warnings.push(format!(
            "{exposures} the exposure_id of an earlier one, so that it does not identify the exposure of a streak"
        ));
    }
    warnings.extend(policy.band_warning(&schedule.bands()));
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

/// Prints the number of exposures with each verdict, and a warning for rows of the file that cannot be judged.
pub fn summary(notices: &Notices, totals: &FlagTotals, schedule: &Schedule, path: &Path) {
    let counts: Vec<String> =
        [VerdictKind::Clear, VerdictKind::Streaked, VerdictKind::Avoid, VerdictKind::Unknown, VerdictKind::Invalid]
            .into_iter()
            .filter(|verdict| totals.count(*verdict) > 0)
            .map(|verdict| format!("{} {verdict}", totals.count(verdict)))
            .collect();
    let number = counted(totals.exposures(), "exposure", "exposures");
    for kind in [VerdictKind::Unknown, VerdictKind::Invalid] {
        if let Some(first) = totals.first(kind) {
            let row = schedule.exposures.iter().find(|row| row.id == first.exposure_id).map_or(0, |row| row.row + 1);
            notices.warn(&[format!(
                "schedule {}: {} of {number} cannot be judged; first row {row}, exposure {}: {}",
                path.display(),
                totals.count(kind),
                Quoted::new(&first.exposure_id),
                first.reasons.join("; ")
            )]);
        }
    }
    notices.info(&format!("{number}: {}", counts.join(", ")));
}
