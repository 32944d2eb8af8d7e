//! The equations of the two-panel model (Lu 2024, sections 2.1 and 2.3) for N geometries at once.
//!
//! Single magnitudes use N = 1. Columns and fits use blocks of geometries, whose loops the compiler vectorises. `F` is
//! true on machines with fused multiply-add ([`crate::math::vectors::widest_fused`]).
//!
//! # Shadow and obstruction by the chassis
//!
//! The sail (solar array) is mounted on the edge of the chassis that faces away from the Sun. This edge is a hinge
//! along y. In the plane of the sail, u runs along the hinge from its middle, and v up the sail. In the body frame a
//! point of the sail is
//!
//! ```text
//! P(u, v) = (-v sin POA, u, v cos POA)        normal n = (cos POA, 0, sin POA)
//! ```
//!
//! with the hinge as origin. The chassis is the rectangle 0 ≤ x ≤ l_base, |y| ≤ w_base/2, z = 0. The ray from P
//! towards a direction w (Sun or observer, unit vector) below the chassis plane meets z = 0 at
//!
//! ```text
//! x = v (n·w)/(-w_z)        y = u + v cos POA w_y/(-w_z)
//! ```
//!
//! so it is blocked if n·w > 0 (otherwise the ray leaves in the other direction), v ≤ h, and |y| ≤ w_base/2, with
//!
//! ```text
//! h = l_base (-w_z)/(n·w)
//! ```
//!
//! The blocked points form a parallelogram on the hinge that is sheared sideways; for the Sun w_y = 0, and it is a
//! rectangle. If w is the Sun, h is that of eq. 15 in Lu (2024); if w is the observer, it is y_p. **Eq. 17 in Lu (2024)
//! prints sin² δ_sun where this derivation (and ray casting) gives sin² δ_obs**; the printed form is wrong by up to
//! 0.74 in the blocked fraction. The condition for obstruction is n·w > 0, not cos α > 0, which is wrong by up to 0.86
//! for POA = -3°.
//!
//! The lost part of the sail is the area of shadow ∪ view, cut to the sail. At each height v the three shapes are
//! intervals in u. The area is therefore the integral of interval lengths that are piecewise linear in v, and has a
//! closed form. Tests compare it with clipped polygons and with single rays.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, LN_10, TAU};

use nalgebra::Vector3;

use crate::math::elementary::{exp, fused, greater, lesser, ln};
use crate::photometry::model_file::SatelliteShape;

/// Value used as the logarithm of a mirror cosine that is not positive, so that every power of the cosine is 0.
const NO_LOBE: f64 = -1e5;

/// Divisor used in place of a cosine of 0.
const TINY: f64 = 1e-60;

/// A rectangular sail (solar array) that is hinged to the edge of a rectangular chassis.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct ChassisAndSail {
    sin_panel_offset: f64,
    cos_panel_offset: f64,
    sail_m2: f64,
    base_m2: f64,
    sail_length_m: f64,
    base_length_m: f64,
    /// The smaller of the widths of the solar array (sail) and the chassis, m.
    narrow_m: f64,
    /// Half the sum of the two widths, m.
    half_sum_m: f64,
    /// Half the sum of the smaller width and the width of the chassis, m.
    half_both_m: f64,
}

/// Fractions of the sail's area that reflect no light to the observer.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Blocked {
    /// Fraction that the chassis shades or hides, BF in Lu (2024), [0, 1].
    pub shadow_or_hidden: f64,
    /// Fraction that the chassis shades, BF' in Lu (2024), [0, 1].
    pub shadow: f64,
}

/// Unit vectors in the body frame: to the Sun (x and z; y is 0) and to the observer (x, y, z).
#[derive(Copy, Clone, Debug, PartialEq)]
pub(crate) struct Directions<const N: usize> {
    pub sun: [[f64; N]; 2],
    pub observer: [[f64; N]; 3],
}

/// Area of the sail lit by the Sun, and the part of it visible to the observer, m².
#[derive(Copy, Clone, Debug, PartialEq)]
pub(crate) struct OpenSail<const N: usize> {
    pub lit_m2: [f64; N],
    pub lit_and_seen_m2: [f64; N],
}

