//! Inputs of public bug reports (`reports/INDEX.tsv` of the real data), each with the result that its authority states.

use crate::common::cli::run;

/// Expected exit status, and words of the output or of the messages. Words after `!` must be absent.
type Expected = (i32, &'static [&'static str]);

const EXPECTED: &[(&str, Expected)] = &[
    ("oem_useable_span", (0, &["212.0", "-16.9", "!213.15"])),
    ("frame_stack_date_end", (2, &["1800.0 s from DATE-OBS to DATE-END", "--exposure 1800s"])),
    ("frame_date_obs_midpoint", (0, &["2026-08-22T03:15:00.000000Z,2.0000,"])),
    ("frame_date_obs_received", (2, &["the time of an event after the exposure", "--start"])),
    ("frame_date_obs_end", (0, &["2026-08-22T03:15:00.000000Z,2.0000,"])),
    ("frame_date_obs_local", (2, &["a local time", "--start"])),
    ("frame_exposure_days", (0, &["2026-08-22T03:15:00.000000Z,2.0000,"])),
    ("frame_exptime_microseconds", (0, &["1 predicted track"])),
    ("frame_itime_coadds", (2, &["2 s of each of 30 exposures (COADDS)", "--exposure 60s"])),
    ("frame_site_conflict", (1, &["Sutherland", "!Haleakala"])),
    ("frame_site_ambiguous", (2, &["ATLAS Chile", "--mpc"])),
    ("frame_gain_setting", (0, &["GAIN is 360: a setting of the camera or electrons per count"])),
    ("omm_epoch_date_only", (2, &["invalid epoch \"2026-08-21\""])),
    ("wcs_pv1_3", (0, &["1 random streak"])),
    ("ds9_saved_vector", (0, &["STARLINK-5095"])),
    ("night_dateline", (0, &["2026-08-22T05:5"])),
    ("opsim_two_snaps", (0, &["avoid"])),
    ("omm_decayed", (2, &["has decayed before 2026-08-21T00:00:00 UTC (DECAY_DATE"])),
    ("amsat_bulletin", (0, &["!truncated", "!rejected, more than half"])),
    ("frame_rgb_cube", (2, &["NAXIS3 = 3", "a colour image"])),
    ("tle_day000", (2, &["day 0 is 31 December of the year before for some programs"])),
];

#[test]
fn valid_results_of_public_reports() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("reports");
    if !folder.join("INDEX.tsv").is_file() {
        eprintln!("\n*** SKIPPED: no reports in {} ***\n", data.display());
        return;
    }
    let index = std::fs::read_to_string(folder.join("INDEX.tsv")).unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let mut failed = Vec::new();
    for (name, (code, words)) in EXPECTED {
        let command = index.lines().find_map(|line| line.strip_prefix(&format!("{name}\t"))).expect(name);
        let command = command.split('\t').next().unwrap();
        let arguments: Vec<String> = command
            .split_whitespace()
            .map(|word| match word {
                "o.fits" | "t.csv" => outputs.path().join(word).display().to_string(),
                word if folder.join(word).is_file() => folder.join(word).display().to_string(),
                word => word.to_owned(),
            })
            .collect();
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (found, stdout, stderr) = run(&[&arguments]);
        let text = format!("{stdout}{stderr}");
        let holds = |word: &&str| word.strip_prefix('!').map_or(text.contains(*word), |absent| !text.contains(absent));
        if found != *code || !words.iter().all(holds) {
            let end: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
            failed.push(format!("{name}: exit {found}, expected {code} and {words:?}:\n{}", end.join("\n")));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

/// Segments whose USEABLE times adjoin are used on both sides, although they differ by more than 1 km; there is no
/// warning about element sets unless there is a time between them.
#[test]
fn valid_adjoining_segments_of_a_public_report_need_no_element_set() {
    let Some(folder) = crate::common::data_dir().map(|data| data.join("reports")) else { return };
    let Ok(whole) = std::fs::read_to_string(folder.join("oem_useable_span.oem")) else {
        eprintln!("\n*** SKIPPED: no reports in {} ***\n", folder.display());
        return;
    };
    let outputs = tempfile::tempdir().unwrap();
    let file = outputs.path().join("a.oem").display().to_string();
    let elements = folder.join("starlink5095.tle").display().to_string();
    let stop = "USEABLE_STOP_TIME = 2026-08-22T03:14:00";
    let start = "USEABLE_START_TIME = 2026-08-22T03:14:00";
    assert!(whole.contains(stop) && whole.contains(start));
    for (text, times, is_hole) in [
        (whole.clone(), ["2026-08-22T03:13:00Z", "2026-08-22T03:14:00Z", "2026-08-22T03:15:00Z"], false),
        (whole.clone(), ["2026-08-22T02:30:00Z", "2026-08-22T03:20:00Z", "2026-08-22T04:00:00Z"], false),
        (whole.replace(stop, "USEABLE_STOP_TIME = 2026-08-22T03:10:00"), ["2026-08-22T03:09:00Z"; 3], false),
        (
            whole.replace(stop, "USEABLE_STOP_TIME = 2026-08-22T03:10:00"),
            ["2026-08-22T03:09:00Z", "2026-08-22T03:12:00Z", "2026-08-22T03:15:00Z"],
            true,
        ),
    ] {
        std::fs::write(&file, text).unwrap();
        let site = ["--lat", "30", "--lon=-110", "--height", "1000", "--norad", "56885", "--format", "csv"];
        let (code, stdout, stderr) = run(&[&["ephemeris", "--elements", &elements, &file, "--times"], &times, &site]);
        assert_eq!(code, 0, "{stderr}");
        assert_eq!(stderr.contains("do not cover"), is_hole, "{times:?}: {stderr}");
        assert_eq!(stdout.matches(",ephemeris").count() < 3, is_hole, "{times:?}: {stdout}");
    }
}
