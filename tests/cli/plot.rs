//! `streakcast plot`: PNG and SVG with their data files, plots of tables written by other verbs, and errors.

use std::fs;
use std::path::Path;

use crate::common::cli::{SKY, path, records, run};
use tempfile::{TempDir, tempdir};

const FIELD: &[&str] = &["--fov", "3.5deg"];
const EXPOSURE: &[&str] = &["--ra", "198.9", "--dec", "7.7", "--start", "2026-08-14T23:29:05Z", "--exposure", "30s"];
const SCHEDULE: &str = "exposure_id,start_utc,duration_s,ra_deg,dec_deg,band\n\
    a,2026-08-14T23:28:00Z,30,198.9,7.7,r\n\
    b,2026-08-14T23:29:05Z,30,198.9,7.7,r\n\
    c,2026-08-14T23:30:00Z,30,198.9,7.7,r\n\
    d,2026-08-15T04:10:00Z,30,0,-30,r\n\
    broken,2026-08-14T23:31:00Z,-5,198.9,7.7,r\n";

/// Writes a plot as PNG and SVG. Returns standard error.
#[track_caller]
fn drawn(folder: &TempDir, name: &str, plot: &[&[&str]], code: i32) -> String {
    let (png, svg) = (path(folder, &format!("{name}.png")), path(folder, &format!("{name}.svg")));
    let (got, stdout, stderr) = run(&[&["plot"], &plot.concat(), &["-o", &png, "-o", &svg]]);
    assert_eq!((got, stdout.as_str()), (code, ""), "{stderr}");
    let image = image::load_from_memory(&fs::read(&png).unwrap()).unwrap().to_rgb8();
    let colours: std::collections::BTreeSet<_> = image.pixels().map(|pixel| pixel.0).collect();
    assert!(image.width() > 600 && image.height() > 500 && colours.len() > 30, "{} colours", colours.len());
    svg_texts(&svg);
    stderr
}

/// Draws a plot again, and requires that its SVG equals that of the first drawing. Both formats are made of the same
/// marks, so the PNG, which takes longer, is not drawn again.
#[track_caller]
fn is_the_same_again(folder: &TempDir, first: &str, plot: &[&[&str]]) {
    let again = path(folder, "again.svg");
    let (code, stdout, stderr) = run(&[&["plot"], &plot.concat(), &["-o", &again]]);
    assert_eq!((code, stdout.as_str()), (0, ""), "{stderr}");
    let picture = |name: &str| fs::read(path(folder, &format!("{name}.svg"))).unwrap();
    assert!(picture("again") == picture(first), "{plot:?}");
}

/// Returns the texts of an SVG file. It must be well-formed and contain its font.
#[track_caller]
fn svg_texts(svg: &str) -> Vec<String> {
    let text = fs::read_to_string(svg).unwrap();
    assert!(text.contains("@font-face") && text.contains("data:font/ttf;base64,"), "no font in {svg}");
    let mut reader = quick_xml::Reader::from_str(&text);
    let mut texts = Vec::new();
    loop {
        match reader.read_event().unwrap() {
            quick_xml::events::Event::Eof => return texts,
            quick_xml::events::Event::Text(text) if !text.contains("@font-face") && !text.trim().is_empty() => {
                texts.push(text.trim().to_owned());
            }
            _ => {}
        }
    }
}

#[track_caller]
fn column(text: &str, name: &str) -> Vec<String> {
    let rows = records(text);
    let index = rows[0].iter().position(|known| known == name).unwrap_or_else(|| panic!("{name} in {:?}", rows[0]));
    rows[1..].iter().map(|row| row[index].to_owned()).collect()
}

#[track_caller]
fn fails(arguments: &[&[&str]], parts: &[&str]) {
    let (code, stdout, stderr) = run(&[&["plot"], &arguments.concat()]);
    assert_eq!((code, stdout.as_str()), (2, ""), "{stderr}");
    let errors: Vec<&str> = stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert_eq!(errors.len(), 1, "{stderr}");
    for part in parts {
        assert!(errors[0].contains(part), "'{part}' is not in: {}", errors[0]);
    }
}

fn schedule(folder: &TempDir) -> String {
    let file = path(folder, "schedule.csv");
    fs::write(&file, SCHEDULE).unwrap();
    file
}

