//! `measure --streaks`: streaks of tables, with known light, in several frames.

use std::fs;

use crate::common::cli::{done, json, path, records, run};
use crate::common::injected::{column, numbers};
use tempfile::TempDir;

/// Required share of fluxes within one sigma in a large sample. In a smaller one it may differ by two standard errors.
const WITHIN_ONE_SIGMA: [f64; 2] = [0.63, 0.73];
/// Largest difference of a mean flux from the truth, in sigmas of the mean.
const MEAN_SIGMAS: f64 = 3.0;
/// Side of a frame, and distance of the streaks in it, pixels.
const SIDE: usize = 1000;
const STEP: usize = 200;
const FRAMES: usize = 8;
/// Number of streaks in a row of a frame.
const ROW: usize = SIDE / STEP;

const SKY: &str = "columns = 1000\nrows = 1000\npixel_scale_arcsec = 0.5\nzero_point_1s_mag = 25.0\n\
                   sky_mag_arcsec2 = 21.0\n[stars]\nper_megapixel = 300.0\nslope = 0.3\nbrightest_mag = 13.0\n\
                   faintest_mag = 21.0\n[detector]\ngain_e_adu = 1.5\nread_noise_e = 6.0\nbias_adu = 200.0\n";

/// A number from 0 to 1 that depends on two indices.
fn drawn(index: usize, number: usize) -> f64 {
    let mut x = (index as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (number as u64 + 1).wrapping_mul(0xd1b5_4a32_d192_ed03);
    x ^= x >> 29;
    x = x.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 32;
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// A normally distributed number.
fn normal(index: usize, number: usize) -> f64 {
    (-2.0 * (1.0 - drawn(index, number)).ln()).sqrt() * (std::f64::consts::TAU * drawn(index, number + 1)).cos()
}

/// Injects 25 streaks into each of some frames. Returns the rows of the truth, and the ends with errors of `sigma_pix`.
fn injected(folder: &TempDir, frames: usize, sigma_pix: f64) -> (Vec<csv::StringRecord>, String) {
    let (description, chosen, truth) =
        (path(folder, "sky.toml"), path(folder, "chosen.csv"), path(folder, "truth.csv"));
    fs::write(&description, SKY).unwrap();
    let mut rows = "id,image,x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n".to_owned();
    let mut ends = "id,image,x1_pix,y1_pix,x2_pix,y2_pix\n".to_owned();
    let places = (0..frames).flat_map(|frame| (0..ROW * ROW).map(move |place| (frame, place)));
    for (index, (frame, place)) in places.enumerate() {
        let [x, y] = [place % ROW, place / ROW].map(|cell| (STEP / 2 + STEP * cell) as f64);
        let (length, angle) = (60.0 + 80.0 * drawn(index, 0), std::f64::consts::TAU * drawn(index, 1));
        let (dx, dy) = (0.5 * length * angle.cos(), 0.5 * length * angle.sin());
        let name = format!("s{index},frame-{:04}.fits", frame + 1);
        let true_ends = [x - dx, y - dy, x + dx, y + dy];
        let [a, b, c, d] = true_ends;
        rows += &format!("{name},{a},{b},{c},{d},{}\n", 15.2 + 2.8 * drawn(index, 2));
        let given: Vec<String> =
            (0..4).map(|at| (true_ends[at] + sigma_pix * normal(index, 10 + 2 * at)).to_string()).collect();
        ends += &format!("{name},{}\n", given.join(","));
    }
    fs::write(&chosen, rows).unwrap();
    let output = path(folder, "");
    done(&[
        &["inject", "--synthetic", &description, "--frames", &frames.to_string(), "-o", &output, "--streaks", &chosen],
        &["--exposure", "30s", "--seeing", "1.5arcsec", "--truth", &truth, "--quiet"],
    ]);
    (records(&fs::read_to_string(truth).unwrap()), ends)
}

#[test]
fn verif_fluxes_of_tables_are_within_their_errors() {
    // Ends of the table have errors of 2 pixels, as those of detectors, or are those of the streaks.
    for (frames, sigma_pix, more) in
        [(FRAMES, 2.0, &["--place-sigma", "1arcsec"][..]), (2, 0.0, &["--seeing", "1.5arcsec"])]
    {
        let folder = TempDir::new().unwrap();
        let (truth, ends) = injected(&folder, frames, sigma_pix);
        let table = path(&folder, "trails.csv");
        fs::write(&table, ends).unwrap();
        let rows = records(&done(&[&["measure", "--streaks", &table, "--format", "csv", "--quiet"], more]));
        let streaks = column(&rows, "streak");
        assert_eq!(streaks.len(), ROW * ROW * frames);
        let (names, counts) = (column(&truth, "name"), numbers(&truth, "counts"));
        let (flux, sigma, rate) = (numbers(&rows, "flux"), numbers(&rows, "flux_sigma"), numbers(&rows, "rate"));
        let (mut within, mut deviations) = (0, 0.0);
        for (row, name) in streaks.iter().enumerate() {
            let truth = counts[names.iter().position(|found| found == name).unwrap()];
            let deviation = (flux[row] - truth) / sigma[row];
            within += usize::from(deviation.abs() < 1.0);
            deviations += deviation;
            assert!((rate[row] * 30.0 / flux[row] - 1.0).abs() < 2e-3, "{name}");
        }
        let count = streaks.len() as f64;
        let share = within as f64 / count;
        let [least, most] = WITHIN_ONE_SIGMA;
        let margin = 2.0 * (0.68 * 0.32 / count).sqrt();
        assert!((least - margin..=most + margin).contains(&share), "{sigma_pix}: {share}");
        assert!(deviations.abs() / count.sqrt() < MEAN_SIGMAS, "{sigma_pix}: {}", deviations / count);
        assert!(column(&rows, "norad_id").iter().all(String::is_empty));
        // The fitted ends are nearer to the true ones than those of the table (2.4 pixels in the median).
        let ends = |rows: &[csv::StringRecord]| ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| column(rows, name));
        let (fitted, given) = (ends(&rows), ends(&truth));
        let mut off: Vec<f64> = Vec::new();
        for (row, name) in streaks.iter().enumerate().filter(|(row, _)| !fitted[0][*row].is_empty()) {
            let place = names.iter().position(|found| found == name).unwrap();
            let apart =
                |axis: usize| fitted[axis][row].parse::<f64>().unwrap() - given[axis][place].parse::<f64>().unwrap();
            off.extend([apart(0).hypot(apart(1)), apart(2).hypot(apart(3))]);
        }
        off.sort_by(f64::total_cmp);
        assert!(off.len() as f64 > 1.8 * count && off[off.len() / 2] < 0.8, "{} {}", off.len(), off[off.len() / 2]);
        // The measured table is a table of streaks.
        let measured = path(&folder, "measured.csv");
        let again = ["measure", "--streaks", &measured, "--format", "csv", "--quiet"];
        done(&[&["measure", "--streaks", &table, "-o", &measured, "--quiet"], more]);
        let again = records(&done(&[&again, more]));
        assert_eq!(column(&again, "image"), column(&rows, "image"));
    }
}

#[test]
fn streaks_outside_of_the_frame_have_rows_with_flags() {
    let folder = TempDir::new().unwrap();
    let (truth, _) = injected(&folder, 2, 0.0);
    let frame = path(&folder, "frame-0001.fits");
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| numbers(&truth, name)[0]);
    let [x1, y1, x2, y2] = ends;
    let table = path(&folder, "edge.csv");
    let rows = format!(
        "id,norad_id,name,x1_pix,y1_pix,x2_pix,y2_pix\nwhole,44713,STARLINK-1007,{x1},{y1},{x2},{y2}\n\
         outside,,,-500,-500,-300,-200\nhalf,,,40,300,-60,310\nthrough,,,-100,{SIDE},1200,500\n\
         short,,,500,500,505,503\npoint,,,300,300,300,300\nnone,,,,,,\npart,,,,10,20,30\n"
    );
    fs::write(&table, rows).unwrap();
    let document = json(&[&["measure", &frame, "--streaks", &table, "--seeing", "1.5arcsec", "--quiet"]]);
    let rows = document["measurements"].as_array().unwrap();
    let cells = |name: &str| rows.iter().map(|row| row[name].clone()).collect::<Vec<_>>();
    assert_eq!(cells("streak"), ["whole", "outside", "half", "through", "short", "point", "none", "part"]);
    let flags: Vec<String> = cells("flags").iter().map(ToString::to_string).collect();
    for (flags, flag) in flags.iter().zip(["", "outside", "open", "open", "short", "short", "no_ends", "no_ends"]) {
        assert!(flags.contains(flag), "{flags} {flag}");
    }
    assert!(!flags[0].contains("open"), "{flags:?}");
    assert_eq!((&rows[0]["norad_id"], &rows[0]["name"]), (&44713.into(), &"STARLINK-1007".into()));
    assert_eq!(rows[0]["detected"], true);
    // Unknown values are missing, not zero or false.
    for name in ["detected", "rate", "flux", "magnitude", "limit_magnitude", "mid_utc", "range_km", "size_m"] {
        assert!(rows[1][name].is_null(), "{name}: {}", rows[1]);
    }
    assert!(rows[2]["duration_s"].as_f64().unwrap() < 15.0 && rows[2]["ends"] == 1, "{}", rows[2]);
    let row = |text: &str| format!("id,image,hdu,norad_id,x1_pix,y1_pix,x2_pix,y2_pix\n{text}\n");
    for (text, words) in [
        (row("a,none.fits,,,1,2,3,4"), "line 2: image is 'none.fits'; allowed"),
        (row("a,,7,,1,2,3,4"), "line 2: hdu is 7; allowed: HDU 0 of"),
        (row("a,,,x,1,2,3,4"), "line 2: norad_id is 'x'; allowed"),
        (row("a,,,,1,2,3,4").replace("norad_id", "enter_s").replace(",,,,1", ",,,99,1"), "enter_s is 99.000 s"),
    ] {
        fs::write(&table, &text).unwrap();
        let (code, _, error) = run(&[&["measure", &frame, "--streaks", &table, "--quiet"]]);
        assert_eq!((code, error.trim().lines().count()), (2, 1), "{text}: {error}");
        assert!(error.contains(words), "{text}: {error}");
    }
    // Invalid rows are named and left out if others can be measured, and so are those of a frame that cannot be read.
    fs::write(path(&folder, "broken.fits"), "SIMPLE").unwrap();
    let text =
        format!("id,image,x1_pix,y1_pix,x2_pix,y2_pix\na,broken.fits,1,2,90,99\nb,{frame},{x1},{y1},{x2},{y2}\n");
    fs::write(&table, text).unwrap();
    let (code, found, error) = run(&[&["measure", "--streaks", &table, "--seeing", "1.5arcsec", "--format", "csv"]]);
    assert_eq!((code, column(&records(&found), "streak")), (0, vec!["b".to_owned()]), "{error}");
    assert!(error.contains("edge.csv: line 2: ") && error.contains("broken.fits"), "{error}");
    let (code, _, error) = run(&[&["measure", &path(&folder, "broken.fits"), "--streaks", &table]]);
    assert!(code == 0 && error.contains("broken.fits") && error.contains("; the frame is left out"), "{error}");
    let name = std::path::Path::new(&frame).file_name().unwrap().to_str().unwrap();
    let text = format!(
        "id,image,hdu,enter_s,x1_pix,y1_pix,x2_pix,y2_pix\na,none.fits,,,1,2,3,4\nb,,7,,1,2,90,99\nc,,,1,left,2,3,4\n\
         d,,,99,1,2,90,99\ncells,1\ngood,{name},,,{x1},{y1},{x2},{y2}\nempty,,,,,,,\n"
    );
    fs::write(&table, text).unwrap();
    let words = ["measure", &frame, "--streaks", &table, "--seeing", "1.5arcsec", "--format", "csv"];
    let (code, found, error) = run(&[&words]);
    assert_eq!((code, column(&records(&found), "streak")), (0, vec!["good".to_owned(), "empty".to_owned()]), "{error}");
    for words in [
        "edge.csv: line 6: 2 cells, but 8 columns",
        "line 4: x1_pix is 'left'; allowed: -1000000 to 1000000; the streak is left out",
        "line 2: image is 'none.fits'",
        "2 more streaks left out",
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix\n1,2,3,4\n").unwrap();
    let (code, _, error) = run(&[&["measure", "--streaks", &table, "--quiet"]]);
    assert!(code == 2 && error.contains("line 2: image is missing"), "{error}");
    let (code, _, error) = run(&[&["measure", &frame, "--place-sigma", "1arcsec"]]);
    assert!(code == 2 && error.contains("--streaks"), "{error}");
}

const SATELLITES: &[&str] = &["--shells", "starlink-gen1", "--mpc", "X05"];

/// Injects satellites into a frame of three degrees. Returns the frame and its truth.
fn wide(folder: &TempDir, name: &str, start: &str) -> (String, Vec<csv::StringRecord>) {
    let [description, frame, truth] = ["wide.toml", name, "truth.csv"].map(|name| path(folder, name));
    let sky = crate::common::injected::unrounded()
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    fs::write(&description, sky).unwrap();
    done(&[
        &["inject", "--synthetic", &description, "-o", &frame, "--truth", &truth, "--seeing", "90arcsec"],
        &["--start", start, "--exposure", "30s", "--ra", "198.9", "--dec", "7.7", "--quiet"],
        SATELLITES,
    ]);
    (frame, records(&fs::read_to_string(truth).unwrap()))
}

/// Regions of DS9 in physical pixels are those of the frame, or of the larger frame from which it was cut and binned.
#[test]
fn regions_in_physical_pixels_are_read() {
    use crate::common::injected::with_new_cards;
    let folder = TempDir::new().unwrap();
    let (frame, truth) = wide(&folder, "v.fits", "2026-08-14T23:29:05Z");
    let [regions, cut] = ["a.reg", "cut.fits"].map(|name| path(&folder, name));
    let id = column(&truth, "norad_id")[0].clone();
    let [x1, y1, x2, y2] = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| numbers(&truth, name)[0]);
    // Axis 1 is in bins of two, from column 41 on; axis 2 begins at row 11.
    let cards = [("LTM1_1", "0.5"), ("LTV1", "-19.75"), ("LTM2_2", "1.0"), ("LTV2", "-10.0")];
    fs::write(&cut, with_new_cards(&fs::read(&frame).unwrap(), &cards)).unwrap();
    for (frame, [x1, y1, x2, y2], system) in [
        (&frame, [x1, y1, x2, y2], "image"),
        (&frame, [x1, y1, x2, y2], "physical"),
        (&cut, [(x1 + 19.75) * 2.0, y1 + 10.0, (x2 + 19.75) * 2.0, y2 + 10.0], "physical"),
    ] {
        fs::write(&regions, format!("{system};line({x1},{y1},{x2},{y2}) # text={{a}}\n")).unwrap();
        for words in [&["--streaks"][..], &["--region"]] {
            let identify = ["identify", words[0], &regions, "--image", frame, "--top", "1", "--quiet"];
            let answer = json(&[&identify, SATELLITES]);
            assert_eq!(answer["candidates"][0]["norad_id"].to_string(), id, "{system} {words:?} {answer}");
        }
        let document =
            json(&[&["measure", frame, "--streaks", &regions, "--seeing", "90arcsec", "--quiet"], SATELLITES]);
        let row = &document["measurements"][0];
        assert_eq!((row["norad_id"].to_string(), row["detected"].clone()), (id.clone(), true.into()), "{system} {row}");
    }
}

