//! `fit run`: fits a model, and writes the model file with covariance and a report.

use std::iter::once;
use std::path::PathBuf;

use anyhow::anyhow;
use hifitime::Epoch;
use streakcast::ErrorKind;
use streakcast::fit::inference::check_walkers;
use streakcast::fit::{
    CompetingForm, CovarianceKind, Fit, FitPoint, FormScore, HeldOutPoint, ModelDescription, Problem, RawWeights,
    baseline_forms, compare_forms, faults, jackknife, model_file, points_of_measurements, predict,
};
use streakcast::photometry::ModelFile;

use super::arguments::{FitArguments, FitRunArguments, FitVerb};
use super::chains;
use super::form::{ChosenForm, form};
use super::points::{FitInput, read, weights};
use super::report::{self, FitResults};
use crate::failure::Outcome;
use crate::files::check_distinct;
use crate::output::{Output, check};

pub fn run(typed: FitArguments) -> anyhow::Result<Outcome> {
    match typed.verb {
        FitVerb::Run(typed) => typed.run(|typed| fit(&typed)),
        FitVerb::Compare(typed) => typed.run(super::compare::compare),
        FitVerb::Reduce(typed) => typed.run(super::reduce::reduce),
        FitVerb::Identify(typed) => typed.run(super::reduce::identify),
    }
}

fn fit(typed: &FitRunArguments) -> anyhow::Result<Outcome> {
    let chosen = form(&typed.form, typed.reduction.raw_points)?;
    let output = checked(typed, &chosen)?;
    let mut input = read(&typed.photometry, &typed.reduction, &weights(&typed.weights)?)?;
    input.weigh(&chosen, &typed.weights)?;
    let problem = Problem::new(chosen.form.as_form(), &input.points, &chosen.settings)?;
    // A saved chain of another fit is an error, which is reported before the computation.
    let sampling = typed.mcmc.map(|steps| chains::prepare(typed, &input, &problem, steps)).transpose()?;
    let notices = &input.notices;
    notices.warn(&input.band_mismatch(chosen.band));
    let fit = with_jackknife(typed.jackknife, &chosen, &input, problem.solve()?)?;
    let in_sample = fit.statistics(&input.points).ok_or_else(|| {
        anyhow!("no point was fitted; allowed: photometry of satellites with sunlit surfaces in the model")
    })?;
    notices.info(&format!(
        "{} points, {} parameters: RMS {:.3} mag, core {:.3} mag",
        in_sample.n,
        fit.free.len(),
        in_sample.rms_mag,
        in_sample.core_mag
    ));
    let faults = faults(&problem, &fit);
    let standings = standings(typed, &chosen, &input)?;
    let singles = single(&chosen, &input, &fit);
    let drawn = sampling.map(|run| chains::sample(typed, &input, &problem, &fit, run)).transpose()?;
    let results = FitResults {
        typed,
        chosen: &chosen,
        input: &input,
        problem: &problem,
        fit: &fit,
        faults: &faults,
        standings: &standings,
        singles: &singles,
        posterior: drawn.as_ref().map(|(chain, posterior)| (chain, posterior)),
    };
    let file = file(&results)?;
    output.write_text(&(file.to_json() + "\n"), notices)?;
    if let Some(path) = &typed.report {
        report::write(path, &results, &file)?;
    }
    for fault in &faults {
        notices.info(&format!("not sound: {fault}"));
    }
    Ok(if faults.is_empty() { Outcome::Done } else { Outcome::No })
}

/// Replaces the covariance of a fit to pixels by that of a jackknife over sets of tracks, because several pixels
/// contain measurements of the same track.
fn with_jackknife(sets: usize, chosen: &ChosenForm, input: &FitInput, fit: Fit) -> anyhow::Result<Fit> {
    let Some(reduction) = input.reduction.as_ref().filter(|_| sets > 0) else { return Ok(fit) };
    match jackknife(chosen.form.as_form(), &input.measurements, reduction.options, &fit, &chosen.settings, sets) {
        Ok(covariance) => Ok(fit.with_covariance(covariance, CovarianceKind::Jackknife)),
        // There are too few tracks, for example in a table without track names.
        Err(problem) if problem.kind() == ErrorKind::TooFewData => {
            input
                .notices
                .info(&format!("warning: errors are too small, with pixels assumed to be independent: {problem}"));
            Ok(fit)
        }
        Err(problem) => Err(problem.into()),
    }
}

/// Compares the form with baseline models on the same held-out folds.
fn standings(typed: &FitRunArguments, chosen: &ChosenForm, input: &FitInput) -> anyhow::Result<Vec<FormScore>> {
    if typed.form.folds == 0 {
        return Ok(Vec::new());
    }
    let own =
        CompetingForm { name: chosen.file.name.clone(), form: chosen.form.boxed(), free: chosen.settings.free.clone() };
    let mut entrants = vec![own];
    entrants.extend(baseline_forms(chosen.form.as_two_panels().as_ref()));
    let standings = match compare_forms(&entrants, &input.points, input.tracks(), &chosen.settings, typed.form.folds) {
        Ok(standings) => standings,
        // Cross-validation is not possible for one night or few pixels; the fit is valid without it.
        Err(problem) if problem.kind() == ErrorKind::TooFewData => {
            input.notices.info(&format!("warning: no cross-validation: {problem}"));
            return Ok(Vec::new());
        }
        Err(error) => return Err(error.into()),
    };
    for standing in &standings {
        input.notices.info(&format!(
            "  held out: {:<22} k {} RMS {:.3} core {:.3} mag, {:.0} % within one sigma",
            standing.name,
            standing.parameters,
            standing.held_out.rms_mag,
            standing.held_out.core_mag,
            100.0 * standing.within_one_sigma
        ));
    }
    Ok(standings)
}

