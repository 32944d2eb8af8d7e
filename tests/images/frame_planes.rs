//! Which images of a file are frames, and which are masks, variances and maps of frames.

use std::path::Path;

use streakcast::images::{Card, FrameFile, FrameImages, Header, ImageValues, NewImage, Pixels, PlaneKind, write_frame};

/// World coordinates of a frame with its centre at a right ascension in degrees.
fn sky(ra_deg: f64) -> String {
    format!(
        "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  = {ra_deg:.4}\nCRVAL2  = 20.0\nCRPIX1  = 8.5\nCRPIX2  = 6.5\n\
         CD1_1   = -0.0001\nCD1_2   = 0.0\nCD2_1   = 0.0\nCD2_2   = 0.0001\n"
    )
}

/// Writes a file with images of 12 by 16 pixels, given by name and cards.
fn written(path: &Path, images: &[(&str, String)]) -> FrameFile {
    let values = ImageValues::new(16, Pixels::F32(vec![1.0; 192].into())).expect("full rows");
    let cards: Vec<Vec<Card>> = images.iter().map(|(_, text)| Header::from_text(text).cards().to_vec()).collect();
    let images: Vec<NewImage> = images
        .iter()
        .zip(&cards)
        .map(|((name, _), cards)| NewImage { name, values: &values, cards, rice: None })
        .collect();
    write_frame(path, &images).expect("written");
    FrameFile::open(path).expect("a file")
}

fn roles(images: &[(&str, String)]) -> Result<FrameImages, String> {
    let folder = tempfile::tempdir().expect("a folder");
    written(&folder.path().join("a.fits"), images).frame_images().map_err(|error| error.to_string())
}

#[test]
fn planes_with_the_coordinates_of_a_frame_are_no_frames() {
    let here = || sky(10.0);
    let names = [
        "VAR",
        "RMS",
        "UNCERT",
        "INVVAR",
        "BPM",
        "QUALITY",
        "FOOTPRINT",
        "COVERAGE",
        "CTX",
        "EXPMAP",
        "BKG",
        "SKY",
        "SEGMAP",
        "VAR_POISSON",
        "TEMPLATE",
        "A NAME THAT NO LIST HAS",
    ];
    for with_sky in [true, false] {
        let mut images = vec![("SCI", here())];
        images.extend(names.map(|name| (name, if with_sky { here() } else { String::new() })));
        images.push(("WCSDVARR", String::new()));
        let found = roles(&images).expect("roles");
        assert_eq!((found.frames, found.tables), (vec![0], vec![names.len() + 1]));
        assert!(found.companions.iter().all(|plane| plane.of == Some(0)), "{:?}", found.companions);
        let kinds: Vec<PlaneKind> = found.companions.iter().map(|plane| plane.kind).collect();
        assert_eq!(
            kinds[..7],
            [
                PlaneKind::Variance,
                PlaneKind::Error,
                PlaneKind::Error,
                PlaneKind::InverseVariance,
                PlaneKind::Mask,
                PlaneKind::Mask,
                PlaneKind::Other
            ]
        );
        assert!(kinds[7..].iter().all(|kind| *kind == PlaneKind::Other));
    }
}

