//! Destination and format of results.

use std::ffi::OsStr;
use std::io::{self, BufWriter, IsTerminal, Write, stdout};
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::output::{
    Provenance, Section, Table, check_target, write_atomically, write_csv, write_csv_rows, write_ecsv, write_json,
    write_json_lines, write_votable,
};

use crate::notices::Notices;
use crate::screen::{Shown, Style, render, terminal_width};
use streakcast::message::printable;

/// Argument that stands for standard output.
const STANDARD_OUTPUT: &str = "-";

/// Output format.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum Format {
    Table,
    Csv,
    Ecsv,
    Json,
    JsonLines,
    VoTable,
}

/// Names of the formats, for error messages.
pub const FORMATS: &str = "table, csv, ecsv, json, jsonl, votable";

/// File extensions of the formats, for error messages.
pub const EXTENSIONS: &str = ".csv, .ecsv, .json, .jsonl, .vot, .votable";

impl Format {
    /// Returns the format for a file extension; CSV if there is no extension.
    fn by_extension(path: &Path) -> anyhow::Result<Self> {
        match extension(path).as_str() {
            "" => Ok(Format::Csv),
            "ics" | "ical" => Err(anyhow!(
                "{} is a calendar, which only streakcast forecast writes; allowed: {EXTENSIONS}",
                path.display()
            )),
            end => Self::by_name(end)
                .ok_or_else(|| anyhow!("the extension of {} is not a format; allowed: {EXTENSIONS}", path.display())),
        }
    }

    fn required(name: &str) -> anyhow::Result<Self> {
        Self::by_name(name).ok_or_else(|| anyhow!("unknown format '{name}'; allowed: {FORMATS}"))
    }

    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "table" => Some(Format::Table),
            "csv" => Some(Format::Csv),
            "ecsv" => Some(Format::Ecsv),
            "json" => Some(Format::Json),
            "jsonl" => Some(Format::JsonLines),
            "votable" | "vot" => Some(Format::VoTable),
            _ => None,
        }
    }
}

/// Returns the extension of a file name in lower case; empty if there is none.
fn extension(path: &Path) -> String {
    path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase()
}

/// Result of a verb: main table, further tables for JSON, and style on a terminal.
pub struct VerbResult<'a> {
    /// Arrays of the JSON document in order; they include the main table.
    sections: Vec<Section<'a>>,
    /// Main table; formats other than JSON and that for terminals contain only this table.
    main: &'a Table,
    /// Table of the format for terminals.
    on_screen: &'a Table,
    provenance: &'a Provenance,
    style: Style<'a>,
}

impl<'a> VerbResult<'a> {
    /// Returns a result with only its main table, of which a terminal shows `columns`.
    pub fn new(name: &'a str, main: &'a Table, columns: &'a [Shown], provenance: &'a Provenance) -> Self {
        let style = Style { columns, bold_row: None };
        Self { sections: vec![Section { name, table: main }], main, on_screen: main, provenance, style }
    }

    /// Adds a table to JSON after the others.
    pub fn with(mut self, name: &'a str, table: &'a Table) -> Self {
        self.sections.push(Section { name, table });
        self
    }

    /// Adds a table to JSON before the others.
    pub fn after(mut self, name: &'a str, table: &'a Table) -> Self {
        self.sections.insert(0, Section { name, table });
        self
    }

    /// Sets the table that a terminal shows in place of the main one.
    pub fn shown_as(self, on_screen: &'a Table) -> Self {
        Self { on_screen, ..self }
    }

    /// Sets the row in bold type.
    pub fn bold(self, bold_row: Option<usize>) -> Self {
        Self { style: Style { bold_row, ..self.style }, ..self }
    }
}

/// Destination of a result.
#[derive(Clone, Debug)]
pub struct Output {
    format: Format,
    path: Option<PathBuf>,
}

impl Output {
    /// Opens an output in the given format, or else in that of the file extension. Standard output (no path, or `-`)
    /// has the format table on a terminal and CSV elsewhere. Checks that the file can be written.
    pub fn new(format: Option<&str>, path: Option<PathBuf>) -> anyhow::Result<Self> {
        let path = path.filter(|path| path != Path::new(STANDARD_OUTPUT));
        let default_format = || match &path {
            Some(path) => {
                Format::by_extension(path).map_err(|error| anyhow!("{error}, no extension (csv), or any with --format"))
            }
            None if stdout().is_terminal() => Ok(Format::Table),
            None => Ok(Format::Csv),
        };
        let format = format.map_or_else(default_format, Format::required)?;
        if let Some(path) = &path {
            check(path)?;
        }
        Ok(Self { format, path })
    }

    /// Opens a file for an additional table in the format of its extension.
    pub fn additional(path: PathBuf) -> anyhow::Result<Self> {
        check(&path)?;
        Ok(Self { format: Format::by_extension(&path)?, path: Some(path) })
    }

    /// Returns true for JSON, in which rows may contain nested tables.
    pub fn is_json(&self) -> bool {
        matches!(self.format, Format::Json | Format::JsonLines)
    }

