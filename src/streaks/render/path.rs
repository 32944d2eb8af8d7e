//! Path of a light over a frame: its position and brightness during the exposure.

use crate::error::Error;
use crate::images::PixelPosition;
use crate::math::quadrature::gauss_legendre;

use super::spline::{Cubic, limited_slopes, smooth_slopes};

/// Largest accepted coordinate, pixels; larger than any frame.
const FARTHEST_PIX: f64 = 1e9;

/// Smallest accepted time between nodes, seconds.
const LEAST_STEP_S: f64 = 1e-9;

/// Position and brightness of a light at one time.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PathNode {
    /// Seconds after the shutter opened.
    pub time_s: f64,
    /// Position in the frame, pixels.
    pub at: PixelPosition,
    /// Brightness in counts of the frame or electrons per second, at least 0. Drawn light has the unit of the rate
    /// times seconds.
    pub rate: f64,
    /// Rate immediately after this time, if the brightness jumps (edge of a glint, lamp switched on); otherwise `None`.
    pub rate_after: Option<f64>,
}

impl PathNode {
    /// Returns a node without a jump.
    pub fn new(time_s: f64, at: PixelPosition, rate: f64) -> Self {
        Self { time_s, at, rate, rate_after: None }
    }
}

/// Position and brightness of a light as functions of time, smooth between nodes.
///
/// Positions follow the cubic spline through the nodes, with continuous speed and curvature; two nodes give a straight
/// line, three a parabola. Rates follow the same kind of spline, limited so that it does not overshoot at steps of
/// brightness and is never below 0; the spline is interrupted at jumps. The path begins at the first node and ends at
/// the last.
#[derive(Clone, Debug, PartialEq)]
pub struct StreakPath {
    nodes: Vec<PathNode>,
    pieces: Vec<Piece>,
}

/// Part of a path from one node to the next.
#[derive(Copy, Clone, Debug, PartialEq)]
pub(super) struct Piece {
    pub start_s: f64,
    pub duration_s: f64,
    pub x: Cubic,
    pub y: Cubic,
    pub rate: Cubic,
}

impl StreakPath {
    /// Creates the path through nodes, which must be in order of time.
    ///
    /// # Errors
    /// There are fewer than two nodes, times do not increase, a number is not finite, or a rate is below 0.
    pub fn new(nodes: Vec<PathNode>) -> Result<Self, Error> {
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

    /// Returns the nodes as given.
    pub fn nodes(&self) -> &[PathNode] {
        &self.nodes
    }

    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Returns ∫ rate dt, the light of the whole path inside and outside the frame.
    pub fn total(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.rate.integral(piece.duration_s)).sum()
    }

    /// Returns the position at a time, seconds after the shutter opened. Before the first and after the last node it is
    /// the position of that node.
    pub fn point_at(&self, time_s: f64) -> PixelPosition {
        let (piece, since_s) = self.piece_at(time_s);
        PixelPosition { x: piece.x.at(since_s), y: piece.y.at(since_s) }
    }

    /// Returns the rate at a time, in the unit of the nodes; 0 before the first and after the last node.
    pub fn rate_at(&self, time_s: f64) -> f64 {
        let (first, last) = (self.nodes[0].time_s, self.nodes[self.nodes.len() - 1].time_s);
        if !(first..=last).contains(&time_s) {
            return 0.0;
        }
        let (piece, since_s) = self.piece_at(time_s);
        piece.rate.at(since_s)
    }

    /// Returns the length of the whole path, pixels.
    pub fn length_pix(&self) -> f64 {
        let rule = gauss_legendre(8);
        let length = |piece: &Piece| {
            let speed = |(share, weight): &(f64, f64)| {
                let since_s = share * piece.duration_s;
                weight * piece.x.slope(since_s).hypot(piece.y.slope(since_s))
            };
            piece.duration_s * rule.iter().map(speed).sum::<f64>()
        };
        self.pieces.iter().map(length).sum()
    }

    fn piece_at(&self, time_s: f64) -> (&Piece, f64) {
        let after = self.pieces.partition_point(|piece| piece.start_s <= time_s);
        let piece = &self.pieces[after.saturating_sub(1)];
        (piece, (time_s - piece.start_s).clamp(0.0, piece.duration_s))
    }
}

fn check(nodes: &[PathNode]) -> Result<(), Error> {
    if nodes.len() < 2 {
        return Err(Error::invalid("number of nodes of the path", nodes.len(), "2 or more"));
    }
    for (number, node) in nodes.iter().enumerate() {
        let after = node.rate_after.unwrap_or(node.rate);
        let fields =
            [("time_s", node.time_s), ("x", node.at.x), ("y", node.at.y), ("rate", node.rate), ("rate_after", after)];
        for (name, given) in fields {
            if !given.is_finite() || (matches!(name, "x" | "y") && given.abs() > FARTHEST_PIX) {
                let allowed = "finite numbers (positions within 1e9 pixels)";
                return Err(Error::invalid(name, given, allowed).at(format_args!("node {number}")));
            }
        }
        if let Some(given) = [node.rate, after].into_iter().find(|rate| *rate < 0.0) {
            return Err(
                Error::invalid("rate", format!("{given} per second"), "0 or more").at(format_args!("node {number}"))
            );
        }
        if number > 0 && node.time_s - nodes[number - 1].time_s < LEAST_STEP_S {
            let before_s = nodes[number - 1].time_s;
            let allowed = format!("at least {LEAST_STEP_S} s after the previous node at {before_s} s");
            return Err(Error::invalid("time", format!("{} s", node.time_s), allowed).at(format_args!("node {number}")));
        }
    }
    Ok(())
}

/// Returns the rate between each two nodes as a cubic; splines do not continue across jumps.
fn rates(nodes: &[PathNode], times: &[f64]) -> Vec<Cubic> {
    let mut cubics = Vec::with_capacity(nodes.len() - 1);
    let mut start = 0;
    while start + 1 < nodes.len() {
        let jump = (start + 1..nodes.len()).find(|i| nodes[*i].rate_after.is_some());
        let end = jump.unwrap_or(nodes.len() - 1);
        let mut values: Vec<f64> = nodes[start..=end].iter().map(|node| node.rate).collect();
        values[0] = nodes[start].rate_after.unwrap_or(values[0]);
        let slopes = limited_slopes(&times[start..=end], &values);
        cubics.extend((0..end - start).map(|i| {
            let step = times[start + i + 1] - times[start + i];
            Cubic::between([values[i], values[i + 1]], [slopes[i], slopes[i + 1]], step)
        }));
        start = end;
    }
    cubics
}
