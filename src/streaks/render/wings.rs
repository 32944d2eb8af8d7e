//! Far from an end its light is so even that over squares of pixels it is a cubic, both ways.

use crate::streaks::{EdgeTable, ProfileTables};

use super::blocks::{EACH, FOUR, LANES, through, weights};
use super::ends::End;

/// Columns and rows of a square.
pub(super) const SIDE: usize = LANES - 1;
/// Nodes from one square to the next.
const NODES: usize = FOUR.len() - 1;
/// Columns and rows from one node to the next.
const STEP: usize = SIDE / NODES;
const _: () = assert!(FOUR[1] as usize == STEP && ProfileTables::EVEN_PIX == SIDE as f64);

/// Columns of neighbouring nodes, from the first.
const COLUMNS: [f32; LANES] = {
    let mut columns = EACH;
    let mut node = 0;
    while node < LANES {
        columns[node] *= STEP as f32;
        node += 1;
    }
    columns
};

/// What an end changes, at nodes of a grid over the pixels of a frame within reach of it.
///
/// Light beside the path and light beyond it are functions of their own, each as smooth on the other's side of the normal as on its own, but near the path: what lies between them is
/// the light of the whole line.
pub(super) struct Wings {
    /// Column and row of the first node.
    first: [usize; 2],
    /// Squares in a row, and rows of them.
    squares: [usize; 2],
    /// Of light beyond the path and beside it.
    sides: [Side; 2],
}

#[derive(Default)]
struct Side {
    /// Of each square: whether cubics will do.
    is_even: Vec<bool>,
    /// Row after row of nodes.
    nodes: Vec<f32>,
}

impl Wings {
    /// In a frame of `columns` by `rows`; none where light is even nowhere.
    #[inline(always)]
    pub fn of(end: &End, table: &EdgeTable, profile: &ProfileTables, frame: [usize; 2]) -> Option<Self> {
        let even_from_pix = table.even_from_pix();
        if !even_from_pix.is_finite() {
            return None;
        }
        let reach = profile.pixel_reach_pix();
        let first = end.border.at.map(|place| (place - reach).floor().max(0.0));
        let squares = [0, 1].map(|axis| {
            let last = (end.border.at[axis] + reach).min(frame[axis] as f64);
            ((last - first[axis]) / SIDE as f64) as usize + 1
        });
        let from_end = |node: usize, axis: usize| first[axis] + (node * STEP) as f64 - end.border.at[axis];
        let mut sides = [Side::default(), Side::default()];
        for square in 0..squares[0] * squares[1] {
            let [x, y] = [square % squares[0], square / squares[0]].map(|number| number * NODES);
            let corners = [[0, 0], [NODES, 0], [0, NODES], [NODES, NODES]];
            let corners = corners.map(|[right, up]| [from_end(x + right, 0), from_end(y + up, 1)]);
            for (is_beside, side) in [false, true].into_iter().zip(&mut sides) {
                side.is_even.push(end.is_even(&corners, is_beside, even_from_pix));
            }
        }
        let [across, down] = squares.map(|count| count * NODES + 1);
        let line = profile.line_of(end.angle_rad());
        for row in 0..down {
            for block in (0..across).step_by(LANES) {
                let [beyond, beside] = end.nodes([from_end(block, 0), from_end(row, 1)], &COLUMNS, table, &line);
                let used = LANES.min(across - block);
                sides[0].nodes.extend_from_slice(&beyond[..used]);
                sides[1].nodes.extend_from_slice(&beside[..used]);
            }
        }
        Some(Self { first: first.map(|place| place as usize), squares, sides })
    }

    /// Light in the columns of the square that holds a pixel and in one more, and which of them is the pixel's; none of it where cubics will not do.
    #[inline(always)]
    pub fn light(&self, is_beside: bool, row: usize, column: usize) -> (Option<[f32; LANES]>, usize) {
        let since = |place: usize, axis: usize| place.saturating_sub(self.first[axis]);
        let (x, y) = (since(column, 0), since(row, 1));
        let (place, square) = (x % SIDE, [x / SIDE, y / SIDE]);
        let side = &self.sides[usize::from(is_beside)];
        let across = self.squares[0];
        let is_even = square[0] < across && side.is_even.get(square[1] * across + square[0]) == Some(&true);
        if !is_even {
            return (None, place);
        }
        let across = across * NODES + 1;
        let mut four = [0.0; 4];
        for (node, weight) in weights(y % SIDE).into_iter().enumerate() {
            let at = (square[1] * NODES + node) * across + square[0] * NODES;
            for (sum, value) in four.iter_mut().zip(&side.nodes[at..at + 4]) {
                *sum += weight * value;
            }
        }
        (Some(through(four)), place)
    }
}
