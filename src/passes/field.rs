//! Field of view: a circle, rectangles, polygons, or a mosaic of chips with gaps.

use nalgebra::Vector3;
use serde::Deserialize;
use serde_json::Value;

use crate::error::Error;
use crate::frames::{Direction, Gcrs};
use crate::input::json_error;

/// Form of a field, for errors.
const FORM: &str = r#"a field is {"shapes": [{"circle_deg": d} | {"rectangle_deg": [w, h]} | {"polygon_deg": [[x, y], ...]}], "unit": "deg"}"#;

/// Largest distance of a point of a rectangle or polygon from the centre of the field, in degrees of the tangent plane
/// (45° on the sky).
const LARGEST_TANGENT_DEG: f64 = 57.3;

/// Shape of the field of view, relative to the pointing.
///
/// Rectangles and polygons are given in degrees on the tangent plane at the pointing (gnomonic projection), with x to
/// the east and y to the north at rotation 0. A circle is exact on the sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    shapes: Vec<NamedShape>,
}

#[derive(Clone, Debug, PartialEq)]
struct NamedShape {
    name: String,
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    /// Circle given by its centre on the tangent plane, in radians of the plane, and its radius on the sky.
    Circle { centre: [f64; 2], radius_rad: f64 },
    /// Polygon given by its corners on the tangent plane, in radians of the plane.
    Polygon(Vec<[f64; 2]>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FieldFile {
    shapes: Vec<ShapeFile>,
    #[serde(default)]
    unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeFile {
    #[serde(default)]
    name: Option<String>,
    #[serde(default)]
    circle_deg: Option<f64>,
    #[serde(default)]
    rectangle_deg: Option<[f64; 2]>,
    #[serde(default)]
    polygon_deg: Option<Vec<[f64; 2]>>,
    #[serde(default)]
    center_deg: Option<[f64; 2]>,
}

impl Field {
    /// Creates a circle of this diameter, radians, centred on the pointing.
    ///
    /// # Errors
    /// The diameter is not above 0 or exceeds 180°.
    pub fn circle(diameter_rad: f64) -> Result<Self, Error> {
        let diameter_deg = diameter_rad.to_degrees();
        if !(diameter_deg > 0.0 && diameter_deg <= 180.0) {
            return Err(invalid_diameter("circle", diameter_deg, 180.0));
        }
        let shape = Shape::Circle { centre: [0.0, 0.0], radius_rad: 0.5 * diameter_rad };
        Ok(Self { shapes: vec![NamedShape { name: "field".to_owned(), shape }] })
    }

    /// Creates a circle of this diameter, degrees, centred on the pointing.
    ///
    /// # Errors
    /// The errors of [`Field::circle`].
    pub fn circle_deg(diameter_deg: f64) -> Result<Self, Error> {
        Self::circle(diameter_deg.to_radians())
    }

    /// Creates a rectangle of this width (x) and height (y), degrees on the tangent plane, centred on the pointing.
    ///
    /// # Errors
    /// A side is not above 0, or a corner is more than 45° from the pointing.
    pub fn rectangle_deg(width_deg: f64, height_deg: f64) -> Result<Self, Error> {
        Ok(Self { shapes: vec![rectangle("field".to_owned(), [width_deg, height_deg], [0.0, 0.0])?] })
    }

    /// Creates a polygon from its corners in degrees on the tangent plane. The corners may be in either sense of
    /// rotation, and the polygon need not be convex.
    ///
    /// # Errors
    /// There are fewer than three corners, the area is 0, or a corner is more than 45° from the pointing.
    pub fn polygon_deg(corners_deg: &[[f64; 2]]) -> Result<Self, Error> {
        Ok(Self { shapes: vec![polygon("field".to_owned(), corners_deg, [0.0, 0.0])?] })
    }

    /// Reads a field in JSON form: `{"shapes": [{"name", "circle_deg": d} | {"rectangle_deg": [w, h]} | {"polygon_deg":
    /// [[x, y], …]}], "unit": "deg"}`. Each shape may have a centre `"center_deg": [x, y]` on the tangent plane.
    /// Several shapes form a mosaic.
    ///
    /// # Errors
    /// The JSON is invalid, the unit is not degrees, there are no shapes, or a shape is invalid.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        Self::from_file(serde_json::from_str(text))
    }

    /// Same as [`Field::from_json`], for keys that are read already.
    pub(crate) fn from_keys(keys: Value) -> Result<Self, Error> {
        Self::from_file(serde_json::from_value(keys))
    }

    fn from_file(file: serde_json::Result<FieldFile>) -> Result<Self, Error> {
        let file = file.map_err(|error| json_error(&error).with_remark(FORM))?;
        if let Some(unit) = file.unit.filter(|unit| unit != "deg") {
            return Err(Error::invalid("unit of the field", format!("{unit:?}"), "\"deg\""));
        }
        let shapes = file
            .shapes
            .into_iter()
            .enumerate()
            .map(|(number, shape)| {
                let name = shape.name.unwrap_or_else(|| (number + 1).to_string());
                let centre_deg = shape.center_deg.unwrap_or([0.0, 0.0]);
                match (shape.circle_deg, shape.rectangle_deg, shape.polygon_deg) {
                    (Some(diameter_deg), None, None) => circle(name, diameter_deg, centre_deg),
                    (None, Some(sides_deg), None) => rectangle(name, sides_deg, centre_deg),
                    (None, None, Some(corners_deg)) => polygon(name, &corners_deg, centre_deg),
                    _ => {
                        let allowed = "exactly one of circle_deg, rectangle_deg, polygon_deg";
                        Err(Error::invalid(format!("field shape {name}"), "none of the forms, or several", allowed))
                    }
                }
            })
            .collect::<Result<Vec<_>, _>>()?;
        if shapes.is_empty() {
            return Err(Error::invalid("number of shapes of the field", 0, "1 or more"));
        }
        Ok(Self { shapes })
    }

    /// Returns the names of the shapes in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.shapes.iter().map(|shape| shape.name.as_str())
    }

    /// Returns the area, square degrees: on the sky for circles, on the tangent plane for other shapes. Overlaps count
    /// twice.
    pub fn area_deg2(&self) -> f64 {
        let area_rad2: f64 = self
            .shapes
            .iter()
            .map(|named| match &named.shape {
                // Ω = 2π (1 - cos r) = 4π sin²(r/2)
                Shape::Circle { radius_rad, .. } => 4.0 * std::f64::consts::PI * (0.5 * radius_rad).sin().powi(2),
                Shape::Polygon(corners) => signed_area(corners).abs(),
            })
            .sum();
        area_rad2 * 1f64.to_degrees().powi(2)
    }

    /// Returns the mean over all directions of the width of the field across the direction, degrees on the tangent
    /// plane. Parts of the direction's normal that several shapes cover count once. An object that crosses at the
    /// angular rate ω for the time t is in the field with a probability proportional to area + ω t × width.
    pub fn mean_width_deg(&self) -> f64 {
        const DIRECTIONS: usize = 180;
        let outlines = self.outlines_deg(360);
        let width = |direction: usize| {
            let (sin, cos) = (std::f64::consts::PI * direction as f64 / DIRECTIONS as f64).sin_cos();
            let extent = |outline: &Vec<[f64; 2]>| {
                let along = outline.iter().map(|[x, y]| x * cos + y * sin);
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
            };
            let mut extents: Vec<(f64, f64)> = outlines.iter().map(extent).collect();
            extents.sort_by(|first, other| first.0.total_cmp(&other.0));
            let covered = (0.0, f64::NEG_INFINITY);
            let union =
                |(sum, end): (f64, f64), (low, high): (f64, f64)| (sum + (high - low.max(end)).max(0.0), high.max(end));
            extents.into_iter().fold(covered, union).0
        };
        (0..DIRECTIONS).map(width).sum::<f64>() / DIRECTIONS as f64
    }

    /// Returns the radius of the smallest circle around the pointing that contains every shape, radians.
    pub fn bounding_radius_rad(&self) -> f64 {
        self.shapes
            .iter()
            .map(|named| match &named.shape {
                Shape::Circle { centre, radius_rad } => centre[0].hypot(centre[1]).atan() + radius_rad,
                Shape::Polygon(corners) => {
                    corners.iter().map(|corner| corner[0].hypot(corner[1]).atan()).fold(0.0, f64::max)
                }
            })
            .fold(0.0, f64::max)
    }

    /// Returns the shapes in order as closed lines in degrees of the tangent plane, with x to the east and y to the
    /// north at rotation 0.
    ///
    /// Circles have `points` points, at least 3. Points 90° or more from the pointing have no position on the plane and
    /// are omitted.
    pub fn outlines_deg(&self, points: usize) -> Vec<Vec<[f64; 2]>> {
        let degrees = |point: [f64; 2]| point.map(f64::to_degrees);
        let outline = |named: &NamedShape| match &named.shape {
            Shape::Circle { centre: [x, y], radius_rad } => {
                let axis = Vector3::new(*x, *y, 1.0).normalize();
                let seen = rim(axis, *radius_rad, points).filter(|sight| sight.z > 1e-9);
                seen.map(|sight| degrees([sight.x / sight.z, sight.y / sight.z])).collect()
            }
            Shape::Polygon(corners) => corners.iter().map(|corner| degrees(*corner)).collect(),
        };
        self.shapes.iter().map(outline).collect()
    }

    /// Places the field on the sky with its centre at `pointing`. `rotation_rad` is the position angle of its y axis,
    /// from north through east.
    #[doc(hidden)]
    pub fn on_sky(&self, pointing: &Direction<Gcrs>, rotation_rad: f64) -> FieldOnSky<'_> {
        let (east, north) = pointing.east_north();
        let (sin, cos) = rotation_rad.sin_cos();
        FieldOnSky {
            field: self,
            centre: *pointing.vector(),
            x_axis: east * cos - north * sin,
            y_axis: east * sin + north * cos,
            bounding_radius_rad: self.bounding_radius_rad(),
        }
    }
}

