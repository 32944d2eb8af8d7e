//! The track of a light over a frame: where it is, and how bright, while the shutter is open.

use thiserror::Error;

use crate::images::PixelPosition;
use crate::math::quadrature::gauss_legendre;

use super::spline::{Cubic, held_slopes, smooth_slopes};

/// Places farther out than this are refused, pixels: there is no frame of such a size.
const FARTHEST_PIX: f64 = 1e9;

/// Nodes follow one another by at least so much, seconds.
const LEAST_STEP_S: f64 = 1e-9;

/// Why nodes do not make a path.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PathError {
    /// Fewer than two.
    #[error("a path needs at least 2 nodes, {given} given")]
    TooFew {
        /// How many there are.
        given: usize,
    },
    /// Time does not go on.
    #[error("node {node} is at {time_s} s, not after the one before it at {before_s} s (by at least {LEAST_STEP_S} s)")]
    Order {
        /// Its number, from 0.
        node: usize,
        /// Its time.
        time_s: f64,
        /// That of the one before.
        before_s: f64,
    },
    /// A number that is not finite, or a place too far from any frame.
    #[error("node {node}: {name} is {given}, allowed are finite numbers (places within 1e9 pixels)")]
    NotFinite {
        /// Its number, from 0.
        node: usize,
        /// The field.
        name: &'static str,
        /// As given.
        given: f64,
    },
    /// Light below zero.
    #[error("node {node}: the rate is {given} per second, allowed are 0 and more")]
    Negative {
        /// Its number, from 0.
        node: usize,
        /// As given.
        given: f64,
    },
}

/// A moment of a track.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathNode {
    /// Seconds after the shutter opened.
    pub time_s: f64,
    /// Where the light is.
    pub at: PixelPosition,
    /// How bright, frame counts or electrons per second: whatever is drawn is in this unit times seconds. At least 0.
    pub rate: f64,
    /// How bright from now on, where brightness jumps here (a glint's edge, a lamp switched on); none where it does not.
    pub rate_after: Option<f64>,
}

impl PathNode {
    /// A node without a jump.
    pub fn new(time_s: f64, at: PixelPosition, rate: f64) -> Self {
        Self { time_s, at, rate, rate_after: None }
    }
}

/// A light's track over a frame and its brightness along it, smooth between nodes.
///
/// Places follow the cubic spline through the nodes, with continuous speed and curvature: 2 nodes make a line, 3 a parabola. Rates follow the
/// same kind of spline, held back where it would swing between steps of brightness, never below 0, broken at jumps. The path begins with the first node and ends with the
/// last: nothing is drawn beyond.
#[derive(Clone, Debug, PartialEq)]
pub struct StreakPath {
    nodes: Vec<PathNode>,
    pieces: Vec<Piece>,
}

/// The path from one node to the next.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Piece {
    pub start_s: f64,
    pub duration_s: f64,
    pub x: Cubic,
    pub y: Cubic,
    pub rate: Cubic,
}

impl StreakPath {
    /// Through nodes in the order of their times.
    ///
    /// # Errors
    /// [`PathError`]: fewer than two nodes, times that do not increase, numbers that are not finite, rates below 0.
    pub fn new(nodes: Vec<PathNode>) -> Result<Self, PathError> {
        check(&nodes)?;
        let times: Vec<f64> = nodes.iter().map(|node| node.time_s).collect();
        let column = |of: fn(&PathNode) -> f64| -> (Vec<f64>, Vec<f64>) {
            let values: Vec<f64> = nodes.iter().map(of).collect();
            let slopes = smooth_slopes(&times, &values);
            (values, slopes)
        };
        let (x, y) = (column(|node| node.at.x), column(|node| node.at.y));
        let rates = rates(&nodes, &times);
        let pieces = (0..nodes.len() - 1).map(|i| {
            let duration_s = times[i + 1] - times[i];
            let cubic = |(values, slopes): &(Vec<f64>, Vec<f64>)| {
                Cubic::between([values[i], values[i + 1]], [slopes[i], slopes[i + 1]], duration_s)
            };
            Piece { start_s: times[i], duration_s, x: cubic(&x), y: cubic(&y), rate: rates[i] }
        });
        let pieces = pieces.collect();
        Ok(Self { nodes, pieces })
    }

