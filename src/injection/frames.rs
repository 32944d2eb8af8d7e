//! The frames that streaks go into: those on file, or synthetic ones, each made when its turn comes.

use std::path::{Path, PathBuf};

use crate::config::{Setup, parse_moment};
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};
use crate::images::HduKind;
use crate::output::ScratchFolder;
use crate::streaks::{FrameSaid, SyntheticFrame, SyntheticShot, TargetFrame};
use hifitime::Epoch;

use super::asked::Asked;
use super::error::InjectionError;
use super::said::InjectionSaid;

/// When synthetic frames with random streaks are taken where nobody says: it changes nothing but the header.
const SOME_DAY: &str = "2000-01-01T12:00:00Z";

pub struct Frames<'a> {
    /// Frames on file; of synthetic ones a first one, that says when and where all are.
    known: Vec<TargetFrame>,
    maker: Option<Maker<'a>>,
}

/// What makes synthetic frames.
struct Maker<'a> {
    synthetic: &'a SyntheticFrame,
    asked: &'a Asked,
    said: FrameSaid,
    opened: Epoch,
    exposure_s: f64,
    centre: Direction<Gcrs>,
    filter: &'static str,
    scratch: ScratchFolder,
}

impl<'a> Frames<'a> {
    pub fn open(
        said: &InjectionSaid,
        setup: &Setup,
        asked: &'a Asked,
        outputs: &[PathBuf],
    ) -> Result<Self, InjectionError> {
        let Some(synthetic) = &asked.synthetic else {
            let open = |path: &PathBuf| Ok(TargetFrame::open(path, &asked.said)?);
            return Ok(Self {
                known: said.image.iter().map(open).collect::<Result<_, InjectionError>>()?,
                maker: None,
            });
        };
        let folder = outputs.first().and_then(|path| path.parent()).filter(|folder| !folder.as_os_str().is_empty());
        let maker = Maker {
            synthetic,
            asked,
            said: FrameSaid { start: None, duration_s: None, ..asked.said.clone() },
            opened: opened(asked)?,
            exposure_s: asked.said.duration_s.ok_or_else(|| {
                InjectionError::said("no length of the exposure; say --exposure 30s or --schedule FILE --row ID")
            })?,
            centre: centre(said, asked)?,
            filter: setup.photometry()?.band.name(),
            scratch: ScratchFolder::new(folder.unwrap_or(Path::new(".")))?,
        };
        // Asked for its header alone: the sky without stars is made sooner.
        let starless = SyntheticFrame { stars: None, star_list: None, ..synthetic.clone() };
        let first = maker.make(&starless, 0, 0)?;
        Ok(Self { known: vec![first], maker: Some(maker) })
    }

    /// Those that are known before any is worked on.
    pub fn known(&self) -> &[TargetFrame] {
        &self.known
    }

    /// Refuses names ending in .fz where the frame has no compressed tiles: a copy has none either.
    pub fn refuse_plain(&self, outputs: &[PathBuf]) -> Result<(), InjectionError> {
        let is_tiled =
            |frame: &TargetFrame| frame.file.hdus().iter().any(|hdu| matches!(hdu.kind, HduKind::CompressedImage(_)));
        for (index, output) in outputs.iter().enumerate() {
            let frame = self.known.get(if self.maker.is_some() { 0 } else { index });
            let promises = output.extension().is_some_and(|end| end.eq_ignore_ascii_case("fz"));
            if promises && frame.is_some_and(|frame| !is_tiled(frame)) {
                return Err(InjectionError::said(format!(
                    "{}: the frame is not compressed in tiles, and its copy will not be; allowed: a name that ends in .fits",
                    output.display()
                )));
            }
        }
        Ok(())
    }

    /// Works on one of them.
    pub fn with<T>(
        &self,
        index: usize,
        seed: u64,
        work: impl FnOnce(&TargetFrame) -> Result<T, InjectionError>,
    ) -> Result<T, InjectionError> {
        match &self.maker {
            None => work(self.known.get(index).ok_or_else(|| InjectionError::said("no frame {index}"))?),
            Some(maker) => {
                let frame = maker.make(maker.synthetic, index + 1, seed)?;
                let answer = work(&frame);
                // Its streaks are in a copy; the scratch folder goes away with whatever cannot be removed now.
                let _ = std::fs::remove_file(frame.file.path());
                answer
            }
        }
    }
}

impl Maker<'_> {
    fn make(&self, synthetic: &SyntheticFrame, number: usize, seed: u64) -> Result<TargetFrame, InjectionError> {
        let path = self.scratch.path().join(format!("{number}.fits"));
        let shot = SyntheticShot {
            opened: self.opened,
            exposure_s: self.exposure_s,
            centre: self.centre,
            tracking: self.asked.tracking(self.exposure_s),
            optics: &self.asked.optics,
            filter: self.filter,
            seed,
        };
        synthetic.write(&shot, &path)?;
        Ok(TargetFrame::open(&path, &self.said)?)
    }
}

fn opened(asked: &Asked) -> Result<Epoch, InjectionError> {
    match asked.said.start {
        Some(start) => Ok(start),
        None if asked.random.is_some() => Ok(parse_moment(SOME_DAY, None)?),
        None => Err(InjectionError::said(
            "no start of the exposure; say --start 2024-08-14T00:30:00.000Z or --schedule FILE --row ID",
        )),
    }
}

fn centre(said: &InjectionSaid, asked: &Asked) -> Result<Direction<Gcrs>, InjectionError> {
    match (&asked.scheduled, &said.ra, &said.dec) {
        (_, Some(ra), Some(dec)) => Ok(Direction::from_lon_lat_rad(
            parse_right_ascension_deg(ra)?.to_radians(),
            parse_declination_deg(dec)?.to_radians(),
        )),
        (Some(exposure), None, None) => Ok(exposure.pointing),
        (None, None, None) if asked.random.is_some() => Ok(Direction::from_lon_lat_rad(0.0, 0.0)),
        _ => {
            Err(InjectionError::said("no centre of the frame; say --ra 188.5 --dec=-30.5 or --schedule FILE --row ID"))
        }
    }
}