/// Returns `points` unit vectors (at least 3) at equal distances on a circle around an axis.
fn rim(axis: Vector3<f64>, radius_rad: f64, points: usize) -> impl Iterator<Item = Vector3<f64>> {
    let points = points.max(3);
    let (east, north) = Direction::<Gcrs>::from_vector(axis).east_north();
    let (sin_radius, cos_radius) = radius_rad.sin_cos();
    (0..points).map(move |step| {
        let (sin, cos) = (std::f64::consts::TAU * step as f64 / points as f64).sin_cos();
        axis * cos_radius + (north * cos + east * sin) * sin_radius
    })
}

fn circle(name: String, diameter_deg: f64, centre_deg: [f64; 2]) -> Result<NamedShape, Error> {
    let offset_deg = centre_deg[0].hypot(centre_deg[1]);
    // A circle that is not centred on the pointing must lie within 90° of it, the limit of the tangent plane.
    let allowed_deg = if offset_deg == 0.0 { 180.0 } else { 90.0 };
    if !(diameter_deg > 0.0 && diameter_deg <= allowed_deg) {
        return Err(invalid_diameter(&name, diameter_deg, allowed_deg));
    }
    if !offset_deg.is_finite() || offset_deg > LARGEST_TANGENT_DEG {
        return Err(too_far(&name));
    }
    let shape = Shape::Circle { centre: centre_deg.map(f64::to_radians), radius_rad: 0.5 * diameter_deg.to_radians() };
    Ok(NamedShape { name, shape })
}

