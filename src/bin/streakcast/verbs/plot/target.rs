//! Where pictures go, and the data beside them.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use streakcast::output::{Provenance, Section, Table};
use streakcast::plot::{Picture, PictureFormat};

use super::arguments::PictureArguments;
use crate::output::{Answer, Output, check, write_bytes};
use crate::screen::Style;

/// Looked at before any work.
pub struct Target {
    pictures: Vec<(PathBuf, PictureFormat)>,
    data: Option<Output>,
}

impl Target {
    /// Of a question: the numbers go beside the picture, where nothing else was said.
    pub fn new(typed: &PictureArguments) -> anyhow::Result<Self> {
        Self::with_data(typed, true)
    }

    /// Of a table that was read: its numbers are in a file already.
    pub fn of_table(typed: &PictureArguments) -> anyhow::Result<Self> {
        match &typed.data {
            Some(path) => Err(anyhow!("data {}: the numbers of this picture are in a file already", path.display())),
            None => Self::with_data(typed, false),
        }
    }

    fn with_data(typed: &PictureArguments, is_beside: bool) -> anyhow::Result<Self> {
        let mut pictures: Vec<(PathBuf, PictureFormat)> = Vec::new();
        for path in &typed.output {
            let format = PictureFormat::of(path)?;
            check(path)?;
            if pictures.iter().any(|(other, _)| other == path) {
                bail!("picture {} is said twice", path.display());
            }
            pictures.push((path.clone(), format));
        }
        let beside = || typed.output.first().filter(|_| is_beside && !typed.no_data).map(|path| name_beside(path));
        let data = typed.data.clone().or_else(beside);
        if let Some(path) = &data {
            let end = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
            if !["ecsv", "csv", "json", "jsonl"].contains(&end.as_str()) {
                bail!("data {}: its name must end in .ecsv, .csv, .json or .jsonl", path.display());
            }
        }
        Ok(Self { pictures, data: data.map(|path| Output::new(None, Some(path))).transpose()? })
    }

    /// All pictures are drawn before the first file is written.
    pub fn write(&self, picture: &Picture, name: &str, table: &Table, provenance: &Provenance) -> anyhow::Result<()> {
        let drawn = self.pictures.iter().map(|(path, format)| Ok((path, picture.to_bytes(*format)?)));
        let drawn = drawn.collect::<anyhow::Result<Vec<_>>>()?;
        if let Some(data) = &self.data {
            data.write(&Answer {
                sections: vec![Section { name, table }],
                main: table,
                provenance,
                style: Style { columns: &[], bold_row: None },
            })?;
        }
        for (path, bytes) in drawn {
            write_bytes(path, &bytes)?;
        }
        Ok(())
    }

    /// A picture of a table that was read.
    pub fn write_picture(&self, picture: &Picture) -> anyhow::Result<()> {
        self.write(picture, "", &Table::default(), &Provenance::new())
    }
}

/// `night.png` has its numbers in `night-data.ecsv`: a schedule may be called `night.ecsv`.
pub fn name_beside(picture: &Path) -> PathBuf {
    let stem = picture.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    picture.with_file_name(format!("{stem}-data.ecsv"))
}

/// The one picture of plots that another verb draws.
pub fn only(typed: &PictureArguments) -> anyhow::Result<PathBuf> {
    match typed.output.as_slice() {
        [path] => Ok(path.clone()),
        _ => Err(anyhow!("this plot writes one picture at a time; say -o once")),
    }
}
