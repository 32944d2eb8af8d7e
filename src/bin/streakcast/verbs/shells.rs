//! `shells`: the synthetic constellations that need no download.

use streakcast::elements::Constellation;
use streakcast::output::{Column, Kind, Provenance, Section, Table};

use crate::arguments::ListArguments;
use crate::failure::Outcome;
use crate::output::{Answer, Output};
use crate::screen::{Shown, Style, shown};

const ON_SCREEN: &[Shown] =
    &[shown("name", "name"), shown("satellites", "satellites"), shown("shells", "shells"), shown("source", "source")];

pub fn run(typed: &ListArguments) -> anyhow::Result<Outcome> {
    let wanted = typed.search.as_deref().unwrap_or("").to_lowercase();
    let all = Constellation::embedded();
    let table = Table {
        columns: vec![
            Column::new("name", Kind::Text, "What --shells takes."),
            Column::new("satellites", Kind::Integer, "How many satellites."),
            Column::new(
                "shells",
                Kind::List { separator: " " },
                "Altitude in km and inclination in degrees of each shell.",
            ),
            Column::new("source", Kind::Text, "Where the numbers come from."),
        ],
        rows: all
            .iter()
            .filter(|constellation| constellation.name.contains(&wanted))
            .map(|constellation| {
                let shells = constellation.shells.iter();
                let shells = shells.map(|shell| format!("{}/{}", shell.altitude_km, shell.inclination_deg)).collect();
                vec![
                    constellation.name.as_str().into(),
                    constellation.satellites().into(),
                    streakcast::output::Value::List(shells),
                    constellation.source.as_str().into(),
                ]
            })
            .collect(),
    };
    Output::new(typed.output.format.as_deref(), typed.output.output.clone())?.write(&Answer {
        sections: vec![Section { name: "shells", table: &table }],
        main: &table,
        provenance: &Provenance::new(),
        style: Style { columns: ON_SCREEN, bold_row: None },
    })?;
    Ok(Outcome::Done)
}
