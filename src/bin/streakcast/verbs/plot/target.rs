//! Output files of plots: pictures and their data.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use streakcast::config::RequiredInput;
use streakcast::output::{Provenance, Table};
use streakcast::plot::{FileOptions, Picture, PictureFormat};

use super::arguments::PictureArguments;
use crate::notices::Notices;
use crate::output::{Output, VerbResult, check, write_bytes};

/// Output files. They are checked before the computation.
pub struct Target {
    pictures: Vec<(PathBuf, PictureFormat)>,
    options: FileOptions,
    data: Option<Output>,
}

impl Target {
    /// Opens pictures and data file for a computed plot.
    pub fn new(typed: &PictureArguments) -> anyhow::Result<Self> {
        Self::with_data(typed, true)
    }

    /// Opens pictures for the plot of an input table; no data file is written.
    pub fn of_table(typed: &PictureArguments) -> anyhow::Result<Self> {
        match &typed.data {
            Some(path) => Err(anyhow!(
                "--data {} is given with --from; allowed: the command without --data (the input file has the data)",
                path.display()
            )),
            None => Self::with_data(typed, false),
        }
    }

    fn with_data(typed: &PictureArguments, has_data: bool) -> anyhow::Result<Self> {
        if typed.output.is_empty() {
            return Err(PICTURE.missing().into());
        }
        let mut pictures: Vec<(PathBuf, PictureFormat)> = Vec::new();
        for path in &typed.output {
            let format = PictureFormat::from_extension(path)?;
            check(path)?;
            pictures.push((path.clone(), format));
        }
        let default_path = || typed.output.first().filter(|_| has_data && !typed.no_data).map(|path| data_path(path));
        let data = typed.data.clone().or_else(default_path);
        if let Some(path) = &data {
            let end = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
            if !["ecsv", "csv", "json", "jsonl"].contains(&end.as_str()) {
                bail!(
                    "invalid data {}; allowed: a file with the extension .ecsv, .csv, .json or .jsonl",
                    path.display()
                );
            }
        }
        Ok(Self {
            pictures,
            options: typed.file_options()?,
            data: data.map(|path| Output::new(None, Some(path))).transpose()?,
        })
    }

    /// Draws all pictures, and then writes all files, so that an error in drawing leaves no files.
    pub fn write(
        &self,
        picture: &Picture,
        name: &str,
        table: &Table,
        provenance: &Provenance,
        notices: &Notices,
    ) -> anyhow::Result<()> {
        let options = FileOptions { provenance: Some(json_of(provenance)), ..self.options.clone() };
        let drawn = self.pictures.iter().map(|(path, format)| Ok((path, picture.to_file(*format, &options)?)));
        let drawn = drawn.collect::<anyhow::Result<Vec<_>>>()?;
        if let Some(data) = &self.data {
            data.write(&VerbResult::new(name, table, &[], provenance), notices)?;
        }
        for (path, bytes) in drawn {
            write_bytes(path, &bytes, notices)?;
        }
        Ok(())
    }

    /// Writes the picture for an input table with this provenance.
    pub fn write_picture(&self, picture: &Picture, provenance: &Provenance, notices: &Notices) -> anyhow::Result<()> {
        self.write(picture, "", &Table::default(), provenance, notices)
    }
}

/// Returns a provenance as a JSON object with sorted names, so that pictures of equal data are equal.
pub fn json_of(provenance: &Provenance) -> String {
    let entries: BTreeMap<&str, &serde_json::Value> = provenance.entries().collect();
    serde_json::to_value(entries).unwrap_or_default().to_string()
}

/// Returns the default path of the data file, for example `night-data.ecsv` for `night.png`. Because of the suffix it
/// does not replace a schedule named `night.ecsv`.
pub fn data_path(picture: &Path) -> PathBuf {
    let stem = picture.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    picture.with_file_name(format!("{stem}-data.ecsv"))
}

const PICTURE: RequiredInput = RequiredInput::new("picture", &[&["-o FILE"]]);

/// Returns the required input of all plots, and whether it is given.
pub fn picture(typed: &PictureArguments) -> (&'static RequiredInput, bool) {
    (&PICTURE, !typed.output.is_empty())
}

/// Returns the path of the picture, for plots that write only one.
pub fn only(typed: &PictureArguments) -> anyhow::Result<PathBuf> {
    match typed.output.as_slice() {
        [path] => Ok(path.clone()),
        [] => Err(PICTURE.missing().into()),
        _ => Err(anyhow!("-o is given more than once; allowed: once, because this plot writes one picture")),
    }
}
