//! Flags and questions of `setup`, and the home file with the answers.

use std::fs;
use std::path::PathBuf;

use anyhow::{anyhow, bail};
use clap::Args;
use streakcast::config::{Config, doubtful_site, parse_coordinates, parse_exposure_s};
use streakcast::geometry::Site;
use streakcast::input::check_regular;
use toml::Value;

use super::dialog::{Dialog, Prompt};
use super::towns::{Town, Towns};
use crate::cache::cache_folder;
use crate::clock::{now, zone_remark};
use crate::failure::Outcome;
use crate::help::help;
use crate::home;
use crate::local_time::local_time;
use crate::notices::Notices;
use crate::output::write_bytes;

#[derive(Args)]
pub struct SetupArguments {
    /// Place: an observatory by name or MPC code, coordinates as LAT,LON or LAT,LON,HEIGHT (degrees, metres), or a town
    /// with more than 15,000 people (Vienna, or Vienna,US)
    #[arg(long, value_name = "PLACE", allow_hyphen_values = true)]
    pub place: Option<String>,
    /// Time zone (Europe/Madrid) or hours ahead of UTC (+01:00); that of the closest town if omitted
    #[arg(long, value_name = "ZONE", allow_hyphen_values = true)]
    pub time_zone: Option<String>,
    /// File of element sets, or a folder of them; the file of streakcast fetch celestrak --group active if omitted
    #[arg(long, value_name = "FILE")]
    pub elements: Option<String>,
    /// Camera: field of view (3.5deg, 1.5x1.0deg, 36x24mm@400mm), a telescope by name or TOML file, or none
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<String>,
    /// Limiting magnitude: crossings of brighter satellites are avoided; 7, or by band g=7,default=6, or none
    #[arg(long, value_name = "MAG", allow_hyphen_values = true)]
    pub limit_mag: Option<String>,
    /// Exposure time of the camera, for example 30s or 2min
    #[arg(long, value_name = "TIME", default_value = DEFAULT_EXPOSURE)]
    pub exposure: String,
    /// Faintest magnitude of the passes that forecast lists
    #[arg(long, value_name = "MAG", default_value_t = 4.0, allow_hyphen_values = true)]
    pub max_mag: f64,
    /// Replace an existing home file
    #[arg(long)]
    pub force: bool,
    /// Suppress everything except errors on standard error
    #[arg(long, short)]
    pub quiet: bool,
}

help! {
    SetupArguments, "setup",
    "--place Vienna --camera 1.5x1.0deg --limit-mag 7",
    "--place=-30.24,-70.75,2663 --elements active.tle --force"
}

/// Exposure time without the flag; without a camera it is not written into the home file.
const DEFAULT_EXPOSURE: &str = "60s";
/// Answer for no camera and no limit.
const NONE: &str = "none";
/// Distance up to which the closest town has the time zone of a site, km.
const SAME_ZONE_KM: f64 = 300.0;
/// Name of the file of `streakcast fetch celestrak --group active` in the cache folder.
const ACTIVE: &str = "celestrak-active.csv";
const FETCH: &str = "fetch celestrak --group active";

/// Place of an observer.
struct Place {
    /// Keys of the home file.
    keys: String,
    site: Site,
    /// Town by whose name the place is given.
    town: Option<Town>,
    /// Other towns with this name, with their countries.
    others: Vec<String>,
}

