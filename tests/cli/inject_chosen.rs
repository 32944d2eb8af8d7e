//! `inject --streaks`: streaks that the user chooses, and their truth.

use std::fs;

use crate::common::cli::{done, path, records, run};
use crate::common::injected::{column, numbers, unrounded, values};
use streakcast::images::{FrameFile, PixelPosition, Wcs};
use tempfile::TempDir;

const ROWS: usize = 300;
const COLUMNS: usize = 400;
/// Magnitude of a star with a sum of 1 count: `zero_point_1s_mag` of 25 in 30 s, with a gain of 2.
fn zero_point() -> f64 {
    25.0 + 2.5 * (30.0f64 / 2.0).log10()
}

/// Writes a synthetic frame without streaks and returns its path.
fn plain(folder: &TempDir) -> String {
    let (description, none, output) = (path(folder, "sky.toml"), path(folder, "none.csv"), path(folder, "plain.fits"));
    fs::write(&description, unrounded()).unwrap();
    fs::write(&none, "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n-900,-900,-800,-900,30\n").unwrap();
    done(&[&["inject", "--synthetic", &description, "-o", &output, "--streaks", &none, "--exposure", "30s"], SEEING]);
    output
}

const SEEING: &[&str] = &["--seeing", "2.5arcsec", "--pixels-only", "--quiet"];

/// Injects a table into the plain frame without noise. Returns the added light and the truth.
fn injected(folder: &TempDir, table: &str, more: &[&str]) -> (Vec<f64>, Vec<csv::StringRecord>) {
    let (frame, file, output, truth) =
        (plain(folder), path(folder, "streaks.csv"), path(folder, "out.fits"), path(folder, "truth.csv"));
    fs::write(&file, table).unwrap();
    done(&[
        &["inject", "--image", &frame, "-o", &output, "--streaks", &file, "--truth", &truth, "--no-noise"],
        SEEING,
        more,
    ]);
    let added = values(&frame, 0).into_iter().zip(values(&output, 0)).map(|(old, new)| f64::from(new) - f64::from(old));
    (added.collect(), records(&fs::read_to_string(&truth).unwrap()))
}

/// Sum and centroid (FITS coordinates) of the light within a rectangle of pixels counted from 0.
fn light(added: &[f64], columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> (f64, [f64; 2]) {
    let (mut sum, mut x_sum, mut y_sum) = (0.0, 0.0, 0.0);
    for y in rows {
        for x in columns.clone() {
            let value = added[y * COLUMNS + x];
            sum += value;
            x_sum += value * (x as f64 + 1.0);
            y_sum += value * (y as f64 + 1.0);
        }
    }
    (sum, [x_sum / sum, y_sum / sum])
}

#[test]
fn verif_the_frame_has_the_flux_and_the_ends_of_the_table() {
    let folder = TempDir::new().unwrap();
    let frame = plain(&folder);
    let file = FrameFile::open(std::path::Path::new(&frame)).unwrap();
    let wcs = Wcs::from_header(file.header(0).unwrap()).unwrap();
    let sky = |x: f64, y: f64| {
        let direction = wcs.to_sky(PixelPosition::from_fits(x, y)).unwrap();
        [direction.longitude_rad().to_degrees(), direction.latitude_rad().to_degrees()]
    };
    let ([ra1, dec1], [ra2, dec2]) = (sky(240.0, 60.0), sky(360.0, 110.0));
    // Four forms of the ends in one table: cells of the other forms are empty.
    let table = format!(
        "id,magnitude,peak,x1_pix,y1_pix,x2_pix,y2_pix,ra1_deg,dec1_deg,ra2_deg,dec2_deg,x_pix,y_pix,angle_deg,length_pix\n\
         ends,11,,40,60,160,100.5,,,,,,,,\n\
         sky,12.5,,,,,,{ra1:.9},{dec1:.9},{ra2:.9},{dec2:.9},,,,\n\
         centre,12,,,,,,,,,,100,220,30,90\n\
         peak,,250,250,200,350,260,,,,,,,,\n"
    );
    let (added, truth) = injected(&folder, &table, &[]);
    assert_eq!(column(&truth, "name"), ["ends", "sky", "centre", "peak"]);
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| numbers(&truth, name));
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let expected = [
        [40.0, 60.0, 160.0, 100.5],
        [240.0, 60.0, 360.0, 110.0],
        [100.0 - 45.0 * cos, 220.0 - 45.0 * sin, 100.0 + 45.0 * cos, 220.0 + 45.0 * sin],
        [250.0, 200.0, 350.0, 260.0],
    ];
    for (number, expected) in expected.iter().enumerate() {
        for (coordinate, expected) in expected.iter().enumerate() {
            // The truth has three decimals.
            assert!((ends[coordinate][number] - expected).abs() < 1.1e-3, "{number} {coordinate}");
        }
    }
    let boxes = [(0..200, 0..150), (200..400, 0..150), (0..200, 150..300), (200..400, 150..300)];
    let found: Vec<(f64, [f64; 2])> = boxes.iter().map(|(x, y)| light(&added, x.clone(), y.clone())).collect();
    for (index, magnitude) in [(0, 11.0), (1, 12.5), (2, 12.0)] {
        let expected = 10f64.powf(-0.4 * (magnitude - zero_point()));
        assert!((found[index].0 / expected - 1.0).abs() < 1e-4, "{} {expected}", found[index].0);
    }
    for ((_, centre), ends) in found.iter().zip(expected) {
        let middle = [0.5 * (ends[0] + ends[2]), 0.5 * (ends[1] + ends[3])];
        assert!((centre[0] - middle[0]).hypot(centre[1] - middle[1]) < 5e-3, "{centre:?} {middle:?}");
    }
    let brightest = (200..400).flat_map(|x| (150..300).map(move |y| (x, y)));
    let brightest = brightest.map(|(x, y)| added[y * COLUMNS + x]).fold(0.0, f64::max);
    // The frame has single precision on a sky of a thousand counts.
    assert!((brightest / 250.0 - 1.0).abs() < 1e-4, "{brightest}");
    assert_eq!(added.len(), ROWS * COLUMNS);
    // Without a distance the light is in focus and a point.
    assert!(column(&truth, "range_km").iter().all(String::is_empty));
}

