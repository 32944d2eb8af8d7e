//! `model`: the brightness models, listed, shown and checked.

use std::fs;

use anyhow::anyhow;
use streakcast::photometry::{BrightnessModel, ModelFile, ModelLibrary};
use streakcast::table::{Column, Kind, Provenance, Section, Table, Value};

use crate::arguments::{ModelArguments, ModelListArguments, ModelShowArguments, ModelVerb, setup_of};
use crate::failure::Outcome;
use crate::output::{Answer, Output};
use crate::screen::{Shown, Style, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("kind", "kind"),
    shown("band", "band"),
    rounded("sigma_mag", "sigma", 2),
    rounded("rms_mag", "rms", 2),
    shown("provisional", "provisional"),
    shown("title", "title"),
];

pub fn run(typed: ModelArguments) -> anyhow::Result<Outcome> {
    match typed.verb {
        ModelVerb::List(typed) => list(typed),
        ModelVerb::Show(typed) => show(typed),
        ModelVerb::Check { files } => check(&files),
    }
}

fn list(typed: ModelListArguments) -> anyhow::Result<Outcome> {
    let library = setup_of(typed.config.as_deref())?.model_library()?;
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    let names: Vec<&str> = library.names().collect();
    write(&output, &table_of(&library, &names))
}

fn show(typed: ModelShowArguments) -> anyhow::Result<Outcome> {
    let library = setup_of(typed.list.config.as_deref())?.model_library()?;
    let format = typed.list.output.format.as_deref();
    let model = library.get(&typed.name).ok_or_else(|| {
        anyhow!("unknown model '{}'; known are {}", typed.name, library.names().collect::<Vec<_>>().join(", "))
    })?;
    let output = Output::new(format, typed.list.output.output)?;
    if output.is_json() || format.is_none() {
        let text = model.file().map(ModelFile::to_json).unwrap_or_default();
        output.write_text(&(text + "\n"))?;
        return Ok(Outcome::Done);
    }
    write(&output, &table_of(&library, &[typed.name.as_str()]))
}

/// Holds files to the rules; without any, the shipped ones.
fn check(files: &[std::path::PathBuf]) -> anyhow::Result<Outcome> {
    let mut checked = Vec::new();
    for path in files {
        let origin = path.display().to_string();
        let text = fs::read_to_string(path).map_err(|error| anyhow!("model {origin}: {error}"))?;
        checked.push((origin.clone(), BrightnessModel::from_json(&text, &origin)?));
    }
    if files.is_empty() {
        for (origin, text) in ModelLibrary::shipped_files() {
            checked.push(((*origin).to_owned(), BrightnessModel::from_json(text, origin)?));
        }
    }
    let lines: String =
        checked.iter().map(|(origin, model)| format!("{origin}: {} is good\n", model.source())).collect();
    Output::new(None, None)?.write_text(&lines)?;
    Ok(Outcome::Done)
}

fn table_of(library: &ModelLibrary, names: &[&str]) -> Table {
    let models: Vec<_> = names.iter().filter_map(|name| library.get(name)).collect();
    let row = |file: &ModelFile| {
        vec![
            file.name.as_str().into(),
            file.kind.name().into(),
            file.band.as_str().into(),
            file.mag_system.as_str().into(),
            file.sigma_mag.into(),
            file.rms_mag.into(),
            Value::Boolean(file.provenance.provisional),
            file.size_m.into(),
            Value::List(file.aliases.clone()),
            file.title.as_str().into(),
            file.provenance.source.as_str().into(),
        ]
    };
    Table {
        columns: vec![
            Column::new("name", Kind::Text, "Name of the model."),
            Column::new("kind", Kind::Text, "What it computes with."),
            Column::new("band", Kind::Text, "Passband it was made in."),
            Column::new("mag_system", Kind::Text, "Zero point it was made in."),
            Column::real("sigma_mag", "mag", 3, "One sigma of a single prediction."),
            Column::real("rms_mag", "mag", 3, "Residuals on the fitted points; empty where none was published."),
            Column::new("provisional", Kind::Boolean, "True for a model that its file calls provisional."),
            Column::real("size_m", "m", 2, "Extent of the satellite that shines."),
            Column::new("aliases", Kind::List { separator: " " }, "Other names."),
            Column::new("title", Kind::Text, "What it is."),
            Column::new("source", Kind::Text, "Whose data, which publication."),
        ],
        rows: models.iter().filter_map(|model| model.file().map(row)).collect(),
    }
}

fn write(output: &Output, table: &Table) -> anyhow::Result<Outcome> {
    output.write(&Answer {
        sections: vec![Section { name: "models", table }],
        main: table,
        provenance: &Provenance::new(),
        style: Style { columns: ON_SCREEN, bold_row: None },
    })?;
    Ok(Outcome::Done)
}
