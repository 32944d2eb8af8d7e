//! World coordinates compared with astropy and wcslib, and round trips.

use crate::common::agreement::Agreement;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use streakcast::ErrorKind;
use streakcast::frames::{Direction, Gcrs};
use streakcast::images::{Header, PixelPosition, Wcs};

/// Tolerance in both directions, pixels. Rounding is 1e-9 pixel for frames far from their CRPIX.
const TOLERANCE_PIX: f64 = 1e-6;

/// Tolerance of round trips, pixels: convergence of Newton's method and rounding.
const ROUND_TRIP_PIX: f64 = 1e-8;

struct Golden {
    place: PixelPosition,
    direction: Direction<Gcrs>,
}

/// Returns all golden values by header and HDU.
fn goldens() -> BTreeMap<(String, usize), Vec<Golden>> {
    let path = crate::common::golden_dir().join("wcs_golden.csv");
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("goldens");
    let mut found = BTreeMap::new();
    for record in reader.records() {
        let record = record.expect("a row");
        let number = |column: usize| record[column].parse::<f64>().expect("a number");
        let golden = Golden {
            place: PixelPosition { x: number(2), y: number(3) },
            direction: Direction::from_lon_lat_rad(number(4).to_radians(), number(5).to_radians()),
        };
        found.entry((record[0].to_owned(), record[1].parse().expect("an HDU"))).or_insert_with(Vec::new).push(golden);
    }
    found
}

#[track_caller]
fn compare(agreement: &mut Agreement, name: &str, header: &Header, goldens: &[Golden]) {
    let wcs = Wcs::from_header(header).unwrap_or_else(|error| panic!("{name}: {error}"));
    for golden in goldens {
        let place = golden.place;
        let found = wcs.to_pixel(golden.direction).unwrap_or_else(|| panic!("{name}: no pixel position of {place:?}"));
        assert!(
            found.distance(place) < TOLERANCE_PIX,
            "{name}: {place:?} is {found:?}, {} pix off",
            found.distance(place)
        );
        agreement.add(found.distance(place));
        let direction = wcs.to_sky(place).unwrap_or_else(|| panic!("{name}: {place:?} has no direction"));
        let miss_pix =
            direction.separation_rad(&golden.direction).to_degrees() * 3600.0 / wcs.pixel_scale_arcsec(place);
        assert!(miss_pix < TOLERANCE_PIX, "{name}: {place:?} is {miss_pix} pix off");
        agreement.add(miss_pix);
        let back = wcs.to_pixel(direction).unwrap_or_else(|| panic!("{name}: no way back from {place:?}"));
        assert!(back.distance(place) < ROUND_TRIP_PIX, "{name}: {place:?} comes back as {back:?}");
    }
}

fn invented(name: &str) -> Header {
    let path = crate::common::golden_dir().join("wcs").join(name);
    Header::from_text(&fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display())))
}

#[test]
fn valid_invented_headers_against_astropy() {
    let mut count = 0;
    let mut agreement = Agreement::new(
        "World coordinates, both directions, synthetic headers",
        "astropy 8.0.2",
        TOLERANCE_PIX,
        "pixel",
    );
    for ((name, _), rows) in goldens().iter().filter(|((name, _), _)| !name.contains('/')) {
        compare(&mut agreement, name, &invented(name), rows);
        count += 1;
    }
    assert!(count >= 12, "only {count} headers");
}

#[test]
fn valid_text_header_of_astrometry_net() {
    let Some(data) = crate::common::data_dir() else { return };
    let name = "frames/trailblazer/cutout_A3671-C2018_F4-R-3.txt";
    let rows = &goldens()[&(name.to_owned(), 0)];
    let mut agreement =
        Agreement::new("World coordinates, header of astrometry.net", "astropy 8.0.2", TOLERANCE_PIX, "pixel");
    compare(&mut agreement, name, &Header::from_text(&fs::read_to_string(data.join(name)).expect("the header")), rows);
}

#[cfg(all(feature = "fits", unix))]
#[test]
fn valid_real_headers_against_astropy() {
    use streakcast::images::FrameFile;
    let Some(data) = crate::common::data_dir() else { return };
    let mut count = 0;
    let mut agreement =
        Agreement::new("World coordinates, both directions, real frames", "astropy 8.0.2", TOLERANCE_PIX, "pixel");
    for ((name, hdu), rows) in goldens().iter().filter(|((name, _), _)| name.contains('/') && !name.ends_with(".txt")) {
        let file = FrameFile::open(&data.join(name)).unwrap_or_else(|error| panic!("{error}"));
        compare(&mut agreement, &format!("{name}[{hdu}]"), file.header(*hdu).expect("the HDU"), rows);
        count += 1;
    }
    assert!(count > 80, "only {count} headers");
}