#[test]
fn chips_are_frames_and_planes_belong_to_their_chip() {
    let version = |number: i64, text: String| format!("{text}EXTVER  = {number}\n");
    // HST: two chips with their planes.
    let hst = [
        ("SCI", version(1, sky(10.0))),
        ("ERR", version(1, sky(10.0))),
        ("DQ", version(1, String::new())),
        ("SCI", version(2, sky(10.1))),
        ("ERR", version(2, sky(10.1))),
        ("DQ", version(2, String::new())),
    ];
    let found = roles(&hst).expect("roles");
    assert_eq!(found.frames, [0, 3]);
    assert_eq!(found.companions.iter().map(|plane| plane.of).collect::<Vec<_>>(), [0, 0, 3, 3].map(Some));
    // Two versions of the science image at the same position, and chips without world coordinates.
    for images in [
        [("SCI", version(1, sky(10.0))), ("SCI", version(2, sky(10.0)))],
        [("IM1", String::new()), ("IM2", String::new())],
        [("IMG_1", sky(10.0)), ("IMG_2", sky(10.0))],
        [("CCD_3", sky(10.0)), ("CCD_4", sky(10.1))],
    ] {
        assert_eq!(roles(&images).expect("roles").frames, [0, 1], "{images:?}");
    }
    // Names that differ by a number do not make frames of one sky.
    for names in [["LAYER_0", "LAYER_1"], ["EXT1", "EXT2"], ["FLUX", "FLUX_2"]] {
        let found = roles(&names.map(|name| (name, sky(10.0)))).expect("roles");
        assert_eq!((found.frames.as_slice(), found.companions[0].of), (&[0][..], Some(0)), "{names:?}");
    }
    let layers = [("FLUX", version(1, sky(10.0))), ("FLUX", version(2, sky(10.0)))];
    assert_eq!(roles(&layers).expect("roles").frames, [0]);
    // A background model in front of the science image.
    let found = roles(&[("BKG", sky(10.0)), ("SCI", sky(10.0))]).expect("roles");
    assert_eq!((found.frames.as_slice(), found.companions[0].of), (&[1][..], Some(1)));
}

/// Masks without world coordinates belong to the chip of their number, of their EXTVER or of their place in the file;
/// those for which nothing decides are named.
#[test]
fn planes_without_coordinates_belong_to_a_chip_or_are_named() {
    let version = |number: i64, text: String| format!("{text}EXTVER  = {number}\n");
    let chip = |name, shift: f64| (name, version(1, sky(10.0 + shift)));
    let mask = |name, number| (name, version(number, String::new()));
    let none = |name| (name, String::new());
    let of = |images: &[(&str, String)]| {
        let found = roles(images).expect("roles");
        let of: Vec<Option<usize>> = found.companions.iter().map(|plane| plane.of).collect();
        (of, found.summary().expect("a line"))
    };
    let (one, two) = (|| chip("CCD1", 0.0), || chip("CCD2", 0.1));
    for images in [
        vec![one(), two(), mask("BPM", 1), mask("BPM", 2)],
        vec![one(), two(), none("BPM"), none("BPM")],
        vec![one(), two(), mask("BPM1", 1), mask("BPM2", 1)],
        vec![one(), two(), mask("MASK_CCD1", 1), mask("MASK_CCD2", 1)],
        vec![one(), none("DQ"), two(), none("DQ")],
        vec![none("DQ"), one(), none("DQ"), two()],
        vec![chip("SCI", 0.0), ("SCI", version(2, sky(10.1))), mask("VAR", 1), mask("VAR", 2)],
    ] {
        let frames = roles(&images).expect("roles").frames;
        let (of, line) = of(&images);
        assert_eq!(of, [Some(frames[0]), Some(frames[1])], "{images:?}");
        assert!(!line.contains("unknown"), "{line}");
    }
    // The order of the EXTVER, not of the HDUs.
    assert_eq!(of(&[one(), two(), mask("BPM", 2), mask("BPM", 1)]).0, [Some(1), Some(0)]);
    // World coordinates before the EXTVER.
    assert_eq!(of(&[one(), two(), ("BPM", version(1, sky(10.1)))]).0, [Some(1)]);
    // One mask for two chips; a map that is not used in any case is not named.
    for (name, is_named) in [("BPM", true), ("VAR", true), ("COVERAGE", false)] {
        let (of, line) = of(&[one(), two(), none(name)]);
        assert_eq!(of, [None]);
        let words = format!("; frame unknown, not used: HDU 2 ({name})");
        assert_eq!(line.ends_with(&words), is_named, "{line}");
    }
}

