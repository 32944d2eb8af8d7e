//! The phase test: where the interpolated elements put a satellite, and whether that is near the line of sight.

use nalgebra::Vector3;

use super::beam::Beam;
use super::kepler::{plane_axis, plane_state};
use super::shade::ShadeInTeme;
use super::side::Cap;
use super::window::Cone;
use crate::constants::WGS72_MU_KM3_S2;

/// Slow elements of one satellite over the window.
#[derive(Copy, Clone, Debug)]
pub(super) struct Phase {
    pub element_index: u32,
    pub reference: [f32; 3],
    pub mean_longitude_rad: f64,
    pub mean_longitude_rate_rad_s: f64,
    pub eccentricity: [f32; 2],
    pub eccentricity_change: [f32; 2],
    pub semi_major_axis_km: f32,
    pub semi_major_axis_change_km: f32,
    pub slop_km: f32,
    pub along_track_s: f32,
    /// How far the true longitude may be from the mean one.
    pub swing_rad: f32,
    /// Drag or an extreme eccentricity makes the interpolated place too poor: SGP4 decides once the plane fits.
    pub only_plane: bool,
}

/// A satellite that may be inside a cone.
#[derive(Copy, Clone, Debug)]
pub(super) struct Inside {
    /// From when to when that may be where it is not late, seconds from the middle of the time asked for.
    pub near_s: [f64; 2],
    /// True where it is in the shade all the time.
    pub is_dark: bool,
}

/// What the phase test knows of the question.
pub(super) struct Question<'a> {
    cone: &'a Cone,
    observer: Vector3<f64>,
    beam: Beam,
    fraction: f64,
    moved_km: f64,
}

impl<'a> Question<'a> {
    pub fn new(cone: &'a Cone, observer: Vector3<f64>, axis: Vector3<f64>, fraction: f64, moved_km: f64) -> Self {
        Self { cone, observer, beam: Beam::new(axis, cone.radius_rad), fraction, moved_km }
    }

    pub fn observer(&self) -> &Vector3<f64> {
        &self.observer
    }

    pub fn axis(&self) -> &Vector3<f64> {
        self.beam.axis()
    }

    /// Where in the window, from 0 to 1.
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// From when to when it is asked, seconds after the window's start.
    pub fn asked_s(&self) -> [f64; 2] {
        [self.cone.mid_s - self.cone.half_duration_s, self.cone.mid_s + self.cone.half_duration_s]
    }

    /// How far the observer moves from the middle on.
    pub fn moved_km(&self) -> f64 {
        self.moved_km
    }

    pub fn radius_rad(&self) -> f64 {
        self.beam.radius_rad()
    }

    /// Where, seen from the Earth's centre, the cone runs through orbits no lower than `lowest_km`, between two distances from the observer; `None` where
    /// that is too wide a place to look for anybody there.
    pub fn cap(&self, distances_km: [f64; 2], lowest_km: f64) -> Option<Cap> {
        Cap::of(&self.observer, self.axis(), self.radius_rad(), distances_km, lowest_km)
    }

    /// Whether a satellite whose orbit plane fits may be over the cap while it is asked for.
    #[inline]
    pub fn may_be_over(&self, cap: &Cap, phase: &Phase, normal: &Vector3<f64>) -> bool {
        let half_s = self.cone.half_duration_s + f64::from(phase.along_track_s);
        phase.only_plane
            || cap.may_hold(phase, normal, self.cone.mid_s, half_s, f64::from(phase.slop_km) + self.moved_km)
    }

    /// How a satellite whose orbit plane fits may be inside the cone while it is asked for; `None` where it cannot be.
    #[inline]
    pub fn place_inside(&self, phase: &Phase, normal: &Vector3<f64>, shade: Option<&ShadeInTeme>) -> Option<Inside> {
        let open_s = self.cone.half_duration_s;
        if phase.only_plane {
            return Some(Inside { near_s: [-open_s, open_s], is_dark: false });
        }
        let (position, velocity) = phase.place(normal, self.cone.mid_s, self.fraction);
        let sight = position - self.observer;
        let half_s = open_s + f64::from(phase.along_track_s);
        // The path bends away from its tangent by at most ½ g t², g being gravity at the satellite.
        let bend_km = 0.5 * WGS72_MU_KM3_S2 / position.norm_squared() * half_s * half_s;
        let slop_km = f64::from(phase.slop_km) + bend_km + self.moved_km;
        let near_s = self.beam.near_s(&sight, &velocity, half_s, slop_km)?;
        // Where the elements put it, however late it is looked for.
        let ends = [-open_s, open_s].map(|time_s| position + velocity * time_s);
        let is_dark = shade.is_some_and(|shade| ends.iter().all(|end| shade.holds(end, slop_km)));
        Some(Inside { near_s: near_s.map(|time_s| time_s.clamp(-open_s, open_s)), is_dark })
    }
}

impl Phase {
    /// Interpolated position and velocity in TEME, km and km/s. The reference turns with the plane by a degree or two, and is
    /// not made a unit vector again for that.
    pub fn place(&self, normal: &Vector3<f64>, time_s: f64, fraction: f64) -> (Vector3<f64>, Vector3<f64>) {
        let [rx, ry, rz] = self.reference;
        let x_axis = plane_axis(&Vector3::new(f64::from(rx), f64::from(ry), f64::from(rz)), normal);
        let y_axis = normal.cross(&x_axis);
        let eccentricity = [0, 1]
            .map(|axis| f64::from(self.eccentricity[axis]) + fraction * f64::from(self.eccentricity_change[axis]));
        let semi_major_axis_km =
            f64::from(self.semi_major_axis_km) + fraction * f64::from(self.semi_major_axis_change_km);
        let longitude_rad = self.mean_longitude_rad + self.mean_longitude_rate_rad_s * time_s;
        let ([x, y], [u, v]) = plane_state(longitude_rad, eccentricity, semi_major_axis_km);
        (x_axis * x + y_axis * y, x_axis * u + y_axis * v)
    }
}
