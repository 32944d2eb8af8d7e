//! Where a line of light ends: what its half holds, far from the end.

use super::curve::Curve;
use super::even::even_from;

/// Powers of the direction that are kept.
const TERMS: usize = 7;
/// Nodes at which the half line is integrated.
const NODES: usize = 128;
/// Angles at which evenness is looked at.
const ANGLES: usize = 4;
/// Parts between these for loops: linear in between, good to 10⁻⁶ of the peak.
const PER_INTERVAL: usize = 4;

/// The light that half a line of unit light per pixel puts into pixels at some distance from its end.
///
/// At distance r from the end, where c is the cosine of the angle between the line and the direction from pixel to end, and c is at least 0 (the line leads
/// away), with the pixel's average profile P,
///
/// H(r, c) = ∫₀^∞ P(√(r² + 2 r c s + s²)) ds = Σ A_k(r) (2c - 1)^k.
///
/// Everything that the line touches is as far from the pixel as its end or farther: where P is round there, so is H. As a function of c it is smooth
/// (the nearest singularity of a power law lies at c = -1), so seven powers do. A(r) is kept at equal steps of 1/r, in which wings are powers.
/// Its last column is ∫_r^∞ ρ P(ρ) dρ, of which and H comes the light of a line that becomes brighter: ∫ s P ds = G - r c H.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeTable {
    from_pix: f64,
    even_from_pix: f64,
    reach_pix: f64,
    scale: f32,
    rows: Vec<[f32; TERMS + 1]>,
}

impl EdgeTable {
    /// The least distance from which on a table has nodes enough, pixels. They lie r²/128 s apart in a table that begins at s, and seeing `fwhm_pix` wide about a flat part must
    /// have many where it ends: three times as many as bring errors down to 5·10⁻⁵ of the peak.
    pub(super) fn from_at_least_pix(fwhm_pix: f64, flat_radius_pix: f64) -> f64 {
        let edge_pix = flat_radius_pix + 1.5 * fwhm_pix;
        (3.0 * edge_pix * edge_pix / (16.0 * fwhm_pix)).max(1.0)
    }

    /// From the average over pixels, which is round from `from_pix` on; `peak` is that of a long line.
    pub(super) fn of(pixel: &Curve, from_pix: f64, peak: f64) -> Self {
        let reach_pix = pixel.radii().end_pix();
        // 1/r in equal steps, from that of the reach to that of the start.
        let step = (1.0 / from_pix - 1.0 / reach_pix) / NODES as f64;
        let radius = |node: usize| 1.0 / (1.0 / reach_pix + node as f64 * step);
        let basis = Basis::new();
        let mut coarse = vec![[0.0_f64; TERMS + 1]];
        for node in 1..=NODES {
            let (r, farther) = (radius(node), radius(node - 1));
            let outside = coarse[node - 1];
            // Along the line as far as the node before, then what is known from there.
            let values = basis.cosines.map(|c| {
                let (u, v2) = (r * c, r * r * (1.0 - c * c));
                let to = (farther * farther - v2).sqrt();
                let way: f64 =
                    GAUSS.iter().map(|(x, weight)| weight * pixel.at((u + x * (to - u)).hypot(v2.sqrt()))).sum();
                way * (to - u) + horner(&outside, 2.0 * to / farther - 1.0)
            });
            let mut row = basis.powers(&values);
            let ring = |x: f64| r + x * (farther - r);
            let moment: f64 = GAUSS.iter().map(|(x, weight)| weight * ring(*x) * pixel.at(ring(*x))).sum();
            row[TERMS] = outside[TERMS] + moment * (farther - r);
            coarse.push(row);
        }
        let rows = refined(&coarse);
        let scale = (PER_INTERVAL as f64 / step) as f32;
        let table = Self { from_pix, even_from_pix: 0.0, reach_pix, scale, rows };
        let even_from_pix = even_from(reach_pix, peak, |nearest, x| {
            // Pixels that lie across the direction to the end, and along it, for lines that leave at several angles.
            let half = |along: f64, across: f64, angle: f64| {
                let r = along.hypot(across);
                let cosine = ((along * angle.cos() + across * angle.sin()) / r).clamp(0.0, 1.0);
                f64::from(table.at(&[r as f32], &[cosine as f32]).0[0])
            };
            std::array::from_fn::<_, { 2 * ANGLES }, _>(|k| {
                let angle = std::f64::consts::FRAC_PI_2 * (k / 2) as f64 / (ANGLES - 1) as f64;
                if k % 2 == 0 { half(nearest, x, angle) } else { half(nearest + x, 0.0, angle) }
            })
        });
        Self { even_from_pix, ..table }
    }