    /// Writes a result: a file atomically, with a notice, and standard output directly.
    pub fn write(&self, result: &VerbResult<'_>, notices: &Notices) -> anyhow::Result<()> {
        let styled = self.is_styled();
        let write_data = |out: &mut dyn Write| match self.format {
            Format::Table => out.write_all(render(result.on_screen, &result.style, styled, self.width()).as_bytes()),
            Format::Csv => write_csv(out, result.main, result.provenance),
            Format::Ecsv => write_ecsv(out, result.main, result.provenance),
            Format::Json => write_json(out, &result.sections, result.provenance),
            Format::JsonLines => write_json_lines(out, result.main, result.provenance),
            Format::VoTable => write_votable(out, result.main, result.provenance),
        };
        let name = result.sections.first().map_or("result", |section| section.name);
        self.put(&format!("the table {name}"), notices, |out| {
            if self.format == Format::Table || !self.is_on_terminal() {
                return write_data(out);
            }
            // Control characters in names and identifiers are escaped, because terminals interpret them.
            let mut bytes = Vec::new();
            write_data(&mut bytes)?;
            out.write_all(printable(&String::from_utf8_lossy(&bytes)).as_bytes())
        })
    }

    /// Returns true if the format is CSV for a file or a pipe, which can be written in parts.
    pub fn takes_parts(&self) -> bool {
        self.format == Format::Csv && !self.is_on_terminal()
    }

    /// Writes a table in parts as CSV, so that not all of its rows are in memory. `empty` has its columns and no rows;
    /// `compute` computes the parts and calls its argument with each.
    pub fn write_parts(
        &self,
        name: &str,
        empty: &Table,
        provenance: &Provenance,
        notices: &Notices,
        compute: impl FnOnce(&mut dyn FnMut(&Table) -> io::Result<()>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut failure = None;
        let written = self.put(&format!("the table {name}"), notices, |out| {
            // A computation that fails before the first row writes nothing.
            let mut is_begun = false;
            let computed = compute(&mut |part| {
                if !std::mem::replace(&mut is_begun, true) {
                    write_csv(out, empty, provenance)?;
                }
                write_csv_rows(out, part)
            });
            computed.map_err(|error| {
                error.downcast::<io::Error>().unwrap_or_else(|error| {
                    failure = Some(error);
                    io::Error::other("the computation failed")
                })
            })?;
            if is_begun { Ok(()) } else { write_csv(out, empty, provenance) }
        });
        failure.map_or(written, Err)
    }

    /// Returns true if the format is a table for terminals.
    pub fn is_table(&self) -> bool {
        self.format == Format::Table
    }

    /// Writes several tables for a terminal, one below the other.
    pub fn write_tables<'a>(
        &self,
        tables: impl Iterator<Item = (&'a Table, &'a [crate::screen::Shown])>,
        notices: &Notices,
    ) -> anyhow::Result<()> {
        let styled = self.is_styled();
        let texts: Vec<String> = tables
            .map(|(table, columns)| render(table, &Style { columns, bold_row: None }, styled, self.width()))
            .collect();
        self.write_text(&texts.join("\n"), notices)
    }

    /// Returns the width of the terminal, characters; `None` for files and pipes.
    fn width(&self) -> Option<usize> {
        if self.is_on_terminal() { terminal_width() } else { None }
    }

    fn is_on_terminal(&self) -> bool {
        self.path.is_none() && stdout().is_terminal()
    }

    fn is_styled(&self) -> bool {
        self.is_on_terminal() && std::env::var_os("NO_COLOR").is_none_or(|no| no.is_empty())
    }

    /// Writes text unchanged.
    pub fn write_text(&self, text: &str, notices: &Notices) -> anyhow::Result<()> {
        self.put("the result", notices, |out| out.write_all(text.as_bytes()))
    }

    /// Writes to the file or to standard output; `what` is written, for errors.
    fn put(
        &self,
        what: &str,
        notices: &Notices,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> anyhow::Result<()> {
        match &self.path {
            Some(path) => {
                write_atomically(path, write).map_err(|error| cannot_write(path, &error))?;
                notices.wrote(path);
                Ok(())
            }
            None => {
                let mut out = BufWriter::new(stdout().lock());
                write(&mut out).and_then(|()| out.flush()).map_err(|error| cannot_print(what, error))
            }
        }
    }
}

/// Returns the error of standard output. The error of the system remains its cause, because a closed pipe is not an
/// error of the program.
pub fn cannot_print(what: &str, error: io::Error) -> anyhow::Error {
    let message = format!("cannot write {what} to standard output: {error}");
    anyhow::Error::new(error).context(message)
}

/// Checks that a file can be written. It is called before long computations.
pub fn check(path: &Path) -> anyhow::Result<()> {
    check_name(path)?;
    check_target(path).map_err(|error| cannot_write(path, &error))
}

/// Checks that a file can be replaced atomically; pipes and devices cannot.
pub fn check_whole(path: &Path) -> anyhow::Result<()> {
    check_name(path)?;
    streakcast::output::AtomicFile::check(path).map_err(|error| cannot_write(path, &error))
}

fn check_name(path: &Path) -> anyhow::Result<()> {
    if path == Path::new(STANDARD_OUTPUT) {
        return Err(anyhow!(
            "cannot write to standard output ({STANDARD_OUTPUT}), which only takes the table of a verb; allowed: the name of a file"
        ));
    }
    Ok(())
}

/// Writes a file of bytes atomically, with a notice.
pub fn write_bytes(path: &Path, bytes: &[u8], notices: &Notices) -> anyhow::Result<()> {
    write_atomically(path, |out| out.write_all(bytes)).map_err(|error| cannot_write(path, &error))?;
    notices.wrote(path);
    Ok(())
}

pub fn cannot_write(path: &Path, error: &io::Error) -> anyhow::Error {
    anyhow!("cannot write {}: {error}", path.display())
}