/// Rows without a measurement or a satellite are left out by the verbs that read tables of `measure --streaks`, and
/// what is unknown about a satellite is not stated.
#[test]
fn tables_of_measured_streaks_serve_the_other_verbs() {
    let folder = TempDir::new().unwrap();
    let (frame, truth) = wide(&folder, "v.fits", "2026-08-14T23:29:05Z");
    let [table, measured, mask, score] = ["t.csv", "m.csv", "mask.fits", "score.csv"].map(|name| path(&folder, name));
    let id = column(&truth, "norad_id")[0].clone();
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| column(&truth, name)[0].clone()).join(",");
    let names = "id,norad_id,x1_pix,y1_pix,x2_pix,y2_pix,fwhm_pix";
    let rows =
        format!("found,,{ends},\nnamed,{id},{ends},\nelsewhere,{id},30,270,90,290,\nfar,,-500,-500,-300,-200,\n");
    fs::write(&table, format!("{names}\n{rows}")).unwrap();
    let measure = ["measure", &frame, "--streaks", &table, "--seeing", "90arcsec", "--quiet"];
    done(&[&measure, SATELLITES, &["-o", &measured]]);
    let text = fs::read_to_string(&measured).unwrap();
    let rows = records(&text);
    // The satellite that the table names has the same distance, times and magnitude as the identified one.
    for name in ["norad_id", "range_km", "predicted_magnitude", "duration_s", "magnitude"] {
        let cells = column(&rows, name);
        assert!(!cells[0].is_empty() && cells[0] == cells[1], "{name}: {cells:?}");
    }
    assert_eq!(column(&rows, "detected"), ["true", "true", "false", ""]);
    // Another streak, of an aircraft.
    let line = text.lines().find(|line| line.starts_with("found,")).unwrap();
    let unnamed = line.replacen(&format!(",{id},"), ",,", 1);
    assert!(unnamed != line);
    fs::write(&measured, format!("{text}{unnamed}\n")).unwrap();
    let given = ["--measured", measured.as_str()];
    let (code, _, stderr) = run(&[&["mask", &frame, "-o", &mask, "--seeing", "90arcsec"], SATELLITES, &given]);
    let warning = "m.csv: 1 measured streak is without a norad_id and therefore not masked: found; complete norad_id";
    assert!(code == 0 && stderr.contains(warning), "{stderr}");
    let times = ["ephemeris", "--times", "2026-08-14T23:29:20Z", "--norad", &id, "--quiet"];
    let stated = json(&[&times, SATELLITES, &given]);
    assert_eq!(stated["provenance"]["measured"]["measurements"], 2, "{}", stated["provenance"]);
    // SCORE: the two that were found, with the error of the predicted time.
    let observer = ["--observer-email", "a@b.org", "--observer-orcid", "0000-0002-1825-0097", "--instrument", "camera"];
    done(&[&measure, SATELLITES, &observer, &["--format", "score", "-o", &score]]);
    let rows = records(&fs::read_to_string(&score).unwrap());
    assert_eq!(rows.len(), 3, "{rows:?}");
    let sigmas = numbers(&rows, "observation_time_uncertainty_sec");
    assert!(sigmas.iter().all(|sigma| *sigma > 0.0 && *sigma < 9.0), "{sigmas:?}");
    // Without elements the times at the edges of the frame are unknown, and with them the magnitude of the satellite.
    let named = format!("{names}\nnamed,{id},{ends},\n");
    fs::write(&table, named).unwrap();
    let document = json(&[&measure]);
    let row = &document["measurements"][0];
    assert!(row["flags"].to_string().contains("open") && row["flux"].is_number(), "{row}");
    assert!(row["magnitude"].is_null() && row["size_m"].is_null() && row["magnitude_size_sigma"].is_null(), "{row}");
}

