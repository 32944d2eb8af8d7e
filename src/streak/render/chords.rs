//! A path cut into short stretches, each a parabola over its chord.

use crate::quadrature::gauss_legendre;

use super::path::{Piece, StreakPath};

/// Longest chord, pixels: within it single precision is good to 10⁻⁵ pixels.
const LONGEST_PIX: f64 = 256.0;
/// Chords are not cut any shorter, pixels.
const SHORTEST_PIX: f64 = 2.0;
/// How far a path may lie from its parabola, pixels: 5·10⁻⁵ of the peak for a width of 1 pixel.
const BOW_ERROR_PIX: f64 = 1.5e-5;
/// How far light per pixel may lie from its parabola, of itself.
const LIGHT_ERROR: f64 = 3e-6;

/// A place on a path, and where the path goes.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Border {
    pub at: [f64; 2],
    /// Of unit length.
    pub along: [f64; 2],
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
    pub light: [f64; 3],
    /// Way from the start of the path to both ends, pixels (where the path is far from the frame, a lower limit).
    pub way_pix: [f64; 2],
    /// True where the path or its light is not a parabola.
    pub is_rough: bool,
}

impl Chord {
    /// Curvature, per pixel, positive to the left.
    pub fn curvature(&self) -> f64 {
        2.0 * self.bow
    }

    /// How far the path lies from its chord at most, pixels, with its sign.
    pub fn sagitta_pix(&self) -> f64 {
        -self.bow * self.half_pix * self.half_pix
    }

    /// λ''/2λ at the middle; infinite where light bends without being there.
    pub fn bend(&self) -> f64 {
        if self.light[2] == 0.0 { 0.0 } else { self.light[2] / self.light[0] }
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
    rule: Vec<(f64, f64)>,
}

impl<'a> Cutter<'a> {
    /// For a frame of `rows` by `columns` and light that reaches `reach_pix`.
    pub fn new(path: &'a StreakPath, rows: usize, columns: usize, reach_pix: f64) -> Self {
        let bounds = |count: usize| [-reach_pix, count as f64 - 1.0 + reach_pix];
        Self { pieces: path.pieces(), near: [bounds(columns), bounds(rows)], rule: gauss_legendre(8) }
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

    fn border(&self, piece: &Piece, since_s: f64) -> Option<(Border, f64)> {
        let [u, v] = piece.motion(since_s);
        let speed = u.hypot(v);
        // A thousandth of a pixel within the piece is standing still.
        (speed * piece.duration_s > 1e-3)
            .then(|| (Border { at: piece.at(since_s), along: [u / speed, v / speed] }, piece.rate.at(since_s) / speed))
    }

    fn chord(&self, stretch: Stretch, way_pix: [f64; 2]) -> Option<Chord> {
        let piece = &self.pieces[stretch.piece];
        let time = |share: f64| stretch.from_s + share * (stretch.to_s - stretch.from_s);
        let (start, first_light) = self.border(piece, stretch.from_s)?;
        let (end, last_light) = self.border(piece, stretch.to_s)?;
        let [dx, dy] = [end.at[0] - start.at[0], end.at[1] - start.at[1]];
        let length = dx.hypot(dy);
        if length < 1e-6 {
            return None;
        }
        let along = [dx / length, dy / length];
        let half_pix = 0.5 * length;
        let middle = [0.5 * (start.at[0] + end.at[0]), 0.5 * (start.at[1] + end.at[1])];
        let placed = |share: f64| {
            let (border, light) = self.border(piece, time(share))?;
            let [x, y] = [border.at[0] - middle[0], border.at[1] - middle[1]];
            Some((x * along[0] + y * along[1], y * along[0] - x * along[1], light))
        };
        let (a, b, light) = placed(0.5)?;
        if a.abs() > 0.5 * half_pix {
            return None;
        }
        let bow = b / (a * a - half_pix * half_pix);
        let light = parabola([(-half_pix, first_light), (a, light), (half_pix, last_light)]);
        let mut is_rough = false;
        for share in [0.25, 0.75] {
            let (a, b, true_light) = placed(share)?;
            let at = light[0] + a * (light[1] + a * light[2]);
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

/// Powers of the parabola through three points.
fn parabola(points: [(f64, f64); 3]) -> [f64; 3] {
    let [(a, f), (b, g), (c, h)] = points;
    let (first, second) = ((g - f) / (b - a), (h - g) / (c - b));
    let square = (second - first) / (c - a);
    let linear = first - square * (a + b);
    [f - a * (linear + a * square), linear, square]
}
