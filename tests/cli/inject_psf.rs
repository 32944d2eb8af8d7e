//! `inject --psf FILE`: point spread functions from images and from files of PSFEx.

use std::fs;

use crate::common::cli::{done, path, run};
use crate::common::injected::{unrounded, values};
use tempfile::TempDir;

const ROWS: usize = 300;
const COLUMNS: usize = 400;
/// Largest relative error of the flux of a streak in the frame.
const FLUX: f64 = 1e-4;
/// Counts of a star of magnitude 11: `zero_point_1s_mag` of 25 in 30 s, with a gain of 2.
fn counts() -> f64 {
    10f64.powf(-0.4 * (11.0 - 25.0 - 2.5 * (30.0f64 / 2.0).log10()))
}

fn block(cards: &[String]) -> Vec<u8> {
    let mut bytes: Vec<u8> =
        cards.iter().chain(&["END".to_owned()]).flat_map(|card| format!("{card:<80}").into_bytes()).collect();
    bytes.resize(bytes.len().next_multiple_of(2880), b' ');
    bytes
}

fn card(name: &str, value: impl std::fmt::Display) -> String {
    format!("{name:<8}= {value:>20}")
}

fn padded(values: impl Iterator<Item = f32>) -> Vec<u8> {
    let mut bytes: Vec<u8> = values.flat_map(f32::to_be_bytes).collect();
    bytes.resize(bytes.len().next_multiple_of(2880), 0);
    bytes
}

/// FITS file with an image.
fn image(sides: &[usize], values: impl Iterator<Item = f32>, more: &[String]) -> Vec<u8> {
    let mut cards = vec![card("SIMPLE", "T"), card("BITPIX", -32), card("NAXIS", sides.len())];
    cards.extend(sides.iter().enumerate().map(|(axis, side)| card(&format!("NAXIS{}", axis + 1), side)));
    cards.extend(more.iter().cloned());
    [block(&cards), padded(values)].concat()
}

/// Gaussian with standard deviations along x and y, in samples.
fn gaussian(side: usize, sigmas: [f64; 2]) -> impl Iterator<Item = f32> {
    let middle = 0.5 * (side as f64 - 1.0);
    (0..side * side).map(move |at| {
        let [x, y] = [at % side, at / side].map(|at| at as f64 - middle);
        (-0.5 * ((x / sigmas[0]).powi(2) + (y / sigmas[1]).powi(2))).exp() as f32
    })
}

/// File of PSFEx with planes of `side` by `side` samples, and other values of its keywords.
fn psfex(side: usize, planes: &[Vec<f32>], step: f64, degree: usize, changed: &[(&str, &str)]) -> Vec<u8> {
    let count = side * side * planes.len();
    let mut cards = vec![
        "XTENSION= 'BINTABLE'".to_owned(),
        card("BITPIX", 8),
        card("NAXIS", 2),
        card("NAXIS1", 4 * count),
        card("NAXIS2", 1),
        card("PCOUNT", 0),
        card("GCOUNT", 1),
        card("TFIELDS", 1),
        "EXTNAME = 'PSF_DATA'".to_owned(),
        card("POLNAXIS", if degree > 0 { 2 } else { 0 }),
        card("POLNGRP", 1),
        "POLNAME1= 'X_IMAGE '".to_owned(),
        card("POLZERO1", 200.0),
        card("POLSCAL1", 400.0),
        "POLNAME2= 'Y_IMAGE '".to_owned(),
        card("POLZERO2", 150.0),
        card("POLSCAL2", 300.0),
        card("POLDEG1", degree),
        card("PSF_SAMP", step),
        card("PSFNAXIS", 3),
        card("PSFAXIS1", side),
        card("PSFAXIS2", side),
        card("PSFAXIS3", planes.len()),
        format!("TFORM1  = '{count}E'"),
        "TTYPE1  = 'PSF_MASK'".to_owned(),
        format!("TDIM1   = '({side},{side},{})'", planes.len()),
    ];
    for (name, value) in changed {
        let at = cards.iter().position(|card| card.starts_with(&format!("{name:<8}="))).unwrap();
        cards[at] = format!("{name:<8}= {value:>20}");
    }
    let primary = block(&[card("SIMPLE", "T"), card("BITPIX", 8), card("NAXIS", 0), card("EXTEND", "T")]);
    [primary, block(&cards), padded(planes.iter().flatten().copied())].concat()
}

struct Frame {
    folder: TempDir,
}

