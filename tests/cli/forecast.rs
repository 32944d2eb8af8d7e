//! `forecast`: columns and formats, filters, empty nights, and errors.

use std::fs;

use crate::common::cli::{SKY, done, json, path, published_constellation, records, run};
use serde_json::Value;

const HEADER: &str = "norad_id,name,rise_utc,culmination_utc,set_utc,rise_azimuth_deg,max_altitude_deg,set_azimuth_deg,shadow_entry_utc,shadow_exit_utc,peak_utc,peak_magnitude,peak_magnitude_sigma,peak_altitude_deg,peak_azimuth_deg,range_km,mag_source,element_age_days,position_source,along_track_sigma_s,in_fitted_range";
const NIGHT: &[&str] = &["forecast", "--night", "2024-08-14"];
/// Twenty planes of a constellation, which have visible passes in the evening and in the morning.
const PLANES: &[&str] = &["--name", "S1 P2", "S1 P6"];

/// Tolerance of probabilities, which have four decimals.
const P_DECIMALS: f64 = 5e-5;
/// Tolerance of peak magnitudes, which have three decimals.
const MAGNITUDE_DECIMALS: f64 = 5e-4;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn verif_columns_rows_and_json_agree() {
    let text = done(&[NIGHT, SKY, PLANES, &["--format", "csv"]]);
    assert!(text.starts_with("# "), "provenance first");
    let rows = records(&text);
    assert_eq!(rows[0].iter().collect::<Vec<_>>().join(","), HEADER);
    assert!(rows.len() > 30, "{} rows", rows.len());
    let answer = json(&[NIGHT, SKY, PLANES]);
    let passes = answer["passes"].as_array().unwrap();
    assert_eq!(passes.len(), rows.len() - 1);
    for (row, pass) in rows[1..].iter().zip(passes) {
        for (name, cell) in rows[0].iter().zip(row) {
            let value = &pass[name];
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            assert!(
                cell == text || cell.is_empty() && value.is_null() || cell.parse::<f64>().ok() == value.as_f64(),
                "{name}: {cell} {text}"
            );
        }
        // The visible part is within the pass, and the peak is within the visible part.
        let time = |name: &str| pass[name].as_str().unwrap_or_default().to_owned();
        assert!(time("begin_utc") <= time("peak_utc") && time("peak_utc") <= time("end_utc"), "{pass}");
        assert!(time("begin_utc") <= time("highest_utc") && time("highest_utc") <= time("end_utc"), "{pass}");
        assert!(time("rise_utc") <= time("begin_utc") && time("end_utc") <= time("set_utc"), "{pass}");
        assert!(number(&pass["highest_altitude_deg"]) <= number(&pass["max_altitude_deg"]) + 0.001, "{pass}");
        // The visible part ends after the satellite begins to fade, and begins before it is in full sunlight. A pass
        // that is never in full sunlight has neither entry nor exit.
        if pass["ends_by"] == "shadow" && !pass["shadow_entry_utc"].is_null() {
            assert!(time("end_utc") > time("shadow_entry_utc"), "{pass}");
        }
        if pass["begins_by"] == "shadow" && !pass["shadow_exit_utc"].is_null() {
            assert!(time("begin_utc") < time("shadow_exit_utc"), "{pass}");
        }
    }
    let night = &answer["night"][0];
    // Passes that are only in the penumbra end with the shadow.
    let of_night = json(&[NIGHT, SKY]);
    let dark = &of_night["night"][0];
    for pass in of_night["passes"].as_array().unwrap() {
        assert!(pass["ends_by"] != "dawn" || pass["end_utc"] == dark["dark_until_utc"], "{pass}");
        assert!(pass["begins_by"] != "dusk" || pass["begin_utc"] == dark["dark_from_utc"], "{pass}");
    }
    assert!((8.0..14.0).contains(&number(&night["dark_h"])) && night["why_empty"].is_null(), "{night}");
    let began = |pass: &Value| pass["begin_utc"].as_str().unwrap().to_owned();
    assert!(passes.iter().all(|pass| began(pass).as_str() >= night["dark_from_utc"].as_str().unwrap()));
    assert!(
        passes.iter().any(|pass| pass["ends_by"] == "shadow")
            && passes.iter().any(|pass| pass["begins_by"] == "shadow")
    );
}

