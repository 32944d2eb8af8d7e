//! Constellations that grow: each night of a schedule has the satellites of its period.

use std::collections::BTreeMap;
use std::fs;

use crate::common::cli::{done, path, records, run};
use crate::common::server::Server;
use serde_json::Value;
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

/// Returns a schedule of two nights at Cerro Pachon, with the rows of the second night first and an invalid row
/// between. UTC of both nights is partly of the same date.
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

/// Rows of both periods in turn have the verdicts of sorted rows, in the order of the schedule.
#[test]
fn rows_in_any_order_have_the_satellites_of_their_period() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(
        &folder,
        "growth.toml",
        "[[period]]\nfrom = 2026-08-01\nshells = { starlink-gen1 = 1 }\n\
         [[period]]\nfrom = 2026-08-14\nshells = { starlink-gen1 = 1, oneweb = 1 }\n",
    );
    let nights = schedule(&["2026-08-14", "2026-08-15"]);
    let (header, rows_of_both) = nights.split_once('\n').unwrap();
    let lines: Vec<&str> = rows_of_both.lines().collect();
    let (first, second) = lines.split_at(lines.len() / 2);
    let mixed: String = first.iter().zip(second).map(|(one, other)| format!("{one}\n{other}\n")).collect();
    let sorted = written(&folder, "sorted.csv", &nights);
    let mixed = written(&folder, "mixed.csv", &format!("{header}\n{mixed}"));
    let of = |name: &str, schedule: &str| {
        let output = path(&folder, &format!("{name}.csv"));
        done(&[&["annotate", "--shells", &growth, "--schedule", schedule, "-o", &output], &SKY]);
        let read = |end: &str| rows(&fs::read_to_string(folder.path().join(format!("{name}{end}.csv"))).unwrap());
        [read(""), read(".streaks")]
    };
    let [sorted_rows, sorted_streaks] = of("a", &sorted);
    let [mixed_rows, mixed_streaks] = of("b", &mixed);
    let ids = |rows: &[BTreeMap<String, String>]| rows.iter().map(|row| row["exposure_id"].clone()).collect::<Vec<_>>();
    assert_ne!(ids(&sorted_rows), ids(&mixed_rows));
    assert!(ids(&mixed_rows)[..2] == ["0-0-0", "1-0-0"], "{:?}", ids(&mixed_rows));
    // Rows that are computed together may differ by 1e-7 deg.
    let by_id = |mut rows: Vec<BTreeMap<String, String>>| {
        for (_, cell) in rows.iter_mut().flatten().filter(|(name, _)| name.ends_with("_deg")) {
            *cell = cell.parse::<f64>().map_or_else(|_| cell.clone(), |number| format!("{number:.4}"));
        }
        rows.sort_by_key(|row| (row["exposure_id"].clone(), row.get("norad_id").cloned()));
        rows
    };
    let mixed_ids = ids(&mixed_rows);
    assert_eq!(by_id(mixed_rows), by_id(sorted_rows));
    let order: Vec<usize> = ids(&mixed_streaks)
        .iter()
        .map(|id| mixed_ids.iter().position(|other| other == id).expect("a row of the schedule"))
        .collect();
    assert!(order.is_sorted() && order.len() > 10, "{order:?}");
    assert_eq!(by_id(mixed_streaks), by_id(sorted_streaks));
    let flags = done(&[&["flag", "--shells", &growth, "--schedule", &mixed, "--format", "json"], &SKY]);
    let answer: serde_json::Value = serde_json::from_str(&flags).unwrap();
    let satellites: Vec<_> =
        answer["provenance"]["periods"].as_array().unwrap().iter().map(|one| &one["satellites"]).collect();
    assert_eq!(satellites, [4408, 4408 + 6372].map(serde_json::Value::from).iter().collect::<Vec<_>>());
}

