//! Paths of light: `path` describes position and brightness as `spline`s in time, `draw` draws a path as a sum of
//! points, and `draw_image` draws it with a point spread function from a file.

mod draw;
#[cfg(all(feature = "fits", unix))]
mod draw_image;
mod path;
mod spline;

pub use draw::draw;
#[cfg(all(feature = "fits", unix))]
pub use draw_image::{draw_image, image_width_pix};
pub use path::{PathNode, StreakPath};