#[test]
fn verif_a_night_has_the_numbers_of_flag() {
    let folder = tempdir().unwrap();
    let schedule = schedule(&folder);
    let arguments: &[&str] = &["--schedule", &schedule, "--limit-mag", "7"];
    drawn(&folder, "night", &[&["night"], arguments, SKY, FIELD], 0);
    let data = fs::read_to_string(path(&folder, "night-data.ecsv")).unwrap();
    let (_, flags, _) = run(&[&["flag"], arguments, SKY, FIELD, &["--format", "csv"]]);
    for name in ["exposure_id", "verdict", "n_streaks", "brightest_mag"] {
        // The invalid row has no time, and belongs to no night.
        assert_eq!(column(&data, name), column(&flags, name)[..4], "{name}");
    }
    assert!(column(&flags, "n_streaks").iter().any(|number| number != "0"), "{flags}");
    // At twilight the Sun is setting; four hours later it is near its lowest altitude.
    let sun: Vec<f64> = column(&data, "sun_altitude_deg").iter().map(|cell| cell.parse().unwrap()).collect();
    assert!(sun[0] > sun[1] && sun[1] > sun[2] && (-25.0..-8.0).contains(&sun[0]) && sun[3] < -60.0, "{sun:?}");
    let texts = svg_texts(&path(&folder, "night.svg"));
    assert!(
        texts.iter().any(|text| text.starts_with("4 exposures, ") && text.contains("1 row of the schedule is invalid")),
        "{texts:?}"
    );
    assert!(
        texts.contains(&"UTC, 2026-08-14/15".to_owned())
            && texts.iter().any(|text| text.starts_with("local mean solar time, 2026-08-14")),
        "{texts:?}"
    );

    // The saved data, and the verdicts together with their schedule, give the same plot.
    let saved = path(&folder, "night-data.ecsv");
    drawn(&folder, "again", &[&["night", "--mpc", "X05", "--limit-mag", "7", "--from", &saved]], 0);
    assert!(!Path::new(&path(&folder, "again-data.ecsv")).exists());
    let flags_file = path(&folder, "flags.csv");
    fs::write(&flags_file, &flags).unwrap();
    // A table of one night does not contain the number of the other rows of the schedule.
    let again = svg_texts(&path(&folder, "again.svg"));
    is_the_same_again(&folder, "night", &[&["night", "--from", &flags_file, "--mpc", "X05"], arguments]);
    assert!(again.iter().any(|text| text.starts_with("4 exposures, ")), "{again:?}");

    // Flags of another plan with the same identifiers are rejected, also if only a pointing is another one.
    for (column, other) in
        [("start", SCHEDULE.replace("T23:30:00Z", "T23:30:01Z")), ("declination", SCHEDULE.replace("-30,r", "-31,r"))]
    {
        let other_file = path(&folder, "other.csv");
        fs::write(&other_file, other).unwrap();
        let plot: &[&str] =
            &["night", "--from", &flags_file, "--schedule", &other_file, "--mpc", "X05", "-o", &path(&folder, "x.png")];
        let id = if column == "start" { "c" } else { "d" };
        let what = format!("the {column} of exposure {id} in the flags differs by 1.000 ");
        fails(&[plot], &[&what, "allowed: the schedule of the flags"]);
    }

    // No satellite is brighter than the limit.
    let (code, _, stderr) =
        run(&[&["plot", "night", "--night", "2026-08-20"], arguments, SKY, FIELD, &["-o", &path(&folder, "x.png")]]);
    assert!(code == 2 && stderr.contains("allowed: 2026-08-14"), "{stderr}");
}

#[test]
fn verif_an_empty_night_is_labelled() {
    let folder = tempdir().unwrap();
    let file = path(&folder, "empty.csv");
    let text = "start_utc,duration_s,verdict,n_streaks,brightest_mag\n2024-08-14T04:10:00Z,30,clear,0,\n2024-08-14T04:11:00Z,30,clear,0,\n";
    fs::write(&file, text).unwrap();
    drawn(&folder, "empty", &[&["night", "--from", &file]], 0);
    let texts = svg_texts(&path(&folder, "empty.svg"));
    assert!(texts.contains(&"no exposure of this night has a streak".to_owned()), "{texts:?}");
    // Without a site there is neither twilight nor local time.
    assert!(!texts.iter().any(|text| text.contains("local") || text.contains("twilight")), "{texts:?}");
}

#[test]
fn verif_a_field_has_the_table_of_passes() {
    let folder = tempdir().unwrap();
    drawn(&folder, "field", &[&["field"], EXPOSURE, SKY, FIELD, &["--data", &path(&folder, "field.csv")]], 0);
    let (_, passes, _) = run(&[&["passes"], EXPOSURE, SKY, FIELD, &["--format", "csv"]]);
    assert_eq!(fs::read_to_string(path(&folder, "field.csv")).unwrap(), passes);
    let names = column(&passes, "name");
    let texts = svg_texts(&path(&folder, "field.svg"));
    assert!(
        !names.is_empty()
            && texts.iter().any(|text| text.len() > 12 && names.iter().any(|name| name.starts_with(text.as_str()))),
        "{texts:?}"
    );
    assert!(
        texts.contains(&"N".to_owned()) && texts.contains(&"E".to_owned()) && texts.contains(&"0.5°".to_owned())
            || texts.contains(&"1°".to_owned()),
        "{texts:?}"
    );
    // Tables written by `passes` in any format give the same plot.
    for format in ["csv", "ecsv", "json", "jsonl"] {
        let file = path(&folder, &format!("passes.{format}"));
        run(&[&["passes"], EXPOSURE, SKY, FIELD, &["-o", &file]]);
        is_the_same_again(&folder, "field", &[&["field", "--from", &file]]);
    }
    // In the middle of a night no satellite is lit. The plot is written, with a message and exit code 1 as for
    // `passes`.
    let night: &[&str] =
        &["--ra", "75", "--dec", "-30", "--start", "2024-12-14T04:45:00Z", "--exposure", "1s", "--fov", "3arcmin"];
    let (code, ..) = run(&[&["passes"], night, SKY]);
    assert_eq!(code, 1);
    drawn(&folder, "none", &[&["field"], night, SKY], 1);
    let is_empty = || svg_texts(&path(&folder, "none.svg")).contains(&"no streak crosses this field".to_owned());
    assert!(is_empty());
    for format in ["csv", "json", "jsonl"] {
        let file = path(&folder, &format!("nothing.{format}"));
        run(&[&["passes"], night, SKY, &["-o", &file]]);
        drawn(&folder, "none", &[&["field", "--from", &file]], 1);
        assert!(is_empty());
    }
}

