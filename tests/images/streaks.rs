//! Drawn streaks compared with GalSim, and with direct sums over points of the path.

use crate::common::agreement::Agreement;
use std::f64::consts::{PI, TAU};

use proptest::prelude::*;
use streakcast::images::{PixelPosition, Plane};
use streakcast::streaks::{Blur, RadialProfile, Seeing, draw_point};
use streakcast::streaks::{PathNode, StreakPath, draw};

/// Required accuracy, as a fraction of the peak and of the flux.
const PIXEL_TOLERANCE: f64 = 1e-3;
const FLUX_TOLERANCE: f64 = 1e-3;

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

/// Returns the path of a case through five nodes, which represent parabolas and linear ramps exactly.
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
    let mut pixels = Agreement::new("Streaks: values of pixels", "GalSim 2.8.5", PIXEL_TOLERANCE, "of the peak");
    let mut light = Agreement::new("Streaks: total flux", "GalSim 2.8.5", FLUX_TOLERANCE, "of the flux");
    for case in &cases {
        let profile = RadialProfile::on_oblong(&case.blur, case.aspect).expect("a profile");
        let patch = draw(&path_of(&case.path), &profile, 160, 160);
        let differences = case.pixels.iter().map(|(row, column, light)| {
            let difference = (f64::from(patch.at(*row, *column)) - light) / case.peak;
            (difference.abs(), (*row, *column))
        });
        let worst = differences.fold((0.0, (0, 0)), |a, b| if b.0 > a.0 { b } else { a });
        let peak = f64::from(patch.iter().flat_map(|span| span.values).fold(0.0_f32, |a, b| a.max(*b)));
        assert!(worst.0 < PIXEL_TOLERANCE, "{}: {worst:?}", case.name);
        assert!((peak / case.peak - 1.0).abs() < PIXEL_TOLERANCE, "{}: peak {peak}", case.name);
        assert!((patch.sum() / case.sum - 1.0).abs() < FLUX_TOLERANCE, "{}: {}", case.name, patch.sum());
        pixels.add(worst.0);
        light.add(patch.sum() / case.sum - 1.0);
    }
}

/// Point spread function computed from its definition by sums over the areas of the disks, tabulated by radius.
struct DirectProfile {
    step_pix: f64,
    values: Vec<f64>,
    sides_pix: [f64; 2],
    fwhm_pix: f64,
}

