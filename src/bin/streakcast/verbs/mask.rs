//! `mask`: masks the streaks of predicted and of measured satellites in frames.

use std::path::PathBuf;

use clap::Args;
use streakcast::Watch;
use streakcast::config::{Config, FRAMES, Mark, MaskConfig, RequiredInput, SATELLITES};

use super::measure::SITE_OF_FRAME;
use crate::failure::Outcome;
use crate::files::check_distinct;
use crate::help::{VerbFlags, help};
use crate::output::{Output, VerbResult, check, check_whole, write_bytes};
use crate::start::begin;

use super::inject::frame_outputs;

#[derive(Args)]
pub struct MaskArguments {
    #[command(flatten)]
    pub mask: MaskConfig,
    /// File of the masks (FITS), or with --into the copy of the frame; a folder for several frames
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Corridors as polygons on the sky: a table with the extension .csv, .ecsv, .json, .jsonl or .vot
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub polygons: Option<PathBuf>,
    /// Corridors as regions of SAOImage DS9
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub regions: Option<PathBuf>,
    #[command(flatten)]
    pub config: Config,
}

const OUTPUT: RequiredInput = RequiredInput {
    mark: Mark::Usage,
    ..RequiredInput::new("output", &[&["-o FILE"], &["--polygons FILE"], &["--regions FILE"]])
};

help! {
    MaskArguments, "mask", asks [FRAMES, OUTPUT, SATELLITES, SITE_OF_FRAME],
    ignores [(&["fov", "field", "rotation"], "has no effect on mask, where the frame is the field")],
    "frame.fits --elements active.tle --mpc X05 --seeing 1.2arcsec -o mask.fits --regions mask.reg",
    "visit.fits --elements active.tle --mpc X05 --telescope rubin --into MASK --bit STREAK -o masked.fits"
}

pub fn run(typed: MaskArguments) -> anyhow::Result<Outcome> {
    let config = typed.config.clone().with_file()?;
    let has_output = typed.output.is_some() || typed.polygons.is_some() || typed.regions.is_some();
    MaskArguments::HELP.check(&config, &[(&FRAMES, !typed.mask.image.is_empty()), (&OUTPUT, has_output)])?;
    let outputs = match &typed.output {
        Some(output) => frame_outputs(output, &typed.mask.image, typed.mask.image.len())?,
        None => Vec::new(),
    };
    outputs.iter().try_for_each(|path| check_whole(path))?;
    let polygons = typed.polygons.clone().map(Output::additional).transpose()?;
    typed.regions.as_deref().map_or(Ok(()), check)?;
    let inputs: Vec<PathBuf> =
        typed.mask.image.iter().cloned().chain(config.files()).chain(config.run.file.clone()).collect();
    let all: Vec<&PathBuf> = outputs.iter().chain(&typed.polygons).chain(&typed.regions).collect();
    check_distinct(&inputs, &all)?;
    let notices = begin(&config)?;
    let done = typed.mask.mask(&config, None, &outputs, &Watch::default())?;
    done.remarks.iter().for_each(|remark| notices.info(remark));
    notices.warn(&done.warnings);
    for (index, masked) in done.frames.iter().enumerate() {
        match outputs.get(index) {
            Some(output) => notices.info(&format!("wrote {}: {}", output.display(), masked.summary)),
            None => notices.info(&format!("{}: {}", masked.image, masked.summary)),
        }
    }
    if let Some(path) = &typed.regions {
        write_bytes(path, done.regions().as_bytes(), &notices)?;
    }
    if let Some(output) = polygons {
        let (corridors, left_out) = (done.corridors(), done.left_out());
        output.write(
            &VerbResult::new("corridors", &corridors, &[], &done.provenance).with("left_out", &left_out),
            &notices,
        )?;
    }
    Ok(Outcome::Done)
}
