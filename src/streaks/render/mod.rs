//! A path drawn: `path` (where a light is and how bright) on `spline`s, `draw` sums its light over points.

mod draw;
mod path;
mod spline;

pub use draw::draw;
pub use path::{PathError, PathNode, StreakPath};