#[test]
fn visible_parts_can_end_with_the_time_range() {
    let minutes = ["forecast", "--start", "2024-08-14T23:30:00Z", "--end", "2024-08-14T23:32:00Z"];
    let answer = json(&[&minutes, SKY, &["--min-altitude", "30"]]);
    let passes = answer["passes"].as_array().unwrap();
    let with = |name: &str, event: &str| passes.iter().filter(|pass| pass[name] == event).cloned().collect::<Vec<_>>();
    let (started, ended) = (with("begins_by", "start"), with("ends_by", "end"));
    assert!(started.len() > 5 && ended.len() > 5, "{} {}", started.len(), ended.len());
    assert!(started.iter().all(|pass| pass["begin_utc"] == "2024-08-14T23:30:00.000000Z"), "{started:?}");
    assert!(ended.iter().all(|pass| pass["end_utc"] == "2024-08-14T23:32:00.000000Z"), "{ended:?}");
    assert!(with("begins_by", "dusk").is_empty() && with("ends_by", "dawn").is_empty());
    let calendar = done(&[&minutes, SKY, &["--min-altitude", "30", "--format", "ics"]]).replace("\r\n ", "");
    assert!(calendar.contains("(end of the forecast)"), "{calendar}");
}

#[test]
fn warnings_are_about_the_selected_satellites() {
    let folder = tempfile::tempdir().unwrap();
    let [flag, file] = published_constellation(&folder, "2024-08-14T12:00:00Z");
    let text = fs::read_to_string(&file).unwrap();
    let old = published_constellation(&folder, "2024-06-14T12:00:00Z");
    let first_old = fs::read_to_string(&old[1]).unwrap().lines().take(3).collect::<Vec<_>>().join("\n");
    // The first satellite has elements two months old.
    let others = text.lines().skip(3).take(300).collect::<Vec<_>>().join("\n");
    fs::write(&file, format!("{first_old}\n{others}\n")).unwrap();
    let night = ["forecast", "--night", "2024-08-14", "--mpc", "X05", &flag, &file, "--norad"];
    let warnings = |norad: &str| run(&[&night, &[norad]]).2;
    let is_old = "1 of 1 element set is more than 14 days";
    assert!(warnings("90001").contains(is_old), "{}", warnings("90001"));
    assert!(!warnings("90002").contains("more than 14 days"), "{}", warnings("90002"));
}

