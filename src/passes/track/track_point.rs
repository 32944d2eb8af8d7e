//! Points along a track, and the pass that they belong to.

use hifitime::Epoch;

use crate::elements::NoradId;
use crate::frames::{Direction, Gcrs};
use crate::geometry::{Illumination, ViewingGeometry};
use crate::photometry::Brightness;

/// A satellite at one time as the telescope sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackPoint {
    /// Time of reception.
    pub epoch: Epoch,
    /// ICRS astrometric topocentric direction.
    pub direction: Direction<Gcrs>,
    /// Altitude above the site's horizon without refraction, radians; `None` for an observer in space.
    pub altitude_rad: Option<f64>,
    /// Azimuth from north through east, [0, 2π), radians; `None` for an observer in space.
    pub azimuth_rad: Option<f64>,
    /// Distance from the observer, km.
    pub range_km: f64,
    /// Geometry of Sun, satellite and observer.
    pub geometry: ViewingGeometry,
    /// Sunlit, in penumbra or in umbra, with the lit fraction of the solar disk.
    pub illumination: Illumination,
    /// Apparent magnitude with its sigma and source, the shadow's dimming included. `None` in the umbra and where a
    /// model sees nothing.
    pub brightness: Option<Brightness>,
}

/// One part of the track inside the field, from entry (or shutter opening) to exit (or shutter closing).
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Chord {
    /// Seconds after the shutter opened.
    pub enter_s: f64,
    /// Seconds after the shutter opened, not before `enter_s`.
    pub exit_s: f64,
}

/// One satellite crossing one exposure's field, or passing near it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Position of its element set in the sky's catalogue.
    pub element_index: usize,
    /// Parts of the track inside the field in time order, one per chip or arm of the shape; empty for a near miss.
    pub chords: Vec<Chord>,
    /// Begin of the first chord; for a near miss, the closest point.
    pub enter: TrackPoint,
    /// Midway in time between `enter` and `exit`; for a near miss, the same point.
    pub mid: TrackPoint,
    /// End of the last chord; for a near miss, the same point.
    pub exit: TrackPoint,
    /// The brightest point between `enter` and `exit`; `None` where none of it is visible, and without light.
    pub peak: Option<TrackPoint>,
    /// Least angle between track and field centre while the shutter is open, radians.
    pub min_separation_rad: f64,
    /// Length of the track on the sky inside the field, all chords, radians.
    pub streak_length_rad: f64,
    /// Direction of motion at mid, from north through east, [0, 2π), radians.
    pub position_angle_rad: f64,
    /// Speed on the sky at mid, rad/s.
    pub angular_rate_rad_s: f64,
    /// Exposure mid minus element epoch, days; negative where the elements are newer.
    pub element_age_days: f64,
    /// One-sigma error along the track as time, seconds.
    pub along_track_sigma_s: f64,
    /// One-sigma error across the track as an angle seen from the observer, radians.
    pub cross_track_sigma_rad: f64,
    /// Probability that the satellite crosses the field while the shutter is open, given those errors.
    pub probability: f64,
    /// Lit at any time between `enter` and `exit`.
    pub lit: bool,
    /// Points along the track; empty without samples in the options.
    pub samples: Vec<TrackPoint>,
}

impl Pass {
    /// True where the nominal track enters the field.
    pub fn is_crossing(&self) -> bool {
        !self.chords.is_empty()
    }

    /// Brightest apparent magnitude between entry and exit; NaN where no light of the satellite is seen.
    pub fn peak_magnitude(&self) -> f64 {
        let brightness = self.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
        brightness.map_or(f64::NAN, |brightness| brightness.magnitude.0)
    }
}
