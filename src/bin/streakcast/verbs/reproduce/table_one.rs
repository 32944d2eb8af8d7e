//! Table 1 of Lu (2024): satellites launched into orbit by generation, counted in a catalogue.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::anyhow;
use streakcast::elements::{Generation, GenerationTable, NoradId, Satellites};
use streakcast::fit::Lu2024Row;
use streakcast::input::TableRows;

/// Printed counts of 12 January 2024, with the generations that the paper counts together.
const PRINTED: [(&str, f64, &[Generation]); 4] = [
    ("Starlink V1.0 with VisorSats", 1665.0, &[Generation::StarlinkV10, Generation::StarlinkVisorSat]),
    ("Starlink V1.5", 2987.0, &[Generation::StarlinkV15]),
    ("Starlink V2 Mini with Direct-to-Cell", 978.0, &[Generation::StarlinkV2Mini, Generation::StarlinkDirectToCell]),
    ("OneWeb", 640.0, &[Generation::OneWeb]),
];
/// Last launch up to 12 January 2024.
const LAST_LAUNCH: &str = "2024-010";
/// Catalogue numbers of supplemental element sets of satellites that are not catalogued yet. The same satellites have
/// other numbers in later files.
const TEMPORARY_IDS: [u32; 2] = [70_000, 79_999];

/// Counts the satellites of table 1 in a SATCAT (CSV of CelesTrak), or else in element sets. If neither is given, the
/// rows have no counts.
pub fn rows(satcat: Option<&Path>, elements: &[PathBuf]) -> anyhow::Result<Vec<Lu2024Row>> {
    let (objects, reason) = match satcat {
        Some(path) => (Some(of_satcat(path)?), "the paper counts in Jonathan's Space Report and Wikipedia"),
        None if !elements.is_empty() => (
            Some(of_elements(elements)?),
            "element sets hold only satellites that were in orbit at their dates; a SATCAT (--satcat) holds all that were launched",
        ),
        None => (None, "needs a catalogue: --satcat FILE, or --elements FILE for those still in orbit"),
    };
    Ok(PRINTED
        .iter()
        .map(|(name, count, generations)| Lu2024Row {
            section: "table 1",
            quantity: format!("{name}, launched to 2024-01-12"),
            unit: "",
            paper: Some(*count),
            ours: objects.as_ref().map(|objects| {
                objects.iter().filter(|(_, generation)| generations.contains(generation)).count() as f64
            }),
            ours_sigma: None,
            reason: reason.to_owned(),
        })
        .collect())
}

/// Returns the objects launched up to the date of the table with their generations.
fn of_elements(paths: &[PathBuf]) -> anyhow::Result<BTreeSet<(NoradId, Generation)>> {
    let table = GenerationTable::embedded();
    let sets = Satellites::read(paths, &Default::default())?.element_sets;
    let [first, last] = TEMPORARY_IDS;
    Ok(sets
        .iter()
        .filter(|set| is_launched(&set.international_designator) && !(first..=last).contains(&set.norad_id.0))
        .map(|set| (set.norad_id, table.generation(set)))
        .collect())
}

fn is_launched(designator: &str) -> bool {
    designator.get(..LAST_LAUNCH.len()).is_some_and(|launch| launch <= LAST_LAUNCH)
}

fn of_satcat(path: &Path) -> anyhow::Result<BTreeSet<(NoradId, Generation)>> {
    let shown = path.display();
    let failed = |error: std::io::Error| anyhow!("satcat {shown}: {error}");
    let rows = TableRows::open(path).map_err(failed)?;
    let column = |name| rows.column(name, "the SATCAT of CelesTrak as CSV").map_err(failed);
    let [name, designator, id] = [column("OBJECT_NAME")?, column("OBJECT_ID")?, column("NORAD_CAT_ID")?];
    let table = GenerationTable::embedded();
    let mut objects = BTreeSet::new();
    for row in rows {
        let row = row.map_err(failed)?;
        let id = NoradId(row.parsed(id, "a catalogue number").map_err(failed)?);
        if is_launched(row.text(designator)) {
            objects.insert((id, table.classify_object(row.text(name), row.text(designator), id).0));
        }
    }
    Ok(objects)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A satellite, the same one with a temporary number, and a later launch.
    #[test]
    fn temporary_numbers_and_later_launches_are_left_out() {
        let orbit = "2022-08-31T00:00:00,15.06,0.0001,53.2,10,20,30,0";
        let text = [
            "OBJECT_NAME,OBJECT_ID,NORAD_CAT_ID,CLASSIFICATION_TYPE,EPOCH,MEAN_MOTION,ECCENTRICITY,INCLINATION,RA_OF_ASC_NODE,ARG_OF_PERICENTER,MEAN_ANOMALY,EPHEMERIS_TYPE,ELEMENT_SET_NO,REV_AT_EPOCH,BSTAR,MEAN_MOTION_DOT,MEAN_MOTION_DDOT".to_owned(),
            format!("STARLINK-4357,2022-104A,53662,U,{orbit},999,1,0.0001,0,0"),
            format!("STARLINK-4357,2022-104A,74357,C,{orbit},999,1,0.0001,0,0"),
            format!("STARLINK-31000,2024-100A,60000,U,{orbit},999,1,0.0001,0,0"),
        ]
        .join("\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sets.csv");
        std::fs::write(&path, text).unwrap();
        let found = of_elements(&[path]).unwrap();
        assert_eq!(found.into_iter().collect::<Vec<_>>(), [(NoradId(53_662), Generation::StarlinkV15)]);
    }
}
