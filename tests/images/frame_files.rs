//! Frame files: reading, copying with changes, creating; errors for invalid files.

use std::fs;
use std::path::{Path, PathBuf};

use streakcast::images::{
    Bitpix, Card, CardValue, Cells, FrameCopy, FrameFile, HduKind, Header, ImageValues, NewImage, Pixels, Plane, Rice,
    TableColumn, write_frame,
};

/// Returns pixels that all differ, in the given type.
fn numbers(kind: &str) -> ImageValues<'static> {
    let values = 0..30 * 20;
    let pixels = match kind {
        "u8" => Pixels::U8(values.map(|n| (n % 200) as u8).collect()),
        "i16" => Pixels::I16(values.map(|n| n as i16 - 300).collect()),
        "u16" => Pixels::U16(values.map(|n| n as u16 + 40_000).collect()),
        "i32" => Pixels::I32(values.map(|n| n * 70_001 - 5).collect()),
        "f32" => Pixels::F32(values.map(|n| n as f32 * 0.37 - 20.0).collect()),
        _ => Pixels::F64(values.map(|n| f64::from(n) * 0.1 + 1e-9).collect()),
    };
    ImageValues::new(30, pixels).expect("full rows")
}

const KINDS: [&str; 6] = ["u8", "i16", "u16", "i32", "f32", "f64"];

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a folder")
}

fn cards(text: &str) -> Vec<Card> {
    Header::from_text(text).cards().to_vec()
}

/// Writes a file with one image.
fn simple(folder: &Path, kind: &str, rice: Option<Rice>, extra: &str) -> PathBuf {
    let path = folder.join(format!("{kind}.fits"));
    let values = numbers(kind);
    write_frame(&path, &[NewImage { name: "SCI", values: &values, cards: &cards(extra), rice }]).expect("written");
    path
}

#[test]
fn verif_every_type_is_written_and_read() {
    let folder = folder();
    for kind in KINDS {
        let file = FrameFile::open(&simple(folder.path(), kind, None, "FILTER  = 'r'\n")).expect(kind);
        let info = &file.hdus()[0];
        assert_eq!(
            (info.name.as_str(), &info.kind, info.image_size()),
            ("SCI", &HduKind::Image, Some([20, 30])),
            "{kind}"
        );
        assert_eq!(file.header(0).expect("a header").text("FILTER").as_deref(), Some("r"));
        let plane = file.read_plane(0).expect(kind);
        let rows = file.read_rows(0, 0..20).expect(kind);
        for (index, (single, double)) in plane.values().iter().zip(&rows).enumerate() {
            let n = index as f64;
            let expected = match kind {
                "u8" => n % 200.0,
                "i16" => n - 300.0,
                "u16" => n + 40_000.0,
                "i32" => n * 70_001.0 - 5.0,
                "f32" => f64::from(n as f32 * 0.37 - 20.0),
                _ => n * 0.1 + 1e-9,
            };
            assert_eq!((*double, *single), (expected, expected as f32), "{kind} {index}");
        }
        assert_eq!(file.read_rows(0, 3..5).expect(kind), rows[90..150]);
    }
}

#[test]
fn verif_only_changed_pixels_differ() {
    let folder = folder();
    for kind in KINDS {
        let source = FrameFile::open(&simple(folder.path(), kind, None, "")).expect(kind);
        let before = source.read_rows(0, 0..20).expect(kind);
        let target = folder.path().join("out.fits");
        let mut copy = FrameCopy::begin(&source, &target).expect(kind);
        // 2.5 and 3.5 are exact in all floating-point types; integer types round them half to even.
        copy.add(0, 4, 10, &[2.5, 0.0, 3.5]).expect(kind);
        copy.add(0, 4, 12, &[1.0, 1.0]).expect(kind);
        copy.add(0, 19, 29, &[-7.0]).expect(kind);
        let changed = copy.finish().expect(kind)[&0];
        assert_eq!((changed.pixels, changed.clipped, changed.without_value), (4, 0, 0), "{kind}");
        let after = FrameFile::open(&target).expect(kind).read_rows(0, 0..20).expect(kind);
        let is_whole = source.hdus()[0].format.bitpix.is_integer();
        for index in 0..600 {
            let added = match index {
                130 => 2.5,
                132 => 4.5,
                133 => 1.0,
                599 => -7.0,
                _ => 0.0,
            };
            let mut expected = before[index] + added;
            if is_whole && expected.fract() != 0.0 {
                // The result is one of the two neighbouring integers.
                assert!((after[index] - expected).abs() < 1.0 && after[index].fract() == 0.0, "{kind} {index}");
                expected = after[index];
            }
            if source.hdus()[0].format.bitpix == Bitpix::F32 {
                assert!((after[index] - expected).abs() < 1e-5, "{kind} {index}");
            } else {
                assert_eq!(after[index], expected, "{kind} {index}");
            }
        }
    }
}

