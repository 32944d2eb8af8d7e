//! Paths of light: `path` is position and brightness in time on `spline`s, `draw` sums its light over points.

mod draw;
mod path;
mod spline;

pub use draw::draw;
pub use path::{PathError, PathNode, StreakPath};
