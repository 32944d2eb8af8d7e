//! Regions of SAOImage DS9 (boxes, polygons, lines and vectors on the sky), and the line fitted to regions drawn around
//! a streak.
//!
//! Format (DS9 reference manual, "Regions"): a coordinate system (`fk5`, `j2000`, `icrs`), then shapes with their
//! numbers in brackets or after blanks, separated by commas or blanks. `;` separates statements, `#` starts a comment,
//! `global` lines are ignored; an excluded shape (`-`) is an error. DS9 saves vectors, projections and segments behind
//! `#`, because other programs do not know them; vectors, projections (a line) and segments of two points are read. FK5
//! of equinox 2000 is read as ICRS: they differ by 0.02 arcsec.

use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};

use super::error;
use crate::error::{Error, ErrorKind};
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};

const SYSTEMS: &[&str] = &["fk5", "j2000", "icrs"];
/// Coordinate systems of DS9 that are recognised but not supported.
const OTHER_SYSTEMS: &[&str] =
    &["image", "physical", "linear", "amplifier", "detector", "fk4", "b1950", "galactic", "ecliptic", "wcs", "wcsa"];
const ALLOWED: &str = "allowed: polygon, box, line and vector in fk5 or icrs";

/// Parses a region file. Returns the corners of each region; `path` is the name of the file in errors.
///
/// # Errors
/// A line has another coordinate system or shape, or invalid numbers; there is no region.
pub fn parse_regions(path: &str, text: &str) -> Result<Vec<Vec<Direction<Gcrs>>>, Error> {
    let mut outlines = Vec::new();
    let mut system: Option<String> = None;
    for (number, line) in text.lines().enumerate() {
        let fail = |problem: String| Error::format(problem).in_line("", path, number + 1);
        let line = statements_of(line);
        for statement in line.split(';').map(str::trim).filter(|statement| !statement.is_empty()) {
            let lower = statement.to_ascii_lowercase();
            if lower.starts_with("global") {
                continue;
            }
            if SYSTEMS.contains(&lower.as_str()) || OTHER_SYSTEMS.contains(&lower.as_str()) {
                system = Some(lower);
                continue;
            }
            match &system {
                Some(known) if SYSTEMS.contains(&known.as_str()) => {}
                Some(other) => {
                    return Err(fail(format!(
                        "unsupported coordinate system {other}; {ALLOWED} (in DS9, save the regions as fk5 in degrees)"
                    )));
                }
                None => return Err(fail(format!("'{statement}' has no preceding coordinate system; {ALLOWED}"))),
            }
            outlines.push(outline(statement).map_err(fail)?);
        }
    }
    if outlines.is_empty() {
        Err(Error::new(ErrorKind::Invalid, "no region found")
            .allowing("polygon, box, line and vector in fk5 or icrs")
            .in_file("", path))
    } else {
        Ok(outlines)
    }
}

/// Shapes that DS9 writes as comments.
const COMMENTED: [&str; 3] = ["vector", "projection", "segment"];

/// Returns a line without its comment. A comment that is a shape of DS9 is a statement.
fn statements_of(line: &str) -> &str {
    let mut parts = line.split('#').map(str::trim);
    match (parts.next(), parts.next()) {
        (Some(""), Some(shape)) if COMMENTED.iter().any(|name| is_shape(shape, name)) => shape,
        (line, _) => line.unwrap_or_default(),
    }
}

/// Returns true if a text is a shape of this name with its numbers in brackets.
fn is_shape(text: &str, name: &str) -> bool {
    let head = text.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name));
    head && text[name.len()..].trim_start().starts_with('(')
}