/// Masks of the template of a difference are not those of the frame.
#[test]
fn planes_of_other_images_are_not_used() {
    for (names, unused) in [
        (&["SCI", "SCI_MASK", "REF", "REF_MASK"][..], 3),
        (&["SCI", "REF_BPM", "MASK", "REF"], 1),
        (&["SCI", "MASK", "SUBTRACTED", "SUBTRACTED_BPM"], 3),
        (&["SCI", "MASK", "TEMPLATE_MASK"], 2),
    ] {
        let images: Vec<(&str, String)> = names.iter().map(|name| (*name, sky(10.0))).collect();
        let found = roles(&images).expect("roles");
        let mut used = found.companions.iter().map(|plane| (plane.of == Some(0)) == (plane.hdu != unused));
        assert!(used.all(|is_right| is_right), "{:?}", found.companions);
        let line = found.summary().expect("a line");
        assert!(line.contains(&format!("; frame unknown, not used: HDU {unused} (")), "{line}");
    }
    // The mask of the reference image is that of the frame if the frame is the reference image.
    let found = roles(&[("REF", sky(10.0)), ("REF_MASK", sky(10.0))]).expect("roles");
    assert_eq!((found.frames[0], found.companions[0].of), (0, Some(0)));
}

/// Reads and amplifiers with one sky are frames, which is stated.
#[test]
fn frames_with_one_sky_are_stated() {
    let version = |number: i64, ra_deg: f64| format!("{}EXTVER  = {number}\n", sky(ra_deg));
    let reads =
        roles(&[("SCI", version(1, 10.0)), ("SCI", version(2, 10.0)), ("SCI", version(3, 10.0))]).expect("roles");
    let line = reads.summary().expect("a line");
    assert!(
        line.contains("the frames are HDU 0, 1, 2; HDU 1, 2 with the world coordinates of an earlier frame"),
        "{line}"
    );
    let chips = roles(&[("SCI", version(1, 10.0)), ("SCI", version(2, 10.1))]).expect("roles");
    assert_eq!(chips.summary(), None);
}

/// Files whose header says that all their images are masks or weights have no frames.
#[test]
fn products_of_archives_that_are_no_frames() {
    for (cards, card) in [
        ("PRODTYPE= 'dqmask'\n", "PRODTYPE = 'DQMASK'"),
        ("PRODTYPE= 'wtmap'\n", "PRODTYPE = 'WTMAP'"),
        ("PRODCATG= 'ANCILLARY.WEIGHTMAP'\n", "PRODCATG = 'ANCILLARY.WEIGHTMAP'"),
        ("PRODCATG= 'ANCILLARY.MASK'\n", "PRODCATG = 'ANCILLARY.MASK'"),
        ("PRODCATG= 'ANCILLARY.RMSMAP'\n", "PRODCATG = 'ANCILLARY.RMSMAP'"),
        ("OBSTYPE = 'BPM'\n", "OBSTYPE = 'BPM'"),
    ] {
        let found = roles(&[("", sky(10.0) + cards), ("S29", sky(10.1))]).expect("roles");
        assert!(found.frames.is_empty() && found.companions.len() == 2, "{cards}");
        let (given, allowed) = found.no_frame();
        assert!(given.contains(card) && allowed.contains("--hdu 0"), "{given}; {allowed}");
    }
    let (given, _) = roles(&[("APERTURE", sky(10.0))]).expect("roles").no_frame();
    assert!(given.contains("HDU 0 (APERTURE) is no frame by its name"), "{given}");
    for cards in [
        "PRODTYPE= 'image'\n",
        "PRODCATG= 'SCIENCE.IMAGE'\n",
        "PRODCATG= 'ANCILLARY.IMAGE'\n",
        "PRODCATG= 'ANCILLARY.PREVIEW'\n",
        "OBSTYPE = 'EXPOSE'\n",
    ] {
        assert_eq!(roles(&[("", sky(10.0) + cards), ("S29", sky(10.1))]).expect("roles").frames, [0, 1], "{cards}");
    }
    assert!(roles(&[("APERTURE", sky(10.0))]).expect("roles").frames.is_empty());
}

