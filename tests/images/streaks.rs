//! Streaks in pixels against GalSim, and the fast way of drawing them against sums over points of the path.

use crate::common::agreement::Agreement;
use std::f64::consts::PI;

use proptest::prelude::*;
use streakcast::images::{PixelPosition, Plane};
use streakcast::streaks::{Blur, RadialProfile, Seeing, draw_point};
use streakcast::streaks::{PathError, PathNode, StreakPath, draw, draw_summed};

/// Of the peak: GalSim's FFTs are good to 10⁻⁶ or so, and 10⁻⁴ of our light lies nearer than it should, spread over the outermost wings.
const GALSIM_TOLERANCE: f64 = 1e-4;
/// Of the flux: what may be missing on the frame.
const FLUX_TOLERANCE: f64 = 1e-4;
/// Between the two ways of drawing, of the peak: curvature in first order, parabolas of 5·10⁻⁵ pixels.
const WAYS_TOLERANCE: f64 = 1e-4;

struct Case {
    name: String,
    blur: Blur,
    path: [f64; 8],
    aspect: f64,
    peak: f64,
    sum: f64,
    pixels: Vec<(usize, usize, f64)>,
}

fn golden() -> Vec<Case> {
    let text = std::fs::read_to_string(crate::common::golden_dir().join("streaks_golden.csv")).expect("goldens");
    let mut cases: Vec<Case> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| -> f64 { cells[at].parse().expect("a number") };
        if cells[0] == "case" {
            let seeing = match cells[2] {
                "gaussian" => Seeing::Gaussian { fwhm_pix: number(3) },
                "moffat" => Seeing::Moffat { fwhm_pix: number(3), beta: number(4) },
                "double" => {
                    Seeing::DoubleGaussian { fwhm_pix: number(3), wide_fwhm_pix: number(4), wide_share: number(5) }
                }
                other => panic!("{other}"),
            };
            cases.push(Case {
                name: cells[1].to_owned(),
                blur: Blur {
                    seeing,
                    outer_radius_pix: number(6),
                    inner_radius_pix: number(7),
                    body_radius_pix: number(8),
                },
                path: std::array::from_fn(|k| number(9 + k)),
                aspect: if cells.len() > 19 { number(19) } else { 1.0 },
                peak: number(17),
                sum: number(18),
                pixels: Vec::new(),
            });
        } else {
            let case = cases.last_mut().expect("a case before its pixels");
            case.pixels.push((number(0) as usize, number(1) as usize, number(2)));
        }
    }
    cases
}

/// The path of a case through five nodes: parabolas and ramps come out exact.
fn path_of(numbers: &[f64; 8]) -> StreakPath {
    let [x0, vx, ax, y0, vy, ay, r0, r1] = *numbers;
    let nodes = (0..5).map(|i| {
        let t = f64::from(i) / 4.0;
        let at = PixelPosition { x: x0 + t * (vx + t * ax), y: y0 + t * (vy + t * ay) };
        PathNode::new(t, at, r0 + t * r1)
    });
    StreakPath::new(nodes.collect()).expect("a path")
}

#[test]
fn valid_streaks_against_galsim() {
    let cases = golden();
    assert!(cases.len() >= 45, "{}", cases.len());
    let mut pixels = Agreement::new("Streaks, every pixel", "GalSim 2.8.5", GALSIM_TOLERANCE, "of the peak");
    let mut light = Agreement::new("Streaks, all light", "GalSim 2.8.5", FLUX_TOLERANCE, "of the light");
    for case in &cases {
        let profile = RadialProfile::on_oblong(&case.blur, case.aspect).expect("a profile");
        let path = path_of(&case.path);
        for (way, patch) in
            [("fast", draw(&path, &profile, 160, 160)), ("summed", draw_summed(&path, &profile, 160, 160))]
        {
            let differences = case.pixels.iter().map(|(row, column, light)| {
                let difference = (f64::from(patch.at(*row, *column)) - light) / case.peak;
                (difference.abs(), (*row, *column))
            });
            let worst = differences.fold((0.0, (0, 0)), |a, b| if b.0 > a.0 { b } else { a });
            let peak = f64::from(patch.iter().flat_map(|span| span.values).fold(0.0_f32, |a, b| a.max(*b)));
            if std::env::var_os("STREAKS_SHOW").is_some() {
                println!(
                    "{} {way}: worst {:.1e} of peak at {:?}, peak {:.1e}, sum {:.1e}",
                    case.name,
                    worst.0,
                    worst.1,
                    peak / case.peak - 1.0,
                    patch.sum() / case.sum - 1.0
                );
                continue;
            }
            assert!(worst.0 < GALSIM_TOLERANCE, "{} {way}: {worst:?}", case.name);
            assert!((peak / case.peak - 1.0).abs() < GALSIM_TOLERANCE, "{} {way}: peak {peak}", case.name);
            assert!((patch.sum() / case.sum - 1.0).abs() < FLUX_TOLERANCE, "{} {way}: {}", case.name, patch.sum());
            pixels.see(worst.0);
            light.see(patch.sum() / case.sum - 1.0);
        }
    }
}

