//! `streakcast identify`: all ways to specify a streak, and errors for invalid values.

use crate::common::cli::{SKY, done, json, path, records, run};
use serde_json::Value;

/// Returns a pass of a simulated constellation.
fn pass() -> Value {
    let answer = json(&[
        &["passes"],
        SKY,
        &["--fov", "3.5deg", "--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"],
    ]);
    answer["passes"][0].clone()
}

fn end(pass: &Value, which: &str) -> String {
    format!("{},{}", pass[format!("{which}_ra_deg")], pass[format!("{which}_dec_deg")])
}

fn first(words: &[&str]) -> (Value, Value) {
    let answer = json(&[&["identify"], SKY, words]);
    (answer["candidates"][0].clone(), answer)
}

#[test]
fn a_pass_is_identified_in_every_form() {
    let pass = pass();
    let (enter, exit) = (end(&pass, "enter"), end(&pass, "exit"));
    let times = [pass["enter_utc"].as_str().unwrap(), pass["exit_utc"].as_str().unwrap()];
    let angle = pass["position_angle_deg"].to_string();
    let (ra, dec) = (pass["mid_ra_deg"].to_string(), pass["mid_dec_deg"].to_string());
    let shutter = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s"];
    let length = format!("{}deg", pass["streak_length_deg"]);
    let ways: [Vec<&str>; 4] = [
        vec!["--end", &enter, "--end", &exit, "--times", times[0], times[1]],
        [vec!["--end", &exit, "--end", &enter], shutter.to_vec()].concat(),
        [vec!["--ra", &ra, "--dec", &dec, "--position-angle", &angle], shutter.to_vec()].concat(),
        [vec!["--ra", &ra, "--dec", &dec, "--position-angle", &angle, "--length", &length], shutter.to_vec()].concat(),
    ];
    for way in ways {
        let (candidate, answer) = first(&way);
        assert_eq!(candidate["norad_id"], pass["norad_id"], "{way:?}: {answer}");
        assert!(candidate["cross_track_offset_arcsec"].as_f64().unwrap().abs() < 30.0, "{candidate}");
        assert!(candidate["magnitude"].is_number() && candidate["probability"].as_f64().unwrap() > 0.5, "{candidate}");
        assert_eq!(answer["streak"].as_array().unwrap().len(), 1);
        assert!(answer["provenance"]["options"]["unknown_probability"].is_number());
    }
}

#[test]
fn the_same_rows_in_every_format() {
    let pass = pass();
    let ends = [end(&pass, "enter"), end(&pass, "exit")];
    let times = [pass["enter_utc"].as_str().unwrap(), pass["exit_utc"].as_str().unwrap()];
    let words = ["--end", &ends[0], "--end", &ends[1], "--times", times[0], times[1], "--top", "1"];
    let output = |format: &str| done(&[&["identify"], SKY, &words, &["--format", format]]);
    let id = pass["norad_id"].to_string();
    for format in ["csv", "ecsv", "jsonl", "json", "table"] {
        assert!(output(format).contains(&id), "{format}: {}", output(format));
    }
    let rows = records(&output("csv"));
    assert_eq!((rows.len(), &rows[0][0], &rows[1][0]), (2, "norad_id", id.as_str()));
}

#[test]
fn no_candidate_ends_with_1() {
    // Position far in the south, where no satellite of inclination 53 degrees passes.
    let words = ["--end", "10,-86.5", "--end", "12,-86.6", "--start", "2026-08-14T23:29:05Z", "--exposure", "1s"];
    let (code, stdout, stderr) = run(&[&["identify"], &SKY[..4], &words, &["--format", "csv"]]);
    assert_eq!(code, 1, "{stderr}");
    assert_eq!(records(&stdout).len(), 1);
    assert!(stderr.contains("no candidate"), "{stderr}");
}

