//! Pictures of maps.

use std::fs;
use std::path::Path;

use anyhow::anyhow;
use streakcast::config::SiteConfig;
use streakcast::maps::PAPER_FIGURES;
use streakcast::photometry::PhotometryOptions;
use streakcast::plot::{Picture, PictureFormat, paper_picture};

use super::arguments::{MapPaperArguments, PictureName};
use crate::failure::Outcome;
use crate::output::{check, write_bytes};
use crate::verbs::judged::begin;

/// The bytes of a picture, where one is wanted.
pub fn made(path: Option<&Path>, picture: impl FnOnce() -> Picture) -> anyhow::Result<Option<Vec<u8>>> {
    path.map(|path| Ok(picture().to_bytes(PictureFormat::of(path)?)?)).transpose()
}

pub fn write(path: Option<&Path>, bytes: Option<Vec<u8>>) -> anyhow::Result<()> {
    match (path, bytes) {
        (Some(path), Some(bytes)) => write_bytes(path, &bytes),
        _ => Ok(()),
    }
}

/// All four figures are drawn before the first is written.
pub fn paper(typed: MapPaperArguments) -> anyhow::Result<Outcome> {
    let config = typed.light.config(SiteConfig::default())?;
    let notices = begin(&config)?;
    let model = super::run::model_of(&config.model_library()?, &typed.model)?;
    let (format, end) = match typed.format {
        PictureName::Png => (PictureFormat::Png, "png"),
        PictureName::Svg => (PictureFormat::Svg, "svg"),
    };
    // The paper's maps are those above the air.
    let options = PhotometryOptions { extinction_mag_per_airmass: None, ..config.photometry()? };
    let folder = &typed.output;
    if !folder.is_dir() {
        fs::create_dir(folder).map_err(|error| anyhow!("cannot make the folder {}: {error}", folder.display()))?;
    }
    notices.warn(&super::run::provisional(&model));
    let of_a_site = [("extinction", config.extinction.is_some()), ("shadow", config.shadow.is_some())];
    notices.warn(&super::run::without_part(&config, &of_a_site, "the paper's figures"));
    let mut pictures = Vec::new();
    for figure in &PAPER_FIGURES {
        let path = folder.join(format!("figure-{}.{end}", figure.number));
        check(&path)?;
        let picture = paper_picture(figure, &model, options)?;
        pictures.push((path, picture.to_bytes(format)?));
    }
    for (path, bytes) in &pictures {
        write_bytes(path, bytes)?;
    }
    Ok(Outcome::Done)
}