fn gaussian(fwhm_pix: f64) -> RadialProfile {
    RadialProfile::of(&Blur::seeing(Seeing::Gaussian { fwhm_pix })).expect("a profile")
}

fn ring() -> RadialProfile {
    let seeing = Seeing::Moffat { fwhm_pix: 3.0, beta: 4.0 };
    let blur = Blur { seeing, outer_radius_pix: 6.0, inner_radius_pix: 3.5, body_radius_pix: 0.8 };
    RadialProfile::of(&blur).expect("a profile")
}

fn node(time_s: f64, x: f64, y: f64, rate: f64) -> PathNode {
    PathNode::new(time_s, PixelPosition { x, y }, rate)
}

fn path(nodes: Vec<PathNode>) -> StreakPath {
    StreakPath::new(nodes).expect("a path")
}

/// Greatest difference of two ways of drawing, of the peak.
fn difference(path: &StreakPath, profile: &RadialProfile, rows: usize, columns: usize) -> f64 {
    let (fast, summed) = (draw(path, profile, rows, columns), draw_summed(path, profile, rows, columns));
    let mut planes = [Plane::zeros(rows, columns), Plane::zeros(rows, columns)];
    fast.add_to(&mut planes[0]);
    summed.add_to(&mut planes[1]);
    let peak = planes[1].values().iter().copied().fold(0.0_f32, f32::max);
    let pairs = planes[0].values().iter().zip(planes[1].values());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0_f32, f32::max);
    // Where only wings reach the frame, of the mean brightness of the streak's middle line.
    let mean = path.total() * profile.line(0.0, 0.0) / path.length_pix().max(4.0 * profile.fwhm_pix());
    f64::from(worst) / f64::from(peak).max(mean)
}

/// The ways' difference for a streak of 900 pixels, bent by `bow` pixels at its ends, whose light grows by `ramp`; the ring's radius counts in FWHM.
fn difference_of_long(at: PixelPosition, angle: f64, bow: f64, ramp: f64, [fwhm_pix, ring]: [f64; 2]) -> f64 {
    let nodes = (0..5).map(|i| {
        let t = f64::from(i) / 2.0 - 1.0;
        let (u, v) = (450.0 * t, bow * (t * t - 0.1));
        let at =
            PixelPosition { x: at.x + u * angle.cos() - v * angle.sin(), y: at.y + u * angle.sin() + v * angle.cos() };
        PathNode::new(t, at, 1.0 + ramp * (t + 1.0) * (t + 1.5))
    });
    let outer = if ring > 1.0 { ring * fwhm_pix } else { 0.0 };
    let seeing = Seeing::Gaussian { fwhm_pix };
    let blur = Blur { seeing, outer_radius_pix: outer, inner_radius_pix: 0.6 * outer, body_radius_pix: 0.1 * outer };
    let profile = RadialProfile::of(&blur).expect("a profile");
    difference(&path(nodes.collect()), &profile, 200, 260)
}

