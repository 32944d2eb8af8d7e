//! Output files of `inject`: links, pipes, and file names with an extension that is not supported.

use std::fs;
use std::path::Path;

use crate::common::cli::{is_ignored, path, records, run};
use crate::common::injected::{RANDOM, SKY, column};
use streakcast::images::{Card, FrameFile, Header, ImageValues, NewImage, Pixels, write_frame};
use tempfile::TempDir;

/// Description file of synthetic frames.
fn sky(folder: &TempDir) -> String {
    let description = path(folder, "sky.toml");
    fs::write(&description, SKY).unwrap();
    description
}

#[cfg(unix)]
#[test]
fn verif_links_are_followed_and_pipes_are_rejected() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = TempDir::new().unwrap();
    let description = sky(&folder);
    fs::create_dir(folder.path().join("store")).unwrap();
    let names = ["frame.fits", "truth.csv", "view.png"];
    for name in names {
        symlink(format!("store/{name}"), folder.path().join(name)).unwrap();
    }
    // One link points to a file, two point to missing files.
    fs::write(folder.path().join("store/truth.csv"), "old").unwrap();
    let [frame, truth, view] = names.map(|name| path(&folder, name));
    let arguments: &[&str] =
        &["inject", "--synthetic", &description, "-o", &frame, "--truth", &truth, "--preview", &view];
    let (code, _, stderr) = run(&[arguments, RANDOM]);
    assert_eq!(code, 0, "{stderr}");
    for (name, begin) in names.iter().zip([&b"SIMPLE"[..], b"#", b"\x89PNG"]) {
        let link = folder.path().join(name);
        assert!(link.is_symlink(), "{name}");
        let target = folder.path().join("store").join(name);
        assert!(!target.is_symlink() && fs::read(&target).unwrap().starts_with(begin), "{name}");
    }

    let (pipe, link) = (path(&folder, "pipe.fits"), path(&folder, "link.fits"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    symlink(&pipe, &link).unwrap();
    for output in [&pipe, &link] {
        // The outputs are checked before reading: the error is not that of the missing frame.
        let none = path(&folder, "none.fits");
        let (code, stdout, stderr) = run(&[&["inject", "--image", &none, "-o", output], RANDOM]);
        assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
        assert!(stderr.contains(output.as_str()) && stderr.contains("is a pipe"), "{stderr}");
        assert!(fs::metadata(output).unwrap().file_type().is_fifo());
    }
    let same: &[&str] = &["-o", &path(&folder, "store/frame.fits"), "--truth", &truth, "--trails", &truth];
    let (code, _, stderr) = run(&[&["inject", "--synthetic", &description], same, RANDOM]);
    assert!(code == 2 && stderr.contains("is also another output"), "{stderr}");
    // An output below a file: the error of the system is stated.
    let below = format!("{description}/frame.fits");
    let (code, _, stderr) = run(&[&["inject", "--synthetic", &description, "-o", &below], RANDOM]);
    assert_eq!(code, 2);
    assert!(stderr.starts_with(&format!("error: cannot write {below}: ")) && stderr.contains("os error"), "{stderr}");
}

#[test]
fn verif_names_of_compressed_files_are_rejected() {
    let folder = TempDir::new().unwrap();
    let description = sky(&folder);
    for (name, words) in [("out.fits.gz", "without .gz"), ("out.fits.fz", "not compressed in tiles")] {
        let output = path(&folder, name);
        let (code, stdout, stderr) = run(&[&["inject", "--synthetic", &description, "-o", &output], RANDOM]);
        assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
        assert!(stderr.contains(name) && stderr.contains(words) && !fs::exists(&output).unwrap(), "{stderr}");
    }
    // The output for a tile-compressed frame is tile-compressed.
    fs::write(&description, format!("compress = true\n{SKY}")).unwrap();
    let [first, second] = ["first.fits.fz", "second.fits.fz"].map(|name| path(&folder, name));
    assert_eq!(run(&[&["inject", "--synthetic", &description, "-o", &first], RANDOM]).0, 0);
    assert_eq!(
        run(&[&["inject", "--image", &first, "-o", &second], &RANDOM[..4], &["--seeing", "2arcsec", "--quiet"]]).0,
        0
    );
}

#[test]
fn verif_a_failed_batch_names_the_frame_and_the_finished_ones() {
    let folder = TempDir::new().unwrap();
    let description = sky(&folder);
    let [good, bad, out] = ["good.fits", "bad.fits", "out"].map(|name| path(&folder, name));
    let plain: &[&str] = &["--random-streaks", "0", "--pixels-only"];
    assert_eq!(run(&[&["inject", "--synthetic", &description, "-o", &good], plain, &RANDOM[2..]]).0, 0);
    // With pixels of 1000 arcsec, an image of 2 arcsec is narrower than can be drawn.
    fs::write(&description, SKY.replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 100.0")).unwrap();
    let wide: &[&str] =
        &["--random-streaks", "0", "--pixels-only", "--magnitude", "8", "--exposure", "30s", "--seeing", "100arcsec"];
    assert_eq!(run(&[&["inject", "--synthetic", &description, "-o", &bad], wide]).0, 0);
    fs::create_dir(&out).unwrap();
    let truth = path(&folder, "truth.csv");
    let (code, _, stderr) = run(&[
        &["inject", "--image", &good, &bad, "-o", &out, "--truth", &truth, "--threads", "1", "--quiet"],
        &["--random-streaks", "2", "--magnitude", "6,8", "--seeing", "2.5arcsec"],
    ]);
    assert_eq!((code, stderr.lines().count()), (2, 1), "{stderr}");
    assert!(stderr.contains("bad.fits") && stderr.contains("1 of 2 frames have already been written"), "{stderr}");
    assert!(fs::exists(path(&folder, "out/good.fits")).unwrap() && !fs::exists(&truth).unwrap());
}

#[test]
fn verif_options_of_satellites_are_rejected_for_random_streaks() {
    let folder = TempDir::new().unwrap();
    let (description, output) = (sky(&folder), path(&folder, "out.fits"));
    let arguments: &[&str] = &["inject", "--synthetic", &description, "-o", &output];
    for option in [
        &["--extinction", "0.1"][..],
        &["--resolve-panels"],
        &["--shadow", "atmosphere"],
        &["--sun-distance"],
        &["--no-earthshine"],
        &["--lat", "40"],
        &["--lon", "40"],
        &["--mpc", "X05"],
        &["--observer-norad", "20580"],
    ] {
        let (code, stdout, stderr) = run(&[arguments, RANDOM, option]);
        assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
        assert!(stderr.contains(&format!("{} has no effect on random streaks", option[0])), "{stderr}");
    }
    // A configuration file may contain options of other verbs.
    let config = path(&folder, "config.toml");
    fs::write(&config, "extinction = 0.1\nmpc = 'X05'\nshadow = 'atmosphere'\n").unwrap();
    let (code, _, stderr) = run(&[arguments, RANDOM, &["--config", &config]]);
    assert_eq!(code, 0, "{stderr}");
}

#[test]
fn verif_history_and_tables_contain_the_settings() {
    let folder = TempDir::new().unwrap();
    let (description, output, truth) = (sky(&folder), path(&folder, "out.fits"), path(&folder, "truth.json"));
    assert_eq!(
        run(&[&["inject", "--synthetic", &description, "-o", &output, "--psf", "moffat:3", "--truth", &truth], RANDOM])
            .0,
        0
    );
    let provenance = std::fs::read_to_string(&truth).unwrap();
    assert!(provenance.contains("\"psf\": \"Moffat with beta 3\""), "{provenance}");
    let file = FrameFile::open(Path::new(&output)).unwrap();
    let history: Vec<String> = file.header(0).unwrap().cards().iter().map(Card::remark_text).collect();
    let history = history.join(" ");
    for words in ["moffat:3, FWHM 2.5 arcsec", " where brightest, zero point 27.940 mag"] {
        assert!(history.contains(words), "{words}: {history}");
    }
    let table = file.hdus().iter().find(|hdu| hdu.name == "STREAKS").unwrap().index;
    let header = file.header(table).unwrap();
    let column = (1..).find(|number| header.text(&format!("TTYPE{number}")).as_deref() == Some("norad_id")).unwrap();
    assert_eq!(header.integer(&format!("TNULL{column}")), Some(-1));
}

/// A streak that crosses two adjacent chips is one streak with two parts.
#[test]
fn pieces_of_streaks_on_a_mosaic_are_counted_apart() {
    let folder = TempDir::new().unwrap();
    let (frame, output, truth) = (path(&folder, "mosaic.fits"), path(&folder, "out.fits"), path(&folder, "truth.csv"));
    let cards = |crpix: f64| {
        let text = format!(
            "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  = 10.0\nCRVAL2  = -30.0\nCRPIX1  = {crpix}\nCRPIX2  = 100.0\n\
             CD1_1   = -2.8E-4\nCD1_2   = 0.0\nCD2_1   = 0.0\nCD2_2   = 2.8E-4\nGAIN    = 2.0\nMAGZERO = 28.0\n"
        );
        Header::from_text(&text).cards().to_vec()
    };
    let pixels = ImageValues::new(200, Pixels::F32(vec![100.0; 40_000].into())).unwrap();
    let (left, right) = (cards(200.0), cards(0.0));
    let image = |name, cards| NewImage { name, values: &pixels, cards, rice: None };
    write_frame(Path::new(&frame), &[image("A", &left), image("B", &right)]).unwrap();
    let shot = ["--start", "2024-08-14T00:00:00Z", "--zero-point", "28", "--truth", &truth, "--seed", "3"];
    let random: Vec<&str> = RANDOM.iter().copied().filter(|word| *word != "--quiet").collect();
    let (code, _, stderr) = run(&[&["inject", "--image", &frame, "-o", &output], &shot, &random]);
    assert_eq!(code, 0, "{stderr}");
    let rows = records(&std::fs::read_to_string(&truth).unwrap());
    let ids: std::collections::BTreeSet<String> = column(&rows, "name").into_iter().collect();
    let (streaks, pieces) = (ids.len(), rows.len() - 1);
    assert!(pieces > streaks, "{rows:?}");
    assert!(stderr.contains(&format!(": {streaks} random streaks in {pieces} pieces, ")), "{stderr}");
}

/// An interrupted run removes its temporary files. Those of a killed run are removed by the next run.
#[cfg(unix)]
#[test]
fn no_temporary_files_remain() {
    use std::process::{Command, Stdio};
    let folder = TempDir::new().unwrap();
    let frames = path(&folder, "frames");
    fs::create_dir(&frames).unwrap();
    let description = sky(&folder);
    let temporary = || -> Vec<String> {
        let names = fs::read_dir(&frames).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.starts_with(".streakcast-")).collect()
    };
    // More frames than can be written before the signal.
    let arguments = ["inject", "--synthetic", &description, "-o", &frames, "--frames", "100000"];
    let ended_by = |signal: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_streakcast"));
        command.env("STREAKCAST_NO_HOME", "1");
        let mut child = command.args(arguments).args(RANDOM).stderr(Stdio::null()).spawn().unwrap();
        while temporary().is_empty() {
            assert!(child.try_wait().unwrap().is_none(), "the run ended");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert!(sent.success() && child.wait().unwrap().code().is_none(), "{signal}");
    };
    for (signal, number) in [("-HUP", 1), ("-INT", 2), ("-QUIT", 3), ("-TERM", 15)] {
        if is_ignored(signal, number) {
            continue;
        }
        ended_by(signal);
        assert_eq!(temporary(), Vec::<String>::new(), "{signal}");
    }
    // The signal can arrive between two frames, when no temporary file exists.
    while temporary().is_empty() {
        ended_by("-KILL");
    }
    let output = path(&folder, "frames/one.fits");
    assert_eq!(run(&[&["inject", "--synthetic", &description, "-o", &output], RANDOM]).0, 0);
    assert_eq!(temporary(), Vec::<String>::new());
}