#[test]
fn verif_a_light_curve_agrees_with_its_pass() {
    let folder = tempdir().unwrap();
    drawn(&folder, "curve", &[&["light-curve"], EXPOSURE, SKY, FIELD, &["--limit-mag", "7", "--utc-offset", "-4"]], 0);
    let data = fs::read_to_string(path(&folder, "curve-data.ecsv")).unwrap();
    let (_, passes, _) = run(&[&["passes"], EXPOSURE, SKY, FIELD, &["--format", "csv"]]);
    let id = column(&data, "norad_id")[0].clone();
    let row = column(&passes, "norad_id").iter().position(|other| *other == id).unwrap();
    let peaks = column(&passes, "magnitude_peak");
    let number = |text: &str| text.parse::<f64>().unwrap_or(f64::INFINITY);
    assert!(peaks.iter().all(|peak| number(peak) >= number(&peaks[row])), "the brightest: {peaks:?} {row}");
    // Times of entry and exit and the magnitude at mid agree with the table of passes.
    let (utc, inside) = (column(&data, "utc"), column(&data, "in_field"));
    let first = inside.iter().position(|cell| cell == "True").unwrap();
    assert!(utc[first] >= column(&passes, "enter_utc")[row] && utc[first - 1] < column(&passes, "enter_utc")[row]);
    let mid = column(&passes, "mid_utc")[row].clone();
    let near = utc.iter().position(|moment| *moment > mid).unwrap();
    let (magnitude, expected) = (number(&column(&data, "magnitude")[near]), number(&column(&passes, "magnitude")[row]));
    // The time between two points of the track is at most a third of a second.
    assert!((magnitude - expected).abs() < 0.05, "{magnitude} {expected}");
    let texts = svg_texts(&path(&folder, "curve.svg"));
    for expected in
        ["enter", "exit", "magnitude, ±1σ", "shutter open", "limit 7.0 mag", "local time (UTC−4), 2026-08-14"]
    {
        assert!(texts.iter().any(|text| text == expected), "{expected}: {texts:?}");
    }
    // The limit is in the data.
    let again: &[&str] = &["--from", &path(&folder, "curve-data.ecsv"), "--utc-offset", "-4"];
    is_the_same_again(&folder, "curve", &[&["light-curve"], again]);
    fails(
        &[&["light-curve"], EXPOSURE, SKY, FIELD, &["--norad", "1", "-o", &path(&folder, "x.png")]],
        &["norad 1", "does not cross", "allowed: "],
    );
}

#[test]
fn verif_rates_over_the_sky_are_means_of_passes() {
    let folder = tempdir().unwrap();
    let arguments: &[&str] = &[
        "--start",
        "2026-08-14T23:29:00Z",
        "--exposure",
        "30s",
        "--nside",
        "2",
        "--repeats",
        "2",
        "--over",
        "2min",
        "--min-altitude",
        "40",
    ];
    drawn(&folder, "rate", &[&["sky-rate"], arguments, SKY, FIELD, &["--limit-mag", "5"]], 0);
    let data = fs::read_to_string(path(&folder, "rate-data.ecsv")).unwrap();
    let (all, bright) = (column(&data, "streaks_per_exposure"), column(&data, "bright_per_exposure"));
    let sum = |cells: &[String]| cells.iter().map(|cell| cell.parse::<f64>().unwrap()).sum::<f64>();
    assert!(sum(&all) > 0.0 && sum(&bright) < sum(&all), "{all:?} {bright:?}");
    // The mean of two exposures per cell is a multiple of one half.
    assert!(all.iter().all(|cell| (cell.parse::<f64>().unwrap() * 2.0).fract() == 0.0), "{all:?}");
    let again: &[&str] = &["sky-rate", "--from", &path(&folder, "rate-data.ecsv")];
    is_the_same_again(&folder, "rate", &[again]);
    let at = ["--sun-altitude-deg", "-15"];
    drawn(&folder, "sun", &[&["sky-rate"], arguments, &at, SKY, FIELD], 0);
    let data = fs::read_to_string(path(&folder, "sun-data.ecsv")).unwrap();
    let texts = data.split("\"sun_altitude_deg\":").nth(1).unwrap().split([',', '}']).next().unwrap();
    // The time is rounded to 0.1 s, in which the altitude of the Sun changes by 0.0004°.
    assert!((texts.parse::<f64>().unwrap() + 15.0).abs() < 0.001, "{texts}");
    fails(
        &[&["sky-rate"], arguments, &["--sun-altitude-deg", "85"], SKY, FIELD, &["-o", &path(&folder, "x.png")]],
        &["does not reach altitude 85 deg"],
    );
    fails(
        &[
            &["sky-rate", "--nside", "3", "--start", "2026-08-14T22:00:00Z", "--exposure", "30s"],
            SKY,
            FIELD,
            &["-o", &path(&folder, "x.png")],
        ],
        &["nside is 3", "allowed: 1, 2, 4"],
    );
}

