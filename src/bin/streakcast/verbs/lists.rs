//! `sites` and `shells`: list observatories with their names and MPC codes, and simulated constellations.

use std::collections::BTreeSet;

use clap::Args;
use streakcast::config::Config;
use streakcast::elements::{Constellation, ConstellationSet, DeploymentPeriod, Shell};
use streakcast::geometry::Site;
use streakcast::message::Quoted;
use streakcast::output::{Column, Kind, Provenance, Table, Value};

use crate::arguments::OutputArguments;
use crate::failure::Outcome;
use crate::help::help;
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, rounded, shown};

#[derive(Args)]
pub struct ListArguments {
    /// List only entries with this text in their name or code
    pub search: Option<String>,
    /// Suppress notes
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! { ListArguments, "sites", "", "rubin --format json" }

#[derive(Args)]
pub struct ShellArguments {
    /// List only constellations with this text in their name, or those of a TOML file
    #[arg(value_name = "SEARCH|FILE.toml")]
    pub search: Option<String>,
    /// Suppress notes
    #[arg(long, short)]
    pub quiet: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

help! { ShellArguments, "shells", "", "starlink --format csv" }

const SITES_ON_SCREEN: &[Shown] = &[
    shown("mpc_code", "MPC"),
    shown("name", "name"),
    rounded("latitude_deg", "latitude deg", 4),
    rounded("longitude_deg", "longitude deg", 4),
    rounded("height_m", "height m", 0),
];

const SHELLS_ON_SCREEN: &[Shown] = &[
    shown("name", "name"),
    shown("satellites", "satellites"),
    shown("n_shells", "shells"),
    rounded("lowest_km", "lowest km", 0),
    rounded("highest_km", "highest km", 0),
    shown("with_assumed_planes", "planes assumed"),
    shown("source", "source"),
];

pub fn sites(typed: &ListArguments) -> anyhow::Result<Outcome> {
    let search = typed.search.as_deref().unwrap_or("").to_lowercase();
    let matches = |site: &&Site| {
        let code = site.mpc_code.as_deref().unwrap_or("").to_lowercase();
        site.name.to_lowercase().contains(&search) || code.contains(&search)
    };
    let table = Table {
        columns: vec![
            Column::new("mpc_code", Kind::Text, "Code of the Minor Planet Center."),
            Column::new("name", Kind::Text, "Name."),
            Column::real("latitude_deg", "deg", 6, "Geodetic latitude (WGS84)."),
            Column::real("longitude_deg", "deg", 6, "Longitude, east positive."),
            Column::real("height_m", "m", 1, "Height above the ellipsoid."),
        ],
        rows: Site::all()
            .filter(matches)
            .map(|site| {
                vec![
                    site.mpc_code.as_deref().into(),
                    site.name.as_str().into(),
                    site.latitude_rad.to_degrees().into(),
                    site.longitude_rad.to_degrees().into(),
                    site.height_m.into(),
                ]
            })
            .collect(),
    };
    let notices = Notices::new(typed.quiet);
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?
        .write(&VerbResult::new("sites", &table, SITES_ON_SCREEN, &Provenance::new()), &notices)?;
    Ok(listed(&table, &typed.search, &notices, "site", "name or code"))
}

/// Returns the outcome of a list. If a search finds nothing, prints a message and returns the negative result.
fn listed(table: &Table, search: &Option<String>, notices: &Notices, what: &str, names: &str) -> Outcome {
    match search {
        Some(search) if table.rows.is_empty() => {
            notices.info(&format!("no {what} has '{search}' in its {names}"));
            Outcome::No
        }
        _ => Outcome::Done,
    }
}

pub fn shells(typed: &ShellArguments) -> anyhow::Result<Outcome> {
    let search = typed.search.as_deref().unwrap_or("");
    let is_file = search.ends_with(".toml");
    let config = Config { shells: Vec::from_iter(is_file.then(|| search.to_owned().into())), ..Config::default() };
    let deployment = config.deployment()?;
    let (all, sets) = match is_file {
        true => (deployment.always().iter().chain(deployment.own_growing()).cloned().collect(), Vec::new()),
        false => (Constellation::embedded(), Constellation::embedded_sets()),
    };
    let matches = |name: &str| is_file || name.contains(&search.to_lowercase());
    let row = |name: &str, several: &[&Constellation], shells: Vec<String>, source: String| -> Vec<Value> {
        let total = |of: &dyn Fn(&Constellation) -> usize| several.iter().map(|one| of(one)).sum::<usize>();
        let altitudes_km = || several.iter().flat_map(|one| &one.shells).map(|shell| shell.altitude_km);
        vec![
            name.into(),
            total(&Constellation::satellites).into(),
            total(&|constellation| constellation.shells.len()).into(),
            altitudes_km().reduce(f64::min).into(),
            altitudes_km().reduce(f64::max).into(),
            total(&Constellation::satellites_with_assumed_planes).into(),
            Value::List(shells),
            source.into(),
        ]
    };
    let row_of_one = |constellation: &Constellation| {
        let text = |shell: &Shell| format!("{}/{}", shell.altitude_km, shell.inclination_deg);
        let shells = constellation.shells.iter().map(text).collect();
        row(&constellation.name, &[constellation], shells, constellation.source.clone())
    };
    let row_of_set = |set: &ConstellationSet| {
        let of_set: Vec<_> =
            all.iter().filter(|constellation| set.constellations.contains(&constellation.name)).collect();
        row(&set.name, &of_set, Vec::new(), format!("{}: {}", set.source, set.constellations.join(", ")))
    };
    let row_of_period = |period: &DeploymentPeriod| {
        // Without the digits of rounding.
        let percent = |fraction: f64| (1e6 * fraction).round() / 1e4;
        let share = |constellation: &Constellation| {
            format!("{} {} %", constellation.name, percent(constellation.deployed_fraction))
        };
        let files = period.elements.iter().map(|path| format!("element sets of {}", path.display()));
        let shares: Vec<String> = period.constellations.iter().map(share).chain(files).collect();
        let of_period: Vec<_> = period.constellations.iter().collect();
        row(&format!("from {}", period.from), &of_period, Vec::new(), shares.join(", "))
    };
    let table = Table {
        columns: vec![
            Column::new("name", Kind::Text, "Name for --shells or for periods; or the first night of a period."),
            Column::new("satellites", Kind::Integer, "Number of simulated satellites."),
            Column::new("n_shells", Kind::Integer, "Number of shells."),
            Column::real("lowest_km", "km", 1, "Altitude of the lowest shell."),
            Column::real("highest_km", "km", 1, "Altitude of the highest shell."),
            Column::new(
                "with_assumed_planes",
                Kind::Integer,
                "Number of satellites in shells of which no source has the planes.",
            ),
            Column::new(
                "shells",
                Kind::List { separator: " " },
                "Altitude in km and inclination in degrees of each shell; empty for several constellations.",
            ),
            Column::new(
                "source",
                Kind::Text,
                "Source of the orbits, or the constellations of a set, or those of a period with its files of element sets.",
            ),
        ],
        rows: all
            .iter()
            .filter(|constellation| matches(&constellation.name))
            .map(row_of_one)
            .chain(sets.iter().filter(|set| matches(&set.name)).map(row_of_set))
            .chain(deployment.periods().map(row_of_period))
            .collect(),
    };
    let notices = Notices::new(typed.quiet);
    let deployed: BTreeSet<&str> = deployment
        .periods()
        .flat_map(|period| &period.constellations)
        .map(|constellation| constellation.name.as_str())
        .collect();
    let never = deployment.own_growing().filter(|constellation| !deployed.contains(constellation.name.as_str()));
    let never = never.map(|constellation| {
        format!("constellation {} is in no period: it is never in orbit", Quoted::new(&constellation.name))
    });
    notices.warn_first(never, "constellations in no period");
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?
        .write(&VerbResult::new("shells", &table, SHELLS_ON_SCREEN, &Provenance::new()), &notices)?;
    Ok(listed(&table, &typed.search, &notices, "constellation", "name"))
}