#[test]
fn verif_ranges_and_undefined_pixels() {
    let folder = folder();
    let path = simple(folder.path(), "u8", None, "BLANK   = 7\n");
    let source = FrameFile::open(&path).expect("a file");
    assert!(source.read_plane(0).expect("a plane").values()[7].is_nan());
    let target = folder.path().join("out.fits");
    let mut copy = FrameCopy::begin(&source, &target).expect("a copy");
    copy.add(0, 0, 5, &[1000.0, -1000.0, 50.0, f32::NAN]).expect("a change");
    let changed = copy.finish().expect("finished")[&0];
    assert_eq!((changed.pixels, changed.clipped, changed.without_value), (2, 2, 1));
    let after = FrameFile::open(&target).expect("a file").read_rows(0, 0..1).expect("rows");
    assert_eq!((after[5], after[6], after[8]), (255.0, 0.0, 8.0));
    assert!(after[7].is_nan());
}

#[test]
fn verif_new_extensions_follow_the_old_ones() {
    let folder = folder();
    let source = FrameFile::open(&simple(folder.path(), "f32", None, "HISTORY made\n")).expect("a file");
    let target = folder.path().join("out.fits");
    let mut copy = FrameCopy::begin(&source, &target).expect("a copy");
    copy.add_history(0, "streaks were added to this frame, and this text is so long that it goes on on another card")
        .expect("history");
    copy.set_card(0, "MJD-OBS", &CardValue::Real(60_000.123_456_789_01), "start").expect("a card");
    copy.append_image(
        "MASK",
        ImageValues::new(30, Pixels::I32(vec![3; 600].into())).expect("rows"),
        &cards("MP_STREAK= 1\n"),
        None,
    );
    copy.append_image("TRUTH", Plane::zeros(20, 30).into(), &[], Some(Rice::default()));
    let columns = [
        TableColumn {
            name: "ra_deg".into(),
            unit: "deg".into(),
            meaning: "right ascension".into(),
            cells: Cells::Real(vec![1.5, f64::NAN]),
        },
        TableColumn {
            name: "norad_id".into(),
            unit: String::new(),
            meaning: String::new(),
            cells: Cells::Integer(vec![Some(44_238), None]),
        },
        TableColumn {
            name: "name".into(),
            unit: String::new(),
            meaning: String::new(),
            cells: Cells::Text(vec!["ISS".into(), "Ørsted".into()]),
        },
    ];
    copy.append_table("STREAKS", &columns, &[]).expect("a table");
    let uneven = [columns[0].clone(), TableColumn { cells: Cells::Integer(vec![Some(1)]), ..columns[1].clone() }];
    let error = copy.append_table("BAD", &uneven, &[]).expect_err("uneven");
    assert_eq!(
        error.to_string(),
        "table \"BAD\": length of column norad_id is 1; allowed: 2, the length of the first column"
    );
    copy.finish().expect("finished");
    let file = FrameFile::open(&target).expect("a file");
    let names: Vec<&str> = file.hdus().iter().map(|hdu| hdu.name.as_str()).collect();
    assert_eq!(names, ["SCI", "MASK", "TRUTH", "STREAKS"]);
    assert_eq!(file.hdus()[2].kind, HduKind::CompressedImage("RICE_1".into()));
    assert_eq!(file.hdus()[3].kind, HduKind::Table);
    assert_eq!(file.header(3).expect("a header").integer("TNULL2"), Some(-1));
    assert_eq!(file.read_plane(1).expect("a plane").values()[0], 3.0);
    let header = file.header(0).expect("a header");
    assert_eq!(header.number("MJD-OBS"), Some(60_000.123_456_789_01));
    let history: Vec<String> =
        header.cards().iter().filter(|card| card.keyword() == "HISTORY").map(Card::remark_text).collect();
    assert_eq!(history.len(), 3);
    assert_eq!(history[0], "made");
    assert_eq!(source.read_plane(0).expect("a plane"), file.read_plane(0).expect("a plane"));
}