/// Quantities that depend on the geometry but not on the coefficients: for each surface, the unblocked area times the
/// cosines of incidence and reflection, m², and ln cos θ of the angle θ between the observer and the direction of
/// mirror reflection.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(crate) struct LitPanels<const N: usize> {
    /// Front of the sail: cos φ_i cos φ_r A (1 - BF).
    pub front_m2: [f64; N],
    /// Sail lit from the front and seen from behind: cos φ_i cos(π - φ_r) A (1 - BF').
    pub through_m2: [f64; N],
    /// Chassis: cos φ_i cos φ_r A.
    pub base_m2: [f64; N],
    /// Logarithm of the sail's mirror cosine, ln cos θ_sail.
    pub ln_sail: [f64; N],
    /// Logarithm of the chassis' mirror cosine, ln cos θ_base.
    pub ln_base: [f64; N],
}

impl Directions<1> {
    pub fn new(to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Self {
        Self { sun: [[to_sun.x], [to_sun.z]], observer: [[to_observer.x], [to_observer.y], [to_observer.z]] }
    }
}

impl ChassisAndSail {
    /// Returns `None` unless all lengths are positive and finite and the panel offset is within ±90°.
    pub fn new(shape: &SatelliteShape) -> Option<Self> {
        let lengths = [shape.sail_length_m, shape.sail_width_m, shape.base_length_m, shape.base_width_m];
        let panel_offset_rad = shape.panel_offset_deg.to_radians();
        let is_sound = lengths.iter().all(|&l| l > 0.0 && l.is_finite()) && panel_offset_rad.abs() < FRAC_PI_2;
        let (sin_panel_offset, cos_panel_offset) = panel_offset_rad.sin_cos();
        let narrow_m = shape.sail_width_m.min(shape.base_width_m);
        is_sound.then_some(Self {
            sin_panel_offset,
            cos_panel_offset,
            sail_m2: shape.sail_length_m * shape.sail_width_m,
            base_m2: shape.base_length_m * shape.base_width_m,
            sail_length_m: shape.sail_length_m,
            base_length_m: shape.base_length_m,
            narrow_m,
            half_sum_m: 0.5 * (shape.sail_width_m + shape.base_width_m),
            half_both_m: 0.5 * (narrow_m + shape.base_width_m),
        })
    }

    /// Returns the area of the chassis, m².
    pub(crate) fn base_m2(&self) -> f64 {
        self.base_m2
    }

    /// Returns the blocked fractions of the sail. The arguments are unit vectors to the Sun (whose y is taken as 0) and
    /// the observer, in the body frame.
    pub fn blocked(&self, to_sun: &Vector3<f64>, to_observer: &Vector3<f64>) -> Blocked {
        self.blocked_of(&self.open_sail::<false, 1>(&Directions::new(to_sun, to_observer)))
    }

    pub(super) fn blocked_of(&self, open: &OpenSail<1>) -> Blocked {
        let lost = |open_m2: [f64; 1]| 1.0 - open_m2[0] / self.sail_m2;
        Blocked { shadow_or_hidden: lost(open.lit_and_seen_m2), shadow: lost(open.lit_m2) }
    }

    /// Returns the areas of a sail that is neither shaded nor hidden.
    #[cfg(feature = "fit")]
    pub(crate) fn whole_sail<const N: usize>(&self) -> OpenSail<N> {
        OpenSail { lit_m2: [self.sail_m2; N], lit_and_seen_m2: [self.sail_m2; N] }
    }

    /// Returns the area of the sail that the chassis does not shade, and the area that it neither shades nor hides.
    #[inline(always)]
    pub(crate) fn open_sail<const F: bool, const N: usize>(&self, directions: &Directions<N>) -> OpenSail<N> {
        let [sun_x, sun_z] = &directions.sun;
        let [eye_x, eye_y, eye_z] = &directions.observer;
        let [mut lit_m2, mut lit_and_seen_m2] = [[0.0; N]; 2];
        for lane in 0..N {
            let shade_m = self.height_m::<F>(sun_x[lane], sun_z[lane]);
            let view_m = self.height_m::<F>(eye_x[lane], eye_z[lane]);
            // |x_p| / y_p = cos POA |w_y| / (-w_z), the shear of the hidden part       Lu (2024), eqs. 16, 18
            let below = greater(-eye_z[lane], TINY);
            let aside = greater((self.cos_panel_offset * eye_y[lane]).abs(), TINY);
            let (shear, per_shear) = (aside / below, below / aside);
            // |S ∪ V| = |S| + |V| - |S ∩ V|, where the shadow S and the hidden part V are each cut to the sail. S is an
            // upright strip of width `narrow_m` about the middle. V at height v is an interval of the chassis' width,
            // displaced from the middle by shear v.
            let shade_m2 = self.narrow_m * shade_m;
            let view_m2 = overlap_m2(self.half_sum_m, self.narrow_m, shear, per_shear, view_m);
            let both_m2 = overlap_m2(self.half_both_m, self.narrow_m, shear, per_shear, lesser(view_m, shade_m));
            let lit = greater(self.sail_m2 - shade_m2, 0.0);
            lit_m2[lane] = lit;
            lit_and_seen_m2[lane] = greater(lit - greater(view_m2 - both_m2, 0.0), 0.0);
        }
        OpenSail { lit_m2, lit_and_seen_m2 }
    }

