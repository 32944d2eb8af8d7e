//! Zero points and seeing from stars of known flux in synthetic frames.

use crate::common::is_all;
use hifitime::Epoch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use streakcast::Watch;
use streakcast::frames::Direction;
use streakcast::images::{LightArea, PixelPosition, Wcs};
use streakcast::measure::{Background, CatalogueStar, StarTable, StarZeroPoint, StreakImage, star_zero_point};
use streakcast::streaks::{Optics, SeeingForm, StarField, SyntheticFrame, SyntheticShot, Tracking};

// Required bounds, set before the first run.

/// Largest mean error of the zero points, mag; the same for the frames of each kind.
const BIAS_MAG: f64 = 0.01;
/// Largest error of each zero point: this number of sigmas plus this margin.
const SIGMAS: f64 = 4.0;
const MARGIN_MAG: f64 = 0.01;
/// Share of the zero points within one sigma. The range is wide, because the error of a median of few stars is not
/// normal. In the first run the share was 0.42, outside the range; since then sigma has a floor of 0.002 mag.
const WITHIN_ONE_SIGMA: std::ops::RangeInclusive<f64> = 0.55..=0.90;
/// Seeing of stars narrower than two pixels, and its largest relative error.
const NARROW_SEEING_ERRORS: [(f64, f64); 3] = [(0.8, 0.15), (1.0, 0.06), (1.5, 0.03)];
/// Largest relative error of the seeing.
const SEEING_ERROR: f64 = 0.03;

const SIDE: usize = 512;
const EXPOSURE_S: f64 = 30.0;
const GAIN: f64 = 2.0;
const ZERO_POINT_1S_MAG: f64 = 24.0;

/// Zero point of one count in the frame.
fn true_zero_point_mag() -> f64 {
    ZERO_POINT_1S_MAG + 2.5 * (EXPOSURE_S / GAIN).log10()
}

#[derive(Copy, Clone, Debug)]
struct Case {
    seeing_pix: f64,
    form: SeeingForm,
    /// Stars that are not in the table, in a million pixels.
    other_stars: f64,
    seed: u64,
    /// Error of the declinations in the table, arcsec.
    shift_arcsec: f64,
}

/// Positions in pixels and magnitudes of stars of the table.
fn scattered(count: usize, seed: u64) -> Vec<(PixelPosition, f64)> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |from: f64, to: f64| from + (to - from) * random.random::<f64>();
    (0..count)
        .map(|_| {
            let at = PixelPosition { x: uniform(60.0, 450.0), y: uniform(60.0, 450.0) };
            (at, uniform(11.5, 16.0))
        })
        .collect()
}

