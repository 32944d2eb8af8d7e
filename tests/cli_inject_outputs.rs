//! Where `inject` writes to: links, pipes, names that promise what is not done.
#![cfg(all(feature = "cli", feature = "fits"))]

mod common;

use std::fs;

use common::cli::{path, run};
use common::injected::{RANDOM, SKY};
use tempfile::TempDir;

/// A description of synthetic frames.
fn sky(folder: &TempDir) -> String {
    let description = path(folder, "sky.toml");
    fs::write(&description, SKY).unwrap();
    description
}

#[cfg(unix)]
#[test]
fn verif_links_are_followed_and_pipes_are_refused() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    let folder = TempDir::new().unwrap();
    let description = sky(&folder);
    fs::create_dir(folder.path().join("store")).unwrap();
    let names = ["frame.fits", "truth.csv", "view.png"];
    for name in names {
        symlink(format!("store/{name}"), folder.path().join(name)).unwrap();
    }
    // One of them leads to a file, two to nothing yet.
    fs::write(folder.path().join("store/truth.csv"), "old").unwrap();
    let [frame, truth, view] = names.map(|name| path(&folder, name));
    let asked: &[&str] = &["inject", "--synthetic", &description, "-o", &frame, "--truth", &truth];
    let pictures: &[&str] = if cfg!(feature = "plot") { &["--preview", &view] } else { &[] };
    let (code, _, stderr) = run(&[asked, pictures, RANDOM]);
    assert_eq!(code, 0, "{stderr}");
    for (name, begin) in names.iter().zip([&b"SIMPLE"[..], b"#", b"\x89PNG"]) {
        let link = folder.path().join(name);
        assert!(link.is_symlink(), "{name}");
        if cfg!(feature = "plot") || *name != "view.png" {
            let target = folder.path().join("store").join(name);
            assert!(!target.is_symlink() && fs::read(&target).unwrap().starts_with(begin), "{name}");
        }
    }

    let (pipe, link) = (path(&folder, "pipe.fits"), path(&folder, "link.fits"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    symlink(&pipe, &link).unwrap();
    for output in [&pipe, &link] {
        // Before anything is read: there is no such frame, and nothing is said of it.
        let none = path(&folder, "none.fits");
        let (code, stdout, stderr) = run(&[&["inject", "--image", &none, "-o", output], RANDOM]);
        assert_eq!((code, stdout.as_str(), stderr.lines().count()), (2, "", 1), "{stderr}");
        assert!(stderr.contains(output.as_str()) && stderr.contains("is a pipe"), "{stderr}");
        assert!(fs::metadata(output).unwrap().file_type().is_fifo());
    }
    let same: &[&str] = &["-o", &path(&folder, "store/frame.fits"), "--truth", &truth, "--trails", &truth];
    let (code, _, stderr) = run(&[&["inject", "--synthetic", &description], same, RANDOM]);
    assert!(code == 2 && stderr.contains("two outputs"), "{stderr}");
}
