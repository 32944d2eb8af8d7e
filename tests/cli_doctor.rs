//! `streakcast doctor`: what would be wrong, told before the night.
#![cfg(feature = "cli")]

mod common;

use common::cli::{path, run};
use common::elements::pair;
use serde_json::Value;

fn doctor(words: &[&str]) -> (i32, String, String) {
    run(&[&["doctor", "--now", "2026-08-14T12:00:00Z"], words])
}

fn findings(words: &[&str]) -> (i32, Vec<(String, String, String)>, Value) {
    let (code, stdout, stderr) = doctor(&[words, &["--format", "json"]].concat());
    let answer: Value = serde_json::from_str(&stdout).unwrap_or_else(|_| panic!("{stderr}"));
    let text = |one: &Value, key: &str| one[key].as_str().unwrap_or_default().to_owned();
    let all = answer["findings"].as_array().unwrap();
    let all = all.iter().map(|one| (text(one, "severity"), text(one, "subject"), text(one, "finding"))).collect();
    (code, all, answer)
}

/// Element sets of ages 0.5 to 40 days, one of the future, one there twice, one with a broken record.
fn file(folder: &tempfile::TempDir) -> String {
    let days = ["226.00000000", "225.00000000", "216.00000000", "186.00000000", "234.00000000"];
    let mut text: String = days.iter().zip(90_000..).map(|(day, id)| pair(id, day)).collect();
    text += &pair(90_000, "226.00000000");
    text += &pair(90_009, "226.00000000").replace("1 90009", "1 90008");
    let path = path(folder, "a.tle");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn ages_repetitions_and_rejections_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, cache) = (file(&folder), path(&folder, "cache"));
    let words = ["--elements", &elements, "--mpc", "X05", "--cache", &cache];
    let (code, all, answer) = findings(&words);
    assert_eq!(code, 0, "warnings are no failure unless --strict: {all:?}");
    let ages = answer["element_ages"].as_array().unwrap();
    assert_eq!(ages.iter().map(|bin| bin["count"].as_u64().unwrap()).sum::<u64>(), 5);
    assert_eq!((&ages[0]["from_days"], &ages[0]["count"]), (&Value::Null, &1.into()));
    for (severity, words) in [
        ("warning", "1 of 7 records rejected"),
        ("note", "1 records are there twice"),
        ("warning", "1 of 5 are older than 14 days"),
        ("warning", "1 of 5 are from the future"),
    ] {
        assert!(all.iter().any(|one| one.0 == severity && one.2.contains(words)), "{words}: {all:?}");
    }
    assert_eq!(doctor(&[&words[..], &["--strict"]].concat()).0, 1);
}

#[test]
fn the_page_has_bars_and_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, cache) = (file(&folder), path(&folder, "cache"));
    let (code, page, _) = doctor(&["--elements", &elements, "--mpc", "X05", "--cache", &cache]);
    assert_eq!(code, 0);
    assert!(page.starts_with("What would be wrong at 2026-08-14T12:00:00Z\n"), "{page}");
    for expected in
        ["warning  elements: ", "         -> ", "Age of the element sets", "future       1 ####", "Satellites by model"]
    {
        assert!(page.contains(expected), "{expected}: {page}");
    }
    // The worst first.
    let severities: Vec<&str> = page
        .lines()
        .skip(2)
        .take_while(|line| !line.is_empty())
        .filter(|line| !line.starts_with(' '))
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    let rank = |word: &str| ["error", "warning", "note", "fine"].iter().position(|one| *one == word).unwrap();
    assert!(severities.windows(2).all(|pair| rank(pair[0]) <= rank(pair[1])), "{severities:?}");
}

#[test]
fn what_cannot_be_read_is_an_error_and_the_rest_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let cache = path(&folder, "cache");
    let (code, all, _) = findings(&["--elements", "missing.tle", "--mpc", "ZZZ", "--cache", &cache]);
    assert_eq!(code, 2);
    for subject in ["elements", "site"] {
        assert!(all.iter().any(|one| one.0 == "error" && one.1 == subject), "{subject}: {all:?}");
    }
    assert!(all.iter().any(|one| one.1 == "leap seconds" && one.0 == "fine"));
    let (code, stdout, stderr) = doctor(&["--elements", "missing.tle", "--cache", &cache]);
    assert!(code == 2 && stdout.contains("error    elements: cannot read missing.tle"), "{stdout}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

#[test]
fn the_cache_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().display().to_string();
    let record = r#"{"source": "CelesTrak", "url": "u", "fetched_utc": "2026-08-01T00:00:00Z", "records": 7,
        "asked_utc": "2026-08-14T11:00:00Z", "answer": "403 Forbidden", "not_before_utc": "2026-08-14T13:00:00Z"}"#;
    std::fs::write(folder.path().join("celestrak-active.csv.fetch.json"), record).unwrap();
    let (_, all, _) = findings(&["--cache", &cache]);
    assert!(
        all.iter().any(|one| one.0 == "warning" && one.2.contains("answered at 2026-08-14T11:00:00Z: 403 Forbidden")),
        "{all:?}"
    );
    assert!(all.iter().any(|one| one.0 == "warning" && one.2.contains("fetched and is gone")), "{all:?}");
    std::fs::write(folder.path().join("celestrak-active.csv"), "x").unwrap();
    let (_, all, answer) = findings(&["--cache", &cache]);
    assert!(all.iter().any(|one| one.0 == "note" && one.2.contains("7 records, fetched 13.5 days ago")), "{all:?}");
    assert_eq!(answer["cache"][0]["not_before_utc"], "2026-08-14T13:00:00Z");
}

#[test]
fn nothing_said_is_nothing_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let (code, page, _) = doctor(&["--cache", &path(&folder, "none"), "--strict"]);
    assert_eq!(code, 0, "{page}");
    let (code, _, stderr) = run(&[&["doctor", "--now", "yesterday"]]);
    assert!(code == 2 && stderr.lines().count() == 1, "{stderr}");
}