impl Frame {
    /// A frame with constant sky, and a table with two streaks in its left and right half.
    fn new() -> Self {
        let frame = Self { folder: TempDir::new().unwrap() };
        fs::write(frame.path("sky.toml"), unrounded()).unwrap();
        fs::write(frame.path("none.csv"), "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n-900,-900,-800,-900,30\n").unwrap();
        let table = "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n60.3,60.7,150.2,150.9,11\n260,200.4,350,200.4,11\n";
        fs::write(frame.path("two.csv"), table).unwrap();
        let [sky, none, plain] = ["sky.toml", "none.csv", "plain.fits"].map(|name| frame.path(name));
        done(&[
            &["inject", "--synthetic", &sky, "-o", &plain, "--streaks", &none, "--exposure", "30s"],
            &["--seeing", "2arcsec", "--pixels-only", "--quiet"],
        ]);
        frame
    }

    fn path(&self, name: &str) -> String {
        path(&self.folder, name)
    }

    /// Adds the streaks with this point spread function. Returns the added light.
    fn added(&self, psf: &[&str]) -> Vec<f64> {
        let [plain, table, output] = ["plain.fits", "two.csv", "out.fits"].map(|name| self.path(name));
        done(&[
            &[
                "inject",
                "--image",
                &plain,
                "-o",
                &output,
                "--streaks",
                &table,
                "--no-noise",
                "--pixels-only",
                "--quiet",
            ],
            psf,
        ]);
        let pairs = values(&plain, 0).into_iter().zip(values(&output, 0));
        pairs.map(|(before, after)| f64::from(after) - f64::from(before)).collect()
    }
}

/// Light in the left (0) or the right (1) half of a frame, and its middle and standard deviation along y.
fn half(added: &[f64], number: usize) -> [f64; 3] {
    let [mut sum, mut first, mut second] = [0.0; 3];
    for y in 0..ROWS {
        for x in 200 * number..200 * number + 200 {
            let light = added[y * COLUMNS + x];
            sum += light;
            first += light * (y as f64 + 1.0);
            second += light * (y as f64 + 1.0).powi(2);
        }
    }
    [sum, first / sum, (second / sum - (first / sum).powi(2)).max(0.0).sqrt()]
}

#[test]
fn verif_an_image_draws_streaks_of_its_shape_with_all_of_their_light() {
    /// Largest difference from the analytic profile, relative to the brightest pixel.
    const PROFILE: f64 = 0.01;
    let frame = Frame::new();
    // Standard deviation of 1.4 pixels, in cells of a quarter of a pixel, whose light is summed to pixels.
    let (fine, coarse) = (frame.path("fine.fits"), frame.path("coarse.fits"));
    fs::write(&fine, image(&[61, 61], gaussian(61, [5.6, 5.6]), &[card("OVERSAMP", 4)])).unwrap();
    let seeing = format!("{}arcsec", 1.4 * 2.354_82);
    let expected = frame.added(&["--psf", "gaussian", "--seeing", &seeing]);
    let found = frame.added(&["--psf", &fine]);
    let peak = expected.iter().copied().fold(0.0, f64::max);
    let difference = found.iter().zip(&expected).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(difference < PROFILE * peak, "{difference} {peak}");
    // The same with an even number of cells, whose light is that of the Gaussian in each cell.
    const EVEN: f64 = 0.003;
    let sigma = 2.8f64.hypot(12f64.recip().sqrt());
    fs::write(&coarse, image(&[61, 61], gaussian(61, [sigma, sigma]), &[card("OVERSAMP", 2)])).unwrap();
    let even = frame.added(&["--psf", &coarse]);
    let difference = even.iter().zip(&expected).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(difference < EVEN * peak, "{difference} {peak}");
    // A long image in x on pixels of the frame. Its sum is not 1.
    fs::write(&coarse, image(&[31, 31], gaussian(31, [3.0, 1.2]).map(|value| 7.0 * value), &[])).unwrap();
    for (psf, sigma) in [(vec!["--psf", &fine], 1.4f64.hypot(12f64.recip().sqrt())), (vec!["--psf", &coarse], 1.2)] {
        let added = frame.added(&psf);
        for number in [0, 1] {
            let sum = half(&added, number)[0];
            assert!((sum / counts() - 1.0).abs() < FLUX, "{psf:?}: {sum} {}", counts());
        }
        // The second streak is along x: its width in y is that of the image, whose centre is on the line.
        let [_, middle, width] = half(&added, 1);
        assert!((middle - 200.4).abs() < 2e-3, "{middle}");
        assert!((width - sigma).abs() < 0.02, "{width} {sigma}");
    }
    // The flag replaces the keyword.
    let same = frame.added(&["--psf", &fine, "--psf-oversampling", "4"]);
    assert_eq!(same, found);
    assert!(frame.added(&["--psf", &fine, "--psf-oversampling", "2"]) != found);
}