/// Returns the residuals of single measurements from the fit, mag, with their weights.
fn single(chosen: &ChosenForm, input: &FitInput, fit: &Fit) -> Vec<(f64, f64)> {
    let points: Vec<FitPoint> = match input.reduction {
        Some(_) => points_of_measurements(&input.measurements, &RawWeights::default()),
        None => input.points.clone(),
    };
    let predicted = predict(chosen.form.as_form(), &points, &fit.values());
    let residuals = points.iter().zip(predicted).map(|(point, predicted)| (point.magnitude - predicted, point.weight));
    residuals.filter(|(r, _)| r.is_finite()).collect()
}

fn file(results: &FitResults) -> anyhow::Result<ModelFile> {
    let FitResults { typed, chosen, input, problem, fit, .. } = results;
    // Median and sigma are those of new single measurements. They are computed from held-out measurements if there are
    // any.
    let own = results.standings.first().filter(|_| typed.reduction.raw_points);
    let (singles, origin) = match own {
        Some(own) => (
            own.held_out_points.iter().map(HeldOutPoint::weighted_residual).collect(),
            format!("holds 68.3 % of single measurements of held-out tracks or nights ({} folds)", typed.form.folds),
        ),
        None => (results.singles.to_vec(), "holds 68.3 % of the single measurements, in sample".to_owned()),
    };
    let files: Vec<String> = typed.photometry.tables.photometry.iter().map(|path| path.display().to_string()).collect();
    let base = &chosen.file;
    let description = ModelDescription {
        name: typed.name.clone().unwrap_or_else(|| format!("{}-fit", base.name)),
        title: format!("{} fitted to photometry", base.title.split(',').next().unwrap_or(&base.title)),
        source: format!("streakcast {} fit run, form of {}", env!("CARGO_PKG_VERSION"), base.name),
        data: typed.data.clone().unwrap_or_else(|| files.join(", ")),
        date: typed.date.clone().unwrap_or_else(this_month),
        provisional: !results.faults.is_empty(),
        notes: notes(typed, input, chosen),
        sigma_origin: origin,
    };
    let rms_mag = fit.statistics(&input.points).map_or(f64::NAN, |statistics| statistics.rms_mag);
    Ok(model_file(base, fit, problem.points(), rms_mag, &singles, &description)?)
}

fn notes(typed: &FitRunArguments, input: &FitInput, chosen: &ChosenForm) -> Vec<String> {
    let kind = match &input.reduction {
        Some(reduction) => format!(
            "Fitted to reduced pixels: layers of {} deg, nside {}, at least {} points, spread of {} mag or less; {} points in all.",
            typed.reduction.layer_deg,
            typed.reduction.nside,
            typed.reduction.min_count,
            typed.reduction.max_iqr,
            reduction.points
        ),
        None => {
            let weights = input.group_correlation.map_or("equal weights".to_owned(), |correlation| {
                format!("weights for a correlation of {correlation:.2} within tracks, nights or passes")
            });
            format!("Fitted to single measurements with a scatter of {} mag and {weights}.", typed.weights.scatter_mag)
        }
    };
    let light = if typed.form.no_earthshine { "Without earthshine." } else { "With earthshine." };
    let mut notes = vec![kind, light.to_owned(), format!("Loss: {}.", chosen.settings.loss)];
    notes.extend(input.band_mismatch(chosen.band).map(|mismatch| format!("Band: {mismatch}.")));
    notes.push(format!("Sunlight passes at least {} km above the ground.", typed.photometry.least_grazing_km));
    notes.extend(chosen.settings.held.iter().map(|(name, value)| format!("{name} was held at {value}.")));
    notes
}

/// Checks all flags, and returns the destination of the model file.
fn checked(typed: &FitRunArguments, chosen: &ChosenForm) -> anyhow::Result<Output> {
    let output = Output::new(Some("json"), Some(typed.output.clone()))?;
    let reports = typed.report.iter().flat_map(|report| report::files(report));
    let outputs: Vec<PathBuf> = once(typed.output.clone()).chain(typed.chains.clone()).chain(reports).collect();
    check_distinct(&typed.photometry.tables.photometry, &outputs)?;
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
            return Err(anyhow!("burn-in is {}; allowed: less than the {steps} steps of --mcmc", typed.burn_in));
        }
        check_walkers(typed.walkers, free)?;
    }
    if typed.form.folds == 1 {
        return Err(anyhow!("folds is 1; allowed: 0, or 2 or more"));
    }
    let is_reduced = !typed.reduction.raw_points;
    if is_reduced && typed.jackknife > 0 && typed.jackknife <= free {
        return Err(anyhow!(
            "jackknife is {}; allowed: more than the {free} free parameters, or 0 for none",
            typed.jackknife
        ));
    }
    if let Some(date) = typed.date.as_deref().filter(|date| !is_date(date)) {
        return Err(anyhow!("invalid date {date}; allowed: a month like 2026-11, or a day like 2026-11-22"));
    }
    // The names in the model file are checked before the fit.
    let mut file = chosen.file.clone();
    file.name = typed.name.clone().unwrap_or(file.name);
    file.provenance.data = typed.data.clone().unwrap_or(file.provenance.data);
    ModelFile::validate(&file, "to be written")?;
    Ok(output)
}

/// Returns true for a valid month or day.
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

/// Returns the current month, for example `2026-11`.
pub fn this_month() -> String {
    let (year, month, ..) = crate::clock::now().to_gregorian_utc();
    format!("{year:04}-{month:02}")
}