/// A given width is not fitted, and contains the size of the satellite.
#[test]
fn given_widths_are_used_as_they_are() {
    let folder = TempDir::new().unwrap();
    let (frame, truth) = wide(&folder, "v.fits", "2026-08-14T23:29:05Z");
    let table = path(&folder, "t.csv");
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| column(&truth, name)[0].clone()).join(",");
    let measured = |names: &str, cells: &str, more: &[&str]| {
        fs::write(&table, format!("x1_pix,y1_pix,x2_pix,y2_pix,enter_s,exit_s{names}\n{ends},10,20{cells}\n")).unwrap();
        let document = json(&[&["measure", &frame, "--streaks", &table, "--quiet"], more]);
        let row = document["measurements"][0].clone();
        (row["flux"].as_f64().unwrap(), row["flux_sigma"].as_f64().unwrap(), row["size_m"].as_f64())
    };
    let fitted = measured("", "", &[]);
    let wide = measured(",fwhm_arcsec", ",180", &[]);
    assert!(wide.0 > 1.2 * fitted.0, "{wide:?} {fitted:?}");
    let in_pixels = measured(",fwhm_pix", ",6", &[]);
    assert!((in_pixels.0 / wide.0 - 1.0).abs() < 1e-4, "{in_pixels:?} {wide:?}");
    assert_eq!(measured(",fwhm_arcsec", ",180", &["--seeing", "90arcsec"]), wide);
    // Neither the size of the model nor a given one widens the image again.
    for more in [&[][..], &["--satellite-size", "500"]] {
        let given = measured(",fwhm_arcsec", ",180", &[&["--seeing", "90arcsec"], SATELLITES, more].concat());
        assert!((given.0 / wide.0 - 1.0).abs() < 1e-9 && given.1 == wide.1 && given.2.is_none(), "{given:?} {wide:?}");
    }
    // The size at a given distance is unknown.
    assert_eq!(measured(",range_km", ",900", &["--seeing", "90arcsec"]).2, None);
    assert_eq!(measured(",range_km,size_m", ",900,3", &["--seeing", "90arcsec"]).2, Some(3.0));
}

