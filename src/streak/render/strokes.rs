//! The loops that put light into pixels, in the widest vectors of the machine.

use std::ops::Range;

use crate::camera::{Lanes, Lattice, Patch, ProfileTables};
use crate::vectors::{NullaryFnOnce, widest};

use super::blocks::{EACH, LANES, add};
use super::chords::Chord;
use super::ends::End;
use super::panels::PanelTree;
use super::runs::{Run, Source};
use super::straight::straight;
use super::wings::Wings;

/// The profile across a line.
pub(super) struct Across {
    /// At the direction of a chord.
    pub line: Lanes,
    /// What a radian more makes of it; none for chords so straight that it is not felt.
    pub turned: Option<Lanes>,
    /// The first one for rows of pixels; for long and straight chords.
    pub lattice: Option<Lattice>,
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
        for run in self.runs {
            let first_column = run.columns.start;
            let pixels = self.patch.stretch_mut(run.row, run.columns.clone());
            match run.source {
                Source::Smooth(number) => {
                    let table = &self.tables[self.table_of[number]];
                    smooth(&self.chords[number], table, self.profile, run.row, first_column, pixels);
                }
                Source::Summed(number) => {
                    let trees = &self.trees[self.trees_of[number].clone()];
                    summed(trees, self.profile, run.row, first_column, pixels);
                }
                Source::Edge { end, is_beside } => {
                    if let Some(table) = self.profile.edge() {
                        let (end, wings) = (&self.ends[end].0, wings[end].as_ref());
                        end.add_to(table, wings, is_beside, run.row, first_column, pixels);
                    }
                }
                Source::Middle(number) => {
                    pixels.fill(0.0);
                    let trees = &self.trees[self.ends[number].1.clone()];
                    summed(trees, self.profile, run.row, first_column, pixels);
                }
            }
        }
    }
}

/// Light of panels in pixels of a row.
#[inline(always)]
fn summed(trees: &[PanelTree], profile: &ProfileTables, row: usize, first_column: usize, pixels: &mut [f32]) {
    for (block, out) in pixels.chunks_mut(LANES).enumerate() {
        let at = [(first_column + block * LANES) as f64, row as f64];
        let mut light = [0.0; LANES];
        for tree in trees {
            tree.add_to(at, out.len(), profile, &mut light);
        }
        add(&light, out);
    }
}

/// Light of a chord in pixels of a row that have their feet on it.
///
/// A pixel at (a, b) has its foot at a₀ = a + d g and lies v = d (1 - g²/2) to the left of the path, where d = b - f(a), g = f'(a). Of a path of
/// curvature κ, points at a way u from the foot are at distance r² = v² + u² (1 - κv) from the pixel, to first order in κ, so that
///
/// I = λ(a₀) (1 + κv/2) L(v) + λ''/2 M₂(v).
///
/// Pixels are squares: L depends on the path's direction at the foot too, L(v, φ + κa₀) = L(v, φ) + κa₀ dL/dφ.
#[inline(always)]
fn smooth(chord: &Chord, table: &Across, profile: &ProfileTables, row: usize, first_column: usize, pixels: &mut [f32]) {
    if let Some(lattice) = &table.lattice {
        return straight(chord, lattice, row, first_column, pixels);
    }
    let stroke = Smooth::of(chord, table, profile);
    let [ux, uy] = chord.along;
    let dy = row as f64 - chord.middle[1];
    for (block, out) in pixels.chunks_mut(LANES).enumerate() {
        let dx = (first_column + block * LANES) as f64 - chord.middle[0];
        let first = [(dx * ux + dy * uy) as f32, (dy * ux - dx * uy) as f32];
        let light = stroke.light(&stroke.feet(first, &EACH));
        add(&light, out);
    }
}

/// A chord as the loop needs it.
struct Smooth<'a> {
    table: &'a Across,
    second_moment: Option<&'a Lanes>,
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
    fn of(chord: &Chord, table: &'a Across, profile: &'a ProfileTables) -> Self {
        Self {
            table,
            second_moment: chord.is_bent(profile).then(|| profile.line_second_moment()),
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
        let mut shares = self.table.line.at(&distance);
        if let Some(turned) = &self.table.turned {
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