/// A streak is on its line wherever the star is in its image, of an odd or even number of pixels, also with an
/// oversampling.
#[test]
fn verif_the_centroid_of_an_image_is_on_the_line() {
    let frame = Frame::new();
    let file = frame.path("star.fits");
    for (sides, star, step) in [
        ([31, 31], [15.0, 17.0], 1.0),
        ([32, 30], [15.5, 14.5], 1.0),
        ([40, 41], [17.3, 22.6], 1.0),
        ([80, 80], [39.5, 39.5], 4.0),
        ([91, 80], [39.5, 36.0], 2.0),
    ] {
        let light = (0..sides[0] * sides[1]).map(|at| {
            let [x, y] = [(at % sides[0]) as f64 - star[0], (at / sides[0]) as f64 - star[1]];
            (-0.5 * (x * x + y * y) / (1.5 * step * 1.5 * step)).exp() as f32
        });
        fs::write(&file, image(&sides, light, &[card("OVERSAMP", step)])).unwrap();
        let [sum, middle, width] = half(&frame.added(&["--psf", &file]), 1);
        println!("{sides:?} {star:?} {step}: {sum} {middle} {width}");
        assert!((sum / counts() - 1.0).abs() < FLUX && (middle - 200.4).abs() < 5e-3, "{sides:?}: {middle}");
        assert!((width - 1.5).abs() < 0.05, "{sides:?}: {width}");
    }
}

#[test]
fn verif_a_file_of_psfex_changes_with_the_position() {
    let frame = Frame::new();
    let file = frame.path("stars.psf");
    let plane = |sigma: f64| gaussian(45, [sigma, sigma]).collect::<Vec<f32>>();
    // Samples every half pixel: standard deviation of 1.5 pixels.
    fs::write(&file, psfex(45, &[plane(3.0)], 0.5, 0, &[])).unwrap();
    let [sum, middle, width] = half(&frame.added(&["--psf", &file]), 1);
    assert!(
        (sum / counts() - 1.0).abs() < FLUX && (middle - 200.4).abs() < 2e-3 && (width - 1.5).abs() < 0.02,
        "{width}"
    );
    // The middle plus (X - 200) / 400 times a difference: narrow at the left, wide at the right.
    let [narrow, wide] = [2.4, 4.0]
        .map(|sigma: f64| plane(sigma).iter().map(|value| value / (sigma * sigma) as f32).collect::<Vec<f32>>());
    let mean: Vec<f32> = narrow.iter().zip(&wide).map(|(a, b)| 0.5 * (a + b)).collect();
    let slope: Vec<f32> = narrow.iter().zip(&wide).map(|(a, b)| b - a).collect();
    let zero = vec![0.0f32; 45 * 45];
    let planes = [mean.clone(), slope.clone(), zero.clone()];
    fs::write(&file, psfex(45, &planes, 0.5, 1, &[])).unwrap();
    let table = "x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n40,100.4,80,100.4,11\n320,100.4,360,100.4,11\n";
    fs::write(frame.path("two.csv"), table).unwrap();
    let added = frame.added(&["--psf", &file]);
    let [left, right] = [half(&added, 0), half(&added, 1)];
    for [sum, middle, _] in [left, right] {
        assert!((sum / counts() - 1.0).abs() < FLUX && (middle - 100.4).abs() < 2e-3, "{sum} {middle}");
    }
    // Variances of the mixtures at X = 60 and X = 340 in squares of the middles of 64 pixels (32.5 and 352.5).
    let variance = |x: f64| {
        let share = 0.5 + (x - 200.0) / 400.0;
        (1.0 - share) * 1.2f64.powi(2) + share * 2.0f64.powi(2)
    };
    assert!(
        (left[2] - variance(60.0).sqrt()).abs() < 0.1 && (right[2] - variance(340.0).sqrt()).abs() < 0.1,
        "{left:?} {right:?}"
    );
    assert!(right[2] > left[2] + 0.3, "{left:?} {right:?}");
    for (bytes, words) in [
        (psfex(45, &planes, 0.5, 1, &[("POLNAME1", "'FLUX_MAX'")]), "POLNAME1 is 'FLUX_MAX'; allowed"),
        (psfex(45, &planes, 0.5, 1, &[("POLDEG1", "2")]), "PSFAXIS3 is 3; allowed: 6"),
        (psfex(45, &planes, 0.5, 1, &[("PSF_SAMP", "0")]), "PSF_SAMP is 0; allowed"),
        (psfex(45, &planes, 0.5, 1, &[("PSFAXIS1", "46")]), "46 by 45 pixels; allowed: odd"),
    ] {
        fs::write(&file, bytes).unwrap();
        rejected(&frame, &["--psf", &file], words);
    }
}