#[test]
fn verif_times_width_size_and_light_curve_of_a_row() {
    let folder = TempDir::new().unwrap();
    fs::write(path(&folder, "fading.csv"), "time_s,delta_mag\n0,0\n30,2\n").unwrap();
    let table = "id,x1_pix,y1_pix,x2_pix,y2_pix,magnitude,enter_s,exit_s,fwhm_pix,range_km,size_m,light_curve\n\
                 half,40,60,160,60,12,5,20,,,,\n\
                 wide,240,60,360,60,12,,,8,,,\n\
                 big,40,220,160,220,12,,,,0.4e3,5,\n\
                 fading,240,220,360,220,12,,,,,,fading.csv\n";
    let (added, truth) = injected(&folder, table, &[]);
    let one = 10f64.powf(-0.4 * (12.0 - zero_point()));
    let found = |x, y| light(&added, x, y);
    let half = found(0..200, 0..150).0;
    assert!((half / (0.5 * one) - 1.0).abs() < 1e-4, "{half} {one}");
    assert_eq!(column(&truth, "enter_utc")[0], "2000-01-01T12:00:05.000000Z");
    let width = numbers(&truth, "width_pix");
    assert!((width[1] - 8.0).abs() < 0.8 && width[0] < 3.5, "{width:?}");
    // 5 m at 400 km are 2.58 arcsec, as wide as the seeing.
    assert!(width[2] > width[0] + 0.5, "{width:?}");
    assert_eq!(column(&truth, "size_m"), ["", "", "5.000", ""]);
    assert_eq!(column(&truth, "range_km"), ["", "", "400.000", ""]);
    // Units that only the header of ECSV states.
    let ecsv = "# %ECSV 1.0\n# ---\n# datatype:\n\
                # - {name: x1, datatype: float64}\n# - {name: y1, datatype: float64}\n\
                # - {name: x2, datatype: float64}\n# - {name: y2, datatype: float64}\n\
                # - {name: magnitude, datatype: float64}\n\
                # - {name: range, unit: m, datatype: float64}\n# - {name: size, unit: cm, datatype: float64}\n\
                # - {name: enter, unit: min, datatype: float64}\n\
                x1 y1 x2 y2 magnitude range size enter\n40 220 160 220 12 400000 500 0.25\n";
    let (_, stated) = injected(&folder, ecsv, &[]);
    assert_eq!(column(&stated, "size_m"), ["5.000"]);
    assert_eq!(column(&stated, "range_km"), ["400.000"]);
    assert_eq!(column(&stated, "enter_utc"), ["2000-01-01T12:00:15.000000Z"]);
    // ∫ 10^(-0.8 u) du from 0 to 1, with linear magnitudes between the points of the path.
    let fading = found(200..400, 150..300).0 / one;
    let exact = (1.0 - 10f64.powf(-0.8)) / (0.8 * std::f64::consts::LN_10);
    assert!((fading / exact - 1.0).abs() < 1e-3, "{fading} {exact}");
}

