//! Streaks of a table to be identified: one request for each row.

use std::io;
use std::path::{Path, PathBuf};

use super::error;
use super::identify::IdentifyConfig;
use super::identify_frame::{clipped, header};
use super::measured_tables::frame_of;
use crate::error::Error;
use crate::images::{Bounded, RowOrigin, StreakEnds, StreakRow, StreakTable};
use crate::input::Column;
use crate::message::listed;
use crate::units::SECONDS;

/// Largest number of streaks in a table.
const MOST_STREAKS: usize = 10_000;

/// Row of a table of streaks.
pub(super) struct TableStreak {
    /// Name of the streak: the column `id`, or the number of the row from 1.
    pub id: String,
    /// The table and its line, for errors.
    pub origin: RowOrigin,
    /// The streak.
    pub streak: IdentifyConfig,
}

/// Streaks of a table.
pub(super) struct TableStreaks {
    pub streaks: Vec<TableStreak>,
    /// Errors of rows, which are left out.
    pub invalid: Vec<Error>,
    /// Remarks about the columns.
    pub remarks: Vec<String>,
    /// Warning about rows without ends, which are left out.
    pub without_ends: Option<String>,
}

/// Columns of the times of a streak.
struct TimeColumns {
    start: Option<Column>,
    duration_s: Option<Bounded>,
}

/// Returns the streaks of a table (CSV, ECSV, ASTRiDE, a catalog of findsat_mrt, or regions of DS9).
///
/// The frame of a row is that of its column `image`: the frame of `base` if it has this name, or else a file relative
/// to `folder`, or to the folder of the table. Without this cell it is the frame of `base`. The columns `start_utc` and
/// `duration_s`, or else the values of `base`, replace the times in the header of the frame. Ends in pixels are those
/// of the part in the frame.
///
/// # Errors
/// The table cannot be read.
pub(super) fn streaks_of_table(
    path: &Path,
    folder: Option<&Path>,
    base: &IdentifyConfig,
) -> Result<TableStreaks, Error> {
    let others = [
        ("--end", !base.end.is_empty()),
        ("--ra", base.ra.is_some()),
        ("--from-pix", base.from_pix.is_some()),
        ("--region", base.region.is_some()),
        ("--times", !base.times.is_empty()),
    ];
    if let Some((first, _)) = others.into_iter().find(|(_, is_given)| *is_given) {
        return Err(error::both(first, "--streaks"));
    }
    let (table, times) =
        StreakTable::read(path, MOST_STREAKS, &["start_utc", "duration_s"], |rows| -> io::Result<_> {
            // In tables of measured streaks, durations are the times in the frame and not those of the exposure.
            let is_measured = rows.find("streak").is_some();
            let duration_s = Bounded::find(rows, &["duration_s"], &SECONDS, [0.0, 1e6])?.filter(|_| !is_measured);
            Ok(TimeColumns { start: rows.find("start_utc"), duration_s })
        })?;
    let folder = folder.or(path.parent()).unwrap_or(Path::new(""));
    let (mut streaks, mut invalid, mut without) = (Vec::new(), table.invalid().to_vec(), Vec::new());
    for row in table.rows() {
        if !row.has_ends() {
            without.push(row.id());
            continue;
        }
        match streak_of_row(&row, folder, base, &times) {
            Ok(streak) => streaks.push(TableStreak { id: row.id(), origin: row.origin(), streak }),
            Err(error) => invalid.push(row.origin().of(error)),
        }
    }
    let without_ends = (!without.is_empty()).then(|| {
        let names = listed(without.iter().map(String::as_str));
        format!("{}: streaks without ends are left out: {names}", path.display())
    });
    Ok(TableStreaks { streaks, invalid, remarks: table.remarks(), without_ends })
}

/// Returns the request for a row.
fn streak_of_row(
    row: &StreakRow<'_>,
    folder: &Path,
    base: &IdentifyConfig,
    times: &TimeColumns,
) -> Result<IdentifyConfig, Error> {
    let given: &[PathBuf] = base.image.as_slice();
    let named = row.image().map(|image| frame_of(image, folder, given)).transpose()?;
    let mut streak =
        IdentifyConfig { image: named.or_else(|| base.image.clone()), hdu: row.hdu()?.or(base.hdu), ..base.clone() };
    if let text @ [_, ..] = row.text(times.start).as_bytes() {
        streak.start = Some(String::from_utf8_lossy(text).into_owned());
    }
    if let Some(seconds) = row.number(times.duration_s)? {
        streak.exposure = Some(format!("{seconds}s"));
    }
    match row.ends()? {
        StreakEnds::Sky(ends) => {
            streak.end = ends
                .iter()
                .map(|end| format!("{},{}", end.longitude_rad().to_degrees(), end.latitude_rad().to_degrees()))
                .collect();
        }
        StreakEnds::Pixels(ends) => {
            let Some(frame) = &streak.image else {
                return Err(row.invalid("image", "", "the frame of a streak in pixels, or --image FRAME"));
            };
            let ends = if row.is_physical() {
                let header = header(frame, streak.hdu)?;
                ends.map(|end| end.of_physical(&header))
            } else {
                ends
            };
            let [from, to] = clipped(frame, streak.hdu, ends)?.map(|at| {
                let [x, y] = at.fits();
                Some(format!("{x},{y}"))
            });
            (streak.from_pix, streak.to_pix) = (from, to);
        }
    }
    Ok(streak)
}
