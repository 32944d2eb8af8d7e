//! Integrals of a radial profile: over the plane, along a line, over a pixel.

use std::f64::consts::PI;

use crate::quadrature::gauss_legendre;

use super::curve::Curve;

/// Harmonics of a square pixel's response that are kept: cos 4mφ, m = 0 to 3. The next one is below 10⁻⁶ of the peak for a
/// full width at half maximum of a pixel.
pub(super) const HARMONICS: usize = 4;

/// Gauss's rule of eight nodes, in panels.
pub(super) struct Panels(Vec<(f64, f64)>);

impl Panels {
    pub fn new() -> Self {
        Self(gauss_legendre(8))
    }

    /// ∫ from `from` to `to`, in equal panels no longer than `step`; 0 for an empty range.
    pub fn integrate(&self, from: f64, to: f64, step: f64, mut function: impl FnMut(f64) -> f64) -> f64 {
        if to <= from {
            return 0.0;
        }
        let count = ((to - from) / step).ceil().max(1.0);
        let width = (to - from) / count;
        let mut sum = 0.0;
        for panel in 0..count as usize {
            let start = from + panel as f64 * width;
            sum += self.0.iter().map(|(x, weight)| weight * function(start + x * width)).sum::<f64>();
        }
        sum * width
    }

    /// ∫ from 0 to `to` of what is smooth over `step` as far as `even_to` and over its distance beyond.
    fn integrate_outwards(&self, to: f64, even_to: f64, step: f64, mut function: impl FnMut(f64) -> f64) -> f64 {
        let mut end = even_to.min(to);
        let mut sum = self.integrate(0.0, end, step, &mut function);
        while end < to {
            let next = (end + 0.5 * end.max(2.0 * step)).min(to);
            sum += self.integrate(end, next, next - end, &mut function);
            end = next;
        }
        sum
    }
}

/// How finely a profile must be looked at.
#[derive(Copy, Clone, Debug)]
pub(super) struct Grain {
    /// Length over which it is smooth, pixels.
    pub step_pix: f64,
    /// Radius up to which that holds; farther out it is smooth over its radius.
    pub even_to_pix: f64,
}

/// ∫ 2π r f(r) dr.
pub(super) fn flux(profile: &Curve, grain: Grain, panels: &Panels) -> f64 {
    let end = profile.radii().end_pix();
    panels.integrate_outwards(end, grain.even_to_pix, 0.5 * grain.step_pix, |r| 2.0 * PI * r * profile.at(r))
}

/// ∫ u^power f(√(u² + v²)) du over a whole line that passes the centre at distance `v`; `power` is even.
pub(super) fn along_line(profile: &Curve, v_pix: f64, power: i32, grain: Grain, panels: &Panels) -> f64 {
    let reach = profile.radii().end_pix();
    let to = (reach * reach - v_pix * v_pix).max(0.0).sqrt();
    let even_to = (grain.even_to_pix.powi(2) - v_pix * v_pix).max(grain.step_pix.powi(2)).sqrt();
    2.0 * panels.integrate_outwards(to, even_to, grain.step_pix, |u| u.powi(power) * profile.at(u.hypot(v_pix)))
}

/// Nodes of a square pixel, offsets from its centre and weights that sum to 1.
pub(super) fn pixel_nodes(count: usize) -> Vec<([f64; 2], f64)> {
    let rule = gauss_legendre(count);
    let both = rule.iter().flat_map(|x| rule.iter().map(move |y| (x, y)));
    both.map(|((x, wx), (y, wy))| ([x - 0.5, y - 0.5], wx * wy)).collect()
}

/// Amplitudes of 1, cos 4φ, cos 8φ, cos 12φ of a function that has a square's symmetry, from its values at [`angle`] 0 to 3.
pub(super) fn harmonics(values: [f64; HARMONICS]) -> [f64; HARMONICS] {
    std::array::from_fn(|m| {
        let sum: f64 = (0..HARMONICS).map(|j| values[j] * (4.0 * m as f64 * angle(j)).cos()).sum();
        sum * if m == 0 { 1.0 } else { 2.0 } / HARMONICS as f64
    })
}

/// Angles between 0 and 45° at which the first four harmonics do not disturb one another, radians.
pub(super) fn angle(number: usize) -> f64 {
    (number as f64 + 0.5) * PI / (4.0 * HARMONICS as f64)
}
