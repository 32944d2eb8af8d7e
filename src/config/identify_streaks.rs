//! Identification of all streaks of tables.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hifitime::Epoch;

use super::document::Config;
use super::identify::IdentifyConfig;
use super::identify_plan::{IdentifiedStreak, IdentifyPlan, IdentifySettings};
use super::identify_table::{TableStreak, TableStreaks, streaks_of_table};
use super::measured_tables::rows_left_out;
use super::prepared::PreparedSky;
use crate::error::{Error, ErrorKind};
use crate::identify::{candidate_table, streak_table};
use crate::message::first_of;
use crate::orbit::LeftOut;
use crate::output::{Column, Kind, Provenance, Table, Value};
use crate::watch::Watch;

/// Function that returns a prepared sky for an interval, for callers that cache skies.
pub type SkyOver<'a> = &'a (dyn Fn(Epoch, Epoch) -> Result<Arc<PreparedSky>, Error> + Sync);

/// Tables of streaks: CSV, ECSV or FITS with their ends, streaks.txt of ASTRiDE, catalogs of findsat_mrt, or regions of
/// DS9.
#[derive(Copy, Clone, Debug)]
pub struct StreakTables<'a> {
    /// Files.
    pub paths: &'a [PathBuf],
    /// Folder to which names of frames in the tables are relative; that of each table if `None`.
    pub folder: Option<&'a Path>,
}

/// Candidates of the streaks of tables.
#[derive(Clone, Debug)]
pub struct IdentifiedStreaks {
    /// Candidates of all streaks. The first columns are `streak` and `image`.
    pub candidates: Table,
    /// The streaks that were compared with the satellites, one row each, with `streak` and `image` in front. The last
    /// columns are `candidates`, the number of candidates, and `unknown_probability`.
    pub streaks: Table,
    /// Names of the streaks that no satellite fits.
    pub without_candidate: Vec<String>,
    /// Satellites of each sky whose positions cannot be computed, with a warning if none before is the same.
    pub left_out: Vec<(Option<String>, Vec<LeftOut>)>,
    /// Provenance of the last sky, with a site only if it is that of all skies; that of no sky if no table has a
    /// streak.
    pub provenance: Provenance,
    /// Remarks about columns, and about sites and times in headers.
    pub remarks: Vec<String>,
    /// Warnings, among them those about rows that are left out.
    pub warnings: Vec<String>,
}

/// Largest number of skies that are kept, for tables whose rows alternate between frames.
const MOST_SKIES: usize = 2;

/// Sky of the streaks of one frame.
struct SkyOfFrame {
    image: Option<PathBuf>,
    span: (Epoch, Epoch),
    prepared: PreparedSky,
    /// True if the satellites without a position are listed.
    is_listed: bool,
}

/// Identifies all streaks of tables. Rows that cannot be used are left out, with a warning. `base` has the values for
/// all streaks, and the frame of rows without an image.
///
/// `sky` returns the sky for the time of a streak; by default it is prepared from the configuration, whose site is that
/// of the header of the frame if it has none.
///
/// # Errors
/// A table cannot be read, the sky cannot be prepared, or no row can be used.
pub fn identify_streaks(
    tables: StreakTables<'_>,
    base: &IdentifyConfig,
    config: &Config,
    settings: &IdentifySettings,
    sky: Option<SkyOver<'_>>,
    watch: &Watch,
) -> Result<IdentifiedStreaks, Error> {
    let mut all = IdentifiedStreaks::new();
    let (mut invalid, mut of_observer) = (Vec::new(), Vec::new());
    base.check_common(config)?;
    let mut has_sky = false;
    let mut skies: VecDeque<SkyOfFrame> = VecDeque::new();
    for path in tables.paths {
        let TableStreaks { streaks, invalid: of_table, remarks, without_ends } =
            streaks_of_table(path, tables.folder, base)?;
        invalid.extend(of_table);
        all.remarks.extend(remarks);
        all.warnings.extend(without_ends);
        for row in streaks {
            watch.check()?;
            let resolved = row.streak.with_site_of_frame(config.clone()).and_then(|(at_site, site)| {
                let plan = row.streak.resolve(&at_site)?;
                Ok((at_site, site, plan))
            });
            let (at_site, site, plan) = match resolved {
                Ok(resolved) => resolved,
                Err(error) => {
                    invalid.push(row.origin.of(error));
                    continue;
                }
            };
            let span = plan.span();
            let known = skies.iter().position(|known| known.image == row.streak.image && known.span == span);
            let of_frame = match known.and_then(|known| skies.remove(known)) {
                Some(known) => known,
                None => {
                    let prepared = match sky {
                        Some(sky) => sky(span.0, span.1)?,
                        None => prepared_at(&at_site, span, &mut all.warnings)?,
                    };
                    all.add_remarks(site.into_iter().chain(plan.remarks.iter().cloned()));
                    all.add_provenance(&prepared.provenance, !has_sky);
                    has_sky = true;
                    let prepared = prepared.watched(watch);
                    SkyOfFrame { image: row.streak.image.clone(), span, prepared, is_listed: false }
                }
            };
            // The sky that was used last is the first one.
            skies.truncate(MOST_SKIES - 1);
            skies.push_front(of_frame);
            let of_frame = &mut skies[0];
            match plan.identify(&at_site, &of_frame.prepared, settings) {
                Ok(found) => {
                    let of_row = found.found.unknown_observer.iter();
                    of_observer.extend(of_row.map(|warning| format!("{}: {warning}", row.origin)));
                    if !std::mem::replace(&mut of_frame.is_listed, true) {
                        all.add_left_out(found.left_out.clone(), found.found.left_out.clone());
                    }
                    all.add(&row, &plan, found);
                }
                Err(error) if error.kind() == ErrorKind::Cancelled => return Err(error),
                Err(error) => invalid.push(row.origin.of(error)),
            }
        }
    }
    if let Some(first) = invalid.first().filter(|_| all.streaks.rows.is_empty()) {
        return Err(first.clone());
    }
    all.warnings.extend(first_of(of_observer, "streaks with such a telescope"));
    all.warnings.extend(rows_left_out(&invalid));
    Ok(all)
}