impl DirectProfile {
    fn of(blur: &Blur, aspect: f64) -> Self {
        let gaussian = |fwhm: f64, r: f64| {
            let sigma = fwhm / 2.354_820_045;
            (-0.5 * (r / sigma).powi(2)).exp() / (TAU * sigma * sigma)
        };
        let (fwhm_pix, reach_pix) = match blur.seeing {
            Seeing::Gaussian { fwhm_pix } => (fwhm_pix, 3.0 * fwhm_pix),
            Seeing::DoubleGaussian { fwhm_pix, wide_fwhm_pix, .. } => (fwhm_pix, 3.0 * wide_fwhm_pix),
            Seeing::Moffat { fwhm_pix, .. } => (fwhm_pix, 60.0 * fwhm_pix),
        };
        let seeing = |r: f64| match blur.seeing {
            Seeing::Gaussian { fwhm_pix } => gaussian(fwhm_pix, r),
            Seeing::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share } => {
                (1.0 - wide_share) * gaussian(fwhm_pix, r) + wide_share * gaussian(wide_fwhm_pix, r)
            }
            Seeing::Moffat { fwhm_pix, beta } => {
                let alpha = 0.5 * fwhm_pix / (2f64.powf(1.0 / beta) - 1.0).sqrt();
                (beta - 1.0) / (PI * alpha * alpha) * (1.0 + (r / alpha).powi(2)).powf(-beta)
            }
        };
        let step_pix = 0.01 * fwhm_pix;
        let count = ((reach_pix + blur.outer_radius_pix + blur.body_radius_pix) / step_pix) as usize;
        let sides_pix = [aspect.sqrt(), 1.0 / aspect.sqrt()];
        let values = (0..count).map(|node| seeing(node as f64 * step_pix)).collect();
        let mut profile = Self { step_pix, values, sides_pix, fwhm_pix };
        for [outer, inner] in [[blur.outer_radius_pix, blur.inner_radius_pix], [blur.body_radius_pix, 0.0]] {
            if outer > 0.0 {
                let places = area_nodes(inner, outer, fwhm_pix);
                let mean = |r: f64| {
                    places.iter().map(|[x, y]| profile.at((r + x).hypot(*y))).sum::<f64>() / places.len() as f64
                };
                let values = (0..count).map(|node| mean(node as f64 * step_pix)).collect();
                profile = Self { values, ..profile };
            }
        }
        profile
    }

    fn at(&self, r_pix: f64) -> f64 {
        let place = r_pix / self.step_pix;
        let node = place as usize;
        let Some([before, after]) = self.values.get(node..node + 2) else { return 0.0 };
        before + (place - node as f64) * (after - before)
    }

    /// Returns the mean over a pixel whose centre is at an offset from the source.
    fn pixel(&self, dx: f64, dy: f64) -> f64 {
        const GAUSS: [(f64, f64); 4] = [
            (-0.430_568_155_8, 0.173_927_422_6),
            (-0.169_990_521_8, 0.326_072_577_4),
            (0.169_990_521_8, 0.326_072_577_4),
            (0.430_568_155_8, 0.173_927_422_6),
        ];
        let [width, height] = self.sides_pix;
        if (dx * width).hypot(dy * height) > self.step_pix * self.values.len() as f64 + 2.0 {
            return 0.0;
        }
        let row = |(y, weight): &(f64, f64)| {
            let y = (dy + y) * height;
            weight * GAUSS.iter().map(|(x, weight)| weight * self.at(((dx + x) * width).hypot(y))).sum::<f64>()
        };
        GAUSS.iter().map(row).sum()
    }

    /// Returns points of a path with their light: Gauss-Legendre rules of four nodes in steps of half the full width at
    /// half maximum.
    fn points(&self, path: &StreakPath) -> Vec<(PixelPosition, f64)> {
        const GAUSS: [(f64, f64); 4] = [
            (0.069_431_844_2, 0.173_927_422_6),
            (0.330_009_478_2, 0.326_072_577_4),
            (0.669_990_521_8, 0.326_072_577_4),
            (0.930_568_155_8, 0.173_927_422_6),
        ];
        let mut points = Vec::new();
        for pair in path.nodes().windows(2) {
            let [from_s, to_s] = [pair[0].time_s, pair[1].time_s];
            let least_pix = self.sides_pix[0].min(self.sides_pix[1]);
            let at = |number: u32| path.point_at(from_s + (to_s - from_s) * f64::from(number) / 16.0);
            let fastest_pix = (0..16).map(|number| at(number).distance(at(number + 1)) * 16.0).fold(0.0, f64::max);
            let count = (2.0 * fastest_pix / (least_pix * self.fwhm_pix)).ceil().max(1.0);
            let duration_s = (to_s - from_s) / count;
            for number in 0..count as usize {
                for (share, weight) in GAUSS {
                    let time_s = from_s + (number as f64 + share) * duration_s;
                    points.push((path.point_at(time_s), weight * duration_s * path.rate_at(time_s)));
                }
            }
        }
        points
    }
}

/// Returns positions evenly spaced over the area of a ring.
fn area_nodes(inner: f64, outer: f64, fwhm: f64) -> Vec<[f64; 2]> {
    let radii = (32.0 * (outer - inner) / fwhm).ceil().clamp(32.0, 100.0) as usize;
    let angles = (12.0 * outer / fwhm).ceil().clamp(24.0, 200.0) as usize;
    let place = |number: usize| {
        let share = ((number / angles) as f64 + 0.5) / radii as f64;
        let r = (inner * inner + share * (outer * outer - inner * inner)).sqrt();
        let (sin, cos) = (TAU * ((number % angles) as f64 + 0.5) / angles as f64).sin_cos();
        [r * cos, r * sin]
    };
    (0..radii * angles).map(place).collect()
}

