//! Ends of a path near which it is straight and even enough for tables.

use crate::camera::{EdgeTable, ProfileTables};

use super::blocks::{EACH, FOUR, LANES, add, through};
use super::chords::{Border, Chord};

/// What a path that is neither straight nor linearly bright may change in a pixel, of the peak.
const TOLERANCE: f64 = 1e-5;
/// In profile reaches: how far from an end light must be smooth.
const CLEAR: f64 = 2.5;

/// Where the path begins or ends.
#[derive(Copy, Clone, Debug)]
pub(super) struct End {
    /// The normal on which it lies, of its chord.
    pub border: Border,
    /// True where the path begins.
    pub is_start: bool,
    /// Unit vector along the path, away from the end.
    inward: [f64; 2],
    /// Light per pixel of length at the end, and its change per pixel inward.
    light: [f64; 2],
    /// Way from the start of the path, pixels.
    pub way_pix: f64,
    /// Number of the chord that ends here.
    pub chord: usize,
    /// Pixels within this distance are summed.
    pub from_pix: f64,
}

impl End {
    /// The end of a chord, the path's first or last; none where tables will not do for it.
    pub fn of(chords: &[Chord], chord: usize, is_start: bool, profile: &ProfileTables) -> Option<Self> {
        let table = profile.edge()?;
        let own = &chords[chord];
        let (border, sign, a) =
            if is_start { (&own.start, 1.0, -own.half_pix) } else { (&own.end, -1.0, own.half_pix) };
        let [light, slope, square] = own.light_at(a);
        let end = Self {
            border: *border,
            is_start,
            inward: border.along.map(|component| sign * component),
            light: [light, sign * slope],
            way_pix: own.way_pix[usize::from(!is_start)],
            chord,
            from_pix: table.from_pix(),
        };
        let brightest = chords.iter().map(|chord| chord.light[0]).fold(end.light[0], f64::max);
        let error = end.error(chords, profile, [square, -sign * own.light[3]]);
        (error <= TOLERANCE * brightest * profile.line(0.0, 0.0)).then_some(end)
    }

    /// What a straight line of linear brightness leaves out at the distance from which tables are used, at most. Beyond the end the light of the
    /// last chord goes on by `beyond`, powers 2 and 3 of the way from there.
    fn error(&self, chords: &[Chord], profile: &ProfileTables, beyond: [f64; 2]) -> f64 {
        let (reach, from_pix) = (profile.pixel_reach_pix(), self.from_pix);
        // Light λ, off by δλ, displaced by b, over a length at a distance σ along the line.
        let felt = |sigma: f64, length: f64, light: f64, off: f64, b: f64| {
            let r = from_pix.hypot(sigma);
            let near = profile.pixel((r - b.abs()).max(0.0), 0.0);
            length * (off.abs() * near + light.abs() * (near - profile.pixel(r, 0.0)).abs())
        };
        let mut sum = 0.0;
        // The path itself, in eight parts of each chord.
        for chord in chords {
            for part in 0..8 {
                let a = chord.half_pix * (f64::from(part) / 4.0 - 0.75);
                let b = chord.bow * (a * a - chord.half_pix * chord.half_pix);
                let ([ux, uy], [x, y]) = (chord.along, chord.middle);
                let [x, y] = [x + a * ux - b * uy - self.border.at[0], y + a * uy + b * ux - self.border.at[1]];
                let sigma = x * self.inward[0] + y * self.inward[1];
                let length = 0.25 * chord.half_pix;
                if sigma.abs() - length > reach {
                    continue;
                }
                let [light, ..] = chord.light_at(a);
                let off = light - (self.light[0] + sigma * self.light[1]);
                sum += felt((sigma - length).max(0.0), length, light, off, y * self.inward[0] - x * self.inward[1]);
            }
        }
        // What the loop for smooth light continues beyond the end: the chord's own parabola and cubic.
        let own = &chords[self.chord];
        for part in 0..16 {
            let length = reach / 16.0;
            let sigma = (f64::from(part) + 1.0) * length;
            let off = (beyond[0] + beyond[1] * sigma) * sigma * sigma;
            sum += felt(sigma - length, length, self.light[0] + off, off, own.bow * sigma * sigma);
        }
        sum
    }

    /// True where nothing that must be summed is near; `hard` are ways along the path.
    pub fn is_clear_of(&self, hard: &[[f64; 2]], profile: &ProfileTables) -> bool {
        let margin = CLEAR * profile.pixel_reach_pix() + 4.0;
        hard.iter().all(|[from, to]| self.way_pix < from - margin || self.way_pix > to + margin)
    }

    /// Light of the half line, added beyond the end and taken from what lies beside the path: all of the pixels are one or the other.
    ///
    /// With the distance u of a pixel's foot from the end and light λ + λ' σ at a way σ from it, λ H + λ' (G - |u| H): see [`EdgeTable`]. Beside the path the loop for
    /// smooth light went on beyond the end: what it drew there goes the other way, with λ' of the other sign.
    #[inline(always)]
    pub fn add_to(&self, table: &EdgeTable, is_beside: bool, row: usize, first_column: usize, pixels: &mut [f32]) {
        let [x, y] = self.border.at;
        let dy = row as f64 - y;
        let even_from = table.even_from_pix() as f32;
        for (block, out) in pixels.chunks_mut(LANES).enumerate() {
            let dx = (first_column + block * LANES) as f64 - x;
            let first = [dx as f32, dy as f32, (dx * self.inward[0] + dy * self.inward[1]) as f32];
            let four = self.seen(first, &FOUR);
            // The nearest of the pixels, wherever in the row it is.
            let nearest = first[1].hypot((-first[0]).clamp(FOUR[0], FOUR[3]) + first[0]);
            let light = if out.len() == LANES && nearest >= even_from {
                through(self.light_of(table, is_beside, &four))
            } else {
                self.light_of(table, is_beside, &self.seen(first, &EACH))
            };
            add(&light, out);
        }
    }

    /// Pixels so many columns after the first, of which x, y and way inward are given.
    #[inline(always)]
    fn seen<const N: usize>(&self, [x0, y0, u0]: [f32; 3], columns: &[f32; N]) -> Seen<N> {
        let mut seen = Seen { distance: [0.0; N], inward: [0.0; N] };
        for (lane, column) in columns.iter().enumerate() {
            let x = x0 + column;
            seen.distance[lane] = (x * x + y0 * y0).sqrt();
            seen.inward[lane] = u0 + column * self.inward[0] as f32;
        }
        seen
    }

    #[inline(always)]
    fn light_of<const N: usize>(&self, table: &EdgeTable, is_beside: bool, seen: &Seen<N>) -> [f32; N] {
        let (light, slope) = (self.light[0] as f32, self.light[1] as f32);
        let even = if is_beside { -light } else { light };
        let Seen { distance, inward } = seen;
        let mut cosine = [0.0; N];
        for lane in 0..N {
            cosine[lane] = inward[lane].abs() / distance[lane];
        }
        let (half, moment) = table.at(distance, &cosine);
        let mut added = [0.0; N];
        for lane in 0..N {
            added[lane] = even * half[lane] + slope * (moment[lane] - inward[lane].abs() * half[lane]);
        }
        added
    }
}

/// Pixels as an end sees them: their distances, and the ways inward to their feet.
struct Seen<const N: usize> {
    distance: [f32; N],
    inward: [f32; N],
}