#[test]
fn verif_rice_round_trip() {
    let folder = folder();
    for kind in KINDS {
        let plain =
            FrameFile::open(&simple(folder.path(), kind, None, "")).expect(kind).read_rows(0, 0..20).expect(kind);
        let rice = Rice { steps_per_sigma: 16.0, dither_seed: 7 };
        let file = FrameFile::open(&simple(folder.path(), kind, Some(rice), "")).expect(kind);
        assert_eq!(file.hdus()[1].kind, HduKind::CompressedImage("RICE_1".into()));
        assert_eq!(file.hdus()[1].image_size(), Some([20, 30]));
        let packed = file.read_rows(1, 0..20).expect(kind);
        // Integers are restored exactly. A ramp of floats has no noise and is therefore also restored exactly.
        for (index, (a, b)) in plain.iter().zip(&packed).enumerate() {
            assert!((a - b).abs() <= if kind.starts_with('f') { 1e-6 } else { 0.0 }, "{kind} {index}: {a} {b}");
        }
    }
}

fn refused(path: &Path) -> String {
    let error = FrameFile::open(path).expect_err("refused").to_string();
    assert!(error.contains(&path.display().to_string()), "{error}");
    error
}

#[test]
fn verif_invalid_frames_are_rejected() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let good = fs::read(simple(folder.path(), "i16", None, "")).expect("bytes");
    assert!(refused(&at("missing.fits")).contains("No such file"));
    assert!(refused(folder.path()).contains("is a directory"));
    let with = |name: &str, bytes: &[u8]| {
        fs::write(at(name), bytes).expect("written");
        refused(&at(name))
    };
    let replaced = |from: &str, to: &str| {
        let text = String::from_utf8_lossy(&good[..2880]).replace(from, to);
        [text.as_bytes(), &good[2880..]].concat()
    };
    assert!(
        with("text.fits", b"hello, this is a text").contains("not a FITS file (it begins with \"hello, this is a\"")
    );
    assert!(with("empty.fits", b"").contains("not a FITS file (it begins with \"\""));
    assert!(
        with("a.fits.gz", b"\x1f\x8b\x08\x00").contains("is compressed with gzip; allowed: a decompressed FITS file")
    );
    assert!(
        with("cut.fits", &good[..3000])
            .contains("HDU 0 is truncated; allowed: at least 4080 bytes for its data (the file has 3000)")
    );
    assert!(
        with("cut-header.fits", &good[..1000])
            .contains("HDU 0 is truncated; allowed: at least 2880 bytes for its header (the file has 1000)")
    );
    let more = with("naxis-more.fits", &replaced("NAXIS2  =                   20", "NAXIS2  =                 2000"));
    assert!(more.contains("at least 122880 bytes for its data"), "{more}");
    // If the stated number of rows is too small, data are read as a header.
    let large = ImageValues::new(100, Pixels::I16((0..10_000).map(|n| n as i16 | 1).collect())).expect("rows");
    write_frame(&at("large.fits"), &[NewImage { name: "", values: &large, cards: &[], rice: None }]).expect("written");
    let text = String::from_utf8_lossy(&fs::read(at("large.fits")).expect("bytes")[..2880])
        .replace("NAXIS2  =                  100", "NAXIS2  =                   50");
    let fewer =
        with("naxis-fewer.fits", &[text.as_bytes(), &fs::read(at("large.fits")).expect("bytes")[2880..]].concat());
    assert!(fewer.contains("data after HDU 0 at byte") && fewer.contains("check the NAXISn"), "{fewer}");
    let negative =
        with("naxis-negative.fits", &replaced("NAXIS2  =                   20", "NAXIS2  =                  -20"));
    assert!(negative.contains("HDU 0: NAXIS2 is -20; allowed: a length of 0 or more"), "{negative}");
    let missing = with("naxis-missing.fits", &replaced("NAXIS2  =", "NOXIS2  ="));
    assert!(missing.contains("NAXIS2 is missing or not a number"), "{missing}");
    let bitpix = with("bitpix.fits", &replaced("BITPIX  =                   16", "BITPIX  =                   17"));
    assert!(bitpix.contains("BITPIX is 17; allowed: 8, 16, 32, 64, -32 or -64"), "{bitpix}");
    let huge = with("naxis-huge.fits", &replaced("NAXIS2  =                   20", "NAXIS2  =  9000000000000000000"));
    assert!(huge.contains("with a product that is a possible size of a file"), "{huge}");
}