#[test]
fn rows_of_satellites_that_do_not_fit_are_omitted() {
    // The streak of the pass, shifted by 0.16 deg perpendicular to the track.
    let pass = pass();
    let end = |which: &str| {
        let ra_deg = pass[format!("{which}_ra_deg")].as_f64().unwrap();
        format!("{},{}", ra_deg + 0.16, pass[format!("{which}_dec_deg")])
    };
    let (enter, exit) = (end("enter"), end("exit"));
    let words = ["--end", &enter, "--end", &exit, "--start", "2026-08-14T23:29:05Z", "--exposure", "30s"];
    let (code, stdout, stderr) = run(&[&["identify"], &SKY[..4], &words, &["--format", "json"]]);
    let answer: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, answer["candidates"].as_array().unwrap().len()), (1, 0), "{stderr}");
    assert!(answer["provenance"]["options"]["candidates"].as_u64().unwrap() > 0, "{answer}");
    assert!(stderr.contains("no candidate fits: ") && stderr.contains(" arcsec from the streak"), "{stderr}");
}

#[test]
fn invalid_streaks_give_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let region = path(&folder, "a.reg");
    std::fs::write(&region, "fk5\ncircle(1,2,3\")\n").unwrap();
    let pixels = path(&folder, "pixels.reg");
    std::fs::write(&pixels, "fk5\nline(1,2,3,4)\nimage\nline(1,2,3,4)\n").unwrap();
    let none = path(&folder, "none.reg");
    std::fs::write(&none, "fk5\n").unwrap();
    let shutter = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s"];
    let with = |words: &[&'static str]| [words.to_vec(), shutter.to_vec()].concat();
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut cases: Vec<(Vec<&str>, &str)> = vec![
        (shutter.to_vec(), "missing streak; specify --end RA,DEC twice"),
        (with(&["--end", "1,2"]), "--end is given once; allowed: twice"),
        (with(&["--end", "1,2", "--end", "1,2"]), "both ends of the streak are at the same position"),
        (with(&["--end", "1;2", "--end", "1,2"]), "invalid end '1;2'"),
        (with(&["--end", "1,2", "--end", "400,2"]), "is not a right ascension"),
        (
            with(&["--end", "1,2", "--end", "2,3", "--ra", "1", "--dec", "2", "--position-angle", "3"]),
            "exclude each other",
        ),
        (
            vec!["--end", "1,2", "--end", "2,3"],
            "missing times of the streak; specify --start and --exposure, or --times",
        ),
        (vec!["--end", "1,2", "--end", "2,3", "--start", "2026-08-14T23:29:05Z"], "missing exposure time"),
        (
            vec!["--end", "1,2", "--end", "2,3", "--times", "2026-08-14T23:29:05Z", "2026-08-14T23:29:05Z"],
            "the second of --times is 0 s after",
        ),
        (with(&["--end", "1,2", "--end", "2,3", "--place-sigma", "5"]), "place-sigma is 5, without a unit"),
        (with(&["--end", "1,2", "--end", "2,3", "--fov", "3deg"]), "--fov has no effect"),
        (with(&["--end", "10,80", "--end", "11,80"]), "the streak is below the horizon of Rubin Observatory"),
        (with(&["--end", "1,2", "--end", "2,3", "--top", "0"]), "top is 0; allowed: 1 or more"),
        (with(&["--ra", "1", "--dec", "2", "--position-angle", "400"]), "position angle is 400"),
        (
            with(&["--ra", "1", "--dec", "2", "--position-angle", "4", "--whole-streak"]),
            "--whole-streak is given without the length of the streak; allowed: a streak of known length, with --length",
        ),
        ([vec!["--region", &region], shutter.to_vec()].concat(), "a.reg: line 2: unsupported shape 'circle'"),
        (with(&["--region", "missing.reg"]), "missing.reg"),
        ([vec!["--region", &pixels], shutter.to_vec()].concat(), "line 4: missing frame of a region in pixels"),
        ([vec!["--region", &none], shutter.to_vec()].concat(), "none.reg: number of regions is 0; allowed: 1 or more"),
    ];
    #[cfg(unix)]
    cases.extend([
        (vec!["--image", "missing.fits", "--from-pix", "1,2", "--to-pix", "3,4"], "missing.fits"),
        (vec!["--image", "missing.fits", "--from-pix", "1;2", "--to-pix", "3,4"], "pixel '1;2'; allowed: X,Y"),
    ]);
    for (words, expected) in cases {
        let (code, stdout, stderr) = run(&[&["identify"], SKY, &words]);
        assert_eq!((code, stdout.as_str()), (2, ""), "{words:?}: {stderr}");
        assert!(stderr.lines().count() == 1 && stderr.contains(expected), "{words:?}: {stderr}");
    }
}