#[test]
fn verif_trails_against_the_sun_of_a_schedule_and_of_a_grid() {
    let folder = tempdir().unwrap();
    let schedule = schedule(&folder);
    drawn(&folder, "schedule", &[&["sun-altitude", "--schedule", &schedule, "--limit-mag", "7"], SKY, FIELD], 0);
    let texts = svg_texts(&path(&folder, "schedule.svg"));
    assert!(
        texts.iter().any(|text| text.starts_with("4 exposures, ")) && texts.contains(&"brighter than 7 mag".to_owned()),
        "{texts:?}"
    );
    let grid: &[&str] =
        &["--start", "2026-08-14T21:30:00Z", "--exposure", "30s", "--step", "2h", "--min-altitude", "60"];
    drawn(&folder, "grid", &[&["sun-altitude"], grid, SKY, FIELD, &["--limit-mag", "7"]], 0);
    let data = fs::read_to_string(path(&folder, "grid-data.ecsv")).unwrap();
    let sun: Vec<f64> = column(&data, "sun_altitude_deg").iter().map(|cell| cell.parse().unwrap()).collect();
    let streaks: Vec<f64> = column(&data, "n_streaks").iter().map(|cell| cell.parse().unwrap()).collect();
    assert!(sun.iter().all(|altitude| *altitude <= 0.0) && streaks.iter().sum::<f64>() > 0.0);
    let texts = svg_texts(&path(&folder, "grid.svg")).join(" ");
    for part in ["brighter than 7 mag", "Exposures of 30 s evenly over the sky above 60°, every 120 min. All"] {
        assert!(texts.contains(part), "{part}: {texts}");
    }
    // Limit and caption are in the data.
    let again: &[&str] = &["sun-altitude", "--from", &path(&folder, "grid-data.ecsv")];
    is_the_same_again(&folder, "grid", &[again]);
    fails(
        &[&["sun-altitude", "--max-sun-altitude-deg", "-89"], grid, SKY, FIELD, &["-o", &path(&folder, "x.png")]],
        &["does not go below -89 deg", "--max-sun-altitude-deg"],
    );
    fails(&[again, &["--bin", "0", "-o", &path(&folder, "x.png")]], &["width of bins", "allowed: 0.1 to 30"]);
}

#[test]
fn verif_charts_of_maps_equal_those_of_map() {
    let folder = tempdir().unwrap();
    let model: &[&str] = &["--model", "starlink-v1.5"];
    for (name, angle) in [("sky", "--sun-altitude-deg"), ("body", "--sun-latitude-deg")] {
        let picture = path(&folder, &format!("{name}.png"));
        let (code, _, stderr) = run(&[&["plot", name], model, &[angle, "-16", "-o", &picture]]);
        assert_eq!(code, 0, "{stderr}");
        let other = path(&folder, "map.png");
        let (_, table, _) = run(&[&["map", name], model, &[angle, "-16", "--picture", &other, "--format", "ecsv"]]);
        assert!(fs::read(&picture).unwrap() == fs::read(&other).unwrap());
        assert_eq!(fs::read_to_string(path(&folder, &format!("{name}-data.ecsv"))).unwrap(), table);
    }
}

/// Magnitudes of a model, made 0.1 mag fainter: all residuals are 0.1 mag.
#[test]
fn verif_residuals_are_observed_less_computed() {
    let folder = tempdir().unwrap();
    let (_, map, _) = run(&[&[
        "map",
        "body",
        "--model",
        "starlink-v1.5",
        "--sun-latitude-deg",
        "-14",
        "--step-deg",
        "5",
        "--format",
        "csv",
    ]]);
    let mut points =
        "standard_magnitude,sun_latitude_deg,observer_longitude_deg,observer_latitude_deg,height_km\n".to_owned();
    for row in &records(&map)[1..] {
        if let Ok(magnitude) = row[2].parse::<f64>() {
            points += &format!("{},-14,{},{},550\n", magnitude + 0.1, &row[0], &row[1]);
        }
    }
    let file = path(&folder, "points.csv");
    fs::write(&file, points).unwrap();
    for plot in ["residuals", "histogram", "phase-curve"] {
        drawn(&folder, plot, &[&[plot, "--model", "starlink-v1.5", "--from", &file]], 0);
        let data = fs::read_to_string(path(&folder, &format!("{plot}-data.ecsv"))).unwrap();
        let is_curve = plot == "phase-curve";
        let texts = svg_texts(&path(&folder, &format!("{plot}.svg")));
        let title = if is_curve { "observed and computed" } else { "observed minus computed" };
        assert!(texts.iter().any(|text| text == &format!("starlink-v1.5: {title}")), "{texts:?}");
        let residuals = column(&data, "residual_mag");
        // Magnitudes of the map have three decimals.
        assert!(
            residuals.len() > 500 && residuals.iter().all(|cell| (cell.parse::<f64>().unwrap() - 0.1).abs() < 0.001)
        );
    }
    fails(
        &[&["residuals", "--model", "nonesuch", "--from", &file, "-o", &path(&folder, "x.png")]],
        &["unknown model 'nonesuch'"],
    );
    let what = ["points.csv: not a file of chains", "allowed: an ECSV file written by fit run --mcmc"];
    fails(&[&["corner", "--chains", &file, "-o", &path(&folder, "x.png")]], &what);
    let (_, list, _) = run(&[&["plot", "--list"]]);
    assert!(list.contains("output of fit reduce") && !list.contains("fit photometry"), "{list}");
}

