//! Integrals of a radial profile: over the plane, along a line, over a pixel.

use std::f64::consts::PI;

use crate::math::quadrature::gauss_legendre;

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
        self.sum(from, to, step, |x, weight| weight * function(x))
    }

    /// ∫ from 0 to `to` of what has a grain.
    pub fn integrate_outwards(&self, to: f64, grain: Grain, mut function: impl FnMut(f64) -> f64) -> f64 {
        self.sum_outwards(to, grain, |x, weight| weight * function(x))
    }

    /// Sum over nodes `x` of something of their weights, which add up to the length.
    fn sum(&self, from: f64, to: f64, step: f64, mut part: impl FnMut(f64, f64) -> f64) -> f64 {
        if to <= from {
            return 0.0;
        }
        let count = ((to - from) / step).ceil().max(1.0);
        let width = (to - from) / count;
        let mut sum = 0.0;
        for panel in 0..count as usize {
            let start = from + panel as f64 * width;
            sum += self.0.iter().map(|(x, weight)| part(start + x * width, weight * width)).sum::<f64>();
        }
        sum
    }

    fn sum_outwards(&self, to: f64, grain: Grain, mut part: impl FnMut(f64, f64) -> f64) -> f64 {
        let step = grain.step_pix;
        let mut end = grain.even_to_pix.min(to);
        let mut sum = self.sum(0.0, end, step, &mut part);
        while end < to {
            let next = (end + 0.5 * end.max(2.0 * step)).min(to);
            sum += self.sum(end, next, next - end, &mut part);
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
    let grain = Grain { step_pix: 0.5 * grain.step_pix, ..grain };
    panels.integrate_outwards(end, grain, |r| 2.0 * PI * r * profile.at(r))
}

/// ∫ f(√(u² + v²)) du over a whole line that passes the centre at distance `v`, and ∫ u² f du.
pub(super) fn along_line(profile: &Curve, v_pix: f64, grain: Grain, panels: &Panels) -> [f64; 2] {
    let reach = profile.radii().end_pix();
    let to = (reach * reach - v_pix * v_pix).max(0.0).sqrt();
    let even_to_pix = (grain.even_to_pix.powi(2) - v_pix * v_pix).max(grain.step_pix.powi(2)).sqrt();
    let mut second = 0.0;
    let first = panels.sum_outwards(to, Grain { even_to_pix, ..grain }, |u, weight| {
        let light = weight * profile.at((u * u + v_pix * v_pix).sqrt());
        second += u * u * light;
        light
    });
    [2.0 * first, 2.0 * second]
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
