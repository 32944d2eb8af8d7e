//! `mask` on the command line: masks of injected and of real streaks, all outputs, invalid input.

use std::fs;
use std::path::Path;

use crate::common::cli::{done, path, published_constellation, run};
use crate::common::injected::{SKY, unrounded, values};
use serde_json::Value;
use streakcast::identify::parse_regions;
use streakcast::images::{Card, FrameFile, Header, ImageValues, NewImage, PixelPosition, Pixels, Wcs, write_frame};
use tempfile::TempDir;

// Required bounds, set before the first run.

/// Smallest share of the pixels of injected streaks above the noise that is masked.
const COVERED: f64 = 0.98;

const SATELLITES: &[&str] = &["--shells", "starlink-gen1", "--mpc", "X05"];
const SEEING: &[&str] = &["--seeing", "90arcsec"];

/// A wide frame with the streaks of a simulated constellation, and a mask plane with the bits STREAK and INJECTED.
fn wide(folder: &TempDir) -> String {
    let description = path(folder, "wide.toml");
    let text = unrounded()
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    fs::write(&description, text).unwrap();
    let output = path(folder, "wide.fits");
    let shot = ["--start", "2026-08-14T23:29:05Z", "--exposure", "30s", "--ra", "198.9", "--dec", "7.7"];
    done(&[&["inject", "--synthetic", &description, "-o", &output, "--quiet"], &shot, SEEING, SATELLITES]);
    output
}

fn header(file: &str, hdu: usize) -> Header {
    FrameFile::open(Path::new(file)).unwrap().header(hdu).unwrap().clone()
}

