//! How Sun, satellite and observer stand to one another.

mod viewing;

pub use viewing::ViewingGeometry;
