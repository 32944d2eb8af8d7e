//! Where frames, truth and pictures go, checked before any work.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::streak::{DrawnStreak, TruthRow, trail_table, truth_rows, truth_table};
use streakcast::table::{Column, Kind, Provenance, Section, Table, Value};

use crate::inject_arguments::InjectArguments;
use crate::output::{Answer, Format, Output, check};
use crate::screen::Style;

/// Every file that is to be written.
pub struct Outputs {
    /// One for each frame.
    pub frames: Vec<PathBuf>,
    truth: Option<Output>,
    trails: Option<Output>,
}

impl Outputs {
    /// Names of all outputs: that typed where there is one frame, else files of the frames' own names in the folder typed. `inputs` are files that are read.
    pub fn new(typed: &InjectArguments, inputs: &[PathBuf]) -> anyhow::Result<Self> {
        let frames = frames(typed)?;
        frames.iter().try_for_each(|path| check(path))?;
        let beside = |path: &Option<PathBuf>| -> anyhow::Result<Option<Output>> {
            path.as_ref().map(|path| Output::new(text_format(path)?, Some(path.clone()))).transpose()
        };
        let outputs = Self { truth: beside(&typed.truth.truth)?, trails: beside(&typed.truth.trails)?, frames };
        let mut all: Vec<&PathBuf> =
            outputs.frames.iter().chain(&typed.truth.truth).chain(&typed.truth.trails).collect();
        #[cfg(feature = "plot")]
        for picture in typed.truth.preview.iter().chain(&typed.truth.preview_marked) {
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
        let apart: BTreeSet<&PathBuf> = all.iter().copied().collect();
        if apart.len() < all.len() {
            return Err(anyhow!("two outputs have one name; frames, --truth, --trails and pictures must differ"));
        }
        Ok(outputs)
    }

    /// The tables beside the frames.
    pub fn write_tables(&self, truth: &Told, provenance: &Provenance) -> anyhow::Result<()> {
        for (output, table, name) in [(&self.truth, &truth.truth, "streaks"), (&self.trails, &truth.trails, "trails")] {
            let (Some(output), Some(table)) = (output, table) else { continue };
            output.write(&Answer {
                sections: vec![Section { name, table }],
                main: table,
                provenance,
                style: Style { columns: &[], bold_row: None },
            })?;
        }
        Ok(())
    }
}

/// The most frames of one run.
const MOST_FRAMES: usize = 100_000;

/// CSV where the name says no format.
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
    let count = if typed.synthetic.is_some() { typed.frames.unwrap_or(1) } else { typed.image.len() };
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
    let name = |index: usize| match typed.image.get(index) {
        Some(image) => image.file_name().map(OsStr::to_owned).unwrap_or_default(),
        None => format!("frame-{:0width$}.fits", index + 1).into(),
    };
    Ok((0..count).map(|index| typed.output.join(name(index))).collect())
}

/// Truth and trails of several frames, one below the other.
#[derive(Default)]
pub struct Told {
    truth: Option<Table>,
    trails: Option<Table>,
}

impl Told {
    /// Of one frame; its file's name stands before each row.
    pub fn of(frame: &Path, streaks: &[DrawnStreak<'_>], exposure_s: f64, seed: u64) -> Self {
        let rows: Vec<TruthRow<'_>> = truth_rows(streaks, exposure_s, seed);
        let name = frame.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut truth = truth_table(&rows);
        truth.columns.insert(0, Column::new("image", Kind::Text, "File of the frame."));
        truth.rows.iter_mut().for_each(|row| row.insert(0, Value::Text(name.clone())));
        Self { truth: Some(truth), trails: Some(trail_table(&rows)) }
    }

    /// Those of another frame below.
    pub fn append(&mut self, other: Self) {
        for (mine, theirs) in [(&mut self.truth, other.truth), (&mut self.trails, other.trails)] {
            match (mine.as_mut(), theirs) {
                (Some(mine), Some(theirs)) => mine.rows.extend(theirs.rows),
                (None, theirs) => *mine = theirs,
                _ => {}
            }
        }
    }
}
