//! Track of a satellite as seen by an observer: the line of sight as a function of time, and the points that are
//! reported.

use std::sync::Arc;

use hifitime::Epoch;
use nalgebra::Vector3;

use crate::constants::EARTH_ROTATION_RAD_S;
use crate::elements::NoradId;
use crate::frames::{Direction, Gcrs, Orientation, Position, Velocity};
use crate::geometry::{Aspect, Illumination, Observer, ViewingGeometry, aspect};
use crate::orbit::{OrbitArc, PositionSource, State};
use crate::photometry::Brightness;

/// Largest acceleration in an orbit, km/s²: gravity at the ground.
const GRAVITY_KM_S2: f64 = 0.009_83;

/// Line of sight and its rate of change. The length of the vector is irrelevant.
#[derive(Copy, Clone, Debug)]
pub(in crate::passes) struct Sight {
    pub vector: Vector3<f64>,
    pub rate_s: Vector3<f64>,
}

/// Motion of an observer: of a site near one time, or of a telescope in orbit along its arc.
#[derive(Clone, Debug)]
pub(in crate::passes) struct ObserverMotion {
    path: Path,
    /// Barycentric velocity of the Earth, for the aberration.
    earth_velocity: Velocity<Gcrs>,
    /// Interval outside which the observer is taken to be at rest, seconds.
    moving_s: (f64, f64),
}

#[derive(Clone, Debug)]
enum Path {
    /// Site that rotates about the pole of date with the Earth.
    ///
    /// The position is accurate to a millimetre over ten minutes, because only the rates of precession, polar motion
    /// and UT1 are neglected.
    Turning { at_s: f64, fixed: Vector3<f64>, turning: Vector3<f64>, ahead: Vector3<f64> },
    /// A telescope in orbit.
    Flying(Arc<OrbitArc>),
}

impl ObserverMotion {
    /// Creates the motion of a site near `at_s`.
    pub fn of_site(observer: &Observer, orientation: &Orientation, earth_velocity: Velocity<Gcrs>, at_s: f64) -> Self {
        let position = *observer.position(orientation).vector();
        let pole: Vector3<f64> = orientation.teme_to_gcrs.matrix().column(2).into_owned();
        let fixed = pole * pole.dot(&position);
        let path = Path::Turning { at_s, fixed, turning: position - fixed, ahead: pole.cross(&position) };
        Self { path, earth_velocity, moving_s: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// Creates the motion of a telescope in orbit along its arc.
    pub fn of_flight(arc: Arc<OrbitArc>, earth_velocity: Velocity<Gcrs>) -> Self {
        Self { path: Path::Flying(arc), earth_velocity, moving_s: (f64::NEG_INFINITY, f64::INFINITY) }
    }

    /// Returns the same motion, but at rest before `from_s` and after `to_s`.
    pub fn still_outside(&self, from_s: f64, to_s: f64) -> Self {
        Self { moving_s: (from_s, to_s), ..self.clone() }
    }

    fn own_time_s(&self, time_s: f64) -> f64 {
        time_s.max(self.moving_s.0).min(self.moving_s.1)
    }

    /// Returns the geocentric position of the observer at a time.
    pub fn position(&self, time_s: f64) -> Position<Gcrs> {
        let time_s = self.own_time_s(time_s);
        match &self.path {
            Path::Turning { at_s, fixed, turning, ahead } => {
                let (sin, cos) = (EARTH_ROTATION_RAD_S * (time_s - at_s)).sin_cos();
                Position::from_vector(fixed + turning * cos + ahead * sin)
            }
            Path::Flying(arc) => arc.state_at(time_s).position,
        }
    }

    /// Returns the velocity, km/s. While the observer is at rest, it is the velocity at the nearest time at which the
    /// observer moves.
    pub fn velocity(&self, time_s: f64) -> Vector3<f64> {
        let time_s = self.own_time_s(time_s);
        match &self.path {
            Path::Turning { at_s, turning, ahead, .. } => {
                let (sin, cos) = (EARTH_ROTATION_RAD_S * (time_s - at_s)).sin_cos();
                (ahead * cos - turning * sin) * EARTH_ROTATION_RAD_S
            }
            Path::Flying(arc) => *arc.state_at(time_s).velocity.vector(),
        }
    }

    /// Returns an upper bound of the mean speed between `mid_s` and any time within `half_s` of it, km/s.
    pub fn fastest_km_s(&self, mid_s: f64, half_s: f64) -> f64 {
        match &self.path {
            Path::Turning { ahead, .. } => ahead.norm() * EARTH_ROTATION_RAD_S,
            // |Δr| ≤ v t + ½ g t²
            Path::Flying(_) => self.velocity(mid_s).norm() + 0.5 * GRAVITY_KM_S2 * half_s,
        }
    }
}

/// Line of sight from an observer to a satellite on an arc of its orbit.
pub(in crate::passes) struct SightLine<'a> {
    pub arc: &'a OrbitArc,
    pub observer: ObserverMotion,
}

impl SightLine<'_> {
    /// Returns the state of the satellite, the position of the observer and the aspect at one time.
    pub fn aspect_at(&self, time_s: f64) -> (State<Gcrs>, Position<Gcrs>, Aspect) {
        self.delayed_aspect(time_s, 0.0)
    }