#[test]
fn verif_filters_omit_only_the_specified_passes() {
    let all = json(&[NIGHT, SKY, PLANES]);
    let all = all["passes"].as_array().unwrap();
    let keep = |holds: &dyn Fn(&Value) -> bool| all.iter().filter(|pass| holds(pass)).cloned().collect::<Vec<_>>();
    let found = |more: &[&str]| json(&[NIGHT, SKY, PLANES, more]);
    // With a probability of 0, all passes are listed, and the sum of their probabilities is the expected number.
    let any = found(&["--max-mag", "5.5", "--min-p-brighter", "0", "--sort", "time"]);
    let p_of = |pass: &Value| number(&pass["p_brighter"]);
    let without = |pass: &Value| {
        let mut pass = pass.clone();
        pass.as_object_mut().unwrap().remove("p_brighter");
        pass
    };
    let with_p = any["passes"].as_array().unwrap();
    assert_eq!(&with_p.iter().map(without).collect::<Vec<_>>(), all);
    let (sum, expected) = (with_p.iter().map(p_of).sum::<f64>(), number(&any["night"][0]["expected_brighter"]));
    assert!((sum - expected).abs() < P_DECIMALS * all.len() as f64 + 0.01 && sum > 5.0, "{sum} {expected}");
    // By default, the passes that are probably brighter are listed, the most probable first.
    let bright = found(&["--max-mag", "5.5"]);
    let shown = bright["passes"].as_array().unwrap();
    assert!(!shown.is_empty() && shown.len() < all.len());
    assert!(shown.windows(2).all(|pair| p_of(&pair[0]) >= p_of(&pair[1])));
    let probable: Vec<_> = with_p.iter().filter(|pass| p_of(pass) >= 0.5).cloned().collect();
    let by_time = found(&["--max-mag", "5.5", "--sort", "time"]);
    assert_eq!(by_time["passes"].as_array().unwrap(), &probable);
    assert_eq!(shown.len(), probable.len());
    assert_eq!(bright["night"][0]["passes_too_faint"].as_u64().unwrap() as usize, all.len() - shown.len());
    assert_eq!(number(&bright["night"][0]["expected_brighter"]), expected);
    // Extinction makes all of them fainter, most near the horizon, and is the same for an explicit value. Twilight
    // makes some of them improbable.
    let above = found(&["--max-mag", "5.5", "--min-p-brighter", "0", "--sort", "time", "--no-atmosphere"]);
    let above = above["passes"].as_array().unwrap();
    let magnitude = |pass: &Value| pass["peak_magnitude"].as_f64();
    for (one, other) in with_p.iter().zip(above) {
        let lost = magnitude(one).zip(magnitude(other)).map(|(below, above)| below - above);
        assert!(lost.is_none_or(|lost| (0.1..1.5).contains(&lost)), "{one} {other}");
        assert!(p_of(one) <= p_of(other), "{one} {other}");
    }
    let coefficient = number(&any["provenance"]["extinction_mag_per_airmass"]);
    let given = found(&["--extinction", &coefficient.to_string()]);
    let peaks = |passes: &Value| passes.as_array().unwrap().iter().map(magnitude).collect::<Vec<_>>();
    let differ =
        |a: &Option<f64>, b: &Option<f64>| a.zip(*b).is_some_and(|(a, b)| (a - b).abs() > MAGNITUDE_DECIMALS * 4.0);
    assert!(!peaks(&given["passes"]).iter().zip(&peaks(&any["passes"])).any(|(a, b)| differ(a, b)));
    let at_dusk = |sun: &str| {
        let passes =
            found(&["--max-mag", "5.5", "--min-p-brighter", "0", "--extinction", "0", "--sun-altitude-deg", sun]);
        number(&passes["night"][0]["expected_brighter"])
    };
    assert!(
        at_dusk("-3") - at_dusk("-5") < 0.3 * (at_dusk("-9") - at_dusk("-15")),
        "{} {}",
        at_dusk("-3"),
        at_dusk("-5")
    );
    let high = found(&["--min-culmination", "40"]);
    let expected = keep(&|pass| number(&pass["max_altitude_deg"]) >= 40.0);
    assert!(!expected.is_empty() && expected.len() < all.len());
    assert_eq!(high["passes"].as_array().unwrap(), &expected);
    let one = number(&all[0]["norad_id"]) as u32;
    let single = found(&["--norad", &one.to_string()]);
    assert_eq!(single["passes"].as_array().unwrap(), &keep(&|pass| pass["norad_id"] == one));
    assert_eq!(found(&["--generation", "starlink-v1.5"])["passes"].as_array().unwrap(), all);
    // With --include-dark the visible passes are unchanged.
    let dark = found(&["--include-dark"]);
    let dark = dark["passes"].as_array().unwrap();
    assert!(dark.len() > all.len() + 50, "{} {}", dark.len(), all.len());
    // The intervals are found by another search with other rounding. Times agree to the second, and none is close to a
    // full second here.
    let second = |pass: &Value| pass["begin_utc"].as_str().unwrap_or_default().chars().take(19).collect::<String>();
    for pass in all {
        assert!(
            dark.iter().any(|other| other["norad_id"] == pass["norad_id"] && second(other) == second(pass)),
            "{pass}"
        );
    }
    let late = found(&["--sun-altitude-deg", "-18"]);
    assert!(late["passes"].as_array().unwrap().len() < all.len());
}

#[test]
fn verif_light_curves_contain_the_peak() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "curves.csv");
    let sky = [SKY, PLANES, &["--max-mag", "6"]].concat();
    let answer = json(&[NIGHT, &sky, &["--light-curves", &file, "--samples", "41"]]);
    let passes = answer["passes"].as_array().unwrap();
    let curves = records(&fs::read_to_string(&file).unwrap());
    assert_eq!(curves.len() - 1, 41 * passes.len());
    for (pass, rows) in passes.iter().zip(curves[1..].chunks(41)) {
        let samples = pass["samples"].as_array().unwrap();
        assert_eq!(samples.len(), 41);
        assert_eq!(
            (&rows[0][3], &rows[40][3]),
            (pass["rise_utc"].as_str().unwrap(), pass["set_utc"].as_str().unwrap())
        );
        let (begin, end) = (pass["begin_utc"].as_str().unwrap(), pass["end_utc"].as_str().unwrap());
        let peak = number(&pass["peak_magnitude"]);
        for sample in samples.iter().filter(|sample| (begin..=end).contains(&sample["utc"].as_str().unwrap())) {
            if let Some(magnitude) = sample["magnitude"].as_f64() {
                assert!(magnitude >= peak - MAGNITUDE_DECIMALS * 2.0, "{magnitude} outshines the peak of {pass}");
            }
        }
        assert!(
            samples
                .iter()
                .filter(|sample| sample["illumination"] == "umbra")
                .all(|sample| sample["magnitude"].is_null())
        );
    }
}