/// Requests that are computed with one period state it if another one begins in them; `statistics` has that of each
/// night.
#[test]
fn verbs_with_one_sky_warn_of_another_period() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(
        &folder,
        "growth.toml",
        "[[period]]\nfrom = 2026-08-01\nshells = { starlink-gen1 = 1 }\n\
         [[period]]\nfrom = 2026-08-14\nshells = { starlink-gen1 = 0.5, own = 1 }\n\
         [[constellation]]\nname = 'own'\nshell = [\
         { altitude_km = 600, inclination_deg = 53, planes = 4, satellites_per_plane = 5, planes_assumed = true }]\n\
         [[constellation]]\nname = 'typo'\nshell = [\
         { altitude_km = 600, inclination_deg = 53, planes = 4, satellites_per_plane = 5 }]\n",
    );
    let shared = ["--shells", &growth, "--mpc", "X05", "--max-mag=-9"];
    let warning = "those of the night of 2026-08-13 for the whole request, although another period of the file begins on 2026-08-14";
    for (end, expected) in [("2026-08-15T04:00:00Z", true), ("2026-08-14T16:00:00Z", false)] {
        let (_, _, stderr) = run(&[&["forecast", "--start", "2026-08-14T02:00:00Z", "--end", end], &shared]);
        assert_eq!(stderr.contains(warning), expected, "{end}: {stderr}");
    }
    let nights = ["statistics", "--night", "2026-08-13", "2026-08-14", "--format", "json", "--moments", "1"];
    let (code, stdout, stderr) = run(&[&nights, &shared[..4]]);
    assert!(code == 0 && stderr.contains("own") && !stderr.contains("whole request"), "{stderr}");
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    let periods = answer["provenance"]["periods"].as_array().unwrap();
    let satellites: Vec<_> = periods.iter().map(|one| one["satellites"].as_u64().unwrap()).collect();
    assert!(
        satellites.len() == 2 && satellites[0] == 4408 && satellites[1] > 2200 && satellites[1] < 2300,
        "{periods:?}"
    );

    // The list has the own constellations, and names those that are never in orbit.
    let (code, stdout, stderr) = run(&[&["shells", &growth, "--format", "csv"]]);
    assert!(code == 0 && stderr.contains("constellation typo is in no period: it is never in orbit"), "{stderr}");
    let names: Vec<_> =
        rows(&stdout).iter().map(|row| (row["name"].clone(), row["with_assumed_planes"].clone())).collect();
    let expected = [("own", "20"), ("typo", "0"), ("from 2026-08-01", "0"), ("from 2026-08-14", "20")];
    assert_eq!(names, expected.map(|(name, count)| (name.to_owned(), count.to_owned())));
}