fn lines(text: &str, changes: &[(&str, &str)]) -> Header {
    let mut text = text.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    Header::from_text(&text)
}

const PLAIN: &str = "NAXIS1  =                 1000\nNAXIS2  =                  800\nCTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nCRVAL1  =                 10.0
CRVAL2  =                 20.0\nCRPIX1  =                500.0\nCRPIX2  =                400.0\nCD1_1   =             -0.00007\nCD1_2   =                  0.0
CD2_1   =                  0.0\nCD2_2   =              0.00007\n";

#[test]
fn verif_unreadable_headers_give_a_reason() {
    for (changes, words) in [
        (vec![("'RA---TAN'", "'        '")], "CTYPE1 is \"\" and CTYPE2 is"),
        (vec![("RA---TAN", "GLON-TAN"), ("DEC--TAN", "GLAT-TAN")], "one RA---xxx and one DEC--xxx"),
        (vec![("TAN", "AIT")], "projection of CTYPE1 is \"AIT\"; allowed: TAN"),
        (vec![("RA---TAN", "RA---TAN-PLY"), ("DEC--TAN", "DEC--TAN-PLY")], "projection of CTYPE1 is \"TAN-PLY\""),
        (vec![("RA---TAN", "RA---TAN-TAB"), ("DEC--TAN", "DEC--TAN-TAB")], "projection of CTYPE1 is \"TAN-TAB\""),
        (vec![("DEC--TAN", "DEC--SIN")], "CTYPE2 is \"DEC--SIN\"; allowed: the projection of the other axis"),
        (vec![("CRPIX2  ", "CRPIX2X ")], "CRPIX2 is missing; allowed: a number"),
        (vec![("CRPIX2  =                400.0", "CRPIX2  = 'middle'")], "CRPIX2 is \"'middle'\"; allowed: a number"),
        (
            vec![("CD2_2   =              0.00007", "CD2_2   =                  0.0")],
            "allowed: a matrix that has an inverse",
        ),
        (
            vec![("CD1_1   =             -0.00007", "CD1_1   =                  nan")],
            "allowed: a matrix that has an inverse",
        ),
        (vec![("CRVAL2  =                 20.0", "CRVAL2  =                 95.0")], "CRVAL2 is 95 degrees"),
        (vec![("CD2_1", "CUNIT2  = 'pixel'\nCD2_1")], "CUNIT2 is \"pixel\"; allowed: deg"),
        (
            vec![("CD2_1", "RADESYS = 'FK4'\nEQUINOX = 1950.0\nCD2_1")],
            "reference system is FK4, equinox 1950; allowed: ICRS",
        ),
        (vec![("CD2_1", "EQUINOX = 1950.0\nCD2_1")], "a system without RADESYS, equinox 1950"),
        (vec![("CD2_1", "RADESYS = 'FK5'\nEQUINOX = 2020.4\nCD2_1")], "FK5, equinox 2020.4"),
        (
            vec![("CD2_1", "A_ORDER = 2\nB_ORDER = 2\nA_2_0 = 0.01\nA_2_0   = 0.01\nCD2_1")],
            "distortion (SIP) is folded",
        ),
    ] {
        let error = Wcs::from_header(&lines(PLAIN, &changes)).expect_err(words);
        assert!(error.to_string().contains(words), "{error}");
    }
    assert_eq!(Wcs::from_header(&Header::default()).unwrap_err().kind(), ErrorKind::NoCoordinates);
}

#[test]
fn verif_fk5_and_icrs_agree() {
    let plain = Wcs::from_header(&lines(PLAIN, &[])).expect("plain");
    for system in ["RADESYS = 'FK5'\nEQUINOX = 2000.0\n", "RADECSYS= 'ICRS'\n", "EQUINOX = 2000.0\n"] {
        let other = Wcs::from_header(&Header::from_text(&format!("{PLAIN}{system}"))).expect(system);
        assert_eq!(plain, other, "{system}");
    }
}