#[test]
fn verif_the_truth_table_is_a_table_of_streaks() {
    let folder = TempDir::new().unwrap();
    let table = "id,x1_pix,y1_pix,x2_pix,y2_pix,magnitude\nA,40,60,160,60,12\nB,240,60,300,200,11\n";
    let (first, truth) = injected(&folder, table, &[]);
    let again = truth.iter().map(|row| row.iter().collect::<Vec<_>>().join(",")).collect::<Vec<_>>().join("\n");
    let (second, names) = injected(&folder, &again, &[]);
    assert_eq!(column(&names, "name"), ["A", "B"]);
    let difference = first.iter().zip(&second).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let peak = first.iter().copied().fold(0.0, f64::max);
    assert!(difference < 2e-3 * peak, "{difference} {peak}");
}

#[test]
fn verif_clipped_counts_are_those_that_the_frame_lacks() {
    let folder = TempDir::new().unwrap();
    let (description, table) = (path(&folder, "sky.toml"), path(&folder, "bright.csv"));
    fs::write(&description, crate::common::injected::SKY).unwrap();
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n-900,-900,-800,-900,30\n").unwrap();
    let (frame, output, truth) = (path(&folder, "plain.fits"), path(&folder, "out.fits"), path(&folder, "truth.csv"));
    done(&[&["inject", "--synthetic", &description, "-o", &frame, "--streaks", &table, "--exposure", "30s"], SEEING]);
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n60,150,340,150,3\n60,250,340,250,12\n").unwrap();
    done(&[
        &["inject", "--image", &frame, "-o", &output, "--streaks", &table, "--truth", &truth, "--no-noise"],
        SEEING,
    ]);
    let rows = records(&fs::read_to_string(&truth).unwrap());
    let added: f64 =
        values(&frame, 0).into_iter().zip(values(&output, 0)).map(|(old, new)| f64::from(new) - f64::from(old)).sum();
    let (counts, clipped) = (numbers(&rows, "counts"), numbers(&rows, "clipped_counts"));
    assert!(clipped[0] > 0.5 * counts[0] && clipped[1] == 0.0, "{clipped:?} {counts:?}");
    let expected = counts[0] + counts[1] - clipped[0];
    // Light of less than half a count in the wings is rounded.
    assert!((added / expected - 1.0).abs() < 2e-3, "{added} {expected}");
}

#[test]
fn verif_size_of_random_streaks_is_a_flag() {
    let folder = TempDir::new().unwrap();
    let description = path(&folder, "sky.toml");
    fs::write(&description, unrounded()).unwrap();
    let width = |more: &[&str]| {
        let (output, truth) = (path(&folder, "a.fits"), path(&folder, "a.csv"));
        done(&[
            &["inject", "--synthetic", &description, "-o", &output, "--truth", &truth, "--random-streaks", "1"],
            &["--magnitude", "6", "--exposure", "30s", "--streak-rate-deg-s", "1"],
            SEEING,
            more,
        ]);
        let rows = records(&fs::read_to_string(&truth).unwrap());
        (numbers(&rows, "width_pix")[0], numbers(&rows, "size_m")[0])
    };
    let (usual, point, large) = (width(&[]), width(&["--satellite-size", "0"]), width(&["--satellite-size", "8"]));
    assert_eq!([usual.1, point.1, large.1], [2.0, 0.0, 8.0]);
    assert!(point.0 < usual.0 && usual.0 < large.0 - 0.5, "{point:?} {usual:?} {large:?}");
}

