//! Computes the verdicts of a schedule, for `flag`, `annotate`, `serve` and plots.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use hifitime::Epoch;
use indicatif::ProgressBar;
use serde_json::Value;
use streakcast::config::{Config, LoadedInputs, ObservationPlan, PreparedSky, state_scales};
use streakcast::frames::seconds_after;
use streakcast::message::Quoted;
use streakcast::orbit::LeftOut;
use streakcast::output::{Provenance, Table, Value as Cell, counted};
use streakcast::passes::Sky;
use streakcast::schedule::{
    FlagReport, FlagTotals, Schedule, ScheduledExposure, Shard, StreakColumns, Verdict, VerdictKind, check_extension,
    evening_mjd, flag_exposures, streak_table,
};

use crate::notices::{Notices, WarningsOfNights};
use crate::start::begin;

/// Number of rows judged between two updates of the progress bar. Rows of one night in a chunk share computations.
const ROWS_AT_A_TIME: usize = 1000;

/// Schedule, or a batch share of it, that can be judged.
pub struct PreparedSchedule {
    pub schedule: Schedule,
    plan: ObservationPlan,
    /// Rows by their satellites, in the order of their first rows: one part, or one for each night or period. A
    /// schedule without a valid row has none.
    parts: Vec<Part>,
    /// Sky of the first part. The others are prepared when they are used, so that few are in memory.
    first_sky: Option<PreparedSky>,
    /// Inputs of the other skies.
    inputs: Option<LoadedInputs>,
    /// Provenance of the verdicts.
    pub provenance: Provenance,
    pub notices: Notices,
    /// Path of the schedule.
    path: PathBuf,
    /// For a batch share: for each row of the file, true if it is in `schedule`.
    pub keep: Option<Vec<bool>>,
}

/// Rows of a schedule with the same satellites.
pub struct Part {
    pub rows: Vec<Range<usize>>,
    /// First shutter opening and last closing.
    pub span: (Epoch, Epoch),
}

/// Judges rows of a schedule in any order, and passes the verdicts on in the order of the schedule.
pub struct RowJudge<'a> {
    schedule: &'a Schedule,
    plan: &'a ObservationPlan,
    totals: FlagTotals,
    bar: ProgressBar,
    /// Verdicts by their first row until those of all rows before are known.
    waiting: BTreeMap<usize, Vec<Verdict>>,
    /// First row that was not passed on.
    next: usize,
}

/// Receiver of rows and verdicts in the order of the schedule.
type Take<'a> = &'a mut dyn FnMut(&[ScheduledExposure], &[Verdict]) -> anyhow::Result<()>;
/// Receiver of verdicts as soon as they are known, with their sky and their first row.
type See<'a> = &'a mut dyn FnMut(&Sky, usize, &[Verdict]);

impl<'a> RowJudge<'a> {
    pub fn new(schedule: &'a Schedule, plan: &'a ObservationPlan, notices: &Notices) -> Self {
        let bar = notices.progress(schedule.exposures.len());
        Self { schedule, plan, totals: FlagTotals::default(), bar, waiting: BTreeMap::new(), next: 0 }
    }

    /// Judges the rows of a part, and returns the warning about satellites without a position.
    pub fn judge(
        &mut self,
        prepared: &PreparedSky,
        part: &Part,
        see: See<'_>,
        take: Take<'_>,
    ) -> anyhow::Result<Option<String>> {
        let mut left_out = Vec::new();
        for rows in &part.rows {
            left_out.append(&mut self.judge_rows(prepared, rows.clone(), see, take)?);
        }
        left_out.sort_by_key(|satellite| satellite.element_index);
        left_out.dedup_by_key(|satellite| satellite.element_index);
        Ok(prepared.left_out_warning(&left_out, part.span.0)?)
    }

