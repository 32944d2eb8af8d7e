//! `map`: magnitudes over a satellite's own sky and over that of a site, as tables, FITS and pictures.

use std::fs;
use std::path::Path;
#[cfg(feature = "fits")]
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::anyhow;
use streakcast::geometry::Site;
#[cfg(feature = "fits")]
use streakcast::maps::DEFAULT_NSIDE;
use streakcast::maps::{BodyView, DEFAULT_STEP_DEG, Earth, Fact, Grid, SkyView};
use streakcast::photometry::{BrightnessModel, ModelLibrary};
use streakcast::setup::Setup;
use streakcast::table::{Provenance, Section, Table};

use crate::failure::Outcome;
use crate::map_arguments::{MapArguments, MapBodyArguments, MapOutputArguments, MapSkyArguments, MapVerb};
#[cfg(any(feature = "fits", feature = "plot"))]
use crate::output::check;
#[cfg(feature = "fits")]
use crate::output::write_bytes;
use crate::output::{Answer, Output};
use crate::screen::{Shown, Style, rounded};

use super::judged::begin;

const BODY_ON_SCREEN: &[Shown] = &[
    rounded("observer_longitude_deg", "longitude deg", 2),
    rounded("observer_latitude_deg", "latitude deg", 2),
    rounded("standard_magnitude", "mag at 1000 km", 2),
];

const SKY_ON_SCREEN: &[Shown] = &[
    rounded("azimuth_deg", "azimuth deg", 2),
    rounded("altitude_deg", "altitude deg", 2),
    rounded("range_km", "range km", 0),
    rounded("magnitude", "mag", 2),
];

pub fn run(typed: MapArguments) -> anyhow::Result<Outcome> {
    match typed.verb {
        MapVerb::Body(typed) => body(typed),
        MapVerb::Sky(typed) => sky(*typed),
        #[cfg(feature = "plot")]
        MapVerb::Paper(typed) => pictures::paper(&typed),
    }
}

fn body(typed: MapBodyArguments) -> anyhow::Result<Outcome> {
    let setup = typed.light.setup(Setup::default())?;
    let notices = begin(&setup)?;
    let model = model_of(&setup.model_library()?, &typed.light.model)?;
    let view = BodyView::new(&model, typed.sun_latitude_deg.to_radians(), typed.height_km, setup.photometry()?)?;
    let target = Target::new(&typed.output)?;
    notices.warn(&provisional(&model));
    if view.sun_latitude_rad() < view.limb_latitude_rad() {
        notices.say(&format!(
            "warning: at {} km the Sun is below the Earth's limb ({:.1} deg); magnitudes are those of full sunlight all the same",
            typed.height_km,
            view.limb_latitude_rad().to_degrees()
        ));
    }
    #[cfg(feature = "plot")]
    let picture = pictures::made(typed.output.picture.as_deref(), || streakcast::plot::body_picture(&view))?;
    match &target {
        #[cfg(feature = "plot")]
        Target::Nothing => {}
        Target::Table(output, grid) => {
            let map = view.map(*grid);
            write_table(output, &map.table(), &provenance_of(&map.facts), BODY_ON_SCREEN)?;
        }
        #[cfg(feature = "fits")]
        Target::Fits(path, grid) => write_bytes(path, &view.map(*grid).to_fits(&std::env::temp_dir())?)?,
    }
    #[cfg(feature = "plot")]
    pictures::write(typed.output.picture.as_deref(), picture)?;
    Ok(Outcome::Done)
}

fn sky(typed: MapSkyArguments) -> anyhow::Result<Outcome> {
    let setup = typed.light.setup(typed.place.setup())?;
    let notices = begin(&setup)?;
    let model = model_of(&setup.model_library()?, &typed.light.model)?;
    let setup = Setup {
        extinction: typed.extinction.or(setup.extinction),
        shadow: typed.shadow.clone().or(setup.shadow),
        ..setup
    };
    let options = setup.photometry()?;
    let earth = site_of(&setup)?.map_or(Earth::Sphere, Earth::Ellipsoid);
    let (sun_azimuth, sun_altitude) = (typed.sun_azimuth_deg.to_radians(), typed.sun_altitude_deg.to_radians());
    let view =
        SkyView::new(&model, earth, typed.height_km, sun_azimuth, sun_altitude, options)?.with_shadow(setup.shadow()?);
    let target = Target::new(&typed.output)?;
    notices.warn(&provisional(&model));
    #[cfg(feature = "plot")]
    let picture = pictures::made(typed.output.picture.as_deref(), || streakcast::plot::sky_picture(&view))?;
    match &target {
        #[cfg(feature = "plot")]
        Target::Nothing => {}
        Target::Table(output, grid) => {
            let map = view.map(*grid);
            write_table(output, &map.table(), &provenance_of(&map.facts), SKY_ON_SCREEN)?;
        }
        #[cfg(feature = "fits")]
        Target::Fits(path, grid) => write_bytes(path, &view.map(*grid).to_fits(&std::env::temp_dir())?)?,
    }
    #[cfg(feature = "plot")]
    pictures::write(typed.output.picture.as_deref(), picture)?;
    Ok(Outcome::Done)
}

