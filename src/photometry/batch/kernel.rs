//! The two-panel model over arrays of angles.
//!
//! The same formulas as `satellite` and `blocking`, written without branches over fixed blocks of directions; the compiler
//! turns each loop into vectors of four or eight. Which instructions the machine has is found out at run time.

use std::f64::consts::{FRAC_1_PI, LN_10, TAU};

use pulp::{Arch, NullaryFnOnce};

use crate::math::elementary::{exp, fused, ln, ln_two, sin_cos};
use crate::photometry::satellite::TwoPanelNumbers;

/// Directions of Sun and observer in the body frame as columns of one length, radians; a shorter column cuts the others.
#[derive(Copy, Clone, Debug)]
pub struct BodyAngles<'a> {
    /// Of the Sun above the chassis plane.
    pub sun_latitude_rad: &'a [f64],
    /// Of the observer, from the Sun's azimuth.
    pub observer_longitude_rad: &'a [f64],
    /// Of the observer above the chassis plane.
    pub observer_latitude_rad: &'a [f64],
}

/// Directions that are worked on together: their intermediate numbers, some 5 kB, stay in the nearest cache.
const BLOCK: usize = 32;

/// Cosines below this are taken as this where they divide: what they belong to is dark, or stopped altogether, long before.
const TINY: f64 = 1e-60;

/// Places of satellites as columns of one length, km, in the same axes as the observer's and the Sun's place; a shorter
/// column cuts the others.
#[derive(Copy, Clone, Debug)]
pub struct Places<'a> {
    /// First coordinate of each satellite, from the Earth's centre.
    pub x_km: &'a [f64],
    /// Second.
    pub y_km: &'a [f64],
    /// Third.
    pub z_km: &'a [f64],
    /// The observer, from the Earth's centre.
    pub observer_km: [f64; 3],
    /// The Sun, from the Earth's centre.
    pub sun_km: [f64; 3],
}

/// Where directions in the body frame come from.
#[derive(Copy, Clone)]
pub(in crate::photometry) enum Columns<'a> {
    Angles(&'a BodyAngles<'a>),
    Places(&'a Places<'a>),
}

/// Magnitudes at 1000 km into `out`; not a number where nothing lit is seen. `zero_mag` is the magnitude of 1 m² sr⁻¹.
pub(in crate::photometry) fn standard_magnitudes(
    model: &TwoPanelNumbers,
    zero_mag: f64,
    columns: Columns,
    out: &mut [f64],
) {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(simd) => simd.vectorize(Run { model, zero_mag, columns, out }),
        #[cfg(target_arch = "x86_64")]
        Arch::V3(simd) => simd.vectorize(Run { model, zero_mag, columns, out }),
        _ => run::<false>(model, zero_mag, columns, out),
    }
}

/// One call of [`run`], as an object that is certain to be inlined where the wide instructions are allowed.
struct Run<'a> {
    model: &'a TwoPanelNumbers,
    zero_mag: f64,
    columns: Columns<'a>,
    out: &'a mut [f64],
}

impl NullaryFnOnce for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        // A copy: behind the reference the compiler could not know that writing magnitudes leaves it alone, and would
        // not make vectors of the loop.
        let model = *self.model;
        run::<true>(&model, self.zero_mag, self.columns, self.out);
    }
}

#[inline(always)]
fn run<const F: bool>(model: &TwoPanelNumbers, zero_mag: f64, columns: Columns, out: &mut [f64]) {
    let three = match columns {
        Columns::Angles(angles) => {
            [angles.sun_latitude_rad, angles.observer_longitude_rad, angles.observer_latitude_rad]
        }
        Columns::Places(places) => [places.x_km, places.y_km, places.z_km],
    };
    let count = three.iter().map(|column| column.len()).min().unwrap_or(0).min(out.len());
    let mut start = 0;
    while start < count {
        let end = (start + BLOCK).min(count);
        let mut block = [[0.0; BLOCK]; 3];
        for (block, column) in block.iter_mut().zip(three) {
            block[..end - start].copy_from_slice(&column[start..end]);
        }
        let directions = match columns {
            Columns::Angles(_) => of_angles::<F>(&block),
            Columns::Places(places) => of_places::<F>(&block, places.observer_km, places.sun_km),
        };
        let magnitudes = of_block::<F>(model, zero_mag, &directions);
        out[start..end].copy_from_slice(&magnitudes[..end - start]);
        start = end;
    }
}

/// Unit vectors to the Sun (x, 0, z) and the observer in the body frame.
struct Directions {
    sun_x: [f64; BLOCK],
    sun_z: [f64; BLOCK],
    eye_x: [f64; BLOCK],
    eye_y: [f64; BLOCK],
    eye_z: [f64; BLOCK],
}