/// Light of streaks beside the frame reaches it as far as the image does, and a polynomial is not extrapolated.
#[test]
fn verif_images_reach_the_frame_from_outside() {
    const SIDE: usize = 101;
    let frame = Frame::new();
    let [sky, none, plain] = ["sky.toml", "none.csv", "plain.fits"].map(|name| frame.path(name));
    let wide = unrounded()
        .replace("rows = 300", "rows = 40")
        .replace("pixel_scale_arcsec = 1.0", "pixel_scale_arcsec = 30.0")
        .replace("zero_point_1s_mag = 25.0", "zero_point_1s_mag = 18.0");
    fs::write(&sky, wide).unwrap();
    done(&[
        &["inject", "--synthetic", &sky, "-o", &plain, "--streaks", &none, "--exposure", "30s"],
        &["--seeing", "60arcsec", "--pixels-only", "--quiet"],
    ]);
    let file = frame.path("flat.fits");
    // A square of light, around which the border has none.
    let whole = SIDE + 2;
    let is_lit = |at: usize| [at / whole, at % whole].iter().all(|side| (1..=SIDE).contains(side));
    let square = (0..whole * whole).map(|at| f32::from(u8::from(is_lit(at))));
    fs::write(&file, image(&[whole, whole], square, &[])).unwrap();
    let with_streak = |x: f64| {
        fs::write(frame.path("two.csv"), format!("x1_pix,y1_pix,x2_pix,y2_pix,peak\n{x},5,{x},35,10\n")).unwrap();
        frame.added(&["--psf", &file])
    };
    for (x, columns) in [(-39.0, 11), (440.0, 11), (-3.0, 47)] {
        let added = with_streak(x);
        let lit = (0..COLUMNS).filter(|column| added[20 * COLUMNS + column] > 5.0).count();
        assert_eq!(lit, columns, "{x}");
    }
    // The mean plus (X - 200) / 400 times 1.9 of it has no light at X < -10.
    let plane: Vec<f32> = gaussian(45, [3.0, 3.0]).collect();
    let planes = [plane.clone(), plane.iter().map(|value| 1.9 * value).collect(), vec![0.0f32; 45 * 45]];
    let file = frame.path("stars.psf");
    fs::write(&file, psfex(45, &planes, 1.0, 1, &[])).unwrap();
    fs::write(frame.path("two.csv"), "x1_pix,y1_pix,x2_pix,y2_pix,peak\n-100,20,100,20,10\n").unwrap();
    let added = frame.added(&["--psf", &file]);
    assert!(added[19 * COLUMNS] > 1.0 && added[19 * COLUMNS + 50] > 1.0);
}

/// A table of degree 2 has the terms 1, x, x², y, xy, y².
#[test]
fn verif_terms_of_psfex_are_in_its_order() {
    let frame = Frame::new();
    let file = frame.path("stars.psf");
    let [narrow, wide] = [2.0, 4.0].map(|sigma: f64| -> Vec<f32> {
        gaussian(45, [sigma, sigma]).map(|value| value / (sigma * sigma) as f32).collect()
    });
    // Only the term of y changes the width: 1.5 wide + 0.5 narrow at the top, and the inverse at the bottom.
    let mean = narrow.iter().zip(&wide).map(|(a, b)| a + b).collect::<Vec<f32>>();
    let slope = narrow.iter().zip(&wide).map(|(a, b)| b - a).collect::<Vec<f32>>();
    let zero = vec![0.0f32; 45 * 45];
    let planes = [mean, zero.clone(), zero.clone(), slope, zero.clone(), zero];
    fs::write(&file, psfex(45, &planes, 0.5, 2, &[])).unwrap();
    let width = |y: f64| {
        let table = format!("x1_pix,y1_pix,x2_pix,y2_pix,magnitude\n300,{y},340,{y},11\n");
        fs::write(frame.path("two.csv"), table).unwrap();
        half(&frame.added(&["--psf", &file]), 1)[2]
    };
    let (bottom, top) = (width(40.0), width(260.0));
    assert!(top > bottom + 0.2, "{bottom} {top}");
}

