//! Where the data goes, and in which format.

use std::ffi::OsStr;
use std::io::{self, BufWriter, IsTerminal, Write, stdout};
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::output::{
    Provenance, Section, Table, check_target, write_atomically, write_csv, write_ecsv, write_json, write_json_lines,
    write_votable,
};

use crate::screen::{Style, render};

/// Written for a path, as other programs have it.
const STANDARD_OUTPUT: &str = "-";

/// Format of the data.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Format {
    Table,
    Csv,
    Ecsv,
    Json,
    JsonLines,
    VoTable,
    #[cfg(feature = "parquet")]
    Parquet,
}

/// Their names.
#[cfg(not(feature = "parquet"))]
pub const FORMATS: &str = "table, csv, ecsv, json, jsonl, votable";
/// Their names.
#[cfg(feature = "parquet")]
pub const FORMATS: &str = "table, csv, ecsv, json, jsonl, votable, parquet";

/// Ends of files' names that say a format.
#[cfg(not(feature = "parquet"))]
pub const ENDS: &str = ".csv, .ecsv, .json, .jsonl, .vot, .votable";
/// Ends of files' names that say a format.
#[cfg(feature = "parquet")]
pub const ENDS: &str = ".csv, .ecsv, .json, .jsonl, .vot, .votable, .parquet";

impl Format {
    /// By the end of a file's name; CSV where it has none.
    fn by_end(path: &Path) -> anyhow::Result<Self> {
        match extension(path).as_str() {
            "" => Ok(Format::Csv),
            // Nobody who asks for this wants lines of text in its place.
            "parquet" => Self::said("parquet"),
            end => Self::by_name(end)
                .ok_or_else(|| anyhow!("the name {} ends in no format; allowed: {ENDS}", path.display())),
        }
    }

    fn said(name: &str) -> anyhow::Result<Self> {
        Self::by_name(name).ok_or_else(|| match name {
            "parquet" => anyhow!("format 'parquet' needs a build with the cargo feature parquet; allowed: {FORMATS}"),
            name => anyhow!("format '{name}' is not known; allowed: {FORMATS}"),
        })
    }

    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "table" => Some(Format::Table),
            "csv" => Some(Format::Csv),
            "ecsv" => Some(Format::Ecsv),
            "json" => Some(Format::Json),
            "jsonl" => Some(Format::JsonLines),
            "votable" | "vot" => Some(Format::VoTable),
            #[cfg(feature = "parquet")]
            "parquet" => Some(Format::Parquet),
            _ => None,
        }
    }
}

/// The end of a file's name in small letters; empty where it has none.
fn extension(path: &Path) -> String {
    path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase()
}

/// An answer: its main table, what JSON has beside it, and what a screen shows of it.
pub struct Answer<'a> {
    /// The arrays of a JSON document in order; the main table among them.
    pub sections: Vec<Section<'a>>,
    /// The rows of all other formats.
    pub main: &'a Table,
    /// What it rests on.
    pub provenance: &'a Provenance,
    /// Columns and colours on a screen.
    pub style: Style<'a>,
}

/// Where an answer goes.
#[derive(Clone, Debug)]
pub struct Output {
    format: Format,
    path: Option<PathBuf>,
}

impl Output {
    /// The format said; else that of the file's name; else a table on a terminal and CSV anywhere else.
    /// That a file can be made there is checked now, before any work. A path of `-` is standard output.
    pub fn new(format: Option<&str>, path: Option<PathBuf>) -> anyhow::Result<Self> {
        let path = path.filter(|path| path != Path::new(STANDARD_OUTPUT));
        let unsaid = || match &path {
            Some(path) => {
                Format::by_end(path).map_err(|error| anyhow!("{error}, none of them for csv, or any with --format"))
            }
            None if stdout().is_terminal() => Ok(Format::Table),
            None => Ok(Format::Csv),
        };
        let format = format.map_or_else(unsaid, Format::said)?;
        if let Some(path) = &path {
            check(path)?;
        }
        Ok(Self { format, path })
    }