#[test]
fn verif_hdus_that_are_missing_or_not_images() {
    let folder = folder();
    let file = FrameFile::open(&simple(folder.path(), "i16", Some(Rice::default()), "")).expect("a file");
    assert!(file.read_plane(5).expect_err("none").to_string().ends_with("HDU 5 is missing; allowed: 0 to 1"));
    assert!(file.header(2).is_err());
    let error = file.read_plane(0).expect_err("no image").to_string();
    assert!(error.ends_with("HDU 0 is only a header; allowed: an image of two axes: HDU [1]"), "{error}");
    let error = file.read_rows(1, 15..25).expect_err("too many rows").to_string();
    let message =
        "HDU 1: row 24, columns 0 to 29 is outside the image; allowed: 20 rows and 30 columns, counted from 0";
    assert!(error.ends_with(message), "{error}");
    let mut copy = FrameCopy::begin(&file, &folder.path().join("out.fits")).expect("a copy");
    for (row, column) in [(20, 0), (0, 30), (3, 28)] {
        let error = copy.add(1, row, column, &[1.0, 1.0, 1.0]).expect_err("outside").to_string();
        assert!(error.contains(&format!("HDU 1: row {row}, columns {column} to {} is outside", column + 2)), "{error}");
    }
    assert!(copy.add_history(9, "x").is_err());
}

/// File names with CFITSIO syntax are taken literally.
#[test]
fn verif_names_with_brackets_are_plain_names() {
    let folder = folder();
    for name in ["a[1].fits", "!b.fits", "c(d).fits", "e+1.fits", "mem:f.fits", "g [compress R].fits", "h*.fits"] {
        let path = folder.path().join(name);
        let values = numbers("i16");
        let image = NewImage { name: "", values: &values, cards: &[], rice: Some(Rice::default()) };
        write_frame(&path, &[image]).expect(name);
        let file = FrameFile::open(&path).expect(name);
        assert_eq!(file.read_plane(1).expect(name).values()[1], -299.0, "{name}");
        let target = folder.path().join(format!("out {name}"));
        let mut copy = FrameCopy::begin(&file, &target).expect(name);
        copy.add_history(1, "copied").expect(name);
        copy.finish().expect(name);
        assert_eq!(FrameFile::open(&target).expect(name).read_plane(1).expect(name).values()[1], -299.0, "{name}");
        fs::remove_file(&target).expect(name);
    }
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 7);
}