#[test]
fn verif_a_night_without_darkness_has_a_reason() {
    let polar: &[&str] = &["--shells", "starlink-gen1", "--lat", "78.2", "--lon", "15.6", "--night", "2024-06-21"];
    let (code, stdout, stderr) = run(&[&["forecast"], polar, &["--format", "csv"]]);
    assert_eq!(code, 0);
    assert!(stdout.lines().filter(|line| !line.starts_with('#')).eq([HEADER]), "{stdout}");
    let why = "no passes: it does not get dark at latitude 78.200, longitude 15.600 deg between 2024-06-21T10:57:36Z and 2024-06-22T10:57:36Z: the lowest altitude of the Sun is 11.6 deg";
    assert!(stderr.contains(why) && stderr.contains("above the limit of -6.0 deg"), "{stderr}");
    let answer = json(&[&["forecast"], polar]);
    assert!(answer["passes"].as_array().unwrap().is_empty());
    let night = &answer["night"][0];
    assert!(why.ends_with(night["why_empty"].as_str().unwrap().split(" (").next().unwrap()), "{night}");
    assert!(night["dark_from_utc"].is_null() && number(&night["lowest_sun_altitude_deg"]) > 11.0);
    // The reason is also printed for a dark night without bright passes.
    let (_, _, stderr) = run(&[NIGHT, &SKY[..4], PLANES, &["--max-mag", "-8", "--format", "csv"]]);
    assert!(
        stderr.contains("no passes: ") && stderr.contains("are brighter than mag -8 with a probability below 50 %"),
        "{stderr}"
    );
}

#[test]
fn verif_documents() {
    let sky = [SKY, PLANES, &["--max-mag", "6", "--no-atmosphere"]].concat();
    let answer = json(&[NIGHT, &sky]);
    let passes = answer["passes"].as_array().unwrap();
    let calendar = done(&[NIGHT, &sky, &["--format", "ics", "--alarm", "5min"]]);
    assert!(calendar.split("\r\n").all(|line| line.len() <= 75 && !line.contains('\n')));
    let unfolded = calendar.replace("\r\n ", "");
    let starting =
        |with: &str| unfolded.lines().filter(|line| line.starts_with(with)).map(str::to_owned).collect::<Vec<_>>();
    let starts: Vec<String> = passes
        .iter()
        .map(|pass| format!("DTSTART:{}Z", &pass["begin_utc"].as_str().unwrap().replace(['-', ':'], "")[..15]))
        .collect();
    assert_eq!(starting("DTSTART:"), starts);
    assert_eq!(starting("TRIGGER:-PT300S").len(), passes.len());
    let somewhere: &[&str] = &["--lat=-30.2446", "--lon=-70.7494", "--height", "2663", "--format", "ics"];
    let of_place = done(&[NIGHT, &SKY[..2], PLANES, somewhere]);
    assert!(of_place.contains("LOCATION:latitude -30.245\\, longitude -70.749 deg\r\n"), "{of_place}");
    let mut ids = starting("UID:");
    // The identifier does not change with the seconds of a prediction.
    assert!(ids.iter().all(|id| id.ends_with("000Z@streakcast")), "{ids:?}");
    ids.dedup();
    assert_eq!(ids.len(), passes.len());

    // Events are in UTC. Their descriptions are in the given time zone, which has summer time in August.
    let described = |zone: &str| {
        let text = done(&[NIGHT, &sky, &["--format", "ics", "--time-zone", zone]]).replace("\r\n ", "");
        let times = text.lines().filter(|line| line.starts_with("DTSTART:")).map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(times, starts);
        text.lines().find(|line| line.starts_with("DESCRIPTION:")).unwrap().to_owned()
    };
    let start = |zone: &str| described(zone).split("starts ").nth(1).unwrap().split("\\,").next().unwrap().to_owned();
    let (utc, local) = (start("Z"), start("America/New_York"));
    let hour = |text: &str| text[..2].parse::<i32>().unwrap();
    assert!(utc.ends_with(" UTC") && local.ends_with(" UTC-04:00") && utc[2..8] == local[2..8], "{utc} {local}");
    assert_eq!((hour(&utc) - 4).rem_euclid(24), hour(&local));

    for (angles, first) in [("radec", "REFERENCE_FRAME = ICRF"), ("azel", "ANGLE_TYPE = AZEL")] {
        let message = done(&[NIGHT, &sky, &["--format", "tdm", "--angle-type", angles, "--samples", "11"]]);
        assert!(message.starts_with("CCSDS_TDM_VERS = 2.0\n"));
        assert_eq!(message.matches("META_START").count(), passes.len());
        assert_eq!(message.matches(first).count(), passes.len());
        let times = |name: &str| message.lines().filter(|line| line.starts_with(name)).count();
        assert!(times("ANGLE_1 = ") == times("ANGLE_2 = ") && times("MAG = ") > 3 * passes.len(), "{angles}");
        assert!(message.contains("CREATION_DATE = ") && message.contains("PATH = 2,1"));
    }

    let report = done(&[NIGHT, &sky, &["--format", "score"]]);
    // Without an extinction, these formats have magnitudes above the atmosphere.
    let implied = done(&[NIGHT, SKY, PLANES, &["--max-mag", "6", "--format", "score"]]);
    assert_eq!(report, implied);
    // Calendars have age and lateness.
    let described = unfolded.lines().filter(|line| line.starts_with("DESCRIPTION:brightest ")).count();
    assert_eq!(described, passes.len());
    assert!(unfolded.contains("elements 0.") && unfolded.contains(" days old\\, times \u{b1} 0."), "{unfolded}");
    let rows = records(&report);
    assert_eq!(rows.len() - 1, passes.len());
    assert_eq!((rows[0].len(), &rows[0][0], &rows[0][26]), (27, "satellite_name", "mpc_code"));
    for (row, pass) in rows[1..].iter().zip(passes) {
        assert_eq!(row[4].parse::<f64>().ok(), pass["peak_magnitude"].as_f64());
        assert!(row[24].starts_with("predicted by streakcast") && &row[26] == "X05", "{row:?}");
        // Columns that describe a measurement are empty.
        assert!([3, 9, 10, 11, 13, 14, 17, 18, 19, 21, 22, 23].iter().all(|&cell| row[cell].is_empty()), "{row:?}");
    }

    let table = done(&[NIGHT, &sky, &["--format", "table", "--utc-offset=-04:00"]]);
    assert_eq!(table.lines().count(), passes.len() + 1);
    assert!(table.lines().next().unwrap().contains("start (local)"));
    // New York has summer time in August.
    assert_eq!(table, done(&[NIGHT, &sky, &["--format", "table", "--time-zone", "America/New_York"]]));
    let votable = done(&[NIGHT, &sky, &["--format", "votable"]]);
    assert_eq!(votable.matches("<TR>").count(), passes.len());
    assert!(votable.starts_with("<?xml") && votable.trim_end().ends_with("</VOTABLE>"));
}

