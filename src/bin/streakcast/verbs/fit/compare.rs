//! `fit compare`: tests of Lu (2024), and comparison of model forms on held-out points.

use anyhow::anyhow;
use streakcast::fit::{
    COEFFICIENTS, CompetingForm, baseline_forms, compare_forms, form_score_table, offset_table, paired_model_table,
    paper_tests,
};

use super::arguments::FitCompareArguments;
use super::form::{FittedForm, form};
use super::points::{provenance, read, weights};
use crate::failure::Outcome;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

const STANDINGS_ON_SCREEN: &[Shown] = &[
    shown("model", "model"),
    shown("parameters", "k"),
    shown("n", "n"),
    rounded("rms_mag", "rms", 3),
    rounded("core_mag", "core", 3),
    rounded("aic", "AIC", 0),
    rounded("held_out_rms_mag", "held-out rms", 3),
    rounded("held_out_core_mag", "held-out core", 3),
    rounded("within_one_sigma", "within", 2),
];
const OFFSETS_ON_SCREEN: &[Shown] = &[
    rounded("sun_latitude_from_deg", "Sun from", 1),
    rounded("sun_latitude_to_deg", "to deg", 1),
    shown("n", "n"),
    rounded("panel_offset_deg", "POA deg", 3),
    rounded("panel_offset_sigma_deg", "sigma", 3),
    rounded("rms_mag", "rms", 4),
];
const PAIRS_ON_SCREEN: &[Shown] = &[
    shown("model", "model"),
    shown("n", "n"),
    shown("parameters", "k"),
    rounded("rms_mag", "rms", 4),
    rounded("aic", "AIC", 1),
    rounded("t", "t", 2),
    rounded("p", "p", 4),
];

pub fn compare(typed: FitCompareArguments) -> anyhow::Result<Outcome> {
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    if typed.form.folds < 2 {
        return Err(anyhow!("folds is {}; allowed: 2 or more", typed.form.folds));
    }
    let chosen = form(&typed.form, typed.reduction.raw_points)?;
    let mut input = read(&typed.photometry, &typed.reduction, &weights(&typed.weights)?)?;
    input.weigh(&chosen, &typed.weights)?;
    let mismatch = input.band_mismatch(chosen.band);
    input.notices.warn(&mismatch);
    let own =
        CompetingForm { name: chosen.file.name.clone(), form: chosen.form.boxed(), free: chosen.settings.free.clone() };
    let mut entrants = vec![own];
    let mut provenance = provenance(&typed.photometry, &typed.reduction, &input);
    if let Some(mismatch) = mismatch {
        provenance.state("band", mismatch);
    }
    provenance.state("layer_deg", typed.reduction.layer_deg);
    provenance.state("free", chosen.settings.free.join(", "));
    for (name, value) in &chosen.settings.held {
        provenance.state(&format!("held_{name}"), *value);
    }
    if typed.reduction.raw_points {
        provenance.state("scatter_mag", typed.weights.scatter_mag);
        provenance.state("group_correlation", input.group_correlation.unwrap_or(0.0));
    }
    provenance.state("loss", chosen.settings.loss.to_string());
    provenance.state("model", chosen.file.name.as_str());
    provenance.state("earthshine", if typed.form.no_earthshine { "off" } else { "computed" });
    let tests = match &chosen.form {
        FittedForm::TwoPanel(two_panel) => {
            Some(paper_tests(two_panel, &input.points, &chosen.settings, typed.reduction.layer_deg)?)
        }
        FittedForm::Panels(_) => None,
    };
    let two_panels = chosen.form.as_two_panels();
    if let (FittedForm::Panels(_), Some(paper)) = (&chosen.form, &two_panels) {
        let free = COEFFICIENTS.iter().map(|&name| name.to_owned()).collect();
        entrants.push(CompetingForm { name: "the paper's form".to_owned(), form: Box::new(paper.clone()), free });
    }
    entrants.extend(baseline_forms(two_panels.as_ref()));
    let folds = typed.form.folds;
    provenance.state("folds", folds);
    let standings = compare_forms(&entrants, &input.points, input.tracks(), &chosen.settings, folds)?;
    let standings = form_score_table(&standings);
    let (offsets, rivals) = match &tests {
        Some(tests) => (offset_table(&tests.offsets), paired_model_table(&[&tests.sail_glossy, &tests.earthshine])),
        None => (offset_table(&[]), paired_model_table(&[])),
    };
    for (span, n) in tests.iter().flat_map(|tests| &tests.left_out) {
        input.notices.info(&format!("layer {} to {} deg omitted: {n} points", span[0], span[1]));
    }
    let dropped = input.measurements.dropped.table();
    if output.is_table() {
        let parts = [(&offsets, OFFSETS_ON_SCREEN), (&rivals, PAIRS_ON_SCREEN), (&standings, STANDINGS_ON_SCREEN)];
        return output
            .write_tables(parts.into_iter().filter(|(table, _)| !table.rows.is_empty()), &input.notices)
            .map(|()| Outcome::Done);
    }
    output.write(
        &VerbResult::new("standings", &standings, STANDINGS_ON_SCREEN, &provenance)
            .after("rivals", &rivals)
            .after("panel_offsets", &offsets)
            .with("dropped", &dropped),
        &input.notices,
    )?;
    Ok(Outcome::Done)
}