#[inline(always)]
fn of_angles<const F: bool>(angles: &[[f64; BLOCK]; 3]) -> Directions {
    let [(sun_z, sun_x), (longitude_sin, longitude_cos), (eye_z, latitude_cos)] =
        [sines_and_cosines::<F>(&angles[0]), sines_and_cosines::<F>(&angles[1]), sines_and_cosines::<F>(&angles[2])];
    let (mut eye_x, mut eye_y) = ([0.0; BLOCK], [0.0; BLOCK]);
    for lane in 0..BLOCK {
        eye_x[lane] = latitude_cos[lane] * longitude_cos[lane];
        eye_y[lane] = latitude_cos[lane] * longitude_sin[lane];
    }
    Directions { sun_x, sun_z, eye_x, eye_y, eye_z }
}

#[inline(always)]
fn of_places<const F: bool>(places: &[[f64; BLOCK]; 3], observer: [f64; 3], sun: [f64; 3]) -> Directions {
    let [mut sun_x, mut sun_z, mut eye_x, mut eye_y, mut eye_z] = [[0.0; BLOCK]; 5];
    for lane in 0..BLOCK {
        let place = [places[0][lane], places[1][lane], places[2][lane]];
        let to_sun = [sun[0] - place[0], sun[1] - place[1], sun[2] - place[2]];
        let to_eye = [observer[0] - place[0], observer[1] - place[1], observer[2] - place[2]];
        // z = p/|p| to the zenith, y = p × s/|p × s|, x = y × z to the Sun's foot on the plane of the chassis
        //                                                                 Lu (2024), eqs. 8, 9
        let across = cross(place, to_sun);
        let (place_km, sun_km, eye_km) = (norm::<F>(place), norm::<F>(to_sun), norm::<F>(to_eye));
        // With the Sun in the zenith to the last digit azimuths mean nothing, and a leaning sail is taken as seen edge-on.
        let across_km2 = positive(norm::<F>(across));
        // One division for all lengths: 1/(|p| |s| |e| |p × s|).
        let (place_sun, eye_across) = (place_km * sun_km, eye_km * across_km2);
        let per_all = 1.0 / (place_sun * eye_across);
        let (per_place_sun, per_eye_across) = (eye_across * per_all, place_sun * per_all);
        sun_x[lane] = dot::<F>(across, across) * eye_km * per_all;
        sun_z[lane] = dot::<F>(place, to_sun) * per_place_sun;
        // x · e = (p × s) · (p × e) / (|p| |p × s| |e|)
        eye_x[lane] = dot::<F>(across, cross(place, to_eye)) * (sun_km * per_all);
        eye_y[lane] = dot::<F>(across, to_eye) * per_eye_across;
        eye_z[lane] = dot::<F>(place, to_eye) * (sun_km * across_km2 * per_all);
    }
    Directions { sun_x, sun_z, eye_x, eye_y, eye_z }
}

#[inline(always)]
fn dot<const F: bool>(a: [f64; 3], b: [f64; 3]) -> f64 {
    fused::<F>(a[0], b[0], fused::<F>(a[1], b[1], a[2] * b[2]))
}

#[inline(always)]
fn norm<const F: bool>(a: [f64; 3]) -> f64 {
    dot::<F>(a, a).sqrt()
}

#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// One block, step by step: each step is a short loop, so that the next vector begins while the last one waits for its
/// results.
#[inline(always)]
fn of_block<const F: bool>(model: &TwoPanelNumbers, zero_mag: f64, directions: &Directions) -> [f64; BLOCK] {
    let [mut front_m2, mut back_m2, mut base_m2, mut sail_mirror, mut base_mirror] = [[0.0; BLOCK]; 5];
    for lane in 0..BLOCK {
        let (sun_z, sun_x, eye_z) = (directions.sun_z[lane], directions.sun_x[lane], directions.eye_z[lane]);
        let (eye_x, eye_y) = (directions.eye_x[lane], directions.eye_y[lane]);
        let sun_eye = fused::<F>(sun_x, eye_x, sun_z * eye_z);
        // n_sail = (cos POA, 0, sin POA), n_base = -z                     Lu (2024), section 2.1
        let sail_in = fused::<F>(model.cos_panel_offset, sun_x, model.sin_panel_offset * sun_z);
        let sail_out = fused::<F>(model.cos_panel_offset, eye_x, model.sin_panel_offset * eye_z);
        let (sun_below, eye_below) = (-sun_z, -eye_z);

        // What the chassis stops, as in `blocking`: the lines' lengths up the sail and their slope on it, all quotients by one division.
        let [facing_sun, facing_eye, below] = [sail_in, sail_out, eye_below].map(|x| greater(x, TINY));
        let aside = greater((model.cos_panel_offset * eye_y).abs(), TINY);
        let (facing, leaning) = (facing_sun * facing_eye, below * aside);
        let per_all = 1.0 / (facing * leaning);
        let (per_facing, per_leaning) = (leaning * per_all, facing * per_all);
        let shade_m = height(model, sun_below, sail_in, facing_eye * per_facing);
        let view_m = height(model, eye_below, sail_out, facing_sun * per_facing);
        let (slope, per_slope) = (aside * aside * per_leaning, below * below * per_leaning);
        let view_m2 = overlap(model.half_sum_m, model.narrow_m, slope, per_slope, view_m);
        let both_m2 = overlap(model.half_both_m, model.narrow_m, slope, per_slope, lesser(view_m, shade_m));
        let shade_m2 = model.narrow_m * shade_m;
        let open_m2 = lesser(greater(model.sail_m2 - (shade_m2 + (view_m2 - both_m2)), 0.0), model.sail_m2);
        let lit = greater(sail_in, 0.0);
        front_m2[lane] = open_m2 * lit * greater(sail_out, 0.0);
        back_m2[lane] = greater(model.sail_m2 - shade_m2, 0.0) * lit * greater(-sail_out, 0.0);
        base_m2[lane] = model.base_m2 * greater(sun_below, 0.0) * greater(eye_below, 0.0);
        sail_mirror[lane] = fused::<F>(2.0 * lit, sail_out, -sun_eye);
        base_mirror[lane] = fused::<F>(2.0 * sun_below, eye_below, -sun_eye);
    }
    let (sail_lobe, base_lobe) =
        lobes::<F>([model.c1, model.c4], [model.n_sail, model.n_base], &sail_mirror, &base_mirror);
    let mut magnitudes = [0.0; BLOCK];
    for lane in 0..BLOCK {
        // B_total                                                         Lu (2024), eqs. 1-6
        let front = (sail_lobe[lane] + model.c2 * FRAC_1_PI) * front_m2[lane];
        let base = (base_lobe[lane] + model.c5 * FRAC_1_PI) * base_m2[lane];
        let b_total = front + base + model.c3 * FRAC_1_PI * back_m2[lane];
        // m = -2.5 log₁₀ B + zero                                         Lu (2024), eq. 19
        let seen = fused::<F>(-2.5 / LN_10, ln::<F>(greater(b_total, 1e-300)), zero_mag);
        magnitudes[lane] = if b_total > 0.0 { seen } else { f64::NAN };
    }
    magnitudes
}