/// One frame of Boley et al. (2021), specified by its region file and by the corner points as ends.
#[test]
fn valid_a_ds9_region_is_a_streak() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = data.join("photometry/boley2021_plaskett");
    let elements = folder.join("starlink.15JUL2021").display().to_string();
    let region = folder.join("regFiles/box-000013.reg").display().to_string();
    // Row 13 of plan.ran: STARLINK-1498 passes at 08:42:04.5.
    let sky = ["--elements", &elements, "--mpc", "658", "-q", "--start", "2021-07-16T08:41:49.5Z", "--exposure", "30s"];
    let answer = json(&[&["identify"], &sky, &["--region", &region]]);
    assert_eq!(answer["candidates"][0]["name"], "STARLINK-1498", "{answer}");
    let ends = ["--end", "325.40061,10.45796", "--end", "325.46328,10.48382"];
    let answer = json(&[&["identify"], &sky, &ends]);
    assert_eq!(answer["candidates"][0]["name"], "STARLINK-1498", "{answer}");
}

#[cfg(unix)]
#[test]
fn valid_a_frame_provides_position_and_time() {
    let Some(data) = crate::common::data_dir() else { return };
    let frame = data.join("frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz").display().to_string();
    for file in ["supgp/starlink_supgp_2020-02-23.tle", "supgp/starlink_supgp_2020-02-25.tle"] {
        let elements = data.join("tle").join(file).display().to_string();
        let sky = ["identify", "--elements", &elements, "-q", "--image", &frame];
        let (code, _, stderr) = run(&[&sky, &["--from-pix", "1,68.5", "--to-pix", "68.02,1"]]);
        assert!(code == 2 && stderr.contains("images; specify one with --hdu"), "{stderr}");
        let hdu = hdu_of_s28(&frame).to_string();
        for (from, to, outside) in [("1,68.5", "71,-2", "71,-2"), ("0.4,68.5", "68,1", "0.4,68.5")] {
            let (code, _, stderr) = run(&[&sky, &["--hdu", &hdu, "--from-pix", from, "--to-pix", to]]);
            let expected = format!(
                "HDU {hdu}: pixel {outside} is outside of the frame; allowed: X from 0.5 to 100.5, Y from 0.5 to 100.5"
            );
            assert!(code == 2 && stderr.contains(&expected), "{stderr}");
        }
        let answer = json(&[
            &sky,
            &["--hdu", &hdu, "--from-pix", "1,68.5", "--to-pix", "68.02,1", "--place-sigma", "0.13arcsec"],
        ]);
        assert_eq!(answer["candidates"][0]["name"], "STARLINK-1102", "{answer}");
        assert_eq!(answer["streak"][0]["start_utc"], "2020-03-06T00:04:15.410235Z", "{answer}");
        // OBS-LONG of this frame has the wrong sign; the site is that of DECam.
        assert_eq!(answer["provenance"]["site"]["mpc_code"], "W84", "{answer}");
    }
}

#[cfg(unix)]
fn hdu_of_s28(frame: &str) -> usize {
    let frame = streakcast::images::FrameFile::open(std::path::Path::new(frame)).unwrap();
    frame.hdus().iter().find(|hdu| hdu.name == "S28").unwrap().index
}

/// FITS file with a table of `acstools.findsat_mrt`: `id`, `endpoints` (pixels counted from 0) and `status`.
#[cfg(unix)]
fn findsat_catalogue(rows: &[(i64, [f64; 4], i64)]) -> Vec<u8> {
    let header = |cards: &[String]| {
        let mut text: String = cards.iter().map(|card| format!("{card:<80}")).collect();
        text += &format!("{:<80}", "END");
        text += &" ".repeat(text.len().next_multiple_of(2880) - text.len());
        text.into_bytes()
    };
    let card = |name: &str, value: &str| format!("{name:<8}= {value:>20}");
    let primary = header(&[card("SIMPLE", "T"), card("BITPIX", "8"), card("NAXIS", "0"), card("EXTEND", "T")]);
    let table = header(&[
        "XTENSION= 'BINTABLE'".to_owned(),
        card("BITPIX", "8"),
        card("NAXIS", "2"),
        card("NAXIS1", "56"),
        card("NAXIS2", &rows.len().to_string()),
        card("PCOUNT", "0"),
        card("GCOUNT", "1"),
        card("TFIELDS", "4"),
        "TTYPE1  = 'id      '".to_owned(),
        "TFORM1  = 'K       '".to_owned(),
        "TTYPE2  = 'endpoints'".to_owned(),
        "TFORM2  = '4D      '".to_owned(),
        "TDIM2   = '(2,2)   '".to_owned(),
        "TTYPE3  = 'status  '".to_owned(),
        "TFORM3  = 'K       '".to_owned(),
        // A column of variable length, which other programs add.
        "TTYPE4  = 'history '".to_owned(),
        "TFORM4  = '1PD(0)  '".to_owned(),
    ]);
    let mut data = Vec::new();
    for (id, ends, status) in rows {
        data.extend(id.to_be_bytes());
        ends.iter().for_each(|end| data.extend(end.to_be_bytes()));
        data.extend(status.to_be_bytes());
        data.extend([0; 8]);
    }
    data.resize(data.len().next_multiple_of(2880), 0);
    [primary, table, data].concat()
}