/// Prepares the sky of a configuration, and adds its warnings that are not there yet.
fn prepared_at(
    config: &Config,
    (first, last): (Epoch, Epoch),
    warnings: &mut Vec<String>,
) -> Result<Arc<PreparedSky>, Error> {
    let mut prepared = config.prepare(first, last)?;
    config.state_scales(&mut prepared.provenance, &config.photometry()?);
    warnings
        .extend(prepared.warnings.iter().filter(|warning| !warnings.contains(warning)).cloned().collect::<Vec<_>>());
    Ok(Arc::new(prepared))
}

impl IdentifiedStreaks {
    fn new() -> Self {
        let mut candidates = candidate_table(std::iter::empty());
        candidates.columns.splice(0..0, STREAK_COLUMNS);
        let measured = streak_table([]).columns;
        let columns = STREAK_COLUMNS.into_iter().chain(measured).chain(RESULT_COLUMNS).collect();
        Self {
            candidates,
            streaks: Table { columns, rows: Vec::new() },
            without_candidate: Vec::new(),
            left_out: Vec::new(),
            provenance: Provenance::new(),
            remarks: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// Adds remarks that are not there yet.
    fn add_remarks(&mut self, remarks: impl Iterator<Item = String>) {
        for remark in remarks {
            if !self.remarks.contains(&remark) {
                self.remarks.push(remark);
            }
        }
    }

    /// Replaces the provenance by that of another sky. The site is stated only if it is the same.
    fn add_provenance(&mut self, of_sky: &Provenance, is_first: bool) {
        let is_same_site = is_first || self.provenance.get("site") == of_sky.get("site");
        self.provenance = of_sky.clone();
        if !is_same_site {
            self.provenance.remove("site");
        }
    }

    /// Adds the satellites of a sky whose positions cannot be computed.
    fn add_left_out(&mut self, warning: Option<String>, satellites: Vec<LeftOut>) {
        let is_stated = self.left_out.iter().any(|(stated, _)| *stated == warning);
        self.left_out.push((warning.filter(|_| !is_stated), satellites));
    }

    /// Adds the candidates of a row.
    fn add(&mut self, row: &TableStreak, plan: &IdentifyPlan, identified: IdentifiedStreak) {
        let IdentifiedStreak { found, candidates, .. } = identified;
        let image = row.streak.image.as_ref().map(|image| image.display().to_string());
        let named = || [Value::Text(row.id.clone()), image.clone().into()];
        if candidates.rows.is_empty() {
            self.without_candidate.push(row.id.clone());
        }
        let named_rows = candidates.rows.into_iter().map(|cells| named().into_iter().chain(cells).collect());
        self.candidates.rows.extend(named_rows);
        let results = [found.candidates.len().into(), found.unknown_probability.into()];
        let measured = streak_table([&plan.streak]).rows.into_iter();
        let rows = measured.map(|cells| named().into_iter().chain(cells).chain(results.clone()).collect());
        self.streaks.rows.extend(rows);
    }
}

/// First columns of both tables: the streak and its frame.
const STREAK_COLUMNS: [Column; 2] = [
    Column::new("streak", Kind::Text, "Name of the streak in its table."),
    Column::new("image", Kind::Text, "File of the frame; empty for a streak without a frame."),
];

/// Last columns of the table of streaks.
const RESULT_COLUMNS: [Column; 2] = [
    Column::new("candidates", Kind::Integer, "Number of candidates, including those that are not listed."),
    Column::real(
        "unknown_probability",
        "",
        6,
        "Probability that the streak is of a satellite that is missing in the elements.",
    ),
];