#[test]
fn verif_invalid_input_gives_one_line_and_no_file() {
    let folder = tempdir().unwrap();
    let out = path(&folder, "x.png");
    let table = |text: &str| {
        let file = path(&folder, "table.csv");
        fs::write(&file, text).unwrap();
        file
    };
    let from = |text: &str| ["night".to_owned(), "--from".to_owned(), table(text), "-o".to_owned(), out.clone()];
    let cases: &[(&str, &[&str])] = &[
        ("", &["table.csv is empty"]),
        ("start_utc,n_streaks\n2024-08-14T00:00:00Z,1\n", &["missing column duration_s", "start_utc, n_streaks"]),
        (
            "start_utc,duration_s,verdict,n_streaks,brightest_mag\nyesterday,30,clear,0,\n",
            &["line 2", "invalid start_utc 'yesterday'", "allowed: a time"],
        ),
        (
            "start_utc,duration_s,verdict,n_streaks,brightest_mag\n2024-08-14T00:00:00Z,30,clear,many,\n",
            &["line 2", "invalid n_streaks 'many'", "a number"],
        ),
        ("start_utc,duration_s,verdict,n_streaks,brightest_mag\n", &["no row has a time"]),
        ("a,b\n1\n", &["table.csv"]),
        ("{\"flags\": 3}", &["an array 'exposures'"]),
        ("{\"flags\": [", &["not JSON"]),
    ];
    for (text, parts) in cases {
        let arguments = from(text);
        fails(&[&arguments.iter().map(String::as_str).collect::<Vec<_>>()], parts);
        assert!(!Path::new(&out).exists());
    }
    fails(&[&["night", "--from", "/nonesuch.csv", "-o", &out]], &["/nonesuch.csv"]);
    fails(&[&["night", "--from", &table("a\n1\n"), "-o", &path(&folder, "x.gif")]], &["x.gif", ".png or .svg"]);
    fails(
        &[&["night", "--from", &table("a\n1\n"), "-o", &path(&folder, "x.pdf")]],
        &["x.pdf: PDF is not supported", "rsvg-convert"],
    );
    fails(
        &[&["night", "--from", &table("a\n1\n"), "-o", &out, "--data", &path(&folder, "d.csv")]],
        &["allowed: the command without --data"],
    );
    fails(
        &[&["field"], EXPOSURE, SKY, FIELD, &["-o", &out, "--data", &path(&folder, "d.txt")]],
        &["d.txt", "the extension .ecsv"],
    );
    fails(&[&["field"], EXPOSURE, SKY, FIELD, &["-o", &out, "-o", &out]], &["is also another output"]);
    fails(
        &[&["field"], EXPOSURE, SKY, &["--fov", "180deg", "-o", &out]],
        &[
            "the field is too large for the chart",
            "extends to 90.0 deg",
            "allowed: below 75 deg (a diameter below 150 deg)",
        ],
    );
    fails(&[&["field", "--from", &table("norad_id\n1\n"), "-o", &out]], &["does not state its exposure"]);
    fails(
        &[&["light-curve", "--utc-offset", "30"], EXPOSURE, SKY, FIELD, &["-o", &out]],
        &["invalid value '30'", "--time-zone", "from -14:00 to +14:00"],
    );
    fails(
        &[&["light-curve", "--around", "2h"], EXPOSURE, SKY, FIELD, &["-o", &out]],
        &["around is 2h", "at most 10min"],
    );
    fails(&[&["sky-rate"], SKY, FIELD, &["-o", &out]], &["missing: start of the exposure (--start", "exposure time"]);
    fails(&[&["night", "-o", &out]], &["--schedule"]);
    assert!(fs::read_dir(folder.path()).unwrap().all(|file| file.unwrap().file_name() == "table.csv"));
}