/// Returns the largest difference between a drawn streak and the direct sum, as a fraction of the peak, for pixels on
/// the path and others spread evenly over the frame.
fn difference(path: &StreakPath, blur: &Blur, aspect: f64, rows: usize, columns: usize) -> f64 {
    let profile = RadialProfile::on_oblong(blur, aspect).expect("a profile");
    let patch = draw(path, &profile, rows, columns);
    let direct = DirectProfile::of(blur, aspect);
    let points = direct.points(path);
    let (first_s, last_s) = (path.nodes()[0].time_s, path.nodes()[path.nodes().len() - 1].time_s);
    let on_path = (0..=48).map(|number| {
        // Pixels up to 5 pixels beside the path.
        let at = path.point_at(first_s + (last_s - first_s) * f64::from(number) / 48.0);
        [at.y + f64::from(number % 11) - 5.0, at.x + f64::from(number % 7) - 3.0].map(f64::round)
    });
    let on_path = on_path.chain((0..=48).map(|number| {
        let at = path.point_at(first_s + (last_s - first_s) * f64::from(number) / 48.0);
        [at.y.round(), at.x.round()]
    }));
    let is_inside =
        |[row, column]: &[f64; 2]| (0.0..rows as f64).contains(row) && (0.0..columns as f64).contains(column);
    let on_path = on_path.filter(is_inside).map(|[row, column]| (row as usize, column as usize));
    // The other pixels are spread by a golden-ratio sequence.
    let others = (0..100).map(|number| {
        let share = |step: f64| (f64::from(number) * step).fract();
        ((share(0.754_877_666) * rows as f64) as usize, (share(0.569_840_291) * columns as f64) as usize)
    });
    let (mut worst, mut peak) = (0.0_f64, 0.0_f64);
    for (row, column) in on_path.chain(others) {
        let light = |(at, light): &(PixelPosition, f64)| light * direct.pixel(column as f64 - at.x, row as f64 - at.y);
        let expected: f64 = points.iter().map(light).sum();
        let found = f64::from(patch.at(row, column));
        assert!(found.is_finite(), "{row} {column}");
        worst = worst.max((found - expected).abs());
        peak = peak.max(expected);
    }
    // If only wings reach the frame, the scale is the mean brightness on the middle line of the streak.
    let mean = path.total() * profile.line(0.0, 0.0) / path.length_pix().max(4.0 * profile.fwhm_pix());
    worst / peak.max(mean)
}

fn gaussian(fwhm_pix: f64) -> RadialProfile {
    RadialProfile::new(&Blur::seeing(Seeing::Gaussian { fwhm_pix })).expect("a profile")
}

fn ring() -> RadialProfile {
    RadialProfile::new(&ring_blur()).expect("a profile")
}

fn node(time_s: f64, x: f64, y: f64, rate: f64) -> PathNode {
    PathNode::new(time_s, PixelPosition { x, y }, rate)
}

fn path(nodes: Vec<PathNode>) -> StreakPath {
    StreakPath::new(nodes).expect("a path")
}

fn ring_blur() -> Blur {
    let seeing = Seeing::Moffat { fwhm_pix: 3.0, beta: 4.0 };
    Blur { seeing, outer_radius_pix: 6.0, inner_radius_pix: 3.5, body_radius_pix: 0.8 }
}

/// Returns blurs of all kinds, with the ratio of the sides of pixels.
fn blurs() -> Vec<(Blur, f64)> {
    let gaussian = |fwhm_pix| Blur::seeing(Seeing::Gaussian { fwhm_pix });
    let moffat = |fwhm_pix, beta| Blur::seeing(Seeing::Moffat { fwhm_pix, beta });
    let double =
        |fwhm_pix, wide_fwhm_pix| Blur::seeing(Seeing::DoubleGaussian { fwhm_pix, wide_fwhm_pix, wide_share: 0.3 });
    let ring = |fwhm_pix, outer_radius_pix| Blur {
        outer_radius_pix,
        inner_radius_pix: 0.6 * outer_radius_pix,
        body_radius_pix: 0.1 * outer_radius_pix,
        ..gaussian(fwhm_pix)
    };
    vec![
        (gaussian(1.0), 1.0),
        (gaussian(2.5), 1.0),
        (gaussian(3.5), 1.0),
        (gaussian(14.0), 1.0),
        (gaussian(48.0), 1.0),
        (moffat(1.2, 3.0), 1.0),
        (moffat(3.5, 4.765), 1.0),
        (moffat(3.5, 2.5), 1.0),
        (moffat(20.0, 4.765), 1.0),
        (double(3.0, 9.0), 1.0),
        (double(1.0, 20.0), 1.0),
        (ring_blur(), 1.0),
        (ring(3.5, 16.0), 1.0),
        (ring(15.8, 74.0), 1.0),
        (gaussian(3.5), 1.1),
        (gaussian(3.5), 2.5),
        (moffat(3.5, 2.5), 0.5),
        (ring(3.0, 9.0), 1.5),
    ]
}

type Way = fn(f64) -> (f64, f64);