/// The server has the satellites of the night of each request, in the schedule and outside of it.
#[test]
fn the_server_has_the_satellites_of_each_night() {
    let folder = tempfile::tempdir().unwrap();
    let growth = written(
        &folder,
        "growth.toml",
        "[[period]]\nfrom = 2026-08-01\nshells = { starlink-gen1 = 1 }\n\
         [[period]]\nfrom = 2026-08-14\nshells = { starlink-gen1 = 1, oneweb = 1 }\n\
         [[period]]\nfrom = 2026-09-10\nshells = { oneweb = 1 }\n",
    );
    let both = written(&folder, "both.csv", &schedule(&["2026-08-15", "2026-08-14"]));
    let flags = rows(&done(&[&["flag", "--shells", &growth, "--schedule", &both, "--format", "csv"], &SKY]));
    let sky = ["--shells", &growth, "--mpc", "X05", "--fov", "3.5deg", "--rate", "100000"];
    let server = Server::start(&[&sky[..], &["--schedule", &both, "-q"]].concat());
    let satellites = |answer: &Value| answer["provenance"]["satellites"].as_u64().unwrap();

    let nights = ["2026-08-14", "2026-08-13"].map(|night| server.json(&format!("/api/v1/night?night={night}")));
    assert_eq!(nights.each_ref().map(satellites), [4408 + 6372, 4408]);
    let expected: BTreeMap<&str, _> = flags.iter().map(|flag| (flag["exposure_id"].as_str(), flag)).collect();
    let mut list = Vec::new();
    for flag in nights.iter().flat_map(|night| night["flags"].as_array().unwrap()) {
        let row = expected[flag["exposure_id"].as_str().unwrap()];
        assert_eq!(flag["verdict"], row["verdict"].as_str(), "{flag}");
        if flag["verdict"] != "invalid" {
            let [start, ra, dec] = ["start_utc", "ra_deg", "dec_deg"].map(|name| row[name].clone());
            list.push((format!("{start},60,{ra},{dec}"), flag["verdict"].clone()));
        }
    }
    assert!(nights.iter().all(|night| night["flags"].as_array().unwrap().len() >= 45) && list.len() >= 40);
    // Rows of both nights in turn, in one request and one by one.
    let half = list.len() / 2;
    let mixed: Vec<_> = (0..half).flat_map(|row| [&list[row], &list[half + row]]).collect();
    let request: Vec<&str> = mixed.iter().map(|(text, _)| text.as_str()).collect();
    let answer = server.json(&format!("/api/v1/exposures?exposures={}", request.join(";")));
    let verdicts: Vec<&Value> = answer["flags"].as_array().unwrap().iter().map(|flag| &flag["verdict"]).collect();
    assert_eq!(verdicts, mixed.iter().map(|(_, verdict)| verdict).collect::<Vec<_>>());
    assert!(verdicts.contains(&&Value::from("streaked")) && verdicts.contains(&&Value::from("clear")));
    for (text, verdict) in mixed.into_iter().step_by(20) {
        let cells: Vec<&str> = text.split(',').collect();
        let [start, ra, dec] = [cells[0], cells[2], cells[3]];
        let one = server.json(&format!("/api/v1/exposure?start_utc={start}&duration_s=60&ra_deg={ra}&dec_deg={dec}"));
        assert_eq!(&one["flags"][0]["verdict"], verdict, "{text}");
    }

    // Nights of a third period, and before the first one.
    let later = "start_utc=2026-09-12T02:00:00Z&duration_s=60&ra_deg=10&dec_deg=-40";
    let first = server.json(&format!("/api/v1/exposure?{later}"));
    server.json("/api/v1/dome?start_utc=2026-09-15T02:00:00Z&duration_s=30");
    assert_eq!((satellites(&first), server.json(&format!("/api/v1/exposure?{later}"))), (6372, first.clone()));
    let problem = server.get("/api/v1/exposure?start_utc=2026-07-30T02:00:00Z&duration_s=60&ra_deg=10&dec_deg=-40");
    let detail = problem.json()["detail"].as_str().unwrap().to_owned();
    assert!(problem.status == 400 && detail.contains("begin with the night of 2026-08-01"), "{detail}");
}