/// Noise planes are a lower limit of the errors if they agree with the scatter of the sky; masks of known instruments
/// and inverse variances of 0 remove pixels.
#[test]
fn verif_planes_of_noise_and_quality_are_used() {
    use streakcast::images::{Header, ImageValues, NewImage, Pixels, write_frame};
    const SIDE: usize = 400;
    /// Noise of the frame, and light of the streak in a pixel of its length.
    const SIGMA: f64 = 10.0;
    let folder = TempDir::new().unwrap();
    let (frame, table) = (path(&folder, "planes.fits"), path(&folder, "ends.csv"));
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix\n41,201,361,201\n").unwrap();
    let sky = "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  = 10.0\nCRVAL2  = 20.0\nCRPIX1  = 200.5\n\
               CRPIX2  = 200.5\nCDELT1  = -0.0002777778\nCDELT2  = 0.0002777778\n";
    let light = |row: usize, column: usize| {
        let across = row as f64 - 200.0;
        let is_lit = (40..=360).contains(&column);
        if is_lit { 60.0 * (-0.5 * across * across / 1.44).exp() } else { 0.0 }
    };
    let noisy: Vec<f64> = (0..SIDE * SIDE)
        .map(|at| 100.0 + light(at / SIDE, at % SIDE) + SIGMA * normal(at / SIDE, 2 * (at % SIDE)))
        .collect();
    // Pixels that scatter less than their noise, because each is the mean of four.
    let resampled: Vec<f64> = (0..SIDE * SIDE)
        .map(|at| {
            let near = [at, at + 1, at + SIDE, at + SIDE + 1].map(|near| noisy[near.min(SIDE * SIDE - 1)]);
            near.iter().sum::<f64>() / 4.0
        })
        .collect();
    let measured = |pixels: &[f64], name: &str, cards: &str, plane: &dyn Fn(usize) -> f64| {
        let values = |values: Vec<f32>| ImageValues::new(SIDE, Pixels::F32(values.into())).unwrap();
        let science = values(pixels.iter().map(|value| *value as f32).collect());
        let more = values((0..SIDE * SIDE).map(|at| plane(at % SIDE) as f32).collect());
        let of = |more: &str| Header::from_text(&format!("{sky}{more}")).cards().to_vec();
        let header =
            of(&format!("DATE-OBS= '2024-08-14T03:30:00'\nEXPTIME = 30.0\nMAGZERO = 30.0\nGAIN    = 2.0\n{cards}"));
        let plain = of("");
        let image = |name, cards, values| NewImage { name, values, cards, rice: None };
        write_frame(std::path::Path::new(&frame), &[image("SCI", &header, &science), image(name, &plain, &more)])
            .unwrap();
        let words = ["measure", &frame, "--streaks", &table, "--seeing", "2.83arcsec", "--psf", "gaussian"];
        let (code, found, stderr) = run(&[&words, &["--format", "csv"]]);
        let rows = records(&found);
        assert_eq!((code, column(&rows, "detected")[0].as_str()), (0, "true"), "{name}: {stderr}");
        (numbers(&rows, "flux_sigma")[0], stderr)
    };
    let (usual, stated) = measured(&noisy, "NONE", "", &|_| 1.0);
    assert!(!stated.contains("noise"), "{stated}");
    // The noise of the frame, and that of a frame with 1.4 times its noise, in all three forms.
    let more = 1.4 * SIGMA;
    for (name, least, most) in [
        ("VAR", more * more, SIGMA * SIGMA),
        ("IVAR", 1.0 / (more * more), 1.0 / (SIGMA * SIGMA)),
        ("ERR", more, SIGMA),
    ] {
        let (sigma, stderr) = measured(&noisy, name, "", &|_| most);
        assert!((1.0..1.25).contains(&(sigma / usual)), "{name}: {sigma} {usual}");
        assert!(stderr.contains(&format!("({name}): 0 bad pixels")) && stderr.contains("lower limit"), "{stderr}");
        let (sigma, _) = measured(&noisy, name, "", &|_| least);
        assert!((1.2..1.6).contains(&(sigma / usual)), "{name}: {sigma} {usual}");
    }
    // Resampled pixels: the plane is that of the pixels before. Other units.
    let (correlated, _) = measured(&resampled, "NONE", "", &|_| 1.0);
    let (sigma, stderr) = measured(&resampled, "VAR", "", &|_| SIGMA * SIGMA);
    assert!(sigma == correlated && stderr.contains("times the scatter of the sky, which resampled"), "{stderr}");
    let (sigma, stderr) = measured(&noisy, "VAR", "", &|_| 40.0 * SIGMA * SIGMA);
    assert!(sigma == usual && stderr.contains("is not used: that of the sky is"), "{stderr}");
    // No information on 60 % of the columns, and on all.
    let (_, stderr) = measured(&noisy, "IVAR", "", &|column| if column < 240 { 0.0 } else { 0.01 });
    assert!(stderr.contains(&format!("(IVAR): {} bad pixels", 240 * SIDE)), "{stderr}");
    let (_, stderr) = measured(&noisy, "IVAR", "", &|_| 0.0);
    assert!(stderr.contains("(IVAR) is not used: 160000 of 160000 pixels would be bad"), "{stderr}");
    // Bits of quality: hot pixels of WFC3, among cosmic rays.
    let bits = |column: usize| if column < 100 { 16.0 } else { 8192.0 };
    let (_, stderr) = measured(&noisy, "DQ", "TELESCOP= 'HST'\nINSTRUME= 'WFC3'\n", &bits);
    assert!(stderr.contains(&format!("(DQ): {} bad pixels (HST WFC3: bits", 100 * SIDE)), "{stderr}");
    let (_, stderr) = measured(&noisy, "DQ", "", &bits);
    assert!(stderr.contains("(DQ) is not used: its bits are described neither by"), "{stderr}");
}

