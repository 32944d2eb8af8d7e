//! The loops that put light into pixels, in the widest vectors of the machine.

use std::ops::Range;

use crate::images::Patch;
use crate::math::vectors::{NullaryFnOnce, widest};
use crate::streaks::{Lanes, Lattice, ProfileTables};

use super::blocks::{EACH, LANES, add};
use super::chords::Chord;
use super::ends::End;
use super::panels::PanelTree;
use super::runs::{Run, Source};
use super::straight::straight;
use super::wings::Wings;

/// The profile across a line at the direction of a chord.
pub(super) enum Across {
    /// For rows of pixels; for long chords that are nearly straight.
    Straight(Lattice),
    /// For all others.
    Curved {
        /// By the distance.
        line: Lanes,
        /// What a radian more makes of it; none for chords so straight that it is not felt.
        turned: Option<Lanes>,
    },
}

/// All that the loops need.
pub(super) struct Strokes<'a> {
    pub chords: &'a [Chord],
    /// Tables of the profile across the path, and which of them each chord uses.
    pub tables: &'a [Across],
    pub table_of: &'a [usize],
    pub trees: &'a [PanelTree],
    /// Of each chord: the trees that reach its pixels.
    pub trees_of: &'a [Range<usize>],
    /// Ends that are drawn by the profile's table of half lines, and the trees that reach each one's middle.
    pub ends: &'a [(End, Range<usize>)],
    pub profile: &'a ProfileTables,
    pub runs: &'a [Run],
    pub patch: &'a mut Patch,
}

/// Draws all runs.
pub(super) fn draw(strokes: Strokes<'_>) {
    widest(strokes);
}

impl NullaryFnOnce for Strokes<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let frame = [self.patch.columns(), self.patch.rows()];
        let mut wings = Vec::with_capacity(self.ends.len());
        for (end, _) in self.ends {
            wings.push(self.profile.edge().and_then(
                #[inline(always)]
                |table| Wings::of(end, table, self.profile, frame),
            ));
        }
        for runs in self.runs.chunk_by(|run, next| run.source == next.source) {
            let source = runs[0].source;
            match source {
                Source::Smooth(number) => {
                    let chord = &self.chords[number];
                    match &self.tables[self.table_of[number]] {
                        Across::Straight(lattice) => straight(chord, lattice, runs, self.patch),
                        Across::Curved { line, turned } => {
                            smooth(&Smooth::of(chord, line, turned.as_ref(), self.profile), runs, self.patch);
                        }
                    }
                }
                Source::Summed(number) => {
                    summed(&self.trees[self.trees_of[number].clone()], self.profile, runs, self.patch);
                }
                Source::Edge { end, is_beside } => {
                    if let Some(table) = self.profile.edge() {
                        let (end, wings) = (&self.ends[end].0, wings[end].as_ref());
                        for run in runs {
                            let pixels = self.patch.stretch_mut(run.row, run.columns.clone());
                            end.add_to(table, wings, is_beside, run.row, run.columns.start, pixels);
                        }
                    }
                }
                Source::Middle(number) => {
                    for run in runs {
                        self.patch.stretch_mut(run.row, run.columns.clone()).fill(0.0);
                    }
                    summed(&self.trees[self.ends[number].1.clone()], self.profile, runs, self.patch);
                }
            }
        }
    }
}

/// Light of panels.
#[inline(always)]
fn summed(trees: &[PanelTree], profile: &ProfileTables, runs: &[Run], patch: &mut Patch) {
    for run in runs {
        let pixels = patch.stretch_mut(run.row, run.columns.clone());
        for (block, out) in pixels.chunks_mut(LANES).enumerate() {
            let at = [(run.columns.start + block * LANES) as f64, run.row as f64];
            let mut light = [0.0; LANES];
            for tree in trees {
                tree.add_to(at, out.len(), profile, &mut light);
            }
            add(&light, out);
        }
    }
}