    /// Judges successive rows, and returns the satellites without a position.
    fn judge_rows(
        &mut self,
        prepared: &PreparedSky,
        rows: Range<usize>,
        see: See<'_>,
        take: Take<'_>,
    ) -> anyhow::Result<Vec<LeftOut>> {
        let request = self.plan.request(&prepared.sky);
        let mut left_out = Vec::new();
        let mut first = rows.start;
        for rows in self.schedule.exposures[rows].chunks(ROWS_AT_A_TIME) {
            let mut report = flag_exposures(&rows.iter().collect::<Vec<_>>(), &request)?;
            let flags = std::mem::take(&mut report.flags);
            // If no satellite can be propagated, no row is passed on as clear.
            if let Some(start) = rows.iter().find_map(|row| Some(row.exposure.as_ref().ok()?.start)) {
                prepared.left_out_warning(&report.left_out, start)?;
            }
            self.totals.add(&report);
            left_out.append(&mut report.left_out);
            see(&prepared.sky, first, &flags);
            self.waiting.insert(first, flags);
            first += rows.len();
            self.bar.inc(rows.len() as u64);
            self.pass_on(take)?;
        }
        Ok(left_out)
    }

    /// Returns the totals of all rows.
    pub fn finish(self) -> FlagTotals {
        self.bar.finish_and_clear();
        self.totals
    }