pub fn run(typed: SetupArguments) -> anyhow::Result<Outcome> {
    let file = home::path().ok_or_else(|| anyhow!("this system has no folder for configuration files"))?;
    let (dialog, notices) = (Dialog::new(), Notices::new(typed.quiet));
    parse_exposure_s(&typed.exposure)?;
    if !(-30.0..=40.0).contains(&typed.max_mag) {
        bail!("max-mag is {} mag; allowed: -30 to 40 mag", typed.max_mag);
    }
    if file.exists() {
        check_regular(&file).map_err(|error| crate::output::cannot_write(&file, &error))?;
    }
    if file.exists() && !typed.force && !dialog.agrees(&format!("{} exists. Replace it?", file.display()))? {
        bail!("{} exists; allowed: --force, which replaces it", file.display());
    }
    let towns = Towns::embedded();
    let prompt = Prompt { text: "Place (observatory, MPC code, LAT,LON, or town)", flag: "--place PLACE", default: "" };
    let place = dialog.answer(&prompt, typed.place.as_deref(), |text| place(text, &towns))?;
    let near = towns.closest(&place.site).filter(|town| town.distance_km(&place.site) < SAME_ZONE_KM);
    let default = place.town.as_ref().or(near).map_or("", |town| town.time_zone.as_str());
    let prompt = Prompt { text: "Time zone", flag: "--time-zone ZONE", default };
    let zone = dialog.answer(&prompt, typed.time_zone.as_deref(), |text| {
        local_time(text).map(|_| text.to_owned()).map_err(|error| anyhow!("'{text}' is {error}"))
    })?;
    let cached = cache_folder(None).map(|folder| folder.join(ACTIVE).display().to_string()).unwrap_or_default();
    let prompt = Prompt { text: "Element sets (file or folder)", flag: "--elements FILE", default: &cached };
    let elements = dialog.answer(&prompt, typed.elements.as_deref(), |text| elements(text, &cached))?;
    let text = "Camera (field such as 1.5x1.0deg or 36x24mm@400mm, telescope, or none)";
    let prompt = Prompt { text, flag: "--camera CAMERA", default: NONE };
    let camera = dialog.answer(&prompt, typed.camera.as_deref(), camera)?;
    let prompt = Prompt { text: "Limiting magnitude of crossings (or none)", flag: "--limit-mag MAG", default: NONE };
    let limit = dialog.answer(&prompt, typed.limit_mag.as_deref(), limit)?;

    let mut text = "# Home file by streakcast setup. Keys are the names of flags, which have precedence.\n".to_owned();
    if let Some(town) = &place.town {
        text += &format!("# {} (GeoNames, CC BY 4.0), within some kilometres.\n", town.name());
    }
    text += &format!("{}time_zone = {}\n", place.keys, quoted(&zone));
    text += &format!("elements = [{}]\n", quoted(&elements.display().to_string()));
    text += &[camera.clone(), limit].into_iter().flatten().collect::<String>();
    text += &format!("\n[forecast]\nmax_mag = {:?}\n", typed.max_mag);
    if camera.is_some() || typed.exposure != DEFAULT_EXPOSURE {
        let exposure = quoted(&typed.exposure);
        text += &format!("\n[windows]\nexposure = {exposure}\n\n[gate]\nexposure = {exposure}\n");
    }
    write_bytes(&file, text.as_bytes(), &notices)?;
    let Site { latitude_rad, longitude_rad, height_m, name, .. } = &place.site;
    let is_named = place.town.is_some() || !place.keys.contains("lat =");
    let name = place.town.as_ref().map_or(name.clone(), Town::name);
    let name = if is_named { name } else { near.map_or(String::new(), |town| format!("near {}", town.name())) };
    let (latitude_deg, longitude_deg) = (latitude_rad.to_degrees(), longitude_rad.to_degrees());
    let has_height = !place.keys.contains("lat =") || place.keys.contains("height =");
    let height =
        if has_height { format!("{height_m:.0} m") } else { "height unknown (0 m is used; key height)".to_owned() };
    let at = format!("{latitude_deg:.4} deg north, {longitude_deg:.4} deg east, {height}");
    notices.info(&format!("place: {}; time zone {zone}", [name, at].join(", ").trim_start_matches(", ")));
    let doubtful = doubtful_site(&place.site).map(|(finding, remedy)| format!("{finding}; {remedy}"));
    let zone = local_time(&zone).ok();
    notices.warn(doubtful.as_slice());
    notices.warn(zone.and_then(|zone| zone_remark(&zone, &place.site, now())).as_slice());
    if !place.others.is_empty() {
        notices.info(&format!("towns with this name: {}", place.others.join("; ")));
    }
    if place.town.is_some() {
        notices.info(
            "a town is known within some kilometres, which is enough for forecasts; for the crossings of a field \
                      narrower than a degree replace lat and lon by those of the telescope, and add its height (m)",
        );
    }
    notices.info(&next_steps(camera.is_some(), elements.exists()));
    Ok(Outcome::Done)
}

