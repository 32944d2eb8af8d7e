//! A search cone in space and time, and the phase test of one satellite against it.

use nalgebra::Vector3;

use super::beam::Beam;
use super::phase::Phase;
use super::shadow_cone::{ShadowCone, ShadowConeInTeme};
use super::side::Cap;
use crate::constants::WGS72_MU_KM3_S2;
use crate::frames::{Direction, Gcrs, Position, Rotation, Teme};

/// Margin of the interval in which a satellite may be inside, seconds.
const NEAR_MARGIN_S: f64 = 0.5;

/// A field of view in time and space.
#[derive(Copy, Clone, Debug)]
pub struct Cone {
    /// Middle of the time interval, seconds after the window's start.
    pub mid_s: f64,
    /// Half its length, seconds; a minute or less keeps the margins small.
    pub half_duration_s: f64,
    /// The observer at that time, km.
    pub observer: Position<Gcrs>,
    /// Largest speed of the observer, km/s.
    pub observer_speed_km_s: f64,
    /// Axis of the cone.
    pub axis: Direction<Gcrs>,
    /// Half its opening, radians, with a margin for aberration and light time (2e-4 is enough).
    pub radius_rad: f64,
}

/// A cone that is tested as a whole before its parts.
#[derive(Copy, Clone, Debug)]
pub struct Cones<'a> {
    /// A cone that holds all parts over all of their time.
    pub whole: &'a Cone,
    /// The parts; empty where only the whole is searched.
    pub parts: &'a [Cone],
    /// Number of the first part (of the whole where there are no parts).
    pub first: u32,
    /// Region in which no satellite is lit; `None` where dark satellites are searched too.
    pub shadow: Option<&'a ShadowCone>,
}

/// How a satellite may be inside a cone.
#[derive(Copy, Clone, Debug)]
pub(super) struct Inside {
    /// Interval of its predicted position inside the cone, seconds from the middle of the cone's time.
    pub near_s: [f64; 2],
    /// True where it is in the shadow all the time.
    pub is_dark: bool,
}

/// A cone in TEME.
pub(super) struct ConeTest<'a> {
    cone: &'a Cone,
    observer: Vector3<f64>,
    beam: Beam,
    fraction: f64,
    moved_km: f64,
}

impl<'a> ConeTest<'a> {
    /// For a window of this length.
    pub fn new(cone: &'a Cone, teme_to_gcrs: &Rotation<Teme, Gcrs>, window_span_s: f64) -> Self {
        let gcrs_to_teme = teme_to_gcrs.inverse();
        Self {
            cone,
            observer: *(gcrs_to_teme * cone.observer).vector(),
            beam: Beam::new(*(gcrs_to_teme * cone.axis).vector(), cone.radius_rad),
            fraction: cone.mid_s / window_span_s,
            moved_km: cone.observer_speed_km_s * cone.half_duration_s,
        }
    }

    pub fn observer(&self) -> &Vector3<f64> {
        &self.observer
    }

    pub fn axis(&self) -> &Vector3<f64> {
        self.beam.axis()
    }

    /// Position in the window, from 0 to 1.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// Its time interval, seconds after the window's start.
    pub fn interval_s(&self) -> [f64; 2] {
        [self.cone.mid_s - self.cone.half_duration_s, self.cone.mid_s + self.cone.half_duration_s]
    }

    /// How far the observer moves from the middle on.
    pub fn moved_km(&self) -> f64 {
        self.moved_km
    }

    pub fn radius_rad(&self) -> f64 {
        self.beam.radius_rad()
    }

    /// The cap, seen from the Earth's centre, of the cone's part in orbits no lower than `lowest_km`, between two
    /// distances from the observer; `None` where it may be the whole Earth.
    pub fn cap(&self, distances_km: [f64; 2], lowest_km: f64) -> Option<Cap> {
        Cap::of(&self.observer, self.axis(), self.radius_rad(), distances_km, lowest_km)
    }

    /// Side test: whether a satellite whose orbit plane fits may be over the cap during the interval.
    #[inline]
    pub fn may_be_over(&self, cap: &Cap, phase: &Phase, normal: &Vector3<f64>) -> bool {
        let half_s = self.cone.half_duration_s + f64::from(phase.along_track_s);
        phase.only_plane
            || cap.may_hold(phase, normal, self.cone.mid_s, half_s, f64::from(phase.slop_km) + self.moved_km)
    }

    /// Phase test: how a satellite whose orbit plane fits may be inside the cone during the interval; `None` where it
    /// cannot be.
    #[inline]
    pub fn inside(&self, phase: &Phase, normal: &Vector3<f64>, shadow: Option<&ShadowConeInTeme>) -> Option<Inside> {
        let half_s = self.cone.half_duration_s + f64::from(phase.along_track_s);
        if phase.only_plane {
            return Some(Inside { near_s: [-half_s, half_s], is_dark: false });
        }
        let (position, velocity) = phase.state(normal, self.cone.mid_s, self.fraction);
        let sight = position - self.observer;
        // The path leaves its tangent by at most ½ g t², g being gravity at the satellite.
        let bend_km = 0.5 * WGS72_MU_KM3_S2 / position.norm_squared() * half_s * half_s;
        let slop_km = f64::from(phase.slop_km) + bend_km + self.moved_km;
        let near_s = self.beam.near_s(&sight, &velocity, half_s, slop_km)?;
        // All positions that a delay can bring into the cone.
        let ends = [-half_s, half_s].map(|time_s| position + velocity * time_s);
        let is_dark = shadow.is_some_and(|shadow| ends.iter().all(|end| shadow.holds(end, slop_km)));
        let [from_s, to_s] = near_s;
        let near_s = [from_s - NEAR_MARGIN_S, to_s + NEAR_MARGIN_S].map(|time_s| time_s.clamp(-half_s, half_s));
        Some(Inside { near_s, is_dark })
    }
}
