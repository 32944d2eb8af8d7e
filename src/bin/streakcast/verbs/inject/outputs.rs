//! Outputs of `inject`: frames, truth and pictures, checked before any work.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::anyhow;

use streakcast::output::{Section, Table};
use streakcast::streaks::{InjectedFrame, Injections};

use super::arguments::InjectArguments;
use crate::output::{Answer, Format, Output, check, check_whole};
use crate::screen::Style;

/// Every file that is to be written.
pub struct Outputs {
    /// One for each frame.
    pub frames: Vec<PathBuf>,
    truth: Option<Output>,
    trails: Option<Output>,
}

impl Outputs {
    /// Names all outputs: the file given for one frame, else files of the frames' own names in the folder given. `inputs` are
    /// files that are read.
    pub fn new(typed: &InjectArguments, inputs: &[PathBuf]) -> anyhow::Result<Self> {
        let frames = frames(typed)?;
        frames.iter().try_for_each(|path| check_whole(path))?;
        let beside = |path: &Option<PathBuf>| -> anyhow::Result<Option<Output>> {
            path.as_ref().map(|path| Output::new(text_format(path)?, Some(path.clone()))).transpose()
        };
        let outputs = Self { truth: beside(&typed.truth)?, trails: beside(&typed.trails)?, frames };
        let mut all: Vec<&PathBuf> = outputs.frames.iter().chain(&typed.truth).chain(&typed.trails).collect();
        #[cfg(feature = "plot")]
        for picture in typed.preview.iter().chain(&typed.preview_marked) {
            if !picture.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")) {
                return Err(anyhow!("picture {}: allowed: a file that ends in .png", picture.display()));
            }
            check(picture)?;
            all.push(picture);
        }
        if outputs.frames.len() > 1
            && all.len()
                > outputs.frames.len() + usize::from(outputs.truth.is_some()) + usize::from(outputs.trails.is_some())
        {
            return Err(anyhow!(
                "--preview and --preview-marked are for one frame; there are {}",
                outputs.frames.len()
            ));
        }
        let read: BTreeSet<PathBuf> = inputs.iter().filter_map(|path| path.canonicalize().ok()).collect();
        if let Some(both) = all.iter().find(|path| path.canonicalize().is_ok_and(|path| read.contains(&path))) {
            return Err(anyhow!("{} is an input and would be overwritten; name another output", both.display()));
        }
        let apart: BTreeSet<PathBuf> =
            all.iter().map(|path| path.canonicalize().unwrap_or(path.to_path_buf())).collect();
        if apart.len() < all.len() {
            return Err(anyhow!("two outputs have one name; frames, --truth, --trails and pictures must differ"));
        }
        Ok(outputs)
    }

    /// Writes the tables beside the frames, those of several frames one below the other.
    pub fn write_tables(&self, done: &Injections) -> anyhow::Result<()> {
        type Choice = fn(&InjectedFrame) -> &Table;
        let truth: Choice = |frame| &frame.truth;
        let trails: Choice = |frame| &frame.trails;
        for (output, of, name) in [(&self.truth, truth, "streaks"), (&self.trails, trails, "trails")] {
            let mut frames = done.frames.iter().map(of);
            let (Some(output), Some(first)) = (output, frames.next()) else { continue };
            let mut table = first.clone();
            frames.for_each(|other| table.rows.extend(other.rows.iter().cloned()));
            output.write(&Answer {
                sections: vec![Section { name, table: &table }],
                main: &table,
                provenance: &done.provenance,
                style: Style { columns: &[], bold_row: None },
            })?;
        }
        Ok(())
    }
}

/// Largest number of frames of one run.
const MOST_FRAMES: usize = 100_000;

/// Checks that the name of a table ends in a format of text.
fn text_format(path: &Path) -> anyhow::Result<Option<&'static str>> {
    let end = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
    match Format::by_name(&end) {
        Some(Format::Table) | None if end != "csv" => {
            Err(anyhow!("table {}: allowed: a file that ends in .csv, .ecsv, .json or .jsonl", path.display()))
        }
        _ => Ok(None),
    }
}

fn frames(typed: &InjectArguments) -> anyhow::Result<Vec<PathBuf>> {
    let count = if typed.injection.synthetic.is_some() {
        typed.injection.frames.unwrap_or(1)
    } else {
        typed.injection.image.len()
    };
    if !(1..=MOST_FRAMES).contains(&count) {
        return Err(anyhow!("frames {count}; allowed: 1 to {MOST_FRAMES}"));
    }
    if count == 1 && !typed.output.is_dir() {
        return Ok(vec![typed.output.clone()]);
    }
    if !typed.output.is_dir() {
        return Err(anyhow!("{count} frames need a folder; --output {} is none", typed.output.display()));
    }
    let width = count.to_string().len().max(4);
    let name = |index: usize| match typed.injection.image.get(index) {
        Some(image) => image.file_name().map(OsStr::to_owned).unwrap_or_default(),
        None => format!("frame-{:0width$}.fits", index + 1).into(),
    };
    Ok((0..count).map(|index| typed.output.join(name(index))).collect())
}
