//! Masks of satellites whose true positions differ from the predicted ones by the stated errors.

use std::path::Path;

use hifitime::Epoch;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use streakcast::elements::{Constellation, NoradId, Origin};
use streakcast::frames::{Direction, EopTable, seconds_after};
use streakcast::geometry::{Observer, Site};
use streakcast::images::{Card, CardValue, Header, ImageValues, NewImage, Pixels, write_frame};
use streakcast::passes::{Exposure, ExposureInterval, ModelChoice, Sky};
use streakcast::photometry::{ModelLibrary, PhotometryOptions};
use streakcast::streaks::{
    FrameMask, FrameOverrides, MaskOptions, MaskedStreak, Optics, SeeingForm, Shot, SkyPoint, SkyTrack, Source,
    SourceName, SourcePart, TargetFrame, Tracking, draw_on_chip, mask_frame,
};

// Required bounds, set before the first run.

/// Probability with which the streaks are to be covered, and half width of the accepted range of the share that is.
const COVERAGE: f64 = 0.95;
const SHARE_ERROR: f64 = 0.02;
/// A streak is covered if at least this share of the light in pixels above the noise is in the mask.
const COVERED_LIGHT: f64 = 0.99;
/// Smallest share of all light of all streaks in the masks: the wings of the streaks are below the noise.
const LEAST_LIGHT: f64 = 0.93;
/// Largest share of the masked pixels that no streak within the errors lights.
const LOST_PIXELS: f64 = 0.2;

const COLUMNS: usize = 1200;
const ROWS: usize = 1000;
const SCALE_ARCSEC: f64 = 12.0;
const SEEING_ARCSEC: f64 = 30.0;
const EXPOSURE_S: f64 = 30.0;
const NOISE: f64 = 10.0;
/// Magnitude of a star of one count.
const ZERO_POINT_MAG: f64 = 22.0;
/// Draws of the errors for each satellite.
const DRAWS: u64 = 60;
/// Steps from the middle to the side of a corridor.
const SIDE_STEPS: i32 = 8;
/// Smallest number of corridors in a comparison.
const LEAST_CORRIDORS: usize = 12;

/// Number of exposures of a comparison, and seconds between their starts.
const EXPOSURES: usize = 40;
const CADENCE_S: f64 = 30.0;

/// Writes a frame of noise at a position on the sky.
fn write(path: &Path) {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let normal = |random: &mut ChaCha8Rng| -> f64 { StandardNormal.sample(random) };
    let pixels = (0..ROWS * COLUMNS).map(|_| (1000.0 + NOISE * normal(&mut random)) as f32).collect::<Vec<f32>>();
    let values = ImageValues::new(COLUMNS, Pixels::F32(pixels.into())).unwrap();
    let mut header = Header::from_text(
        "CTYPE1  = 'RA---TAN'\nCTYPE2  = 'DEC--TAN'\nDATE-OBS= '2026-08-14T23:29:05'\nTIMESYS = 'UTC'\n",
    );
    let real = |number: f64| CardValue::Real(number);
    let step_deg = SCALE_ARCSEC / 3600.0;
    let keys = [
        ("CRVAL1", 198.9),
        ("CRVAL2", 7.7),
        ("CRPIX1", 0.5 * COLUMNS as f64),
        ("CRPIX2", 0.5 * ROWS as f64),
        ("CD1_1", -step_deg),
        ("CD1_2", 0.0),
        ("CD2_1", 0.0),
        ("CD2_2", step_deg),
        ("EXPTIME", EXPOSURE_S),
        ("MAGZERO", ZERO_POINT_MAG),
    ];
    keys.iter().for_each(|(key, number)| header.set(key, &real(*number), ""));
    let cards: &[Card] = header.cards();
    write_frame(path, &[NewImage { name: "", values: &values, cards, rice: None }]).unwrap();
}

/// Returns a sky of published element sets, whose age is given in days.
fn sky(start: Epoch, age_days: f64) -> Sky {
    let epoch = seconds_after(start, -86_400.0 * age_days);
    let mut sets = Constellation::by_name("starlink-gen1").unwrap().element_sets(epoch);
    for (number, set) in sets.iter_mut().enumerate() {
        set.norad_id = NoradId(90_001 + number as u32);
        set.name = format!("STARLINK-{}", 3001 + number).into();
        set.origin = Origin::Published;
    }
    let choice = ModelChoice::new(&ModelLibrary::embedded()).unwrap();
    Sky::with_models(sets, Observer::new(Site::from_mpc("X05").unwrap()), EopTable::embedded(), &choice)
}