/// Returns the commands that need no further flags.
fn next_steps(has_camera: bool, has_elements: bool) -> String {
    let mut lines = Vec::new();
    if !has_elements {
        lines.push(format!("first, and every day or two: streakcast {FETCH}"));
    }
    lines.push("passes of tonight: streakcast forecast".to_owned());
    if has_camera {
        lines.push("clear windows of a target: streakcast windows --target M31".to_owned());
        lines.push("before each exposure: streakcast gate --target M31".to_owned());
    }
    lines.push("check of all inputs: streakcast doctor".to_owned());
    lines.join("\n")
}

fn quoted(text: &str) -> String {
    Value::String(text.to_owned()).to_string()
}

/// Returns the configuration with these keys.
fn config(keys: &str) -> anyhow::Result<Config> {
    Ok(Config::from_toml(keys, "of the answers")?)
}

/// Reads a place: coordinates, an observatory, or a town.
fn place(text: &str, towns: &Towns) -> anyhow::Result<Place> {
    let text = text.trim();
    if let Some(coordinates) = parse_coordinates(text) {
        let (lat, lon, height) = coordinates.map_err(|error| anyhow!(error))?;
        let height = height.map(|height| format!("height = {height:?}\n")).unwrap_or_default();
        let keys = format!("lat = {lat:?}\nlon = {lon:?}\n{height}");
        return Ok(Place { site: config(&keys)?.site()?, keys, town: None, others: Vec::new() });
    }
    for keys in [format!("mpc = {}\n", quoted(text)), format!("site = {}\n", quoted(text))] {
        if let Ok(site) = config(&keys)?.site() {
            let others = towns.by_name(text).iter().take(5).map(|town| town.name()).collect();
            return Ok(Place { keys, site, town: None, others });
        }
    }
    let found = towns.by_name(text);
    let Some(town) = found.first() else {
        let similar = towns.similar(text);
        let hint = if similar.is_empty() { String::new() } else { format!(" (similar: {})", similar.join("; ")) };
        bail!(
            "unknown place '{text}'{hint}; allowed: an observatory or code listed by streakcast sites, LAT,LON in decimal \
             degrees with a point (south and west negative), or a town with more than 15,000 people"
        );
    };
    let keys = format!("lat = {:?}\nlon = {:?}\n", town.latitude_deg, town.longitude_deg);
    let others = found.iter().skip(1).take(5).map(|town| town.name()).collect();
    Ok(Place { site: config(&keys)?.site()?, keys, town: Some((*town).clone()), others })
}

/// Reads the path of element sets; that of the cache may not exist yet.
fn elements(text: &str, cached: &str) -> anyhow::Result<PathBuf> {
    let path = std::path::absolute(text)?;
    if text != cached {
        fs::metadata(&path).map_err(|error| anyhow!("element sets {}: {error}", path.display()))?;
        config(&format!("elements = [{}]\n", quoted(&path.display().to_string())))?.load()?;
    }
    Ok(path)
}

/// Reads a camera and returns its keys; `None` if there is none.
fn camera(text: &str) -> anyhow::Result<Option<String>> {
    if text.eq_ignore_ascii_case(NONE) {
        return Ok(None);
    }
    let keys = if text.ends_with(".toml") {
        format!("telescope = {}\n", quoted(&std::path::absolute(text)?.display().to_string()))
    } else if text.starts_with(|first: char| first.is_ascii_digit() || first == '.') {
        format!("fov = {}\n", quoted(text))
    } else {
        format!("telescope = {}\n", quoted(text))
    };
    config(&keys)?.field_of_view()?;
    Ok(Some(keys))
}

/// Reads a magnitude limit and returns its key; `None` if there is none.
fn limit(text: &str) -> anyhow::Result<Option<String>> {
    if text.eq_ignore_ascii_case(NONE) {
        return Ok(None);
    }
    let value = match text.trim().parse::<f64>() {
        Ok(_) => text.trim().to_owned(),
        Err(_) => {
            text.parse::<streakcast::schedule::MagnitudeLimit>().map_err(|error| anyhow!("limit-mag: {error}"))?;
            let by_band: Vec<String> = text.split(',').map(|limit| limit.replacen('=', " = ", 1)).collect();
            format!("{{ {} }}", by_band.join(", "))
        }
    };
    let key = format!("limit_mag = {value}\n");
    config(&key)?.policy()?;
    Ok(Some(key))
}
