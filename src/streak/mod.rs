//! Streaks in pixels: the light of a pass put into a frame, with its truth.

mod chords;
mod panels;
mod path;
mod render;
mod runs;
mod spline;
mod strokes;

pub use path::{PathError, PathNode, StreakPath};
pub use render::{draw, draw_summed};