fn options() -> MaskOptions {
    MaskOptions {
        coverage: COVERAGE,
        threshold: 1.0,
        min_probability: 0.01,
        width_arcsec: None,
        is_calibrated: true,
        optics: Optics {
            form: SeeingForm::Gaussian,
            seeing_arcsec: SEEING_ARCSEC,
            outer_radius_m: 0.0,
            inner_radius_m: 0.0,
        },
        photometry: PhotometryOptions::default(),
    }
}

/// Light of one drawn streak.
#[derive(Default, Clone)]
struct Drawn {
    all: f64,
    covered: f64,
    bright: f64,
    covered_bright: f64,
    /// Pixels above the noise, if the errors are within those that the corridor covers.
    lit: Vec<(usize, usize)>,
}

type Place<'a> = (&'a MaskedStreak, &'a TargetFrame, &'a ExposureInterval<'a>);

/// Draws the streak of a satellite that is late by `late_s` and `across_rad` beside its track.
fn drawn(place: Place<'_>, (late_s, across_rad): (f64, f64), magnitude: f64) -> Drawn {
    drawn_from(place, [late_s, 0.0], across_rad, magnitude)
}

/// Draws the part of the track of a satellite on time that a satellite passes that is late by `late_s`.
fn drawn_on_time(place: Place<'_>, late_s: f64, across_rad: f64, magnitude: f64) -> Drawn {
    drawn_from(place, [0.0, -late_s], across_rad, magnitude)
}

fn drawn_from(
    (streak, frame, interval): Place<'_>,
    [late_s, from_s]: [f64; 2],
    across_rad: f64,
    magnitude: f64,
) -> Drawn {
    let sky = interval.sky();
    let index = sky.elements().iter().position(|set| set.norad_id == streak.norad_id).unwrap();
    let track = interval.track(index, late_s).unwrap();
    let steps = 121;
    let point = |step: usize| {
        let time_s = EXPOSURE_S * step as f64 / (steps - 1) as f64;
        let (direction, rate) = track.direction(from_s + time_s);
        let across = direction.vector().cross(&rate).normalize();
        let direction = Direction::from_vector((direction.vector() + across * across_rad).normalize());
        SkyPoint { time_s, direction, range_km: 600.0, magnitude: Some(magnitude) }
    };
    let source = Source {
        name: SourceName::Random(1),
        mag_source: String::new(),
        element_age_days: None,
        hdu: None,
        image_fwhm_arcsec: None,
        parts: vec![SourcePart {
            label: "whole",
            track: SkyTrack { points: (0..steps).map(point).collect() },
            radius_m: 0.5 * sky.model(index).size_m(),
        }],
    };
    let chip = &frame.chips[streak.chip].chip;
    let (centre, _) = chip.circle().unwrap();
    let optics = options().optics;
    let shot = Shot {
        opened: frame.opened,
        exposure_s: EXPOSURE_S,
        centre,
        tracking: &Tracking::Sidereal,
        optics: &optics,
        truth_points: 2,
    };
    let mut light = Drawn::default();
    for one in draw_on_chip(&source, chip, &shot).unwrap() {
        for span in one.patch.iter() {
            for (column, value) in (span.first_column..).zip(span.values) {
                let value = f64::from(*value);
                let is_covered = streak.area.contains(span.row, column);
                light.all += value;
                light.covered += if is_covered { value } else { 0.0 };
                if value > NOISE {
                    light.bright += value;
                    light.covered_bright += if is_covered { value } else { 0.0 };
                    light.lit.push((span.row, column));
                }
            }
        }
    }
    light
}

/// Sums over all drawn streaks.
#[derive(Default)]
struct Sums {
    corridors: usize,
    draws: usize,
    covered: usize,
    light: f64,
    light_covered: f64,
    masked_pixels: usize,
    lost_pixels: usize,
}