#[test]
fn verif_invalid_tables_name_file_row_column_and_allowed_values() {
    let folder = TempDir::new().unwrap();
    let (frame, table, output) = (plain(&folder), path(&folder, "bad.csv"), path(&folder, "out.fits"));
    const ENDS: &str = "x1_pix,y1_pix,x2_pix,y2_pix";
    for (text, words) in [
        (format!("{ENDS},magnitude\n1,2,abc,4,9\n"), "line 2: x2_pix is 'abc'; allowed: -1000000 to 1000000"),
        (format!("{ENDS},magnitude\n1,2,nan,4,9\n"), "line 2: x2_pix is missing; allowed"),
        (format!("{ENDS},magnitude\n1,2,3,4,9\n1,2,,4,9\n"), "line 3: x2_pix is missing; allowed: x1_pix, y1_pix"),
        (format!("{ENDS},magnitude\n1,2,3,4\n"), "line 2: 4 cells, but 5 columns"),
        (format!("{ENDS},magnitud\n1,2,3,4,5\n"), "allowed: also magnitude or peak"),
        ("x,y,magnitude\n1,2,3\n".to_owned(), "allowed: x1_pix, y1_pix, x2_pix, y2_pix; ra1_deg"),
        (format!("{ENDS},magnitude,peak\n1,2,3,4,9,100\n"), "line 2: peak is '100'; allowed: no peak"),
        (
            format!("{ENDS},magnitude,image\n1,2,3,4,9,other.fits\n"),
            "line 2: image is 'other.fits'; allowed: a frame: plain",
        ),
        (format!("{ENDS},magnitude,hdu\n1,2,3,4,9,7\n"), "line 2: hdu is 7; allowed: HDU 0 of"),
        (format!("{ENDS},magnitude,size_m\n1,2,3,4,9,7\n"), "line 2: size_m is '7'; allowed: with range_km"),
        (
            format!("{ENDS},magnitude,enter_utc\n1,2,3,4,9,2026-01-01T00:00:00Z\n"),
            " s after the opening of the shutter; allowed: 0 to ",
        ),
        (
            "ra1,dec1,ra2,dec2,magnitude\n10:00:07.8,91:00:00,10:00:07,20,9\n".to_owned(),
            "line 2: dec1_deg is '91:00:00'; allowed: -90 to 90, or text such as -30d30m15s",
        ),
        (format!("{ENDS},magnitude,enter_s,exit_s\n1,2,3,4,9,20,10\n"), "line 2: exit_s is 10 s; allowed: later"),
        (format!("{ENDS},magnitude,light_curve\n1,2,3,4,9,none.csv\n"), "none.csv: light curve:"),
        (format!("{ENDS},peak\n1,2,3,4,-1\n"), "line 2: peak is '-1'; allowed: above 0, at most 1000000000000"),
        (
            format!("{},magnitude\n1,1,2,3,4,9\n", ENDS.replace("x1_pix", "X1_PIX,x1_Pix")),
            "columns X1_PIX and x1_Pix have the same name; allowed: one of them, or x1_pix",
        ),
        ("ra1_m,dec1_deg,ra2_deg,dec2_deg,magnitude\n1,2,3,4,9\n".to_owned(), "allowed: x1_pix"),
    ] {
        fs::write(&table, &text).unwrap();
        let (code, _, error) = run(&[&[
            "inject",
            "--image",
            &frame,
            "-o",
            &output,
            "--streaks",
            &table,
            "--seeing",
            "2arcsec",
            "--no-noise",
        ]]);
        assert_eq!(code, 2, "{text}");
        assert!(error.contains(words) && error.contains("csv"), "{text}: {error}");
        assert_eq!(error.trim().lines().count(), 1, "{error}");
        assert!(!std::path::Path::new(&output).exists());
    }
}

/// A table without rows is that of a frame in which nothing is to be injected. Names of columns may be in capitals.
#[test]
fn verif_tables_may_have_no_rows_and_names_in_capitals() {
    let folder = TempDir::new().unwrap();
    let (added, truth) = injected(&folder, "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n", &[]);
    assert!(added.iter().all(|added| *added == 0.0) && truth.len() == 1, "{truth:?}");
    let table = "ID,X1_PIX,Y1_Pix,x2_pix,y2_pix,MAGNITUDE\nown,40,60,160,100,11\n";
    let (added, truth) = injected(&folder, table, &[]);
    assert!(added.iter().sum::<f64>() > 0.0 && column(&truth, "name") == ["own"]);
}