/// Measures the zero point of a frame with the given stars, of which those of the table may have wrong magnitudes.
fn measured(
    case: &Case,
    stars: &[(PixelPosition, f64)],
    table_mag: impl Fn(usize, f64) -> f64,
    assumed: Option<f64>,
) -> StarZeroPoint {
    let optics = Optics { form: case.form, seeing_arcsec: case.seeing_pix, outer_radius_m: 0.0, inner_radius_m: 0.0 };
    let shot = SyntheticShot {
        opened: "2026-08-14T23:29:05 UTC".parse::<Epoch>().unwrap(),
        exposure_s: EXPOSURE_S,
        centre: Direction::from_lon_lat_rad(1.0, 0.3),
        tracking: Tracking::Sidereal,
        optics: &optics,
        filter: "V",
        seed: case.seed,
        watch: &Watch::default(),
    };
    let text = format!(
        "columns = {SIDE}\nrows = {SIDE}\npixel_scale_arcsec = 1.0\nzero_point_1s_mag = {ZERO_POINT_1S_MAG}\n\
         sky_mag_arcsec2 = 20.0\n\
         detector = {{ gain_e_adu = {GAIN}, read_noise_e = 5, bias_adu = 300, saturation = {{ full_well_e = 100000 }}, \
         quantisation = {{ greatest_adu = 65535 }} }}"
    );
    let mut sky = SyntheticFrame::from_toml(&text, "test").unwrap();
    if case.other_stars > 0.0 {
        let (slope, brightest_mag, faintest_mag) = (0.3, 12.0, 19.0);
        sky.stars = Some(StarField { per_megapixel: case.other_stars, slope, brightest_mag, faintest_mag });
    }
    let wcs = Wcs::tangent(shot.centre, 1.0, 0.0, SIDE, SIDE).unwrap();
    let list = tempfile::NamedTempFile::new().unwrap();
    let rows = stars.iter().map(|(at, magnitude)| {
        let direction = wcs.to_sky(*at).unwrap();
        let [ra, dec] = [direction.longitude_rad(), direction.latitude_rad()].map(f64::to_degrees);
        format!("{ra:.9},{dec:.9},{magnitude}\n")
    });
    std::fs::write(list.path(), format!("ra_deg,dec_deg,magnitude\n{}", rows.collect::<String>())).unwrap();
    sky.star_list = Some(list.path().to_owned());
    let (plane, wcs) = sky.expose(&shot).unwrap();
    let mut table = StarTable::read(list.path()).unwrap().in_band(Some("V")).unwrap();
    table.iter_mut().enumerate().for_each(|(index, star)| {
        let latitude_rad = star.direction.latitude_rad() + (case.shift_arcsec / 3600.0).to_radians();
        let direction = Direction::from_lon_lat_rad(star.direction.longitude_rad(), latitude_rad);
        *star = CatalogueStar { magnitude: table_mag(index, star.magnitude), direction, ..*star };
    });
    let light_area = LightArea::whole(SIDE, SIDE);
    let image = StreakImage {
        plane: &plane,
        background: &Background::new(&plane, &light_area),
        light_area: &light_area,
        exposure_s: EXPOSURE_S,
        electrons_per_unit: Some(GAIN),
        saturation: Some(100_000.0 / GAIN + 300.0),
        pixel_scale_arcsec: 1.0,
        pixel_aspect: 1.0,
    };
    let is_known = assumed.is_some();
    // Seeing and form of a user who gives neither.
    let form = if is_known { case.form } else { SeeingForm::Moffat { beta: 3.5 } };
    let assumed_optics = Optics { seeing_arcsec: assumed.unwrap_or(4.0), form, ..optics };
    star_zero_point(&image, &wcs, &table, &assumed_optics, is_known, is_known, &Watch::default()).unwrap()
}

#[test]
fn verif_zero_points_of_stars_are_unbiased_and_errors_are_honest() {
    let mut cases = Vec::new();
    for seeing_pix in [2.5, 4.0, 6.0] {
        for form in [SeeingForm::Gaussian, SeeingForm::Moffat { beta: 4.0 }, SeeingForm::Moffat { beta: 2.75 }] {
            for other_stars in [0.0, 300.0] {
                for repeat in 0..if is_all() { 4 } else { 2 } {
                    cases.push(Case {
                        seeing_pix,
                        form,
                        other_stars,
                        seed: 100 * cases.len() as u64 + repeat,
                        shift_arcsec: 0.0,
                    });
                }
            }
        }
    }
    // Seeing and form are not given: they are measured.
    let found: Vec<(Case, StarZeroPoint)> = cases
        .into_par_iter()
        .map(|case| (case, measured(&case, &scattered(60, case.seed + 50), |_, magnitude| magnitude, None)))
        .collect();
    let mut within = 0;
    for (case, one) in &found {
        let zero_point = one.zero_point_mag.unwrap_or_else(|| panic!("{case:?}: {one:?}"));
        let error = zero_point.value - true_zero_point_mag();
        let seeing = one.shape.unwrap().seeing_arcsec / case.seeing_pix - 1.0;
        println!("{case:?}: {error:+.4} +- {:.4}, seeing {:+.2} %, {}", zero_point.sigma, 100.0 * seeing, one.counts());
        assert!(error.abs() <= SIGMAS * zero_point.sigma + MARGIN_MAG, "{case:?}: {error} +- {}", zero_point.sigma);
        assert!(seeing.abs() <= SEEING_ERROR, "{case:?}: {seeing}");
        within += usize::from(error.abs() <= zero_point.sigma);
    }
    let share = within as f64 / found.len() as f64;
    println!("within one sigma: {share:.2} of {}", found.len());
    assert!(WITHIN_ONE_SIGMA.contains(&share), "{share}");
    type Kind = fn(&Case) -> bool;
    let kinds: [(&str, Kind); 4] = [
        ("all", |_| true),
        ("alone", |case| case.other_stars == 0.0),
        ("with other stars", |case| case.other_stars > 0.0),
        ("Moffat", |case| case.form != SeeingForm::Gaussian),
    ];
    for (name, is_of_kind) in kinds {
        let errors: Vec<f64> = found
            .iter()
            .filter(|(case, _)| is_of_kind(case))
            .map(|(_, one)| one.zero_point_mag.unwrap().value - true_zero_point_mag())
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        println!("{name}: bias {mean:+.4} mag of {}", errors.len());
        assert!(mean.abs() <= BIAS_MAG, "{name}: {mean}");
    }
}

