//! Element sets of earlier days beside a cached file: folder `NAME.days` with files `YYYY-MM-DD.EXTENSION`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::frames::{parse_moment, seconds_between};
use streakcast::output::{format_utc, write_atomically};

const DAY_S: f64 = 86_400.0;
/// Length of the blocks of which one file is kept, days: the ages are then near 3, 7 and 14 days at any time.
const BLOCK_DAYS: f64 = 4.0;
/// Largest age of a kept file, days.
const LONGEST_DAYS: f64 = 16.0;

/// Returns the folder with the element sets of several days.
pub fn folder_of_days(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(".days");
    PathBuf::from(name)
}

/// Writes the element sets downloaded at `now` into the folder of days. The newest file and the oldest one of each
/// block of four days are kept up to an age of 16 days, thus at most six files; others that have names of days are
/// removed.
///
/// # Errors
/// The folder or a file cannot be written or removed.
pub fn keep(file: &Path, bytes: &[u8], now: Epoch) -> anyhow::Result<()> {
    let folder = folder_of_days(file);
    let failed = |path: &Path, error: std::io::Error| anyhow!("cannot write {}: {error}", path.display());
    let extension = file.extension().unwrap_or_default().to_string_lossy().into_owned();
    let day = format_utc(now, 0)[..10].to_owned();
    let newest = folder.join(format!("{day}.{extension}"));
    write_atomically(&newest, |out| out.write_all(bytes)).map_err(|error| failed(&newest, error))?;
    let mut dated: Vec<(f64, PathBuf)> = Vec::new();
    for entry in fs::read_dir(&folder).map_err(|error| failed(&folder, error))? {
        let path = entry.map_err(|error| failed(&folder, error))?.path();
        dated.extend(age_days(&path, &extension, now).map(|age| (age, path)));
    }
    // Newest first, so that the last one of a block is its oldest.
    dated.sort_by(|a, b| a.0.total_cmp(&b.0));
    let today = mjd(&day)?;
    let block = |age: f64| ((today - age) / BLOCK_DAYS).floor();
    for (at, (age, path)) in dated.iter().enumerate() {
        let is_oldest = dated.get(at + 1).is_none_or(|(older, _)| block(*older) != block(*age));
        let is_kept = *age <= 0.0 || (is_oldest && *age <= LONGEST_DAYS);
        if !is_kept {
            fs::remove_file(path).map_err(|error| anyhow!("cannot remove {}: {error}", path.display()))?;
        }
    }
    Ok(())
}

/// Returns the age in whole days of a file with the name of a day; `None` for other files.
fn age_days(path: &Path, extension: &str, now: Epoch) -> Option<f64> {
    let day = path.file_name()?.to_str()?.strip_suffix(extension)?.strip_suffix('.')?;
    let is_day = day.len() == 10 && day.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-');
    let day = is_day.then(|| mjd(day).ok()).flatten()?;
    Some(mjd(&format_utc(now, 0)[..10]).ok()? - day)
}

/// Returns the modified Julian date of a day.
fn mjd(day: &str) -> anyhow::Result<f64> {
    let origin = parse_moment("1858-11-17T00:00:00Z", None)?;
    Ok((seconds_between(origin, parse_moment(&format!("{day}T00:00:00Z"), None)?) / DAY_S).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_a_year_of_daily_downloads_are_few_and_of_useful_ages() {
        let cache = tempfile::tempdir().unwrap();
        let file = cache.path().join("celestrak-active.csv");
        let start = parse_moment("2026-01-01T05:00:00Z", None).unwrap();
        let own = folder_of_days(&file).join("notes.csv");
        for day in 0..60 {
            let now = streakcast::frames::seconds_after(start, f64::from(day) * DAY_S);
            keep(&file, b"elements", now).unwrap();
            fs::write(&own, "of the user").unwrap();
            let mut ages: Vec<f64> = fs::read_dir(folder_of_days(&file))
                .unwrap()
                .filter_map(|entry| age_days(&entry.unwrap().path(), "csv", now))
                .collect();
            ages.sort_by(f64::total_cmp);
            assert!(ages.len() <= 6 && ages[0] == 0.0 && ages.iter().all(|age| *age <= LONGEST_DAYS), "{ages:?}");
            if day >= 20 {
                for wanted in [3.0, 7.0, 14.0] {
                    assert!(ages.iter().any(|age| (age - wanted).abs() <= 2.0), "day {day}: {ages:?}");
                }
            }
        }
        assert!(own.exists());
    }
}