#[test]
fn verif_tables_of_forecast_are_drawn() {
    let folder = tempdir().unwrap();
    let (curves, json, ecsv) = (path(&folder, "c.csv"), path(&folder, "n.json"), path(&folder, "c.ecsv"));
    let night = ["forecast", "--night", "2026-08-14", "--max-mag", "5.3", "--min-culmination", "86", "--samples", "41"];
    for (light_curves, output) in [(&curves, &json), (&ecsv, &path(&folder, "n.jsonl"))] {
        let (code, _, stderr) = run(&[&night, SKY, &["--light-curves", light_curves, "-o", output]]);
        assert_eq!(code, 0, "{stderr}");
    }
    // Tables of points, and of passes that contain points, give the same plot in each format.
    drawn(&folder, "sky", &[&["sky-chart", "--from", &curves]], 0);
    let sky = svg_texts(&path(&folder, "sky.svg"));
    for expected in ["Passes over the sky", "N", "E", "60°", "rise UTC", "10"] {
        assert!(sky.iter().any(|text| text == expected), "{expected}: {sky:?}");
    }
    // The passes of a whole night have no common sky.
    assert!(!sky.join(" ").contains("stars"), "{sky:?}");
    for file in [&ecsv, &json, &path(&folder, "n.jsonl")] {
        is_the_same_again(&folder, "sky", &[&["sky-chart", "--from", file]]);
    }
    drawn(&folder, "local", &[&["sky-chart", "--from", &curves, "--utc-offset", "-4"]], 0);
    let local = svg_texts(&path(&folder, "local.svg"));
    assert!(local.iter().any(|text| text == "rise") && !local.iter().any(|text| text == "rise UTC"), "{local:?}");
    assert!(local.join(" ").contains("Times: local time (UTC−4)."), "{local:?}");
    // A single pass is labelled in minutes, and its light curve contains the peak of the table.
    let document: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let passes = document["passes"].as_array().unwrap();
    let peak = |pass: &serde_json::Value| pass["peak_magnitude"].as_f64().unwrap();
    let brightest = passes.iter().min_by(|a, b| peak(a).total_cmp(&peak(b))).unwrap();
    let id = brightest["norad_id"].to_string();
    drawn(&folder, "one", &[&["sky-chart", "--from", &curves, "--norad", &id]], 0);
    let one = svg_texts(&path(&folder, "one.svg"));
    let clock = |name: &str| brightest[name].as_str().unwrap()[11..16].to_owned();
    let minutes = |text: &String| text.len() == 5 && (clock("rise_utc")..=clock("set_utc")).contains(text);
    assert!(one.iter().filter(|text| minutes(text)).count() > 4, "{one:?}");
    assert!(one.join(" ").contains("Stars to V = 6 mag and constellations at "), "{one:?}");
    // The finder chart is that of the brightest pass, with local times and a table.
    drawn(&folder, "finder", &[&["sky-chart", "--finder", "--from", &curves, "--time-zone", "America/Santiago"]], 0);
    let finder = svg_texts(&path(&folder, "finder.svg"));
    let name = brightest["name"].as_str().unwrap().trim_end_matches(" (synthetic)");
    for expected in [&format!("Pass of {name}"), "start", "end", "altitude", "azimuth", "magnitude"] {
        assert!(finder.iter().any(|text| text == expected), "{expected}: {finder:?}");
    }
    let joined = finder.join(" ");
    assert!(joined.contains("local time (UTC−4)") && joined.contains("The satellite is simulated."), "{finder:?}");
    is_the_same_again(&folder, "finder", &[&["sky-chart", "--finder", "--from", &json, "--time-zone", "-4"]]);
    for (file, offset, clock) in [
        (&curves, &["--time-zone", "America/New_York"][..], "local time (UTC−4), 2026-08-15"),
        (&json, &[], "local mean solar time, 2026-08-15"),
    ] {
        drawn(&folder, "curve", &[&["light-curve", "--from", file], offset], 0);
        let texts = svg_texts(&path(&folder, "curve.svg"));
        assert!(texts.iter().any(|text| text == clock), "{clock}: {texts:?}");
        assert!(texts.iter().any(|text| text.contains(" (synthetic) (NORAD ")), "{texts:?}");
        assert!(texts.join(" ").contains("Satellites of shells are simulated."), "{texts:?}");
        assert!(texts.iter().any(|text| text.contains(&format!("(NORAD {id})"))), "{texts:?}");
        assert!(texts.iter().any(|text| text == "magnitude, ±1σ") && !texts.iter().any(|text| text == "in the field"));
    }
    // Of several passes, the brightest one is drawn and the others are mentioned; a time selects another one.
    assert!(passes.len() > 1, "only one pass");
    let out = path(&folder, "chosen.svg");
    let (_, _, stderr) = run(&[&["plot", "light-curve", "--from", &curves, "-o", &out]]);
    assert!(stderr.contains(&format!("has {} such passes; the brightest is drawn", passes.len())), "{stderr}");
    let other = passes.iter().find(|pass| pass["norad_id"] != brightest["norad_id"]).unwrap();
    let at = other["culmination_utc"].as_str().unwrap();
    let (code, _, stderr) = run(&[&["plot", "light-curve", "--from", &curves, "--start", at, "-o", &out]]);
    assert!(code == 0 && !stderr.contains("such passes"), "{stderr}");
    let number = format!("(NORAD {})", other["norad_id"]);
    assert!(svg_texts(&out).iter().any(|text| text.contains(&number)), "{number}");
    let noon = ["--start", "2026-08-14T12:00:00Z"];
    fails(
        &[&["light-curve", "--from", &curves, "-o", &out], &noon],
        &["no pass of table", "one of the starts 2026-08-1"],
    );
    // A night without passes gives an empty sky chart. A light curve cannot be plotted.
    let empty = path(&folder, "empty.json");
    let (code, _, stderr) = run(&[&night[..3], &["--max-mag", "-9", "--samples", "5", "-o", &empty], SKY]);
    assert_eq!(code, 0, "{stderr}");
    drawn(&folder, "empty", &[&["sky-chart", "--from", &empty]], 0);
    assert!(svg_texts(&path(&folder, "empty.svg")).iter().any(|text| text == "no pass"));
    is_the_same_again(&folder, "empty", &[&["sky-chart", "--from", &empty, "--time-zone", "Europe/Vienna"]]);
    let out = path(&folder, "x.png");
    fails(&[&["light-curve", "--from", &empty, "-o", &out]], &["has no pass"]);
    fails(&[&["sky-chart", "--finder", "--from", &empty, "-o", &out]], &["has no pass"]);
    let table = path(&folder, "plain.csv");
    run(&[&night[..7], SKY, &["-o", &table]]);
    for plot in ["sky-chart", "light-curve"] {
        fails(&[&[plot, "--from", &table, "-o", &out]], &["no points along passes", "--light-curves FILE"]);
        fails(&[&[plot, "--from", &curves, "--norad", "25544", "-o", &out]], &["norad 25544 has no pass in table"]);
        fails(&[&[plot, "--from", &curves, "--norad", "ISS", "-o", &out]], &["'ISS'", "1 to 999999999"]);
    }
    fails(&[&["sky-chart", "-o", &out]], &["--from"]);
}

