//! `map body` and `map sky`: write the table of a map, its picture, or both.

use std::path::Path;
use std::sync::Arc;

use anyhow::{anyhow, bail};
use streakcast::config::{Config, SiteConfig};
use streakcast::geometry::Site;
use streakcast::maps::{BodyView, Earth, Fact, SkyView};
use streakcast::output::{Provenance, Table};
use streakcast::photometry::{BrightnessModel, ModelLibrary};

use crate::failure::Outcome;
use crate::notices::Notices;
#[cfg(unix)]
use crate::output::write_bytes;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded};

use super::arguments::{MapArguments, MapBodyArguments, MapSkyArguments, MapVerb};
use super::pictures;
use super::target::Target;
#[cfg(unix)]
use super::target::fits_bytes;
use crate::start::begin;

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
        MapVerb::Body(typed) => typed.run(body),
        MapVerb::Sky(typed) => typed.run(sky),
        MapVerb::Paper(typed) => typed.run(pictures::paper),
    }
}

/// Writes a map over the directions around a satellite.
pub fn body(MapBodyArguments { view: typed, output: to }: MapBodyArguments) -> anyhow::Result<Outcome> {
    let config = typed.light.config(SiteConfig::default())?;
    let notices = begin(&config)?;
    let model = model_of(&config.model_library()?, &typed.model)?;
    let view = BodyView::new(&model, typed.sun_latitude_deg.to_radians(), typed.height_km, config.photometry()?)?;
    let target = Target::new(&to, config.format.as_deref())?;
    notices.warn(&provisional(&model));
    let site_options = [("extinction", config.extinction.is_some()), ("shadow", config.shadow.is_some())];
    notices.warn(&unused_options(&config, &site_options, "a map of the directions around a satellite"));
    if view.sun_latitude_rad() < view.limb_latitude_rad() {
        notices.info(&format!(
            "warning: at {} km the Sun is below the Earth's limb ({:.1} deg); magnitudes are for full sunlight nevertheless",
            typed.height_km,
            view.limb_latitude_rad().to_degrees()
        ));
    }
    let picture = pictures::made(&to, &provenance_of(&view.facts()), || streakcast::plot::body_picture(&view))?;
    match &target {
        Target::Nothing => {}
        Target::Table(output, grid) => {
            let map = view.map(*grid)?;
            write_table(output, &map.table(), &provenance_of(&map.facts), BODY_ON_SCREEN, &notices)?;
        }
        #[cfg(unix)]
        Target::Fits(path, grid) => {
            write_bytes(path, &fits_bytes(|scratch| view.map(*grid)?.to_fits(scratch))?, &notices)?
        }
    }
    pictures::write(to.picture.as_deref(), picture, &notices)?;
    Ok(Outcome::Done)
}

/// Writes a map over the sky of a site.
pub fn sky(MapSkyArguments { view: typed, output: to }: MapSkyArguments) -> anyhow::Result<Outcome> {
    let config = typed.light.config(typed.site.clone())?;
    let notices = begin(&config)?;
    let model = model_of(&config.model_library()?, &typed.model)?;
    let config = Config {
        extinction: typed.extinction.or(config.extinction),
        shadow: typed.shadow.clone().or(config.shadow),
        ..config
    };
    if config.is_in_orbit() {
        bail!(
            "the observer of the configuration is in orbit; allowed: a site on the ground (--site, --mpc, or --lat and --lon)"
        );
    }
    let options = config.photometry()?;
    let earth = site_of(&config)?.map_or(Earth::Sphere, Earth::Ellipsoid);
    let (sun_azimuth, sun_altitude) = (typed.sun_azimuth_deg.to_radians(), typed.sun_altitude_deg.to_radians());
    let view =
        SkyView::new(&model, earth, typed.height_km, sun_azimuth, sun_altitude, options)?.with_shadow(config.shadow()?);
    let target = Target::new(&to, config.format.as_deref())?;
    notices.warn(&provisional(&model));
    notices.warn(&unused_options(&config, &[], "a map of the sky"));
    let picture = pictures::made(&to, &provenance_of(&view.facts()), || streakcast::plot::sky_picture(&view))?;
    match &target {
        Target::Nothing => {}
        Target::Table(output, grid) => {
            let map = view.map(*grid)?;
            write_table(output, &map.table(), &provenance_of(&map.facts), SKY_ON_SCREEN, &notices)?;
        }
        #[cfg(unix)]
        Target::Fits(path, grid) => {
            write_bytes(path, &fits_bytes(|scratch| view.map(*grid)?.to_fits(scratch))?, &notices)?
        }
    }
    pictures::write(to.picture.as_deref(), picture, &notices)?;
    Ok(Outcome::Done)
}

/// Returns the model with this name in the library, or of this file. The text is a path if it has the extension .json
/// or a folder, or if it is not a name in the library and such a file exists.
pub fn model_of(library: &ModelLibrary, name: &str) -> anyhow::Result<Arc<BrightnessModel>> {
    let path = Path::new(name);
    let is_path =
        path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json")) || name.contains(std::path::is_separator);
    let known = library.get(name).filter(|_| !is_path);
    if known.is_none() && (is_path || path.is_file()) {
        let text =
            streakcast::input::read_to_string(name.as_ref()).map_err(|error| anyhow!("model {name}: {error}"))?;
        return Ok(Arc::new(BrightnessModel::from_json(&text, name)?));
    }
    known.ok_or_else(|| {
        let names = library.names().collect::<Vec<_>>().join(", ");
        anyhow!("unknown model '{name}', and no file of that name; allowed: {names}")
    })
}

/// Returns a warning that lists the options of the configuration that have no effect on a map.
pub fn unused_options(config: &Config, more: &[(&str, bool)], map: &str) -> Option<String> {
    let sun = ("sun_distance", config.sun_distance == Some(true));
    let unused: Vec<&str> = [sun].iter().chain(more).filter(|(_, is_given)| *is_given).map(|(key, _)| *key).collect();
    let verb = if unused.len() == 1 { "has" } else { "have" };
    (!unused.is_empty()).then(|| format!("{} of the configuration {verb} no effect on {map}", unused.join(", ")))
}

/// Returns the site; `None` if none is given.
pub fn site_of(config: &Config) -> anyhow::Result<Option<Site>> {
    Ok(if config.site.is_given() { Some(config.site()?) } else { None })
}

pub fn provisional(model: &BrightnessModel) -> Option<String> {
    let is_provisional = model.file().is_some_and(|file| file.provenance.provisional);
    is_provisional.then(|| format!("model {} is provisional (see streakcast model show)", model.source()))
}

fn provenance_of(facts: &[Fact]) -> Provenance {
    let mut provenance = Provenance::new();
    facts.iter().for_each(|fact| fact.state(&mut provenance));
    provenance
}

fn write_table(
    output: &Output,
    table: &Table,
    provenance: &Provenance,
    shown: &[Shown],
    notices: &Notices,
) -> anyhow::Result<()> {
    output.write(&VerbResult::new("directions", table, shown, provenance), notices)
}