/// The reason why a streak in the frame is not measured does not depend on the error of its ends.
#[test]
fn short_and_masked_streaks_are_not_outside() {
    let folder = TempDir::new().unwrap();
    let description = path(&folder, "sky.toml");
    fs::write(&description, SKY).unwrap();
    let frame = path(&folder, "v.fits");
    let random = ["--random-streaks", "0", "--magnitude", "8", "--exposure", "30s", "--seeing", "1.5arcsec", "--quiet"];
    done(&[&["inject", "--synthetic", &description, "-o", &frame, "--pixels-only"], &random]);
    let mut bytes = fs::read(&frame).unwrap();
    let data = bytes.len() - (SIDE * SIDE * 4).next_multiple_of(2880);
    for row in 500..620 {
        for column in 500..620 {
            let at = data + 4 * (row * SIDE + column);
            bytes[at..at + 4].copy_from_slice(&f32::NAN.to_be_bytes());
        }
    }
    fs::write(&frame, bytes).unwrap();
    let table = path(&folder, "t.csv");
    let rows = "diagonal,250,50,260,60\nshort,250,50,256,56\nbad,530,560,590,560\nfar,-500,-500,-300,-200\n";
    fs::write(&table, format!("id,x1_pix,y1_pix,x2_pix,y2_pix\n{rows}")).unwrap();
    for sigma in [&["--place-sigma", "0.05arcsec"][..], &[]] {
        let document = json(&[&["measure", &frame, "--streaks", &table, "--seeing", "1.5arcsec", "--quiet"], sigma]);
        let rows = document["measurements"].as_array().unwrap();
        let flags: Vec<String> = rows.iter().map(|row| row["flags"].to_string()).collect();
        for (flags, (flag, is_measured)) in
            flags.iter().zip([("", true), ("short", false), ("masked", false), ("outside", false)])
        {
            assert!(flags.contains(flag), "{sigma:?} {flags} {flag}");
            let row = &rows[if is_measured { 0 } else { 1 }];
            assert_eq!(row["flux"].is_number(), is_measured, "{row}");
        }
        assert!(!flags[0].contains("short") && !flags[0].contains("outside"), "{flags:?}");
    }
    // A frame with the same name in another folder has the rows of its own table only.
    let [here, there, own] = ["a/x.fits", "b/x.fits", "a/t.csv"].map(|name| path(&folder, name));
    for part in ["a", "b"] {
        fs::create_dir(folder.path().join(part)).unwrap();
    }
    fs::copy(&frame, &here).unwrap();
    fs::copy(&frame, &there).unwrap();
    let text = "image,x1_pix,y1_pix,x2_pix,y2_pix\nx.fits,250,50,256,56\n./x.fits,250,50,256,56\n";
    fs::write(&own, text).unwrap();
    fs::write(&table, text).unwrap();
    let rows = records(&done(&[&["measure", &there, &here, "--streaks", &own, "--format", "csv", "--quiet"]]));
    assert_eq!(column(&rows, "image"), [here.clone(), here.clone()]);
    let (code, _, error) = run(&[&["measure", &there, &here, "--streaks", &table, "--quiet"]]);
    assert!(code == 2 && error.contains("line 2: image is 'x.fits'; allowed: the name of one frame"), "{error}");
    // An error of the ends far below a pixel is no error of the path.
    let tiny = ["--place-sigma", "1e-9arcsec", "--seeing", "1.5arcsec"];
    fs::write(&table, "x1_pix,y1_pix,x2_pix,y2_pix\n250,50,290,60\n").unwrap();
    done(&[&["measure", &frame, "--streaks", &table, "--quiet"], &tiny]);
}