fn rejected(frame: &Frame, psf: &[&str], words: &str) {
    let [plain, table, output] = ["plain.fits", "two.csv", "bad.fits"].map(|name| frame.path(name));
    let (code, _, error) = run(&[&["inject", "--image", &plain, "-o", &output, "--streaks", &table, "--quiet"], psf]);
    assert_eq!((code, error.trim().lines().count()), (2, 1), "{words}: {error}");
    assert!(error.contains(words), "{words}: {error}");
    assert!(!std::path::Path::new(&output).exists());
}

#[test]
fn invalid_point_spread_functions_give_one_line() {
    let frame = Frame::new();
    let file = frame.path("psf.fits");
    let ones = |count: usize| std::iter::repeat_n(1.0f32, count);
    for (bytes, words) in [
        (image(&[3, 3], (0..9).map(|at| if at == 4 { f32::NAN } else { 1.0 }), &[]), "NaN; allowed: finite"),
        (image(&[3, 3], ones(9).map(|one| -one), &[]), "sum of the point spread function is -9; allowed: above 0"),
        (image(&[3, 3], (0..9).map(|at| if at == 4 { 8.0001 } else { -1.0 }), &[]), "above 0.1 of the sum"),
        (image(&[5, 5], ones(25), &[]), "border of the point spread function is 100.0 % of its peak (median); allowed"),
        (image(&[31, 31], gaussian(31, [2.0, 2.0]).map(|value| value + 0.02), &[]), "is 2.0 % of its peak"),
        (image(&[3, 3, 3], ones(27), &[]), "missing; allowed: an image with two axes"),
        (image(&[1027, 3], ones(3081), &[]), "1027 by 3 pixels; allowed: sides up to 1025"),
        (
            image(&[1001, 3], (0..3003).map(|at| if at == 1501 { 1.0 } else { 0.0 }), &[]),
            "1001 pixels of the frame; allowed: at most 513",
        ),
        (image(&[21, 21], gaussian(21, [2.0, 2.0]), &[card("OVERSAMP", 2.5)]), "is 2.5; allowed: a whole number"),
        (b"no FITS file".to_vec(), "psf.fits"),
    ] {
        fs::write(&file, bytes).unwrap();
        rejected(&frame, &["--psf", &file], words);
    }
    fs::write(&file, image(&[21, 21], gaussian(21, [2.0, 2.0]), &[])).unwrap();
    rejected(&frame, &["--psf", &file, "--seeing", "1arcsec"], "--seeing");
    rejected(&frame, &["--psf", &file, "--psf-oversampling", "0"], "is 0; allowed: a whole number from 1 to 16");
    rejected(&frame, &["--psf", "gaussian", "--seeing", "1arcsec", "--psf-oversampling", "2"], "allowed: with a file");
    rejected(&frame, &["--psf", &frame.path("missing.fits")], "missing.fits");
    fs::write(frame.path("two.csv"), "x1_pix,y1_pix,x2_pix,y2_pix,magnitude,fwhm_pix\n60,60,150,150,11,3\n").unwrap();
    rejected(&frame, &["--psf", &file], "line 2: width of the streak is given; allowed");
}

/// A file with an empty primary HDU and an image in an extension.
fn in_extension(side: usize, values: impl Iterator<Item = f32>, primary: &[String]) -> Vec<u8> {
    let mut cards = vec![card("SIMPLE", "T"), card("BITPIX", 8), card("NAXIS", 0), card("EXTEND", "T")];
    cards.extend(primary.iter().cloned());
    let extension = [
        "XTENSION= 'IMAGE   '".to_owned(),
        card("BITPIX", -32),
        card("NAXIS", 2),
        card("NAXIS1", side),
        card("NAXIS2", side),
        card("PCOUNT", 0),
        card("GCOUNT", 1),
    ];
    [block(&cards), block(&extension), padded(values)].concat()
}