/// A binned copy, a background on a coarser grid, a stamp of stars and a shifted difference overlap the frame; a second
/// exposure of the same sky has a start of its own.
#[test]
fn images_that_overlap_a_frame_are_planes_and_other_exposures_are_frames() {
    let scaled = |scale: f64, shift_pix: f64| {
        let text = sky(10.0).replace("0.0001", &format!("{:.5}", 1e-4 * scale));
        text.replace("8.5", &format!("{}", 8.5 + shift_pix))
    };
    let planes = [("SCI_BIN2", scaled(2.0, 0.0)), ("BKG_MESH", scaled(16.0, 0.0)), ("PSF", scaled(0.1, 0.0))];
    for (name, text) in planes.into_iter().chain([("DIFF", scaled(1.0, 0.5))]) {
        let found = roles(&[("SCI", sky(10.0)), (name, text)]).expect("roles");
        assert_eq!((found.frames.as_slice(), found.companions[0].hdu), (&[0][..], 1), "{name}");
        assert!(found.summary().expect("a line").contains(name), "{name}");
    }
    let dated = |day: u32| format!("{}DATE-OBS= '2026-08-{day}T03:14:59'\n", sky(10.0));
    assert_eq!(roles(&[("OBS_A", dated(22)), ("OBS_B", dated(23))]).expect("roles").frames, [0, 1]);
    assert_eq!(roles(&[("G", dated(22)), ("MODEL", dated(22))]).expect("roles").frames, [0]);
    // Maps that another program dated, and templates of earlier nights.
    for name in ["SEGM", "BKG", "TEMPLATE", "SCI_BKG", "REF_IMAGE", "MASK", "VAR", "EXPMAP"] {
        let found = roles(&[("SCI", dated(22)), (name, dated(23))]).expect("roles");
        assert_eq!((found.frames, found.companions[0].of), (vec![0], Some(0)), "{name}");
    }
    assert_eq!(roles(&[("TEMPLATE", dated(21)), ("SCI", dated(22))]).expect("roles").frames, [1]);
    for two in [["SCI", "IMAGE"], ["SKY1", "SKY2"], ["SCI_1", "SCI_2"]] {
        assert_eq!(roles(&[(two[0], dated(22)), (two[1], dated(23))]).expect("roles").frames, [0, 1], "{two:?}");
    }
    for two in [["", ""], ["SCI", "BANANA"], ["SCI", ""]] {
        let error = roles(&[(two[0], dated(22)), (two[1], dated(23))]).expect_err("unclear");
        assert!(error.contains("--hdu 0, --hdu 1 or --hdu 0,1"), "{two:?}: {error}");
    }
    // The next chip of a mosaic overlaps by two columns.
    assert_eq!(roles(&[("S28", sky(10.0)), ("N4", sky(10.0015))]).expect("roles").frames, [0, 1]);
}

#[test]
fn classes_of_data_products_mark_planes() {
    for (class, kind) in [
        ("HDUCLAS2= 'ERROR'\n", PlaneKind::Error),
        ("HDUCLAS2= 'ERROR'\nHDUCLAS3= 'MSE'\n", PlaneKind::Variance),
        ("HDUCLAS2= 'ERROR'\nHDUCLAS3= 'INVMSE'\n", PlaneKind::InverseVariance),
        ("HDUCLAS2= 'QUALITY'\n", PlaneKind::Mask),
    ] {
        let found = roles(&[("CHIP1.1", sky(10.0)), ("CHIP1.2", sky(10.0) + class)]).expect("roles");
        assert_eq!((found.frames.as_slice(), found.companions[0].kind), (&[0][..], kind));
    }
}

#[test]
fn images_that_can_be_both_are_an_error() {
    for images in [
        vec![("", sky(10.0)), ("", sky(10.0))],
        vec![("", sky(10.0)), ("SCI", sky(10.0))],
        vec![("SCI", sky(10.0)), ("SCI", sky(10.0))],
        vec![("LEFT", String::new()), ("RIGHT", String::new())],
        vec![("CCD_3", sky(10.0)), ("CCD_4", sky(10.0))],
    ] {
        let error = roles(&images).expect_err("both");
        assert!(error.contains("a frame or a companion plane; allowed: --hdu 0, --hdu 1 or --hdu 0,1"), "{error}");
    }
    let summary =
        roles(&[("SCI", sky(10.0)), ("MASK", sky(10.0)), ("D2IMARR", String::new())]).expect("roles").summary();
    assert_eq!(
        summary.as_deref(),
        Some("the frame is HDU 0; companion planes, no frames: HDU 1 (MASK); distortion tables: HDU 2")
    );
    assert_eq!(roles(&[("SCI", sky(10.0))]).expect("roles").summary(), None);
}
