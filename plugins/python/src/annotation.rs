//! Annotation of schedule files: verdicts and streaks of all nights, in the rows' order.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use streakcast::Watch;
use streakcast::config::{PreparedSky, parse_time_scale, state_scales};
use streakcast::message::Quoted;
use streakcast::output::{AtomicFile, Provenance, Table, Value, counted};
use streakcast::schedule::{
    Annotation, Schedule, ScheduledExposure, StreakColumns, Verdict, VerdictKind, annotate, check_extension,
    check_not_annotated, flag_exposures, flag_table, streak_table,
};

use super::engine::{Engine, WithWarnings};
use crate::exposures::scale_name;
use crate::failure;

impl Engine {
    /// Writes a copy of a schedule file with verdicts and streaks. Returns the paths of the written files.
    pub(crate) fn annotated(
        &self,
        path: &Path,
        output: &Path,
        scale: Option<&str>,
        replace: bool,
        watch: &Watch,
    ) -> PyResult<WithWarnings<Vec<PathBuf>>> {
        let mut options = self.setup.schedule_options().map_err(failure::setup)?;
        options.default_time_scale = options.time_scale.take().or(options.default_time_scale);
        options.time_scale = scale.map(parse_time_scale).transpose().map_err(failure::request)?;
        let schedule = Schedule::read(path, &options).map_err(failure::request)?;
        check_extension(path, schedule.format, output).map_err(failure::request)?;
        if !replace {
            check_not_annotated(path, schedule.format).map_err(failure::request)?;
        }
        AtomicFile::check(output).map_err(|error| failure::request(format!("{}: {error}", output.display())))?;
        let columns = StreakColumns { p_brighter: self.policy.has_limit(), ..StreakColumns::default() };
        let mut by_row: BTreeMap<usize, Vec<Vec<Value>>> = BTreeMap::new();
        let mut periods: Vec<serde_json::Value> = Vec::new();
        let mut provenance: Option<Provenance> = None;
        let field = self.field()?;
        let mut each = |prepared: &PreparedSky, rows: &[&ScheduledExposure], flags: &mut [Verdict]| {
            provenance.get_or_insert_with(|| {
                // The satellites may be those of a model with other options.
                let mut stated = prepared.provenance.clone();
                stated.state("settings_files", self.setup.settings_json());
                stated
            });
            // Constellations that grow differ from night to night.
            let starts = rows.iter().filter_map(|row| row.exposure.as_ref().ok()).map(|exposure| exposure.start);
            if let Some(first) = starts.min() {
                prepared.add_period(first, &mut periods);
            }
            let request = self.request(field, prepared);
            for (row, flag) in rows.iter().zip(flags) {
                let (Ok(exposure), false) = (&row.exposure, flag.passes.is_empty()) else { continue };
                let band = row.band.as_deref();
                let limit_mag = self.policy.limit_mag_in(band);
                let streaks =
                    flag.passes.iter().map(|pass| request.streak_row((exposure, row.open_s), pass, band, limit_mag));
                by_row.insert(row.row, streak_table(streaks, columns).rows);
                // Of many nights only the rows are kept.
                flag.passes = Vec::new();
            }
        };
        let (flags, warnings) = self.report(&schedule.exposures, &self.policy, flag_exposures, &mut each, watch)?;
        let streaks = Table { rows: by_row.into_values().flatten().collect(), ..streak_table([], columns) };
        let mut provenance = provenance.unwrap_or_default();
        state_scales(&mut provenance, &scale_name(schedule.time_scale), &self.photometry);
        provenance.state("schedule", schedule.statement(path));
        if periods.len() > 1 {
            provenance.state("periods", periods);
        }
        let telescope = self.telescope.as_ref().map(|telescope| telescope.name.as_str());
        provenance.state("options", self.setup.flag_options(&self.policy, telescope));
        let annotation =
            Annotation { flags: &flag_table(&flags), streaks: &streaks, provenance: &provenance, replace, keep: None };
        let written = annotate(path, schedule.format, output, &annotation).map_err(failure::request)?;
        let mut all = schedule.warnings(&self.policy);
        all.extend(warnings);
        all.extend(invalid_warning(&flags));
        Ok((written, all))
    }
}

/// Returns a warning about exposures of invalid rows, with the first one; `None` if there are none.
fn invalid_warning(flags: &[Verdict]) -> Option<String> {
    let mut invalid = flags.iter().filter(|flag| flag.kind == VerdictKind::Invalid);
    let first = invalid.next()?;
    let count = counted(1 + invalid.count(), "exposure is", "exposures are");
    Some(format!("{count} invalid; first {}: {}", Quoted::new(&first.exposure_id), first.reasons.join("; ")))
}
