//! Destination of a map: table, HEALPix in FITS, or picture.

use std::ffi::OsStr;
use std::path::Path;
#[cfg(unix)]
use std::path::PathBuf;

use anyhow::{anyhow, bail};
#[cfg(unix)]
use streakcast::maps::DEFAULT_NSIDE;
use streakcast::maps::{DEFAULT_STEP_DEG, Grid};

use super::arguments::MapOutputArguments;
use crate::output::check;
use crate::output::{FORMATS, Format, Output};
use streakcast::{Error, ErrorKind};

/// Destination of the table of a map. It is checked before the computation.
pub enum Target {
    /// No table, because only a picture is written.
    Nothing,
    Table(Output, Grid),
    #[cfg(unix)]
    Fits(PathBuf, Grid),
}

/// Kind of a file by its extension.
#[derive(Copy, Clone, PartialEq, Eq)]
enum Ending {
    Fits,
    Table,
    /// Any other extension, or no extension.
    Other,
}

impl Ending {
    fn from_extension(path: Option<&Path>) -> anyhow::Result<Self> {
        let Some(path) = path else { return Ok(Self::Other) };
        let end = path.extension().and_then(OsStr::to_str).unwrap_or_default().to_ascii_lowercase();
        let shown = path.display();
        match end.as_str() {
            "fits" | "fit" => Ok(Self::Fits),
            "gz" => bail!(
                "output {shown} is compressed, which is not supported; allowed: {}",
                path.with_extension("").display()
            ),
            "png" | "svg" | "pdf" => {
                streakcast::plot::PictureFormat::from_extension(path)?;
                bail!("output {shown} is a picture; allowed: --picture {shown}")
            }
            _ => Ok(if Format::by_name(&end).is_some() { Self::Table } else { Self::Other }),
        }
    }
}

impl Target {
    /// Opens a destination in the given format, or else in that of the file extension, or else in that of the
    /// configuration.
    pub fn new(typed: &MapOutputArguments, configured: Option<&str>) -> anyhow::Result<Self> {
        let grid = match (typed.nside, typed.step_deg) {
            (Some(nside), _) => Grid::healpix(nside)?,
            (None, step) => Grid::regular(step.unwrap_or(DEFAULT_STEP_DEG))?,
        };
        let output = typed.output.as_deref();
        let ending = Ending::from_extension(output)?;
        let format = typed.format.as_deref().or(configured.filter(|_| ending == Ending::Other));
        if let Some(name) = format
            && name != "fits"
            && Format::by_name(name).is_none()
        {
            bail!("unknown format '{name}'; allowed: {FORMATS}, fits");
        }
        if let (Some(name), Some(path)) = (format, output) {
            let is_other = if name == "fits" { ending == Ending::Table } else { ending == Ending::Fits };
            if is_other {
                bail!("the file {} does not have the format {name}; allowed: the extension .{name}", path.display());
            }
        }
        if let Some(picture) = &typed.picture {
            streakcast::plot::PictureFormat::from_extension(picture)?;
            check(picture)?;
            if output.is_none() && typed.format.is_none() {
                return Self::picture_alone(typed);
            }
        }
        if format == Some("fits") || ending == Ending::Fits {
            return Self::fits(typed, grid);
        }
        Ok(Self::Table(Output::new(format, typed.output.clone())?, grid))
    }

    /// Rejects grid flags if only a picture is written, because a picture has its own pixel grid.
    fn picture_alone(typed: &MapOutputArguments) -> anyhow::Result<Self> {
        let of_tables = [("--nside", typed.nside.is_some()), ("--step-deg", typed.step_deg.is_some())];
        match of_tables.iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => {
                bail!("{flag} has no effect on a picture; allowed: with a table or FITS (-o or --format)")
            }
            None => Ok(Self::Nothing),
        }
    }

    #[cfg(unix)]
    fn fits(typed: &MapOutputArguments, grid: Grid) -> anyhow::Result<Self> {
        let path =
            typed.output.clone().ok_or_else(|| anyhow!("missing output file for format fits; specify -o map.fits"))?;
        if typed.step_deg.is_some() {
            bail!(
                "--step-deg is given with format fits, which holds HEALPix maps; allowed: --nside, for example {DEFAULT_NSIDE}"
            );
        }
        check(&path)?;
        Ok(Self::Fits(path, if typed.nside.is_some() { grid } else { Grid::healpix(DEFAULT_NSIDE)? }))
    }

    #[cfg(not(unix))]
    fn fits(_: &MapOutputArguments, _: Grid) -> anyhow::Result<Self> {
        Err(anyhow!("format fits does not exist on Windows; allowed: {FORMATS}"))
    }
}

/// Returns the bytes of a FITS file. CFITSIO writes it to a temporary file first.
#[cfg(unix)]
pub fn fits_bytes(made: impl FnOnce(&Path) -> Result<Vec<u8>, Error>) -> anyhow::Result<Vec<u8>> {
    made(&std::env::temp_dir()).map_err(|error| match error.kind() {
        ErrorKind::File => anyhow!("{error}; the environment variable TMPDIR sets another folder"),
        _ => error.into(),
    })
}
