//! A line through outlines that were drawn around a streak.

use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};

use super::error::IdentifyError;
use crate::frames::{Direction, Gcrs};

/// Ends and half width of what was outlined.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedLine {
    /// Both ends: the outermost corners, laid on the line.
    pub ends: [Direction<Gcrs>; 2],
    /// Half the width of the outlines across the line, radians: the root mean square of the corners' distances from it.
    pub half_width_rad: f64,
}

/// How far the middle of an outline may lie beside the line: so many of its own widths,
const WIDTHS_BESIDE: f64 = 2.0;
/// and so much of the line's length, for lines drawn by hand along one streak have no width.
const LENGTHS_BESIDE: f64 = 0.01;

/// The line of corners of one or more outlines (boxes, polygons, lines) along one streak: through their middle, in the direction in which they spread most.
///
/// Boxes drawn around several stretches of a streak are one line; the gaps between them do not matter.
///
/// # Errors
/// [`IdentifyError::NoLine`] where all corners are at one place; [`IdentifyError::NotOneLine`] where the middle of an outline lies farther beside the line
/// than twice its own width and a hundredth of the line's length.
pub fn fit_line(outlines: &[Vec<Direction<Gcrs>>]) -> Result<FittedLine, IdentifyError> {
    let corners: Vec<Vector3<f64>> = outlines.iter().flatten().map(|corner| *corner.vector()).collect();
    let no_line = IdentifyError::NoLine { separation_arcsec: 0.0 };
    let centre = corners.iter().sum::<Vector3<f64>>().try_normalize(0.0).ok_or(no_line.clone())?;
    let (east, north) = Direction::<Gcrs>::from_vector(centre).east_north();
    // On the tangent plane, where great circles are straight lines.
    let plane = |corner: &Vector3<f64>| Vector2::new(corner.dot(&east), corner.dot(&north)) / corner.dot(&centre);
    let points: Vec<Vector2<f64>> = corners.iter().map(plane).collect();
    let middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let along = longest(&points, &middle);
    let across = Vector2::new(-along.y, along.x);
    let half_width_rad =
        (points.iter().map(|point| (point - middle).dot(&across).powi(2)).sum::<f64>() / points.len() as f64).sqrt();

    let ways = points.iter().map(|point| (point - middle).dot(&along));
    let (low, high) = ends_of(ways);
    if high <= low {
        return Err(no_line);
    }
    for outline in outlines.iter().filter(|outline| !outline.is_empty()) {
        let own: Vec<Vector2<f64>> = outline.iter().map(|corner| plane(corner.vector())).collect();
        let own_middle = own.iter().sum::<Vector2<f64>>() / own.len() as f64;
        let off_rad = (own_middle - middle).dot(&across).abs();
        let narrow_rad = narrow_width(&own, &own_middle);
        if off_rad > WIDTHS_BESIDE * narrow_rad + LENGTHS_BESIDE * (high - low) {
            let arcsec = |angle: f64| angle.to_degrees() * 3600.0;
            return Err(IdentifyError::NotOneLine { off_arcsec: arcsec(off_rad), width_arcsec: arcsec(narrow_rad) });
        }
    }
    let ends = [low, high].map(|way| {
        let point = middle + along * way;
        Direction::from_vector((centre + east * point.x + north * point.y).normalize())
    });
    Ok(FittedLine { ends, half_width_rad })
}

/// The direction in which points spread most.
fn longest(points: &[Vector2<f64>], middle: &Vector2<f64>) -> Vector2<f64> {
    let spread: Matrix2<f64> = points.iter().map(|point| (point - middle) * (point - middle).transpose()).sum();
    let axes = SymmetricEigen::new(spread);
    axes.eigenvectors.column(axes.eigenvalues.imax()).into_owned()
}

/// Full width of one outline across its own length, radians.
fn narrow_width(points: &[Vector2<f64>], middle: &Vector2<f64>) -> f64 {
    let along = longest(points, middle);
    let across = Vector2::new(-along.y, along.x);
    let (low, high) = ends_of(points.iter().map(|point| (point - middle).dot(&across)));
    (high - low).max(0.0)
}

fn ends_of(ways: impl Iterator<Item = f64>) -> (f64, f64) {
    ways.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), way| (low.min(way), high.max(way)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_arcsec: f64, y_arcsec: f64) -> Direction<Gcrs> {
        let deg = |arcsec: f64| (arcsec / 3600.0).to_radians();
        let (dec, ra) = (0.5 + deg(y_arcsec), 2.0 + deg(x_arcsec) / 0.5_f64.cos());
        Direction::from_lon_lat_rad(ra, dec)
    }

    /// A box of 100 by 10 arcsec about a place, turned by 30°.
    fn outline(middle_arcsec: f64, beside_arcsec: f64) -> Vec<Direction<Gcrs>> {
        let (sin, cos) = 30_f64.to_radians().sin_cos();
        [(-50.0, -5.0), (50.0, -5.0), (50.0, 5.0), (-50.0, 5.0)]
            .map(|(along, across)| (along + middle_arcsec, across + beside_arcsec))
            .map(|(along, across)| at(along * cos - across * sin, along * sin + across * cos))
            .to_vec()
    }

    #[test]
    fn verif_boxes_of_one_streak() {
        let line = fit_line(&[outline(0.0, 0.0), outline(300.0, 0.0)]).unwrap();
        let length_arcsec = line.ends[0].separation_rad(&line.ends[1]).to_degrees() * 3600.0;
        assert!((length_arcsec - 400.0).abs() < 0.1, "{length_arcsec}");
        assert!((line.half_width_rad.to_degrees() * 3600.0 - 5.0).abs() < 0.05);
        // 30° from east towards north: position angle 60° or 240°.
        let angle_deg = line.ends[0].position_angle_rad(&line.ends[1]).to_degrees() % 180.0;
        assert!((angle_deg - 60.0).abs() < 0.1, "{angle_deg}");
    }

    #[test]
    fn what_is_no_line_is_refused() {
        let apart = fit_line(&[outline(0.0, 0.0), outline(10.0, 400.0), outline(300.0, 0.0)]);
        assert!(matches!(apart, Err(IdentifyError::NotOneLine { .. })), "{apart:?}");
        assert!(matches!(fit_line(&[vec![at(0.0, 0.0)]]), Err(IdentifyError::NoLine { .. })));
        assert!(matches!(fit_line(&[]), Err(IdentifyError::NoLine { .. })));
    }
}
