//! Drawing of a path as points of light at the nodes of a quadrature rule.

use crate::images::{Patch, PixelPosition};
use crate::math::quadrature::gauss_legendre;
use crate::streaks::{PointLight, RadialProfile, draw_points};

use super::path::{Piece, StreakPath};

/// Largest number of nodes of a quadrature rule. A rule has two more nodes than the distance of the points requires,
/// because the light is a cubic function of time.
const MOST_NODES: usize = 32;
const MORE_NODES: usize = 2;
/// Largest number of quadrature rules in an interval. Longer intervals are halved, and halves outside the frame are
/// omitted.
const MOST_RULES: f64 = 8.0;

/// Draws a path in a frame of `rows` by `columns` pixels. The result is in the unit of the path's rates times seconds.
///
/// Each pixel is the profile averaged over its area and integrated along the path. It is accurate to 10⁻³ of the peak
/// and of the flux, also at ends, jumps of brightness and bends. The path is drawn as a sum of points that are close
/// enough to form a line.
///
/// The profile is the same along the whole path; it should be the profile at the middle of the part in the frame. If
/// the range changes by 1 % within the frame, the radius of a defocus ring is wrong by 0.5 % at both ends.
pub fn draw(path: &StreakPath, profile: &RadialProfile, rows: usize, columns: usize) -> Patch {
    let mut rules = vec![Vec::new(); MOST_NODES + 1];
    let reach = profile.pixel_reach_pix() + 1.0;
    let near = [columns, rows].map(|count| [-reach, count as f64 - 1.0 + reach]);
    draw_points(profile, rows, columns, |step_pix| {
        let mut points = Vec::new();
        for piece in path.pieces() {
            let mut open = vec![[0.0, piece.duration_s]];
            while let Some([from_s, to_s]) = open.pop() {
                let [x, y] = [&piece.x, &piece.y].map(|cubic| cubic.control_points(from_s, to_s));
                let is_near = [x, y].iter().zip(near).all(|(points, [least, greatest])| {
                    points.iter().any(|point| *point >= least) && points.iter().any(|point| *point <= greatest)
                });
                if !is_near {
                    continue;
                }
                // The speed along a cubic is at most three times the longest side of its Bézier control polygon.
                let sides = (1..4).map(|i| profile.mean_pixels([x[i] - x[i - 1], y[i] - y[i - 1]]));
                let steps = 3.0 * sides.fold(0.0, f64::max) / step_pix;
                let count = (steps / (MOST_NODES - MORE_NODES) as f64).ceil().max(1.0);
                if count > MOST_RULES {
                    let middle_s = 0.5 * (from_s + to_s);
                    open.extend([[middle_s, to_s], [from_s, middle_s]]);
                    continue;
                }
                let nodes = (steps / count).ceil() as usize + MORE_NODES;
                let rule = &mut rules[nodes];
                if rule.is_empty() {
                    *rule = even_rule(nodes);
                }
                let duration_s = (to_s - from_s) / count;
                for number in 0..count as usize {
                    let start_s = from_s + number as f64 * duration_s;
                    points.extend(rule.iter().map(|(share, weight)| {
                        let light = weight * duration_s;
                        point(piece, start_s + share * duration_s, light)
                    }));
                }
            }
        }
        points.retain(|point| point.light > 0.0);
        points
    })
}

/// Returns the light that a piece emits in `duration_s` seconds around a time, as a point.
fn point(piece: &Piece, since_s: f64, duration_s: f64) -> PointLight {
    let at = PixelPosition { x: piece.x.at(since_s), y: piece.y.at(since_s) };
    PointLight { at, light: duration_s * piece.rate.at(since_s) }
}

/// Returns a quadrature rule on (0, 1) whose nodes are almost evenly spaced (Hale and Trefethen 2008, SIAM J. Numer.
/// Anal. 46, 930, section 3.1). Nodes of a Gauss rule are π/2 times as far apart in the middle as on average, so a
/// third more of them would be needed.
fn even_rule(nodes: usize) -> Vec<(f64, f64)> {
    /// Logarithm of the error for a constant function, ρ^-2n.
    const LN_ERROR: f64 = -11.5;
    // The map x = asin(α t) / asin(α) is singular at t = ±1/α, on the ellipse (ρ + 1/ρ)/2 = 1/α.
    let rho = (-0.5 * LN_ERROR / nodes as f64).exp();
    let alpha = 2.0 / (rho + 1.0 / rho);
    let moved = |(x, weight): (f64, f64)| {
        let t = alpha * (2.0 * x - 1.0);
        (0.5 + 0.5 * t.asin() / alpha.asin(), weight * alpha / alpha.asin() / (1.0 - t * t).sqrt())
    };
    gauss_legendre(nodes).into_iter().map(moved).collect()
}