fn rectangle(name: String, [width, height]: [f64; 2], centre_deg: [f64; 2]) -> Result<NamedShape, Error> {
    if !(width > 0.0 && height > 0.0) {
        let what = format!("field shape {name}: size");
        return Err(Error::invalid(what, format!("{width} by {height} deg"), "sides above 0"));
    }
    let (x, y) = (0.5 * width, 0.5 * height);
    polygon(name, &[[-x, -y], [x, -y], [x, y], [-x, y]], centre_deg)
}

fn polygon(name: String, corners_deg: &[[f64; 2]], centre_deg: [f64; 2]) -> Result<NamedShape, Error> {
    let corners: Vec<[f64; 2]> =
        corners_deg.iter().map(|corner| [0, 1].map(|axis| (corner[axis] + centre_deg[axis]).to_radians())).collect();
    if corners.len() < 3 {
        return Err(
            Error::invalid("number of corners", corners.len(), "3 or more").at(format_args!("field shape {name}"))
        );
    }
    let limit = LARGEST_TANGENT_DEG.to_radians();
    if !corners.iter().all(|corner| corner[0].hypot(corner[1]) <= limit) {
        return Err(too_far(&name));
    }
    if signed_area(&corners) == 0.0 {
        return Err(Error::invalid("area", 0, "above 0").at(format_args!("field shape {name}")));
    }
    Ok(NamedShape { name, shape: Shape::Polygon(corners) })
}

