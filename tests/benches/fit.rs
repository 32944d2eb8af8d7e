//! Time of a least-squares fit and of posterior sampling with the two-panel form, for the points in a file.
//!
//!     venv/bin/python tests/reference/make_fit_goldens.py --points 20000 points.csv
//!     cargo bench --bench fit -- points.csv [--steps 500] [--threads 1]
//!
//! Measures one descent from a fixed start (that of `peers/fit.py`), the search from many starts, and steps of 32
//! walkers, each without and with earthshine. Prints medians.

use std::time::Instant;

use streakcast::fit::{FitPoint, FitSettings, PosteriorSettings, Problem, TwoPanelForm, draw};
use streakcast::geometry::ViewingGeometry;
use streakcast::photometry::{Coefficients, Earthshine, SatelliteShape};

/// Start of every descent: c1 to c5 and both exponents.
const START: [f64; 7] = [0.05, 0.01, 0.01, 0.2, 0.1, 4.0, 12.0];
const NAMES: [&str; 7] = ["c1", "c2", "c3", "c4", "c5", "n_sail", "n_base"];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let Some(path) = arguments.iter().find(|argument| argument.ends_with(".csv")) else {
        println!("fit: no points given, nothing is timed (see the head of tests/benches/fit.rs)");
        return;
    };
    let option = |name: &str, otherwise: usize| {
        let at = arguments.iter().position(|argument| argument == name);
        at.and_then(|at| arguments.get(at + 1)?.parse().ok()).unwrap_or(otherwise)
    };
    let (steps, threads) = (option("--steps", 500), option("--threads", 0));
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().expect("threads");
    let points = read(path);
    for earthshine in [Earthshine::Off, Earthshine::Computed] {
        let form = TwoPanelForm {
            shape: SatelliteShape {
                sail_length_m: 8.1,
                sail_width_m: 2.8,
                base_length_m: 1.3,
                base_width_m: 2.8,
                panel_offset_deg: 0.0,
            },
            coefficients: Coefficients { c1: 0.0, c2: 0.0, c3: 0.0, c4: 0.0, c5: 0.0, n_sail: 1.0, n_base: 1.0 },
            earthshine,
            blocking: true,
            sun_magnitude: -26.76,
        };
        let began = Instant::now();
        let problem = Problem::new(&form, &points, &FitSettings::free(&NAMES)).expect("a problem");
        let prepared_s = began.elapsed().as_secs_f64();
        let mut descents: Vec<f64> = Vec::new();
        let mut end = problem.descend(&START);
        for _ in 0..15 {
            let began = Instant::now();
            end = problem.descend(&START);
            descents.push(began.elapsed().as_secs_f64());
        }
        let began = Instant::now();
        let fit = problem.solve().expect("a fit");
        let search_s = began.elapsed().as_secs_f64();
        let objective = problem.objective();
        let settings = PosteriorSettings { steps, burn_in: 0, walkers: 32, seed: 1 };
        let began = Instant::now();
        let chain = draw(&objective, &fit, &settings, None, |_| Ok(())).expect("a chain");
        let per_step_s = began.elapsed().as_secs_f64() / steps as f64;
        descents.sort_by(f64::total_cmp);
        println!(
            "earthshine {earthshine:?}: {} points, prepared {:.1} ms; descent {:.3} ms (cost {:.10}); search {:.1} ms (cost {:.10}); \
             32 walkers {:.3} ms a step ({:.1} s for 5000), acceptance {:.2}",
            points.len(),
            prepared_s * 1e3,
            descents[descents.len() / 2] * 1e3,
            end.cost,
            search_s * 1e3,
            fit.cost,
            per_step_s * 1e3,
            per_step_s * 5000.0,
            chain.acceptance(),
        );
    }
}

fn read(path: &str) -> Vec<FitPoint> {
    let text = std::fs::read_to_string(path).expect("points");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| {
        let n: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [sun, longitude, latitude] = [n[0], n[1], n[2]].map(f64::to_radians);
        let geometry = ViewingGeometry::from_angles(sun, longitude, latitude, 1000.0, 550.0).expect("a geometry");
        FitPoint { geometry, magnitude: n[3], sigma_mag: n[4], weight: 1.0, group: 0 }
    })
    .collect()
}