/// The number of satellites of unknown brightness is reported, both of listed and of omitted passes.
#[test]
fn verif_priors_are_reported() {
    let elements = crate::common::golden_dir().join("elements/sample.3le").display().to_string();
    let arguments =
        ["forecast", "--elements", &elements, "--lat", "35", "--lon", "10", "--format", "csv", "--no-atmosphere"];
    let time = ["--start", "2026-03-18T00:00:00Z", "--end", "2026-03-23T00:00:00Z"];
    let prior = |more: &[&str]| {
        let (code, stdout, stderr) = run(&[&arguments, &time, more]);
        assert_eq!(code, 0, "{stderr}");
        let warning = stderr.lines().find(|line| line.contains("only a wide prior")).map(str::to_owned);
        (records(&stdout), warning, stderr)
    };
    let (all, warning, _) = prior(&[]);
    let (count, source) = (all.len() - 1, all[0].iter().position(|name| name == "mag_source").unwrap());
    assert!(count > 1 && all[1..].iter().all(|row| &row[source] == "prior"), "{all:?}");
    let warning = warning.expect("a warning");
    assert!(
        warning.starts_with("warning: ")
            && warning.contains(&format!("({count} passes shown); specify standard magnitudes with --qs-mag FILE")),
        "{warning}"
    );
    // With a limit slightly brighter than the faintest peak, one pass is omitted, and the message uses the singular.
    let peak = all[0].iter().position(|name| name == "peak_magnitude").unwrap();
    let mut peaks: Vec<f64> = all[1..].iter().map(|row| row[peak].parse().unwrap()).collect();
    peaks.sort_by(f64::total_cmp);
    let limit = (0.5 * (peaks[count - 2] + peaks[count - 1])).to_string();
    let (_, warning, _) = prior(&["--max-mag", &limit]);
    let expected = format!("{} shown, 1 pass omitted as probably fainter than mag {limit})", passes(count - 1));
    assert!(warning.as_ref().is_some_and(|warning| warning.contains(&expected)), "{warning:?}: {expected}");
    let (_, warning, stderr) = prior(&["--max-mag", "-9"]);
    assert!(
        warning.is_some_and(
            |warning| warning.contains(&format!("({count} passes omitted as probably fainter than mag -9)"))
        )
    );
    assert!(
        stderr.contains("no passes: ") && stderr.contains("are brighter than mag -9 with a probability below 50 %"),
        "{stderr}"
    );
    // Satellites with a model are not reported.
    let (code, _, stderr) = run(&[NIGHT, &SKY[..4], PLANES, &["--format", "csv"]]);
    assert!(code == 0 && !stderr.contains("prior"), "{stderr}");
}