/// Nodes that lie on pixels, or on normals through them: each pixel gets its light from one side of them alone.
#[test]
fn verif_pixels_on_the_normal_of_a_node_have_their_light_once() {
    type Way = fn(f64) -> (f64, f64);
    let nodes_at = |place: Way| {
        let node = |i: u32| {
            let (x, y) = place(f64::from(i));
            PathNode::new(0.3 * f64::from(i), PixelPosition { x, y }, 1.0)
        };
        path((0..8).map(node).collect())
    };
    let ways: [(&str, Way); 5] = [
        ("along a row", |i| (10.0 + 30.0 * i, 50.0)),
        ("along a column", |i| (60.0, -40.0 + 30.0 * i)),
        ("backwards", |i| (240.0 - 30.0 * i, 50.0)),
        ("diagonally", |i| (-60.0 + 30.0 * i, -60.0 + 30.0 * i)),
        ("bent", |i| (10.0 + 30.0 * i, 50.0 + 0.01 * (i - 3.0) * (i - 4.0))),
    ];
    for (name, way) in ways {
        for profile in [gaussian(3.0), gaussian(12.0), ring()] {
            let found = difference(&nodes_at(way), &profile, 120, 260);
            assert!(found < WAYS_TOLERANCE, "{name}: {found}");
        }
    }
}

/// The widest rings on lines that are as bent as the lattice allows: without what a curve adds to the light on its inner side, 2.5e-4 of the peak are lost.
#[test]
fn verif_wide_rings_on_lines_that_bend_a_little() {
    for angle in [0.3, 2.5, 6.028] {
        for bow in [0.4, 1.0, 2.0] {
            let found = difference_of_long(PixelPosition { x: 0.0, y: 0.0 }, angle, bow, 2e-4, [15.8, 4.7]);
            assert!(found < WAYS_TOLERANCE, "{angle} {bow}: {found}");
        }
    }
}

/// Wings that reach 67 pixels about an end, which far from it are cubics over squares: beyond the path, beside it, and on squares that lie on both sides of the normal. Of
/// straight lines, and of lines bent by about as much as half lines will still do for: 5 pixels in 4,000.
#[test]
fn verif_wide_wings_about_an_end() {
    // Of the peak: 8e-6 of the lattice and where points near the end are summed, 2e-6 of a cubic for each of both ways, a few 1e-6 of the bend.
    const TOLERANCE: f64 = 2e-5;
    let profile = RadialProfile::of(&Blur::seeing(Seeing::Moffat { fwhm_pix: 3.5, beta: 2.5 })).expect("a profile");
    // In the middle of the frame, and just outside of it.
    for (x, y) in [(110.3, 119.6), (-9.2, 57.5)] {
        for angle in [0.03, 0.6, 1.92, 4.0] {
            for (ramp, is_start, curvature) in
                [(0.0, true, 0.0), (0.1, true, 0.0), (0.1, false, 0.0), (0.0, true, 2.5e-6)]
            {
                let node = |time_s: f64| {
                    let way = 500.0 * if is_start { time_s } else { 1.0 - time_s };
                    let aside = 0.5 * curvature * way * way;
                    let at = PixelPosition {
                        x: x + way * f64::cos(angle) - aside * f64::sin(angle),
                        y: y + way * f64::sin(angle) + aside * f64::cos(angle),
                    };
                    PathNode::new(time_s, at, 1.0 + ramp * time_s)
                };
                let nodes = if curvature > 0.0 { vec![0.0, 0.25, 0.5, 0.75, 1.0] } else { vec![0.0, 1.0] };
                let found = difference(&path(nodes.into_iter().map(node).collect()), &profile, 230, 240);
                assert!(found < TOLERANCE, "{x} {angle} {ramp} {is_start} {curvature}: {found}");
            }
        }
    }
}