/// A pixel of infinite value has no light, as one without a value.
#[test]
fn infinite_pixels_have_no_value() {
    let folder = TempDir::new().unwrap();
    let (frame, truth) = wide(&folder, "v.fits", "2026-08-14T23:29:05Z");
    let table = path(&folder, "t.csv");
    let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| numbers(&truth, name)[0]);
    let [x1, y1, x2, y2] = ends;
    fs::write(&table, format!("x1_pix,y1_pix,x2_pix,y2_pix\n{x1},{y1},{x2},{y2}\n")).unwrap();
    let whole = fs::read(&frame).unwrap();
    let file = streakcast::images::FrameFile::open(std::path::Path::new(&frame)).unwrap();
    let columns = file.image_size(file.images()[0]).unwrap()[1];
    // The primary image follows the header that ends with END.
    let end = whole.chunks_exact(80).position(|card| card.starts_with(b"END     ")).unwrap() * 80 + 80;
    let [x, y] = [0.5 * (x1 + x2), 0.5 * (y1 + y2)].map(|at| at as usize);
    let at = end.next_multiple_of(2880) + 4 * ((y - 1) * columns + x - 1);
    let with = |value: f32| {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_be_bytes());
        fs::write(&frame, bytes).unwrap();
        let document = json(&[&["measure", &frame, "--streaks", &table, "--seeing", "90arcsec", "--quiet"]]);
        document["measurements"][0]["flux"].as_f64().unwrap()
    };
    let [missing, infinite, negative] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(with);
    assert!(missing == infinite && missing == negative, "{missing} {infinite} {negative}");
}

