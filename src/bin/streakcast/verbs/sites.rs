//! `sites`: the observatories known by name and MPC code.

use streakcast::geometry::Site;
use streakcast::output::{Column, Kind, Provenance, Section, Table};

use crate::arguments::ListArguments;
use crate::failure::Outcome;
use crate::output::{Answer, Output};
use crate::screen::{Shown, Style, rounded, shown};

const ON_SCREEN: &[Shown] = &[
    shown("mpc_code", "MPC"),
    shown("name", "name"),
    rounded("latitude_deg", "latitude deg", 4),
    rounded("longitude_deg", "longitude deg", 4),
    rounded("height_m", "height m", 0),
];

pub fn run(typed: &ListArguments) -> anyhow::Result<Outcome> {
    let wanted = typed.search.as_deref().unwrap_or("").to_lowercase();
    let holds = |site: &&Site| {
        let code = site.mpc_code.as_deref().unwrap_or("").to_lowercase();
        site.name.to_lowercase().contains(&wanted) || code.contains(&wanted)
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
            .filter(holds)
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
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?.write(&Answer {
        sections: vec![Section { name: "sites", table: &table }],
        main: &table,
        provenance: &Provenance::new(),
        style: Style { columns: ON_SCREEN, bold_row: None },
    })?;
    Ok(Outcome::Done)
}
