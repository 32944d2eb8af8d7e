//! Streaks of a table to be identified: one request for each row.

use std::io;
use std::path::{Path, PathBuf};

use super::error;
use super::identify::IdentifyConfig;
use super::identify_frame::clipped;
use crate::error::Error;
use crate::images::{Bounded, StreakEnds, StreakTable};
use crate::message::listed;
use crate::units::SECONDS;

/// Largest number of streaks in a table.
const MOST_STREAKS: usize = 10_000;

/// Row of a table of streaks.
#[derive(Clone, Debug, PartialEq)]
pub struct TableStreak {
    /// Name of the streak: the column `id`, or the number of the row from 1.
    pub id: String,
    /// The table and its line, for errors.
    pub origin: String,
    /// The streak.
    pub streak: IdentifyConfig,
}

/// Returns the streaks of a table (CSV, ECSV, ASTRiDE, a catalog of findsat_mrt, or regions of DS9), and remarks about its columns.
///
/// The frame of a row is that of its column `image`, relative to the folder of the table, or else that of `base`. Its
/// columns `start_utc` and `duration_s`, or else the values of `base`, replace the times in the header of the frame. Ends
/// in pixels are those of the part in the frame. Rows without ends are left out, which a remark states.
///
/// # Errors
/// The table cannot be read, a cell is invalid, or a streak in pixels has no frame.
pub fn streaks_of_table(path: &Path, base: &IdentifyConfig) -> Result<(Vec<TableStreak>, Vec<String>), Error> {
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
    let (table, (start, duration_s)) = StreakTable::read(path, |rows| -> io::Result<_> {
        // In tables of measured streaks, durations are the times in the frame and not those of the exposure.
        let is_measured = rows.find("streak").is_some();
        let duration_s = Bounded::find(rows, &["duration_s"], &SECONDS, [0.0, 1e6])?.filter(|_| !is_measured);
        Ok((rows.find("start_utc"), duration_s))
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut streaks, mut without) = (Vec::new(), Vec::new());
    for (row, number) in table.rows().zip(1..) {
        if number > MOST_STREAKS {
            return Err(row.invalid("number of streaks", &number.to_string(), format!("1 to {MOST_STREAKS}")));
        }
        if !row.has_ends() {
            without.push(row.id(number));
            continue;
        }
        let image: Option<PathBuf> = row.image().map(|image| folder.join(image)).or_else(|| base.image.clone());
        let hdu = row.hdu()?.or(base.hdu);
        let mut streak = IdentifyConfig { image, hdu, ..base.clone() };
        if let text @ [_, ..] = row.text(start).as_bytes() {
            streak.start = Some(String::from_utf8_lossy(text).into_owned());
        }
        if let Some(seconds) = row.number(duration_s)? {
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
                let [from, to] = clipped(frame, streak.hdu, ends)?.map(|at| {
                    let [x, y] = at.fits();
                    Some(format!("{x},{y}"))
                });
                (streak.from_pix, streak.to_pix) = (from, to);
            }
        }
        streaks.push(TableStreak { id: row.id(number), origin: row.origin().to_string(), streak });
    }
    let mut remarks = table.remarks(&["start_utc", "duration_s"]);
    if !without.is_empty() {
        let names = listed(without.iter().map(String::as_str));
        remarks.push(format!("{}: streaks without ends are left out: {names}", path.display()));
    }
    Ok((streaks, remarks))
}