    /// Returns the values of [`SightLine::aspect_at`] for a satellite that is where it was predicted `late_s` earlier.
    pub fn delayed_aspect(&self, time_s: f64, late_s: f64) -> (State<Gcrs>, Position<Gcrs>, Aspect) {
        let state = self.arc.state_at(time_s - late_s);
        let observer = self.observer.position(time_s);
        let aspect = aspect(&state.position, &state.velocity, &observer, &self.observer.earth_velocity);
        (state, observer, aspect)
    }

    /// Returns the astrometric line of sight and its rate. The rate neglects the change of the light time (10⁻⁴ of the
    /// rate). This shifts no border or extremum by more than the tolerance of a root.
    pub fn sight(&self, time_s: f64) -> Sight {
        self.delayed_sight(time_s, 0.0)
    }

    /// Returns the line of sight of [`SightLine::sight`] for a satellite that is late by `late_s`.
    pub fn delayed_sight(&self, time_s: f64, late_s: f64) -> Sight {
        let (state, _, aspect) = self.delayed_aspect(time_s, late_s);
        let relative = state.velocity.vector() - self.observer.velocity(time_s);
        Sight { vector: *aspect.direction.vector(), rate_s: relative / aspect.range_km }
    }
}

/// Position and brightness of a satellite at one time, as seen by the observer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
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
    /// Height of the satellite above the WGS84 ellipsoid, km. The height in [`Self::geometry`] is the distance from the
    /// Earth's centre minus the equatorial radius.
    pub height_km: f64,
    /// Geometry of Sun, satellite and observer.
    pub geometry: ViewingGeometry,
    /// Illumination: sunlit, in penumbra with the fraction of sunlight that arrives, or in umbra.
    pub illumination: Illumination,
    /// Apparent magnitude, dimmed by the Earth's shadow, with its uncertainty and source. `None` in the umbra and if
    /// the model gives no light.
    pub brightness: Option<Brightness>,
}

/// Part of a track inside the field, from entry (or shutter opening) to exit (or shutter closing).
#[derive(Copy, Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Chord {
    /// Entry, seconds after the shutter opened.
    pub enter_s: f64,
    /// Exit, seconds after the shutter opened, not before `enter_s`.
    pub exit_s: f64,
}

/// Satellite that crosses the field during one exposure, or passes near it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pass {
    /// NORAD catalogue number.
    pub norad_id: NoradId,
    /// Index of its element set in the catalogue of the sky.
    pub element_index: usize,
    /// Parts of the track inside the field, in order of time. There may be several for mosaics and concave shapes, and
    /// none for a near miss.
    pub chords: Vec<Chord>,
    /// Parts of the chords in which the satellite is lit ([`Illumination::is_lit`]), to a millisecond; in the thermal
    /// bands W1 and W2 all parts.
    pub lit_chords: Vec<Chord>,
    /// Point at the start of the first chord; for a near miss, the closest point.
    pub enter: TrackPoint,
    /// Point midway in time between `enter` and `exit`; for a near miss, the closest point.
    pub mid: TrackPoint,
    /// Point at the end of the last chord; for a near miss, the closest point.
    pub exit: TrackPoint,
    /// Brightest point between `enter` and `exit`; `None` if the satellite is in the umbra or not visible in between,
    /// or if the options omit brightness.
    pub peak: Option<TrackPoint>,
    /// Smallest angle between the track and the centre of the field while the shutter is open, radians.
    pub min_separation_rad: f64,
    /// Length of the lit part of the track inside the field, radians: the sum over `lit_chords`.
    pub streak_length_rad: f64,
    /// Length of the whole track inside the field, lit or not, radians: the sum over `chords`.
    pub track_length_rad: f64,
    /// Position angle of the motion at `mid`, from north through east, [0, 2π), radians.
    pub position_angle_rad: f64,
    /// Angular speed at `mid`, rad/s.
    pub angular_rate_rad_s: f64,
    /// Source of the positions.
    pub position_source: PositionSource,
    /// Time from the epoch of the elements to `mid`, days; negative if the elements are newer.
    pub element_age_days: f64,
    /// Uncertainty (one sigma) of the position along the track as a time, seconds.
    pub along_track_sigma_s: f64,
    /// Uncertainty (one sigma) of the position across the track as an angle seen from the observer, radians.
    pub cross_track_sigma_rad: f64,
    /// Probability that the satellite is in the field at any time of the exposure, given these uncertainties.
    pub probability: f64,
    /// True if the satellite is lit at any time inside the field; for a near miss, at the closest point. Always true in
    /// the thermal bands W1 and W2, in which the illumination of the points states whether it is sunlit.
    pub lit: bool,
    /// Points along the track; empty if [`samples`](super::PassOptions::samples) is 0.
    pub samples: Vec<TrackPoint>,
}

impl Pass {
    /// Returns true if the nominal track enters the field.
    pub fn is_crossing(&self) -> bool {
        !self.chords.is_empty()
    }

    /// Probability of being brighter than an apparent magnitude at the brightest point; 0 if the satellite is not
    /// visible, and without brightness.
    pub fn probability_brighter_than(&self, limit_mag: f64) -> f64 {
        let brightness = self.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
        brightness.map_or(0.0, |brightness| brightness.probability_brighter_than(limit_mag))
    }

    /// Brightest apparent magnitude between entry and exit; NaN if the satellite is not visible.
    pub fn peak_magnitude(&self) -> f64 {
        let brightness = self.peak.as_ref().and_then(|peak| peak.brightness.as_ref());
        brightness.map_or(f64::NAN, |brightness| brightness.magnitude.0)
    }
}