    fn pass_on(&mut self, take: Take<'_>) -> anyhow::Result<()> {
        while let Some(flags) = self.waiting.remove(&self.next) {
            let rows = &self.schedule.exposures[self.next..self.next + flags.len()];
            self.next += flags.len();
            let report = FlagReport { flags, ..FlagReport::default() };
            self.totals.add(&report);
            take(rows, &report.flags)?;
        }
        Ok(())
    }
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
        // The parts depend on the whole schedule, so that all batch shares use the same element sets.
        let judgeable = span(&schedule);
        let mut statement = schedule.statement(path);
        statement["shard"] = shard.map(|shard| shard.to_string()).into();
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
        let (parts, inputs) = match judgeable.filter(|_| !schedule.exposures.is_empty()) {
            Some(span) => parts_and_inputs(config, &schedule, span)?,
            None => (Vec::new(), None),
        };
        let first_sky = parts.first().map(|Part { span: (first, last), .. }| match &inputs {
            Some(inputs) => inputs.prepare(*first, *last),
            None => config.prepare(*first, *last),
        });
        let first_sky = first_sky.transpose()?;
        let mut provenance = first_sky.as_ref().map_or_else(Provenance::new, |sky| sky.provenance.clone());
        if let (Some(inputs), Some(span)) = (&inputs, judgeable) {
            let periods = self::parts(config, &schedule, span)?;
            state_periods(&mut provenance, inputs, periods.iter().map(|part| part.span.0))?;
            if inputs.epochs_of_choice().is_some() {
                provenance.state("element_sets", "closest to the middle of each night");
            }
        }
        let ObservationPlan { policy, telescope, photometry, .. } = &plan;
        let telescope = telescope.as_ref().map(|telescope| telescope.name.as_str());
        state_scales(&mut provenance, &schedule.time_scale.to_string().to_ascii_lowercase(), photometry);
        provenance.state("schedule", statement);
        provenance.state("options", config.flag_options(policy, telescope));
        Ok(Self { schedule, plan, parts, first_sky, inputs, provenance, notices, path: path.to_owned(), keep })
    }

    /// Judges the rows in parts, calls `take` with the rows and the verdicts of each part in their order, and prints
    /// the warnings and the number of exposures with each verdict.
    pub fn judge_in_parts(&self, take: Take<'_>) -> anyhow::Result<FlagTotals> {
        self.judge_and_see(&mut |_, _, _| {}, take)
    }

    fn judge_and_see(&self, see: See<'_>, take: Take<'_>) -> anyhow::Result<FlagTotals> {
        let Self { schedule, plan, notices, parts, .. } = self;
        let totals = if parts.is_empty() { invalid_rows(schedule, take)? } else { self.judge_parts(see, take)? };
        notices.warn(&schedule.warnings(&plan.policy));
        let sky = self.first_sky.as_ref();
        notices.warn(&sky.and_then(|sky| schedule.altitude_warning(sky.sky.viewpoint(), &sky.eop)));
        summary(notices, &totals, schedule, &self.path);
        Ok(totals)
    }

    fn judge_parts(&self, see: See<'_>, take: Take<'_>) -> anyhow::Result<FlagTotals> {
        let Self { schedule, plan, notices, .. } = self;
        let mut judge = RowJudge::new(schedule, plan, notices);
        let mut of_nights = WarningsOfNights::default();
        let mut without_position = Vec::new();
        for (number, part) in self.parts.iter().enumerate() {
            let later = self.inputs.as_ref().filter(|_| number > 0);
            let later = later.map(|inputs| inputs.prepare(part.span.0, part.span.1)).transpose()?;
            let Some(prepared) = later.as_ref().or(self.first_sky.as_ref()) else { continue };
            notices.warn(prepared.warnings.iter().filter(|warning| of_nights.is_first(warning)));
            without_position
                .extend(judge.judge(prepared, part, see, take)?.filter(|warning| of_nights.is_first(warning)));
        }
        let totals = judge.finish();
        of_nights.print_last(notices);
        notices.list_left_out(without_position, totals.left_out());
        notices.warn(&totals.warnings());
        Ok(totals)
    }

    /// Judges all rows.
    pub fn judge(&self) -> anyhow::Result<(Vec<Verdict>, FlagTotals)> {
        let mut flags = Vec::with_capacity(self.schedule.exposures.len());
        let totals = self.judge_in_parts(&mut |_, verdicts| {
            flags.extend_from_slice(verdicts);
            Ok(())
        })?;
        Ok((flags, totals))
    }

    /// Judges all rows, and returns the verdicts with the table of streaks: one row for each exposure and satellite.
    pub fn judge_with_streaks(&self) -> anyhow::Result<(Vec<Verdict>, Table)> {
        let mut flags = Vec::with_capacity(self.schedule.exposures.len());
        let mut streaks: BTreeMap<usize, Vec<Vec<Cell>>> = BTreeMap::new();
        self.judge_and_see(
            &mut |sky, first, verdicts| {
                streaks.insert(first, self.streaks(sky, &self.schedule.exposures[first..], verdicts).rows);
            },
            &mut |_, verdicts| {
                flags.extend(verdicts.iter().map(|verdict| Verdict { passes: Vec::new(), ..verdict.clone() }));
                Ok(())
            },
        )?;
        Ok((
            flags,
            Table { rows: streaks.into_values().flatten().collect(), ..streak_table([], self.streak_columns()) },
        ))
    }

    fn streak_columns(&self) -> StreakColumns {
        StreakColumns { p_brighter: self.plan.policy.has_limit(), ..StreakColumns::default() }
    }

    /// Returns the streaks of judged rows.
    fn streaks(&self, sky: &Sky, rows: &[ScheduledExposure], flags: &[Verdict]) -> Table {
        let policy = &self.plan.policy;
        let request = self.plan.request(sky);
        let judged = rows.iter().zip(flags).filter_map(|(row, flag)| Some((row, row.exposure.as_ref().ok()?, flag)));
        let rows = judged.flat_map(|(row, exposure, flag)| {
            let band = row.band.as_deref();
            let limit_mag = policy.limit_mag.as_ref().and_then(|limit| limit.limit_in(band));
            flag.passes.iter().map(move |pass| request.streak_row((exposure, row.open_s), pass, band, limit_mag))
        });
        streak_table(rows, self.streak_columns())
    }
}

