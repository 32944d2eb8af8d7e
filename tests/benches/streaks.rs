//! Time to draw streaks into a 4096 x 4096 frame, and to apply detector effects to one frame.
//!
//!     cargo bench --bench streaks [-- --rounds 15]
//!
//! Prints medians on one core. `peers/streaks.py` measures the same cases with GalSim and NumPy and prints ratios. It
//! runs this benchmark with `--pixels FILE`, which writes the pixel values of the shortest Gaussian streak as 32-bit
//! floats for comparison.

use std::io::Write;
use std::time::Instant;

use streakcast::images::{Detector, PixelPosition, Plane};
use streakcast::streaks::{Blur, RadialProfile, Seeing};
use streakcast::streaks::{PathNode, StreakPath, draw};

const SIZE: usize = 4096;
/// Streaks as in `peers/streaks.py`: inclined to rows and columns, through the centre of the frame, with one count per
/// pixel of length.
const ANGLE_RAD: f64 = 0.7;

fn blurs() -> Vec<(&'static str, Blur)> {
    let gaussian = Seeing::Gaussian { fwhm_pix: 3.5 };
    let moffat = |beta: f64| Blur::seeing(Seeing::Moffat { fwhm_pix: 3.5, beta });
    vec![
        ("gaussian", Blur::seeing(gaussian)),
        ("moffat4.765", moffat(4.765)),
        ("moffat3.5", moffat(3.5)),
        ("moffat2.5", moffat(2.5)),
        ("ring", Blur { seeing: gaussian, outer_radius_pix: 7.8, inner_radius_pix: 4.8, body_radius_pix: 0.5 }),
    ]
}

/// Returns a straight path, or a parabola whose middle is `bow_pix` away from the chord, as caused by distortion.
fn streak(length_pix: f64, bow_pix: f64) -> StreakPath {
    let (sin, cos) = ANGLE_RAD.sin_cos();
    let node = |time_s: f64| {
        let side = 2.0 * time_s - 1.0;
        let (along, across) = (0.5 * side * length_pix, bow_pix * (1.0 - side * side));
        let at = PixelPosition { x: 2047.8 + along * cos - across * sin, y: 2047.4 + along * sin + across * cos };
        PathNode::new(time_s, at, length_pix)
    };
    let intervals = if bow_pix == 0.0 { 1 } else { 9 };
    StreakPath::new((0..=intervals).map(|k| node(f64::from(k) / f64::from(intervals))).collect()).expect("a path")
}

fn median_ms(rounds: usize, mut job: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let began = Instant::now();
            job();
            began.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[rounds / 2]
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| argument != "--bench").collect();
    let option = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name);
        at.and_then(|at| arguments.get(at + 1))
    };
    let rounds = option("--rounds").and_then(|rounds| rounds.parse().ok()).unwrap_or(15).max(1);
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("threads");
    let mut plane = Plane::zeros(SIZE, SIZE);
    plane.values_mut().fill(100.0);
    for (name, blur) in blurs() {
        let profile_ms = median_ms(rounds, || drop(RadialProfile::new(&blur).expect("a profile")));
        let profile = RadialProfile::new(&blur).expect("a profile");
        println!("{name} profile: {profile_ms:.3} ms (reach {:.0} pixels)", profile.reach_pix());
        let straight = [500.0, 1000.0, 2000.0, 4000.0, 8000.0].map(|length_pix| (length_pix, 0.0));
        // The last straight streak is longer than the diagonal of the frame, so that both ends are outside.
        for (length_pix, bow_pix) in straight.into_iter().chain([(4000.0, 0.5), (4000.0, 3.0)]) {
            let path = streak(length_pix, bow_pix);
            let mut pixels = 0;
            let drawn_ms = median_ms(rounds, || {
                let patch = draw(&path, &profile, SIZE, SIZE);
                patch.add_to(&mut plane);
                pixels = patch.len();
            });
            let bent = if bow_pix > 0.0 { format!(" bent by {bow_pix} pixels") } else { String::new() };
            println!("{name} {length_pix:.0}{bent}: {drawn_ms:.3} ms ({pixels} pixels)");
        }
        if let (Some(path), "gaussian") = (option("--pixels"), name) {
            let patch = draw(&streak(500.0, 0.0), &profile, SIZE, SIZE);
            let mut alone = Plane::zeros(SIZE, SIZE);
            patch.add_to(&mut alone);
            let bytes: Vec<u8> = alone.values().iter().flat_map(|value| value.to_le_bytes()).collect();
            std::fs::File::create(path).and_then(|mut file| file.write_all(&bytes)).expect("written");
        }
    }
    let detector = Detector::from_toml(
        "gain_e_adu = 1.5\nread_noise_e = 8\nsaturation = { full_well_e = 150000 }\nquantisation = {}",
    )
    .expect("a detector");
    let profile = RadialProfile::new(&blurs()[0].1).expect("a profile");
    let patches: Vec<_> = (1..6).map(|i| draw(&streak(700.0 * f64::from(i), 0.0), &profile, SIZE, SIZE)).collect();
    let added_ms = median_ms(rounds, || {
        detector.add_light(&mut plane, &patches, 1).expect("added");
    });
    println!("detector: 5 streaks added to a frame {added_ms:.1} ms");
    let exposed_ms = median_ms(3, || drop(detector.expose(&plane, 1).expect("exposed")));
    println!("detector: a whole frame exposed {exposed_ms:.0} ms");
}
