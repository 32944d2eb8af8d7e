//! Distribution of the lateness of Starlink satellites by class, age, and source of the mean motion.
//!
//! ```text
//! (1 - m) [0.7 N(s) + 0.3 N(r s)] + m N(w)                                   s, each sigma at most 0.3413 P
//! ```
//!
//! The core of two Gaussians has the widths s and r s. The third Gaussian, of the share m and the width w, is for
//! satellites that manoeuvred since the epoch (w = 90 t, with the age t in days) or, in classes whose satellites change
//! their orbits, an ordinary part of the distribution. It is searched for in the latter case only.
//!
//! The coefficients were fitted on even catalogue numbers of the Starlink catalogues of June 2026: those of shells and
//! of raising satellites by `tests/reference/calibrate_starlink_lateness.py` (start days before and from 15 June on
//! have the same weight), those of rates and disagreeing sets without element sets of 15, 17, ..., 29 June.
//! `tests/reference/positions_by_age.py` compares them with odd numbers (docs/explanation/uncertainty.md). June was
//! quiet. Widths with one set are therefore up to 3 % (`Station`, `DirectToCell`) and 4 % (`StrongDrag`) above the most
//! probable ones. In the histories of 72 satellites until August, one sigma of `Station` contains 61-67 %.

use super::lateness::Lateness;
use super::station_keeping::{MeanMotion, StarlinkClass};

/// Weight of the inner Gaussian of the core.
const CORE_WEIGHT: f64 = 0.7;
/// Error along the track at epoch, s: 1 km at 7.6 km/s. It is added to widths that vanish at epoch.
const FLOOR_S: f64 = 0.13;
/// Time in which the noise between two element sets of a satellite in a shell rises, days: sets of one day share
/// observations.
const RISE_DAYS: f64 = 1.5;
/// The lateness does not depend on a smaller drag than this, s/day².
const LEAST_DRAG_S_DAY2: f64 = 0.01;
/// Width of the lateness of satellites that manoeuvred, s per day of age.
const MANOEUVRE_S_DAY: f64 = 90.0;
/// Factor of the core of two sets if there are four that do not all agree.
const DISAGREEING: f64 = 1.7;
/// Largest share of satellites that manoeuvred; the ages in the calibration end at 21 days.
const LARGEST_MANOEUVRING: f64 = 0.5;
/// Largest share of the wide Gaussian of classes whose satellites change their orbits.
const LARGEST_WIDE: f64 = 0.9;

/// The distribution before its widths are limited by the period.
struct Shape {
    /// s, seconds.
    core_s: f64,
    /// r.
    ratio: f64,
    /// m.
    share: f64,
    wide: Wide,
}

/// Third Gaussian.
enum Wide {
    /// Satellites that manoeuvred, w in seconds; not searched.
    Manoeuvred(f64),
    /// An ordinary part of the distribution, w in seconds.
    Ordinary(f64),
}

impl Shape {
    /// Class without an ordinary wide part; the share of manoeuvres is m₀ + m₁ t.
    fn steady(core_s: f64, ratio: f64, (m0, m1): (f64, f64), age: f64) -> Self {
        let share = (m0 + m1 * age).min(LARGEST_MANOEUVRING);
        Self { core_s, ratio, share, wide: Wide::Manoeuvred(MANOEUVRE_S_DAY * age) }
    }

    /// Class whose satellites change their orbits.
    fn changing(core_s: f64, ratio: f64, share: f64, wide_s: f64) -> Self {
        Self { core_s, ratio, share: share.min(LARGEST_WIDE), wide: Wide::Ordinary(wide_s) }
    }

    fn lateness(self, cap_s: f64) -> Lateness {
        let core_s = self.core_s.min(cap_s / self.ratio);
        let outer_s = self.ratio * core_s;
        let core = [(CORE_WEIGHT, core_s), (1.0 - CORE_WEIGHT, outer_s)];
        // The third Gaussian is at least as wide as the second.
        match self.wide {
            Wide::Manoeuvred(wide_s) => {
                Lateness::core_and_manoeuvres(core, (self.share, wide_s.max(outer_s).min(cap_s)))
            }
            Wide::Ordinary(wide_s) => Lateness::core_and_wings(core, (self.share, wide_s.max(outer_s).min(cap_s))),
        }
    }
}