/// A model of the library, or of a file.
pub fn model_of(library: &ModelLibrary, name: &str) -> anyhow::Result<Arc<BrightnessModel>> {
    if Path::new(name).extension().is_some_and(|end| end == "json") {
        let text = fs::read_to_string(name).map_err(|error| anyhow!("model {name}: {error}"))?;
        return Ok(Arc::new(BrightnessModel::from_json(&text, name)?));
    }
    library
        .get(name)
        .ok_or_else(|| anyhow!("unknown model '{name}'; known are {}", library.names().collect::<Vec<_>>().join(", ")))
}

/// The site, where one was said.
pub fn site_of(setup: &Setup) -> anyhow::Result<Option<Site>> {
    let said = [setup.lat, setup.lon, setup.height].iter().any(Option::is_some);
    let is_said = said || setup.site.is_some() || setup.mpc.is_some();
    Ok(if is_said { Some(setup.site()?) } else { None })
}

fn provisional(model: &BrightnessModel) -> Option<String> {
    let is_provisional = model.file().is_some_and(|file| file.provenance.provisional);
    is_provisional.then(|| format!("model {} is provisional (streakcast model show tells why)", model.source()))
}

fn provenance_of(facts: &[Fact]) -> Provenance {
    let mut provenance = Provenance::new();
    facts.iter().for_each(|fact| fact.state(&mut provenance));
    provenance
}

fn write_table(output: &Output, table: &Table, provenance: &Provenance, shown: &[Shown]) -> anyhow::Result<()> {
    output.write(&Answer {
        sections: vec![Section { name: "directions", table }],
        main: table,
        provenance,
        style: Style { columns: shown, bold_row: None },
    })
}

/// Where the numbers go; looked at before any work.
enum Target {
    /// Only a picture is wanted.
    #[cfg(feature = "plot")]
    Nothing,
    Table(Output, Grid),
    #[cfg(feature = "fits")]
    Fits(PathBuf, Grid),
}

impl Target {
    fn new(typed: &MapOutputArguments) -> anyhow::Result<Self> {
        let grid = match (typed.nside, typed.step_deg) {
            (Some(nside), _) => Grid::healpix(nside)?,
            (None, step) => Grid::regular(step.unwrap_or(DEFAULT_STEP_DEG))?,
        };
        #[cfg(feature = "plot")]
        if let Some(picture) = &typed.picture {
            streakcast::plot::PictureFormat::of(picture)?;
            check(picture)?;
            if typed.output.as_ref() == Some(picture) {
                return Err(anyhow!("--output and --picture name the same file {}", picture.display()));
            }
            if typed.output.is_none() && typed.format.is_none() {
                return Ok(Self::Nothing);
            }
        }
        let ends_in_fits = typed.output.as_ref().is_some_and(|path| path.extension().is_some_and(|end| end == "fits"));
        if typed.format.as_deref() == Some("fits") || typed.format.is_none() && ends_in_fits {
            return Self::fits(typed, grid);
        }
        Ok(Self::Table(Output::new(typed.format.as_deref(), typed.output.clone())?, grid))
    }

    #[cfg(feature = "fits")]
    fn fits(typed: &MapOutputArguments, grid: Grid) -> anyhow::Result<Self> {
        let path = typed.output.clone().ok_or_else(|| anyhow!("format fits needs a file; say -o map.fits"))?;
        if typed.step_deg.is_some() {
            return Err(anyhow!("format fits holds HEALPix maps; say --nside {DEFAULT_NSIDE} instead of --step-deg"));
        }
        check(&path)?;
        Ok(Self::Fits(path, if typed.nside.is_some() { grid } else { Grid::healpix(DEFAULT_NSIDE)? }))
    }

    #[cfg(not(feature = "fits"))]
    fn fits(_: &MapOutputArguments, _: Grid) -> anyhow::Result<Self> {
        Err(anyhow!("this streakcast was built without FITS (feature fits); allowed: table, csv, ecsv, json, jsonl"))
    }
}

/// What is drawn.
#[cfg(feature = "plot")]
mod pictures {
    use std::fs;
    use std::path::Path;

    use anyhow::anyhow;
    use streakcast::maps::PAPER_FIGURES;
    use streakcast::photometry::{Earthshine, ModelLibrary, PhotometryOptions};
    use streakcast::plot::{Picture, PictureFormat, paper_picture};

    use crate::failure::Outcome;
    use crate::map_arguments::{MapPaperArguments, PictureName};
    use crate::output::{check, write_bytes};

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
    pub fn paper(typed: &MapPaperArguments) -> anyhow::Result<Outcome> {
        let model = super::model_of(&ModelLibrary::embedded(), &typed.model)?;
        let (format, end) = match typed.format {
            PictureName::Png => (PictureFormat::Png, "png"),
            PictureName::Svg => (PictureFormat::Svg, "svg"),
        };
        let folder = &typed.output;
        if !folder.is_dir() {
            fs::create_dir(folder).map_err(|error| anyhow!("cannot make the folder {}: {error}", folder.display()))?;
        }
        let earthshine = if typed.no_earthshine { Earthshine::Off } else { Earthshine::default() };
        let options = PhotometryOptions { earthshine, ..PhotometryOptions::default() };
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
}
