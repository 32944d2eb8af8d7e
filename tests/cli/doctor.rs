//! `streakcast doctor`: setup check.

use crate::common::cli::{path, run};
use crate::common::elements::pair;
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

/// Element sets with ages of 0.5 to 40 days, one in the future, one duplicate and one invalid record.
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
        ("note", "1 duplicate record"),
        ("warning", "1 of 5 is older than 14 days"),
        ("warning", "1 of 5 has an epoch more than 1.5 days after 2026-08-14T12:00:00Z: up to 2026-08-22"),
    ] {
        assert!(all.iter().any(|one| one.0 == severity && one.2.contains(words)), "{words}: {all:?}");
    }
    assert_eq!(doctor(&[&words[..], &["--strict"]].concat()).0, 1);
}

#[test]
fn the_page_has_bars_and_remedies() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, cache) = (file(&folder), path(&folder, "cache"));
    let (code, page, _) = doctor(&["--elements", &elements, "--mpc", "X05", "--cache", &cache]);
    assert_eq!(code, 0);
    assert!(page.starts_with("Setup check for 2026-08-14T12:00:00Z\n"), "{page}");
    for expected in [
        "warning   elements: ",
        "          -> ",
        "Age of the element sets",
        "from 1.5 d ahead       1 ####",
        "Satellites by model",
    ] {
        assert!(page.contains(expected), "{expected}: {page}");
    }
    // The most severe finding comes first.
    let severities: Vec<&str> = page
        .lines()
        .skip(2)
        .take_while(|line| !line.is_empty())
        .filter(|line| !line.starts_with(' '))
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    let rank =
        |word: &str| ["error", "warning", "unchecked", "note", "fine"].iter().position(|one| *one == word).unwrap();
    assert!(severities.windows(2).all(|pair| rank(pair[0]) <= rank(pair[1])), "{severities:?}");
}

#[test]
fn unreadable_files_are_errors_and_the_other_findings_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let cache = path(&folder, "cache");
    let (code, all, _) = findings(&["--elements", "missing.tle", "--mpc", "ZZZ", "--cache", &cache]);
    assert_eq!(code, 2);
    for subject in ["elements", "site"] {
        assert!(all.iter().any(|one| one.0 == "error" && one.1 == subject), "{subject}: {all:?}");
    }
    assert!(all.iter().any(|one| one.1 == "leap seconds" && one.0 == "fine"));
    let (code, stdout, stderr) = doctor(&["--elements", "missing.tle", "--cache", &cache]);
    assert!(code == 2 && stdout.contains("error     elements: cannot read missing.tle"), "{stdout}");
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
}

#[test]
fn the_cache_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().display().to_string();
    let record = r#"{"source": "CelesTrak", "url": "u", "fetched_utc": "2026-08-01T00:00:00Z", "records": 7,
        "asked_utc": "2026-08-14T11:00:00Z", "answer": "403 Forbidden", "not_before_utc": "2026-08-14T13:00:00Z"}"#;
    std::fs::write(folder.path().join("celestrak-active.csv.fetch.json"), record).unwrap();
    let (_, all, _) = findings(&["--cache", &cache]);
    assert!(
        all.iter()
            .any(|one| one.0 == "warning"
                && one.2.contains("response of CelesTrak at 2026-08-14T11:00:00Z: 403 Forbidden")),
        "{all:?}"
    );
    assert!(
        all.iter().any(|one| one.0 == "warning" && one.2.contains("was fetched, but the file is missing")),
        "{all:?}"
    );
    std::fs::write(folder.path().join("celestrak-active.csv"), "x").unwrap();
    let (_, all, answer) = findings(&["--cache", &cache]);
    assert!(all.iter().any(|one| one.0 == "note" && one.2.contains("7 records, fetched 13.5 days ago")), "{all:?}");
    assert_eq!(answer["cache"][0]["not_before_utc"], "2026-08-14T13:00:00Z");
}