/// Divides the rows of a schedule from `first` to `last` into parts with the same satellites: nights, if there are
/// several and the files have element sets of several epochs. The inputs are returned if there are several skies.
fn parts_and_inputs(
    config: &Config,
    schedule: &Schedule,
    (first, last): (Epoch, Epoch),
) -> anyhow::Result<(Vec<Part>, Option<LoadedInputs>)> {
    let longitude_rad = config.viewpoint_longitude_rad(Some(first))?;
    let night = |epoch| evening_mjd(epoch, longitude_rad);
    if night(first) == night(last) {
        return Ok((parts(config, schedule, (first, last))?, None));
    }
    let inputs = config.load()?;
    let parts = match inputs.epochs_of_choice() {
        // Nights before and after all epochs have the same sets, but their own periods of constellations that grow.
        Some([oldest, newest]) => {
            let deployment = config.deployment()?;
            let key = |start| {
                let evening = night(start);
                (deployment.periods_begun(evening), evening.clamp(night(oldest) - 1, night(newest) + 1))
            };
            divided(schedule, key)
        }
        None => parts(config, schedule, (first, last))?,
    };
    Ok((parts, Some(inputs)))
}

/// Divides the rows of a schedule from `first` to `last` into parts of the same periods of constellations that grow.
pub fn parts(config: &Config, schedule: &Schedule, (first, last): (Epoch, Epoch)) -> anyhow::Result<Vec<Part>> {
    let deployment = config.deployment()?;
    if deployment.periods().next().is_none() {
        let rows = std::iter::once(0..schedule.exposures.len()).collect();
        return Ok(vec![Part { rows, span: (first, last) }]);
    }
    let longitude_rad = config.viewpoint_longitude_rad(Some(first))?;
    Ok(divided(schedule, |start| deployment.periods_begun(evening_mjd(start, longitude_rad))))
}

/// Divides the rows of a schedule into parts with the same key, a function of the shutter opening.
fn divided<Key: Ord>(schedule: &Schedule, key: impl Fn(Epoch) -> Key) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut by_key: BTreeMap<Key, usize> = BTreeMap::new();
    let mut previous = None;
    for (row, scheduled) in schedule.exposures.iter().enumerate() {
        let Ok(exposure) = &scheduled.exposure else { continue };
        let (start, end) = (exposure.start, seconds_after(exposure.start, exposure.duration_s));
        let part = *by_key.entry(key(start)).or_insert_with(|| {
            parts.push(Part { rows: Vec::new(), span: (start, end) });
            parts.len() - 1
        });
        let span = &mut parts[part].span;
        *span = (span.0.min(start), span.1.max(end));
        // Rows without a valid time are in the part of the row before them, those at the beginning in the first part.
        if previous != Some(part) {
            let begin = if previous.is_none() { 0 } else { row };
            parts[part].rows.push(begin..begin);
        }
        if let Some(before) = previous.filter(|before| *before != part)
            && let Some(rows) = parts[before].rows.last_mut()
        {
            rows.end = row;
        }
        previous = Some(part);
    }
    if let Some(rows) = previous.and_then(|part| parts[part].rows.last_mut()) {
        rows.end = schedule.exposures.len();
    }
    parts
}

/// States the satellites of each period, if there are several; `starts` are the first shutter openings of the periods.
pub fn state_periods(
    provenance: &mut Provenance,
    inputs: &LoadedInputs,
    starts: impl Iterator<Item = Epoch>,
) -> anyhow::Result<()> {
    let mut starts: Vec<Epoch> = starts.collect();
    starts.sort();
    if starts.len() > 1 {
        let stated = starts.into_iter().map(|first| inputs.period_json(first));
        provenance.state("periods", stated.collect::<Result<Vec<Value>, _>>()?);
    }
    Ok(())
}

/// Reports on a schedule in which no row can be judged.
fn invalid_rows(schedule: &Schedule, take: Take<'_>) -> anyhow::Result<FlagTotals> {
    let mut totals = FlagTotals::default();
    for rows in schedule.exposures.chunks(ROWS_AT_A_TIME) {
        let reasons = rows.iter().filter_map(|row| Some((row, row.exposure.as_ref().err()?)));
        let flags = reasons.map(|(row, reason)| Verdict::invalid(&row.id, reason.clone())).collect();
        let report = FlagReport { flags, ..FlagReport::default() };
        totals.add(&report);
        take(rows, &report.flags)?;
    }
    Ok(totals)
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