#[cfg(unix)]
#[test]
fn streaks_of_tables_and_detectors_are_identified() {
    use crate::common::injected::numbers;
    let folder = tempfile::TempDir::new().unwrap();
    let (frame, truth) = (path(&folder, "visit.fits"), path(&folder, "truth.csv"));
    let description = path(&folder, "wide.toml");
    let sky = crate::common::injected::unrounded()
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    std::fs::write(&description, sky).unwrap();
    let satellites = ["--shells", "starlink-gen1", "--mpc", "X05", "--quiet"];
    done(&[
        &["inject", "--synthetic", &description, "-o", &frame, "--truth", &truth, "--seeing", "90arcsec"],
        &["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"],
        &satellites,
    ]);
    let rows = records(&std::fs::read_to_string(&truth).unwrap());
    let ids = numbers(&rows, "norad_id");
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| numbers(&rows, name));
    let line = |row: usize| [0, 1, 2, 3].map(|coordinate| ends[coordinate][row]);
    let identified = |table: &str, more: &[&str]| {
        let answer = json(&[&["identify", "--streaks", table, "--top", "1"], &satellites, more]);
        let candidates = answer["candidates"].as_array().unwrap().clone();
        candidates
            .iter()
            .map(|one| (one["streak"].as_str().unwrap().to_owned(), one["norad_id"].as_f64().unwrap()))
            .collect::<Vec<_>>()
    };
    let expected: Vec<(String, f64)> = (0..ids.len()).map(|row| (format!("s{row}"), ids[row])).collect();
    // Ends in pixels, with the frame in a column; the path is relative to the table.
    let table = path(&folder, "streaks.csv");
    let row = |row: usize| {
        let [x1, y1, x2, y2] = line(row);
        format!("s{row},visit.fits,{x1},{y1},{x2},{y2}\n")
    };
    let text: String = (0..ids.len()).map(row).collect();
    std::fs::write(&table, format!("id,image,x1_pix,y1_pix,x2_pix,y2_pix\n{text}")).unwrap();
    assert_eq!(identified(&table, &[]), expected);
    // Ends on the sky without a frame.
    let sky_ends = ["ra1_deg", "dec1_deg", "ra2_deg", "dec2_deg"].map(|name| numbers(&rows, name));
    let text: String = (0..ids.len())
        .map(|row| {
            format!("s{row},{},{},{},{}\n", sky_ends[0][row], sky_ends[1][row], sky_ends[2][row], sky_ends[3][row])
        })
        .collect();
    std::fs::write(&table, format!("id,ra1_deg,dec1_deg,ra2_deg,dec2_deg\n{text}")).unwrap();
    assert_eq!(identified(&table, &["--start", "2026-08-14T23:29:05Z", "--exposure", "30s"]), expected);
    // Rows that cannot be used are left out: no ends, part of them, equal ends, outside of the frame. Lines end in the
    // frame. Names of columns may be in capitals.
    let [x1, y1, x2, y2] = line(0);
    let (fx, fy) = (x2 + 0.2 * (x2 - x1), y2 + 0.2 * (y2 - y1));
    let text = format!("long,{x1},{y1},{fx},{fy}\nempty,,,,\npart,,10,20,30\nequal,5,5,5,5\nfar,9000,9000,9100,9100\n");
    std::fs::write(&table, format!("ID,X1_PIX,y1_pix,x2_pix,Y2_PIX\n{text}")).unwrap();
    let (code, found, error) = run(&[
        &["identify", "--streaks", &table, "--image", &frame, "--top", "1", "--format", "csv"],
        &satellites[..4],
    ]);
    let found = records(&found);
    assert_eq!((code, &found[1][0], found.len()), (0, "long", 2), "{error}");
    assert!(found[1].iter().any(|cell| cell == ids[0].to_string()), "{found:?}");
    // The provenance is that of the satellites, although the last row failed.
    let (_, json, _) = run(&[
        &["identify", "--streaks", &table, "--image", &frame, "--top", "1", "--format", "json"],
        &satellites[..4],
    ]);
    let answer: Value = serde_json::from_str(&json).unwrap();
    assert!(answer["provenance"]["models"].is_array() && answer["provenance"]["band"].is_string(), "{answer}");
    for words in ["streaks without ends are left out: empty, part", "line 5: ", "line 6: "] {
        assert!(error.contains(words), "{words}: {error}");
    }
    // A cell that is not a number or a number of cells that is wrong leaves out its row, and so does a frame that is
    // missing. Of columns that differ in upper and lower case only, the one in lower case is used; others do not
    // matter.
    let text = format!("text,,1,abc,{y1},{x2},{y2},1,2\ncells,1\nmissing,no.fits,1,{x1},{y1},{x2},{y2},1,2\n");
    let text = format!("id,image,X1_PIX,x1_pix,y1_pix,x2_pix,y2_pix,SNR,snr\n{text}good,,1,{x1},{y1},{x2},{y2},1,2\n");
    std::fs::write(&table, &text).unwrap();
    let arguments = ["identify", "--streaks", &table, "--image", &frame, "--top", "1", "--format", "json"];
    let (code, found, error) = run(&[&arguments, &satellites[..4]]);
    let answer: Value = serde_json::from_str(&found).unwrap();
    assert_eq!((code, answer["candidates"][0]["norad_id"].as_f64()), (0, Some(ids[0])), "{error}");
    let streaks = answer["streaks"].as_array().unwrap();
    assert_eq!((streaks.len(), &streaks[0]["streak"]), (1, &"good".into()), "{answer}");
    assert!(streaks[0]["candidates"].as_u64() >= Some(1) && streaks[0]["unknown_probability"].is_number(), "{answer}");
    for words in [
        "line 2: x1_pix is 'abc'; allowed: -1000000 to 1000000; the streak is left out",
        "line 3: 2 cells, but 9 columns",
        "line 4: image is 'no.fits'; allowed: the name of a given frame, or a file in the folder of the table",
        "columns that are not used: X1_PIX, SNR, snr",
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
    std::fs::write(&table, text.replace("X1_PIX,x1_pix", "X1_PIX,x1_Pix")).unwrap();
    let (code, _, error) = run(&[&arguments, &satellites]);
    assert!(
        code == 2 && error.contains("columns X1_PIX and x1_Pix have the same name; allowed: one of them"),
        "{error}"
    );
    std::fs::write(&table, text.replace("id,image", "id,IMAGE").replace("SNR", "Image")).unwrap();
    let (code, _, error) = run(&[&arguments, &satellites]);
    assert!(code == 2 && error.contains("columns IMAGE and Image have the same name"), "{error}");
    // Detectors count pixels from 0. Trails that failed a test of findsat_mrt are left out.
    let [x1, y1, x2, y2] = line(0).map(|coordinate| coordinate - 1.0);
    let (astride, findsat) = (path(&folder, "streaks.txt"), path(&folder, "visit_catalog.fits"));
    let names = "#ID x_center y_center area perimeter shape_factor radius_deviation slope_angle intercept connectivity \
                 ep1_x ep1_y ep2_x ep2_y length thickness";
    let cells =
        format!(" 7 10.00 20.00 640.3 360.9 0.06 0.60 -1.40 20.00 -1 {x1:.2} {y1:.2} {x2:.2} {y2:.2} 810.0 8.0");
    std::fs::write(&astride, format!("{names}\n{cells}\n")).unwrap();
    std::fs::write(&findsat, findsat_catalogue(&[(3, [0.0, 0.0, 9.0, 9.0], 1), (7, [x1, y1, x2, y2], 2)])).unwrap();
    for table in [&astride, &findsat] {
        assert_eq!(identified(table, &["--image", &frame]), [("7".to_owned(), ids[0])]);
    }
    // Regions of DS9 in pixels and on the sky, in one file: the streak of each, and the line through both.
    let regions = path(&folder, "a.reg");
    let [from_x, from_y, to_x, to_y] = line(0);
    let [ra1, dec1, ra2, dec2] = [0, 1, 2, 3].map(|coordinate| sky_ends[coordinate][0]);
    let length = (to_x - from_x).hypot(to_y - from_y);
    let angle_deg = (to_y - from_y).atan2(to_x - from_x).to_degrees();
    let text = format!(
        "image\n# vector({from_x},{from_y},{length},{angle_deg}) text={{7}}\nicrs\nline({ra1},{dec1},{ra2},{dec2}) # text={{8}}\n"
    );
    std::fs::write(&regions, text).unwrap();
    let both = ["7", "8"].map(|name| (name.to_owned(), ids[0]));
    assert_eq!(identified(&regions, &["--image", &frame]), both);
    let (_, found, error) = run(&[
        &["identify", "--region", &regions, "--image", &frame, "--top", "1", "--format", "csv"],
        &satellites[..4],
    ]);
    assert_eq!(numbers(&records(&found), "norad_id"), [ids[0]], "{error}");
    // The line of a box that reaches beyond the frame is cut at its edges.
    let (x, y) = (from_x + 0.6 * (to_x - from_x), from_y + 0.6 * (to_y - from_y));
    let identify = |shape: &str| {
        std::fs::write(&regions, format!("image\n{shape}\n")).unwrap();
        run(&[
            &["identify", "--region", &regions, "--image", &frame, "--top", "1", "--format", "csv"],
            &satellites[..4],
        ])
    };
    let (code, found, error) = identify(&format!("box({x},{y},{},8,{angle_deg})", 1.2 * length));
    assert_eq!((code, numbers(&records(&found), "norad_id")), (0, vec![ids[0]]), "{error}");
    let (code, _, error) = identify("box(9000,9000,20,10)");
    assert!(code == 2 && error.contains("9000 is outside of the frame"), "{error}");
    // A frame in which the detector found nothing is no error.
    std::fs::write(&astride, format!("{names}\n")).unwrap();
    let (code, table, error) =
        run(&[&["identify", "--streaks", &astride, "--image", &frame, "--format", "csv"], &satellites]);
    assert_eq!((code, records(&table).len()), (1, 1), "{error}");
    for (text, words) in [
        (format!("{names}\n 7 10.00\n"), "line 2: 2 cells, but 16 columns"),
        (format!("{names}\n{}\n", cells.replace(&format!("{x1:.2}"), "abc")), "line 2: x1_pix is 'abc'; allowed"),
        ("#ID x_center y_center\n".to_owned(), "column ep1_x of ASTRiDE is missing; allowed"),
        ("x1_pix,y1_pix,x2_pix,y2_pix\n1,2,3,4,5\n".to_owned(), "line 2: 5 cells, but 4 columns"),
        ("x1_pix,y1_pix,x2_pix,y2_pix\n1,2,1e7,4\n".to_owned(), "line 2: x2_pix is '1e7'; allowed"),
        ("x1_pix,y1_pix,x2_pix,y2_pix\n900,2,990,4000\n".to_owned(), "outside of the frame; allowed"),
        ("x1_pix,y1_pix,x2_pix,y2_pix,image\n1,2,3,4,none.fits\n".to_owned(), "none.fits"),
    ] {
        std::fs::write(&astride, &text).unwrap();
        let (code, _, error) = run(&[&["identify", "--streaks", &astride, "--image", &frame], &satellites]);
        assert_eq!((code, error.trim().lines().count()), (2, 1), "{text}: {error}");
        assert!(error.contains(words), "{text}: {error}");
    }
    // The truth in the frame is a table of streaks, too.
    let named: Vec<f64> = identified(&frame, &["--image", &frame]).into_iter().map(|(_, norad_id)| norad_id).collect();
    assert!(named.len() == ids.len() && ids.iter().all(|id| named.contains(id)), "{named:?}");
    std::fs::write(&findsat, &findsat_catalogue(&[])[..2880]).unwrap();
    let (code, _, error) = run(&[&["identify", "--streaks", &findsat, "--image", &frame], &satellites]);
    assert!(code == 2 && error.contains("such as a catalog of findsat_mrt"), "{error}");
}

