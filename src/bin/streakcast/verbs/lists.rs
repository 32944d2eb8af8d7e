//! `sites` and `shells`: list observatories with their names and MPC codes, and simulated constellations.

use clap::Args;
use streakcast::elements::Constellation;
use streakcast::geometry::Site;
use streakcast::output::{Column, Kind, Provenance, Section, Table, Value};

use crate::arguments::OutputArguments;
use crate::failure::Outcome;
use crate::notices::Notices;
use crate::output::{Output, VerbResult};
use crate::screen::{Shown, Style, rounded, shown};

#[derive(Args)]
pub struct ListArguments {
    /// List only entries with this text in their name or code
    pub search: Option<String>,
    #[command(flatten)]
    pub output: OutputArguments,
}

const SITES_ON_SCREEN: &[Shown] = &[
    shown("mpc_code", "MPC"),
    shown("name", "name"),
    rounded("latitude_deg", "latitude deg", 4),
    rounded("longitude_deg", "longitude deg", 4),
    rounded("height_m", "height m", 0),
];

const SHELLS_ON_SCREEN: &[Shown] =
    &[shown("name", "name"), shown("satellites", "satellites"), shown("shells", "shells"), shown("source", "source")];

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
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?.write(
        &VerbResult {
            sections: vec![Section { name: "sites", table: &table }],
            main: &table,
            provenance: &Provenance::new(),
            style: Style { columns: SITES_ON_SCREEN, bold_row: None },
        },
        &Notices::new(false),
    )?;
    Ok(listed(&table, &typed.search, "site", "name or code"))
}

/// Returns the outcome of a list. If a search finds nothing, prints a message and returns the negative result.
fn listed(table: &Table, search: &Option<String>, what: &str, names: &str) -> Outcome {
    match search {
        Some(search) if table.rows.is_empty() => {
            Notices::new(false).info(&format!("no {what} has '{search}' in its {names}"));
            Outcome::No
        }
        _ => Outcome::Done,
    }
}

pub fn shells(typed: &ListArguments) -> anyhow::Result<Outcome> {
    let search = typed.search.as_deref().unwrap_or("").to_lowercase();
    let all = Constellation::embedded();
    let table = Table {
        columns: vec![
            Column::new("name", Kind::Text, "Name for --shells."),
            Column::new("satellites", Kind::Integer, "Number of satellites."),
            Column::new(
                "shells",
                Kind::List { separator: " " },
                "Altitude in km and inclination in degrees of each shell.",
            ),
            Column::new("source", Kind::Text, "Source of the orbits."),
        ],
        rows: all
            .iter()
            .filter(|constellation| constellation.name.contains(&search))
            .map(|constellation| {
                let shells = constellation.shells.iter();
                let shells = shells.map(|shell| format!("{}/{}", shell.altitude_km, shell.inclination_deg)).collect();
                vec![
                    constellation.name.as_str().into(),
                    constellation.satellites().into(),
                    Value::List(shells),
                    constellation.source.as_str().into(),
                ]
            })
            .collect(),
    };
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?.write(
        &VerbResult {
            sections: vec![Section { name: "shells", table: &table }],
            main: &table,
            provenance: &Provenance::new(),
            style: Style { columns: SHELLS_ON_SCREEN, bold_row: None },
        },
        &Notices::new(false),
    )?;
    Ok(listed(&table, &typed.search, "constellation", "name"))
}
