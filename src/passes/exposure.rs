//! One opening of the shutter: when, how long, where to.

use hifitime::Epoch;

use crate::frames::{Direction, Gcrs};

/// An exposure: the shutter opens at `start` and closes `duration_s` later, tracking one place among the stars.
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// The schedule's own name for it.
    pub id: String,
    /// Shutter opening.
    pub start: Epoch,
    /// Length, seconds, at least 0.
    pub duration_s: f64,
    /// Centre of the field, ICRS astrometric.
    pub pointing: Direction<Gcrs>,
    /// Position angle of the field's y axis, from north through east, radians.
    pub rotation_rad: f64,
}