fn passes(count: usize) -> String {
    format!("{count} {}", if count == 1 { "pass" } else { "passes" })
}

#[test]
fn messages_use_the_singular_for_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "one.tle");
    let good = fs::read_to_string(crate::common::golden_dir().join("elements/sample.2le")).unwrap();
    // Changes the checksum, which is the last digit of each line.
    let wrong = |line: &str| format!("{}{}\n", &line[..68], (line.as_bytes()[68] - b'0' + 1) % 10);
    fs::write(&file, good.lines().take(2).map(wrong).collect::<String>()).unwrap();
    let arguments =
        ["forecast", "--elements", &file, "--accept-bad-checksums", "--mpc", "X05", "--night", "2026-03-20"];
    let (code, _, stderr) = run(&[&arguments]);
    assert!(code == 0 && stderr.contains("1 record accepted despite a wrong checksum"), "{stderr}");
    // The selected satellite has one pass above the minimum culmination.
    let all = json(&[NIGHT, SKY, PLANES]);
    let all = all["passes"].as_array().unwrap();
    let one = all.iter().map(|pass| number(&pass["max_altitude_deg"])).fold(0.0, f64::max);
    let just_below = format!("{:.3}", one - 0.001);
    let (_, _, stderr) = run(&[NIGHT, &SKY[..4], PLANES, &["--min-culmination", &just_below, "--format", "csv"]]);
    assert!(stderr.contains("1 pass of 1 satellite"), "{stderr}");
    let (_, _, stderr) =
        run(&[NIGHT, &SKY[..4], PLANES, &["--min-culmination", &just_below, "--max-mag", "-9", "--format", "csv"]]);
    assert!(stderr.contains("1 pass is brighter than mag -9 with a probability below 50 %"), "{stderr}");
}

