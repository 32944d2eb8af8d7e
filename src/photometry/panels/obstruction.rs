//! How much of a panel is lost to light: the exact area of overlapping shadows and views.

use crate::photometry::polygon::PanelPolygon;

/// Panels that may stand in the way of one panel; each throws a shadow and hides a part.
pub const MOST_BLOCKERS: usize = 4;

/// Area of the union of convex shapes, m²: |A ∪ B ∪ …| = Σ|A| - Σ|A ∩ B| + …, with empty intersections left out early.
pub fn union_area_m2(shapes: &[PanelPolygon]) -> f64 {
    signed(shapes, None)
}

/// Σ over non-empty subsets, of alternating sign, of the area that all of the subset and `within` share.
fn signed(shapes: &[PanelPolygon], within: Option<&PanelPolygon>) -> f64 {
    let mut sum = 0.0;
    for (place, shape) in shapes.iter().enumerate() {
        let shared = within.map_or(*shape, |within| within.clipped_to(shape));
        let area_m2 = shared.area_m2();
        if area_m2 > 0.0 {
            sum += area_m2 - signed(&shapes[place + 1..], Some(&shared));
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

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
        // Whatever the sense in which corners run.
        let mut turned = PanelPolygon::default();
        [[0.0, 0.0], [0.0, 2.0], [2.0, 2.0], [2.0, 0.0]].into_iter().for_each(|corner| turned.push(corner));
        assert!((union_area_m2(&[turned, square(1.0, 1.0)]) - 7.0).abs() < 1e-14);
    }
}