/// An invalid option is not an error of a row. Each frame has its own site, and rows that alternate between frames are
/// the same as rows in order.
#[cfg(unix)]
#[test]
fn options_are_checked_before_rows_and_each_frame_has_its_site() {
    use crate::common::injected::{unrounded, with_new_cards};
    let folder = tempfile::TempDir::new().unwrap();
    let [description, frame, table] = ["wide.toml", "a.fits", "streaks.csv"].map(|name| path(&folder, name));
    std::fs::write(&description, unrounded().replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")).unwrap();
    done(&[
        &["inject", "--synthetic", &description, "-o", &frame, "--seeing", "90arcsec", "--quiet", "--mpc", "X05"],
        &["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"],
        &["--shells", "starlink-gen1"],
    ]);
    let bytes = std::fs::read(&frame).unwrap();
    for (name, latitude_deg, longitude_deg) in
        [("chile.fits", "-30.2446", "-70.7494"), ("peru.fits", "-16.4", "-71.5"), ("same.fits", "-30.2446", "-70.7494")]
    {
        let cards = [("OBSGEO-B", latitude_deg), ("OBSGEO-L", longitude_deg), ("OBSGEO-H", "2600.0")];
        std::fs::write(path(&folder, name), with_new_cards(&bytes, &cards)).unwrap();
    }
    let identified = |frames: &[&str], more: &[&str]| {
        let rows: String =
            frames.iter().enumerate().map(|(row, frame)| format!("{row},{frame}.fits,10,10,300,200\n")).collect();
        std::fs::write(&table, format!("id,image,x1_pix,y1_pix,x2_pix,y2_pix\n{rows}")).unwrap();
        run(&[&["identify", "--streaks", &table, "--shells", "starlink-gen1", "--place-sigma", "2deg"], more])
    };
    let answer = |frames: &[&str], more: &[&str]| -> Value {
        let (_, found, error) = identified(frames, &[&["--format", "json"], more].concat());
        serde_json::from_str(&found).unwrap_or_else(|_| panic!("{frames:?}: {error}"))
    };
    let site = |frames: &[&str]| answer(frames, &[])["provenance"]["site"].clone();
    assert!(site(&["chile", "same"]).to_string().contains("-30.2446"));
    assert!(site(&["chile", "peru"]).is_null() && site(&["chile", "peru", "chile"]).is_null());
    // An HDU without --image is that of the frames in the table.
    let (alternating, in_order) =
        (answer(&["chile", "peru", "chile"], &["--hdu", "0"]), answer(&["chile", "chile", "peru"], &[]));
    let candidates = |answer: &Value, row: usize| answer["streaks"][row]["unknown_probability"].clone();
    assert!(candidates(&alternating, 0).is_number());
    assert_eq!(candidates(&alternating, 0), candidates(&alternating, 2));
    assert_eq!([0, 2, 1].map(|row| candidates(&alternating, row)), [0, 1, 2].map(|row| candidates(&in_order, row)));
    for (options, words) in [
        (&["--time-sigma", "0s"][..], "error: time-sigma is 0"),
        (&["--exposure", "-5s"], "error: exposure is -5 s; allowed"),
        (&["--start", "banana"], "error: invalid time 'banana'; allowed"),
        (&["--band", "banana"], "error: unknown band \"banana\""),
    ] {
        let (code, _, error) = identified(&["chile"], options);
        assert!(code == 2 && error.starts_with(words), "{options:?}: {error}");
    }
    let arguments = ["identify", "--streaks", &table, "--shells", "starlink-gen1", "--place-sigma", "banana"];
    let (code, _, error) = run(&[&arguments]);
    assert!(code == 2 && error.starts_with("error: invalid place-sigma 'banana'; allowed"), "{error}");
    let ends = ["identify", "--end", "198,7", "--end", "199,7.5", "--hdu", "0", "--shells", "starlink-gen1"];
    let (code, _, error) = run(&[&ends]);
    assert!(code == 2 && error.contains("missing frame of --hdu; specify --image"), "{error}");
}
