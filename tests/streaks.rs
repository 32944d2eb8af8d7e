//! Streaks in pixels against GalSim, and the fast way of drawing them against sums over points of the path.

mod common;

use std::f64::consts::PI;

use proptest::prelude::*;
use streakcast::camera::{Blur, PixelPosition, Plane, RadialProfile, Seeing, draw_point};
use streakcast::streak::{PathError, PathNode, StreakPath, draw, draw_summed};

/// Of the peak: GalSim's FFTs are good to 10⁻⁶ or so, and 10⁻⁵ of our light lies nearer than it should.
const GALSIM_TOLERANCE: f64 = 1e-4;
/// Of the flux: what may be missing on the frame.
const FLUX_TOLERANCE: f64 = 1e-4;
/// Between the two ways of drawing, of the peak: curvature in first order, parabolas of 5·10⁻⁵ pixels.
const WAYS_TOLERANCE: f64 = 1e-4;

struct Case {
    name: String,
    blur: Blur,
    path: [f64; 8],
    peak: f64,
    sum: f64,
    pixels: Vec<(usize, usize, f64)>,
}

fn golden() -> Vec<Case> {
    let text = std::fs::read_to_string(common::golden_dir().join("streaks_golden.csv")).expect("goldens");
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
    assert!(cases.len() >= 25, "{}", cases.len());
    for case in &cases {
        let profile = RadialProfile::of(&case.blur).expect("a profile");
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
        }
    }
}