#[test]
fn unchecked_items_are_listed_and_fail_with_strict() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, cache) = (file(&folder), path(&folder, "none"));
    let (code, page, _) = doctor(&["--cache", &cache]);
    assert_eq!(code, 0, "{page}");
    for line in ["unchecked elements: not given", "unchecked site: not given"] {
        assert!(page.contains(line), "{line}: {page}");
    }
    assert_eq!(doctor(&["--cache", &cache, "--strict"]).0, 1);
    // No problem, but no site either.
    let synthetic = ["--shells", "oneweb", "--cache", &cache, "--strict"];
    assert_eq!(doctor(&synthetic).0, 1);
    assert_eq!(doctor(&[&synthetic[..], &["--mpc", "X05"]].concat()).0, 0);
    let (_, all, _) = findings(&["--elements", &elements, "--cache", &cache]);
    let unchecked: Vec<_> = all.iter().filter(|one| one.0 == "unchecked").map(|one| one.1.as_str()).collect();
    assert_eq!(unchecked, ["site"]);
    let (code, _, stderr) = run(&[&["doctor", "--now", "yesterday"]]);
    assert!(code == 2 && stderr.lines().count() == 1, "{stderr}");
}

#[test]
fn limits_can_be_flags_and_an_unreadable_policy_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let (policy, cache) = (path(&folder, "p.toml"), path(&folder, "none"));
    let about = |words: &[&str]| {
        let (code, all, _) = findings(&[words, &["--cache", &cache]].concat());
        let found: Vec<_> = all.into_iter().filter(|one| one.1 == "policy").map(|one| (one.0, one.2)).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        (code, found[0].0.clone(), found[0].1.clone())
    };
    assert!(about(&[]).2.starts_with("no magnitude limit is set"));
    assert_eq!(about(&["--limit-mag", "6.5"]), (0, "fine".into(), "blocking avoid, limit_mag 6.5".into()));
    std::fs::write(&policy, "limit_mag = 7\nmargin_s = 3\n").unwrap();
    let (code, severity, words) = about(&["--policy", &policy, "--max-delay", "2min"]);
    assert_eq!((code, severity.as_str()), (0, "fine"));
    for part in ["limit_mag 7", "margin_s 3", "max_delay_s 120"] {
        assert!(words.contains(part), "{words}");
    }
    std::fs::write(&policy, "margin_s = 5\n").unwrap();
    let (_, _, words) = about(&["--policy", &policy]);
    assert!(words.starts_with("no magnitude limit is set") && words.contains("margin_s 5"), "{words}");
    std::fs::write(&policy, "limit_magg = 7\n").unwrap();
    let (code, severity, words) = about(&["--policy", &policy]);
    assert!(code == 2 && severity == "error" && words.contains("limit_magg"), "{words}");
}

#[test]
fn visits_that_cannot_be_judged_are_a_finding() {
    let folder = tempfile::tempdir().unwrap();
    let (schedule, cache) = (path(&folder, "visits.csv"), path(&folder, "none"));
    let about = |rows: &str| {
        std::fs::write(&schedule, format!("exposure_id,start_utc,duration_s,ra_deg,dec_deg\n{rows}")).unwrap();
        let (code, found, _) = findings(
            &[
                &["--shells", "starlink-gen1", "--mpc", "X05", "--cache", &cache, "--fov", "3.5deg"][..],
                &["--schedule", &schedule],
            ]
            .concat(),
        );
        let (severity, _, words) = found.into_iter().find(|(_, subject, _)| subject == "schedule").unwrap();
        (code, severity, words)
    };
    let good = "1,2026-08-14T23:30:00Z,30,217.5,-30\n";
    let bad = "2,2026-08-14T23:31:00Z,-5,217.5,-30\n3,2026-08-14T23:32:00Z,30,217.5,85\n";
    let (code, severity, words) = about(bad);
    assert!(code == 2 && severity == "error" && words.starts_with("2 of 2 visits cannot be judged"), "{words}");
    let (_, severity, words) = about(&format!("{good}{bad}"));
    assert!(severity == "warning" && words.starts_with("2 of 3 visits cannot be judged; "), "{words}");
    let (_, severity, words) = about(good);
    assert!(severity == "fine" && words.starts_with("1 visit; "), "{words}");
}

