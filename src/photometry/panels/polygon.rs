//! Small convex polygons in the plane of a panel, in fixed arrays: its hidden and shaded parts.

/// Capacity: the intersection of eight quadrilaterals, each cut by a plane and by the panel, has no more corners.
const MAX_CORNERS: usize = 48;

/// A convex polygon of at most 48 corners in the plane of a panel (u and v along its edges), metres.
#[derive(Copy, Clone, Debug)]
pub struct PanelPolygon {
    corners: [[f64; 2]; MAX_CORNERS],
    len: usize,
}

impl Default for PanelPolygon {
    fn default() -> Self {
        Self { corners: [[0.0; 2]; MAX_CORNERS], len: 0 }
    }
}

impl PanelPolygon {
    /// Creates a polygon from corners in order; those beyond the capacity are dropped.
    pub fn new(corners: &[[f64; 2]]) -> Self {
        let mut polygon = Self::default();
        corners.iter().for_each(|&corner| polygon.push(corner));
        polygon
    }

    /// Returns the corners in order; empty for an empty polygon.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }

    /// Returns the enclosed area, m².
    pub fn area_m2(&self) -> f64 {
        self.signed_area_m2().abs()
    }

    /// Returns the part within `u[0]` ≤ u ≤ `u[1]` and `v[0]` ≤ v ≤ `v[1]` (Sutherland and Hodgman 1974).
    pub fn clipped_to_rectangle(&self, u: [f64; 2], v: [f64; 2]) -> Self {
        self.clipped(|p| p[0] - u[0]).clipped(|p| u[1] - p[0]).clipped(|p| p[1] - v[0]).clipped(|p| v[1] - p[1])
    }

    /// Returns the intersection with another convex polygon.
    pub fn clipped_to(&self, other: &Self) -> Self {
        let turn = other.signed_area_m2().signum();
        let corners = other.corners();
        if corners.len() < 3 {
            return Self::default();
        }
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        edges.fold(*self, |kept, (a, b)| {
            // Left of each edge, for anticlockwise corners.
            kept.clipped(|p| turn * ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])))
        })
    }

    /// Adds a corner; cutting a convex polygon by a line adds at most one, so the capacity suffices.
    pub fn push(&mut self, corner: [f64; 2]) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    fn signed_area_m2(&self) -> f64 {
        let corners = self.corners();
        // Shoelace formula.
        let doubled: f64 =
            corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        0.5 * doubled
    }

    /// Returns the part where a linear function is not negative.
    fn clipped(&self, inside: impl Fn([f64; 2]) -> f64) -> Self {
        let mut kept = Self::default();
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
}

/// Largest number of panels that may block one panel; each casts a shadow and hides a part.
pub const MOST_BLOCKERS: usize = 4;

/// Returns the area of the union of convex shapes, m²: |A ∪ B ∪ …| = Σ|A| - Σ|A ∩ B| + …; empty intersections are
/// skipped early.
pub fn union_area_m2(shapes: &[PanelPolygon]) -> f64 {
    signed(shapes, None)
}

/// Returns Σ over non-empty subsets, with alternating sign, of the area common to the subset and `within`.
fn signed(shapes: &[PanelPolygon], within: Option<&PanelPolygon>) -> f64 {
    let mut sum = 0.0;
    for (index, shape) in shapes.iter().enumerate() {
        let shared = within.map_or(*shape, |within| within.clipped_to(shape));
        let area_m2 = shared.area_m2();
        if area_m2 > 0.0 {
            sum += area_m2 - signed(&shapes[index + 1..], Some(&shared));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_triangle_cut_by_a_square() {
        // The triangle (0,0) (2,0) (0,2) within the unit square is the whole square; within (0..1, 0..0.5) half of it.
        let triangle = PanelPolygon::new(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]);
        let cut = |u, v| triangle.clipped_to_rectangle(u, v);
        assert!((triangle.area_m2() - 2.0).abs() < 1e-15);
        assert!((cut([0.0, 1.0], [0.0, 1.0]).area_m2() - 1.0).abs() < 1e-15);
        assert!((cut([1.0, 3.0], [0.0, 3.0]).area_m2() - 0.5).abs() < 1e-15);
        let gone = cut([5.0, 6.0], [0.0, 1.0]);
        assert!(gone.corners().is_empty() && gone.area_m2() == 0.0);
    }

    #[test]
    fn verif_triangles_cut_by_one_another() {
        let one = PanelPolygon::new(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]);
        // The same triangle rotated by half a turn about (0.5, 0.5), in reverse order: they share a hexagon.
        let other = PanelPolygon::new(&[[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]]);
        let shared = one.clipped_to(&other);
        assert!((shared.area_m2() - other.clipped_to(&one).area_m2()).abs() < 1e-15);
        // 0 ≤ u ≤ 1, 0 ≤ v ≤ 1, u + v ≥ 0, u + v ≤ 2: the unit square.
        assert!((shared.area_m2() - 1.0).abs() < 1e-15);
        assert_eq!(one.clipped_to(&PanelPolygon::default()).area_m2(), 0.0);
    }

    #[test]
    fn verif_union_of_three_overlapping_squares() {
        let square = |x: f64, y: f64| {
            let mut shape = PanelPolygon::default();
            [[x, y], [x + 2.0, y], [x + 2.0, y + 2.0], [x, y + 2.0]].into_iter().for_each(|corner| shape.push(corner));
            shape
        };
        let squares = [square(0.0, 0.0), square(1.0, 1.0), square(1.0, 0.0)];
        // On unit cells: 4 + 4 + 4 less 1 (first two) less 2 (first, third) less 2 (second, third) plus 1.
        assert!((union_area_m2(&squares) - 8.0).abs() < 1e-14, "{}", union_area_m2(&squares));
        assert_eq!(union_area_m2(&[]), 0.0);
        assert!((union_area_m2(&[square(0.0, 0.0), square(5.0, 5.0)]) - 8.0).abs() < 1e-14);
        // Corners in either order.
        let mut turned = PanelPolygon::default();
        [[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]].into_iter().for_each(|corner| turned.push(corner));
        assert!((union_area_m2(&[turned, square(1.0, 1.0)]) - 7.0).abs() < 1e-14);
    }
}