#[test]
fn verif_the_list_names_every_plot() {
    let (code, list, _) = run(&[&["plot", "--list"]]);
    assert_eq!(code, 0);
    let (_, help, _) = run(&[&["plot", "--help"]]);
    let named: Vec<String> = column(&list, "plot");
    let commands =
        help.lines().skip_while(|line| !line.starts_with("Commands:")).skip(1).take_while(|line| !line.is_empty());
    // Long descriptions continue on indented lines.
    let commands = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let commands: Vec<&str> =
        commands.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert_eq!(named, commands);
}

/// Nights are named by the civil date of their evening, also beyond the date line.
#[test]
fn nights_have_the_date_of_the_time_zone() {
    let folder = tempdir().unwrap();
    let file = path(&folder, "tonga.csv");
    let rows = ["2026-08-22T08:30:00Z", "2026-08-23T08:30:00Z"].map(|start| format!("{start},30,clear,0,\n"));
    fs::write(&file, format!("start_utc,duration_s,verdict,n_streaks,brightest_mag\n{}", rows.concat())).unwrap();
    let site: &[&str] = &["--lat", "-21.2", "--lon", "-175.2"];
    let nights: [(&[&str], [&str; 2]); 2] =
        [(&["--time-zone", "Pacific/Tongatapu"], ["2026-08-22", "2026-08-23"]), (&[], ["2026-08-21", "2026-08-22"])];
    for (zone, [first, last]) in nights {
        let plot = |night: &str| {
            let picture = path(&folder, "n.svg");
            let plot: &[&str] = &["plot", "night", "--from", &file, "--night", night, "-o", &picture];
            let (code, _, stderr) = run(&[plot, site, zone]);
            (code, stderr, fs::read_to_string(&picture).unwrap_or_default())
        };
        let (code, stderr, picture) = plot(last);
        assert!(code == 0 && picture.contains(&format!("Night of {last}")), "{stderr}");
        let (code, stderr, _) = plot("2026-08-20");
        assert!(code == 2 && stderr.contains(&format!("allowed: {first} to {last}, 2 nights")), "{stderr}");
    }
}

/// Plots of simulated satellites are labelled as such, with site, limit and twilight, also if plotted from a table.
#[test]
fn metadata_of_a_table_are_drawn_again() {
    let folder = tempdir().unwrap();
    let schedule = schedule(&folder);
    let arguments: &[&str] =
        &["night", "--schedule", &schedule, "--shells", "starlink-gen1", "--mpc", "X05", "--limit-mag", "6"];
    let table = path(&folder, "n.ecsv");
    let (first, again, bare) = (path(&folder, "a.svg"), path(&folder, "b.svg"), path(&folder, "c.svg"));
    let (code, _, stderr) = run(&[&["plot"], arguments, FIELD, &["-o", &first, "--data", &table]]);
    assert_eq!(code, 0, "{stderr}");
    let text = |path: &str| fs::read_to_string(path).unwrap();
    // Texts of a paragraph are lines of the picture.
    let shown = svg_texts(&first).join(" ");
    assert!(shown.contains("All satellites are simulated.") && shown.contains("limit 6 mag"), "{shown}");
    assert!(shown.contains("Verdict avoid: "), "{shown}");
    let (code, _, stderr) = run(&[&["plot", "night", "--from", &table, "-o", &again]]);
    assert_eq!(code, 0, "{stderr}");
    // Identical except for the caption: the saved data do not contain the invalid rows.
    let kept = |path: &str| {
        let of_caption = |text: &String| text.contains("of the schedule is invalid") || text.contains("simulated.");
        svg_texts(path).into_iter().filter(|text| !of_caption(text)).collect::<Vec<_>>()
    };
    let (drawn_first, drawn_again) = (kept(&first), kept(&again));
    assert!(drawn_first.iter().all(|one| drawn_again.contains(one)), "{drawn_first:?} {drawn_again:?}");
    assert!(drawn_again.iter().any(|one| one.contains("Rubin Observatory")), "{drawn_again:?}");
    assert!(text(&again).contains("All satellites are simulated."));
    // Without a site, twilight and local time cannot be drawn, and a message is printed.
    let stripped: String = text(&table)
        .lines()
        .filter(|line| !line.contains("\"site\"") && !line.contains("# site"))
        .fold(String::new(), |all, line| all + line + "\n");
    let without = path(&folder, "w.csv");
    fs::write(
        &without,
        stripped.lines().filter(|line| !line.starts_with('#')).fold(String::new(), |all, line| all + line + "\n"),
    )
    .unwrap();
    let (code, _, stderr) = run(&[&["plot", "night", "--from", &without, "-o", &bare]]);
    assert!(code == 0 && stderr.contains("no site is given, and the table has none"), "{stderr}");
}

