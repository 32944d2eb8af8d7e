//! A path cut into short stretches, each a parabola over its chord, and its light a cubic.

use crate::math::quadrature::gauss_legendre;

use super::path::{Piece, StreakPath};
use crate::streaks::ProfileTables;

/// Longest chord, pixels: within it single precision is good to 10⁻⁵ pixels.
const LONGEST_PIX: f64 = 256.0;
/// Chords are not cut any shorter, pixels.
const SHORTEST_PIX: f64 = 2.0;
/// How far a path may lie from its parabola, pixels: 5·10⁻⁵ of the peak for a width of 1 pixel.
const BOW_ERROR_PIX: f64 = 1.5e-5;
/// How far light per pixel may lie from its cubic, of itself.
const LIGHT_ERROR: f64 = 3e-6;

/// λ''/2λ times the variance from which on it is felt.
const LEAST_BEND: f64 = 2e-6;

/// A place on a path, and where the path goes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Border {
    pub at: [f64; 2],
    /// Of unit length.
    pub along: [f64; 2],
}

impl Border {
    /// True where they differ by no more than their arithmetic does.
    fn is_nearly(&self, other: &Self) -> bool {
        const ROUNDING: f64 = 1e-9;
        let near = |a: [f64; 2], b: [f64; 2], allowed: f64| (a[0] - b[0]).hypot(a[1] - b[1]) <= allowed;
        let size = 1.0 + self.at[0].hypot(self.at[1]);
        near(self.at, other.at, ROUNDING * size) && near(self.along, other.along, ROUNDING)
    }
}

/// Part of a piece, seconds since the piece's start.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Stretch {
    pub piece: usize,
    pub from_s: f64,
    pub to_s: f64,
}

/// A stretch as a parabola: `a` pixels along the chord from its middle, `b` pixels to the left of it.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Chord {
    pub stretch: Stretch,
    pub start: Border,
    pub end: Border,
    pub middle: [f64; 2],
    /// Unit vector of the chord.
    pub along: [f64; 2],
    pub half_pix: f64,
    /// b = bow (a² - half²).
    pub bow: f64,
    /// Light per pixel of length: powers of a.
    pub light: [f64; 4],
    /// Way from the start of the path to both ends, pixels (where the path is far from the frame, a lower limit).
    pub way_pix: [f64; 2],
    /// True where the path is not a parabola or its light not a cubic.
    pub is_rough: bool,
}

impl Chord {
    /// Curvature, per pixel, positive to the left.
    pub fn curvature(&self) -> f64 {
        2.0 * self.bow
    }

    /// Direction of the chord from the rows, radians.
    pub fn angle_rad(&self) -> f64 {
        self.along[1].atan2(self.along[0])
    }

    /// Greatest angle between the path and its chord, radians.
    pub fn half_turn_rad(&self) -> f64 {
        self.curvature().abs() * self.half_pix
    }

    /// How far the path lies from its chord at most, pixels, with its sign.
    pub fn sagitta_pix(&self) -> f64 {
        -self.bow * self.half_pix * self.half_pix
    }

    /// λ, λ' and λ''/2 at a place of the chord.
    pub fn light_at(&self, a: f64) -> [f64; 3] {
        let [constant, slope, square, cube] = self.light;
        let light = constant + a * (slope + a * (square + a * cube));
        [light, slope + a * (2.0 * square + 3.0 * a * cube), square + 3.0 * a * cube]
    }

    /// |λ''|/2 at most, of λ at the middle; infinite where light bends without being there.
    pub fn bend(&self) -> f64 {
        let [first, last] = [-self.half_pix, self.half_pix].map(|a| self.light_at(a)[2].abs());
        let most = first.max(last);
        if most == 0.0 { 0.0 } else { most / self.light[0].abs() }
    }

    /// Whether light bends by so much that its second moment is felt.
    pub fn is_bent(&self, profile: &ProfileTables) -> bool {
        self.bend() * profile.variance_pix2() > LEAST_BEND
    }

    /// Angle between the directions at both ends, radians.
    pub fn turning_rad(&self) -> f64 {
        let (a, b) = (self.start.along, self.end.along);
        (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1]).abs()
    }
}

