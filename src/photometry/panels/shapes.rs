//! Shapes of the parts of a satellite: polygons, rectangles and spheres. Spheres represent parts without an
//! orientation. They are never shaded or hidden, cast no shadow, and receive no earthshine.

use std::f64::consts::PI;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::attitude::Axes;
use crate::math::convex::clip;
use crate::photometry::phase::lambert_sphere;

/// Largest number of corners. The intersection of eight quadrilaterals, each cut by a plane and by the panel, has at
/// most this many.
const MAX_CORNERS: usize = 48;

/// Convex polygon of at most 48 corners in the plane of a panel, in metres; u and v are along the edges of the panel.
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
    /// Creates a polygon from corners in order; corners beyond the capacity are dropped.
    pub fn new(corners: &[[f64; 2]]) -> Self {
        let mut polygon = Self::default();
        corners.iter().for_each(|&corner| polygon.push(corner));
        polygon
    }

    /// Returns the corners in order; none for an empty polygon.
    pub fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }

    /// Returns the enclosed area, m².
    pub fn area_m2(&self) -> f64 {
        self.signed_area_m2().abs()
    }

    /// Returns the part of the polygon with `u[0]` ≤ u ≤ `u[1]` and `v[0]` ≤ v ≤ `v[1]` (Sutherland and Hodgman 1974).
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
            // For anticlockwise corners, the part to the left of each edge is kept.
            kept.clipped(|p| turn * ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])))
        })
    }

    /// Adds a corner. Cutting a convex polygon by a line adds at most one corner, so that the capacity suffices.
    pub fn push(&mut self, corner: [f64; 2]) {
        if let Some(slot) = self.corners.get_mut(self.len) {
            *slot = corner;
            self.len += 1;
        }
    }

    fn signed_area_m2(&self) -> f64 {
        let corners = self.corners();
        // Area by the shoelace formula.
        let doubled: f64 =
            corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        0.5 * doubled
    }

    /// Returns the part of the polygon where a linear function is not negative.
    fn clipped(&self, inside: impl Fn([f64; 2]) -> f64) -> Self {
        let mut kept = Self::default();
        clip(self.corners(), inside, |corner| kept.push(corner));
        kept
    }
}

/// Largest number of panels that may block one panel. Each of them may shade a part and hide a part.
pub const MOST_BLOCKERS: usize = 4;

/// Returns the area of the union of convex shapes, m²: |A ∪ B ∪ …| = Σ|A| - Σ|A ∩ B| + …. Empty intersections are
/// skipped early.
pub fn union_area_m2(shapes: &[PanelPolygon]) -> f64 {
    signed(shapes, None)
}

/// Returns the sum, over non-empty subsets and with alternating sign, of the area that the shapes of the subset and
/// `within` share.
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

/// Rectangle in the body frame, given by a point in its plane, its axes, and its extent along them, in metres.
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

    /// Returns the part of this rectangle for which another rectangle blocks light from or to `direction` (a unit
    /// vector that points away from the satellite). The corners are in u and v of this rectangle; the polygon is empty
    /// if nothing is blocked.
    ///
    /// The result is exact for flat rectangles. Only the part of the other rectangle on that side of this plane to
    /// which `direction` points can block light; it is projected along `direction` onto this plane.
    pub fn blocked_by(&self, other: &Self, direction: &Vector3<f64>) -> PanelPolygon {
        let along = self.axes.normal.dot(direction);
        // A rectangle that is seen edge-on has no light that could be blocked.
        if along.abs() < 1e-12 {
            return PanelPolygon::default();
        }
        let side = along.signum();
        // Each corner with its height above this plane, measured on the side of `direction`.
        let heights: [(f64, Vector3<f64>); 4] = other.corners_m().map(|corner| {
            let from_anchor = corner - self.anchor_m;
            (side * self.axes.normal.dot(&from_anchor), from_anchor)
        });
        let mut shape = PanelPolygon::default();
        // Q = B - w (n·B)/(n·w), the point where the ray through B meets the plane
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

/// Dependence of the light of a sphere on the phase angle.
#[derive(Copy, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SpherePhase {
    /// A sphere that reflects by Lambert's law.
    Lambert,
    /// Equal light in every direction.
    Isotropic,
}

/// A sphere, or several parts that together reflect like one.
#[derive(Clone, Debug, PartialEq)]
pub struct Sphere {
    /// Name in the model file.
    pub name: String,
    /// Cross-section, m².
    pub area_m2: f64,
    /// Fraction of the incident power that is reflected in all directions together.
    pub albedo: f64,
    /// Dependence of the light on the phase angle.
    pub phase: SpherePhase,
}

impl Sphere {
    /// Returns the reflected sunlight at a phase angle in [0, π], m² sr⁻¹.
    pub fn m2_sr(&self, phase_angle_rad: f64) -> f64 {
        let per_m2 = match self.phase {
            // 2/3, the geometric albedo of a white Lambertian sphere, and its phase function, 1 at full phase:
            // B = c A/π · 2/3 · (sin φ + (π - φ) cos φ)/π               Russell (1916), ApJ 43, 173
            SpherePhase::Lambert => 2.0 / (3.0 * PI * PI) * lambert_sphere(phase_angle_rad).max(0.0),
            // B = c A/4π
            SpherePhase::Isotropic => 0.25 / PI,
        };
        self.albedo * self.area_m2 * per_m2
    }