/// Catalogs of detectors have no names of frames: each belongs to the frame at its place.
#[test]
fn several_tables_belong_to_the_frames_in_order_and_streaks_are_identified() {
    let folder = TempDir::new().unwrap();
    let (mut frames, mut tables, mut expected) = (Vec::new(), Vec::new(), Vec::new());
    for (number, start) in ["2026-08-14T23:29:05Z", "2026-08-14T23:31:05Z"].into_iter().enumerate() {
        let (frame, rows) = wide(&folder, &format!("v{number}.fits"), start);
        let ids = numbers(&rows, "norad_id");
        let ends = ["x1_pix", "y1_pix", "x2_pix", "y2_pix"].map(|name| column(&rows, name));
        let table = path(&folder, &format!("v{number}.csv"));
        let lines = (0..ids.len()).map(|row| {
            let cells = ends.each_ref().map(|end| end[row].clone());
            format!("v{number}-{row},{}\n", cells.join(","))
        });
        fs::write(&table, format!("id,x1_pix,y1_pix,x2_pix,y2_pix\n{}", lines.collect::<String>())).unwrap();
        expected.extend(ids.iter().enumerate().map(|(row, id)| (format!("v{number}-{row}"), *id)));
        frames.push(frame);
        tables.push(table);
    }
    let arguments = ["measure", &frames[0], &frames[1], "--streaks", &tables[0], &tables[1]];
    let document = json(&[&arguments, SATELLITES, &["--quiet"]]);
    let rows = document["measurements"].as_array().unwrap();
    let found: Vec<(String, f64)> = rows
        .iter()
        .map(|row| (row["streak"].as_str().unwrap().to_owned(), row["norad_id"].as_f64().unwrap_or_default()))
        .collect();
    assert!(!expected.is_empty());
    assert_eq!(found, expected);
    for row in rows {
        assert!(row["probability"].as_f64().unwrap() > 0.5 && row["range_km"].as_f64().unwrap() > 300.0, "{row}");
        assert!(row["predicted_magnitude"].is_number() && row["element_age_days"].is_number(), "{row}");
        // The time in the frame is that of the satellite, not that of the exposure.
        let number = |name: &str| row[name].as_f64().unwrap();
        assert!(number("duration_s") < 20.0, "{row}");
        if row["detected"] == true {
            assert!((number("magnitude") - number("predicted_magnitude")).abs() < 0.5, "{row}");
        }
    }
    // Rows without a name of the file cannot be divided among more frames.
    let (code, _, error) = run(&[&["measure", &frames[0], "--streaks", &tables[0], &tables[1], "--quiet"]]);
    assert!(code == 2 && error.contains("image is missing, with 2 tables"), "{error}");
}