    /// Distance from the end from which on it holds, pixels.
    pub fn from_pix(&self) -> f64 {
        self.from_pix
    }

    /// Distance from the end from which on light over [`super::ProfileTables::EVEN_PIX`] is a cubic, on either side of the end, pixels.
    pub fn even_from_pix(&self) -> f64 {
        self.even_from_pix
    }

    /// H and G for `N` pixels at distances from the end of at least [`EdgeTable::from_pix`], and cosines in [0, 1].
    #[inline(always)]
    pub fn at<const N: usize>(&self, r_pix: &[f32; N], cosine: &[f32; N]) -> ([f32; N], [f32; N]) {
        let last = self.rows.len() as i32 - 2;
        let nearest = 1.0 / self.reach_pix as f32;
        let (mut nodes, mut fractions, mut x) = ([0; N], [0.0_f32; N], [0.0; N]);
        for lane in 0..N {
            let place = ((1.0 / r_pix[lane] - nearest) * self.scale).max(0.0);
            nodes[lane] = (place as i32).min(last);
            fractions[lane] = (place - nodes[lane] as f32).min(1.0);
            x[lane] = 2.0 * cosine[lane] - 1.0;
        }
        // All terms of a pixel lie side by side; then all pixels' of a term.
        let mut terms = [[0.0; N]; TERMS + 1];
        for lane in 0..N {
            let (node, fraction) = (nodes[lane] as usize, fractions[lane]);
            let [before, after] = [&self.rows[node], &self.rows[node + 1]];
            let row: [f32; TERMS + 1] = std::array::from_fn(|k| before[k] + fraction * (after[k] - before[k]));
            for (term, value) in terms.iter_mut().zip(row) {
                term[lane] = value;
            }
        }
        let mut half = [0.0; N];
        for term in terms[..TERMS].iter().rev() {
            for lane in 0..N {
                half[lane] = half[lane] * x[lane] + term[lane];
            }
        }
        (half, terms[TERMS])
    }
}

/// Gauss's rule of four nodes on (0, 1).
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

fn horner(row: &[f64; TERMS + 1], x: f64) -> f64 {
    row[..TERMS].iter().rev().fold(0.0, |sum, term| sum * x + term)
}

/// From values at Chebyshev's nodes to powers of 2c - 1.
struct Basis {
    cosines: [f64; TERMS],
    /// Of each power: what each value adds to it.
    weights: [[f64; TERMS]; TERMS],
}

impl Basis {
    fn new() -> Self {
        let angle = |node: usize| std::f64::consts::PI * (node as f64 + 0.5) / TERMS as f64;
        // T_(n+1) = 2 x T_n - T_(n-1)
        let mut chebyshev = [[0.0; TERMS]; TERMS];
        chebyshev[0][0] = 1.0;
        chebyshev[1][1] = 1.0;
        for n in 2..TERMS {
            for k in 0..TERMS {
                let raised = if k > 0 { 2.0 * chebyshev[n - 1][k - 1] } else { 0.0 };
                chebyshev[n][k] = raised - chebyshev[n - 2][k];
            }
        }
        // f(x) = Σ c_n T_n,  c_n = (2 - δ_n0) / K Σ_j f(x_j) cos(n θ_j)
        let share = |n: usize, node: usize| {
            let norm = if n == 0 { 1.0 } else { 2.0 } / TERMS as f64;
            norm * (n as f64 * angle(node)).cos()
        };
        let weight = |k: usize, node: usize| (0..TERMS).map(|n| chebyshev[n][k] * share(n, node)).sum();
        Self {
            cosines: std::array::from_fn(|node| 0.5 * (1.0 + angle(node).cos())),
            weights: std::array::from_fn(|k| std::array::from_fn(|node| weight(k, node))),
        }
    }