/// Cuts a path into stretches that come near a frame.
pub(super) struct Cutter<'a> {
    pub pieces: &'a [Piece],
    /// Bounds of x and y within which light reaches the frame.
    pub near: [[f64; 2]; 2],
    /// A chord from whose direction its path turns by more is rough, radians.
    most_turn_rad: f64,
    rule: Vec<(f64, f64)>,
}

impl<'a> Cutter<'a> {
    /// For a frame of `rows` by `columns`.
    pub fn new(path: &'a StreakPath, profile: &ProfileTables, rows: usize, columns: usize) -> Self {
        let reach_pix = profile.pixel_reach_pix();
        let bounds = |count: usize| [-reach_pix, count as f64 - 1.0 + reach_pix];
        Self {
            pieces: path.pieces(),
            near: [bounds(columns), bounds(rows)],
            most_turn_rad: profile.line_most_turn_rad(),
            rule: gauss_legendre(8),
        }
    }

    /// Way along a stretch, pixels.
    pub fn length_pix(&self, stretch: Stretch) -> f64 {
        self.pieces[stretch.piece].length_pix(stretch.from_s, stretch.to_s, &self.rule)
    }

    fn is_near(&self, stretch: Stretch) -> bool {
        let piece = &self.pieces[stretch.piece];
        [piece.x, piece.y].iter().zip(self.near).all(|(cubic, near)| {
            let [least, greatest] = cubic.bounds(stretch.from_s, stretch.to_s);
            least <= near[1] && greatest >= near[0]
        })
    }

    /// True where the path begins with this chord, or ends.
    pub fn is_end(&self, chord: &Chord, is_start: bool) -> bool {
        let Stretch { piece, from_s, to_s } = chord.stretch;
        if is_start {
            piece == 0 && from_s == 0.0
        } else {
            piece + 1 == self.pieces.len() && to_s == self.pieces[piece].duration_s
        }
    }

    /// All stretches near the frame, none longer than allowed, with the way to their starts.
    pub fn stretches(&self) -> Vec<(Stretch, [f64; 2])> {
        let mut found = Vec::new();
        let mut way = 0.0;
        for (number, piece) in self.pieces.iter().enumerate() {
            let whole = Stretch { piece: number, from_s: 0.0, to_s: piece.duration_s };
            let mut open = vec![whole];
            while let Some(stretch) = open.pop() {
                let length = self.length_pix(stretch);
                if !self.is_near(stretch) {
                    way += length;
                } else if length > LONGEST_PIX {
                    let [first, second] = halves(stretch);
                    open.push(second);
                    open.push(first);
                } else {
                    found.push((stretch, [way, way + length]));
                    way += length;
                }
            }
        }
        found
    }

    /// Chords of all stretches near the frame; none where the path stands still somewhere or turns too sharply for chords.
    pub fn chords(&self) -> Option<Vec<Chord>> {
        let mut chords = Vec::new();
        for (stretch, way_pix) in self.stretches() {
            self.chords_of(stretch, way_pix, &mut chords)?;
        }
        Some(chords)
    }

    fn chords_of(&self, stretch: Stretch, way_pix: [f64; 2], chords: &mut Vec<Chord>) -> Option<()> {
        let chord = self.chord(stretch, way_pix)?;
        if chord.is_rough && way_pix[1] - way_pix[0] > SHORTEST_PIX {
            let [first, second] = halves(stretch);
            let between = way_pix[0] + self.length_pix(first);
            self.chords_of(first, [way_pix[0], between], chords)?;
            self.chords_of(second, [between, way_pix[1]], chords)
        } else {
            chords.push(chord);
            Some(())
        }
    }

    /// Two chords in place of one.
    pub fn halve(&self, chord: &Chord) -> Option<[Chord; 2]> {
        let [first, second] = halves(chord.stretch);
        let between = chord.way_pix[0] + self.length_pix(first);
        Some([self.chord(first, [chord.way_pix[0], between])?, self.chord(second, [between, chord.way_pix[1]])?])
    }