#[test]
fn invalid_input_gives_one_line_with_the_allowed_values() {
    let folder = tempfile::tempdir().unwrap();
    // A file in place of a folder.
    let elsewhere = path(&folder, "file/x.csv");
    fs::write(path(&folder, "file"), "").unwrap();
    for (arguments, parts) in [
        (&["--night", "8/14/2024"][..], &["'8/14/2024' for '--night <DATE>'", "tonight", "2024-08-14"][..]),
        (&["--start", "2024-08-14T00:00:00Z"], &["--end"]),
        (&["--start", "2024-08-14T00:00:00Z", "--end", "2024-10-14T00:00:00Z"], &["; allowed: 0 to 31 days"]),
        (&["--start", "2024-08-14T00:00:00Z", "--end", "2024-08-13T00:00:00Z"], &["the end not before the start"]),
        (&["--night", "2024-08-14", "--min-altitude", "95"], &["min-altitude is 95 deg", "below 90 deg"]),
        (&["--night", "2024-08-14", "--min-altitude", "NaN"], &["min-altitude is NaN"]),
        (&["--night", "2024-08-14", "--sun-altitude-deg", "-100"], &["sun-altitude-deg is -100 deg", "-90 to 90 deg"]),
        (&["--night", "2024-08-14", "--max-mag", "99"], &["max-mag is 99 mag", "-30 to 40 mag"]),
        (&["--night", "2024-08-14", "--min-p-brighter", "2"], &["min-p-brighter is 2", "0 to 1"]),
        (&["--night", "2024-08-14", "--sort", "size"], &["invalid value 'size'", "time, brightness"]),
        (
            &["--night", "2024-08-14", "--no-atmosphere", "--extinction", "0.1"],
            &["no-atmosphere and extinction exclude each other"],
        ),
        (&["--night", "2024-08-14", "--samples", "1000000"], &["samples is 1000000", "0 to 10000"]),
        (&["--night", "2024-08-14", "--generation", "starlink"], &["generation 'starlink'", "starlink-v2mini"]),
        (
            &["--night", "2024-08-14", "--name", "ISS (ZARYA)"],
            &["none of the 4408 satellites has a name with ISS (ZARYA)"],
        ),
        (&["--night", "2024-08-14", "--norad", "x"], &["'x'", "not a NORAD catalogue number; allowed: 1 to 999999999"]),
        (&["--night", "2024-08-14", "--norad", "0"], &["'0'", "1 to 999999999"]),
        (&["--night", "2024-08-14", "--alarm", "5min"], &["--alarm is given without a calendar", "--format ics"]),
        (&["--night", "2024-08-14", "--alarm", "5min", "--format", "csv"], &["--alarm is given without a calendar"]),
        (
            &["--night", "2024-08-14", "--angle-type", "azel"],
            &["--angle-type is given without a tracking data message", "--format tdm"],
        ),
        (
            &["--night", "2024-08-14", "--time-zone", "Europe/Madrid", "--format", "tdm"],
            &["--time-zone has no effect on the formats tdm and score", "table or ics"],
        ),
        (
            &["--night", "2024-08-14", "--utc-offset", "Atlantis"],
            &["invalid value 'Atlantis'", "--time-zone", "Europe/Madrid", "+01:00"],
        ),
        (&["--night", "2024-08-14", "--alarm", "5"], &["alarm", "30s, 2.5min, 1h"]),
        (&["--night", "2024-08-14", "--angle-type", "xyz"], &["angle-type 'xyz'", "radec, azel"]),
        (&["--night", "2024-08-14", "--format", "xlsx"], &["format 'xlsx'", "votable", ", ics, tdm, score"]),
        (&["--night", "2024-08-14", "--light-curves", &elsewhere], &["cannot write", "file/x.csv"]),
        (
            &["--night", "2024-08-14", "--light-curves", "lc.foo"],
            &["the extension of lc.foo is not a format", ".ecsv, .json"],
        ),
        (
            &["--night", "2024-08-14", "-o", "x.png"],
            &["the extension of x.png is not a format", ".vot", ".ics, .tdm, .score", "--format"],
        ),
        (&["--night", "2024-08-14", "--fov", "3deg"], &["--fov has no effect on passes over a site"]),
        (&["--night", "2024-08-14", "--rotation", "3"], &["--rotation has no effect"]),
        (&["--night", "2024-08-14", "--telescope", "rubin"], &["--telescope has no effect"]),
        (&["--night", "2024-08-14", "--min-probability", "5"], &["--min-probability has no effect"]),
        (
            &["--night", "2024-08-14", "--norad", "1", "99999"],
            &["none of the 4408 satellites has NORAD number 1 or 99999"],
        ),
        (&["--night", "1850-08-14"], &["1957 to 2099"]),
    ] {
        let (code, stdout, stderr) = run(&[&["forecast"], SKY, arguments]);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(
            stdout.is_empty() && stderr.starts_with("error: ") && stderr.lines().count() == 1,
            "{arguments:?}: {stderr}"
        );
        for part in parts {
            assert!(stderr.contains(part), "{arguments:?}: {stderr}");
        }
    }
}

/// Passes counted as in the shadow are above the horizon during darkness, and not sunlit in the dark hours.
#[test]
fn verif_shadow_counts_passes_in_darkness_only() {
    // The satellite is sunlit, but sets before darkness.
    let evening = ["--start", "2026-08-14T22:10:00Z", "--end", "2026-08-14T22:45:00Z", "--norad", "900002031"];
    let night = json(&[&["forecast"], SKY, &evening])["night"][0].clone();
    assert_eq!(night["passes_in_shadow"], 0, "{night}");
    let why = night["why_empty"].as_str().unwrap();
    assert!(why.starts_with("the only satellite does not rise above 10.0 deg while it is dark"), "{why}");
    assert!(!json(&[&["forecast"], SKY, &evening, &["--include-dark"]])["passes"].as_array().unwrap().is_empty());
    // Counted independently: all passes in a dark time span minus the visible ones, for ten seconds at midnight and for
    // the last hours of a night.
    for (start, end) in
        [("2026-08-15T04:00:00Z", "2026-08-15T04:00:10Z"), ("2026-08-15T08:00:00Z", "2026-08-15T10:30:00Z")]
    {
        let time = ["--start", start, "--end", end, "--name", "S1"];
        let answer = json(&[&["forecast"], SKY, &time]);
        let all = json(&[&["forecast"], SKY, &time, &["--include-dark"]]);
        let unseen = |pass: &&Value| pass["begin_utc"].is_null();
        let expected = all["passes"].as_array().unwrap().iter().filter(unseen).count();
        let counted = answer["night"][0]["passes_in_shadow"].as_u64().unwrap() as usize;
        assert!(expected > 20 && counted == expected, "{start}: {counted} counted, {expected} there");
    }
}