    fn powers(&self, values: &[f64; TERMS]) -> [f64; TERMS + 1] {
        let power = |k: usize| self.weights[k].iter().zip(values).map(|(weight, value)| weight * value).sum();
        std::array::from_fn(|k| if k < TERMS { power(k) } else { 0.0 })
    }
}

/// Rows at `PER_INTERVAL` times as many nodes.
fn refined(coarse: &[[f64; TERMS + 1]]) -> Vec<[f32; TERMS + 1]> {
    let mut rows = Vec::with_capacity((coarse.len() - 1) * PER_INTERVAL + 1);
    for interval in 0..coarse.len() - 1 {
        let first = interval.clamp(1, coarse.len() - 3) - 1;
        for part in 0..PER_INTERVAL {
            let weights = super::curve::cubic((interval - first) as f64 + part as f64 / PER_INTERVAL as f64);
            let column = |k: usize| (0..4).map(|node| weights[node] * coarse[first + node][k]).sum::<f64>();
            rows.push(std::array::from_fn(|k| column(k) as f32));
        }
    }
    rows.extend(coarse.last().map(|row| row.map(|value| value as f32)));
    rows
}

#[cfg(test)]
mod tests {
    use crate::streaks::psf::{Blur, RadialProfile, Seeing};

    /// Of the peak of a long line.
    const TOLERANCE: f64 = 3e-6;

    #[test]
    fn verif_half_lines_against_sums_over_points() {
        for (beta, outer) in [(2.2, 0.0), (2.5, 0.0), (3.5, 0.0), (2.5, 7.8), (3.5, 7.8)] {
            let seeing = Seeing::Moffat { fwhm_pix: 3.5, beta };
            let blur = Blur { seeing, outer_radius_pix: outer, inner_radius_pix: 0.6 * outer, body_radius_pix: 0.0 };
            let profile = RadialProfile::of(&blur).unwrap();
            let profile = profile.tables();
            let table = profile.edge().expect("wings");
            let peak = profile.line(0.0, 0.0).max(profile.line(outer, 0.0));
            for i in 0..12 {
                let r = table.from_pix() * (profile.reach_pix() / table.from_pix()).powf(f64::from(i) / 11.0);
                for c in [0.0, 0.13, 0.5, 0.77, 1.0_f64] {
                    let (u, v) = (r * c, r * (1.0 - c * c).sqrt());
                    let step = 0.02;
                    let points = (0..(1.1 * profile.reach_pix() / step) as usize).map(|k| (k as f64 + 0.5) * step);
                    // The line lies at 30 degrees to the rows: P is round here.
                    let at = |s: f64| {
                        profile.pixel(0.866_025_403_784 * (u + s) - 0.5 * v, 0.5 * (u + s) + 0.866_025_403_784 * v)
                    };
                    let (mut half, mut moment) = (0.0, 0.0);
                    for s in points {
                        half += step * at(s);
                        moment += step * (u + s) * at(s);
                    }
                    let ([found], [found_moment]) = table.at(&[r as f32], &[c as f32]);
                    assert!(
                        (f64::from(found) - half).abs() < TOLERANCE * peak,
                        "{beta} {outer} {r} {c}: {found} {half}"
                    );
                    assert!(
                        (f64::from(found_moment) - moment).abs() < 1e-3 * moment + 3e-5 * peak,
                        "{r} {c}: {found_moment} {moment}"
                    );
                }
            }
        }
    }
}
