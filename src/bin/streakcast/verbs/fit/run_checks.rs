//! What can be said of a `fit run` before its work: options, names, and whether every file can be written.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::fit::inference::check_walkers;
use streakcast::photometry::ModelFile;

use super::arguments::FitRunArguments;
use super::form::Chosen;
use super::report;
use crate::output::{Output, check};

/// Where the model file goes, once nothing is wrong.
pub fn checked(typed: &FitRunArguments, chosen: &Chosen) -> anyhow::Result<Output> {
    let output = Output::new(Some("json"), Some(typed.output.clone()))?;
    distinct(typed)?;
    if let Some(chains) = &typed.chains {
        check(chains)?;
    }
    if let Some(report) = &typed.report {
        report::check_name(report)?;
        report::files(report).iter().try_for_each(|file| check(file))?;
    }
    let free = chosen.settings.free.len();
    if let Some(steps) = typed.mcmc {
        if typed.burn_in >= steps {
            return Err(anyhow!("burn-in {}; allowed: less than the {steps} steps of --mcmc", typed.burn_in));
        }
        check_walkers(typed.walkers, free)?;
    }
    if typed.form.folds == 1 {
        return Err(anyhow!("folds 1; allowed: 0, or 2 or more"));
    }
    let is_reduced = !typed.reduction.raw_points;
    if is_reduced && typed.jackknife > 0 && typed.jackknife <= free {
        return Err(anyhow!(
            "jackknife {}; allowed: more than the {free} free parameters, or 0 for none",
            typed.jackknife
        ));
    }
    if let Some(date) = typed.date.as_deref().filter(|date| !is_date(date)) {
        return Err(anyhow!("date {date}; allowed: a month as 2026-11, or a day as 2026-11-22"));
    }
    // Names as the model file will hold them.
    let mut file = chosen.file.clone();
    file.name = typed.name.clone().unwrap_or(file.name);
    file.provenance.data = typed.data.clone().unwrap_or(file.provenance.data);
    ModelFile::validate(&file, "to be written")?;
    Ok(output)
}

/// That no output stands where another does, or where the photometry is.
fn distinct(typed: &FitRunArguments) -> anyhow::Result<()> {
    let reports = typed.report.iter().flat_map(|report| report::files(report));
    let outputs = std::iter::once(typed.output.clone()).chain(typed.chains.clone()).chain(reports);
    let mut taken: Vec<PathBuf> = typed.photometry.tables.photometry.iter().map(|path| place_of(path)).collect();
    for path in outputs {
        let place = place_of(&path);
        if taken.contains(&place) {
            return Err(anyhow!("{} is named twice; every output needs a file of its own", path.display()));
        }
        taken.push(place);
    }
    Ok(())
}

/// Folder and name, whatever way they are written.
fn place_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    folder.canonicalize().unwrap_or_else(|_| folder.to_owned()).join(path.file_name().unwrap_or_default())
}

/// A month or a day that there is.
fn is_date(text: &str) -> bool {
    let digits = |part: &str, length: usize| part.len() == length && part.bytes().all(|byte| byte.is_ascii_digit());
    let parts: Vec<&str> = text.split('-').collect();
    let (year, month, day) = match parts[..] {
        [year, month] => (year, month, "01"),
        [year, month, day] => (year, month, day),
        _ => return false,
    };
    let [Ok(month), Ok(day)] = [month, day].map(str::parse::<u8>) else { return false };
    digits(year, 4)
        && parts[1..].iter().all(|part| digits(part, 2))
        && year.parse().is_ok_and(|year| Epoch::maybe_from_gregorian_utc(year, month, day, 0, 0, 0, 0).is_ok())
}

/// As `2026-11`.
pub fn this_month() -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let (year, month, ..) = Epoch::from_unix_seconds(since_1970.as_secs_f64()).to_gregorian_utc();
    format!("{year:04}-{month:02}")
}