#[test]
fn the_oversampling_of_an_image_is_read_from_its_usual_keywords() {
    let frame = Frame::new();
    let file = frame.path("psf.fits");
    fs::write(&file, image(&[61, 61], gaussian(61, [5.6, 5.6]), &[card("OVERSAMP", 4)])).unwrap();
    let [_, _, expected] = half(&frame.added(&["--psf", &file]), 1);
    assert!((expected - 1.4).abs() < 0.1, "{expected}");
    for stated in
        [card("OVERSAMP", 4), card("DET_SAMP", 4), card("OVERSMPL", 4), card("OSAMP", 4), card("PSF_SAMP", 0.25)]
    {
        for bytes in [
            in_extension(61, gaussian(61, [5.6, 5.6]), std::slice::from_ref(&stated)),
            image(&[61, 61], gaussian(61, [5.6, 5.6]), std::slice::from_ref(&stated)),
        ] {
            fs::write(&file, bytes).unwrap();
            let [_, _, width] = half(&frame.added(&["--psf", &file]), 1);
            assert!((width - expected).abs() < 1e-6, "{stated}: {width} {expected}");
        }
    }
    // The header of the image comes before the primary header, and a number of no use is not 1.
    fs::write(&file, image(&[61, 61], gaussian(61, [5.6, 5.6]), &["OVERSAMP= 'four    '".to_owned()])).unwrap();
    rejected(&frame, &["--psf", &file], "is NaN; allowed: a whole number");
}

#[test]
fn a_scale_of_an_image_that_is_not_that_of_the_frame_is_an_error() {
    let frame = Frame::new();
    let plain = frame.path("plain.fits");
    let header = String::from_utf8_lossy(&fs::read(&plain).unwrap()[..2880 * 3]).into_owned();
    let of = |name: &str| {
        let at = header.find(&format!("{name:<8}= ")).unwrap() + 10;
        header[at..at + 20].trim().parse::<f64>().unwrap()
    };
    let scale_deg = of("CD1_1").hypot(of("CD2_1"));
    let file = frame.path("psf.fits");
    let scales = |cell_deg: f64| {
        [
            vec![card("PIXELSCL", 3600.0 * cell_deg)],
            vec![card("PIXSCALE", 3600.0 * cell_deg)],
            vec![card("CD1_1", -cell_deg), card("CD2_2", cell_deg)],
            vec!["CTYPE1  = 'RA---TAN'".to_owned(), card("CDELT1", -cell_deg), card("CDELT2", cell_deg)],
        ]
    };
    for cards in scales(0.25 * scale_deg) {
        fs::write(&file, image(&[61, 61], gaussian(61, [5.6, 5.6]), &cards)).unwrap();
        rejected(&frame, &["--psf", &file], "specify --psf-oversampling");
        rejected(&frame, &["--psf", &file], cards[cards.len().saturating_sub(2)][..8].trim());
        let [_, _, width] = half(&frame.added(&["--psf", &file, "--psf-oversampling", "4"]), 1);
        assert!((width - 1.4).abs() < 0.1, "{width}");
        fs::write(&file, image(&[61, 61], gaussian(61, [5.6, 5.6]), &[cards, vec![card("OVERSAMP", 4)]].concat()))
            .unwrap();
        frame.added(&["--psf", &file]);
    }
    for cards in scales(scale_deg) {
        fs::write(&file, image(&[31, 31], gaussian(31, [1.7, 1.7]), &cards)).unwrap();
        frame.added(&["--psf", &file]);
    }
    // Plain pixels.
    fs::write(&file, image(&[31, 31], gaussian(31, [1.7, 1.7]), &[card("CDELT1", 1.0), card("CDELT2", 1.0)])).unwrap();
    frame.added(&["--psf", &file]);
}

#[test]
fn a_border_with_a_share_of_the_light_is_a_warning() {
    let frame = Frame::new();
    let [plain, table, output, file] = ["plain.fits", "two.csv", "out.fits", "psf.fits"].map(|name| frame.path(name));
    for (sky, words) in [
        (0.005, "has 0.50 % of its peak (median): if this is a sky, 21 % of"),
        (-0.002, "has -0.20 % of its peak"),
        (0.0001, ""),
    ] {
        fs::write(&file, image(&[31, 31], gaussian(31, [1.7, 1.7]).map(|value| value + sky), &[])).unwrap();
        let (code, _, error) =
            run(&[&["inject", "--image", &plain, "-o", &output, "--streaks", &table, "--psf", &file]]);
        assert_eq!(code, 0, "{error}");
        assert_eq!(error.contains("border of the point spread function"), !words.is_empty(), "{error}");
        assert!(error.contains(words), "{error}");
        fs::remove_file(&output).unwrap();
    }
}
