//! What `flag` and `annotate` share: a schedule read, judged, and its tables.

use std::path::Path;

use anyhow::anyhow;
use hifitime::Epoch;
use serde_json::{Value, json};
pub use streakcast::config::state_scales;
use streakcast::config::{FieldSetup, Prepared, Setup};
use streakcast::frames::seconds_after;
use streakcast::images::Telescope;
use streakcast::output::{Provenance, Table, format_utc};
use streakcast::passes::{Exposure, Field};
use streakcast::photometry::PhotometryOptions;
use streakcast::schedule::{
    ExposureFlag, FlagReport, FlagRequest, Policy, Schedule, Shard, StreakRow, Verdict, flag_exposures, streak_table,
};

use crate::notices::Notices;

/// Rows judged at a time: often enough for a progress bar, and a night shares its preparation.
const ROWS_AT_A_TIME: usize = 1000;

/// More threads than any machine has cores are a slip of the finger, and starting them takes minutes.
const MOST_THREADS: usize = 1024;

/// A schedule with its verdicts.
pub struct Judged {
    pub schedule: Schedule,
    pub report: FlagReport,
    /// What the answers rest on.
    pub provenance: Provenance,
    pub notices: Notices,
    /// One row for each exposure and satellite.
    pub streaks: Table,
    /// Of a share of a batch: which rows of the file are in `schedule`.
    pub keep: Option<Vec<bool>>,
}

/// Sets the threads, and says how loud the run is.
pub fn begin(setup: &Setup) -> anyhow::Result<Notices> {
    if let Some(threads) = setup.threads {
        if !(1..=MOST_THREADS).contains(&threads) {
            return Err(anyhow!("threads {threads}; allowed: 1 to {MOST_THREADS}"));
        }
        rayon::ThreadPoolBuilder::new().num_threads(threads).build_global()?;
    }
    Ok(Notices::new(setup.quiet.unwrap_or(false)))
}

/// Reads and judges a schedule, or its share of a batch.
pub fn judge(setup: &Setup, path: &Path, shard: Option<Shard>) -> anyhow::Result<Judged> {
    let notices = begin(setup)?;
    let asked = Asked::of(setup)?;
    let mut schedule = Schedule::read(path, &setup.schedule_options()?)?;
    // The sky is made for the whole schedule: every share asks the same one.
    let judgeable = span(&schedule);
    let all_rows = schedule.exposures.len();
    let keep = match shard {
        Some(shard) => {
            let keep = shard.rows(&schedule, setup.viewpoint_longitude_rad(judgeable.map(|(first, _)| first))?);
            let mut kept = keep.iter();
            schedule.exposures.retain(|_| kept.next().copied().unwrap_or(false));
            Some(keep)
        }
        None => None,
    };
    let (report, streaks, mut provenance) = match judgeable {
        Some(_) if schedule.exposures.is_empty() => {
            // A share of a batch with more shares than nights.
            (FlagReport::default(), streak_table(std::iter::empty(), false, false), Provenance::new())
        }
        Some(span) => judge_rows(setup, &schedule, span, &asked, &notices)?,
        None => {
            // No moment to ask any satellite about: the rows come back with their reasons, and rest on nothing.
            notices.warn(&[none_judged(&schedule, path)]);
            (invalid_rows(&schedule), streak_table(std::iter::empty(), false, false), Provenance::new())
        }
    };
    let Asked { policy, telescope, photometry, .. } = &asked;
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
    provenance.state("options", options_json(setup, policy, telescope));
    summary(&notices, &report);
    Ok(Judged { schedule, report, provenance, notices, streaks, keep })
}

/// What a schedule is judged by.
pub struct Asked {
    pub field: Field,
    pub telescope: Option<Telescope>,
    pub policy: Policy,
    pub photometry: PhotometryOptions,
}

impl Asked {
    /// As a setup says it.
    pub fn of(setup: &Setup) -> anyhow::Result<Self> {
        let (field, telescope) = (setup.field_of_view()?, setup.telescope()?);
        Ok(Self { field, telescope, policy: setup.policy()?, photometry: setup.photometry()? })
    }
}

/// A report in which no row was judged.
fn invalid_rows(schedule: &Schedule) -> FlagReport {
    let reasons = schedule.exposures.iter().filter_map(|row| Some((row, row.exposure.as_ref().err()?)));
    let flags: Vec<_> = reasons.map(|(row, reason)| ExposureFlag::invalid(&row.id, reason.clone())).collect();
    FlagReport { passes: vec![Vec::new(); flags.len()], flags, ..FlagReport::default() }
}

