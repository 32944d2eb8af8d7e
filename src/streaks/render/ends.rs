//! Ends of a path near which it is straight and even enough for tables.

use crate::streaks::{EdgeTable, ProfileTables};

use super::blocks::{EACH, LANES, add};
use super::chords::{Border, Chord};
use super::wings::{SIDE, Wings};

/// What a path that is neither straight nor linearly bright may change in a pixel, of the peak. The sum that is held against it takes all parts as if they had one
/// sign: where it allows a bend, 5·10⁻⁶ are found.
const TOLERANCE: f64 = 4e-5;
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
    pub fn add_to(
        &self,
        table: &EdgeTable,
        wings: Option<&Wings>,
        is_beside: bool,
        row: usize,
        first_column: usize,
        pixels: &mut [f32],
    ) {
        let Some(wings) = wings else { return self.add_each(table, is_beside, row, first_column, pixels) };
        let (mut column, mut rest) = (first_column, pixels);
        while !rest.is_empty() {
            let (light, place) = wings.light(is_beside, row, column);
            let (out, after) = rest.split_at_mut((SIDE - place).min(rest.len()));
            column += out.len();
            rest = after;
            match (light, <&mut [f32; SIDE]>::try_from(&mut *out)) {
                (Some(light), Ok(whole)) => whole.iter_mut().zip(light).for_each(|(pixel, light)| *pixel += light),
                (Some(light), Err(_)) => {
                    out.iter_mut().zip(&light[place..]).for_each(|(pixel, light)| *pixel += light);
                }
                (None, _) => self.add_each(table, is_beside, row, column - out.len(), out),
            }
        }
    }

    /// The same from the table for each pixel.
    #[inline(always)]
    fn add_each(&self, table: &EdgeTable, is_beside: bool, row: usize, first_column: usize, pixels: &mut [f32]) {
        let [x, y] = self.border.at;
        for (block, out) in pixels.chunks_mut(LANES).enumerate() {
            let Half { even, tilt, .. } =
                self.half(table, [(first_column + block * LANES) as f64 - x, row as f64 - y], &EACH);
            let sign = if is_beside { -1.0 } else { 1.0 };
            let mut light = [0.0; LANES];
            for lane in 0..LANES {
                light[lane] = sign * even[lane] + tilt[lane];
            }
            add(&light, out);
        }
    }

    /// Light at pixels so many columns after one at a place from the end.
    #[inline(always)]
    fn half<const N: usize>(&self, table: &EdgeTable, [dx, dy]: [f64; 2], columns: &[f32; N]) -> Half<N> {
        let (light, slope) = (self.light[0] as f32, self.light[1] as f32);
        let [x0, y0, u0] = [dx as f32, dy as f32, (dx * self.inward[0] + dy * self.inward[1]) as f32];
        let (mut distance, mut inward, mut cosine) = ([0.0; N], [0.0_f32; N], [0.0; N]);
        for (lane, column) in columns.iter().enumerate() {
            let x = x0 + column;
            distance[lane] = (x * x + y0 * y0).sqrt();
            inward[lane] = u0 + column * self.inward[0] as f32;
            cosine[lane] = inward[lane].abs() / distance[lane];
        }
        let (half, moment) = table.at(&distance, &cosine);
        let (mut even, mut tilt) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            even[lane] = light * half[lane];
            tilt[lane] = slope * (moment[lane] - inward[lane].abs() * half[lane]);
        }
        Half { even, tilt, inward }
    }

    /// What is added beyond the path and beside it, at pixels so many columns after one at a place from the end; each on the other's side of the normal too, as far
    /// as squares reach that lie on both; `line` is the profile across the whole line.
    #[inline(always)]
    pub fn nodes<const N: usize>(
        &self,
        [dx, dy]: [f64; 2],
        columns: &[f32; N],
        table: &EdgeTable,
        line: impl Fn(f64) -> f64,
    ) -> [[f32; N]; 2] {
        let Half { even, tilt, inward } = self.half(table, [dx, dy], columns);
        let (mut beyond, mut beside) = ([0.0; N], [0.0; N]);
        for lane in 0..N {
            (beyond[lane], beside[lane]) = (even[lane] + tilt[lane], tilt[lane] - even[lane]);
            if f64::from(inward[lane].abs()) > FARTHEST_ACROSS * ProfileTables::EVEN_PIX {
                continue;
            }
            let v = (dx + f64::from(columns[lane])) * self.inward[1] - dy * self.inward[0];
            let whole = ((self.light[0] + f64::from(inward[lane]) * self.light[1]) * line(v)) as f32;
            if inward[lane] < 0.0 {
                beside[lane] = beyond[lane] - whole;
            } else {
                beyond[lane] = beside[lane] + whole;
            }
        }
        [beyond, beside]
    }

    /// Angle of the path here, radians.
    pub fn angle_rad(&self) -> f64 {
        self.inward[1].atan2(self.inward[0])
    }

    /// Whether light beyond the path, or beside it, is a cubic between the corners of a square, of which `corners` are the places from the end.
    pub fn is_even(&self, corners: &[[f64; 2]; 4], is_beside: bool, even_from_pix: f64) -> bool {
        let along = corners.map(|[x, y]| x * self.inward[0] + y * self.inward[1]);
        let across = corners.map(|[x, y]| y * self.inward[0] - x * self.inward[1]);
        let least = |values: [f64; 4]| {
            let (low, high) =
                values.iter().fold((f64::MAX, f64::MIN), |(low, high), one| (low.min(*one), high.max(*one)));
            low.max(-high).max(0.0)
        };
        // Where it lies on both sides of the normal, light is that of a line which may pass near by.
        let is_own = along.iter().all(|along| (*along >= 0.0) == is_beside);
        let [x, y] = [0, 1].map(|axis| least(corners.map(|corner| corner[axis])));
        if is_own { x.hypot(y) >= even_from_pix } else { least(across) >= even_from_pix }
    }
}

/// Greatest distance from the normal of corners of squares that lie on both sides of it, of their side.
const FARTHEST_ACROSS: f64 = std::f64::consts::SQRT_2;

/// Light of half a line in pixels.
struct Half<const N: usize> {
    /// Of the light at its end.
    even: [f32; N],
    /// Of what it becomes brighter by.
    tilt: [f32; N],
    /// Ways inward to the feet of the pixels.
    inward: [f32; N],
}
