//! Axes as types: mixing two frames does not compile.

mod frame;
mod vector;

pub use frame::{Body, Frame, Gcrs, Horizontal, Itrs, Teme};
pub use vector::{Direction, Position, Rotation, Velocity};
