//! `model check`: validates model files, and compares models with published references.

use anyhow::anyhow;
use streakcast::fit::checks::{DataSet, POPULATION, Photometry, compare, comparison_table};
use streakcast::output::Provenance;
use streakcast::photometry::{BrightnessModel, ModelLibrary};

use super::model::ModelCheckArguments;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

const CHECK_ON_SCREEN: &[Shown] = &[
    shown("model", "model"),
    shown("kind", "against"),
    shown("reference", "of"),
    shown("sample", "sample"),
    shown("n", "n"),
    rounded("model_mean_mag", "model", 2),
    rounded("model_sd_mag", "sd", 2),
    rounded("reference_mean_mag", "reference", 2),
    rounded("reference_sd_mag", "sd", 2),
    rounded("difference_mag", "difference", 2),
    rounded("difference_errors", "errors", 1),
    rounded("rms_mag", "rms", 2),
    rounded("core_mag", "core", 2),
    rounded("sigma_mag", "sigma", 2),
    rounded("within_one_sigma", "within", 2),
    rounded("sigma_ratio", "ratio", 2),
    shown("verdict", "verdict"),
];

/// Validates the given model files, or else the bundled ones, and compares the models with published references.
pub fn check(typed: ModelCheckArguments) -> anyhow::Result<Outcome> {
    let notices = Notices::new(typed.quiet);
    let mut checked = Vec::new();
    for path in &typed.files {
        let origin = path.display().to_string();
        let text = streakcast::input::read_to_string(path).map_err(|error| anyhow!("model {origin}: {error}"))?;
        checked.push((origin.clone(), BrightnessModel::from_json(&text, &origin)?));
    }
    if typed.files.is_empty() {
        for (origin, text) in ModelLibrary::shipped_files() {
            checked.push(((*origin).to_owned(), BrightnessModel::from_json(text, origin)?));
        }
    }
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    let photometry = typed.data.as_deref().map(Photometry::read).transpose()?;
    // The bundled files are validated by tests.
    if !typed.files.is_empty() {
        checked.iter().for_each(|(origin, model)| notices.info(&format!("{origin}: {} is valid", model.source())));
    }
    let rows: Vec<_> = checked.iter().flat_map(|(_, model)| compare(model, photometry.as_ref())).collect();
    let mut provenance = Provenance::new();
    provenance.state("population", POPULATION);
    provenance.state("difference", "reference minus model");
    for set in DataSet::ALL.iter().filter(|set| photometry.as_ref().is_some_and(|all| all.get(**set).is_some())) {
        provenance.state(&format!("photometry {}", set.path()), set.source());
    }
    let table = comparison_table(&rows);
    output.write(&VerbResult::new("comparisons", &table, CHECK_ON_SCREEN, &provenance), &notices)?;
    Ok(Outcome::Done)
}