    /// The normal at a moment of a piece, and the light there. Where one piece goes on as the next, both have the same normal to the last bit: else a pixel
    /// that lies on it might be either's, or nobody's.
    fn border(&self, number: usize, since_s: f64) -> Option<(Border, f64)> {
        let piece = &self.pieces[number];
        let [u, v] = piece.motion(since_s);
        let speed = u.hypot(v);
        // A thousandth of a pixel within the piece is standing still.
        if speed * piece.duration_s <= 1e-3 {
            return None;
        }
        let own = Border { at: piece.at(since_s), along: [u / speed, v / speed] };
        let next = self.pieces.get(number + 1).filter(|_| since_s == piece.duration_s).and_then(|next| {
            let [u, v] = next.motion(0.0);
            let of_next = Border { at: next.at(0.0), along: [u, v].map(|one| one / u.hypot(v)) };
            of_next.is_nearly(&own).then_some(of_next)
        });
        Some((next.unwrap_or(own), piece.rate.at(since_s) / speed))
    }

    fn chord(&self, stretch: Stretch, way_pix: [f64; 2]) -> Option<Chord> {
        let time = |share: f64| stretch.from_s + share * (stretch.to_s - stretch.from_s);
        let (start, first_light) = self.border(stretch.piece, stretch.from_s)?;
        let (end, last_light) = self.border(stretch.piece, stretch.to_s)?;
        let [dx, dy] = [end.at[0] - start.at[0], end.at[1] - start.at[1]];
        let length = dx.hypot(dy);
        if length < 1e-6 {
            return None;
        }
        let along = [dx / length, dy / length];
        let half_pix = 0.5 * length;
        let middle = [0.5 * (start.at[0] + end.at[0]), 0.5 * (start.at[1] + end.at[1])];
        let placed = |share: f64| {
            let (border, light) = self.border(stretch.piece, time(share))?;
            let [x, y] = [border.at[0] - middle[0], border.at[1] - middle[1]];
            Some((x * along[0] + y * along[1], y * along[0] - x * along[1], light))
        };
        let (a, b, middle_light) = placed(0.5)?;
        if a.abs() > 0.5 * half_pix {
            return None;
        }
        let bow = b / (a * a - half_pix * half_pix);
        let (first_third, last_third) = (placed(1.0 / 3.0)?, placed(2.0 / 3.0)?);
        let light = cubic([
            (-half_pix, first_light),
            (first_third.0, first_third.2),
            (last_third.0, last_third.2),
            (half_pix, last_light),
        ]);
        let mut is_rough = 2.0 * bow.abs() * half_pix > self.most_turn_rad;
        for (a, b, true_light) in [placed(0.25)?, (a, b, middle_light), placed(0.75)?] {
            let at = light[0] + a * (light[1] + a * (light[2] + a * light[3]));
            is_rough |= (b - bow * (a * a - half_pix * half_pix)).abs() > BOW_ERROR_PIX;
            is_rough |= (at - true_light).abs() > LIGHT_ERROR * true_light.abs().max(first_light).max(last_light);
        }
        Some(Chord { stretch, start, end, middle, along, half_pix, bow, light, way_pix, is_rough })
    }
}

fn halves(stretch: Stretch) -> [Stretch; 2] {
    let middle = 0.5 * (stretch.from_s + stretch.to_s);
    [Stretch { to_s: middle, ..stretch }, Stretch { from_s: middle, ..stretch }]
}

/// Powers of the cubic through four points, by Newton's divided differences.
fn cubic(points: [(f64, f64); 4]) -> [f64; 4] {
    let mut differences = points.map(|(_, value)| value);
    for order in 1..4 {
        for i in (order..4).rev() {
            differences[i] = (differences[i] - differences[i - 1]) / (points[i].0 - points[i - order].0);
        }
    }
    // Σ d_i Π_(j<i) (a - a_j), from the innermost factor outwards.
    let mut powers = [0.0; 4];
    for i in (0..4).rev() {
        for k in (1..4).rev() {
            powers[k] = powers[k - 1] - points[i].0 * powers[k];
        }
        powers[0] = differences[i] - points[i].0 * powers[0];
    }
    powers
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_goes_through_its_points() {
        let value = |a: f64| 2.0 + a * (-0.5 + a * (0.03 + a * 0.001));
        let found = cubic([-20.0, -6.0, 7.5, 20.0].map(|a| (a, value(a))));
        for (found, power) in found.into_iter().zip([2.0, -0.5, 0.03, 0.001]) {
            assert!((found - power).abs() < 1e-12, "{found} {power}");
        }
    }
}
