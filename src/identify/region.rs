//! Line fitted to regions drawn around a streak.

use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};

use super::error;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs};

/// Line fitted to regions drawn around a streak.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedLine {
    /// Ends of the line: the outermost corners of the regions, projected onto the line.
    pub ends: [Direction<Gcrs>; 2],
    /// Half width of the regions, radians: the root mean square distance of their corners from the line.
    pub half_width_rad: f64,
    /// True if a region has an area (polygon, box), false for lines and vectors only, whose width is not that of the
    /// streak.
    pub has_width: bool,
}

/// Largest distance of the middle of a region from the line, as a multiple of the width of the region.
const MOST_WIDTHS_OFF: f64 = 2.0;
/// Additional allowed distance as a fraction of the length of the line. Lines drawn along a streak have no width.
const MOST_LENGTHS_OFF: f64 = 0.01;

/// Fits a line to the corners of regions of one streak. It passes through their mean in the direction of their largest
/// variance. The regions need not cover the whole streak.
///
/// # Errors
/// All corners are at one position, or the middle of a region is farther from the line than twice the width of the
/// region plus a hundredth of the length of the line.
pub fn fit_line(outlines: &[Vec<Direction<Gcrs>>]) -> Result<FittedLine, Error> {
    let corners: Vec<Vector3<f64>> = outlines.iter().flatten().map(|corner| *corner.vector()).collect();
    let no_line = || error::no_line(0.0);
    let centre = corners.iter().sum::<Vector3<f64>>().try_normalize(0.0).ok_or_else(no_line)?;
    let (east, north) = Direction::<Gcrs>::from_vector(centre).east_north();
    // On the tangent plane, great circles are straight lines.
    let plane = |corner: &Vector3<f64>| Vector2::new(corner.dot(&east), corner.dot(&north)) / corner.dot(&centre);
    let points: Vec<Vector2<f64>> = corners.iter().map(plane).collect();
    let PlaneLine { middle, along, across, half_width: half_width_rad, low, high } = line_in_plane(&points);
    if high <= low {
        return Err(no_line());
    }
    for outline in outlines.iter().filter(|outline| !outline.is_empty()) {
        let own: Vec<Vector2<f64>> = outline.iter().map(|corner| plane(corner.vector())).collect();
        let own_middle = own.iter().sum::<Vector2<f64>>() / own.len() as f64;
        let off_rad = (own_middle - middle).dot(&across).abs();
        let narrow_rad = narrow_width(&own, &own_middle);
        if off_rad > MOST_WIDTHS_OFF * narrow_rad + MOST_LENGTHS_OFF * (high - low) {
            let arcsec = |angle: f64| angle.to_degrees() * 3600.0;
            return Err(Error::new(
                ErrorKind::Invalid,
                format!(
                    "the regions are not on one line: the middle of one is {:.1} arcsec off, and it is {:.1} arcsec wide",
                    arcsec(off_rad),
                    arcsec(narrow_rad)
                ),
            )
            .allowing("the regions of one streak"));
        }
    }
    let ends = [low, high].map(|way| {
        let point = middle + along * way;
        Direction::from_vector((centre + east * point.x + north * point.y).normalize())
    });
    let has_width = outlines.iter().any(|outline| outline.len() > 2);
    Ok(FittedLine { ends, half_width_rad, has_width })
}

/// Line through the mean of points in a plane, in the direction of their largest variance.
pub(crate) struct PlaneLine {
    /// Mean of the points.
    pub middle: Vector2<f64>,
    /// Unit vectors along the line and across it.
    pub along: Vector2<f64>,
    pub across: Vector2<f64>,
    /// Root mean square distance of the points from the line.
    pub half_width: f64,
    /// Positions of the outermost points along the line, from its middle.
    pub low: f64,
    pub high: f64,
}

/// Fits a line to points in a plane.
pub(crate) fn line_in_plane(points: &[Vector2<f64>]) -> PlaneLine {
    let middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let along = longest(points, &middle);
    let across = Vector2::new(-along.y, along.x);
    let half_width =
        (points.iter().map(|point| (point - middle).dot(&across).powi(2)).sum::<f64>() / points.len() as f64).sqrt();
    let (low, high) = extremes(points.iter().map(|point| (point - middle).dot(&along)));
    PlaneLine { middle, along, across, half_width, low, high }
}

/// Returns the direction of the largest variance of points.
fn longest(points: &[Vector2<f64>], middle: &Vector2<f64>) -> Vector2<f64> {
    let spread: Matrix2<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    let axes = SymmetricEigen::new(spread);
    axes.eigenvectors.column(axes.eigenvalues.imax()).into_owned()
}

/// Returns the full width of a region, perpendicular to its length, radians.
fn narrow_width(points: &[Vector2<f64>], middle: &Vector2<f64>) -> f64 {
    let along = longest(points, middle);
    let across = Vector2::new(-along.y, along.x);
    let (low, high) = extremes(points.iter().map(|point| (point - middle).dot(&across)));
    (high - low).max(0.0)
}

fn extremes(positions: impl Iterator<Item = f64>) -> (f64, f64) {
    positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), position| (low.min(position), high.max(position)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_arcsec: f64, y_arcsec: f64) -> Direction<Gcrs> {
        let deg = |arcsec: f64| (arcsec / 3600.0).to_radians();
        let (dec, ra) = (0.5 + deg(y_arcsec), 2.0 + deg(x_arcsec) / 0.5_f64.cos());
        Direction::from_lon_lat_rad(ra, dec)
    }

    /// Returns a box of 100 by 10 arcsec about a position, rotated by 30°.
    fn streak_box(middle_arcsec: f64, offset_arcsec: f64) -> Vec<Direction<Gcrs>> {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        [(-50.0, -5.0), (50.0, -5.0), (50.0, 5.0), (-50.0, 5.0)]
            .map(|(along, across)| (along + middle_arcsec, across + offset_arcsec))
            .map(|(along, across)| at(along * cos - across * sin, along * sin + across * cos))
            .to_vec()
    }

    #[test]
    fn verif_boxes_of_one_streak() {
        let line = fit_line(&[streak_box(0.0, 0.0), streak_box(300.0, 0.0)]).unwrap();
        let length_arcsec = line.ends[0].separation_rad(&line.ends[1]).to_degrees() * 3600.0;
        assert!((length_arcsec - 400.0).abs() < 0.1, "{length_arcsec}");
        assert!((line.half_width_rad.to_degrees() * 3600.0 - 5.0).abs() < 0.05);
        // The line is 30° from east towards north: position angle 60° or 240°.
        let angle_deg = line.ends[0].position_angle_rad(&line.ends[1]).to_degrees() % 180.0;
        assert!((angle_deg - 60.0).abs() < 0.1, "{angle_deg}");
    }

    #[test]
    fn invalid_lines_are_rejected() {
        let apart = fit_line(&[streak_box(0.0, 0.0), streak_box(10.0, 400.0), streak_box(300.0, 0.0)]);
        assert!(apart.unwrap_err().to_string().starts_with("the regions are not on one line"));
        for regions in [&[vec![at(0.0, 0.0)]][..], &[]] {
            assert!(fit_line(regions).unwrap_err().to_string().starts_with("both ends of the streak"));
        }
    }
}
