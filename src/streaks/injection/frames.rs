//! Frames of an injection: existing files, or synthetic frames that are created one at a time.

use std::path::{Path, PathBuf};

use super::super::frame::{FrameOverrides, SyntheticFrame, SyntheticShot, TargetFrame};
use super::plan::{InjectionPlan, SyntheticPlan};
use crate::error::{Error, ErrorKind};
use crate::images::HduKind;
use crate::output::ScratchFolder;
use crate::watch::Watch;

pub struct Frames<'a> {
    /// Existing frames, or one synthetic frame without stars, which has the time and centre of all synthetic frames.
    known: Vec<TargetFrame>,
    maker: Option<SyntheticMaker<'a>>,
}

/// Adds the flag that replaces the coordinates of a frame to the error that it has none.
fn without_coordinates(error: Error) -> Error {
    if error.kind() != ErrorKind::NoCoordinates {
        return error;
    }
    let allowed = error.allowed().unwrap_or_default();
    let allowed = format!("{allowed}, or --pixel-scale ANGLE with random streaks or --streaks in pixels");
    error.allowing(allowed)
}

/// Rejects a name that ends in .fz for the copy of a frame that is not compressed in tiles.
pub fn reject_untiled(frame: &TargetFrame, output: &Path) -> Result<(), Error> {
    let is_tiled = frame.file.hdus().iter().any(|hdu| matches!(hdu.kind, HduKind::CompressedImage(_)));
    if output.extension().is_some_and(|end| end.eq_ignore_ascii_case("fz")) && !is_tiled {
        return Err(Error::invalid(
            output.display().to_string(),
            "the copy of a frame that is not compressed in tiles",
            "a name that ends in .fits",
        ));
    }
    Ok(())
}

/// Creates synthetic frames in temporary files.
struct SyntheticMaker<'a> {
    synthetic: &'a SyntheticPlan,
    plan: &'a InjectionPlan,
    overrides: FrameOverrides,
    scratch: ScratchFolder,
}

impl<'a> Frames<'a> {
    pub fn open(plan: &'a InjectionPlan, outputs: &[PathBuf]) -> Result<Self, Error> {
        let Some(synthetic) = &plan.synthetic else {
            let open = |path: &PathBuf| TargetFrame::open(path, &plan.overrides).map_err(without_coordinates);
            return Ok(Self { known: plan.images.iter().map(open).collect::<Result<_, Error>>()?, maker: None });
        };
        let beside = outputs.first().map_or(Path::new("frame"), PathBuf::as_path);
        let maker = SyntheticMaker {
            synthetic,
            plan,
            overrides: FrameOverrides { start: None, duration_s: None, ..plan.overrides.clone() },
            scratch: ScratchFolder::beside(beside).map_err(Error::system)?,
        };
        // Only the header of this frame is used. It is made without stars, which is faster.
        let starless = SyntheticFrame { stars: None, star_list: None, ..synthetic.frame.clone() };
        let first = maker.make(&starless, 0, 0, &Watch::default())?;
        Ok(Self { known: vec![first], maker: Some(maker) })
    }

    /// Returns the frames that exist before the injection starts.
    pub fn known(&self) -> &[TargetFrame] {
        &self.known
    }

    /// Rejects output names that end in .fz for frames that are not compressed in tiles, because their copies are not
    /// compressed either.
    pub fn reject_untiled(&self, outputs: &[PathBuf]) -> Result<(), Error> {
        for (index, output) in outputs.iter().enumerate() {
            let frame = self.known.get(if self.maker.is_some() { 0 } else { index });
            frame.map_or(Ok(()), |frame| reject_untiled(frame, output))?;
        }
        Ok(())
    }

    /// Calls a function with one frame. A synthetic frame is created before the call and deleted after it.
    pub fn with_frame<T>(
        &self,
        index: usize,
        seed: u64,
        watch: &Watch,
        work: impl FnOnce(&TargetFrame) -> Result<T, Error>,
    ) -> Result<T, Error> {
        match &self.maker {
            None => work(
                self.known
                    .get(index)
                    .ok_or_else(|| Error::invalid("frame", index, format!("below {}", self.known.len())))?,
            ),
            Some(maker) => {
                let frame = maker.make(&maker.synthetic.frame, index + 1, seed, watch)?;
                let result = work(&frame);
                // The frame is no longer needed, because the streaks are in a copy. If its file cannot be deleted here,
                // it is deleted with the temporary folder.
                let _ = std::fs::remove_file(frame.file.path());
                result
            }
        }
    }
}

impl SyntheticMaker<'_> {
    fn make(&self, synthetic: &SyntheticFrame, number: usize, seed: u64, watch: &Watch) -> Result<TargetFrame, Error> {
        let path = self.scratch.path().join(format!("{number}.fits"));
        let SyntheticPlan { opened, exposure_s, centre, .. } = *self.synthetic;
        let shot = SyntheticShot {
            opened,
            exposure_s,
            centre,
            tracking: self.plan.tracking(exposure_s),
            optics: &self.plan.optics,
            filter: self.plan.photometry.band.name(),
            seed,
            watch,
        };
        synthetic.write(&shot, &path).map_err(|error| error.at("synthetic frame"))?;
        TargetFrame::open(&path, &self.overrides)
    }
}
