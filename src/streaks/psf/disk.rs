//! A radial profile blurred by a uniform disk.

use std::f64::consts::PI;

use super::integrals::Panels;

/// Mean of a radial `profile` over a disk of radius `a_pix` whose centre lies `r_pix` from the profile's own.
///
/// In circles about the profile's centre: those of radius s < a - r lie within the disk, those with |r - a| < s < r + a by an arc
///
/// 2 α(s) = 2 arccos((r² + s² - a²) / 2 r s),   mean = 1/(π a²) [ ∫₀^(a-r) 2π s f(s) ds + ∫ 2 α s f(s) ds ].
///
/// The arc grows like a square root from both ends; s = m - h cos θ makes it smooth. `reach_pix` is where the profile ends, `step_pix` a
/// length over which it is smooth.
pub(super) fn disk_mean(
    profile: impl Fn(f64) -> f64,
    reach_pix: f64,
    step_pix: f64,
    a_pix: f64,
    r_pix: f64,
    panels: &Panels,
) -> f64 {
    let full_to = (a_pix - r_pix).clamp(0.0, reach_pix);
    let full = panels.integrate(0.0, full_to, step_pix, |s| 2.0 * PI * s * profile(s));
    let (least, greatest) = ((r_pix - a_pix).abs(), r_pix + a_pix);
    let to = greatest.min(reach_pix);
    if least >= to {
        return full / (PI * a_pix * a_pix);
    }
    let (middle, half) = (0.5 * (least + greatest), 0.5 * (greatest - least));
    let last_angle = ((middle - to) / half).clamp(-1.0, 1.0).acos();
    let step = 0.5 * step_pix * last_angle / (to - least);
    let arcs = panels.integrate(0.0, last_angle, step, |theta| {
        let (sin, cos) = theta.sin_cos();
        let s = middle - half * cos;
        let alpha = ((r_pix * r_pix + s * s - a_pix * a_pix) / (2.0 * r_pix * s)).clamp(-1.0, 1.0).acos();
        2.0 * alpha * s * profile(s) * half * sin
    });
    (full + arcs) / (PI * a_pix * a_pix)
}