    /// A table in a file beside the answer: its name alone says the format.
    pub fn beside(path: PathBuf) -> anyhow::Result<Self> {
        check(&path)?;
        Ok(Self { format: Format::by_end(&path)?, path: Some(path) })
    }

    /// True where the rows may hold rows.
    pub fn is_json(&self) -> bool {
        matches!(self.format, Format::Json | Format::JsonLines)
    }

    /// Writes an answer: a file whole or not at all, standard output as it comes.
    pub fn write(&self, answer: &Answer<'_>) -> anyhow::Result<()> {
        let styled = self.is_styled();
        self.put(|out| match self.format {
            Format::Table => out.write_all(render(answer.main, &answer.style, styled).as_bytes()),
            Format::Csv => write_csv(out, answer.main, answer.provenance),
            Format::Ecsv => write_ecsv(out, answer.main, answer.provenance),
            Format::Json => write_json(out, &answer.sections, answer.provenance),
            Format::JsonLines => write_json_lines(out, answer.main, answer.provenance),
            Format::VoTable => write_votable(out, answer.main, answer.provenance),
            #[cfg(feature = "parquet")]
            Format::Parquet => {
                // Its end tells where everything is: the writer wants a place of its own.
                let mut bytes = Vec::new();
                streakcast::output::write_parquet(&mut bytes, answer.main, answer.provenance)?;
                out.write_all(&bytes)
            }
        })
    }

    /// True where eyes are to read it.
    pub fn is_table(&self) -> bool {
        self.format == Format::Table
    }

    /// Several tables for eyes, one below the other.
    #[cfg(feature = "fit")]
    pub fn write_tables<'a>(
        &self,
        tables: impl Iterator<Item = (&'a Table, &'a [crate::screen::Shown])>,
    ) -> anyhow::Result<()> {
        let styled = self.is_styled();
        let texts: Vec<String> =
            tables.map(|(table, columns)| render(table, &Style { columns, bold_row: None }, styled)).collect();
        self.write_text(&texts.join("\n"))
    }

    fn is_styled(&self) -> bool {
        self.path.is_none() && stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|no| no.is_empty())
    }

    /// Writes text as it is.
    pub fn write_text(&self, text: &str) -> anyhow::Result<()> {
        self.put(|out| out.write_all(text.as_bytes()))
    }

    fn put(&self, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> anyhow::Result<()> {
        match &self.path {
            Some(path) => write_atomically(path, write).map_err(|error| cannot_write(path, &error)),
            None => {
                let mut out = BufWriter::new(stdout().lock());
                write(&mut out)?;
                Ok(out.flush()?)
            }
        }
    }
}

/// That a file can be written there, asked before any work.
pub fn check(path: &Path) -> anyhow::Result<()> {
    named(path)?;
    check_target(path).map_err(|error| cannot_write(path, &error))
}

/// Checks a file that is only replaced as a whole: not a pipe, not a device.
#[cfg(feature = "fits")]
pub fn check_whole(path: &Path) -> anyhow::Result<()> {
    named(path)?;
    streakcast::output::AtomicFile::check(path).map_err(|error| cannot_write(path, &error))
}

fn named(path: &Path) -> anyhow::Result<()> {
    if path == Path::new(STANDARD_OUTPUT) {
        return Err(anyhow!(
            "cannot write {STANDARD_OUTPUT}: standard output takes the main answer alone; allowed: a file's name"
        ));
    }
    Ok(())
}

/// Writes a file of bytes, whole or not at all.
#[cfg(any(feature = "fit", feature = "fits", feature = "plot"))]
pub fn write_bytes(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    write_atomically(path, |out| out.write_all(bytes)).map_err(|error| cannot_write(path, &error))
}

pub fn cannot_write(path: &Path, error: &io::Error) -> anyhow::Error {
    anyhow!("cannot write {}: {error}", path.display())
}