/// Rates over right ascension and declination: all directions visible from the site, means over the dark hours, and the
/// same plot from the table.
#[test]
fn verif_the_rate_over_right_ascension_and_declination() {
    let folder = tempdir().unwrap();
    let arguments: &[&str] = &[
        "sky-rate",
        "--equatorial",
        "--night",
        "2026-08-14",
        "--exposure",
        "30s",
        "--nside",
        "2",
        "--step",
        "1h",
        "--min-altitude",
        "40",
        "--shells",
        "starlink-gen1",
        "--mpc",
        "X05",
    ];
    drawn(&folder, "stars", &[arguments, FIELD], 0);
    let data = fs::read_to_string(path(&folder, "stars-data.ecsv")).unwrap();
    let numbers = |name: &str| column(&data, name).iter().map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>();
    let (dec, exposures, rate) = (numbers("dec_deg"), numbers("exposures"), numbers("streaks_per_exposure"));
    // At latitude -30.2, altitudes above 40 deg have declinations between -80 and +20 deg, and cell centres up to half
    // a cell of 29 deg more.
    assert!(dec.iter().all(|dec| *dec < 20.0 + 15.0), "{dec:?}");
    // Every exposure of every dark hour is in one cell: the total is the number of times multiplied by the number of
    // cells above 40 deg.
    let all: f64 = exposures.iter().sum();
    let above = 12.0;
    assert!(all % above == 0.0 && all >= 5.0 * above, "{all}");
    assert!(rate.iter().zip(&exposures).all(|(rate, n)| (rate * n - (rate * n).round()).abs() < 1e-3 * n));
    // A repeated night counts once, and the exposure time may be set in a configuration file.
    let config = path(&folder, "config.toml");
    fs::write(&config, "exposure = \"30s\"\n").unwrap();
    let night: Vec<&str> = arguments.iter().copied().filter(|word| !["--exposure", "30s"].contains(word)).collect();
    drawn(&folder, "configured", &[&night[..], FIELD, &["--night", "2026-08-14", "--config", &config]], 0);
    // The provenance names the file.
    let configured = fs::read_to_string(path(&folder, "configured-data.ecsv")).unwrap();
    let rows = |data: &str| data.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    assert_eq!(rows(&configured), rows(&data));
    let again: &[&str] = &["sky-rate", "--from", &path(&folder, "stars-data.ecsv")];
    is_the_same_again(&folder, "stars", &[again]);
    let x = path(&folder, "x.png");
    for (text, part) in [
        (vec!["--equatorial", "--exposure", "30s"], "--night"),
        (vec!["--equatorial", "--night", "2026-08-14", "--repeats", "3", "--exposure", "30s"], "--repeats"),
        (
            vec!["--equatorial", "--night", "2026-12-21", "--exposure", "30s", "--max-sun-altitude-deg", "-80"],
            "does not reach altitude -80 deg",
        ),
        (
            vec!["--equatorial", "--night", "2026-08-14", "--exposure", "30s", "--nside", "2", "--min-altitude", "80"],
            "no cell of nside 2 has its centre above 80 deg",
        ),
    ] {
        fails(&[&["sky-rate"], &text[..], SKY, FIELD, &["-o", &x]], &[part]);
    }
}

/// Size, resolution and metadata of a picture drawn from a table.
#[test]
fn verif_pictures_have_sizes_and_contain_their_provenance() {
    let folder = tempdir().unwrap();
    let (table, png, svg) = (path(&folder, "passes.ecsv"), path(&folder, "sized.png"), path(&folder, "sized.svg"));
    run(&[&["passes"], EXPOSURE, SKY, FIELD, &["-o", &table]]);
    let plot: &[&str] = &["plot", "field", "--from", &table, "--size", "8x5in", "--dpi", "150", "-o", &png, "-o", &svg];
    let (code, _, stderr) = run(&[plot]);
    assert_eq!(code, 0, "{stderr}");
    let reader = png::Decoder::new(std::io::BufReader::new(fs::File::open(&png).unwrap())).read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.width, info.height), (1200, 750));
    // 150 dots per inch of 0.0254 m.
    assert_eq!(info.pixel_dims.unwrap().xppu, 5906);
    let text = |keyword: &str| {
        let chunk = info.utf8_text.iter().find(|chunk| chunk.keyword == keyword).unwrap();
        chunk.get_text().unwrap()
    };
    assert_eq!(text("Software"), format!("streakcast {}", env!("CARGO_PKG_VERSION")));
    assert_eq!(text("Description"), "Streaks in the field, exposure of 30 s");
    let provenance: serde_json::Value = serde_json::from_str(&text("Provenance")).unwrap();
    assert_eq!(provenance["options"]["exposure_s"], 30.0);
    assert_eq!(provenance["site"]["mpc_code"], "X05");
    let svg = fs::read_to_string(&svg).unwrap();
    assert!(svg.starts_with("<svg width=\"8in\" height=\"5in\" "));
    let inside = svg.split("<metadata><![CDATA[").nth(1).unwrap().split("]]></metadata>").next().unwrap();
    let inside: serde_json::Value = serde_json::from_str(inside).unwrap();
    assert_eq!((&inside["Provenance"], &inside["Description"]), (&provenance, &text("Description").into()));
    assert!(svg.contains("Rubin Observatory, 2026-08-14 23:29:05 to 23:29:35 UTC"));
    let out = path(&folder, "x.png");
    for (flags, part) in [
        (["--size", "8x5mm"], "20x12cm"),
        (["--size", "20000x100"], "100 to 10000 pixels"),
        (["--dpi", "5"], "10..=1200"),
    ] {
        fails(&[&["field", "--from", &table, "-o", &out], &flags], &[part]);
        assert!(!Path::new(&out).exists());
    }
}
