//! Tables of streaks that are measured: the frames of their rows, and the satellites of the streaks.

use std::path::{Component, Path, PathBuf};

use super::identify::{POSITION_SIGMA_PIX, TIME_SIGMA_S};
use crate::error::Error;
use crate::frames::seconds_between;
use crate::identify::{IdentifyOptions, MeasuredStreak, Timing, identify_streak};
use crate::measure::{KnownSatellite, ListedStreak, StreakList};
use crate::message::{Quoted, first_of};
use crate::orbit::LeftOut;
use crate::passes::Sky;
use crate::photometry::PhotometryOptions;
use crate::streaks::TargetFrame;

/// Smallest probability of a satellite with which a streak is named.
const LIKELY: f64 = 0.5;

/// Share of the exposure from which the time between the ends is that of the whole exposure.
const WHOLE_SHARE: f64 = 0.97;

/// Tables of streaks, with the frames of their rows.
#[derive(Clone, Debug, Default)]
pub(super) struct MeasuredTables {
    /// Frames: those that are given, and then those that rows name.
    pub frames: Vec<PathBuf>,
    /// Remarks about the columns of the tables.
    pub remarks: Vec<String>,
    /// Errors of rows, which are left out.
    pub invalid: Vec<Error>,
    /// Each table with its frame; `None` for the only table, whose rows are of all frames.
    tables: Vec<(StreakList, Option<PathBuf>)>,
}

impl MeasuredTables {
    /// Reads tables and finds the frames of their rows: the given `frames` of that name, or else the file relative to
    /// `folder`, or to that of the table. Rows of a single table without a name are of all frames; those of several
    /// tables are of the frame at the place of the table.
    ///
    /// # Errors
    /// A table is invalid, or no row is valid.
    pub fn read(tables: &[PathBuf], folder: Option<&Path>, frames: &[PathBuf]) -> Result<Self, Error> {
        let mut found = Self { frames: frames.to_vec(), ..Self::default() };
        for (number, path) in tables.iter().enumerate() {
            let mut list = StreakList::read(path)?;
            found.remarks.append(&mut list.remarks);
            found.invalid.append(&mut list.invalid);
            let folder = folder.or(path.parent()).unwrap_or(Path::new(""));
            for mut streak in std::mem::take(&mut list.streaks) {
                let of_row = |error: Error| streak.origin.of(error);
                let file = match &streak.image {
                    Some(image) => frame_of(image, folder, frames).map(Some).map_err(of_row),
                    None if tables.len() == 1 && !frames.is_empty() => Ok(None),
                    None if tables.len() == frames.len() => Ok(None),
                    None => {
                        let given =
                            format!("missing, with {} tables of streaks and {} frames", tables.len(), frames.len());
                        let allowed = "the file of the frame, or one table, or as many tables as FRAME...";
                        Err(of_row(Error::invalid("image", given, allowed)))
                    }
                };
                match file {
                    Ok(file) => {
                        streak.image = file.as_ref().map(|file| file.display().to_string());
                        found.frames.extend(file.filter(|file| !found.frames.contains(file)));
                        list.streaks.push(streak);
                    }
                    Err(error) => found.invalid.push(error),
                }
            }
            let of_table = (tables.len() > 1).then(|| frames.get(number).cloned()).flatten();
            found.tables.push((list, of_table));
        }
        match found.invalid.first() {
            Some(first) if found.tables.iter().all(|(list, _)| list.streaks.is_empty()) => Err(first.clone()),
            _ => Ok(found),
        }
    }

    /// Adds the rows that name a frame to the invalid ones.
    pub fn leave_out_rows_of(&mut self, frame: &Path, error: &Error) {
        let streaks = self.tables.iter().flat_map(|(list, _)| &list.streaks);
        let rows = streaks.filter(|streak| streak.image.as_ref().is_some_and(|image| Path::new(image) == frame));
        self.invalid.extend(rows.map(|row| row.origin.of(error.clone())));
    }

    /// Returns the streaks of a frame, in the order of the tables.
    pub fn streaks_of(&self, frame: &Path) -> Vec<ListedStreak> {
        let rows = self.tables.iter().flat_map(|(list, of_table)| {
            list.streaks.iter().filter(move |streak| match (&streak.image, of_table) {
                (None, Some(of_table)) => of_table == frame,
                (None, None) => true,
                (Some(image), _) => Path::new(image) == frame,
            })
        });
        rows.cloned().collect()
    }
}