    /// As they were given.
    pub fn nodes(&self) -> &[PathNode] {
        &self.nodes
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// ∫ rate dt: all the light of the path, on the frame or not.
    pub fn total(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.rate.integral(piece.duration_s)).sum()
    }

    /// Where the light is at a time, seconds after the shutter opened; before the first and after the last node, where those are.
    pub fn point_at(&self, time_s: f64) -> PixelPosition {
        let (piece, since_s) = self.piece_at(time_s);
        PixelPosition { x: piece.x.at(since_s), y: piece.y.at(since_s) }
    }

    /// How bright the light is at a time, the unit of the nodes; 0 before the first and after the last node.
    pub fn rate_at(&self, time_s: f64) -> f64 {
        let (first, last) = (self.nodes[0].time_s, self.nodes[self.nodes.len() - 1].time_s);
        if !(first..=last).contains(&time_s) {
            return 0.0;
        }
        let (piece, since_s) = self.piece_at(time_s);
        piece.rate.at(since_s)
    }

    /// Length of the whole path, pixels.
    pub fn length_pix(&self) -> f64 {
        let rule = gauss_legendre(8);
        let way = |piece: &Piece| {
            let speed = |(share, weight): &(f64, f64)| {
                let since_s = share * piece.duration_s;
                weight * piece.x.slope(since_s).hypot(piece.y.slope(since_s))
            };
            piece.duration_s * rule.iter().map(speed).sum::<f64>()
        };
        self.pieces.iter().map(way).sum()
    }

    fn piece_at(&self, time_s: f64) -> (&Piece, f64) {
        let after = self.pieces.partition_point(|piece| piece.start_s <= time_s);
        let piece = &self.pieces[after.saturating_sub(1)];
        (piece, (time_s - piece.start_s).clamp(0.0, piece.duration_s))
    }
}

fn check(nodes: &[PathNode]) -> Result<(), PathError> {
    if nodes.len() < 2 {
        return Err(PathError::TooFew { given: nodes.len() });
    }
    for (number, node) in nodes.iter().enumerate() {
        let after = node.rate_after.unwrap_or(node.rate);
        let fields =
            [("time_s", node.time_s), ("x", node.at.x), ("y", node.at.y), ("rate", node.rate), ("rate_after", after)];
        for (name, given) in fields {
            if !given.is_finite() || (matches!(name, "x" | "y") && given.abs() > FARTHEST_PIX) {
                return Err(PathError::NotFinite { node: number, name, given });
            }
        }
        if let Some(given) = [node.rate, after].into_iter().find(|rate| *rate < 0.0) {
            return Err(PathError::Negative { node: number, given });
        }
        if number > 0 && node.time_s - nodes[number - 1].time_s < LEAST_STEP_S {
            let before_s = nodes[number - 1].time_s;
            return Err(PathError::Order { node: number, time_s: node.time_s, before_s });
        }
    }
    Ok(())
}

/// The rate from node to node: runs between jumps are curves of their own.
fn rates(nodes: &[PathNode], times: &[f64]) -> Vec<Cubic> {
    let mut cubics = Vec::with_capacity(nodes.len() - 1);
    let mut start = 0;
    while start + 1 < nodes.len() {
        let jump = (start + 1..nodes.len()).find(|i| nodes[*i].rate_after.is_some());
        let end = jump.unwrap_or(nodes.len() - 1);
        let mut values: Vec<f64> = nodes[start..=end].iter().map(|node| node.rate).collect();
        values[0] = nodes[start].rate_after.unwrap_or(values[0]);
        let slopes = held_slopes(&times[start..=end], &values);
        cubics.extend((0..end - start).map(|i| {
            let step = times[start + i + 1] - times[start + i];
            Cubic::between([values[i], values[i + 1]], [slopes[i], slopes[i + 1]], step)
        }));
        start = end;
    }
    cubics
}
