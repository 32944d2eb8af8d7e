//! Interpolated slow elements of one satellite over a window, and its position from them.

use nalgebra::Vector3;

use super::kepler::{plane_axis, plane_state};

/// Slow elements of one satellite over a window.
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
    /// Largest error of the interpolated position, with the search distance across the track, km.
    pub slop_km: f32,
    /// Largest delay searched, seconds.
    pub along_track_s: f32,
    /// Largest difference between true and mean longitude.
    pub swing_rad: f32,
    /// True where drag or an extreme eccentricity makes the interpolated position too inaccurate: SGP4 is evaluated
    /// whenever the plane passes.
    pub only_plane: bool,
}

impl Phase {
    /// Returns the interpolated position and velocity in TEME, km and km/s. The reference turns with the plane by a
    /// degree or two and is not normalised again.
    pub fn state(&self, normal: &Vector3<f64>, time_s: f64, fraction: f64) -> (Vector3<f64>, Vector3<f64>) {
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