fn json(file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

/// Share of the pixels with STREAK in the mask of `inject` that a mask contains.
fn covered(frame: &str, mask: &[f32]) -> f64 {
    let bits = values(frame, 1);
    let streak: Vec<bool> = bits.iter().map(|bits| *bits as i32 & 1 == 1).collect();
    let all = streak.iter().filter(|is_streak| **is_streak).count();
    assert!(all > 100, "{all}");
    streak.iter().zip(mask).filter(|(is_streak, mask)| **is_streak && **mask > 0.0).count() as f64 / all as f64
}

#[test]
fn verif_injected_streaks_are_masked_in_all_outputs() {
    let folder = TempDir::new().unwrap();
    let frame = wide(&folder);
    let before = fs::read(&frame).unwrap();
    let [mask, regions, polygons] = ["mask.fits", "mask.reg", "mask.json"].map(|name| path(&folder, name));
    let outputs = ["-o", &mask, "--regions", &regions, "--polygons", &polygons];
    let (code, _, stderr) = run(&[&["mask", &frame], &outputs, SEEING, SATELLITES]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("masked") && stderr.contains("the frame is HDU 0"), "{stderr}");
    assert_eq!(fs::read(&frame).unwrap(), before, "the frame is not changed");

    let cards = header(&mask, 0);
    assert_eq!((cards.integer("BITPIX"), cards.text("EXTNAME").as_deref()), (Some(8), Some("MASK")));
    assert_eq!((cards.integer("MP_STREAK"), cards.integer("IMAGEHDU")), (Some(0), Some(0)));
    let pixels = values(&mask, 0);
    assert!(pixels.iter().all(|pixel| [0.0, 1.0].contains(pixel)));
    let share = covered(&frame, &pixels);
    println!("{share:.4} of the streaks is masked, {} pixels", pixels.iter().sum::<f32>());
    assert!(share >= COVERED, "{share}");

    let document = json(&polygons);
    let corridors = document["corridors"].as_array().unwrap();
    assert!(!corridors.is_empty() && document["provenance"]["options"]["coverage"] == 0.95, "{document}");
    let outlines = parse_regions("mask.reg", &fs::read_to_string(&regions).unwrap()).unwrap();
    assert_eq!(outlines.len(), corridors.len());
    // The mask has the coordinates of the frame, and the polygons contain each masked pixel.
    let wcs = Wcs::from_header(&cards).unwrap();
    assert_eq!(
        wcs.to_sky(PixelPosition { x: 20.0, y: 30.0 }),
        Wcs::from_header(&header(&frame, 0)).unwrap().to_sky(PixelPosition { x: 20.0, y: 30.0 })
    );
    let outlines: Vec<Vec<PixelPosition>> =
        outlines.iter().map(|outline| outline.iter().map(|corner| wcs.to_pixel(*corner).unwrap()).collect()).collect();
    let is_inside = |x: f64, y: f64, outline: &[PixelPosition]| {
        (0..outline.len()).all(|index| {
            let (a, b) = (outline[index], outline[(index + 1) % outline.len()]);
            let away = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
            // Rounding, and corners that are omitted because they are almost straight.
            away >= -0.3 * a.distance(b)
        })
    };
    for (index, _) in pixels.iter().enumerate().filter(|(_, pixel)| **pixel > 0.0) {
        let (x, y) = ((index % 400) as f64, (index / 400) as f64);
        // The corners are anticlockwise in pixels.
        assert!(outlines.iter().any(|outline| is_inside(x, y, outline)), "{x} {y}");
    }
    for row in corridors {
        assert!(row["s_region"].as_str().unwrap().starts_with("POLYGON ICRS "), "{row}");
        assert!(row["coverage"].as_f64().unwrap() >= 0.94 && row["origin"] == "predicted", "{row}");
    }
}

#[test]
fn verif_a_bit_is_added_to_the_mask_plane_and_other_bits_are_kept() {
    let folder = TempDir::new().unwrap();
    let frame = wide(&folder);
    let before = fs::read(&frame).unwrap();
    let [mask, copy] = ["mask.fits", "copy.fits"].map(|name| path(&folder, name));
    done(&[&["mask", &frame, "-o", &mask, "--quiet"], SEEING, SATELLITES]);
    let masked = values(&mask, 0);
    for (into, bit, number) in
        [("1", "SATELLITE", 2), ("mask", "mp_satellite", 2), ("MASK", "STREAK", 0), ("1", "6", 6)]
    {
        done(&[&["mask", &frame, "-o", &copy, "--into", into, "--bit", bit, "--quiet"], SEEING, SATELLITES]);
        let (old, new) = (values(&frame, 1), values(&copy, 1));
        for ((old, new), masked) in old.iter().zip(&new).zip(&masked) {
            let (old, new) = (*old as u8, *new as u8);
            assert_eq!(new, old | if *masked > 0.0 { 1 << number } else { 0 }, "{into} {bit}");
        }
        assert_eq!(values(&copy, 0), values(&frame, 0));
        let cards = header(&copy, 1);
        let [streak, injected, new] = ["MP_STREAK", "MP_INJECTED", "MP_SATELLITE"].map(|name| cards.integer(name));
        assert_eq!((streak, injected, new), (Some(0), Some(1), bit.to_uppercase().contains("SATELLITE").then_some(2)));
        assert!(cards.cards().iter().any(|card| card.text().contains("streakcast") && card.keyword() == "HISTORY"));
    }
    assert_eq!(fs::read(&frame).unwrap(), before, "the frame is not changed");
}

/// Writes a file with images of 40 by 60 pixels, given by name, cards and pixels.
fn written(folder: &TempDir, name: &str, images: &[(&str, String, Pixels)]) -> String {
    let file = path(folder, name);
    let images: Vec<(&str, Vec<Card>, ImageValues)> = images
        .iter()
        .map(|(name, text, pixels)| {
            let values = ImageValues::new(60, pixels.clone()).unwrap();
            (*name, Header::from_text(text).cards().to_vec(), values)
        })
        .collect();
    let images: Vec<NewImage<'_>> =
        images.iter().map(|(name, cards, values)| NewImage { name, values, cards, rice: None }).collect();
    write_frame(Path::new(&file), &images).unwrap();
    file
}

/// Cards of a chip with its centre at a right ascension in degrees.
fn chip(ra_deg: f64, version: i64) -> String {
    format!(
        "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  = {ra_deg:.4}\nCRVAL2  = 7.7\nCRPIX1  = 30.5\nCRPIX2  = 20.5\n\
         CD1_1   = -0.02\nCD1_2   = 0.0\nCD2_1   = 0.0\nCD2_2   = 0.02\nEXTVER  = {version}\n\
         DATE-OBS= '2026-08-14T23:29:05'\nTIMESYS = 'UTC'\nEXPTIME = 30.0\n"
    )
}

fn grey() -> Pixels {
    Pixels::F32((0..2400).map(|index| 100.0 + (index * 7919 % 101) as f32).collect())
}

const WIDE: &[&str] = &["--width", "10arcmin"];

#[test]
fn verif_masks_of_several_chips_have_different_versions() {
    let folder = TempDir::new().unwrap();
    let cases = [
        ([1, 2], [("MASK_SCI", Some(1)), ("MASK_SCI", Some(2))]),
        ([1, 1], [("MASK_SCI", Some(1)), ("MASK_SCI", Some(2))]),
    ];
    for (versions, expected) in cases {
        let sci = |index: usize| ("SCI", chip(198.9 + 2.0 * index as f64, versions[index]), grey());
        let frame = written(&folder, "two.fits", &[sci(0), sci(1)]);
        let mask = path(&folder, "two-mask.fits");
        done(&[&["mask", &frame, "-o", &mask, "--hdu", "0,1", "--quiet"], WIDE, SATELLITES]);
        let found = [0, 1].map(|hdu| {
            let cards = header(&mask, hdu);
            (cards.text("EXTNAME").unwrap(), cards.integer("EXTVER"), cards.integer("IMAGEHDU"))
        });
        for (hdu, ((name, version, of), expected)) in found.iter().zip(expected).enumerate() {
            assert_eq!((name.as_str(), *version, *of), (expected.0, expected.1, Some(hdu as i64)));
        }
        assert!(values(&mask, 0).iter().sum::<f32>() > 0.0, "a satellite crosses");
    }
}

/// The bits of integer planes of all types are set exactly; planes and bits that do not exist are named.
#[test]
fn verif_planes_of_all_types() {
    let folder = TempDir::new().unwrap();
    let output = path(&folder, "copy.fits");
    let mask = path(&folder, "mask.fits");
    let of = |index: usize, most: usize| index * 7919 % most;
    let planes = [
        ("DQ", Pixels::U8((0..2400).map(|index| of(index, 128) as u8).collect()), 7),
        ("FLAG", Pixels::U16((0..2400).map(|index| of(index, 32_768) as u16).collect()), 15),
        ("MASK", Pixels::I32((0..2400).map(|index| of(index, 1 << 29) as i32).collect()), 30),
    ];
    for (name, plane, bit) in planes {
        let frame = written(&folder, "frame.fits", &[("SCI", chip(198.9, 1), grey()), (name, String::new(), plane)]);
        done(&[&["mask", &frame, "-o", &mask, "--quiet"], WIDE, SATELLITES]);
        let number = bit.to_string();
        done(&[&["mask", &frame, "-o", &output, "--into", name, "--bit", &number, "--quiet"], WIDE, SATELLITES]);
        let read = |file: &str, hdu: usize| FrameFile::open(Path::new(file)).unwrap().read_rows(hdu, 0..40).unwrap();
        let (old, new, masked) = (read(&frame, 1), read(&output, 1), read(&mask, 0));
        assert!(masked.iter().sum::<f64>() > 0.0);
        for ((old, new), masked) in old.iter().zip(&new).zip(&masked) {
            assert_eq!(*new as i64, *old as i64 | if *masked > 0.0 { 1 << bit } else { 0 });
        }
        for (more, part) in [
            (["--into", name, "--bit", "31"], format!("mask bit is 31; allowed: 0 to {}", bit.min(30))),
            (["--into", name, "--bit", "STREAK"], "names no bits (MP_ keywords)".to_owned()),
            (
                ["--into", "OTHER", "--bit", "3"],
                format!("mask plane \"OTHER\" is missing; allowed: mask planes: HDU 1 ({name})"),
            ),
            (["--into", "0", "--bit", "3"], "HDU 0 is not a mask plane".to_owned()),
        ] {
            let (code, _, stderr) = run(&[&["mask", &frame, "-o", &output, "--quiet"], &more, WIDE, SATELLITES]);
            assert!(code == 2 && stderr.contains(&part), "{more:?}: {stderr}");
        }
    }
    let frame = written(&folder, "frame.fits", &[("SCI", chip(198.9, 1), grey()), ("MASK", String::new(), grey())]);
    let flags = ["--into", "MASK", "--bit", "3", "--quiet"];
    let (code, _, stderr) = run(&[&["mask", &frame, "-o", &output], &flags, WIDE, SATELLITES]);
    assert!(code == 2 && stderr.contains("not whole numbers") && stderr.contains("HDU 1"), "{stderr}");
}

#[test]
fn verif_faint_satellites_and_unknown_positions_are_counted_and_named() {
    let folder = TempDir::new().unwrap();
    let (frame, polygons) = (wide(&folder), path(&folder, "mask.json"));
    let flags = ["--polygons", &polygons, "--threshold", "100"];
    let (code, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(code == 0 && stderr.contains("0 satellites masked") && stderr.contains("too faint left out:"), "{stderr}");
    let document = json(&polygons);
    let left_out = document["left_out"].as_array().unwrap();
    assert!(document["corridors"].as_array().unwrap().is_empty());
    assert!(
        !left_out.is_empty() && left_out[0]["reason"].as_str().unwrap().starts_with("too faint: at "),
        "{document}"
    );

    let old = published_constellation(&folder, "2026-05-01T12:00:00 UTC");
    let old: Vec<&str> = old.iter().map(String::as_str).collect();
    let (code, _, stderr) = run(&[&["mask", &frame, "--polygons", &polygons, "--mpc", "X05"], SEEING, &old]);
    assert!(code == 0 && stderr.contains("of unknown position left out: STARLINK-3001"), "{stderr}");
    assert!(stderr.contains("positions unknown: the mask is incomplete"), "{stderr}");
    assert_eq!(json(&polygons)["left_out"].as_array().unwrap().len(), 4408);
}

/// Corridors of measured streaks are narrow, and contain the streaks.
#[test]
fn verif_measured_streaks_are_masked_where_they_were_found() {
    let folder = TempDir::new().unwrap();
    let frame = wide(&folder);
    let [measured, mask, narrow, polygons] =
        ["measured.csv", "mask.fits", "narrow.fits", "narrow.json"].map(|name| path(&folder, name));
    done(&[&["measure", &frame, "-o", &measured, "--quiet"], SEEING, SATELLITES]);
    done(&[&["mask", &frame, "-o", &mask, "--quiet"], SEEING, SATELLITES]);
    let flags = ["-o", &narrow, "--polygons", &polygons, "--measured", &measured];
    let (code, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(code == 0 && stderr.contains("measured) masked"), "{stderr}");
    let document = json(&polygons);
    let rows = document["corridors"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["origin"] == "measured" && row["probability"] == 1.0), "{rows:?}");
    let share = covered(&frame, &values(&narrow, 0));
    let [all, less] = [&mask, &narrow].map(|file| values(file, 0).iter().sum::<f32>());
    println!("{share:.4} of the streaks is masked, {less} of {all} pixels");
    assert!(share >= COVERED && less < all, "{share} {less} {all}");
    // Streaks of other frames are not used.
    let text = fs::read_to_string(&measured).unwrap().replace("wide.fits", "other.fits");
    fs::write(&measured, text).unwrap();
    let (_, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(stderr.contains("of other frames"), "{stderr}");
    fs::write(&measured, "norad_id,mid_utc,magnitude,magnitude_sigma\n1,2026-08-14T23:29:05Z,5,0.1\n").unwrap();
    let (code, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(code == 2 && stderr.contains("measured.csv: missing column image"), "{stderr}");
}

#[test]
fn invalid_input_is_named() {
    let folder = TempDir::new().unwrap();
    let frame = written(&folder, "frame.fits", &[("SCI", chip(198.9, 1), grey())]);
    let mask = path(&folder, "mask.fits");
    let (output, zero) = (["-o", mask.as_str()], ["--zero-point", "20"]);
    let cases: &[(&[&[&str]], &str)] = &[
        (&[SEEING, &zero], "missing output; specify -o FILE, --polygons FILE or --regions FILE"),
        (&[&output, SEEING], "frame.fits: missing zero point"),
        (&[&output, &zero], "missing seeing; specify --seeing"),
        (&[&output, WIDE, SEEING], "cannot be used with"),
        (&[&output, WIDE, &["--coverage", "1"]], "coverage is 1; allowed: 0.5 to 0.999"),
        (&[&output, SEEING, &zero, &["--threshold", "0"]], "threshold is 0; allowed: 0.01 to 100"),
        (&[&output, WIDE, &["--bit", "3"]], "--into"),
        (&[&output, WIDE, &["--into", "1", "--bit", "A B"]], "bit is 'A B'; allowed: a number, or a name"),
        (&[&output, WIDE, &["--into", "1"]], "HDU 1 is missing"),
        (&[&output, WIDE, &["--min-probability", "0"]], "min-probability is 0; allowed: above 0"),
        (&[&output, WIDE, &["--fov", "1deg"]], "--fov has no effect on mask"),
        (&[&["-o", &frame], WIDE], "is also an input"),
        (&[&["--regions", &frame], WIDE], "is also an input"),
        (&[&["-o", &format!("{mask}.gz")], WIDE], "the name of a compressed file"),
        (&[&["--polygons", &mask], WIDE], "the extension of"),
    ];
    for (flags, part) in cases {
        let (code, stdout, stderr) = run(&[&["mask", &frame], SATELLITES, &flags.concat()]);
        assert!(code == 2 && stderr.contains(part) && stdout.is_empty(), "{flags:?}: {stderr}");
        assert!(!Path::new(&mask).exists());
    }
    fs::write(path(&folder, "sky.toml"), SKY).unwrap();
    let (code, _, stderr) = run(&[&["mask", "-o", &mask], WIDE, SATELLITES]);
    assert!(code == 2 && stderr.contains("missing frames; specify FRAME..., FITS files"), "{stderr}");
}

/// The streaks of real frames are in the masks: with predicted positions, which are uncertain by more than the cutouts
/// after 11 days, and with measured ones.
#[test]
fn valid_real_streaks_are_masked() {
    let Some(data) = crate::common::data_dir() else { return };
    let folder = TempDir::new().unwrap();
    let of = |name: &str| data.join(name).display().to_string();
    /// Half width, pixels, within which the streak is searched for light, and smallest share of it that is masked.
    const SHARE: f64 = 0.95;
    /// Largest share of the pixels of a cutout that the mask of a measured streak contains.
    const LARGEST: f64 = 0.45;
    let [measured, mask, narrow] = ["measured.csv", "mask.fits", "narrow.fits"].map(|name| path(&folder, name));
    // Ends of the streaks, by hand: tests/images/streak_real.rs, and from the frame of Hyper Suprime-Cam.
    let decam = of("frames/trailblazer/cutout_c4d_200306_000415_ori.fits.fz");
    let hsc = of("frames/trailblazer/cutout_HSCA21787010.fits");
    let (starlinks, all) = (of("tle/supgp/starlink_supgp_2020-02-23.tle"), of("tle/fullcat/tle_2020-05-17.txt"));
    /// Frame, flags of satellites and of the width, name of the mask, ends of the streak, and its half width, pixels.
    type Case<'a> = (&'a str, &'a [&'a str], &'a [&'a str], &'a str, [f64; 4], f64);
    let cases: [Case<'_>; 2] = [
        (
            &decam,
            &["--elements", &starlinks, "--zero-point", "30.343"],
            &["--seeing", "1.3arcsec"],
            "MASK_S28",
            [0.0, 67.5, 70.0, -3.0],
            8.0,
        ),
        (
            &hsc,
            &[
                "--elements",
                &all,
                "--accept-bad-checksums",
                "--lat",
                "19.8255",
                "--lon",
                "-155.4765",
                "--height",
                "4163",
            ],
            &["--width", "14arcsec"],
            "MASK",
            [216.2, 0.0, 72.1, 399.0],
            18.0,
        ),
    ];
    for (frame, satellites, width, name, [x1, y1, x2, y2], half_pix) in cases {
        done(&[&["measure", frame, "-o", &measured, "--quiet"], satellites]);
        done(&[&["mask", frame, "-o", &mask, "--quiet"], satellites, width]);
        done(&[&["mask", frame, "-o", &narrow, "--measured", &measured, "--quiet"], satellites, width]);
        for (file, largest) in [(&mask, 1.0), (&narrow, LARGEST)] {
            let found = FrameFile::open(Path::new(file)).unwrap();
            let hdu = found.hdus().iter().find(|hdu| hdu.name == name).unwrap().index;
            let plane = found.read_plane(hdu).unwrap();
            let length = (x2 - x1).hypot(y2 - y1);
            let (mut of_streak, mut masked) = (0, 0);
            for row in 0..plane.rows() {
                for column in 0..plane.columns() {
                    let (x, y) = (column as f64 - x1, row as f64 - y1);
                    let (along, across) =
                        ((x * (x2 - x1) + y * (y2 - y1)) / length, (x * (y2 - y1) - y * (x2 - x1)) / length);
                    if across.abs() <= half_pix && (0.0..=length).contains(&along) {
                        of_streak += 1;
                        masked += usize::from(plane.row(row)[column] > 0.0);
                    }
                }
            }
            let share = f64::from(u32::try_from(masked).unwrap()) / f64::from(of_streak);
            let all: f32 = plane.values().iter().sum();
            let of_all = f64::from(all) / (plane.rows() * plane.columns()) as f64;
            println!("{name}: {share:.3} of the streak masked, {of_all:.3} of the pixels");
            assert!(share >= SHARE && of_all <= largest, "{name}: {share} {of_all}");
        }
    }
}