/// Straight and bent paths with ends inside and outside the frame. The brightness jumps in the middle, and varies
/// smoothly before it.
#[test]
fn verif_every_blur_agrees_with_direct_sums() {
    let ways: [(&str, Way); 6] = [
        ("along a row", |t| (20.0 + 90.0 * t, 50.0)),
        ("along a column", |t| (60.3, 150.0 - 120.0 * t)),
        ("diagonally through pixel centres", |t| (90.0 - 100.0 * t, 90.0 - 100.0 * t)),
        ("bent", |t| (10.2 + 110.0 * t, 40.7 + 30.0 * t * (1.3 - t))),
        ("turning", |t| (70.0 + 30.0 * (3.0 * t).cos(), 50.4 + 30.0 * (3.0 * t).sin())),
        ("short", |t| (55.3 + 2.0 * t, 49.6 - 1.0 * t)),
    ];
    for (number, (blur, aspect)) in blurs().into_iter().enumerate() {
        for (name, way) in ways.iter().cycle().skip(number).take(3) {
            let nodes = (0..9).map(|i| {
                let t = f64::from(i) / 8.0;
                let (x, y) = way(t);
                let rate_after = (i == 5).then_some(2.5);
                PathNode { rate_after, ..node(t, x, y, 1.0 + 0.8 * (2.0 * t).sin()) }
            });
            let found = difference(&path(nodes.collect()), &blur, aspect, 100, 120);
            assert!(found < PIXEL_TOLERANCE, "{name}: {found} with {blur:?} {aspect}");
        }
    }
}

