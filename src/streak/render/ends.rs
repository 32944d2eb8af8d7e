//! Ends of a path near which it is straight and even enough for tables.

use crate::camera::{EdgeTable, ProfileTables};

use super::chords::Chord;
use super::panels::LANES;

/// What a path that is neither straight nor linearly bright may change in a pixel, of the peak.
const TOLERANCE: f64 = 1e-5;
/// In profile reaches: how far from an end light must be smooth.
const CLEAR: f64 = 2.5;

/// Where the path begins or ends.
#[derive(Copy, Clone, Debug)]
pub(super) struct End {
    pub at: [f64; 2],
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
        let [constant, slope, square] = own.light;
        let end = Self {
            at: border.at,
            inward: border.along.map(|component| sign * component),
            light: [constant + a * (slope + a * square), sign * (slope + 2.0 * a * square)],
            way_pix: own.way_pix[usize::from(!is_start)],
            chord,
            from_pix: table.from_pix(),
        };
        let brightest = chords.iter().map(|chord| chord.light[0]).fold(end.light[0], f64::max);
        let error = end.error(chords, profile, table.from_pix());
        (error <= TOLERANCE * brightest * profile.line(0.0, 0.0)).then_some(end)
    }

    /// What a straight line of linear brightness leaves out at the distance from which tables are used, at most.
    fn error(&self, chords: &[Chord], profile: &ProfileTables, from_pix: f64) -> f64 {
        let reach = profile.pixel_reach_pix();
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
                let [x, y] = [x + a * ux - b * uy - self.at[0], y + a * uy + b * ux - self.at[1]];
                let sigma = x * self.inward[0] + y * self.inward[1];
                let length = 0.25 * chord.half_pix;
                if sigma.abs() - length > reach {
                    continue;
                }
                let light = chord.light[0] + a * (chord.light[1] + a * chord.light[2]);
                let off = light - (self.light[0] + sigma * self.light[1]);
                sum += felt((sigma - length).max(0.0), length, light, off, y * self.inward[0] - x * self.inward[1]);
            }
        }
        // What the loop for smooth light continues beyond the end: the chord's own parabolas.
        let own = &chords[self.chord];
        for part in 0..16 {
            let length = reach / 16.0;
            let sigma = (f64::from(part) + 1.0) * length;
            let off = own.light[2] * sigma * sigma;
            sum += felt(sigma - length, length, self.light[0] + off, off, own.bow * sigma * sigma);
        }
        sum
    }

    /// True where nothing that must be summed is near; `hard` are ways along the path.
    pub fn is_clear_of(&self, hard: &[[f64; 2]], profile: &ProfileTables) -> bool {
        let margin = CLEAR * profile.pixel_reach_pix() + 4.0;
        hard.iter().all(|[from, to]| self.way_pix < from - margin || self.way_pix > to + margin)
    }

    /// Light of the half line, added beyond the end and taken from what lies beside it.
    ///
    /// With the distance u of a pixel's foot from the end and light λ + λ' σ at a way σ from it, λ H + λ' (G - |u| H): see [`EdgeTable`]. Beside the path the loop for
    /// smooth light went on beyond the end: what it drew there goes the other way, with λ' of the other sign.
    #[inline(always)]
    pub fn add_to(&self, table: &EdgeTable, row: usize, first_column: usize, pixels: &mut [f32]) {
        let dy = row as f64 - self.at[1];
        let (light, slope) = (self.light[0] as f32, self.light[1] as f32);
        for (block, out) in pixels.chunks_mut(LANES).enumerate() {
            let dx = (first_column + block * LANES) as f64 - self.at[0];
            let u0 = (dx * self.inward[0] + dy * self.inward[1]) as f32;
            let (x0, y0) = (dx as f32, dy as f32);
            let (mut r, mut u, mut cosine) = ([0.0_f32; LANES], [0.0_f32; LANES], [0.0_f32; LANES]);
            for lane in 0..LANES {
                let x = x0 + lane as f32;
                r[lane] = (x * x + y0 * y0).sqrt();
                u[lane] = u0 + lane as f32 * self.inward[0] as f32;
                cosine[lane] = u[lane].abs() / r[lane];
            }
            let (half, moment) = table.at(&r, &cosine);
            let mut added = [0.0_f32; LANES];
            for lane in 0..LANES {
                let further = slope * (moment[lane] - u[lane].abs() * half[lane]);
                let even = light * half[lane];
                added[lane] = if u[lane] > 0.0 { further - even } else { further + even };
            }
            for (pixel, value) in out.iter_mut().zip(added) {
                *pixel += value;
            }
        }
    }
}