/// Along a great circle through the frame and far beyond it, pixel positions advance or do not exist.
#[test]
fn verif_a_track_far_outside_does_not_return() {
    for name in ["sip-no-suffix-no-inverse.hdr", "tpv-radial-dec-first.hdr", "tnx-chebyshev.hdr"] {
        let header = invented(name);
        let wcs = Wcs::from_header(&header).expect(name);
        let [columns, rows] = wcs.size();
        let centre = PixelPosition { x: columns as f64 / 2.0, y: rows as f64 / 2.0 };
        let middle = wcs.to_sky(centre).expect("the middle");
        let (east, north) = middle.east_north();
        for step in 0..12 {
            let (sine, cosine) = (f64::from(step) * std::f64::consts::FRAC_PI_6).sin_cos();
            let along = east * cosine + north * sine;
            let mut previous = f64::NEG_INFINITY;
            let mut inside = 0;
            let first =
                wcs.to_pixel(Direction::from_vector((middle.vector() + along * 1e-6).normalize())).expect("near");
            let (x, y) = (first.x - centre.x, first.y - centre.y);
            for at in -4000..=4000 {
                let direction = Direction::from_vector((middle.vector() + along * (f64::from(at) * 1e-4)).normalize());
                let Some(place) = wcs.to_pixel(direction) else { continue };
                let progress = ((place.x - centre.x) * x + (place.y - centre.y) * y) / x.hypot(y);
                assert!(progress > previous, "{name}: back at {place:?}");
                previous = progress;
                inside += 1;
            }
            assert!(inside > 20, "{name}: only {inside} places");
        }
    }
}

#[test]
fn verif_tangent_frames() {
    let centre = Direction::<Gcrs>::from_lon_lat_rad(3.2, -0.7);
    let wcs = Wcs::tangent(centre, 0.2, 0.5, 4000, 2000).expect("a frame");
    let middle = PixelPosition { x: 1999.5, y: 999.5 };
    assert!(wcs.to_pixel(centre).expect("inside").distance(middle) < 1e-9);
    assert!((wcs.pixel_scale_arcsec(middle) - 0.2).abs() < 1e-9);
    assert!((wcs.pixel_area_arcsec2(middle) - 0.04).abs() < 1e-9);
    // Rows increase towards position angle 0.5 rad, columns towards 0.5 rad - 90°.
    for (x, y, angle) in [(0.0, 10.0, 0.5), (-10.0, 0.0, 0.5 + std::f64::consts::FRAC_PI_2)] {
        let there = wcs.to_sky(PixelPosition { x: middle.x + x, y: middle.y + y }).expect("inside");
        assert!((centre.position_angle_rad(&there) - angle).abs() < 1e-9, "{x} {y}");
    }
    // The header cards give the same coordinates.
    let mut cards = Header::from_text("NAXIS1  = 4000\nNAXIS2  = 2000");
    cards.extend(wcs.cards());
    assert_eq!(Wcs::from_header(&cards).expect("its own cards"), wcs);
    // The opposite side of the sky has no pixel position.
    assert_eq!(wcs.to_pixel(-centre), None);
    assert!(Wcs::tangent(centre, 0.0, 0.0, 10, 10).is_err());
    assert_eq!(wcs.to_sky(PixelPosition { x: f64::NAN, y: 0.0 }), None);
}

#[test]
fn verif_golden_files_exist() {
    for (name, _) in goldens().keys().filter(|(name, _)| !name.contains('/')) {
        assert!(Path::new(&crate::common::golden_dir().join("wcs").join(name)).is_file(), "{name}");
    }
}

/// PVi_3 of the longitude axis is LONPOLE (paper II, section 2.5), unless the header has SCAMP's distortion.
#[test]
fn verif_native_pole_by_pv_of_the_longitude_axis() {
    let with = |cards: &str| Wcs::from_header(&lines(PLAIN, &[("CD2_1", &format!("{cards}\nCD2_1"))]));
    let at = PixelPosition { x: 700.0, y: 100.0 };
    let position = |cards: &str| with(cards).expect(cards).to_sky(at).expect("a position");
    let plain = position("EQUINOX = 2000.0");
    for (cards, lonpole) in [
        ("PV1_3   = 150.0", 150.0),
        ("PV1_3   = 150.0\nLONPOLE = 180.0", 150.0),
        ("LONGPOLE= 150.0", 150.0),
        ("PV1_1   = 0.0\nPV1_2   = 90.0\nPV1_3   = 10.0", 10.0),
    ] {
        let expected = position(&format!("LONPOLE = {lonpole:.1}"));
        assert!(position(cards).separation_rad(&expected) < 1e-12, "{cards}");
        assert!(plain.separation_rad(&expected).to_degrees() > 0.005, "{cards}");
    }
    let scamp = "PV1_0   = 0.0\nPV1_1   = 1.0\nPV1_2   = 0.0\nPV2_0   = 0.0\nPV2_1   = 1.0\nPV2_2   = 0.0";
    assert!(position(scamp).separation_rad(&plain) < 1e-12);
    // TAN has no parameters of the latitude axis: those without effect in either reading are ignored.
    for cards in ["PV2_1   = 0.0", "PV2_1   = 1.0", "PV2_0   = 0.0\nPV2_3   = 0.0"] {
        assert!(position(cards).separation_rad(&plain) < 1e-12, "{cards}");
    }
    for cards in ["PV2_1   = 1.001", "PV2_3   = 0.01\nLONPOLE = 180.0"] {
        let error = with(cards).expect_err(cards).to_string();
        assert!(error.contains("PV2_") && error.contains("CTYPE TPV"), "{error}");
    }
    assert!(position("PV2_5   = 0.01").separation_rad(&plain) > 1e-9);
    let error = with("PV1_1   = 5.0").expect_err("another reference point").to_string();
    assert!(error.contains("PV1_1 is 5; allowed: 0 (the reference point of TAN)"), "{error}");
}