/// Long paths with a small bend, and narrow streaks with a large one.
#[test]
fn verif_long_lines_agree_with_direct_sums() {
    for (blur, aspect) in blurs().into_iter().take(9) {
        for (angle, bow) in [(0.003, 0.0), (0.6, 0.4), (2.5, 5.0), (6.0, 40.0)] {
            let nodes = (0..5).map(|i| {
                let t = f64::from(i) / 2.0 - 1.0;
                let (u, v) = (450.0 * t, bow * (t * t - 0.1));
                let at = [
                    48.3 + u * f64::cos(angle) - v * f64::sin(angle),
                    51.6 + u * f64::sin(angle) + v * f64::cos(angle),
                ];
                node(t, at[0], at[1], 1.0 + 0.1 * (t + 1.0) * (t + 1.5))
            });
            let found = difference(&path(nodes.collect()), &blur, aspect, 100, 120);
            assert!(found < PIXEL_TOLERANCE, "{angle} {bow}: {found} with {blur:?} {aspect}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Straight and bent paths of varying brightness, with a jump, partly outside the frame.
    #[test]
    fn verif_random_streaks_agree_with_direct_sums(
        x in -60.0..180.0_f64, y in -60.0..160.0_f64, log_length in -0.5..2.6_f64, angle in 0.0..(2.0 * PI),
        bend in -1.0..1.0_f64, rates in prop::array::uniform5(0.2..3.0_f64), jump in proptest::option::of(0.0..3.0_f64),
        kind in 0..4, fwhm_pix in 1.0..9.0_f64, beta in 2.3..5.0_f64, ring in 1.0..4.0_f64, log_aspect in -0.4..0.4_f64,
    ) {
        // Half of the paths have a small bend.
        let bend = if jump.is_some() { bend } else { bend.powi(5) };
        let nodes = (0..5).map(|i| {
            let t = f64::from(i) / 4.0;
            // Circular arc whose direction changes by twice `bend`.
            let phi = angle + bend * (2.0 * t - 1.0);
            let u = 10f64.powf(log_length) * t * if bend.abs() < 1e-6 { 1.0 } else { bend.sin() / bend };
            PathNode { rate_after: jump.filter(|_| i == 2), ..node(t, x + u * phi.cos(), y + u * phi.sin(), rates[i as usize]) }
        });
        let plain = Blur::seeing(Seeing::Gaussian { fwhm_pix });
        let (outer_radius_pix, inner_radius_pix) = (ring * fwhm_pix, 0.5 * ring * fwhm_pix);
        let (blur, aspect) = match kind {
            0 => (plain, 1.0),
            1 => (Blur::seeing(Seeing::Moffat { fwhm_pix, beta }), 1.0),
            2 => (Blur { outer_radius_pix, inner_radius_pix, body_radius_pix: 0.3 * fwhm_pix, ..plain }, 1.0),
            _ => (plain, log_aspect.exp()),
        };
        let found = difference(&path(nodes.collect()), &blur, aspect, 100, 120);
        prop_assert!(found < PIXEL_TOLERANCE, "{found} with {blur:?} {aspect}");
    }

    /// Flux and centroid of streaks inside the frame.
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
        // The required accuracy is 0.02 pixels.
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
            let profile = RadialProfile::new(&blur).expect("a profile");
            let size = 2 * profile.pixel_reach_pix().ceil() as usize + 3;
            let at = PixelPosition { x: size as f64 / 2.0 + 0.2, y: size as f64 / 2.0 - 0.4 };
            let patch = draw_point(&profile, at, 1000.0, size, size);
            assert!((patch.sum() / 1000.0 - 1.0).abs() < 1e-5, "{fwhm_pix} {beta} {outer}: {}", patch.sum());
            // If the profile is narrower than two pixels, the sampling by pixels shifts the centroid by exp(-2π²σ²)/π.
            let allowed = if fwhm_pix < 2.0 { 0.015 } else { 0.001 };
            assert!(patch.centroid().expect("light").distance(at) < allowed);
            if outer == 0.0 {
                assert!((profile.fwhm_pix() / fwhm_pix - 1.0).abs() < 1e-4, "{}", profile.fwhm_pix());
            }
        }
    }
    // Across a line, the light integrates to 1.
    let profile = gaussian(4.0);
    for angle in [0.0, 0.3, PI / 4.0] {
        let across: f64 = (-400..=400).map(|i| 0.05 * profile.line(0.05 * f64::from(i), angle)).sum();
        assert!((across - 1.0).abs() < 1e-5, "{across}");
    }
}

#[test]
fn verif_a_long_streak_is_even_along_itself_and_cheap_outside() {
    // A thousandth of the path is on the frame, at the middle of its brightness change.
    let path = path(vec![node(0.0, -2e6, -1e6, 3.0), node(1.0, 2e6, 1e6, 3.0)]);
    let profile = gaussian(3.5);
    let patch = draw(&path, &profile, 1000, 1000);
    let per_pixel = 3.0 / 4e6_f64.hypot(2e6);
    let expected = per_pixel * profile.line(0.0, 0.5_f64.atan());
    for column in [0_usize, 400, 600, 998] {
        let value = f64::from(patch.at(column / 2, column));
        assert!((value / expected - 1.0).abs() < PIXEL_TOLERANCE, "{column}: {value} {expected}");
    }
    // The streak spans 1000 columns and 500 rows of the frame, and its light extends 7.9 pixels to either side.
    assert!(patch.len() < 25_000, "{}", patch.len());
    // A frame that the streak does not touch stays empty.
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
    // The path reverses on the same pixels.
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
    let blur = *profile.blur();
    assert!(difference(&path, &blur, 1.0, 120, 160) < PIXEL_TOLERANCE);
    // The result is that of a path that begins where its brightness becomes positive.
    let patch = draw(&path, &profile, 120, 160);
    let shorter = StreakPath::new(vec![node(1.0, 60.0, 50.0, 5.0), node(3.0, 140.0, 90.0, 5.0)]).expect("a path");
    let shorter = draw(&shorter, &profile, 120, 160);
    assert!((patch.sum() / shorter.sum() - 1.0).abs() < 1e-6);
    assert!((patch.at(50, 60) / shorter.at(50, 60) - 1.0).abs() < 1e-4);
    assert_eq!(patch.at(30, 20), 0.0);
    // A path without light is empty.
    let dark = StreakPath::new(vec![node(0.0, 10.0, 10.0, 0.0), node(1.0, 90.0, 70.0, 0.0)]).expect("a path");
    assert_eq!(draw(&dark, &profile, 100, 100).sum(), 0.0);
    assert!(draw(&dark, &profile, 0, 0).is_empty());
}

#[test]
fn verif_rates_between_nodes() {
    // The interpolated brightness of a peak between dark nodes is not negative; a smooth curve is interpolated to 0.2
    // %.
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
    let (at_0, at_1) = (node(0.0, 1.0, 1.0, 1.0), node(1.0, 1.0, 1.0, 1.0));
    for (nodes, message) in [
        (vec![at_0], "number of nodes of the path is 1; allowed: 2 or more"),
        (
            vec![node(0.5, 1.0, 1.0, 1.0), node(0.5, 2.0, 1.0, 1.0)],
            "node 1: time is 0.5 s; allowed: at least 0.000000001 s after the previous node at 0.5 s",
        ),
        (
            vec![node(0.0, f64::NAN, 1.0, 1.0), at_1],
            "node 0: x is NaN; allowed: finite numbers (positions within 1e9 pixels)",
        ),
        (
            vec![at_0, node(1.0, 1.0, 1.0, f64::INFINITY)],
            "node 1: rate is inf; allowed: finite numbers (positions within 1e9 pixels)",
        ),
        (
            vec![node(0.0, 1.0, 1e10, 1.0), at_1],
            "node 0: y is 10000000000; allowed: finite numbers (positions within 1e9 pixels)",
        ),
        (vec![node(0.0, 1.0, 1.0, -1.0), at_1], "node 0: rate is -1 per second; allowed: 0 or more"),
    ] {
        assert_eq!(StreakPath::new(nodes).expect_err(message).to_string(), message);
    }
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
        assert!(RadialProfile::new(&blur).is_err(), "{blur:?}");
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
