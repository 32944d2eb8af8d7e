//! Copies of real frames: all cards, extensions and tables are kept, in order.

use std::fs;
use std::path::{Path, PathBuf};

use streakcast::images::{Cells, FrameCopy, FrameFile, ImageValues, Pixels, TableColumn};

/// Frames of all kinds, and the HDU that is changed.
const FRAMES: &[(&str, usize)] = &[
    ("trailblazer/cutout_calexp-0941420_23.fits", 1),
    ("trailblazer/cutout_c4d_200306_000415_ori.fits.fz", 28),
    ("trailblazer/cutout_frame-i-008108-5-0025.fits", 0),
    ("trailblazer/cutout_lbcb.20210407.120357.fits", 2),
    ("trailblazer/cutout_HSCA21787010.fits", 0),
    ("trailblazer/cutout_A3671-C2018_F4-R-3.fit", 0),
    ("trailblazer/cutout_GMOSN.i.2021-01-17T14_35_11.5_2PAC.fits", 0),
    ("trailblazer/cutout_LMI.VR.2021-06-01T04_06_03.67_1PA.fits", 0),
    ("clean/HorseHead.fits", 0),
    ("clean/gc_2mass_k.fits", 0),
    ("clean/sep_image.fits", 0),
    ("galsim_wcs/tpv.fits", 0),
    ("galsim_wcs/tnx.fits", 0),
    ("galsim_wcs/sipsample.fits", 0),
    ("galsim_wcs/zpx.fits", 0),
    ("astride/long.fits", 0),
];

/// Keywords that change when tiles are compressed again. EXTEND is T if there are extensions.
const PACKING: &[&str] = &["PCOUNT", "TFORM1", "TFORM2", "CHECKSUM", "DATASUM", "EXTEND"];

/// Returns the folder of the copies. If STREAKCAST_KEEP names a folder, they are kept there for
/// `tests/reference/check_frame_copies.py`.
fn kept_folder() -> (Option<tempfile::TempDir>, PathBuf) {
    match std::env::var_os("STREAKCAST_KEEP") {
        Some(folder) => {
            fs::create_dir_all(&folder).expect("the folder");
            (None, folder.into())
        }
        None => {
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().to_owned();
            (Some(folder), path)
        }
    }
}

fn copied(path: &Path, hdu: usize, folder: &Path) -> PathBuf {
    let source = FrameFile::open(path).unwrap_or_else(|error| panic!("{error}"));
    let target = folder.join(path.file_name().expect("a name"));
    let mut copy = FrameCopy::begin(&source, &target).expect("a copy");
    for row in 10..20 {
        copy.add(hdu, row, 20 + row, &[50.0, 100.0, 50.0]).expect("light");
    }
    copy.add_history(hdu, "light was added to rows 10 to 19").expect("history");
    copy.append_image("MASK", ImageValues::new(7, Pixels::U8(vec![1; 21].into())).expect("rows"), &[], None);
    let cells = Cells::Real(vec![1.0, 2.0]);
    let column = TableColumn { name: "x_pix".into(), unit: "pix".into(), meaning: "column, from 0".into(), cells };
    copy.append_table("STREAKS", &[column], &[]).expect("a table");
    let changed = copy.finish().unwrap_or_else(|error| panic!("{error}"))[&hdu];
    assert!(changed.pixels + changed.without_value == 30, "{}: {changed:?}", path.display());
    target
}

#[test]
fn verif_all_content_is_kept() {
    let Some(data) = crate::common::data_dir() else { return };
    let (_guard, folder) = kept_folder();
    for (name, hdu) in FRAMES {
        let path = data.join("frames").join(name);
        let bytes = fs::read(&path).expect("the original");
        let target = copied(&path, *hdu, &folder);
        assert!(fs::read(&path).expect("the original") == bytes, "{name} was touched");
        let (before, after) =
            (FrameFile::open(&path).expect("the original"), FrameFile::open(&target).expect("the copy"));
        assert_eq!(after.hdus().len(), before.hdus().len() + 2, "{name}");
        for info in before.hdus() {
            let (old, new) =
                (before.header(info.index).expect("a header"), after.header(info.index).expect("a header"));
            if info.index != *hdu {
                assert_eq!(old, new, "{name}[{}]", info.index);
                continue;
            }
            // One additional card follows the others of its kind. Checksums and sizes of compressed data change.
            let is_new = |text: &str| text.starts_with("HISTORY light was added");
            let cards = |header: &streakcast::images::Header| -> Vec<String> {
                let kept = header.cards().iter().filter(|card| !PACKING.contains(&card.keyword().as_str()));
                kept.map(|card| card.text()).filter(|text| !is_new(text)).collect()
            };
            assert_eq!(cards(old), cards(new), "{name}[{hdu}]");
            assert_eq!(new.len(), old.len() + 1, "{name}[{hdu}]");
            assert_ne!(new.logical("EXTEND"), Some(false), "{name}[{hdu}]");
        }
    }
}
