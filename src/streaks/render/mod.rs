//! Paths of light: `path` describes position and brightness as `spline`s in time, `draw` draws a path as a sum of
//! points.

mod draw;
mod path;
mod spline;

pub use draw::draw;
pub use path::{PathNode, StreakPath};