#[test]
fn verif_an_unknown_catalogue_number_is_named() {
    let (code, _, stderr) =
        run(&[NIGHT, &SKY[..4], &["--norad", "900000001", "99999", "--include-dark", "--format", "csv"]]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("warning: none of the 4408 satellites has NORAD number 99999\n"), "{stderr}");
}

#[test]
fn verif_an_empty_night_is_a_valid_calendar_without_message() {
    let empty: &[&str] = &["--max-mag", "-8"];
    let calendar = done(&[NIGHT, SKY, PLANES, empty, &["--format", "ics", "--alarm", "5min"]]).replace("\r\n ", "");
    assert_eq!((calendar.matches("BEGIN:VEVENT").count(), calendar.matches("BEGIN:VALARM").count()), (1, 0));
    for line in ["SUMMARY:No visible satellite pass over ", "DESCRIPTION:", "TRANSP:TRANSPARENT", "UID:none-"] {
        assert!(calendar.lines().any(|known| known.starts_with(line)), "{calendar}");
    }
    assert!(calendar.contains("brighter than mag -8"), "{calendar}");
    // The extension of the file name determines the format, in upper or lower case.
    let folder = tempfile::tempdir().unwrap();
    let file = path(&folder, "NIGHT.ICS");
    done(&[NIGHT, SKY, PLANES, empty, &["-o", &file]]);
    assert!(fs::read_to_string(&file).unwrap().starts_with("BEGIN:VCALENDAR"));
    // The calendar also contains this event if no pass is visible.
    let unseen = ["forecast", "--start", "2026-08-15T04:00:00Z", "--end", "2026-08-15T04:00:10Z", "--include-dark"];
    let calendar = done(&[&unseen, SKY, &["--format", "ics"]]);
    assert!(calendar.matches("BEGIN:VEVENT").count() == 1 && calendar.contains("all passes are in the Earth's shadow"));
    assert_eq!(run(&[&unseen, SKY, &["--format", "tdm"]]).0, 2);
    let (code, stdout, stderr) = run(&[NIGHT, SKY, PLANES, empty, &["--format", "tdm"]]);
    assert!(code == 2 && stdout.is_empty(), "{stdout}");
    assert!(stderr.contains("brighter than mag -8") && stderr.contains("needs at least one"), "{stderr}");
}

#[test]
fn help_names_every_format() {
    let help = done(&[&["forecast", "--help"]]).split_whitespace().collect::<Vec<_>>().join(" ");
    for format in ["votable, ics (calendar)", "tdm (CCSDS tracking data message)", "score (columns of SCORE)"] {
        assert!(help.contains(format), "{format}: {help}");
    }
}

/// The date is that of the brightest time, beside which it is printed, if the pass begins before midnight.
#[test]
fn dates_are_those_of_the_brightest_time() {
    let answer = json(&[NIGHT, SKY, PLANES]);
    let minute = |pass: &Value, name: &str| pass[name].as_str().unwrap()[..16].to_owned();
    let passes = answer["passes"].as_array().unwrap().iter();
    let pass = passes.into_iter().find(|pass| minute(pass, "begin_utc") < minute(pass, "peak_utc")).unwrap();
    // The minute of the brightest time is the first one of a local day.
    let peak = minute(pass, "peak_utc");
    let [hours, minutes] = [11..13, 14..16].map(|digits| peak[digits].parse::<u32>().unwrap());
    let (ahead_min, sign) = match 60 * hours + minutes {
        minutes @ ..=720 => (minutes, '-'),
        minutes => (1440 - minutes, '+'),
    };
    let zone = format!("{sign}{:02}:{:02}", ahead_min / 60, ahead_min % 60);
    let day = peak[8..10].parse::<u32>().unwrap() + u32::from(sign == '+');
    let [start, end] = ["rise_utc", "set_utc"].map(|name| pass[name].as_str().unwrap().to_owned());
    let id = pass["norad_id"].to_string();
    let table = done(&[
        &["forecast", "--start", &start, "--end", &end, "--time-zone", &zone, "--norad", &id, "--format", "table"],
        SKY,
    ]);
    let date = format!("{}{day:02}", &peak[..8]);
    assert!(table.lines().any(|line| line.trim_start().starts_with(&date)), "{date} {zone}: {table}");
}