/// Findings do not contradict each other: for a time other than the clock's no advice on the clock is given, old
/// elements are not called "newer" for an earlier time, and the numbers of models add up.
#[test]
fn no_finding_contradicts_another() {
    let folder = tempfile::tempdir().unwrap();
    let (elements, cache) = (path(&folder, "late.tle"), path(&folder, "none"));
    let late: String = (90_000..90_004).map(|id| pair(id, "240.00000000")).collect();
    std::fs::write(&elements, late).unwrap();
    let (code, page, _) = doctor(&["--elements", &elements, "--mpc", "X05", "--cache", &cache]);
    assert_eq!(code, 2, "{page}");
    assert!(
        page.contains("4 of 4 have epochs more than 1.5 days after")
            && page.contains("half of them more than 13.5 days in the future")
    );
    for wrong in ["correct the clock", "fetch newer", "median age -", "clock: "] {
        assert!(!page.contains(wrong), "{wrong}: {page}");
    }
    assert!(page.contains("time: 2026-08-14T12:00:00Z, as given") && page.contains("satchecker --epoch"), "{page}");
    assert_eq!(page.matches(" models: ").count(), 1, "{page}");
    // If models cannot be read, no finding states that every satellite has one.
    let config = path(&folder, "c.toml");
    std::fs::write(&config, "[models]\nfiles = ['no-such-model.json']\n").unwrap();
    let (code, page, _) = doctor(&["--elements", &elements, "--config", &config, "--cache", &cache]);
    assert!(code == 2 && page.contains("error     models: "), "{page}");
    assert_eq!(page.matches(" models: ").count(), 1, "{page}");
}

/// Growing constellations whose first period begins later are an error of all verbs.
#[test]
fn a_first_period_in_the_future_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let growth = path(&folder, "growth.toml");
    for (first, expected) in [("2026-08-13", false), ("2027-01-01", true)] {
        std::fs::write(&growth, format!("[[period]]\nfrom = {first}\nshells = {{ oneweb = 1 }}\n")).unwrap();
        let (_, findings, _) = findings(&["--shells", &growth, "--mpc", "X05"]);
        let is_error = |(severity, subject, finding): &(String, String, String)| {
            severity == "error" && subject == "elements" && finding.contains("begin with the night of 2027-01-01")
        };
        assert_eq!(findings.iter().any(is_error), expected, "{findings:?}");
    }
    let elements = file(&folder);
    // All other verbs that read the file of a later period would fail.
    std::fs::write(folder.path().join("wrong.tle"), "not an element set\n").unwrap();
    for (name, expected) in [("missing.tle", "missing.tle: No such file"), ("wrong.tle", "contains no element sets")] {
        let later = format!("[[period]]\nfrom = 2031-01-01\nelements = '{name}'\n");
        let text = format!("[[period]]\nfrom = 2026-08-13\nelements = '{elements}'\n{later}");
        std::fs::write(&growth, text).unwrap();
        let (code, findings, _) = findings(&["--shells", &growth, "--mpc", "X05"]);
        let errors: Vec<_> = findings.iter().filter(|(severity, ..)| severity == "error").collect();
        assert!(code == 2 && errors.len() == 1 && errors[0].2.contains(expected), "{findings:?}");
    }
    // The element sets of a period are those that are checked.
    for (name, expected) in [("missing.tle", "missing.tle: No such file"), (elements.as_str(), "median age")] {
        std::fs::write(&growth, format!("[[period]]\nfrom = 2026-08-13\nelements = '{name}'\n")).unwrap();
        let (_, findings, _) = findings(&["--shells", &growth, "--mpc", "X05"]);
        assert!(
            findings.iter().any(|(_, subject, text)| subject == "elements" && text.contains(expected)),
            "{findings:?}"
        );
    }
}