fn too_far(shape: &str) -> Error {
    let allowed = format!("finite numbers within {LARGEST_TANGENT_DEG} deg on the tangent plane");
    Error::invalid("distance of a point from the centre", "too large", allowed).at(format_args!("field shape {shape}"))
}

fn invalid_diameter(shape: &str, diameter_deg: f64, allowed_deg: f64) -> Error {
    let allowed = format!("above 0, at most {allowed_deg} deg");
    Error::invalid("diameter", format!("{diameter_deg} deg"), allowed).at(format_args!("field shape {shape}"))
}

/// Returns the area by the shoelace formula; positive if the corners are anticlockwise.
fn signed_area(corners: &[[f64; 2]]) -> f64 {
    0.5 * edges(corners).map(|([ax, ay], [bx, by])| ax * by - bx * ay).sum::<f64>()
}

/// Returns the edges of a closed polygon.
pub(super) fn edges(corners: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2])> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}

/// Field of view placed on the sky at a pointing.
#[derive(Clone, Debug)]
pub struct FieldOnSky<'a> {
    field: &'a Field,
    centre: Vector3<f64>,
    x_axis: Vector3<f64>,
    y_axis: Vector3<f64>,
    bounding_radius_rad: f64,
}

/// Border of a shape, which a track can cross.
#[derive(Clone, Debug)]
pub(super) enum Border<'a> {
    /// Circle on the sky with its centre and its radius in radians.
    Rim(Vector3<f64>, f64),
    /// Polygon on the tangent plane, given by its corners.
    Outline(&'a [[f64; 2]]),
}

impl FieldOnSky<'_> {
    /// Returns the centre as a unit vector.
    pub(super) fn centre(&self) -> &Vector3<f64> {
        &self.centre
    }

    /// Returns the radius around the centre that contains every shape, radians.
    pub(super) fn bounding_radius_rad(&self) -> f64 {
        self.bounding_radius_rad
    }

    /// Returns the borders of the shapes in order.
    pub(super) fn borders(&self) -> impl Iterator<Item = Border<'_>> {
        self.field.shapes.iter().map(|named| match &named.shape {
            Shape::Circle { centre: [x, y], radius_rad } => {
                let axis = (self.centre + self.x_axis * *x + self.y_axis * *y).normalize();
                Border::Rim(axis, *radius_rad)
            }
            Shape::Polygon(corners) => Border::Outline(corners),
        })
    }

    /// Returns the position of a vector on the tangent plane, radians of the plane; `None` for 90° or more from the
    /// centre.
    pub(super) fn project(&self, sight: &Vector3<f64>) -> Option<[f64; 2]> {
        let depth = sight.dot(&self.centre);
        (depth > 0.0).then(|| [sight.dot(&self.x_axis) / depth, sight.dot(&self.y_axis) / depth])
    }

    /// Returns the border of every shape as directions: the corners of a polygon, or `round` points (at least 3) of a
    /// circle. The first point is not repeated at the end.
    pub fn outlines(&self, round: usize) -> Vec<Vec<Direction<Gcrs>>> {
        let corner =
            |[x, y]: &[f64; 2]| Direction::from_vector((self.centre + self.x_axis * *x + self.y_axis * *y).normalize());
        let outline = |border: Border<'_>| match border {
            Border::Rim(axis, radius_rad) => rim(axis, radius_rad, round).map(Direction::from_vector).collect(),
            Border::Outline(corners) => corners.iter().map(corner).collect(),
        };
        self.borders().map(outline).collect()
    }

    /// Returns true if a direction lies inside one of the shapes.
    pub fn contains(&self, direction: &Direction<Gcrs>) -> bool {
        let sight = direction.vector();
        self.borders().any(|border| match border {
            Border::Rim(axis, radius_rad) => axis.cross(sight).norm().atan2(axis.dot(sight)) <= radius_rad,
            Border::Outline(corners) => self.project(sight).is_some_and(|point| polygon_contains(corners, point)),
        })
    }
}

/// Returns true if a point is inside a polygon (even-odd rule).
pub(super) fn polygon_contains(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    edges(corners)
        .filter(|([ax, ay], [bx, by])| (*ay > y) != (*by > y) && x < (bx - ax) * (y - ay) / (by - ay) + ax)
        .count()
        % 2
        == 1
}