/// Distribution of the delay at an age in days of either sign. `drag_s_day2` is D = |ṅ/2| P, `baseline_days` the time
/// from the epoch to that of the other element set (negative if that is older), and `cap_s` the sigma at which every
/// position along the orbit is equally likely.
pub(super) fn lateness(
    class: StarlinkClass,
    motion: MeanMotion,
    age_days: f64,
    drag_s_day2: f64,
    baseline_days: f64,
    cap_s: f64,
) -> Lateness {
    let age = age_days.abs();
    let shape = match motion {
        MeanMotion::OneSet => of_one_set(class, age, drag_s_day2),
        MeanMotion::TwoSets => of_two_sets(class, 1.0, age, age / baseline_days.abs()),
        MeanMotion::FourSets => of_four_sets(class, age),
        MeanMotion::Disagreeing => {
            let two = of_two_sets(class, 1.0, age, age / baseline_days.abs());
            Shape { core_s: DISAGREEING * two.core_s, ..two }
        }
        MeanMotion::Enclosed => of_enclosing_sets(class, age_days, baseline_days),
        MeanMotion::Shell => of_shell(class, age),
        MeanMotion::Arrived => of_arrived(class, age),
        MeanMotion::OffShell => off_shells(class, age),
        MeanMotion::Changed => of_changed_orbit(class, age, drag_s_day2),
        MeanMotion::Coasting => of_coasting(class, age, drag_s_day2),
        MeanMotion::Rate => Shape::changing(0.67_f64.hypot(3.8 * age.powf(2.45)), 1.0, 0.24, 66.0 * age.powf(1.17)),
        MeanMotion::NoRate => Shape::changing(FLOOR_S.hypot(age.powi(2)), 6.0, 0.42, 33.0 * age.powf(1.94)),
    };
    shape.lateness(cap_s)
}

/// √(a² + b² + c²).
fn norm3(a: f64, b: f64, c: f64) -> f64 {
    a.hypot(b).hypot(c)
}

#[rustfmt::skip]
fn of_one_set(class: StarlinkClass, t: f64, d: f64) -> Shape {
    // s = √(s₀² + (c D^q t)²)
    let core_s = |s0: f64, c: f64, q: f64| s0.hypot(c * d.max(LEAST_DRAG_S_DAY2).powf(q) * t);
    match class {
        // s = √(s₀² + (k t)² + (c D t)²)
        StarlinkClass::V15          => Shape::steady(norm3(0.295, 0.146 * t, 6.2 * d * t),   1.63, (0.072, 0.003), t),
        StarlinkClass::Station      => Shape::steady(core_s(0.445, 0.59, 0.20),              2.8,  (0.022, 0.0),   t),
        StarlinkClass::DirectToCell => Shape::steady(core_s(0.62, 1.12, 0.35),               2.6,  (0.012, 0.0),   t),
        StarlinkClass::StrongDrag   => Shape::steady(core_s(0.17, 0.22, 2.35),               2.9,  (0.070, 0.0),   t),
        StarlinkClass::Parked       => Shape::changing(norm3(0.07, 0.755 * d * t, FLOOR_S),  1.56, 0.128 + 0.057 * t, 55.0 * t.powi(2)),
        StarlinkClass::Descending   => Shape::steady(0.37_f64.hypot(0.097 * d * t.powf(2.25)), 5.8, (0.0, 0.0),    t),
        StarlinkClass::Raising      => Shape::changing(FLOOR_S.hypot(12.1 * t.powf(2.71)),     1.0,  0.30, 88.0 * t.powf(2.06)),
        StarlinkClass::MovingV15    => Shape::changing(0.83_f64.hypot(0.285 * d * t.powi(2)), 1.0, 0.70, 19.2 * t.powf(2.4)),
    }
}

/// `ratio` is t/Δ, `noise` a factor of s₀.
#[rustfmt::skip]
fn of_two_sets(class: StarlinkClass, noise: f64, t: f64, ratio: f64) -> Shape {
    // s = √(s₀² + b² t + (e t/Δ)²)
    let core_s = |s0: f64, b: f64, e: f64| norm3(noise * s0, b * t.sqrt(), e * ratio);
    match class {
        StarlinkClass::V15          => Shape::steady(core_s(0.164, 0.234, 0.445), 4.0, (0.013, 0.010), t),
        StarlinkClass::StrongDrag   => Shape::steady(core_s(0.57,  0.255, 0.767), 3.1, (0.014, 0.0),   t),
        StarlinkClass::DirectToCell => Shape::steady(core_s(0.525, 0.195, 0.52),  2.6, (0.0,   0.0),   t),
        StarlinkClass::Parked       => {
            // s = √(0.155² (1 + (1 + t/Δ)² + (t/Δ)²) + (0.125 t)²)
            let noise_s = 0.155 * norm3(1.0, 1.0 + ratio, ratio);
            Shape::changing(noise_s.hypot(0.125 * t), 5.1, 0.142 + 0.055 * t, 62.0 * t.powi(2))
        }
        _                           => Shape::steady(core_s(0.364, 0.259, 0.66),  3.4, (0.0,   0.0),   t),
    }
}