/// A given seeing that is wrong by a large factor is noticed: the width of the stars is measured all the same.
#[test]
fn verif_the_width_of_stars_is_measured_far_from_the_given_seeing() {
    let case = Case { seeing_pix: 6.0, form: SeeingForm::Gaussian, other_stars: 0.0, seed: 91, shift_arcsec: 0.0 };
    let stars = scattered(40, 92);
    for assumed in [1.0, 2.0] {
        let found = measured(&case, &stars, |_, magnitude| magnitude, Some(assumed));
        let seeing = found.shape.map_or(f64::NAN, |shape| shape.seeing_arcsec);
        println!("given {assumed}: {seeing}");
        assert!((seeing / case.seeing_pix - 1.0).abs() <= SEEING_ERROR, "{assumed}: {found:?}");
    }
}

/// Stars narrower than two pixels, whose light is in one or two pixels.
#[test]
fn verif_the_width_of_undersampled_stars_is_measured() {
    for (seeing_pix, largest_error) in NARROW_SEEING_ERRORS {
        for form in [SeeingForm::Gaussian, SeeingForm::Moffat { beta: 3.5 }] {
            let case = Case { seeing_pix, form, other_stars: 0.0, seed: 93, shift_arcsec: 0.0 };
            let found = measured(&case, &scattered(60, 94), |_, magnitude| magnitude, Some(seeing_pix));
            let (seeing, zero_point) =
                (found.shape.map_or(f64::NAN, |shape| shape.seeing_arcsec), found.zero_point_mag.unwrap());
            println!("{seeing_pix} {form:?}: {seeing:.3}, {:+.4}", zero_point.value - true_zero_point_mag());
            assert!((seeing / seeing_pix - 1.0).abs() <= largest_error, "{seeing_pix}: {found:?}");
            assert!((zero_point.value - true_zero_point_mag()).abs() <= BIAS_MAG, "{seeing_pix}: {found:?}");
        }
    }
}

