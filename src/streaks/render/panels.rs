//! Light of a path by sums over points of it: for ends, jumps, tight curves and what hardly moves; and what the fast way is held against.
//!
//! A stretch of path is a panel of eight nodes of Gauss's rule in time. Near by, panels are short against the profile; farther out, where its
//! wings are smooth, a panel of twice the length does as well, so panels form a tree and each pixel uses the longest that are good enough.

use crate::math::quadrature::gauss_legendre;
use crate::streaks::ProfileTables;

use super::blocks::{EACH, LANES};
use super::chords::{Cutter, Stretch};

/// Nodes of a panel.
const NODES: usize = 8;

/// Eight points of a path with their light.
#[derive(Clone, Debug)]
struct Panel {
    centre: [f64; 2],
    /// All of its path lies as near to the centre.
    radius_pix: f64,
    /// Pixels at this distance from its path, or farther, may use it.
    from_pix: f64,
    x: [f64; NODES],
    y: [f64; NODES],
    light: [f32; NODES],
    /// Two shorter ones in its place.
    halves: Option<[u32; 2]>,
}

/// Panels over a stretch of a path.
#[derive(Clone, Debug)]
pub(super) struct PanelTree {
    /// The last one is the whole.
    panels: Vec<Panel>,
}

impl PanelTree {
    pub fn of(cutter: &Cutter<'_>, stretch: Stretch, profile: &ProfileTables) -> Self {
        let rule = gauss_legendre(NODES);
        let mut panels = Vec::new();
        grow(cutter, stretch, profile, &rule, &mut panels);
        Self { panels }
    }

    /// Discs that hold short parts of the stretch each.
    pub fn discs(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        self.panels.iter().filter(|panel| panel.halves.is_none()).map(|panel| (panel.centre, panel.radius_pix))
    }

    /// Adds its light to `used` neighbouring pixels of a row, at most [`LANES`], of which the first is at `[x, y]`.
    #[inline(always)]
    pub fn add_to(&self, first: [f64; 2], used: usize, profile: &ProfileTables, light: &mut [f32; LANES]) {
        let half = 0.5 * (used as f64 - 1.0);
        let reach = profile.pixel_reach_pix();
        // Two a level, and a tree of 32 levels would be longer than any path.
        let mut open = [0_u32; 64];
        let mut count = 1;
        open[0] = (self.panels.len() - 1) as u32;
        while count > 0 {
            count -= 1;
            let panel = &self.panels[open[count & 63] as usize];
            let across = ((panel.centre[0] - first[0] - half).abs() - half).max(0.0);
            let down = first[1] - panel.centre[1];
            let distance = (across * across + down * down).sqrt() - panel.radius_pix;
            if distance > reach {
                continue;
            }
            match panel.halves {
                Some([first, second]) if distance < panel.from_pix => {
                    open[count & 63] = first;
                    open[(count + 1) & 63] = second;
                    count += 2;
                }
                _ => panel.add_to(first, profile, distance > profile.round_from_pix(), light),
            }
        }
    }
}

impl Panel {
    #[inline(always)]
    fn add_to(&self, first: [f64; 2], profile: &ProfileTables, is_round: bool, light: &mut [f32; LANES]) {
        for ((x, y), weight) in self.x.iter().zip(self.y).zip(self.light) {
            let dx = (first[0] - x) as f32;
            let dx = EACH.map(|column| dx + column);
            let shares = profile.pixels(&dx, &[(first[1] - y) as f32; LANES], is_round);
            for (light, share) in light.iter_mut().zip(shares) {
                *light += weight * share;
            }
        }
    }
}

/// Adds the panel of a stretch after those of its halves, and says where it stands.
fn grow(
    cutter: &Cutter<'_>,
    stretch: Stretch,
    profile: &ProfileTables,
    rule: &[(f64, f64)],
    panels: &mut Vec<Panel>,
) -> u32 {
    let length = cutter.length_pix(stretch);
    // Panels alike in length; by a hundredth longer rather than one more.
    let count = (length / profile.panel_pix() - 0.01).ceil();
    let halves = (count > 1.0).then(|| {
        let between = stretch.from_s + (0.5 * count).floor() / count * (stretch.to_s - stretch.from_s);
        let first = grow(cutter, Stretch { to_s: between, ..stretch }, profile, rule, panels);
        let second = grow(cutter, Stretch { from_s: between, ..stretch }, profile, rule, panels);
        [first, second]
    });
    let piece = &cutter.pieces[stretch.piece];
    let duration_s = stretch.to_s - stretch.from_s;
    let (mut x, mut y, mut light) = ([0.0; NODES], [0.0; NODES], [0.0; NODES]);
    for (node, (share, weight)) in rule.iter().enumerate().take(NODES) {
        let since_s = stretch.from_s + share * duration_s;
        [x[node], y[node]] = piece.at(since_s);
        light[node] = (weight * duration_s * piece.rate.at(since_s)) as f32;
    }
    let centre = piece.at(stretch.from_s + 0.5 * duration_s);
    // Nothing of a stretch is farther from its middle in time than the longer of its halves is long.
    let middle = 0.5 * (stretch.from_s + stretch.to_s);
    let radius_pix = cutter
        .length_pix(Stretch { to_s: middle, ..stretch })
        .max(cutter.length_pix(Stretch { from_s: middle, ..stretch }));
    let from_pix = if halves.is_some() { profile.panel_from_pix(length) } else { 0.0 };
    panels.push(Panel { centre, radius_pix, from_pix, x, y, light, halves });
    (panels.len() - 1) as u32
}