fn outline(statement: &str) -> Result<Vec<Direction<Gcrs>>, String> {
    let shape_end = statement.find(|mark: char| mark == '(' || mark.is_whitespace()).unwrap_or(statement.len());
    let (shape, rest) = statement.split_at(shape_end);
    let inside = rest.trim().trim_start_matches('(');
    let inside = inside.split(')').next().unwrap_or_default();
    let numbers: Vec<&str> =
        inside.split(|mark: char| mark == ',' || mark.is_whitespace()).filter(|number| !number.is_empty()).collect();
    let wrong_count = |count: &str| format!("{shape} has {} numbers; allowed: {count}", numbers.len());
    match shape.trim_start_matches('+').to_ascii_lowercase().as_str() {
        "polygon" if numbers.len() >= 4 && numbers.len().is_multiple_of(2) => {
            numbers.chunks(2).map(|pair| position(pair[0], pair[1])).collect()
        }
        "polygon" => Err(wrong_count("two or more pairs of right ascension and declination")),
        "segment" if numbers.len() != 4 => Err(wrong_count("4: the positions of two points")),
        // A projection also has a width.
        "line" | "projection" | "segment" if numbers.len() >= 4 => {
            numbers[..4].chunks(2).map(|pair| position(pair[0], pair[1])).collect()
        }
        "line" | "projection" => Err(wrong_count("4: the positions of both ends")),
        "vector" if numbers.len() == 4 => {
            let (from, length, angle) =
                (position(numbers[0], numbers[1])?, size_rad(numbers[2])?, angle_rad(numbers[3])?);
            Ok(vec![from, moved(&from, length * angle.cos(), length * angle.sin())])
        }
        "vector" => Err(wrong_count("4: a position, a length and an angle")),
        "box" if numbers.len() == 4 || numbers.len() == 5 => {
            let centre = position(numbers[0], numbers[1])?;
            let (width, height) = (0.5 * size_rad(numbers[2])?, 0.5 * size_rad(numbers[3])?);
            let (sin, cos) = numbers.get(4).map_or(Ok(0.0), |angle| angle_rad(angle))?.sin_cos();
            let corners = [(-width, -height), (width, -height), (width, height), (-width, height)];
            Ok(corners.map(|(x, y)| moved(&centre, x * cos - y * sin, x * sin + y * cos)).to_vec())
        }
        "box" => Err(wrong_count("4 or 5: a position, a width, a height, and an angle")),
        other => Err(format!("unsupported shape '{other}'; {ALLOWED}")),
    }
}

fn position(right_ascension: &str, declination: &str) -> Result<Direction<Gcrs>, String> {
    let ra_deg = parse_right_ascension_deg(right_ascension).map_err(|error| error.to_string())?;
    let dec_deg = parse_declination_deg(declination).map_err(|error| error.to_string())?;
    Ok(Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()))
}

/// Parses a size: `12.5"` in arcsec, `3'` in arcmin, `0.2d` or a number in degrees.
fn size_rad(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.char_indices().last() {
        Some((at, '"')) => (&text[..at], 1.0 / 3600.0),
        Some((at, '\'')) => (&text[..at], 1.0 / 60.0),
        Some((at, 'd')) => (&text[..at], 1.0),
        _ => (text, 1.0),
    };
    let size: Option<f64> = number.parse().ok().filter(|size: &f64| size.is_finite() && *size > 0.0);
    size.map(|size| (size * factor).to_radians())
        .ok_or_else(|| format!("invalid size '{text}'; allowed: a number above 0, followed by \", ' or d"))
}

fn angle_rad(text: &str) -> Result<f64, String> {
    let angle: Option<f64> = text.trim_end_matches('d').parse().ok().filter(|angle: &f64| angle.is_finite());
    angle.map(f64::to_radians).ok_or_else(|| format!("invalid angle '{text}'; allowed: a number of degrees"))
}

