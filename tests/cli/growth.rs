//! Constellations that grow: each night of a schedule has the satellites of its period.

use std::collections::BTreeMap;
use std::fs;

use crate::common::cli::{done, path, records, run};
use tempfile::TempDir;

const BEFORE: &str = "starlink-gen1";
const AFTER: &str = "starlink-gen1,oneweb";
const SKY: [&str; 5] = ["--mpc", "X05", "--fov", "3.5deg", "-q"];

/// Returns the rows of a CSV text by the names of its columns.
fn rows(text: &str) -> Vec<BTreeMap<String, String>> {
    let records = records(text);
    let row = |record: &csv::StringRecord| {
        records[0].iter().zip(record).map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
    };
    records[1..].iter().map(row).collect()
}

fn written(folder: &TempDir, name: &str, text: &str) -> String {
    fs::write(folder.path().join(name), text).unwrap();
    path(folder, name)
}

/// Returns a schedule of two nights at Cerro Pachon, with the rows of the second night first and an invalid row between.
/// UTC of both nights is partly of the same date.
fn schedule(nights: &[&str]) -> String {
    let mut text = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n".to_owned();
    for (number, dates) in nights.iter().enumerate() {
        for (index, (date, hour)) in dates.split(' ').flat_map(|date| [(date, 0), (date, 1), (date, 8)]).enumerate() {
            for minute in (0..60).step_by(4) {
                let (ra_deg, id) = (60 + 5 * minute + 10 * index, format!("{number}-{index}-{minute}"));
                text += &format!("{id},{date}T{hour:02}:{minute:02}:00Z,60,{},-40\n", ra_deg % 360);
            }
        }
        text += &format!("{number}-invalid,never,60,10,-40\n");
    }
    text
}

#[test]
fn each_night_has_the_satellites_of_its_period() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(
        &folder,
        "growth.toml",
        "[[period]]\nfrom = 2026-08-01\nshells = { starlink-gen1 = 1 }\n\
         [[period]]\nfrom = 2026-08-14\nshells = { starlink-gen1 = 1, oneweb = 1 }\n",
    );
    // The night of 13 August ends on 14 August.
    let both = written(&folder, "both.csv", &schedule(&["2026-08-15", "2026-08-14"]));
    let verdicts = |schedule: &str, shells: &str| {
        rows(&done(&[&["flag", "--shells", shells, "--schedule", schedule, "--format", "csv"], &SKY]))
    };
    let (of_both, all) = (verdicts(&both, &growth), verdicts(&both, AFTER));
    let expected = |night: &str, shells: &str| {
        let alone = written(&folder, "alone.csv", &schedule(&[night]));
        verdicts(&alone, shells)
    };
    let (last, first) = (expected("2026-08-15", AFTER), expected("2026-08-14", BEFORE));
    let of = |rows: &[BTreeMap<String, String>], column: &str| -> Vec<String> {
        rows.iter().map(|row| row[column].clone()).collect()
    };
    for column in ["verdict", "n_streaks", "norad_ids"] {
        let separate = [of(&last, column), of(&first, column)].concat();
        assert_eq!(of(&of_both, column), separate, "{column}");
        assert_ne!(of(&all, column), separate, "{column}: the periods make no difference");
    }
    let rows_without_time: Vec<_> = of_both
        .iter()
        .filter(|row| row["exposure_id"].ends_with("-invalid"))
        .map(|row| row["verdict"].as_str())
        .collect();
    assert_eq!(rows_without_time, ["invalid"; 2]);

    // The table of streaks has the satellites of both skies.
    let output = path(&folder, "annotated.csv");
    done(&[&["annotate", "--shells", &growth, "--schedule", &both, "-o", &output], &SKY]);
    let streaks = rows(&fs::read_to_string(folder.path().join("annotated.streaks.csv")).unwrap());
    let names = |night: &str, name: &str| {
        streaks.iter().filter(|row| row["exposure_id"].starts_with(night) && row["name"].starts_with(name)).count()
    };
    let counts = [names("0-", "ONEWEB"), names("0-", "STARLINK"), names("1-", "ONEWEB"), names("1-", "STARLINK")];
    assert!(counts[0] > 0 && counts[1] > 0 && counts[2] == 0 && counts[3] > 0, "{counts:?}");
}

/// Before the first satellites are in orbit, all exposures are clear.
#[test]
fn a_period_may_have_no_satellites() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(&folder, "growth.toml", "[[period]]\nfrom = 2026-08-01\nshells = {}\n");
    let night = written(&folder, "night.csv", &schedule(&["2026-08-14"]));
    let flags = rows(&done(&[&["flag", "--shells", &growth, "--schedule", &night, "--format", "csv"], &SKY]));
    let verdicts: Vec<&str> = flags.iter().map(|row| row["verdict"].as_str()).collect();
    assert!(verdicts.contains(&"clear") && !verdicts.contains(&"unknown") && !verdicts.contains(&"streaked"));
}

#[test]
fn nights_before_the_first_period_are_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(&folder, "growth.toml", "[[period]]\nfrom = 2026-08-14\nshells = { oneweb = 1 }\n");
    let early = written(&folder, "early.csv", &schedule(&["2026-08-14"]));
    let arguments = ["flag", "--shells", &growth, "--schedule", &early];
    let (code, _, error) = run(&[&arguments, &SKY]);
    assert!(
        code == 2
            && error.contains("growth.toml: the simulated constellations begin with the night of 2026-08-14")
            && error.contains("[[period]]"),
        "{error}"
    );
}