    /// Returns the height on the sail, m, below which the chassis blocks light to or from a direction with these x and
    /// z.
    #[inline(always)]
    fn height_m<const F: bool>(&self, x: f64, z: f64) -> f64 {
        // h = l_base (-sin δ) / (n · w)                                  Lu (2024), eqs. 15 and 17 (corrected)
        let facing = fused::<F>(self.cos_panel_offset, x, self.sin_panel_offset * z);
        let height_m = lesser(self.base_length_m * -z / facing, self.sail_length_m);
        if z < 0.0 && facing > 0.0 { height_m } else { 0.0 }
    }

    /// Computes projected areas and mirror angles; logarithms only for the lobes (sail, chassis) that are `selected`.
    #[inline(always)]
    pub(crate) fn lit<const F: bool, const N: usize>(
        &self,
        directions: &Directions<N>,
        open: &OpenSail<N>,
        selected: [bool; 2],
    ) -> LitPanels<N> {
        let [sun_x, sun_z] = &directions.sun;
        let [eye_x, _, eye_z] = &directions.observer;
        let [mut front_m2, mut through_m2, mut base_m2, mut cos_sail, mut cos_base] = [[0.0; N]; 5];
        for lane in 0..N {
            let (sun_x, sun_z, eye_x, eye_z) = (sun_x[lane], sun_z[lane], eye_x[lane], eye_z[lane]);
            // n_sail = (cos POA, 0, sin POA), n_base = -z                    Lu (2024), section 2.1
            let sail_in = greater(fused::<F>(self.cos_panel_offset, sun_x, self.sin_panel_offset * sun_z), 0.0);
            let sail_out = fused::<F>(self.cos_panel_offset, eye_x, self.sin_panel_offset * eye_z);
            front_m2[lane] = open.lit_and_seen_m2[lane] * sail_in * greater(sail_out, 0.0);
            through_m2[lane] = open.lit_m2[lane] * sail_in * greater(-sail_out, 0.0);
            base_m2[lane] = self.base_m2 * greater(-sun_z, 0.0) * greater(-eye_z, 0.0);
            // cos θ = 2 cos φ_i cos φ_r - s · o
            let sun_eye = fused::<F>(sun_x, eye_x, sun_z * eye_z);
            cos_sail[lane] = fused::<F>(2.0 * sail_in, sail_out, -sun_eye);
            cos_base[lane] = fused::<F>(2.0 * sun_z, eye_z, -sun_eye);
        }
        for (cosines, selected) in [(&mut cos_sail, selected[0]), (&mut cos_base, selected[1])] {
            if selected {
                for cosine in cosines.iter_mut() {
                    let logarithm = ln::<F>(greater(*cosine, f64::MIN_POSITIVE));
                    *cosine = if *cosine > 0.0 { logarithm } else { NO_LOBE };
                }
            }
        }
        LitPanels { front_m2, through_m2, base_m2, ln_sail: cos_sail, ln_base: cos_base }
    }
}

impl<const N: usize> LitPanels<N> {
    /// Returns five terms, in the order c1 to c5, m² sr⁻¹; B_total is the sum of c_k times these terms. The term of a
    /// lobe without an exponent is 0.
    #[inline(always)]
    pub(crate) fn basis<const F: bool>(&self, exponents: [Option<f64>; 2]) -> [[f64; N]; 5] {
        let mut basis = [[0.0; N]; 5];
        let [sail_lobe, sail, through, base_lobe, base] = &mut basis;
        for lane in 0..N {
            [sail_lobe[lane], sail[lane], through[lane], base_lobe[lane], base[lane]] =
                self.basis_at::<F>(lane, exponents);
        }
        basis
    }