/// Returns a position offset to the west and the north. DS9 measures the angles of regions from the x axis of an image
/// with north up and east left: 0° is west, 90° is north.
fn moved(from: &Direction<Gcrs>, west_rad: f64, north_rad: f64) -> Direction<Gcrs> {
    let (east, north) = from.east_north();
    let moved: Vector3<f64> = from.vector() - east * west_rad.tan() + north * north_rad.tan();
    Direction::from_vector(moved.normalize())
}

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
    let middle = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let along = longest(&points, &middle);
    let across = Vector2::new(-along.y, along.x);
    let half_width_rad =
        (points.iter().map(|point| (point - middle).dot(&across).powi(2)).sum::<f64>() / points.len() as f64).sqrt();

    let positions = points.iter().map(|point| (point - middle).dot(&along));
    let (low, high) = extremes(positions);
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

    const HEAD: &str = "# Region file format: DS9 version 4.1\nglobal color=green dashlist=8 3\nfk5\n";

    #[test]
    fn shapes_of_ds9() {
        let text = format!(
            "{HEAD}polygon(232.0174027,8.9284745,232.0161734,8.9252280,232.0695267,8.9023292)\n\
             line(15:28:04.2,+8:55:42,15:28:16.7,+8:54:08) # line=0 0\nbox 232 9 20\" 2' 30; vector(232,9,60\",90)\n"
        );
        let outlines = parse_regions("a.reg", &text).unwrap();
        assert_eq!(outlines.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2, 4, 2]);
        assert!((outlines[0][1].longitude_rad().to_degrees() - 232.0161734).abs() < 1e-9);
        assert!((outlines[1][0].latitude_rad().to_degrees() - 8.928_333_333).abs() < 1e-8);
        // A vector of angle 90° points north.
        let [from, to] = [outlines[3][0], outlines[3][1]];
        assert!(from.position_angle_rad(&to).sin().abs() < 1e-6, "{}", from.position_angle_rad(&to));
        assert!(to.latitude_rad() > from.latitude_rad());
        assert!((from.separation_rad(&to).to_degrees() * 3600.0 - 60.0).abs() < 1e-3);
        // The long side of the box points north and is rotated by 30° anticlockwise: its position angle is 30°.
        let angle_deg = outlines[2][1].position_angle_rad(&outlines[2][2]).to_degrees();
        assert!((angle_deg - 30.0).abs() < 0.01, "{angle_deg}");
    }

    /// Lines as DS9 8 saves them: vectors and projections behind a number sign.
    #[test]
    fn shapes_that_ds9_writes_as_comments() {
        let text = format!(
            "{HEAD}# vector(232,9,60\",90) vector=1 width=2\n# projection(232,9,232.1,9.1,3\")\n\
             #segment(232,9,232.1,9.1) # color=red\n# text(232,9) text={{vector}}\n# vector of the streak\n"
        );
        let outlines = parse_regions("a.reg", &text).unwrap();
        assert_eq!(outlines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
        assert_eq!(outlines[0], parse_regions("a.reg", &format!("{HEAD}vector(232,9,60\",90)")).unwrap()[0]);
        let message = parse_regions("a.reg", &format!("{HEAD}# vector(232,9)\n")).unwrap_err().to_string();
        assert!(message.starts_with("a.reg: line 4: vector has 2 numbers"), "{message}");
    }

    #[test]
    fn unsupported_statements_are_reported_with_their_line() {
        let message = |body: &str| parse_regions("a.reg", &format!("{HEAD}{body}")).unwrap_err().to_string();
        assert!(message("circle(1,2,3\")").starts_with("a.reg: line 4: unsupported shape 'circle'"));
        assert!(message("polygon(1,2,3)").contains("polygon has 3 numbers"));
        assert!(message("line(400,2,3,4)").contains("\"400\" is not a right ascension"));
        assert!(message("box(1,2,x,3)").contains("invalid size 'x'"));
        assert!(message("image\nline(1,2,3,4)").starts_with("a.reg: line 5: unsupported coordinate system image"));
        assert!(message("-line(1,2,3,4)").contains("unsupported shape '-line'"));
        assert_eq!(message(""), format!("a.reg: no region found; {ALLOWED}"));
        let bare = parse_regions("a.reg", "line(1,2,3,4)").unwrap_err().to_string();
        assert!(bare.contains("has no preceding coordinate system"), "{bare}");
    }

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