/// Distortions in tables, and two matrices in one header.
#[test]
fn verif_ignored_terms_are_rejected() {
    let with = |cards: &str| Wcs::from_header(&lines(PLAIN, &[("CD2_1", &format!("{cards}\nCD2_1"))]));
    for (cards, words) in [
        ("CPDIS1  = 'LOOKUP'", "CPDIS1 is \"LOOKUP\"; allowed: world coordinates without distortion tables"),
        ("CPDIS2  = 'Polynomial'", "CPDIS2"),
        ("D2IMDIS1= 'Lookup'", "D2IMDIS1"),
        ("D2IMEXT = 'odd_d2i.fits'", "D2IMEXT"),
        ("DP1     = 'EXTVER: 1'", "DP1"),
        ("DQ2     = 'NAXES: 2'", "DQ2"),
        ("PC1_1   = -1.0\nPC2_2   = 1.0\nCDELT1  = 0.0001\nCDELT2  = 0.0001", "matrix of CDi_j is [[-7e-5"),
        ("PC1_1   = 0.0001", "remove the other from the header"),
        ("PC001001= 0.6\nPC001002= 0.8\nCDELT1  = -0.00007\nCDELT2  = 0.00007", "remove the other"),
    ] {
        let error = with(cards).expect_err(words).to_string();
        assert!(error.contains(words), "{error}");
    }
    for cards in [
        "PC1_1   = 1.0\nPC1_2   = 0.0\nPC2_1   = 0.0\nPC2_2   = 1.0",
        "PC1_1   = 1.0\nPC2_2   = 1.0\nCDELT1  = -0.00007\nCDELT2  = 0.00007",
        "PC1_1   = -0.00007\nPC2_2   = 0.00007",
        "CDELT1  = -0.0001\nCDELT2  = 0.0001\nCROTA2  = 30.0",
    ] {
        with(cards).unwrap_or_else(|error| panic!("{cards}: {error}"));
    }
}

/// Rotations of the old keywords CROTAi that contradict PCi_j or each other.
#[test]
fn verif_rotations_that_contradict_each_other_are_errors() {
    let with = |cards: &str| {
        let (head, tail): (Vec<&str>, Vec<&str>) = PLAIN.lines().partition(|line| line.starts_with("CD"));
        assert_eq!(head.len(), 4);
        Wcs::from_header(&Header::from_text(&format!(
            "{}\nCDELT1  = -0.0001\nCDELT2  = 0.0001\n{cards}\n",
            tail.join("\n")
        )))
    };
    for (cards, words) in [
        ("PC1_1   = 1.0\nPC2_2   = 1.0\nCROTA2  = 30.0", "CROTA2 is 30, but PCi_j"),
        ("PC1_1   = 0.866\nPC1_2   = -0.5\nPC2_1   = 0.5\nPC2_2   = 0.866\nCROTA2  = 30.0", "CROTA2 is 30"),
        ("CROTA1  = 30.0", "CROTA1 is 30, but CROTA2 is 0"),
        ("CROTA1  = 10.0\nCROTA2  = 30.0", "CROTA1 is 10, but CROTA2 is 30"),
    ] {
        let error = with(cards).expect_err(cards).to_string();
        assert!(error.contains(words), "{error}");
    }
    // A rotation of 30 degrees: PC1_2 = -sin ρ s₂/s₁ is positive, because s₁ is negative.
    let turned = "PC1_1   = 0.8660254\nPC1_2   = 0.5\nPC2_1   = -0.5\nPC2_2   = 0.8660254";
    for cards in ["CROTA2  = 30.0", "CROTA1  = 30.0\nCROTA2  = 30.0", turned, &format!("{turned}\nCROTA2  = 0.0")] {
        with(cards).unwrap_or_else(|error| panic!("{cards}: {error}"));
    }
    assert!(with(&format!("{turned}\nCROTA2  = 30.0")).is_ok());
}