#[rustfmt::skip]
fn of_four_sets(class: StarlinkClass, t: f64) -> Shape {
    // s = √(s₀² + b² t + (k t)²)
    let core_s = |s0: f64, b: f64, k: f64| norm3(s0, b * t.sqrt(), k * t);
    match class {
        StarlinkClass::V15          => Shape::steady(core_s(0.188, 0.228, 0.060), 3.1,  (0.017, 0.009), t),
        StarlinkClass::StrongDrag   => Shape::steady(core_s(0.418, 0.307, 0.025), 2.35, (0.0,   0.0),   t),
        StarlinkClass::DirectToCell => Shape::steady(core_s(0.42,  0.20,  0.015), 2.45, (0.0,   0.0),   t),
        _                           => Shape::steady(core_s(0.363, 0.222, 0.050), 2.9,  (0.0,   0.0),   t),
    }
}

/// Noise of the element sets, and changes of the mean motion.
#[rustfmt::skip]
fn of_shell(class: StarlinkClass, t: f64) -> Shape {
    // s = √(s₀² + a² (1 - exp(-t/τ)) + b² t)
    let risen = (1.0 - (-t / RISE_DAYS).exp()).sqrt();
    let core_s = |s0: f64, a: f64, b: f64| norm3(s0, a * risen, b * t.sqrt());
    match class {
        StarlinkClass::V15          => Shape::steady(core_s(0.17,    0.216, 0.169), 3.2,  (0.005, 0.0096), t),
        StarlinkClass::StrongDrag   => Shape::steady(core_s(FLOOR_S, 0.70,  0.079), 2.05, (0.009, 0.001),  t),
        StarlinkClass::DirectToCell => Shape::steady(core_s(0.40,    0.189, 0.134), 2.2,  (0.003, 0.0),    t),
        _                           => Shape::steady(core_s(FLOOR_S, 0.441, 0.110), 2.9,  (0.010, 0.0004), t),
    }
}

/// Satellites that arrived at their shell a short time ago.
fn of_arrived(class: StarlinkClass, t: f64) -> Shape {
    match class {
        StarlinkClass::V15 => Shape::steady(FLOOR_S.hypot(0.241 * t.powf(0.405)), 10.0, (0.14, 0.0), t),
        StarlinkClass::DirectToCell => Shape::steady(FLOOR_S.hypot(0.49 * t.sqrt()), 10.0, (0.14, 0.0), t),
        _ => Shape::steady(0.51_f64.hypot(0.206 * t.sqrt()), 4.9, (0.038, 0.0), t),
    }
}

/// Satellites on their way to a shell, or away from one.
fn off_shells(class: StarlinkClass, t: f64) -> Shape {
    match class {
        StarlinkClass::V15 => Shape::changing(FLOOR_S.hypot(0.28 * t.powf(0.6)), 3.0, 0.45, 4.3 * t.powf(1.7)),
        StarlinkClass::DirectToCell => {
            Shape::changing(FLOOR_S.hypot(12.0 * t.powf(1.85)), 1.0, 0.30, 25.0 * t.powf(1.85))
        }
        StarlinkClass::StrongDrag => Shape::changing(FLOOR_S.hypot(1.6 * t.powf(2.53)), 3.5, 0.28, 83.0 * t.powf(1.17)),
        _ => Shape::changing(FLOOR_S.hypot(0.24 * t.powf(0.82)), 4.7, 0.48, 8.4 * t.powf(1.91)),
    }
}

/// Satellites that changed their orbits a short time ago, and may do so again.
fn of_changed_orbit(class: StarlinkClass, t: f64, d: f64) -> Shape {
    match class {
        StarlinkClass::Parked => of_one_set(StarlinkClass::Parked, t, d),
        StarlinkClass::DirectToCell => of_one_set(StarlinkClass::Raising, t, d),
        StarlinkClass::StrongDrag => {
            Shape::changing(FLOOR_S.hypot(0.77 * t), 8.3, 0.113 + 0.020 * t, 47.0 * t.powf(1.3))
        }
        _ => Shape::changing(FLOOR_S.hypot(0.62 * t), 3.0, 0.27, 7.0 * t.powf(1.75)),
    }
}

/// Satellites that do not cancel their drag, and may begin to.
fn of_coasting(class: StarlinkClass, t: f64, d: f64) -> Shape {
    let (growth, ratio, share) = if class == StarlinkClass::Parked { (0.2, 2.0, 0.08) } else { (0.3, 4.0, 0.11) };
    Shape::changing(0.2_f64.hypot(growth * d * t.powi(2)), ratio, share, 10.0 * d * t.powi(2))
}

/// Between the two epochs the error of the mean motion cancels: the prediction agrees with both element sets.
fn of_enclosing_sets(class: StarlinkClass, age_days: f64, baseline_days: f64) -> Shape {
    let ratio = age_days / baseline_days;
    if !(0.0..=1.0).contains(&ratio) {
        return of_two_sets(class, 1.0, age_days.abs(), ratio.abs());
    }
    // The errors of both sets, with the weights 1 - t/Δ and t/Δ. b² t becomes b² t (1 - t/Δ), as for a random walk with
    // both ends fixed, and e is 0.
    let noise = (1.0 - ratio).hypot(ratio);
    of_two_sets(class, noise, age_days.abs() * (1.0 - ratio), 0.0)
}