#[test]
fn stars_that_cannot_be_used_are_counted() {
    let case =
        Case { seeing_pix: 3.0, form: SeeingForm::Moffat { beta: 3.5 }, other_stars: 0.0, seed: 7, shift_arcsec: 0.0 };
    // A grid of 20 good stars, then 2 saturated ones, 3 at the edge, 2 beside each other, 2 faint ones, and 3 whose
    // magnitudes in the table are wrong by one magnitude. One star is outside the frame.
    let grid = |index: usize, magnitude: f64| {
        let (x, y) = (70.0 + 60.0 * (index % 7) as f64, 70.0 + 60.0 * (index / 7) as f64);
        (PixelPosition { x, y }, magnitude)
    };
    let mut stars: Vec<_> = (0..20).map(|index| grid(index, 13.0 + 0.05 * index as f64)).collect();
    stars.extend((20..22).map(|index| grid(index, 10.5)));
    stars.extend([(4.0, 100.0), (8.0, 200.0), (509.0, 300.0)].map(|(x, y)| (PixelPosition { x, y }, 13.0)));
    let (beside, _) = grid(22, 0.0);
    stars.extend([0.0, 6.0].map(|shift| (PixelPosition { x: beside.x + shift, y: beside.y }, 13.0)));
    stars.extend((24..26).map(|index| grid(index, 19.0)));
    stars.extend((27..30).map(|index| grid(index, 13.0)));
    stars.push((PixelPosition { x: -30.0, y: 250.0 }, 13.0));
    let outliers = stars.len() - 4..stars.len() - 1;
    let wrong = |index: usize, magnitude: f64| if outliers.contains(&index) { magnitude - 1.0 } else { magnitude };
    let found = measured(&case, &stars, wrong, Some(3.0));
    let counts = (found.used, found.saturated, found.edge, found.blended, found.faint, found.outliers);
    assert_eq!(counts, (20, 2, 3, 2, 2, 3), "{found:?}");
    assert_eq!(found.counts(), "stars used: 20; omitted: 2 saturated, 3 at the edge, 2 blended, 2 faint, 3 outliers");
    let zero_point = found.zero_point_mag.unwrap();
    assert!((zero_point.value - true_zero_point_mag()).abs() <= SIGMAS * zero_point.sigma + MARGIN_MAG);
    // Two stars are too few.
    let few = measured(&case, &stars[..2], |_, magnitude| magnitude, Some(3.0));
    assert!(few.zero_point_mag.is_none() && few.used == 2, "{few:?}");
    let none = measured(&case, &stars[24..25], |_, magnitude| magnitude, Some(3.0));
    assert!(none.zero_point_mag.is_none() && none.used == 0, "{none:?}");
}

#[test]
fn stars_that_are_not_at_their_positions_give_no_zero_point() {
    let form = SeeingForm::Gaussian;
    for (shift_arcsec, other_stars) in [(8.0, 0.0), (-8.0, 0.0), (30.0, 0.0), (8.0, 300.0)] {
        let case = Case { seeing_pix: 3.0, form, other_stars, seed: 95, shift_arcsec };
        for assumed in [None, Some(3.0)] {
            let found = measured(&case, &scattered(40, 96), |_, magnitude| magnitude, assumed);
            assert!(found.zero_point_mag.is_none() && found.used == 0, "{shift_arcsec}: {found:?}");
            let cause = "the world coordinates of the frame or the positions of the stars (epoch) are wrong";
            // Farther away, no star has light at its position.
            assert!(shift_arcsec > 8.0 || found.counts().ends_with(cause), "{shift_arcsec}: {}", found.counts());
        }
    }
    // An error within the reach of the centroid.
    let case = Case { seeing_pix: 3.0, form, other_stars: 0.0, seed: 95, shift_arcsec: 1.0 };
    let found = measured(&case, &scattered(40, 96), |_, magnitude| magnitude, None);
    assert!((found.zero_point_mag.unwrap().value - true_zero_point_mag()).abs() <= BIAS_MAG, "{found:?}");
    // A table of magnitudes that are those of other stars.
    let found = measured(&case, &scattered(40, 96), |index, _| 11.5 + 0.1 * (index * 17 % 40) as f64, None);
    assert!(found.zero_point_mag.is_none() && found.counts().contains("scatter by"), "{found:?}");
    // A table of another field.
    let case = Case { shift_arcsec: 3600.0, ..case };
    let found = measured(&case, &scattered(40, 96), |_, magnitude| magnitude, None);
    assert_eq!(found.counts(), "stars used: 0; omitted: 40 outside of the frame");
}
