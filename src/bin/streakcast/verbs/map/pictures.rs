//! Pictures of maps.

use std::path::Path;

use streakcast::config::SiteConfig;
use streakcast::maps::PAPER_FIGURES;
use streakcast::output::Provenance;
use streakcast::photometry::PhotometryOptions;
use streakcast::plot::{FileOptions, Picture, PictureFormat, paper_picture};

use super::arguments::{MapOutputArguments, MapPaperArguments, PictureName};
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{check, write_bytes};
use crate::start::begin;
use crate::verbs::plot::json_of;

/// Returns the bytes of a picture in the format of its path; `None` if there is no path.
pub fn made(
    to: &MapOutputArguments,
    provenance: &Provenance,
    picture: impl FnOnce() -> Picture,
) -> anyhow::Result<Option<Vec<u8>>> {
    let options = FileOptions { provenance: Some(json_of(provenance)), ..to.file_options.clone() };
    to.picture.as_deref().map(|path| Ok(picture().to_file(PictureFormat::from_extension(path)?, &options)?)).transpose()
}

pub fn write(path: Option<&Path>, bytes: Option<Vec<u8>>, notices: &Notices) -> anyhow::Result<()> {
    match (path, bytes) {
        (Some(path), Some(bytes)) => write_bytes(path, &bytes, notices),
        _ => Ok(()),
    }
}

/// Draws the four figures, and then writes them, so that an error in drawing leaves no files.
pub fn paper(typed: MapPaperArguments) -> anyhow::Result<Outcome> {
    let config = typed.light.config(SiteConfig::default())?;
    let notices = begin(&config)?;
    let model = super::run::model_of(&config.model_library()?, &typed.model)?;
    let (format, end) = match typed.format {
        PictureName::Png => (PictureFormat::Png, "png"),
        PictureName::Svg => (PictureFormat::Svg, "svg"),
    };
    // The maps of the paper have no atmospheric extinction.
    let options = PhotometryOptions { extinction_mag_per_airmass: None, ..config.photometry()? };
    let folder = &typed.output;
    notices.warn(&super::run::provisional(&model));
    let site_options = [("extinction", config.extinction.is_some()), ("shadow", config.shadow.is_some())];
    notices.warn(&super::run::unused_options(&config, &site_options, "the paper's figures"));
    let mut pictures = Vec::new();
    for figure in &PAPER_FIGURES {
        let path = folder.join(format!("figure-{}.{end}", figure.number));
        check(&path)?;
        let picture = paper_picture(figure, &model, options)?;
        let mut provenance = Provenance::new();
        provenance.state("figure", figure.number);
        provenance.state("model", model.source().to_string());
        provenance.state_all(options.statements());
        let file_options = FileOptions { provenance: Some(json_of(&provenance)), ..FileOptions::default() };
        pictures.push((path, picture.to_file(format, &file_options)?));
    }
    for (path, bytes) in &pictures {
        write_bytes(path, bytes, &notices)?;
    }
    Ok(Outcome::Done)
}