/// Seeing that is many drawn pixels wide: what an end's table of half lines has nodes for only farther out. Oblong pixels are drawn on finer ones.
#[test]
fn verif_ends_in_wide_seeing_and_on_oblong_pixels() {
    let gaussian = |fwhm_pix| Seeing::Gaussian { fwhm_pix };
    let moffat = |fwhm_pix, beta| Seeing::Moffat { fwhm_pix, beta };
    let double = Seeing::DoubleGaussian { fwhm_pix: 21.9, wide_fwhm_pix: 40.0, wide_share: 0.3 };
    for (seeing, aspect) in [
        (gaussian(14.0), 1.0),
        (gaussian(48.0), 1.0),
        (moffat(20.0, 4.765), 1.0),
        (double, 1.0),
        (gaussian(3.5), 1.1),
        (gaussian(3.5), 1.03),
        (moffat(3.5, 2.5), 1.1),
    ] {
        let profile = RadialProfile::on_oblong(&Blur::seeing(seeing), aspect).expect("a profile");
        for angle in [-0.03, 0.6, 1.9] {
            let place = |side: f64| [60.3 + 50.0 * side * f64::cos(angle), 49.6 + 50.0 * side * f64::sin(angle)];
            let node = |time_s: f64| {
                let [x, y] = place(2.0 * time_s - 1.0);
                node(time_s, x, y, 1.0)
            };
            let found = difference(&path(vec![node(0.0), node(1.0)]), &profile, 100, 120);
            assert!(found < WAYS_TOLERANCE, "{seeing:?} {aspect} {angle}: {found}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Any straight or bent path, brighter and fainter along it, with a jump, partly off the frame.
    #[test]
    fn verif_fast_and_summed_ways_agree(
        x in -60.0..260.0_f64, y in -60.0..260.0_f64, length in 1.0..400.0_f64, angle in 0.0..(2.0 * PI),
        bend in -0.15..0.15_f64, rates in prop::array::uniform5(0.2..3.0_f64), jump in proptest::option::of(0.0..3.0_f64),
        is_ring in any::<bool>(),
    ) {
        let nodes = (0..5).map(|i| {
            let t = f64::from(i) / 4.0;
            // A circle's arc that turns by `bend` times two.
            let phi = angle + bend * (2.0 * t - 1.0);
            let sinc = if bend.abs() < 1e-6 { 1.0 } else { bend.sin() / bend };
            let (u, v) = (length * t * sinc, 0.0);
            let at = PixelPosition { x: x + u * phi.cos() - v * phi.sin(), y: y + u * phi.sin() + v * phi.cos() };
            let rate_after = jump.filter(|_| i == 2);
            PathNode { time_s: t, at, rate: rates[i as usize], rate_after }
        });
        let path = path(nodes.collect());
        let profile = if is_ring { ring() } else { gaussian(3.0) };
        let found = difference(&path, &profile, 200, 210);
        prop_assert!(found < WAYS_TOLERANCE, "{found}");
    }

    /// The same with wings, where ends are drawn by half lines, or not where the path bends or brightens too much for these.
    #[test]
    fn verif_ends_with_wings_agree_with_sums(
        x in -20.0..130.0_f64, y in -20.0..120.0_f64, length in 0.5..300.0_f64, angle in 0.0..(2.0 * PI), log_bend in -6.0..-1.0_f64,
        log_ramp in -5.0..-0.2_f64, beta in 2.3..4.0_f64, fwhm_pix in 1.0..4.0_f64, jump in proptest::option::of(0.0..3.0_f64),
    ) {
        let (bend, ramp) = (10f64.powf(log_bend), 10f64.powf(log_ramp));
        let nodes = (0..5).map(|i| {
            let t = f64::from(i) / 4.0;
            let (u, v) = (length * t, length * bend * t * (t - 1.0));
            let at = PixelPosition { x: x + u * angle.cos() - v * angle.sin(), y: y + u * angle.sin() + v * angle.cos() };
            let rate_after = jump.filter(|_| i == 3);
            PathNode { time_s: t, at, rate: 1.0 + ramp * (t + t * t), rate_after }
        });
        let path = path(nodes.collect());
        let profile = RadialProfile::of(&Blur::seeing(Seeing::Moffat { fwhm_pix, beta })).expect("a profile");
        let found = difference(&path, &profile, 110, 120);
        prop_assert!(found < WAYS_TOLERANCE, "{found}");
    }

    /// Long and nearly straight ones, read from lattices where they turn by less than these allow, at any angle to the rows.
    #[test]
    fn verif_long_streaks_agree_with_sums(
        x in 0.0..260.0_f64, y in 0.0..200.0_f64, angle in 0.0..(2.0 * PI), is_shallow in any::<bool>(), log_bow in -4.0..1.0_f64,
        log_ramp in -4.0..0.5_f64, fwhm_pix in 2.5..16.0_f64, ring in 0.0..5.0_f64,
    ) {
        let angle = if is_shallow { 0.02 * angle } else { angle };
        let found = difference_of_long(PixelPosition { x, y }, angle, 10f64.powf(log_bow), 10f64.powf(log_ramp), [fwhm_pix, ring]);
        prop_assert!(found < WAYS_TOLERANCE, "{found}");
    }

    /// Light that lies on the frame is all there, and where it should be.
    #[test]
    fn verif_flux_and_centroid(
        x in 60.0..140.0_f64, y in 60.0..140.0_f64, length in 0.0..70.0_f64, angle in 0.0..(2.0 * PI), duration_s in 0.01..30.0_f64,
        is_ring in any::<bool>(),
    ) {
        let (dx, dy) = (0.5 * length * angle.cos(), 0.5 * length * angle.sin());
        let path = path(vec![node(1.0, x - dx, y - dy, 7.0), node(1.0 + duration_s, x + dx, y + dy, 7.0)]);
        let profile = if is_ring { ring() } else { gaussian(2.0) };
        let patch = draw(&path, &profile, 200, 200);
        prop_assert!((path.total() - 7.0 * duration_s).abs() < 1e-12 * path.total());
        prop_assert!((patch.sum() / path.total() - 1.0).abs() < FLUX_TOLERANCE, "{}", patch.sum() / path.total());
        let centroid = patch.centroid().expect("light");
        // Asked for: 0.02 pixels.
        prop_assert!(centroid.distance(PixelPosition { x, y }) < 0.001, "{centroid:?} of {x} {y}");
    }
}

#[test]
fn verif_flux_of_profiles_is_one() {
    for fwhm_pix in [1.0, 2.3, 3.5, 20.0] {
        for (beta, outer) in [(2.5, 0.0), (4.765, 0.0), (3.5, 9.0)] {
            let seeing = Seeing::Moffat { fwhm_pix, beta };
            let blur =
                Blur { seeing, outer_radius_pix: outer, inner_radius_pix: 0.6 * outer, body_radius_pix: 0.1 * outer };
            let profile = RadialProfile::of(&blur).expect("a profile");
            let size = 2 * profile.pixel_reach_pix().ceil() as usize + 3;
            let at = PixelPosition { x: size as f64 / 2.0 + 0.2, y: size as f64 / 2.0 - 0.4 };
            let patch = draw_point(&profile, at, 1000.0, size, size);
            assert!((patch.sum() / 1000.0 - 1.0).abs() < 1e-5, "{fwhm_pix} {beta} {outer}: {}", patch.sum());
            // The pixels themselves move what is narrower than two of them: by exp(-2π²σ²)/π.
            let allowed = if fwhm_pix < 2.0 { 0.015 } else { 0.001 };
            assert!(patch.centroid().expect("light").distance(at) < allowed);
            if outer == 0.0 {
                assert!((profile.fwhm_pix() / fwhm_pix - 1.0).abs() < 1e-4, "{}", profile.fwhm_pix());
            }
        }
    }
    // Half of a Gaussian's light lies within half its full width; a line's light across it is 1.
    let profile = gaussian(4.0);
    assert!((profile.half_light_pix() - 2.0).abs() < 1e-3);
    for angle in [0.0, 0.3, PI / 4.0] {
        let across: f64 = (-400..=400).map(|i| 0.05 * profile.line(0.05 * f64::from(i), angle)).sum();
        assert!((across - 1.0).abs() < 1e-5, "{across}");
    }
}

#[test]
fn verif_a_long_streak_is_even_along_itself_and_cheap_outside() {
    // The frame sees a thousandth of it, in the middle of its brightness.
    let path = path(vec![node(0.0, -2e6, -1e6, 3.0), node(1.0, 2e6, 1e6, 3.0)]);
    let profile = gaussian(3.5);
    let patch = draw(&path, &profile, 1000, 1000);
    let per_pixel = 3.0 / 4e6_f64.hypot(2e6);
    let expected = per_pixel * profile.line(0.0, 0.5_f64.atan());
    for column in [0_usize, 400, 600, 998] {
        let value = f64::from(patch.at(column / 2, column));
        assert!((value / expected - 1.0).abs() < 1e-4, "{column}: {value} {expected}");
    }
    // 1000 px wide, 500 px high, 7.9 px to each side.
    assert!(patch.len() < 25_000, "{}", patch.len());
    // In a frame that it does not touch there is nothing.
    assert!(draw(&path, &profile, 1000, 1).len() < 30);
    let beside = StreakPath::new(vec![node(0.0, -50.0, 500.0, 1.0), node(1.0, -20.0, 2000.0, 1.0)]).expect("a path");
    assert!(draw(&beside, &profile, 1000, 1000).is_empty());
}

#[test]
fn verif_what_hardly_moves_is_a_point() {
    let profile = ring();
    let at = PixelPosition { x: 50.3, y: 49.6 };
    let star = draw_point(&profile, at, 30.0, 100, 100);
    for drift in [0.0, 1e-7, 1e-3] {
        let path = path(vec![node(0.0, at.x - drift, at.y, 2.0), node(15.0, at.x + drift, at.y, 2.0)]);
        let patch = draw(&path, &profile, 100, 100);
        let worst = star.iter().flat_map(|span| {
            (span.first_column..).zip(span.values).map(move |(column, value)| (span.row, column, *value))
        });
        let worst = worst.map(|(row, column, value)| (patch.at(row, column) - value).abs()).fold(0.0_f32, f32::max);
        assert!(worst < 1e-5 * star.at(50, 47), "{drift}: {worst}");
    }
    // Back and forth over the same pixels: turning round is no trouble.
    let there = path(vec![node(0.0, 20.0, 50.0, 1.0), node(1.0, 80.0, 50.0, 1.0), node(2.0, 20.0, 50.3, 1.0)]);
    assert!((draw(&there, &gaussian(3.0), 100, 100).sum() / 2.0 - 1.0).abs() < FLUX_TOLERANCE);
}

#[test]
fn verif_jumps_and_dark_stretches() {
    let mut nodes = vec![
        node(0.0, 20.0, 30.0, 0.0),
        node(1.0, 60.0, 50.0, 0.0),
        node(2.0, 100.0, 70.0, 5.0),
        node(3.0, 140.0, 90.0, 5.0),
    ];
    nodes[1].rate_after = Some(5.0);
    nodes[3].rate_after = Some(9.0);
    let path = path(nodes);
    assert!((path.total() - 10.0).abs() < 1e-12, "{}", path.total());
    assert_eq!((path.rate_at(0.5), path.rate_at(1.5), path.rate_at(-0.1), path.rate_at(3.1)), (0.0, 5.0, 0.0, 0.0));
    assert!((path.length_pix() - 120.0_f64.hypot(60.0)).abs() < 1e-9);
    let profile = gaussian(3.5);
    assert!(difference(&path, &profile, 120, 160) < 1e-5);
    // As if it began where the light comes on.
    let patch = draw(&path, &profile, 120, 160);
    let shorter = StreakPath::new(vec![node(1.0, 60.0, 50.0, 5.0), node(3.0, 140.0, 90.0, 5.0)]).expect("a path");
    let shorter = draw(&shorter, &profile, 120, 160);
    assert!((patch.sum() / shorter.sum() - 1.0).abs() < 1e-6);
    assert!((patch.at(50, 60) / shorter.at(50, 60) - 1.0).abs() < 1e-4);
    assert_eq!(patch.at(30, 20), 0.0);
    // Without any light there is none.
    let dark = StreakPath::new(vec![node(0.0, 10.0, 10.0, 0.0), node(1.0, 90.0, 70.0, 0.0)]).expect("a path");
    assert_eq!(draw(&dark, &profile, 100, 100).sum(), 0.0);
    assert!(draw(&dark, &profile, 0, 0).is_empty());
}

#[test]
fn verif_rates_between_nodes() {
    // A glint between dark nodes does not swing below 0, a smooth curve is followed to two thousandths.
    let times: Vec<f64> = (0..11).map(f64::from).collect();
    let spike = path(times.iter().map(|t| node(*t, 10.0 * t, 0.0, if *t == 5.0 { 100.0 } else { 1.0 })).collect());
    let wave = path(times.iter().map(|t| node(*t, 10.0 * t, 0.0, 2.0 + (0.6 * t).sin())).collect());
    for i in 0..=1000 {
        let t = f64::from(i) / 100.0;
        assert!((0.0..=100.0 + 1e-9).contains(&spike.rate_at(t)), "{t}: {}", spike.rate_at(t));
        assert!((wave.rate_at(t) - 2.0 - (0.6 * t).sin()).abs() < 0.005, "{t}: {}", wave.rate_at(t));
        assert!((wave.point_at(t).x - 10.0 * t).abs() < 1e-9);
    }
}

#[test]
fn verif_nodes_that_make_no_path_are_named() {
    let error = |nodes: Vec<PathNode>| StreakPath::new(nodes).expect_err("an error");
    assert_eq!(error(vec![node(0.0, 1.0, 1.0, 1.0)]), PathError::TooFew { given: 1 });
    let twice = error(vec![node(0.5, 1.0, 1.0, 1.0), node(0.5, 2.0, 1.0, 1.0)]);
    assert_eq!(twice, PathError::Order { node: 1, time_s: 0.5, before_s: 0.5 });
    assert!(matches!(
        error(vec![node(0.0, f64::NAN, 1.0, 1.0), node(1.0, 1.0, 1.0, 1.0)]),
        PathError::NotFinite { node: 0, name: "x", .. }
    ));
    assert!(matches!(
        error(vec![node(0.0, 1.0, 1.0, 1.0), node(1.0, 1.0, 1.0, f64::INFINITY)]),
        PathError::NotFinite { name: "rate", .. }
    ));
    assert!(matches!(
        error(vec![node(0.0, 1.0, 1e10, 1.0), node(1.0, 1.0, 1.0, 1.0)]),
        PathError::NotFinite { name: "y", .. }
    ));
    assert!(
        matches!(error(vec![node(0.0, 1.0, 1.0, -1.0), node(1.0, 1.0, 1.0, 1.0)]), PathError::Negative { node: 0, given } if given == -1.0)
    );
}

#[test]
fn verif_blurs_outside_their_ranges_are_refused() {
    let gaussian = |fwhm_pix: f64| Seeing::Gaussian { fwhm_pix };
    let plain = Blur::seeing(gaussian(3.0));
    for blur in [
        Blur::seeing(gaussian(f64::NAN)),
        Blur::seeing(gaussian(0.09)),
        Blur::seeing(gaussian(1e3)),
        Blur::seeing(Seeing::Moffat { fwhm_pix: 3.0, beta: 1.5 }),
        Blur::seeing(Seeing::DoubleGaussian { fwhm_pix: 3.0, wide_fwhm_pix: 2.0, wide_share: 0.1 }),
        Blur::seeing(Seeing::DoubleGaussian { fwhm_pix: 3.0, wide_fwhm_pix: 6.0, wide_share: 1.5 }),
        Blur { outer_radius_pix: 500.0, ..plain },
        Blur { outer_radius_pix: 5.0, inner_radius_pix: 5.0, ..plain },
        Blur { body_radius_pix: -1.0, ..plain },
        Blur::seeing(Seeing::Moffat { fwhm_pix: 90.0, beta: 2.0 }),
    ] {
        assert!(RadialProfile::of(&blur).is_err(), "{blur:?}");
    }
}

#[test]
fn verif_patches_know_their_pixels() {
    let profile = gaussian(3.0);
    let patch = draw(&path(vec![node(0.0, -5.0, 20.0, 100.0), node(1.0, 30.0, 41.0, 100.0)]), &profile, 50, 60);
    let mut plane = Plane::zeros(50, 60);
    plane.values_mut().fill(10.0);
    patch.add_to(&mut plane);
    let added: f64 = plane.values().iter().map(|value| f64::from(*value) - 10.0).sum();
    assert!((added / patch.sum() - 1.0).abs() < 1e-4);
    let mask = patch.footprint(0.5);
    let in_mask: usize = mask.iter().map(|(_, columns)| columns.len()).sum();
    let above = patch.iter().flat_map(|span| span.values).filter(|value| **value >= 0.5).count();
    assert!(in_mask == above && above > 20, "{in_mask} {above}");
    for (row, columns) in mask {
        assert!(columns.clone().all(|column| patch.at(row, column) >= 0.5));
        assert!(columns.start == 0 || patch.at(row, columns.start - 1) < 0.5);
    }
    assert_eq!((patch.at(49, 0), patch.row(7_000).values.len()), (0.0, 0));
}

#[test]
fn verif_narrow_streaks_that_turn_are_followed() {
    // The narrower the profile, the more a square pixel's response changes with the angle: 1.6·10⁻⁴ of the peak from table to table once.
    let nodes = (0..9).map(|i| {
        let s = 50.0 * f64::from(i) - 200.0;
        node(f64::from(i), 200.0 + 0.8 * s - 6e-5 * s * s, 200.0 + 0.6 * s + 8e-5 * s * s, 1.0)
    });
    let found = difference(&path(nodes.collect()), &gaussian(1.0), 400, 400);
    assert!(found < WAYS_TOLERANCE, "{found}");
}