#[inline(always)]
fn sines_and_cosines<const F: bool>(angles: &[f64; BLOCK]) -> ([f64; BLOCK], [f64; BLOCK]) {
    let (mut sines, mut cosines) = ([0.0; BLOCK], [0.0; BLOCK]);
    for lane in 0..BLOCK {
        (sines[lane], cosines[lane]) = sin_cos::<F>(angles[lane]);
    }
    (sines, cosines)
}

/// c (n + 2)/2π cosⁿθ of sail and chassis; 0 where cos θ is not positive, and where c is 0.
#[inline(always)]
fn lobes<const F: bool>(
    weights: [f64; 2],
    exponents: [f64; 2],
    sail_mirror: &[f64; BLOCK],
    base_mirror: &[f64; BLOCK],
) -> ([f64; BLOCK], [f64; BLOCK]) {
    let (mut sail, mut base) = ([0.0; BLOCK], [0.0; BLOCK]);
    match weights.map(|weight| weight != 0.0) {
        [true, true] => {
            for lane in 0..BLOCK {
                let logarithms = ln_two::<F>(positive(sail_mirror[lane]), positive(base_mirror[lane]));
                (sail[lane], base[lane]) = (exponents[0] * logarithms.0, exponents[1] * logarithms.1);
            }
        }
        [on_sail, on_base] => {
            for (wanted, exponent, mirror, values) in
                [(on_sail, exponents[0], sail_mirror, &mut sail), (on_base, exponents[1], base_mirror, &mut base)]
            {
                if wanted {
                    for lane in 0..BLOCK {
                        values[lane] = exponent * ln::<F>(positive(mirror[lane]));
                    }
                }
            }
        }
    }
    for (weight, exponent, mirror, values) in
        [(weights[0], exponents[0], sail_mirror, &mut sail), (weights[1], exponents[1], base_mirror, &mut base)]
    {
        if weight != 0.0 {
            let scale = weight * (exponent + 2.0) / TAU;
            for lane in 0..BLOCK {
                let value = scale * exp::<F>(values[lane]);
                values[lane] = if mirror[lane] > 0.0 { value } else { 0.0 };
            }
        }
    }
    (sail, base)
}

/// How far up the sail the chassis stops light to or from a direction, m; eqs. 15 and 17 (mended).
#[inline(always)]
fn height(model: &TwoPanelNumbers, below: f64, facing: f64, per_facing: f64) -> f64 {
    let met = lesser(model.base_length_m * below * per_facing, model.sail_length_m);
    if below > 0.0 && facing > 0.0 { met } else { 0.0 }
}

/// ∫ clamp(reach - slope v, 0, flat) dv over 0 ≤ v ≤ height, as in `blocking`.
#[inline(always)]
fn overlap(reach: f64, flat: f64, slope: f64, per_slope: f64, height: f64) -> f64 {
    let full = lesser((reach - flat) * per_slope, height);
    let none_from = greater(lesser(reach * per_slope, height), full);
    let last = greater(lesser(reach - slope * none_from, flat), 0.0);
    flat * full + 0.5 * (flat + last) * (none_from - full)
}

/// The number itself where it is positive, and 1 where a quotient or logarithm by it is not looked at.
#[inline(always)]
fn positive(x: f64) -> f64 {
    if x > 0.0 { x } else { 1.0 }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
