//! Attitudes of panels: directions of the normal and of the edges as functions of the Sun's latitude.
//!
//! In the body frame z points to the zenith, and the Sun is in the half plane y = 0, x > 0 (Lu 2024, section 2.2).
//! Hence x points towards the Sun's azimuth. The axes of a panel are u and v in its plane and the normal n of its
//! front, right-handed. Attitudes that depend on the direction of flight cannot be expressed in this frame, because
//! brightness is here a function of Sun and observer only.

use nalgebra::Vector3;

/// Angle between a panel's normal and its nominal direction, as a function of the Sun's latitude.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelOffset {
    /// Constant offset, radians.
    Constant(f64),
    /// Pairs of the Sun's latitude and the offset, radians, in order of latitude. The offset is interpolated linearly
    /// and constant beyond the ends.
    Table(Vec<[f64; 2]>),
}

impl PanelOffset {
    /// Returns the offset for a latitude of the Sun, radians.
    pub fn at_rad(&self, sun_latitude_rad: f64) -> f64 {
        let table = match self {
            Self::Constant(offset_rad) => return *offset_rad,
            Self::Table(table) => table,
        };
        let after = table.partition_point(|[latitude_rad, _]| *latitude_rad <= sun_latitude_rad);
        match (after.checked_sub(1).and_then(|before| table.get(before)), table.get(after)) {
            (Some([from, low]), Some([to, high])) => low + (high - low) * (sun_latitude_rad - from) / (to - from),
            (Some([_, last]), None) => *last,
            (None, Some([_, first])) => *first,
            (None, None) => 0.0,
        }
    }
}

/// Rule that determines the attitude of a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Attitude {
    /// The front faces straight down, and v points towards the Sun's azimuth.
    Nadir,
    /// The normal is in the half plane of the Sun, at this angle above the chassis plane: n = (cos POA, 0, sin POA). At
    /// 0 the panel is upright and follows the Sun only in azimuth, like the sail of Lu (2024).
    SunAzimuth(PanelOffset),
    /// The normal is in the half plane of the Sun, at this angle above the Sun. At 0 the panel faces the Sun.
    SunTracking(PanelOffset),
    /// The axes are fixed in the body frame; both are unit vectors, perpendicular to one another.
    Fixed {
        /// Normal of the front.
        normal: Vector3<f64>,
        /// Direction of the edge v.
        v: Vector3<f64>,
    },
}

/// Axes of a panel in the body frame, right-handed: u × v = n.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct Axes {
    /// Direction of the first edge.
    pub u: Vector3<f64>,
    /// Direction of the second edge.
    pub v: Vector3<f64>,
    /// Normal of the front.
    pub normal: Vector3<f64>,
}

impl Attitude {
    /// Returns the axes for a direction of the Sun (unit vector in the body frame with y = 0).
    pub fn axes(&self, to_sun: &Vector3<f64>) -> Axes {
        let sun_latitude_rad = to_sun.z.atan2(to_sun.x);
        let leaning = |elevation_rad: f64| {
            // n = (cos POA, 0, sin POA), v = (-sin POA, 0, cos POA)        Lu (2024), section 2.1
            let (sin, cos) = elevation_rad.sin_cos();
            Axes { u: Vector3::y(), v: Vector3::new(-sin, 0.0, cos), normal: Vector3::new(cos, 0.0, sin) }
        };
        match self {
            Self::Nadir => Axes { u: Vector3::y(), v: Vector3::x(), normal: -Vector3::z() },
            Self::SunAzimuth(offset) => leaning(offset.at_rad(sun_latitude_rad)),
            Self::SunTracking(offset) => leaning(sun_latitude_rad + offset.at_rad(sun_latitude_rad)),
            Self::Fixed { normal, v } => Axes { u: v.cross(normal), v: *v, normal: *normal },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_axes_are_right_handed_with_the_expected_directions() {
        let to_sun = Vector3::new(0.9_f64.cos(), 0.0, -(0.9_f64.sin()));
        let fixed = Attitude::Fixed { normal: Vector3::new(0.0, 0.6, 0.8), v: Vector3::x() };
        let all = [
            Attitude::Nadir,
            Attitude::SunAzimuth(PanelOffset::Constant(0.3)),
            Attitude::SunTracking(PanelOffset::Constant(0.0)),
            fixed,
        ];
        for attitude in &all {
            let axes = attitude.axes(&to_sun);
            assert!((axes.u.cross(&axes.v) - axes.normal).norm() < 1e-15, "{attitude:?}");
            assert!((axes.u.norm() - 1.0).abs() < 1e-15 && (axes.v.norm() - 1.0).abs() < 1e-15);
        }
        assert!((all[2].axes(&to_sun).normal - to_sun).norm() < 1e-15);
        assert!((all[1].axes(&to_sun).normal.z - 0.3_f64.sin()).abs() < 1e-15);
    }

    #[test]
    fn verif_offsets_between_and_beyond_the_rows_of_a_table() {
        let offset = PanelOffset::Table(vec![[-0.4, 0.0], [-0.2, 0.1], [0.0, -0.1]]);
        for (latitude, expected) in [(-1.0, 0.0), (-0.4, 0.0), (-0.3, 0.05), (-0.2, 0.1), (-0.1, 0.0), (0.5, -0.1)] {
            assert!((offset.at_rad(latitude) - expected).abs() < 1e-15, "{latitude}");
        }
    }
}