#[test]
fn verif_the_input_is_kept_and_no_partial_output_remains() {
    let folder = folder();
    let path = simple(folder.path(), "f32", None, "");
    let bytes = fs::read(&path).expect("bytes");
    let source = FrameFile::open(&path).expect("a file");
    let same = FrameCopy::begin(&source, &path).expect_err("the same file").to_string();
    assert!(same.ends_with("is also the input; allowed: another output"), "{same}");
    let below_a_file = path.join("out.fits");
    let error = FrameCopy::begin(&source, &below_a_file).expect_err("no folder").to_string();
    assert!(error.contains("folder ") && error.contains("f32"), "{error}");
    assert!(FrameCopy::begin(&source, folder.path()).expect_err("a folder").to_string().contains("is a directory"));
    let mut copy = FrameCopy::begin(&source, &folder.path().join("out.fits")).expect("a copy");
    copy.add(0, 0, 0, &[1.0]).expect("a change");
    drop(copy);
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
    // The input is truncated during the copy, so that the output would be invalid.
    let mut copy = FrameCopy::begin(&source, &folder.path().join("out.fits")).expect("a copy");
    copy.add(0, 0, 0, &[1.0]).expect("a change");
    fs::write(&path, &bytes[..3000]).expect("cut");
    let error = copy.finish().expect_err("cut").to_string();
    assert!(error.contains("the input was truncated"), "{error}");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}

/// In a compressed image, unchanged pixels are identical; changed ones differ by up to half a quantisation step.
#[track_caller]
fn change_compressed(path: &Path, hdu: usize, step: f64) {
    let folder = folder();
    let name = path.display().to_string();
    let source = FrameFile::open(path).expect("a file");
    let [rows, columns] = source.hdus()[hdu].image_size().expect("an image");
    let before = source.read_rows(hdu, 0..rows).expect("rows");
    let target = folder.path().join("out.fits");
    let mut copy = FrameCopy::begin(&source, &target).expect("a copy");
    let touched = |row: usize, column: usize| row % 3 == 1 && (5..15).contains(&column);
    for row in (0..rows).filter(|row| row % 3 == 1) {
        copy.add(hdu, row, 5, &[60.0; 10]).expect("a change");
        // The same pixels are changed several times.
        copy.add(hdu, row, 8, &[40.0; 7]).expect("a change");
        copy.add(hdu, row, 5, &[40.0; 3]).expect("a change");
    }
    let changed = copy.finish().expect("finished")[&hdu];
    assert!(changed.pixels > 10 && changed.clipped == 0, "{name}: {changed:?}");
    let after = FrameFile::open(&target).expect("a file");
    assert_eq!(after.hdus().len(), source.hdus().len());
    let values = after.read_rows(hdu, 0..rows).expect("rows");
    for row in 0..rows {
        for column in 0..columns {
            let (old, new) = (before[row * columns + column], values[row * columns + column]);
            if old.is_nan() {
                assert!(new.is_nan(), "{name} {row} {column}");
            } else if touched(row, column) {
                assert!((new - old - 100.0).abs() <= step, "{name} {row} {column}: {old} {new}");
            } else {
                assert_eq!(new, old, "{name} {row} {column}");
            }
        }
    }
    // The other HDUs have identical bytes.
    for other in (0..source.hdus().len()).filter(|other| *other != hdu) {
        assert_eq!(source.header(other).expect("a header"), after.header(other).expect("a header"), "{name}[{other}]");
    }
}

#[test]
fn verif_compressed_images_change_only_where_touched() {
    let folder = folder();
    for kind in ["i16", "u16", "i32", "f32", "f64"] {
        let path = simple(folder.path(), kind, Some(Rice { steps_per_sigma: 4.0, dither_seed: 33 }), "");
        change_compressed(&path, 1, if kind.starts_with('f') { 1e-4 } else { 0.0 });
    }
}

#[test]
fn verif_noisy_floats_keep_their_steps() {
    let folder = folder();
    let path = folder.path().join("noise.fits");
    let mut random = crate::common::random::Random(5);
    let mut values: Vec<f32> =
        (0..200 * 60).map(|_| 1000.0 + 10.0 * (0..12).map(|_| random.uniform() as f32 - 0.5).sum::<f32>()).collect();
    values[777] = f32::NAN;
    let values = ImageValues::new(200, Pixels::F32(values.into())).expect("rows");
    let rice = Rice { steps_per_sigma: 4.0, dither_seed: 9_999 };
    write_frame(&path, &[NewImage { name: "", values: &values, cards: &[], rice: Some(rice) }]).expect("written");
    // The step is a quarter of the noise of 10, which is the largest error of added light. The noise estimate of
    // CFITSIO differs between rows.
    change_compressed(&path, 1, 4.0);
}

