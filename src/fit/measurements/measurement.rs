//! A measured magnitude in its geometry: what all of this room ends in, and what fits begin with.

use hifitime::Epoch;

use crate::elements::NoradId;
use crate::geometry::ViewingGeometry;
use crate::photometry::StandardMagnitude;

use super::dropped::DropCounts;

/// One measured magnitude.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Brought to 1000 km, in the band of the survey.
    pub magnitude: StandardMagnitude,
    /// One sigma as the survey states it, mag.
    pub sigma_mag: Option<f64>,
    /// Where Sun and observer stood in the satellite's frame.
    pub geometry: ViewingGeometry,
    /// Index into [`Measurements::groups`].
    pub group: u32,
    /// Which satellite, where that is known.
    pub norad_id: Option<NoradId>,
    /// When, where that is known.
    pub epoch: Option<Epoch>,
}

/// Measured magnitudes, and what was not used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// In the order of the files.
    pub points: Vec<Measurement>,
    /// Names of what was measured together: a track, a satellite, a night, or a whole file, whichever of these a row names first.
    pub groups: Vec<String>,
    /// Rows that are not among the points.
    pub dropped: DropCounts,
}
