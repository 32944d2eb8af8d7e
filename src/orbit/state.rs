//! State of a satellite.

use crate::frames::{Frame, Position, Velocity};

/// Position and velocity in one frame.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct State<F: Frame> {
    /// Geocentric position, km.
    pub position: Position<F>,
    /// Velocity with respect to the frame's axes taken as fixed, km/s.
    pub velocity: Velocity<F>,
}