#[test]
fn verif_real_compressed_frames() {
    let Some(data) = crate::common::data_dir() else { return };
    let frames = data.join("frames/trailblazer");
    change_compressed(&frames.join("cutout_c4d_200306_000415_ori.fits.fz"), 7, 0.0);
    change_compressed(&frames.join("cutout_calexp-0941420_23.fits"), 1, 3.0);
    change_compressed(&frames.join("cutout_calexp-0941420_23.fits"), 2, 0.0);
}

/// Without permission to write to the folder, and with a full disk, there is no output, and the error is that of the
/// system.
#[cfg(target_os = "linux")]
#[test]
fn verif_unwritable_disks() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let source = FrameFile::open(&simple(folder.path(), "f32", None, "")).expect("a file");
    let closed = folder.path().join("closed");
    fs::create_dir(&closed).expect("a folder");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).expect("closed");
    // Root can write to any folder, so that this part is skipped for root.
    if fs::write(closed.join("probe"), b"x").is_err() {
        let error = FrameCopy::begin(&source, &closed.join("out.fits")).expect_err("closed").to_string();
        assert!(error.contains("Permission denied") && error.contains("out.fits"), "{error}");
    }
    // The full disk is simulated by a limit on file sizes in a shell, which runs this test again.
    if std::env::var_os("STREAKCAST_FULL_DISK").is_none() {
        let test = std::env::current_exe().expect("this test");
        let command = format!(
            "ulimit -f 64; trap '' XFSZ; exec {test:?} --exact frame_files::verif_unwritable_disks --nocapture"
        );
        let output = std::process::Command::new("sh")
            .args(["-c", &command])
            .env("STREAKCAST_FULL_DISK", "1")
            .output()
            .expect("a shell");
        let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && text.contains("full: copy and new frame refused"), "{text}");
        return;
    }
    // The limit is 64 blocks of 512 or 1024 bytes. The frame has 120 kB; it is appended to a small source file.
    let large = ImageValues::new(200, Pixels::F32(vec![1.0; 30_000].into())).expect("rows");
    let target = folder.path().join("out.fits");
    let mut copy = FrameCopy::begin(&source, &target).expect("a copy");
    copy.append_image("LARGE", large.clone(), &[], None);
    let error = copy.finish().expect_err("full").to_string();
    assert!(error.contains("out.fits") && error.contains("the disk may be full"), "{error}");
    let error = write_frame(&target, &[NewImage { name: "", values: &large, cards: &[], rice: None }])
        .expect_err("full")
        .to_string();
    assert!(error.contains("out.fits") && error.contains("the disk may be full"), "{error}");
    let noise: Vec<i32> = (0..30_000u32).map(|n| n.wrapping_mul(2_654_435_761) as i32).collect();
    let noise = ImageValues::new(200, Pixels::I32(noise.into())).expect("rows");
    let rice = Some(Rice::default());
    let error =
        write_frame(&target, &[NewImage { name: "", values: &noise, cards: &[], rice }]).expect_err("full").to_string();
    assert!(error.contains("CFITSIO"), "{error}");
    let left: Vec<_> =
        fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("an entry").file_name()).collect();
    assert_eq!(left.len(), 2, "{left:?}");
    println!("full: copy and new frame refused");
}

