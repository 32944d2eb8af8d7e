//! `mask` on the command line: masks of injected and of real streaks, all outputs, invalid input.

use std::fs;
use std::path::Path;

use crate::common::cli::{done, path, published_constellation, run};
use crate::common::injected::{SKY, unrounded, values};
use serde_json::Value;
use streakcast::images::{
    Card, FrameFile, Header, ImageValues, NewImage, OUTLINES, Outline, PixelPosition, Pixels, Wcs, parse_regions,
    write_frame,
};
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
    let outlines = parse_regions("mask.reg", &fs::read_to_string(&regions).unwrap(), OUTLINES).unwrap();
    assert_eq!(outlines.len(), corridors.len());
    // The mask has the coordinates of the frame, and the polygons contain each masked pixel.
    let wcs = Wcs::from_header(&cards).unwrap();
    assert_eq!(
        wcs.to_sky(PixelPosition { x: 20.0, y: 30.0 }),
        Wcs::from_header(&header(&frame, 0)).unwrap().to_sky(PixelPosition { x: 20.0, y: 30.0 })
    );
    let outlines: Vec<Vec<PixelPosition>> = outlines
        .into_iter()
        .map(|region| match region.outline {
            Outline::Sky(corners) => corners.into_iter().map(|corner| wcs.to_pixel(corner).unwrap()).collect(),
            pixels => panic!("{pixels:?}"),
        })
        .collect();
    let is_inside = |x: f64, y: f64, outline: &[PixelPosition]| {
        (0..outline.len()).all(|index| {
            let (a, b) = (outline[index], outline[(index + 1) % outline.len()]);
            let away = (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
            // Coordinates are rounded to 0.002 arcsec.
            away >= -0.001 * a.distance(b)
        })
    };
    for (index, _) in pixels.iter().enumerate().filter(|(_, pixel)| **pixel > 0.0) {
        let (x, y) = ((index % 400) as f64, (index / 400) as f64);
        // The corners are anticlockwise on the sky, and so in pixels of this frame.
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
        [("1", "SATELLITE", 2), ("streakmask", "mp_satellite", 2), ("STREAKMASK", "STREAK", 0), ("1", "6", 6)]
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

fn grey() -> Pixels<'static> {
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

/// Element sets of two lines have no names.
#[test]
fn satellites_without_names_are_named_by_their_numbers() {
    let folder = TempDir::new().unwrap();
    let (frame, mask) = (wide(&folder), path(&folder, "mask.fits"));
    let [flag, elements] = published_constellation(&folder, "2026-05-01T12:00:00 UTC");
    let text = fs::read_to_string(&elements).unwrap();
    let lines: String =
        text.lines().filter(|line| !line.starts_with("STARLINK")).map(|line| format!("{line}\n")).collect();
    fs::write(&elements, lines).unwrap();
    let (code, _, stderr) = run(&[&["mask", &frame, "-o", &mask, "--mpc", "X05", &flag, &elements], WIDE]);
    let named = stderr.split_once("the masks of ").and_then(|(_, rest)| rest.split_once(") contain the streak"));
    let numbers = named.and_then(|(names, _)| names.split_once('(')).map(|(_, numbers)| numbers);
    let first = numbers.and_then(|numbers| numbers.split(", ").next()?.parse::<u32>().ok());
    assert!(code == 0 && first.is_some(), "{stderr}");
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
    // Their masks need no zero point, which that of a predicted streak does.
    let (bytes, bare) = (fs::read(&frame).unwrap(), path(&folder, "bare"));
    fs::create_dir(&bare).unwrap();
    let bare = format!("{bare}/wide.fits");
    let keyword = bytes.windows(9).position(|bytes| bytes == b"MAGZP   =").unwrap();
    fs::write(&bare, [&bytes[..keyword], b"OTHER   =", &bytes[keyword + 9..]].concat()).unwrap();
    let before = values(&narrow, 0);
    done(&[&["mask", &bare], &flags, &["--quiet"], SEEING, SATELLITES]);
    assert!(values(&narrow, 0) == before);
    let text = fs::read_to_string(&measured).unwrap();
    let last = text.trim_end().rfind('\n').unwrap();
    fs::write(&measured, &text[..=last]).unwrap();
    let (code, _, stderr) = run(&[&["mask", &bare], &flags, SEEING, SATELLITES]);
    assert!(code == 2 && stderr.contains("missing zero point") && stderr.contains("is not measured"), "{stderr}");
    // Streaks of other frames are not used.
    fs::write(&measured, text.replace("wide.fits", "other.fits")).unwrap();
    let (_, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(stderr.contains("of other frames"), "{stderr}");
    fs::write(&measured, "norad_id,mid_utc,magnitude,magnitude_sigma\n1,2026-08-14T23:29:05Z,5,0.1\n").unwrap();
    let (code, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
    assert!(code == 2 && stderr.contains("measured.csv: missing column image"), "{stderr}");
}

/// Replaces a column of a table of measured streaks.
fn with_column(table: &str, name: &str, value: impl Fn(&str) -> String) -> String {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().unwrap();
    let index = header.split(',').position(|column| column == name).unwrap();
    let row = |line: &str| {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[index] = value(&cells[index]);
        cells.join(",")
    };
    std::iter::once(header.to_owned()).chain(lines.map(row)).map(|line| line + "\n").collect()
}

/// Rows of another night, of another HDU and beside the frame do not remove a satellite from the mask.
#[test]
fn verif_measured_streaks_that_are_not_used_leave_the_prediction() {
    let folder = TempDir::new().unwrap();
    let frame = wide(&folder);
    let [table, measured, mask, output, polygons] =
        ["table.csv", "measured.csv", "mask.fits", "output.fits", "mask.json"].map(|name| path(&folder, name));
    let (_, _, stderr) = run(&[&["measure", &frame, "-o", &table], SEEING, SATELLITES]);
    assert!(stderr.contains("companion planes, no frames: HDU 1 (STREAKMASK); no plane is used"), "{stderr}");
    done(&[&["mask", &frame, "-o", &mask, "--quiet"], SEEING, SATELLITES]);
    let good = fs::read_to_string(&table).unwrap();
    let tomorrow = |time: &str| time.replace("2026-08-14", "2026-08-15");
    let north = |dec_deg: &str| format!("{}", dec_deg.parse::<f64>().unwrap() + 10.0);
    let masked = |text: &str| {
        fs::write(&measured, text).unwrap();
        let flags = ["-o", &output, "--polygons", &polygons, "--measured", &measured];
        let (code, _, stderr) = run(&[&["mask", &frame], &flags, SEEING, SATELLITES]);
        assert_eq!(code, 0, "{stderr}");
        (values(&output, 0), stderr)
    };
    for (text, reason) in [
        (with_column(&good, "mid_utc", tomorrow), "not used, because mid_utc is not in the exposure"),
        (with_column(&good, "hdu", |_| "1".into()), "not used, because hdu is not one of the masked images"),
        (with_column(&good, "dec_deg", north), "not used, because the track does not reach the image"),
    ] {
        let (pixels, stderr) = masked(&text);
        assert!(stderr.contains(reason), "{reason}: {stderr}");
        assert!(pixels == values(&mask, 0), "{reason}");
    }
    let repeated = good.lines().filter(|line| !line.starts_with('#')).skip(1).collect::<Vec<_>>().join("\n");
    let (pixels, stderr) = masked(&format!("{good}{repeated}\n"));
    assert!(stderr.contains("not used, because there is another row of the satellite and the HDU"), "{stderr}");
    assert!(pixels == masked(&good).0);

    // The time of a measured streak includes its delay.
    let times = |late_s: &str| -> Vec<f64> {
        let late = with_column(&good, "late_s", |_| late_s.into());
        masked(&with_column(&late, "late_sigma_s", |_| "0.01".into()));
        let document = json(&polygons);
        let rows = document["corridors"].as_array().unwrap().iter().filter(|row| row["origin"] == "measured");
        let seconds = |row: &Value| row["mid_utc"].as_str().unwrap()[17..23].parse().unwrap();
        rows.map(seconds).collect()
    };
    let (on_time, late) = (times("0"), times("2"));
    assert!(!on_time.is_empty() && on_time.len() == late.len());
    assert!(on_time.iter().zip(&late).all(|(a, b)| (a - b).abs() < 1.0), "{on_time:?} {late:?}");
}

/// Appends an image of 40 by 60 integers to a file, with any BITPIX.
fn append_plane(file: &str, bits: usize, cards: &str, pixels: impl Fn(usize) -> i64) {
    let text = format!(
        "XTENSION= 'IMAGE   '\nBITPIX  = {bits:20}\nNAXIS   = {:20}\nNAXIS1  = {:20}\nNAXIS2  = {:20}\nPCOUNT  = {:20}\n\
         GCOUNT  = {:20}\nEXTNAME = 'MASK    '\n{cards}END",
        2, 60, 40, 0, 1
    );
    let mut bytes: Vec<u8> = text.lines().flat_map(|card| format!("{card:80}").into_bytes()).collect();
    bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    bytes.extend((0..2400).flat_map(|index| pixels(index).to_be_bytes()[8 - bits / 8..].to_vec()));
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    fs::write(file, [fs::read(file).unwrap(), bytes].concat()).unwrap();
}

/// Bits of 64-bit and unsigned 32-bit integers are set exactly, or the plane is rejected.
#[test]
fn verif_bits_of_large_integers() {
    let folder = TempDir::new().unwrap();
    let [mask, output] = ["mask.fits", "copy.fits"].map(|name| path(&folder, name));
    let unsigned = format!("BZERO   = {:20}\n", 1i64 << 31);
    let planes: [(usize, &str, &str, i64, &str); 5] = [
        (64, "", "40", 5, ""),
        (64, "", "52", 1 << 51, ""),
        (64, "", "3", (1 << 53) + 1, "pixel of 64 bits is 9007199254740992"),
        (64, "BZERO   = 9223372036854775808\n", "3", i64::MIN + 5, "BZERO or pixel of 64 bits is 9223372036854775808"),
        (32, &unsigned, "31", 5 - (1 << 31), ""),
    ];
    for (bits, cards, bit, pixel, rejected) in planes {
        let frame = written(&folder, "frame.fits", &[("SCI", chip(198.9, 1), grey())]);
        append_plane(&frame, bits, cards, |_| pixel);
        done(&[&["mask", &frame, "-o", &mask, "--quiet"], WIDE, SATELLITES]);
        let masked = values(&mask, 0);
        let flags = ["-o", &output, "--into", "1", "--bit", bit];
        let (code, _, stderr) = run(&[&["mask", &frame], &flags, WIDE, SATELLITES]);
        if !rejected.is_empty() {
            assert!(code == 2 && stderr.contains(rejected), "{rejected}: {stderr}");
            continue;
        }
        assert!(code == 0 && stderr.contains(&format!("; bit {bit}")), "{stderr}");
        let new = FrameFile::open(Path::new(&output)).unwrap().read_rows(1, 0..40).unwrap();
        let old = if bits == 32 { pixel + (1 << 31) } else { pixel };
        for (new, masked) in new.iter().zip(&masked) {
            assert_eq!(*new as i64, old | if *masked > 0.0 { 1 << bit.parse::<u32>().unwrap() } else { 0 });
        }
        let flags = ["-o", &output, "--into", "1", "--bit", "53"];
        let (code, _, stderr) = run(&[&["mask", &frame, "--quiet"], &flags, WIDE, SATELLITES]);
        let allowed = format!("mask bit is 53; allowed: 0 to {} in this plane", if bits == 32 { 31 } else { 52 });
        assert!(code == 2 && stderr.contains(&allowed), "{stderr}");
    }
}

/// A new name has one number in all planes of a file. Planes are checked before anything is written.
#[test]
fn verif_one_bit_for_all_planes_of_a_file() {
    let folder = TempDir::new().unwrap();
    let sci = |version: i64| ("SCI", chip(198.9, version), grey());
    let dq = |version: i64, cards: &str, used: i16| {
        let pixels = (0..2400).map(|index| if index % 100 == 0 { used } else { 0 }).collect();
        ("DQ", format!("EXTVER  = {version}\n{cards}"), Pixels::I16(pixels))
    };
    let named = |version: i64, used: i16| dq(version, "MP_BAD  = 0\n", used);
    let frame = written(&folder, "two.fits", &[sci(1), named(1, 1), sci(2), named(2, 0b111)]);
    let output = path(&folder, "copy.fits");
    let flags = ["--into", "DQ", "--bit", "SATELLITE", "-o", &output];
    let (code, _, stderr) = run(&[&["mask", &frame], &flags, WIDE, SATELLITES]);
    assert!(code == 0 && stderr.contains("copy.fits: ") && stderr.contains("; bit 3"), "{stderr}");
    assert_eq!([1, 3].map(|hdu| header(&output, hdu).integer("MP_SATELLITE")), [Some(3); 2]);
    for (hdu, used) in [(1, 1), (3, 0b111)] {
        let bits: Vec<i16> = values(&output, hdu).iter().map(|bits| *bits as i16).collect();
        assert!(bits.iter().any(|bits| bits & 8 == 8) && bits.iter().all(|bits| bits & !8 & !used == 0));
    }
    // The number of a bit with another name is an error, in the first plane or another; that of STREAK is not.
    let marked = written(&folder, "two.fits", &[sci(1), named(1, 1), sci(2), dq(2, "MP_EDGE = 4\nMP_STREAK= 5\n", 1)]);
    for (bit, part) in
        [("0", "HDU 1: mask bit is 0, that of MP_BAD; allowed: --bit BAD"), ("4", "that of MP_EDGE"), ("5", "")]
    {
        let (code, _, stderr) =
            run(&[&["mask", &marked, "--into", "DQ", "--bit", bit, "-o", &output], WIDE, SATELLITES]);
        assert!(code == if part.is_empty() { 0 } else { 2 } && stderr.contains(part), "{bit}: {stderr}");
    }
    // A number that only one plane names is used in the other if it is free there.
    for (used, expected) in [(1, Some(5)), (32, None)] {
        let one = dq(1, "MP_BAD  = 0\nHIERARCH MP_SATELLITE = 5\n", 1);
        let frame = written(&folder, "two.fits", &[sci(1), one, sci(2), named(2, used)]);
        let (code, _, stderr) = run(&[&["mask", &frame], &flags, WIDE, SATELLITES]);
        match expected {
            Some(_) => assert_eq!([1, 3].map(|hdu| header(&output, hdu).integer("MP_SATELLITE")), [expected; 2]),
            None => assert!(code == 2 && stderr.contains("bit MP_SATELLITE is 5 in some mask planes"), "{stderr}"),
        }
    }

    let several = path(&folder, "several");
    fs::create_dir(&several).unwrap();
    let first = written(&folder, "first.fits", &[sci(1), named(1, 1)]);
    let flags = ["--into", "DQ", "--bit", "SATELLITE", "-o", &several, "--quiet"];
    for (second, part, count) in [
        (written(&folder, "bare.fits", &[sci(1)]), "bare.fits: mask plane \"DQ\" is missing", 0),
        (
            written(&folder, "half.fits", &[sci(1), named(1, 1), sci(2)]),
            "half.fits: mask plane of HDU 2 is missing; 1 of 2 frames have already been written, without tables; allowed: \
             mask planes: HDU 1 (DQ)",
            1,
        ),
    ] {
        let (code, _, stderr) = run(&[&["mask", &first, &second], &flags, WIDE, SATELLITES]);
        assert!(code == 2 && stderr.contains(part), "{stderr}");
        assert_eq!(fs::read_dir(&several).unwrap().count(), count, "{part}");
    }
}

/// Polygons are anticlockwise on the sky in frames of both parities, and a satellite that is too faint in all chips has
/// the light of the brightest.
#[test]
fn verif_parity_and_chips_do_not_change_polygons_and_reasons() {
    let folder = TempDir::new().unwrap();
    let polygons = path(&folder, "mask.json");
    for text in [chip(198.9, 1), chip(198.9, 1).replace("CD1_1   = -", "CD1_1   = ")] {
        let frame = written(&folder, "frame.fits", &[("SCI", text, grey())]);
        done(&[&["mask", &frame, "--polygons", &polygons, "--quiet"], WIDE, SATELLITES]);
        let document = json(&polygons);
        let rows = document["corridors"].as_array().unwrap();
        assert!(!rows.is_empty());
        for row in rows {
            let region = row["s_region"].as_str().unwrap();
            let numbers: Vec<f64> = region.split(' ').skip(2).map(|number| number.parse().unwrap()).collect();
            // East is at the left.
            let corners: Vec<[f64; 2]> = numbers.chunks(2).map(|corner| [-corner[0], corner[1]]).collect();
            let next = corners.iter().cycle().skip(1);
            let twice: f64 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
            assert!(twice > 0.0, "{region}");
        }
    }
    let noisy = Pixels::F32((0..2400).map(|index| 100.0 + 50.0 * (index * 7919 % 101) as f32).collect());
    let reasons = |frame: &str, hdus: &str| -> Vec<String> {
        let flags = ["--polygons", &polygons, "--hdu", hdus, "--threshold", "100", "--zero-point", "20", "--quiet"];
        done(&[&["mask", frame], &flags, SEEING, SATELLITES]);
        let document = json(&polygons);
        let reason = |one: &Value| one["reason"].as_str().unwrap().to_owned();
        document["left_out"].as_array().unwrap().iter().map(reason).collect()
    };
    let frame = written(&folder, "two.fits", &[("SCI", chip(198.9, 1), grey()), ("SCI", chip(198.9, 2), noisy)]);
    let (both, first, second) = (reasons(&frame, "0,1"), reasons(&frame, "0"), reasons(&frame, "1"));
    assert!(!first.is_empty() && first != second && first[0].starts_with("too faint"), "{first:?} {second:?}");
    assert_eq!(both, first);
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
        (&[&output, WIDE, SEEING], "--seeing has no effect with --width"),
        (&[&output, WIDE, &["--threshold", "1"]], "--threshold has no effect with --width"),
        (&[&output, SEEING, &zero, &["--zero-point-1s", "20"]], "exclude each other"),
        (&[&output, WIDE, &["--coverage", "1"]], "coverage is 1; allowed: 0.5 to 0.999"),
        (&[&output, SEEING, &zero, &["--threshold", "0"]], "threshold is 0; allowed: 0.01 to 100"),
        (&[&output, WIDE, &["--bit", "3"]], "--bit is given without --into"),
        (&[&["--regions", &mask], WIDE, &["--into", "1"]], "--output"),
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
