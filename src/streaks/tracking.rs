//! Tracking: motion of the telescope while the shutter is open.

use nalgebra::Vector3;

use crate::frames::{Direction, Gcrs};

/// Stars or moving target that the telescope follows during the exposure.
#[derive(Copy, Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Tracking {
    /// The telescope follows the stars.
    #[default]
    Sidereal,
    /// The telescope follows a target that moves relative to the stars at a constant rate, such as an asteroid or a
    /// satellite.
    Rate {
        /// Rate towards the east on the sky (including the cosine of the declination), rad/s.
        east_rad_s: f64,
        /// Rate towards the north, rad/s.
        north_rad_s: f64,
        /// Time at which the frame's WCS is valid, seconds after the shutter opened.
        reference_s: f64,
    },
}

impl Tracking {
    /// Returns the direction that the frame's WCS gives to the pixel in which an object in `direction` appears at a
    /// time.
    ///
    /// The frame moves along a great circle through its `centre`, at the tracking rate. Times are seconds after the
    /// shutter opened.
    pub fn seen(&self, direction: &Direction<Gcrs>, time_s: f64, centre: &Direction<Gcrs>) -> Direction<Gcrs> {
        self.carried(direction, -1.0, time_s, centre)
    }

    /// Returns the direction relative to the stars of an object that appears, at a time, in the pixel to which the
    /// frame's WCS gives the direction `seen`. This is the inverse of [`seen`](Self::seen).
    pub fn on_sky(&self, seen: &Direction<Gcrs>, time_s: f64, centre: &Direction<Gcrs>) -> Direction<Gcrs> {
        self.carried(seen, 1.0, time_s, centre)
    }

    /// Returns the largest angle, radians, by which the frame moves from the position for which its WCS is valid,
    /// during an exposure of this length.
    pub fn reach_rad(&self, exposure_s: f64) -> f64 {
        match *self {
            Self::Sidereal => 0.0,
            Self::Rate { east_rad_s, north_rad_s, reference_s } => {
                east_rad_s.hypot(north_rad_s) * reference_s.abs().max((exposure_s - reference_s).abs())
            }
        }
    }

    /// Rotates a direction with the telescope (`sense` 1) or in the opposite sense (-1).
    fn carried(
        &self,
        direction: &Direction<Gcrs>,
        sense: f64,
        time_s: f64,
        centre: &Direction<Gcrs>,
    ) -> Direction<Gcrs> {
        let Self::Rate { east_rad_s, north_rad_s, reference_s } = *self else { return *direction };
        let (east, north) = centre.east_north();
        let motion = east * east_rad_s + north * north_rad_s;
        // The telescope turns by ω (t - t₀) around the axis c × v; directions relative to the frame turn by the
        // opposite angle.
        let Some(axis) = centre.vector().cross(&motion).try_normalize(0.0) else { return *direction };
        let angle_rad = sense * motion.norm() * (time_s - reference_s);
        Direction::from_vector(rotated(direction.vector(), &axis, angle_rad))
    }
}

/// Rotates a vector by Rodrigues' formula: v cos θ + (k × v) sin θ + k (k · v)(1 - cos θ).
fn rotated(vector: &Vector3<f64>, axis: &Vector3<f64>, angle_rad: f64) -> Vector3<f64> {
    let (sin, cos) = angle_rad.sin_cos();
    vector * cos + axis.cross(vector) * sin + axis * axis.dot(vector) * (1.0 - cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_a_tracked_target_is_stationary_in_the_frame() {
        let centre = Direction::from_lon_lat_rad(1.0, 0.5);
        let arcsec = (1.0f64 / 3600.0).to_radians();
        let tracking = Tracking::Rate { east_rad_s: 40.0 * arcsec, north_rad_s: -30.0 * arcsec, reference_s: 10.0 };
        let (east, north) = centre.east_north();
        for time_s in [0.0, 10.0, 25.0] {
            let moved = (time_s - 10.0) * arcsec;
            let there = centre.vector() + (east * 40.0 - north * 30.0) * moved;
            let seen = tracking.seen(&Direction::from_vector(there.normalize()), time_s, &centre);
            // The tangent is longer than the arc by a third of the angle cubed: 0.0033" at 750".
            assert!(tracking.on_sky(&seen, time_s, &centre).vector().angle(&there) < 1e-12);
            assert!(seen.separation_rad(&centre) < 5e-3 * arcsec, "{time_s}");
        }
        // A star moves in the opposite direction by 50"/s.
        let star = tracking.seen(&centre, 11.0, &centre);
        assert!((star.separation_rad(&centre) / arcsec - 50.0).abs() < 1e-6);
        assert!((star.position_angle_rad(&centre).to_degrees() - 126.8699).abs() < 1e-2);
        assert_eq!(Tracking::Sidereal.seen(&centre, 5.0, &star), centre);
    }
}
