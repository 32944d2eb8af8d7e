//! Small convex polygons on the sail, in fixed arrays: outlines to draw, and areas to check against.

/// Corners that a quadrilateral can have after a cut by four edges.
const MAX_CORNERS: usize = 12;

/// A convex polygon of at most twelve corners in the plane of the sail (u along the hinge, v up the sail), metres.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct SailPolygon {
    corners: [[f64; 2]; MAX_CORNERS],
    len: usize,
}

impl SailPolygon {
    /// From up to eight corners in order (each of four cuts may add one); those beyond are dropped.
    pub fn new(corners: &[[f64; 2]]) -> Self {
        let mut polygon = Self { corners: [[0.0; 2]; MAX_CORNERS], len: 0 };
        corners.iter().take(MAX_CORNERS - 4).for_each(|&corner| polygon.push(corner));
        polygon
    }

    /// The corners in order; empty where nothing is left.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }

    /// Enclosed area, m².
    pub fn area_m2(&self) -> f64 {
        let corners = self.corners();
        // Shoelace.
        let doubled: f64 =
            corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        0.5 * doubled.abs()
    }

    /// What lies within u_min ≤ u ≤ u_max and v_min ≤ v ≤ v_max (Sutherland and Hodgman 1974).
    pub fn clipped_to_rectangle(&self, u_min: f64, u_max: f64, v_min: f64, v_max: f64) -> Self {
        self.clipped(|p| p[0] - u_min).clipped(|p| u_max - p[0]).clipped(|p| p[1] - v_min).clipped(|p| v_max - p[1])
    }

    /// The part where a linear function is not negative.
    fn clipped(&self, inside: impl Fn([f64; 2]) -> f64) -> Self {
        let mut kept = Self { corners: [[0.0; 2]; MAX_CORNERS], len: 0 };
        let corners = self.corners();
        for (&a, &b) in corners.iter().zip(corners.iter().cycle().skip(1)) {
            let (from, to) = (inside(a), inside(b));
            if from >= 0.0 {
                kept.push(a);
            }
            if (from >= 0.0) != (to >= 0.0) {
                let t = from / (from - to);
                kept.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            }
        }
        kept
    }

    /// Adds a corner; a cut of a convex polygon never exceeds the room.
    fn push(&mut self, corner: [f64; 2]) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_triangle_cut_by_a_square() {
        // The triangle (0,0) (2,0) (0,2) within the unit square is the whole square; within (0..1, 0..0.5) a half of
        // it.
        let triangle = SailPolygon::new(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]);
        assert!((triangle.area_m2() - 2.0).abs() < 1e-15);
        assert!((triangle.clipped_to_rectangle(0.0, 1.0, 0.0, 1.0).area_m2() - 1.0).abs() < 1e-15);
        assert!((triangle.clipped_to_rectangle(1.0, 3.0, 0.0, 3.0).area_m2() - 0.5).abs() < 1e-15);
        let gone = triangle.clipped_to_rectangle(5.0, 6.0, 0.0, 1.0);
        assert!(gone.corners().is_empty() && gone.area_m2() == 0.0);
    }
}
