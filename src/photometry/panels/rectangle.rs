//! A rectangle in the body frame, and its shadow on the plane of another.

use nalgebra::Vector3;

use super::attitude::Axes;
use super::polygon::PanelPolygon;

/// A rectangle in the body frame: a point of its plane, its axes, and its extent along them, metres.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct PlacedRectangle {
    /// Position of u = v = 0, in the body frame.
    pub anchor_m: Vector3<f64>,
    /// Directions of the edges and of the normal.
    pub axes: Axes,
    /// Extent along u.
    pub u_m: [f64; 2],
    /// Extent along v.
    pub v_m: [f64; 2],
}

impl PlacedRectangle {
    /// Returns the area, m².
    pub fn area_m2(&self) -> f64 {
        (self.u_m[1] - self.u_m[0]) * (self.v_m[1] - self.v_m[0])
    }

    /// Returns the four corners in the body frame, in order.
    pub fn corners_m(&self) -> [Vector3<f64>; 4] {
        let [u0, u1] = self.u_m;
        let [v0, v1] = self.v_m;
        [(u0, v0), (u1, v0), (u1, v1), (u0, v1)].map(|(u, v)| self.anchor_m + self.axes.u * u + self.axes.v * v)
    }

    /// Returns the part of this rectangle from which another blocks light from or to `direction` (unit vector, away
    /// from the satellite), in u and v of this one; empty if nothing is blocked.
    ///
    /// Exact for flat rectangles: only the part of the other on the side of this plane to which `direction` points can
    /// block, and it is projected along `direction` onto the plane.
    pub fn stopped_by(&self, other: &Self, direction: &Vector3<f64>) -> PanelPolygon {
        let along = self.axes.normal.dot(direction);
        // Edge-on there is no light to block.
        if along.abs() < 1e-12 {
            return PanelPolygon::default();
        }
        let side = along.signum();
        // (height above this plane on the side of the direction, position)
        let heights: [(f64, Vector3<f64>); 4] = other.corners_m().map(|corner| {
            let from_anchor = corner - self.anchor_m;
            (side * self.axes.normal.dot(&from_anchor), from_anchor)
        });
        let mut shape = PanelPolygon::default();
        // Q = B - w (n·B)/(n·w): along the ray to the plane
        let mut project = |height: f64, position: Vector3<f64>| {
            let on_plane = position - direction * (height / along.abs());
            shape.push([on_plane.dot(&self.axes.u), on_plane.dot(&self.axes.v)]);
        };
        for (&(from_height, from), &(to_height, to)) in heights.iter().zip(heights.iter().cycle().skip(1)) {
            if from_height >= 0.0 {
                project(from_height, from);
            }
            if (from_height > 0.0 && to_height < 0.0) || (from_height < 0.0 && to_height > 0.0) {
                project(0.0, from + (to - from) * (from_height / (from_height - to_height)));
            }
        }
        shape.clipped_to_rectangle(self.u_m, self.v_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::panels::Attitude;

    /// A unit square in z = 0 facing up, and one of the same size above it.
    fn pair(height_m: f64) -> (PlacedRectangle, PlacedRectangle) {
        let axes = Attitude::Fixed { normal: Vector3::z(), v: Vector3::y() }.axes(&Vector3::x());
        let below = PlacedRectangle { anchor_m: Vector3::zeros(), axes, u_m: [0.0, 1.0], v_m: [0.0, 1.0] };
        (below, PlacedRectangle { anchor_m: Vector3::new(0.0, 0.0, height_m), ..below })
    }

    #[test]
    fn verif_a_square_above_another_casts_a_shifted_square() {
        let (below, above) = pair(0.5);
        // Light from 45° along x: the shadow moves by half a side, and half of it remains.
        let slant = Vector3::new(-1.0, 0.0, 1.0).normalize();
        assert!((below.stopped_by(&above, &slant).area_m2() - 0.5).abs() < 1e-15);
        assert!((below.stopped_by(&above, &Vector3::z()).area_m2() - 1.0).abs() < 1e-15);
        // From below it is behind; and the lower one hides the back of the upper one.
        assert_eq!(below.stopped_by(&above, &-Vector3::z()).area_m2(), 0.0);
        assert!((above.stopped_by(&below, &-Vector3::z()).area_m2() - 1.0).abs() < 1e-15);
        assert_eq!(below.stopped_by(&above, &Vector3::x()).area_m2(), 0.0);
    }
}