/// A period with files of element sets uses these instead of those of the request, the others those of the request.
#[test]
fn periods_have_element_sets_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sets")).unwrap();
    let tle = |name: &str, number: u32, mean_anomaly: &str| {
        let lines = [
            format!("1 {number}U 98067A   26226.50000000  .00000000  00000+0  00000-0 0  999"),
            format!("2 {number}  51.6304 193.4497 0006669 272.1743 {mean_anomaly} 15.4894766457509"),
        ];
        let sum =
            |line: &str| line.chars().map(|c| if c == '-' { 1 } else { c.to_digit(10).unwrap_or(0) }).sum::<u32>() % 10;
        written(&folder, name, &lines.map(|line| format!("{line}{}\n", sum(&line))).concat())
    };
    let request = tle("request.tle", 10_001, " 87.8481");
    tle("sets/first.tle", 20_001, " 87.8481");
    let other = tle("other.tle", 20_002, "187.8481");
    let growth = |first: &str| {
        let text = format!(
            "[[period]]\nfrom = 2026-08-01\n{first}\n[[period]]\nfrom = 2026-08-14\nshells = {{ oneweb = 1 }}\n"
        );
        written(&folder, "growth.toml", &text)
    };
    let file = growth("elements = ['sets/first.tle', 'other.tle']");
    let both = written(&folder, "both.csv", &schedule(&["2026-08-14", "2026-08-15"]));
    let base = ["--shells", &file, "--elements", &request];
    let flags = done(&[&["flag", "--schedule", &both, "--format", "json"], &base, &SKY]);
    let answer: Value = serde_json::from_str(&flags).unwrap();
    let periods = answer["provenance"]["periods"].as_array().unwrap();
    let satellites: Vec<_> = periods.iter().map(|period| period["satellites"].as_u64().unwrap()).collect();
    assert_eq!(satellites, [2, 1 + 6372]);
    let files = |period: &Value| -> Vec<String> {
        period["elements"].as_array().unwrap().iter().map(|one| one["file"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(files(&periods[0]), [path(&folder, "sets/first.tle"), other.clone()]);
    assert_eq!(files(&periods[1]), std::slice::from_ref(&request));
    // Verdicts of the first night are those of its files alone.
    let first = written(&folder, "first.csv", &schedule(&["2026-08-14"]));
    let alone = ["--elements", &path(&folder, "sets/first.tle"), "--elements", &other];
    let alone = rows(&done(&[&["flag", "--schedule", &first, "--format", "csv"], &alone, &SKY]));
    let of_both = rows(&done(&[&["flag", "--schedule", &both, "--format", "csv"], &base, &SKY]));
    assert_eq!(alone, of_both[..alone.len()]);
    // A request of one night, and a server.
    let passes = ["ephemeris", "--times", "2026-08-14T00:00:00Z", "--mpc", "X05"];
    let code = |satellite: &str| run(&[&passes, &base, &["--norad", satellite]]).0;
    assert_eq!(["20001", "20002", "10001"].map(code), [0, 0, 2]);
    let server = Server::start(&[&["--schedule", &both], &base[..], &SKY].concat());
    let sources = |start: &str| {
        let request = format!("/api/v1/exposure?start_utc={start}&duration_s=30&ra_deg=60&dec_deg=-40");
        files(&server.json(&request)["provenance"])
    };
    assert_eq!(sources("2026-08-14T01:00:00Z"), [path(&folder, "sets/first.tle"), other]);
    assert_eq!(sources("2026-08-15T01:00:00Z"), [request]);
    let (code, stdout, _) = run(&[&["shells", &file]]);
    assert!(code == 0 && stdout.contains("element sets of") && stdout.contains("first.tle"), "{stdout}");

    // Periods that differ in their files only are stated too.
    let text = ["2026-08-01\nelements = 'sets/first.tle'", "2026-08-14\nelements = ['other.tle', 'sets/first.tle']"];
    let files_only = written(&folder, "files.toml", &text.map(|text| format!("[[period]]\nfrom = {text}\n")).concat());
    let nights = ["statistics", "--night", "2026-08-13", "2026-08-14", "--format", "json", "--moments", "1", "-q"];
    let answer: Value = serde_json::from_str(&done(&[&nights, &["--shells", &files_only, "--mpc", "X05"]])).unwrap();
    let stated = answer["provenance"]["periods"].as_array().unwrap().iter();
    let stated: Vec<_> = stated.map(|period| (period["satellites"].as_u64().unwrap(), files(period).len())).collect();
    assert_eq!(stated, [(1, 1), (2, 2)]);

    written(&folder, "empty.tle", "");
    written(&folder, "wrong.tle", "not an element set\n");
    for (first, expected) in [
        ("elements = 'missing.tle'", "missing.tle: No such file or directory"),
        ("elements = 'empty.tle'", "empty.tle is empty"),
        ("elements = 'wrong.tle'", "wrong.tle contains no element sets"),
        ("elements = 3", "growth.toml: constellation file: period from 2026-08-01: elements is 3; allowed: the path"),
        ("", "growth.toml: constellation file: period from 2026-08-01: it has neither shells nor elements"),
    ] {
        let file = growth(first);
        let (code, _, stderr) = run(&[&["flag", "--schedule", &both, "--shells", &file], &SKY]);
        assert!(code == 2 && stderr.contains(expected), "{first}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
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
            && error
                .contains("growth.toml: the periods begin with the night of 2026-08-14, after the night of 2026-08-13")
            && error.contains("[[period]]"),
        "{error}"
    );
}