/// Judges all rows between two moments: the report, its streaks, and what they rest on.
fn judge_rows(
    setup: &Setup,
    schedule: &Schedule,
    (first, last): (Epoch, Epoch),
    asked: &Asked,
    notices: &Notices,
) -> anyhow::Result<(FlagReport, Table, Provenance)> {
    let Asked { telescope, photometry, .. } = asked;
    let prepared = setup.prepare(first, last)?;
    notices.warn(&prepared.warnings);
    let report = flag_rows(&prepared, schedule, first, asked, notices)?;

    let judged: Vec<(&Exposure, &Vec<_>)> = schedule
        .exposures
        .iter()
        .zip(&report.passes)
        .filter_map(|(row, passes)| row.exposure.as_ref().ok().map(|exposure| (exposure, passes)))
        .collect();
    let streaks = streak_table(
        judged.iter().flat_map(|(exposure, passes)| {
            passes.iter().map(|pass| StreakRow {
                exposure,
                pass,
                elements: &prepared.sky.elements()[pass.element_index],
                satellite_size_m: prepared.sky.model(pass.element_index).size_m(),
                telescope: telescope.as_ref(),
                photometry,
            })
        }),
        false,
        false,
    );
    Ok((report, streaks, prepared.provenance))
}

/// The verdicts of all rows under a sky that is ready, with a bar on long work.
pub fn flag_rows(
    prepared: &Prepared,
    schedule: &Schedule,
    first: Epoch,
    asked: &Asked,
    notices: &Notices,
) -> anyhow::Result<FlagReport> {
    let Asked { field, telescope, policy, photometry } = asked;
    let request = FlagRequest { sky: &prepared.sky, field, policy, telescope: telescope.as_ref(), photometry };
    let rows: Vec<_> = schedule.exposures.iter().collect();
    let mut report = FlagReport::default();
    let bar = notices.progress(rows.len());
    for rows in rows.chunks(ROWS_AT_A_TIME) {
        report.append(flag_exposures(rows, &request)?);
        bar.inc(rows.len() as u64);
    }
    bar.finish_and_clear();
    notices.warn(&prepared.left_out_warning(&report.left_out, first)?);
    notices.warn(&report.lower_limit_warning());
    Ok(report)
}

/// What the user may not have noticed about the schedule.
pub fn schedule_warnings(schedule: &Schedule, policy: &Policy, telescope: Option<&Telescope>) -> Vec<String> {
    let mut warnings = Vec::new();
    let repeated = schedule.repeated_ids();
    if repeated > 0 {
        warnings.push(format!(
            "{repeated} exposures carry the id of an earlier one: their streaks cannot be told apart by it"
        ));
    }
    for (name, limit) in [
        ("limit_mag", &policy.limit_mag),
        ("saturation_mag", &policy.saturation_mag),
        ("crosstalk_mag", &policy.crosstalk_mag),
    ] {
        let bands = limit.as_ref().map(|limit| schedule.bands_without(limit)).unwrap_or_default();
        if !bands.is_empty() {
            let bands: Vec<&str> = bands.into_iter().collect();
            warnings.push(format!("the policy's {name} has no number for band {} and no default", bands.join(", ")));
        }
    }
    for (name, limit) in telescope.map(|telescope| policy.limits_of_telescope(telescope)).unwrap_or_default() {
        let bands: Vec<&str> = schedule.bands_without(&limit).into_iter().collect();
        if !bands.is_empty() {
            let bands = bands.join(", ");
            warnings.push(format!("the policy's {name} has no number for band {bands} in the file of the telescope"));
        }
    }
    warnings
}

/// From the first opening to the last closing of the rows that can be judged; `None` where none can.
pub fn span(schedule: &Schedule) -> Option<(Epoch, Epoch)> {
    let exposures = || schedule.judged().map(|(_, exposure)| exposure);
    let first = exposures().map(|exposure| exposure.start).min();
    let last = exposures().map(|exposure| seconds_after(exposure.start, exposure.duration_s)).max();
    first.zip(last)
}

pub fn none_judged(schedule: &Schedule, path: &Path) -> String {
    let why = schedule.exposures.iter().find_map(|row| row.exposure.as_ref().err().map(|reason| (row, reason)));
    let example = why.map(|(row, reason)| format!("; row {}: {reason}", row.row + 1)).unwrap_or_default();
    format!("schedule {}: none of its {} rows can be judged{example}", path.display(), schedule.exposures.len())
}

pub fn options_json(setup: &Setup, policy: &Policy, telescope: Option<&str>) -> Value {
    json!({
        "field": field_said(setup),
        "default_rotation_deg": setup.rotation.unwrap_or(0.0),
        "telescope": telescope,
        "policy": policy,
    })
}

/// The field as it was said, for the provenance.
pub fn field_said(setup: &Setup) -> Value {
    match (&setup.fov, &setup.field) {
        (Some(diameter), _) => json!({ "circle": diameter.text() }),
        (None, Some(FieldSetup::File(path))) => json!({ "file": path.display().to_string() }),
        (None, Some(FieldSetup::Table(table))) => json!(table),
        (None, None) => json!("of the telescope"),
    }
}

pub fn summary(notices: &Notices, report: &FlagReport) {
    let count = |verdict| report.flags.iter().filter(|flag| flag.verdict == verdict).count();
    let words: Vec<String> = [Verdict::Clear, Verdict::Streaked, Verdict::Avoid, Verdict::Invalid]
        .into_iter()
        .filter(|verdict| count(*verdict) > 0)
        .map(|verdict| format!("{} {verdict}", count(verdict)))
        .collect();
    notices.say(&format!("{} exposures: {}", report.flags.len(), words.join(", ")));
}
