//! `model list` and `model show`: list and print the brightness models. `model_pressure` and `model_check` compute the
//! other two verbs.

use std::path::{Path, PathBuf};

use crate::arguments::OutputArguments;
use clap::{Args, Subcommand};
use streakcast::config::Config;

use streakcast::output::{Column, Kind, Provenance, Table, Value};
use streakcast::photometry::{ModelFile, ModelLibrary};

use crate::failure::Outcome;
use crate::help::{Typed, help};
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

#[derive(Args)]
pub struct ModelArguments {
    #[command(subcommand)]
    pub verb: ModelVerb,
}

help! { ModelArguments, "model", "list", "show visorsat" }

#[derive(Subcommand)]
pub enum ModelVerb {
    /// List all models by name
    List(Typed<ModelListArguments>),
    /// Show the file of a model, with coefficients, covariance and provenance
    Show(Typed<ModelShowArguments>),
    /// Compute the acceleration of a satellite by the pressure of sunlight, from the panels of its model
    Pressure(Typed<ModelPressureArguments>),
    /// Validate models and compare them with published means, phase curves and photometry
    Check(Typed<ModelCheckArguments>),
}

#[derive(Args)]
pub struct ModelCheckArguments {
    /// Model files; the bundled models if omitted. A model named visorsat-mine is compared with the data of visorsat
    pub files: Vec<PathBuf>,
    /// Folder of published photometry (see docs/explanation/models.md); only published means and curves if omitted
    #[arg(long, value_name = "FOLDER")]
    pub data: Option<PathBuf>,
    /// Suppress everything except errors on standard error
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! { ModelCheckArguments, "model check", "", "visorsat-mine.json --data photometry" }

#[derive(Args)]
pub struct ModelListArguments {
    /// Configuration file with additional models
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Suppress notes
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! { ModelListArguments, "model list", "", "--config streakcast.toml --format csv" }

#[derive(Args)]
pub struct ModelShowArguments {
    /// Name or alias of the model
    pub name: String,
    #[command(flatten)]
    pub list: ModelListArguments,
}

help! { ModelShowArguments, "model show", "visorsat", "visorsat --format table" }

#[derive(Args)]
pub struct ModelPressureArguments {
    /// Brightness model of panels: name (listed by streakcast model list) or model file
    #[arg(value_name = "MODEL")]
    pub model: String,
    /// Mass of the satellite, kg
    #[arg(long, value_name = "KG", allow_hyphen_values = true)]
    pub mass_kg: f64,
    /// Latitudes of the Sun above the plane of the chassis, degrees (negative below); -30 to 90 in steps of 10 if
    /// omitted
    #[arg(long, value_name = "DEG", num_args = 1.., value_delimiter = ',', allow_negative_numbers = true)]
    pub sun_latitude_deg: Vec<f64>,
    /// Configuration file with additional models
    #[arg(long, value_name = "FILE")]
    pub config: Option<PathBuf>,
    /// Suppress everything except errors on standard error
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! {
    ModelPressureArguments, "model pressure",
    "starlink-v1.5 --mass-kg 295",
    "v2mini-panels --mass-kg 575 --sun-latitude-deg -20 0 20 --format csv"
}

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
        ModelVerb::List(typed) => typed.run(list),
        ModelVerb::Show(typed) => typed.run(show),
        ModelVerb::Pressure(typed) => typed.run(super::model_pressure::pressure),
        ModelVerb::Check(typed) => typed.run(super::model_check::check),
    }
}

fn list(typed: ModelListArguments) -> anyhow::Result<Outcome> {
    let library = library_of(typed.config.as_deref())?;
    let output = Output::new(typed.output.format.as_deref(), typed.output.output)?;
    let names: Vec<&str> = library.names().collect();
    write(&output, &table_of(&library, &names), typed.quiet)
}

fn show(typed: ModelShowArguments) -> anyhow::Result<Outcome> {
    let library = library_of(typed.list.config.as_deref())?;
    let format = typed.list.output.format.as_deref();
    let model = library.find(&typed.name)?;
    let output = Output::new(format, typed.list.output.output)?;
    if output.is_json() || format.is_none() {
        let text = model.file().map(ModelFile::to_json).unwrap_or_default();
        output.write_text(&(text + "\n"), &Notices::new(typed.list.quiet))?;
        return Ok(Outcome::Done);
    }
    write(&output, &table_of(&library, &[typed.name.as_str()]), typed.list.quiet)
}

/// Returns the bundled brightness models and those of a configuration file.
pub fn library_of(config: Option<&Path>) -> anyhow::Result<ModelLibrary> {
    Ok(config.map(Config::read).transpose()?.unwrap_or_default().model_library()?)
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
            Column::new("kind", Kind::Text, "Kind of the model."),
            Column::new("band", Kind::Text, "Passband of the model."),
            Column::new("mag_system", Kind::Text, "Zero point of the model."),
            Column::real("sigma_mag", "mag", 3, "One sigma of the predicted magnitude of a single satellite."),
            Column::real("rms_mag", "mag", 3, "RMS of the residuals of the fit; empty if not published."),
            Column::new("provisional", Kind::Boolean, "True for a provisional model."),
            Column::real("size_m", "m", 2, "Size of the satellite."),
            Column::new("aliases", Kind::List { separator: " " }, "Other names."),
            Column::new("title", Kind::Text, "Title of the model."),
            Column::new("source", Kind::Text, "Source of the data and publication."),
        ],
        rows: models.iter().filter_map(|model| model.file().map(row)).collect(),
    }
}

fn write(output: &Output, table: &Table, quiet: bool) -> anyhow::Result<Outcome> {
    output.write(&VerbResult::new("models", table, ON_SCREEN, &Provenance::new()), &Notices::new(quiet))?;
    Ok(Outcome::Done)
}