    /// Returns B_total in sunlight, m² sr⁻¹, without storing its terms.
    #[inline(always)]
    pub(crate) fn light<const F: bool>(&self, c: &[f64; 5], exponents: [Option<f64>; 2]) -> [f64; N] {
        let mut light = [0.0; N];
        for (lane, light) in light.iter_mut().enumerate() {
            *light = weighted::<F>(c, self.basis_at::<F>(lane, exponents));
        }
        light
    }

    #[inline(always)]
    fn basis_at<const F: bool>(&self, lane: usize, exponents: [Option<f64>; 2]) -> [f64; 5] {
        let (front_m2, through_m2, base_m2) = (self.front_m2[lane], self.through_m2[lane], self.base_m2[lane]);
        [
            lobe::<F>(exponents[0], self.ln_sail[lane]) * front_m2,
            // f = c / π                                                      Lu (2024), eqs. 3, 4, 6
            FRAC_1_PI * front_m2,
            FRAC_1_PI * through_m2,
            lobe::<F>(exponents[1], self.ln_base[lane]) * base_m2,
            FRAC_1_PI * base_m2,
        ]
    }
}

/// Returns the value of a lobe of weight 1, sr⁻¹.
#[inline(always)]
fn lobe<const F: bool>(exponent: Option<f64>, ln_cosine: f64) -> f64 {
    let Some(n) = exponent else { return 0.0 };
    // f = (n + 2) / 2π · cosⁿθ                                           Lu (2024), eqs. 2, 5
    let value = (n + 2.0) / TAU * exp::<F>(n * ln_cosine);
    if ln_cosine > NO_LOBE { value } else { 0.0 }
}

/// Returns the derivative of a lobe with respect to its exponent, from the value of the lobe and the exponent.
#[inline(always)]
#[cfg(feature = "fit")]
pub(crate) fn slope_of_lobe(lobe: f64, exponent: f64, ln_cosine: f64) -> f64 {
    // ∂/∂n of (n + 2)/2π cosⁿθ: itself times 1/(n + 2) + ln cos θ
    lobe * (1.0 / (exponent + 2.0) + ln_cosine)
}

/// Returns Σ c_k b_k.
#[inline(always)]
fn weighted<const F: bool>(c: &[f64; 5], basis: [f64; 5]) -> f64 {
    let diffuse = fused::<F>(c[1], basis[1], fused::<F>(c[2], basis[2], c[4] * basis[4]));
    fused::<F>(c[0], basis[0], fused::<F>(c[3], basis[3], diffuse))
}

/// Returns Σ c_k b_k for each of N elements.
#[inline(always)]
#[cfg(feature = "fit")]
pub(crate) fn weighted_sum<const F: bool, const N: usize>(c: &[f64; 5], basis: &[[f64; N]; 5]) -> [f64; N] {
    let mut sum = [0.0; N];
    for lane in 0..N {
        sum[lane] = weighted::<F>(c, [0, 1, 2, 3, 4].map(|k: usize| basis[k][lane]));
    }
    sum
}

/// Computes the magnitudes of reflected light. `zero_mag` is the magnitude of 1 m² sr⁻¹; light below `least_m2_sr` is
/// replaced by `least_m2_sr`.
#[inline(always)]
pub(crate) fn magnitudes<const F: bool, const N: usize>(
    light_m2_sr: &[f64; N],
    least_m2_sr: f64,
    zero_mag: f64,
) -> [f64; N] {
    let mut magnitudes = [0.0; N];
    for lane in 0..N {
        // m = -2.5 log₁₀ B + zero                                        Lu (2024), eq. 21
        magnitudes[lane] = fused::<F>(-2.5 / LN_10, ln::<F>(greater(light_m2_sr[lane], least_m2_sr)), zero_mag);
    }
    magnitudes
}

/// Returns ∫ clamp(reach - slope v, 0, flat) dv over 0 ≤ v ≤ height. This is the area that two strips have in common,
/// one of which is inclined.
///
/// `reach` is half the sum of the widths of the strips and at least the smaller width, `flat`.
#[inline(always)]
fn overlap_m2(reach: f64, flat: f64, slope: f64, per_slope: f64, height: f64) -> f64 {
    let full = lesser((reach - flat) * per_slope, height);
    let none_from = greater(lesser(reach * per_slope, height), full);
    let last = greater(lesser(reach - slope * none_from, flat), 0.0);
    flat * full + 0.5 * (flat + last) * (none_from - full)
}
