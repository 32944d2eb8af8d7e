//! Coordinates of targets by name, for hosts that send only the name.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use streakcast::config::Quantity;
use streakcast::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};

use super::status_file::{Fault, FaultKind};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    targets: BTreeMap<String, Coordinates>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Coordinates {
    ra: Quantity,
    dec: Quantity,
}

/// Returns the coordinates of a target. Case, blanks, underscores and hyphens in the name are ignored (Ekos replaces
/// blanks by underscores).
pub fn look_up(path: &Path, name: &str) -> Result<Direction<Gcrs>, Fault> {
    let fault = |what: String| Fault::new(FaultKind::Target, format!("targets {}: {what}", path.display()));
    let text = streakcast::input::read_to_string(path).map_err(|error| fault(error.to_string()))?;
    let file: File =
        toml::from_str(&text).map_err(|error| fault(streakcast::input::toml_error(&error, &text).to_string()))?;
    let key = |name: &str| name.to_lowercase().replace(|c: char| c.is_whitespace() || c == '_' || c == '-', "");
    let found = file
        .targets
        .get(name)
        .or_else(|| file.targets.iter().find_map(|(known, target)| (key(known) == key(name)).then_some(target)));
    let target = found.ok_or_else(|| fault(format!("unknown target '{name}'; allowed: {}", known(&file))))?;
    let angles = parse_right_ascension_deg(target.ra.as_str())
        .and_then(|ra_deg| Ok((ra_deg, parse_declination_deg(target.dec.as_str())?)))
        .map_err(|error| fault(format!("target '{name}': {error}")))?;
    Ok(Direction::from_lon_lat_rad(angles.0.to_radians(), angles.1.to_radians()))
}

fn known(file: &File) -> String {
    const SHOWN: usize = 8;
    let mut names: Vec<&str> = file.targets.keys().take(SHOWN).map(String::as_str).collect();
    if file.targets.len() > SHOWN {
        names.push("...");
    }
    names.join(", ")
}