/// Returns the frame of a row with this name: the only one of `frames` with this end of its path, or the one in the
/// folder of the table, or else a file there.
///
/// # Errors
/// There is no such frame, or there are several.
pub(super) fn frame_of(image: &str, folder: &Path, frames: &[PathBuf]) -> Result<PathBuf, Error> {
    let invalid = |allowed| Error::invalid("image", format!("'{}'", Quoted::new(image)), allowed);
    let plain = |path: &Path| -> PathBuf { path.components().filter(|part| *part != Component::CurDir).collect() };
    let file = folder.join(image);
    let named: Vec<&PathBuf> = frames.iter().filter(|frame| plain(frame).ends_with(plain(Path::new(image)))).collect();
    match named[..] {
        [only] => Ok(only.clone()),
        [] if file.is_file() => Ok(file),
        [] => Err(invalid("the name of a given frame, or a file in the folder of the table")),
        _ => {
            let in_folder = named.iter().find(|frame| plain(frame) == plain(&file));
            in_folder
                .map(|frame| (*frame).clone())
                .ok_or_else(|| invalid("the name of one frame with its folder, because several have this name"))
        }
    }
}

/// Returns warnings about rows of tables of streaks that are left out: the first three, and the number of the others.
pub(super) fn rows_left_out(invalid: &[Error]) -> Vec<String> {
    first_of(invalid.iter().map(|error| format!("{error}; the streak is left out")), "streaks left out")
}

/// Adds to each streak the satellite of the sky that has probably made it, or what the sky knows about the satellite
/// that the table names. Returns the satellites whose positions cannot be computed.
///
/// # Errors
/// Positions cannot be computed at the time of the frame.
pub(super) fn identify_listed(
    sky: &Sky,
    frame: &TargetFrame,
    streaks: &mut [ListedStreak],
    place_sigma_deg: Option<f64>,
    photometry: &PhotometryOptions,
) -> Result<Vec<LeftOut>, Error> {
    let options = IdentifyOptions { include_dark: false, photometry: *photometry };
    let mut left_out = Vec::new();
    for streak in streaks {
        let Some((ends, pixel_arcsec)) = streak.on_sky(frame) else { continue };
        let sigma_rad = place_sigma_deg.unwrap_or(POSITION_SIGMA_PIX * pixel_arcsec / 3600.0).to_radians();
        let time = (frame.opened, frame.exposure_s);
        // A streak that is too short or too long to be of a satellite keeps its row.
        let time_sigma_s = TIME_SIGMA_S.max(frame.start_sigma_s);
        let Ok(measured) = MeasuredStreak::from_ends(ends, time, Timing::Within, sigma_rad, time_sigma_s) else {
            continue;
        };
        let found = identify_streak(sky, &measured, &options)?;
        left_out = found.left_out;
        let best = match streak.satellite.norad_id {
            Some(named) => found.candidates.iter().find(|candidate| candidate.norad_id == named),
            None => found.candidates.first().filter(|best| best.probability >= LIKELY),
        };
        let Some(best) = best else { continue };
        streak.probability = streak.satellite.norad_id.is_none().then_some(best.probability);
        if let Some(given) = streak.given.as_mut().filter(|given| !given.has_times()) {
            // A streak that the satellite crosses in less than the exposure continues outside of the frame. Its light
            // is that of the time between the ends.
            let duration_s = ends[0].separation_rad(&ends[1]) / best.angular_rate_rad_s;
            if duration_s < WHOLE_SHARE * frame.exposure_s {
                let middle_s = seconds_between(frame.opened, best.passage.epoch);
                let from_s = (middle_s - 0.5 * duration_s).clamp(0.0, frame.exposure_s - duration_s);
                given.set_seconds([from_s, from_s + duration_s]);
            }
        }
        streak.satellite = KnownSatellite {
            norad_id: Some(best.norad_id),
            name: sky.elements()[best.element_index].name.clone(),
            element_age_days: Some(best.element_age_days),
            brightness: best.passage.brightness.clone(),
            geometry: Some(best.passage.geometry),
            range_km: Some(best.passage.range_km),
            model_size_m: Some(sky.model(best.element_index).size_m()),
            time_sigma_s: Some(best.along_track_s.sigma),
        };
    }
    Ok(left_out)
}