/// Only the rows that name a frame which cannot be read are left out, and an invalid option is not an error of a row.
#[test]
fn rows_of_unreadable_frames_and_invalid_options_are_told_apart() {
    let folder = TempDir::new().unwrap();
    let (frame, _) = wide(&folder, "good.fits", "2026-08-14T23:29:05Z");
    fs::write(path(&folder, "bad.fits"), "no frame").unwrap();
    let table = path(&folder, "m.csv");
    let rows = "a,good.fits,10,10,90,90\nb,bad.fits,10,10,90,90\nc,,20,10,90,90\nd,./bad.fits,30,10,90,90\n";
    fs::write(&table, format!("id,image,x1_pix,y1_pix,x2_pix,y2_pix\n{rows}")).unwrap();
    let flags = ["--seeing", "90arcsec", "--format", "csv"];
    let (code, found, error) = run(&[&["measure", &frame, "--streaks", &table], &flags]);
    assert_eq!((code, column(&records(&found), "streak")), (0, vec!["a".to_owned(), "c".to_owned()]), "{error}");
    let left_out: Vec<&str> = error.lines().filter(|line| line.ends_with("; the streak is left out")).collect();
    assert!(left_out.len() == 2 && left_out[0].contains("line 3: ") && left_out[1].contains("line 5: "), "{error}");
    for (options, words) in [
        (["--gain", "-1"], "error: gain is -1 e/count; allowed"),
        (["--saturation", "0"], "error: saturation is 0; allowed"),
        (["--start", "banana"], "error: invalid time 'banana'; allowed"),
        (["--exposure", "-5s"], "error: exposure is -5 s; allowed"),
    ] {
        let (code, _, error) = run(&[&["measure", "--streaks", &table], &options]);
        assert!(code == 2 && error.starts_with(words), "{options:?}: {error}");
    }
}