    /// Returns the momentum of the reflected light towards the source, per unit of radiation pressure, m²: ∫ B cos φ
    /// dω.
    pub(super) fn reflected_momentum_m2(&self) -> f64 {
        let per_m2 = match self.phase {
            // 4/9 of a Lambertian sphere: the light of each element leaves with 2/3 of its momentum along the normal
            SpherePhase::Lambert => 4.0 / 9.0,
            SpherePhase::Isotropic => 0.0,
        };
        self.albedo * self.area_m2 * per_m2
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::photometry::brdf::{Brdf, Incidence, Lambert};
    use crate::photometry::panels::attitude::Attitude;
    use crate::photometry::{DiffuseSphere, StandardMagnitude};

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
        let triangle = PanelPolygon::new(&[[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]);
        // The same triangle rotated by half a turn about (0.5, 0.5), in reverse order: they share a square.
        let other = PanelPolygon::new(&[[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0]]);
        let shared = triangle.clipped_to(&other);
        assert!((shared.area_m2() - other.clipped_to(&triangle).area_m2()).abs() < 1e-15);
        // 0 ≤ u ≤ 1, 0 ≤ v ≤ 1, u + v ≥ 0, u + v ≤ 2: the unit square.
        assert!((shared.area_m2() - 1.0).abs() < 1e-15);
        assert_eq!(triangle.clipped_to(&PanelPolygon::default()).area_m2(), 0.0);
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
        assert!((below.blocked_by(&above, &slant).area_m2() - 0.5).abs() < 1e-15);
        assert!((below.blocked_by(&above, &Vector3::z()).area_m2() - 1.0).abs() < 1e-15);
        // Seen from below, the upper square blocks nothing of the lower one, which hides the back of the upper one.
        assert_eq!(below.blocked_by(&above, &-Vector3::z()).area_m2(), 0.0);
        assert!((above.blocked_by(&below, &-Vector3::z()).area_m2() - 1.0).abs() < 1e-15);
        assert_eq!(below.blocked_by(&above, &Vector3::x()).area_m2(), 0.0);
    }

    fn sphere(phase: SpherePhase) -> Sphere {
        Sphere { name: "clutter".to_owned(), area_m2: 2.5, albedo: 0.4, phase }
    }

    #[test]
    fn verif_all_directions_together_receive_the_albedo() {
        for phase in [SpherePhase::Lambert, SpherePhase::Isotropic] {
            let (sphere, n) = (sphere(phase), 20_000);
            // ∫ B 2π sin φ dφ = c A
            let sum: f64 = (0..n)
                .map(|i| {
                    let angle = (f64::from(i) + 0.5) * PI / f64::from(n);
                    sphere.m2_sr(angle) * 2.0 * PI * angle.sin() * PI / f64::from(n)
                })
                .sum();
            assert!((sum - 0.4 * 2.5).abs() < 1e-7, "{phase:?}: {sum}");
        }
    }

    #[test]
    fn verif_momentum_of_the_light_of_spheres() {
        for phase in [SpherePhase::Lambert, SpherePhase::Isotropic] {
            let (sphere, n) = (sphere(phase), 20_000);
            // ∫ B cos φ 2π sin φ dφ
            let sum: f64 = (0..n)
                .map(|i| {
                    let angle = (f64::from(i) + 0.5) * PI / f64::from(n);
                    sphere.m2_sr(angle) * PI * (2.0 * angle).sin() * PI / f64::from(n)
                })
                .sum();
            assert!((sum - sphere.reflected_momentum_m2()).abs() < 1e-7, "{phase:?}: {sum}");
        }
    }

    #[test]
    fn verif_lambert_sphere_is_a_ball_of_lambertian_plates() {
        let (sphere, n) = (sphere(SpherePhase::Lambert), 400);
        let law = Lambert { albedo: 0.4 };
        let to_sun = Vector3::z();
        for angle in [0.0_f64, 0.6, 1.5, 2.6] {
            let to_observer = Vector3::new(angle.sin(), 0.0, angle.cos());
            let mut sum = 0.0;
            for i in 0..n {
                let cos: f64 = (f64::from(i) + 0.5) / f64::from(n);
                let sin = (1.0 - cos * cos).sqrt();
                for j in 0..2 * n {
                    let psi = (f64::from(j) + 0.5) * PI / f64::from(n);
                    let normal = Vector3::new(sin * psi.cos(), sin * psi.sin(), cos);
                    let incidence = Incidence::new(&normal, &to_sun, &to_observer);
                    // R² = A/π; the lit half in cells of equal size
                    let cell_m2 = 2.5 / PI * PI / f64::from(n * n);
                    sum += law.value_per_sr(&incidence) * incidence.front() * cell_m2;
                }
            }
            // The error is that of cells of 1/400 at the terminator.
            assert!((sum - sphere.m2_sr(angle)).abs() < 1e-5, "{angle}: {sum} {}", sphere.m2_sr(angle));
        }
    }

    #[test]
    fn verif_lambert_sphere_equals_the_sphere_of_standard_magnitudes() {
        let sphere = sphere(SpherePhase::Lambert);
        let magnitude = |angle: f64| StandardMagnitude::from_reflection(sphere.m2_sr(angle), -26.76).map(|it| it.0);
        let known = DiffuseSphere { half_lit: StandardMagnitude(magnitude(PI / 2.0).unwrap()) };
        for degrees in 0..180 {
            let angle = f64::from(degrees).to_radians();
            let expected = known.standard_magnitude(angle).unwrap().0;
            assert!((magnitude(angle).unwrap() - expected).abs() < 1e-9, "{degrees}°");
        }
        assert_eq!(sphere.m2_sr(4.0), 0.0);
    }
}