/// Light of a chord in pixels that have their feet on it.
///
/// A pixel at (a, b) has its foot at a₀ = a + d g and lies v = d (1 - g²/2) to the left of the path, where d = b - f(a), g = f'(a). Of a path of
/// curvature κ, points at a way u from the foot are at distance r² = v² + u² (1 - κv) from the pixel, to first order in κ, so that
///
/// I = λ(a₀) (1 + κv/2) L(v) + λ''/2 M₂(v).
///
/// Pixels are squares: L depends on the path's direction at the foot too, L(v, φ + κa₀) = L(v, φ) + κa₀ dL/dφ.
#[inline(always)]
fn smooth(stroke: &Smooth<'_>, runs: &[Run], patch: &mut Patch) {
    let ([ux, uy], middle) = (stroke.along, stroke.middle);
    for run in runs {
        let dy = run.row as f64 - middle[1];
        let pixels = patch.stretch_mut(run.row, run.columns.clone());
        for (block, out) in pixels.chunks_mut(LANES).enumerate() {
            let dx = (run.columns.start + block * LANES) as f64 - middle[0];
            let first = [(dx * ux + dy * uy) as f32, (dy * ux - dx * uy) as f32];
            let light = stroke.light(&stroke.feet(first, &EACH));
            add(&light, out);
        }
    }
}

/// A chord as the loop needs it.
struct Smooth<'a> {
    line: &'a Lanes,
    turned: Option<&'a Lanes>,
    second_moment: Option<&'a Lanes>,
    middle: [f64; 2],
    along: [f64; 2],
    step: [f32; 2],
    bow: f32,
    half2: f32,
    curvature: f32,
    light: [f32; 4],
}

/// Pixels as a chord sees them: v, a₀, and λ(a₀) (1 + κv/2).
struct Feet<const N: usize> {
    across: [f32; N],
    along: [f32; N],
    brightness: [f32; N],
}

impl<'a> Smooth<'a> {
    #[inline(always)]
    fn of(chord: &Chord, line: &'a Lanes, turned: Option<&'a Lanes>, profile: &'a ProfileTables) -> Self {
        Self {
            line,
            turned,
            second_moment: chord.is_bent(profile).then(|| profile.line_second_moment()),
            middle: chord.middle,
            along: chord.along,
            step: [chord.along[0] as f32, -chord.along[1] as f32],
            bow: chord.bow as f32,
            half2: (chord.half_pix * chord.half_pix) as f32,
            curvature: chord.curvature() as f32,
            light: chord.light.map(|power| power as f32),
        }
    }

    /// Of pixels so many columns after the first, whose a and b are given.
    #[inline(always)]
    fn feet<const N: usize>(&self, first: [f32; 2], columns: &[f32; N]) -> Feet<N> {
        let mut feet = Feet { across: [0.0; N], along: [0.0; N], brightness: [0.0; N] };
        for (lane, column) in columns.iter().enumerate() {
            let a = first[0] + column * self.step[0];
            let b = first[1] + column * self.step[1];
            let d = b - self.bow * (a * a - self.half2);
            let g = 2.0 * self.bow * a;
            let v = d * (1.0 - 0.5 * g * g);
            let foot = a + d * g;
            feet.across[lane] = v;
            feet.along[lane] = foot;
            let bend = self.light[2] + foot * self.light[3];
            feet.brightness[lane] =
                (self.light[0] + foot * (self.light[1] + foot * bend)) * (1.0 + 0.5 * self.curvature * v);
        }
        feet
    }

    #[inline(always)]
    fn light<const N: usize>(&self, feet: &Feet<N>) -> [f32; N] {
        let distance = feet.across.map(f32::abs);
        let mut shares = self.line.at(&distance);
        if let Some(turned) = self.turned {
            let turned = turned.at(&distance);
            for lane in 0..N {
                // The path's direction at the foot: f'(a₀)
                shares[lane] += self.curvature * feet.along[lane] * turned[lane];
            }
        }
        let mut light = [0.0; N];
        for lane in 0..N {
            light[lane] = feet.brightness[lane] * shares[lane];
        }
        if let Some(moments) = self.second_moment {
            let moments = moments.at(&distance);
            for lane in 0..N {
                light[lane] += (self.light[2] + 3.0 * self.light[3] * feet.along[lane]) * moments[lane];
            }
        }
        light
    }
}