/// A second injection keeps the truth of the first: HDUs with the same name have different versions.
#[test]
fn verif_each_injection_has_its_own_truth() {
    let folder = TempDir::new().unwrap();
    let [first, second, third, table] =
        ["first.fits", "second.fits", "third.fits", "a.csv"].map(|name| path(&folder, name));
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n40,60,160,100,11\n").unwrap();
    for (input, output) in [(&plain(&folder), &first), (&first, &second), (&second, &third)] {
        let flags = ["--streaks", &table, "--seeing", "2.5arcsec", "--quiet"];
        done(&[&["inject", "--image", input, "-o", output], &flags]);
    }
    let file = FrameFile::open(std::path::Path::new(&third)).unwrap();
    let version = |hdu: usize| file.header(hdu).unwrap().integer("EXTVER").unwrap_or(1);
    let found: Vec<(&str, i64)> = file.hdus()[1..].iter().map(|hdu| (hdu.name.as_str(), version(hdu.index))).collect();
    let truth = |version| [("STREAKMASK", version), ("STREAKS", version), ("STREAK_POINTS", version)];
    let expected = [truth(1), truth(2), truth(3)].concat();
    assert_eq!(found, expected);
}

/// A size without a distance has no angle.
#[test]
fn verif_the_size_of_satellites_needs_the_distance_of_each_streak() {
    let folder = TempDir::new().unwrap();
    let (frame, table, output) = (plain(&folder), path(&folder, "rows.csv"), path(&folder, "out.fits"));
    let injected = |text: &str| {
        fs::write(&table, format!("x1_pix,y1_pix,x2_pix,y2_pix,magnitude{text}")).unwrap();
        let words = ["inject", "--image", &frame, "-o", &output, "--streaks", &table, "--satellite-size", "4"];
        run(&[&words, SEEING, &["--no-noise"]])
    };
    for (text, line) in
        [("\n1,2,90,40,9\n", 2), (",fwhm_pix\n1,2,90,40,9,4\n", 2), (",range_km\n1,2,90,40,9,500\n1,9,90,49,9,\n", 3)]
    {
        let (code, _, error) = injected(text);
        let words = format!("line {line}: --satellite-size is 4 m; allowed: with range_km in each row");
        assert!(code == 2 && error.contains(&words), "{text}: {error}");
    }
    assert_eq!(injected(",range_km\n1,2,90,40,9,500\n").0, 0);
    // Streaks that are measured may have no distance.
    let words = ["measure", &output, "--streaks", &table, "--satellite-size", "4", "--seeing", "2.5arcsec"];
    let warning = "--satellite-size has no effect";
    assert!(!run(&[&words]).2.contains(warning));
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix\n1,2,90,40\n").unwrap();
    assert!(run(&[&words]).2.contains(warning));
}

/// Returns true if a position is in a polygon.
fn is_inside(polygon: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crossed =
        sides.filter(|([ax, ay], [bx, by])| (*ay > y) != (*by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax));
    crossed.count() % 2 == 1
}