#[test]
fn verif_an_image_of_three_axes_and_one_of_no_pixels() {
    let folder = folder();
    let path = simple(folder.path(), "i16", None, "");
    let good = fs::read(&path).expect("bytes");
    let text = String::from_utf8_lossy(&good[..2880]).into_owned();
    let cube = text
        .replace("NAXIS   =                    2", "NAXIS   =                    3")
        .replace("NAXIS2  =                   20 / rows     ", "NAXIS2  =                   20            ");
    let card = |text: &str| format!("{text:<80}");
    let axes = |third: i64| {
        cube.replacen(
            &card("EXTEND  =                    T / extensions may follow"),
            &card(&format!("NAXIS3  = {third:>20}")),
            1,
        )
    };
    let with = |name: &str, header: &str, data: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, [header.as_bytes(), data].concat()).expect("written");
        FrameFile::open(&path).expect(name)
    };
    // A third axis with one pixel is ignored, one with two pixels is an error.
    let flat = with("flat.fits", &axes(1), &good[2880..]);
    assert_eq!(flat.read_plane(0).expect("a plane").values()[1], -299.0);
    for (planes, words) in [
        (2, "HDU 0 is a cube of 2 planes (NAXIS3 = 2); allowed: an image of two axes: extract the plane of"),
        (
            3,
            "HDU 0 is a cube or a colour image of 3 planes (NAXIS3 = 3); allowed: an image of two axes: extract one plane",
        ),
    ] {
        let thick = with("thick.fits", &axes(planes), &[&good[2880..], &[0; 2880]].concat());
        let error = thick.read_plane(0).expect_err("a cube").to_string();
        assert!(error.contains(words), "{error}");
    }
    // The header states what the planes are.
    for (cards, words) in [
        ("CTYPE3  = 'STOKES'", "HDU 0 is a cube of 3 planes (NAXIS3 = 3, CTYPE3 = 'STOKES'); allowed"),
        ("CTYPE3  = 'TIME'", "HDU 0 is a cube of 3 planes (NAXIS3 = 3, CTYPE3 = 'TIME'); allowed"),
        ("CTYPE3  = 'RGB'", "HDU 0 is a colour image of 3 planes (NAXIS3 = 3, CTYPE3 = 'RGB'); allowed"),
        ("BAYERPAT= 'RGGB'", "HDU 0 is a colour image of 3 planes (NAXIS3 = 3); allowed"),
    ] {
        let header = axes(3).replacen(&card("END"), &(card(cards) + &card("END")), 1);
        let header = header[..header.trim_end().len().next_multiple_of(2880)].to_owned();
        let file = with("stated.fits", &header, &[&good[2880..], &[0; 2880]].concat());
        let error = file.read_plane(0).expect_err("a cube").to_string();
        assert!(error.contains(words), "{error}");
    }
    // Axes of length 1 are not planes. A cube of four axes is no colour image.
    for (shape, words) in [
        (
            &[1, 6, 5][..],
            "HDU 0 is an image of axes [1, 6, 5]; allowed: an image of two axes: remove the axes of length 1",
        ),
        (&[6, 1, 5], "HDU 0 is an image of axes [6, 1, 5]; allowed"),
        (&[6, 5, 4, 3], "HDU 0 is a cube of axes [6, 5, 4, 3]; allowed: an image of two axes: extract the plane of"),
        (&[6, 5, 1, 3], "HDU 0 is a cube or a colour image of 3 planes (NAXIS4 = 3); allowed"),
        (&[1, 6, 5, 9], "HDU 0 is a cube of 9 planes (NAXIS4 = 9); allowed"),
        (&[3, 6, 5], "HDU 0 is a cube or a colour image of 3 planes (NAXIS1 = 3); allowed"),
    ] {
        let lengths = shape.iter().enumerate().map(|(axis, length)| format!("NAXIS{}  = {length:>20}", axis + 1));
        let cards = ["SIMPLE  = T".to_owned(), "BITPIX  = 16".to_owned(), format!("NAXIS   = {}", shape.len())];
        let header: String = cards.into_iter().chain(lengths).map(|text| card(&text)).collect();
        let header = format!("{:<2880}", header + "END");
        let bytes = shape.iter().product::<i64>() as usize * 2;
        let file = with("shape.fits", &header, &vec![0; bytes.next_multiple_of(2880)]);
        let error = file.read_plane(0).expect_err("no frame").to_string();
        assert!(error.contains(words), "{error}");
    }
    let none =
        with("none.fits", &text.replace("NAXIS2  =                   20", "NAXIS2  =                    0"), b"");
    assert!(none.read_plane(0).is_err());
}
