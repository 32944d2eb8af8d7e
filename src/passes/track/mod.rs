//! Lines of sight from an observer to a satellite over time, and the points of a track.

mod sight_line;
mod track_point;

pub(super) use sight_line::{ObserverMotion, Sight, SightLine};
pub use track_point::{Chord, Pass, TrackPoint};
