//! Annotated schedules in the formats of common tools (samples from tests/reference/make_schedule_samples.py): the
//! original text is contained unchanged, verdicts agree between formats, streaks are written to a second file, and the
//! shards of a batch together equal the whole.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::cli::{FLAG, SKY, done, path, records, run};
use serde_json::Value;
use tempfile::TempDir;

fn sample(name: &str) -> String {
    crate::common::golden_dir().join("schedules").join(name).display().to_string()
}

fn annotated(folder: &TempDir, name: &str, more: &[&str]) -> PathBuf {
    let output = path(folder, name);
    done(&[&["annotate", "--schedule", &sample(name), "-o", &output], FLAG, SKY, more]);
    PathBuf::from(output)
}

/// Returns true if each line of a text (and each object of one-line JSON) occurs unchanged and in order in another
/// text.
fn is_contained(original: &str, text: &str) -> bool {
    let mut rest = text;
    let mut pieces = original
        .split(['\n', '}'])
        .map(|piece| piece.trim_end_matches([',', '\r']))
        .filter(|piece| !piece.trim().is_empty());
    pieces.all(|piece| match rest.find(piece) {
        Some(at) => {
            rest = &rest[at + piece.len()..];
            true
        }
        None => false,
    })
}

/// Returns the verdicts of `flag`, one per row.
fn verdicts(name: &str, more: &[&str]) -> Vec<String> {
    let answer = crate::common::cli::json(&[&["flag", "--schedule", &sample(name)], FLAG, SKY, more]);
    answer["flags"].as_array().unwrap().iter().map(|flag| flag["verdict"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn consdb_exports_are_tai_and_the_same_in_every_format() {
    let expected = verdicts("consdb.csv", &[]);
    assert_eq!(expected.len(), 12);
    assert!(
        expected.iter().any(|verdict| verdict == "clear") && expected.iter().any(|verdict| verdict != "clear"),
        "{expected:?}"
    );
    for name in ["consdb.ecsv", "consdb_comma.ecsv", "consdb.vot"] {
        assert_eq!(verdicts(name, &[]), expected, "{name}");
    }
    // The start times of the sample (23:05:37 and later) are TAI, 37 s ahead of UTC.
    let answer = crate::common::cli::json(&[&["flag", "--schedule", &sample("consdb.csv")], FLAG, SKY]);
    assert_eq!(answer["provenance"]["time_scale"], "tai");
    assert_eq!(answer["provenance"]["schedule"]["first_start_utc"], "2024-08-14T23:05:00.000Z");
    assert_eq!(answer["flags"][0]["exposure_id"], "2024081400000");
    let (code, _, stderr) = run(&[&["flag", "--schedule", &sample("consdb.csv"), "--time-scale", "utc"], FLAG, SKY]);
    assert_eq!(code, 2);
    assert!(stderr.contains("column obs_start_mjd is in TAI, but --time-scale is UTC"), "{stderr}");
}

#[test]
fn obsplan_feeds_need_a_time_scale_and_number_their_rows() {
    let (code, _, stderr) = run(&[&["flag", "--schedule", &sample("obsplan.json")], FLAG, SKY]);
    assert_eq!(code, 2);
    assert!(stderr.contains("the time scale of column t_planning is missing") && stderr.contains("37 s"), "{stderr}");
    let scale = &["--time-scale", "utc"];
    // The same exposures as in the other samples, without rotation, which has no effect for a circular field.
    assert_eq!(verdicts("obsplan.json", scale), verdicts("consdb.csv", &[]));
    let folder = tempfile::tempdir().unwrap();
    let output = annotated(&folder, "obsplan.json", scale);
    let rows: Vec<Value> = serde_json::from_str(&fs::read_to_string(&output).unwrap()).unwrap();
    assert_eq!((rows[0]["exposure_id"].as_str(), rows[11]["exposure_id"].as_str()), (Some("1"), Some("12")));
    let streaks: Value =
        serde_json::from_str(&fs::read_to_string(path(&folder, "obsplan.streaks.json")).unwrap()).unwrap();
    assert!(!streaks["streaks"].as_array().unwrap().is_empty());
    assert_eq!(streaks["provenance"]["time_scale"], "utc");
}

#[test]
fn original_bytes_are_kept_and_a_second_annotation_replaces_the_first() {
    for (name, scale) in [
        ("consdb.csv", &[][..]),
        ("consdb.ecsv", &[]),
        ("consdb_comma.ecsv", &[]),
        ("consdb.vot", &[]),
        ("obsplan.json", &["--time-scale", "utc"]),
        ("obsplan_object.json", &["--time-scale", "utc"]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = annotated(&folder, name, scale);
        let (original, text) = (fs::read_to_string(sample(name)).unwrap(), fs::read_to_string(&output).unwrap());
        assert!(is_contained(&original, &text), "{name}");
        assert!(text.contains("next_clear_start_utc"), "{name}");
        let verdict_count = |text: &str| {
            text.matches("clear").count() + text.matches("streaked").count() + text.matches("avoid").count()
        };
        assert!(verdict_count(&text) >= 12, "{name}");
        // An annotated file can be read like the original, and annotated again only with `--replace`.
        let output = output.display().to_string();
        let again = |more: &[&str]| {
            run(&[&["annotate", "--schedule", &output, "-o", &path(&folder, "second")], FLAG, SKY, scale, more])
        };
        let (code, _, stderr) = again(&[]);
        assert_eq!(code, 2, "{name}: {stderr}");
        assert!(stderr.contains("already has") && stderr.contains("--replace"), "{name}: {stderr}");
        // Except in JSON, this is found before the exposures are judged.
        let loud = ["annotate", "--schedule", &output, "-o", &output, "--shells", "starlink-gen1", "--mpc", "X05"];
        let (_, _, stderr) = run(&[&loud, FLAG, scale]);
        assert_eq!(stderr.contains("exposures: "), name.ends_with(".json"), "{name}: {stderr}");
        let (code, _, stderr) = again(&["--replace"]);
        assert_eq!(code, 0, "{name}: {stderr}");
        let strip = |text: &str| text.replace(&output, "").replace(&sample(name), "");
        assert_eq!(strip(&fs::read_to_string(path(&folder, "second")).unwrap()), strip(&text), "{name}");
        // An annotation of the file itself is also written atomically, and no temporary file remains.
        let (code, ..) = run(&[&["annotate", "--schedule", &output, "-o", &output, "--replace"], FLAG, SKY, scale]);
        assert_eq!(code, 0, "{name}");
        let stray = fs::read_dir(folder.path())
            .unwrap()
            .flatten()
            .filter(|one| one.file_name().to_string_lossy().contains(".part"))
            .count();
        assert_eq!(stray, 0);
    }
}

#[test]
fn streaks_are_written_where_the_format_allows() {
    let folder = tempfile::tempdir().unwrap();
    annotated(&folder, "consdb.csv", &[]);
    let rows = records(&fs::read_to_string(path(&folder, "consdb.streaks.csv")).unwrap());
    annotated(&folder, "consdb.ecsv", &[]);
    // Truth values are True and False in ECSV.
    let ecsv = fs::read_to_string(path(&folder, "consdb.streaks.ecsv")).unwrap();
    assert_eq!(records(&ecsv.replace(",True", ",true").replace(",False", ",false")), rows);
    let votable = fs::read_to_string(annotated(&folder, "consdb.vot", &[])).unwrap();
    let table = &votable[votable.find("<TABLE name=\"streaks\">").unwrap()..];
    assert_eq!(table.matches("<TR>").count(), rows.len() - 1);
    assert!(table.contains("<INFO name=\"version\""));
    let scale = &["--time-scale", "utc"];
    let object = fs::read_to_string(annotated(&folder, "obsplan_object.json", scale)).unwrap();
    let object: Value = serde_json::from_str(&object).unwrap();
    assert_eq!(object["streaks"].as_array().unwrap().len(), rows.len() - 1);
    assert_eq!(object["streak_provenance"]["software"], "streakcast");
    assert_eq!(object["note"]["b"][1], 2);
    assert!(!Path::new(&path(&folder, "obsplan_object.streaks.json")).exists());
}

/// The extension of the output must not be that of another format, but that of the schedule is always allowed.
#[test]
fn extensions_of_the_output_are_checked() {
    let folder = TempDir::new().unwrap();
    let output = path(&folder, "out.json");
    let (code, _, stderr) = run(&[&["annotate", "--schedule", &sample("consdb.csv"), "-o", &output], FLAG, &SKY[..4]]);
    assert_eq!(code, 2);
    assert!(stderr.contains("has the extension of another format; allowed: .csv, .tsv, because"), "{stderr}");
    // The name is checked before the computation, which prints warnings and a summary.
    assert_eq!(stderr.lines().count(), 1, "{stderr}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    let ecsv = path(&folder, "ecsv.csv");
    fs::copy(sample("consdb.ecsv"), &ecsv).unwrap();
    done(&[&["annotate", "--schedule", &ecsv, "-o", &path(&folder, "out.csv")], FLAG, SKY]);
}

#[test]
fn unwritable_formats_are_rejected_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: &str, part: &str| {
        let input = path(&folder, name);
        fs::write(&input, text).unwrap();
        let (code, _, stderr) = run(&[&["annotate", "--schedule", &input, "-o", &path(&folder, "out")], FLAG, SKY]);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(part), "'{part}' is not in: {stderr}");
        assert!(!Path::new(&path(&folder, "out")).exists());
    };
    let votable = fs::read_to_string(sample("consdb.vot")).unwrap();
    refused("b.vot", &votable.replace("TABLEDATA", "BINARY2"), "another serialization than TABLEDATA");
    refused("s.vot", &votable.replacen("<TD>r</TD>", "", 1), "row 1 has 10 cells but the header has 11");
    refused("x.vot", &votable[..votable.len() / 2], "x.vot");
    let ecsv = fs::read_to_string(sample("consdb.ecsv")).unwrap();
    refused(
        "q.ecsv",
        &ecsv.replacen("\"fbs, \"\"main\"\"\"", "\"fbs,\nmain\"", 1),
        "a quoted cell continues on the next line",
    );
}

/// Wide field, so that most rows have streaks.
const WIDE: &[&str] = &["--fov", "12deg", "--limit-mag", "6.5"];

/// Returns a schedule with the same exposures on three nights.
fn three_nights() -> String {
    let mut text = "exposure_id,start_utc,duration_s,ra_deg,dec_deg\n".to_owned();
    for night in 0..3 {
        for number in 0..8 {
            let (ra, dec) = (200.0 + 1.5 * f64::from(number), -40.0 + f64::from(number));
            text +=
                &format!("n{night}v{number},2024-08-{:02}T23:{:02}:30.000Z,30,{ra},{dec}\n", 14 + night, 5 + number);
        }
    }
    text + "broken,2024-08-14T23:59:00Z,x,1,2\n"
}

#[test]
fn shards_of_a_batch_add_up_to_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let schedule = path(&folder, "nights.csv");
    fs::write(&schedule, three_nights()).unwrap();
    let flags = |more: &[&str]| {
        let text = done(&[&["flag", "--schedule", &schedule, "--format", "csv"], WIDE, SKY, more]);
        records(&text)[1..].iter().map(|row| (row[0].to_owned(), row.clone())).collect::<BTreeMap<_, _>>()
    };
    let whole = flags(&[]);
    assert_eq!(whole.len(), 25);
    for count in [1, 2, 3, 5] {
        let mut together = BTreeMap::new();
        for index in 1..=count {
            let share = flags(&["--shard", &format!("{index}/{count}")]);
            for (id, row) in share {
                assert!(together.insert(id, row).is_none(), "a row in two shares of {count}");
            }
        }
        assert_eq!(together, whole, "{count} shares");
    }
    let annotated = |name: &str, schedule: &str, more: &[&str]| {
        let output = path(&folder, name);
        done(&[&["annotate", "--schedule", schedule, "-o", &output], WIDE, SKY, more]);
        let streaks = output.replace(".csv", ".streaks.csv");
        (
            records(&fs::read_to_string(output).unwrap())[1..].to_vec(),
            records(&fs::read_to_string(streaks).unwrap())[1..].to_vec(),
        )
    };
    let (mut rows, mut streaks) = annotated("whole.csv", &schedule, &[]);
    let shares: Vec<_> = (1..=2)
        .map(|index| annotated(&format!("s{index}.csv"), &schedule, &["--shard", &format!("{index}/2")]))
        .collect();
    let mut all_rows: Vec<_> = shares.iter().flat_map(|(rows, _)| rows.clone()).collect();
    let mut all_streaks: Vec<_> = shares.iter().flat_map(|(_, streaks)| streaks.clone()).collect();
    for list in [&mut rows, &mut all_rows, &mut streaks, &mut all_streaks] {
        list.sort_by_key(|row| row.iter().map(str::to_owned).collect::<Vec<_>>());
    }
    assert_eq!(all_rows, rows);
    assert_eq!(all_streaks, streaks);
    assert!(!streaks.is_empty());

    // In the other formats a shard is a complete file. These schedules have one night: one shard contains it, and the
    // other has no rows.
    for (name, scale) in [
        ("consdb.ecsv", &[][..]),
        ("consdb.vot", &[]),
        ("obsplan.json", &["--time-scale", "utc"]),
        ("obsplan_object.json", &["--time-scale", "utc"]),
    ] {
        let share = |index: &str| {
            let output = path(&folder, &format!("{index}-{name}"));
            done(&[
                &["annotate", "--schedule", &sample(name), "-o", &output, "--shard", &format!("{index}/2")],
                FLAG,
                SKY,
                scale,
            ]);
            fs::read_to_string(output).unwrap()
        };
        assert!(is_contained(&fs::read_to_string(sample(name)).unwrap(), &share("1")), "{name}");
        let empty = share("2");
        assert!(!empty.contains("20240814000") && !empty.contains("lowdust"), "{name}: {empty}");
        if name.ends_with(".json") {
            let document: Value = serde_json::from_str(&empty).unwrap();
            assert!(document.as_array().or_else(|| document["exposures"].as_array()).unwrap().is_empty());
        }
    }
    let (code, _, stderr) = run(&[&["flag", "--schedule", &schedule, "--shard", "4/3"], WIDE, SKY]);
    assert_eq!(code, 2);
    assert!(stderr.contains("invalid shard '4/3'; allowed: I/N"), "{stderr}");
}
