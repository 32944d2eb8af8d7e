//! Paths of light: `path` describes position and brightness in time by `spline`s, `draw` sums the light over points.

mod draw;
mod path;
mod spline;

pub use draw::draw;
pub use path::{PathNode, StreakPath};