/// Draws the errors of the satellites of a mask from their stated distributions, and compares the light with the mask.
fn compare(sky: &Sky, frame: &TargetFrame, sums: &mut Sums) {
    let mask: FrameMask = mask_frame(sky, frame, &[], &options()).unwrap();
    assert!(mask.left_out.is_empty(), "{:?}", mask.left_out);
    let (pointing, _) = frame.circle().unwrap();
    let exposure =
        Exposure { id: String::new(), start: frame.opened, duration_s: EXPOSURE_S, pointing, rotation_rad: 0.0 };
    let interval = sky.exposure_interval(&exposure).unwrap();
    for streak in &mask.streaks {
        let index = sky.elements().iter().position(|set| set.norad_id == streak.norad_id).unwrap();
        let propagator = interval.propagator(index).unwrap();
        let uncertainty = interval.uncertainty(index, propagator, 0.5 * EXPOSURE_S);
        let (_, bright_mag) = streak.brightness.as_ref().unwrap();
        let range_km = interval.sighting(propagator, 0.5 * EXPOSURE_S, 0.0).unwrap().range_km;
        let of_draw = |seed: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(seed * 1_000_003 + u64::from(streak.norad_id.0));
            let (along, across): (f64, f64) = (StandardNormal.sample(&mut random), StandardNormal.sample(&mut random));
            let mut part: f64 = random.random();
            let parts: Vec<(f64, f64)> = uncertainty.lateness.parts().collect();
            let chosen = parts.iter().find(|(weight, _)| {
                part -= weight;
                part < 0.0
            });
            let late_s = along * chosen.unwrap_or(&parts[0]).1;
            let across_rad = across * uncertainty.cross_track_km / range_km;
            // The corridor is for magnitudes up to the bright one.
            drawn((streak, frame, &interval), (late_s, across_rad), *bright_mag)
        };
        let all: Vec<Drawn> = (0..DRAWS).into_par_iter().map(of_draw).collect();
        for one in all.into_iter().filter(|one| one.bright > 0.0) {
            sums.draws += 1;
            sums.covered += usize::from(one.covered_bright >= COVERED_LIGHT * one.bright);
            sums.light += one.all;
            sums.light_covered += one.covered;
        }
        // Streaks in steps over the errors that the corridor covers.
        let steps = -SIDE_STEPS..=SIDE_STEPS;
        let errors: Vec<(i32, usize)> = steps.flat_map(|step| (0..2).map(move |end| (step, end))).collect();
        let of_step = |(step, end): &(i32, usize)| {
            let across_rad = streak.across_rad * f64::from(*step) / f64::from(SIDE_STEPS);
            // The track is that of a satellite on time, whose streak begins or ends by the largest delay earlier or
            // later.
            drawn_on_time((streak, frame, &interval), streak.late_s[*end], across_rad, *bright_mag).lit
        };
        let mut lit: Vec<(usize, usize)> = errors.par_iter().flat_map_iter(of_step).collect();
        lit.sort_unstable();
        lit.dedup();
        let used = lit.iter().filter(|(row, column)| streak.area.contains(*row, *column)).count();
        sums.corridors += 1;
        sums.masked_pixels += streak.area.pixels();
        sums.lost_pixels += streak.area.pixels() - used;
    }
}

fn verify(age_days: f64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frame.fits");
    write(&path);
    let open =
        |start: Option<Epoch>| TargetFrame::open(&path, &FrameOverrides { start, ..Default::default() }).unwrap();
    let start = open(None).opened;
    let sky = sky(start, age_days);
    let mut sums = Sums::default();
    for number in 0..EXPOSURES {
        compare(&sky, &open(Some(seconds_after(start, CADENCE_S * number as f64))), &mut sums);
    }
    let share = sums.covered as f64 / sums.draws as f64;
    let of_light = sums.light_covered / sums.light;
    let lost = sums.lost_pixels as f64 / sums.masked_pixels as f64;
    println!(
        "elements {age_days} d old: {} corridors of {:.2} % of the pixels, {} drawn streaks: {share:.4} covered, \
         {of_light:.4} of all light; {lost:.3} of the masked pixels lit by no draw",
        sums.corridors,
        100.0 * sums.masked_pixels as f64 / (sums.corridors * ROWS * COLUMNS) as f64,
        sums.draws,
    );
    assert!(sums.corridors >= LEAST_CORRIDORS, "{}", sums.corridors);
    assert!((share - COVERAGE).abs() <= SHARE_ERROR, "{share}");
    assert!(of_light >= LEAST_LIGHT, "{of_light}");
    assert!(lost <= LOST_PIXELS, "{lost}");
}

#[test]
fn verif_streaks_with_errors_of_fresh_elements_are_covered() {
    verify(0.3);
}

#[test]
fn verif_streaks_with_delays_of_seconds_are_covered() {
    verify(5.0);
}