#[test]
fn verif_labels_contain_the_streaks() {
    let folder = TempDir::new().unwrap();
    // The second streak leaves the frame of 400 by 300 pixels; the third is outside of it.
    let table =
        "id,magnitude,x1_pix,y1_pix,x2_pix,y2_pix\none,11,40,60,160,100.5\ntwo,11,300,200,460,330\nno,9,900,9,950,9\n";
    let (added, truth) = injected(&folder, table, &["--labels", "coco,yolo,ds9"]);
    let widths = numbers(&truth, "width_pix");
    let read = |name: &str| fs::read_to_string(path(&folder, name)).unwrap();
    let coco: serde_json::Value = serde_json::from_str(&read("out.coco.json")).unwrap();
    let image = &coco["images"][0];
    assert_eq!(
        (&image["width"], &image["height"], &image["file_name"]),
        (&400.into(), &300.into(), &"out.fits".into())
    );
    let annotations = coco["annotations"].as_array().unwrap();
    assert_eq!(annotations.iter().map(|one| one["streak"].as_str().unwrap()).collect::<Vec<_>>(), ["one", "two"]);
    assert_eq!(coco["categories"][0]["id"], annotations[0]["category_id"]);
    let pairs = |numbers: Vec<f64>| numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>();
    let yolo = read("out.txt");
    let boxes: Vec<Vec<[f64; 2]>> = yolo
        .lines()
        .map(|line| {
            let cells: Vec<f64> = line.split(' ').map(|cell| cell.parse().unwrap()).collect();
            assert_eq!((cells.len(), cells[0]), (9, 0.0), "{line}");
            assert!(cells.iter().all(|cell| (0.0..=1.0).contains(cell)), "{line}");
            pairs(cells[1..].to_vec()).into_iter().map(|[x, y]| [400.0 * x, 300.0 * y]).collect()
        })
        .collect();
    let regions = read("out.reg");
    assert!(regions.contains("\nimage\n") && regions.contains("text={one}"), "{regions}");
    let polygons: Vec<Vec<[f64; 2]>> = regions
        .lines()
        .filter_map(|line| line.strip_prefix("polygon(")?.split(')').next())
        .map(|corners| pairs(corners.split(',').map(|cell| cell.parse().unwrap()).collect()))
        .collect();
    assert_eq!((boxes.len(), polygons.len()), (2, 2));
    for (number, annotation) in annotations.iter().enumerate() {
        let segments = annotation["segmentation"].as_array().unwrap();
        assert_eq!(segments.len(), 1);
        let outline = pairs(segments[0].as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect());
        let bbox: Vec<f64> = annotation["bbox"].as_array().unwrap().iter().map(|one| one.as_f64().unwrap()).collect();
        let (mut all, mut inside, mut pixels) = (0.0, [0.0; 3], 0);
        for y in 0..ROWS {
            // The streaks are in the left and in the right half of the frame.
            for x in (0..COLUMNS).filter(|x| (*x >= 200) == (number == 1)) {
                let (light, middle) = (added[y * COLUMNS + x], [x as f64 + 0.5, y as f64 + 0.5]);
                // Regions of DS9 count from the centre of the first pixel, which is 1.
                let in_each = [
                    is_inside(&outline, middle),
                    is_inside(&boxes[number], middle),
                    is_inside(&polygons[number], [x as f64 + 1.0, y as f64 + 1.0]),
                ];
                all += light;
                pixels += usize::from(in_each[0]);
                inside.iter_mut().zip(in_each).for_each(|(sum, is_in)| *sum += if is_in { light } else { 0.0 });
                if in_each[0] {
                    let [left, low] = [bbox[0], bbox[1]];
                    assert!(
                        middle[0] > left && middle[0] < left + bbox[2] && middle[1] > low && middle[1] < low + bbox[3]
                    );
                }
            }
        }
        // A Moffat profile has some per cent of its light beyond its full width at half maximum, and a streak that
        // leaves the frame more.
        for sum in inside {
            assert!(sum > 0.85 * all && sum < all, "{number}: {sum} of {all}");
        }
        // The box contains the part of the streak in the frame.
        assert!(inside[1] > 0.999 * inside[0], "{number}: {inside:?}");
        let area = annotation["area"].as_f64().unwrap();
        assert!((area / pixels as f64 - 1.0).abs() < 0.05, "{area} {pixels}");
        assert!(area < 3.0 * widths[number] * 200.0, "{area}");
    }
    let (code, _, error) = run(&[
        &["inject", "--image", &path(&folder, "plain.fits"), "-o", &path(&folder, "x.fits")],
        &["--streaks", &path(&folder, "streaks.csv"), "--labels", "voc"],
        SEEING,
    ]);
    assert!(code == 2 && error.contains("coco, yolo, ds9"), "{error}");
    // The labels may not replace an input.
    fs::copy(path(&folder, "streaks.csv"), path(&folder, "y.txt")).unwrap();
    let (code, _, error) = run(&[
        &["inject", "--image", &path(&folder, "plain.fits"), "-o", &path(&folder, "y.fits")],
        &["--streaks", &path(&folder, "y.txt"), "--labels", "yolo"],
        SEEING,
    ]);
    assert!(code == 2 && error.contains("is also an input"), "{error}");
}
