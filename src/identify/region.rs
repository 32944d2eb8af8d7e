//! Regions of SAOImage DS9: boxes, polygons, lines and vectors on the sky, as outlines.
//!
//! Read are the lines of the format (DS9 reference manual, "Regions"): a system of coordinates (`fk5`, `j2000`, `icrs`), then shapes with their numbers
//! in brackets or after blanks, parted by commas or blanks; `;` parts statements, `#` begins a comment, `global` lines are passed over, a `-` before
//! a shape takes it away (and is refused here). FK5 of equinox 2000 is taken as ICRS: they differ by 0.02 arcsec.

use nalgebra::Vector3;

use super::error::IdentifyError;
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};

const SYSTEMS: &[&str] = &["fk5", "j2000", "icrs"];
/// Known to DS9, and not on the sky in ICRS.
const OTHER_SYSTEMS: &[&str] =
    &["image", "physical", "linear", "amplifier", "detector", "fk4", "b1950", "galactic", "ecliptic", "wcs", "wcsa"];
const ALLOWED: &str = "allowed: polygon, box, line and vector in fk5 or icrs";

/// The outlines in the text of a file; `path` is what errors call it.
///
/// # Errors
/// [`IdentifyError::Region`] with the line: another system or shape, numbers that are none; [`IdentifyError::NoRegion`].
pub fn parse_regions(path: &str, text: &str) -> Result<Vec<Vec<Direction<Gcrs>>>, IdentifyError> {
    let mut outlines = Vec::new();
    let mut system: Option<String> = None;
    for (number, line) in text.lines().enumerate() {
        let fail = |problem: String| IdentifyError::Region { path: path.to_owned(), line: number + 1, problem };
        let line = line.split('#').next().unwrap_or_default();
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
                        "coordinates are {other}; {ALLOWED} (save the regions as fk5 in degrees)"
                    )));
                }
                None => return Err(fail(format!("'{statement}' before any system of coordinates; {ALLOWED}"))),
            }
            outlines.push(outline(statement).map_err(fail)?);
        }
    }
    if outlines.is_empty() { Err(IdentifyError::NoRegion { path: path.to_owned() }) } else { Ok(outlines) }
}

fn outline(statement: &str) -> Result<Vec<Direction<Gcrs>>, String> {
    let shape_end = statement.find(|mark: char| mark == '(' || mark.is_whitespace()).unwrap_or(statement.len());
    let (shape, rest) = statement.split_at(shape_end);
    let inside = rest.trim().trim_start_matches('(');
    let inside = inside.split(')').next().unwrap_or_default();
    let numbers: Vec<&str> =
        inside.split(|mark: char| mark == ',' || mark.is_whitespace()).filter(|number| !number.is_empty()).collect();
    let wants = |count: &str| format!("{shape} of {} numbers; allowed: {count}", numbers.len());
    match shape.trim_start_matches('+').to_ascii_lowercase().as_str() {
        "polygon" if numbers.len() >= 4 && numbers.len().is_multiple_of(2) => {
            numbers.chunks(2).map(|pair| place(pair[0], pair[1])).collect()
        }
        "polygon" => Err(wants("pairs of right ascension and declination, two or more")),
        "line" if numbers.len() >= 4 => numbers[..4].chunks(2).map(|pair| place(pair[0], pair[1])).collect(),
        "line" => Err(wants("4, two ends")),
        "vector" if numbers.len() == 4 => {
            let (from, length, angle) = (place(numbers[0], numbers[1])?, size_rad(numbers[2])?, angle_rad(numbers[3])?);
            Ok(vec![from, moved(&from, length * angle.cos(), length * angle.sin())])
        }
        "vector" => Err(wants("4: a place, a length and an angle")),
        "box" if numbers.len() == 4 || numbers.len() == 5 => {
            let centre = place(numbers[0], numbers[1])?;
            let (width, height) = (0.5 * size_rad(numbers[2])?, 0.5 * size_rad(numbers[3])?);
            let (sin, cos) = numbers.get(4).map_or(Ok(0.0), |angle| angle_rad(angle))?.sin_cos();
            let corners = [(-width, -height), (width, -height), (width, height), (-width, height)];
            Ok(corners.map(|(x, y)| moved(&centre, x * cos - y * sin, x * sin + y * cos)).to_vec())
        }
        "box" => Err(wants("4 or 5: a place, width, height and an angle")),
        other => Err(format!("'{other}' is not read; {ALLOWED}")),
    }
}

fn place(right_ascension: &str, declination: &str) -> Result<Direction<Gcrs>, String> {
    let ra_deg = parse_right_ascension_deg(right_ascension).map_err(|error| error.to_string())?;
    let dec_deg = parse_declination_deg(declination).map_err(|error| error.to_string())?;
    Ok(Direction::from_lon_lat_rad(ra_deg.to_radians(), dec_deg.to_radians()))
}

/// A size: `12.5"` arcsec, `3'` arcmin, `0.2d` or a bare number degrees.
fn size_rad(text: &str) -> Result<f64, String> {
    let (number, factor) = match text.char_indices().last() {
        Some((at, '"')) => (&text[..at], 1.0 / 3600.0),
        Some((at, '\'')) => (&text[..at], 1.0 / 60.0),
        Some((at, 'd')) => (&text[..at], 1.0),
        _ => (text, 1.0),
    };
    let size: Option<f64> = number.parse().ok().filter(|size: &f64| size.is_finite() && *size > 0.0);
    size.map(|size| (size * factor).to_radians())
        .ok_or_else(|| format!("'{text}' is no size; allowed: a number above 0 with \", ' or d"))
}

fn angle_rad(text: &str) -> Result<f64, String> {
    let angle: Option<f64> = text.trim_end_matches('d').parse().ok().filter(|angle: &f64| angle.is_finite());
    angle.map(f64::to_radians).ok_or_else(|| format!("'{text}' is no angle; allowed: degrees"))
}

/// DS9 measures angles of sky regions from the axis of growing x of an image with north up and east left: towards the west, anticlockwise over north.
fn moved(from: &Direction<Gcrs>, west_rad: f64, north_rad: f64) -> Direction<Gcrs> {
    let (east, north) = from.east_north();
    let moved: Vector3<f64> = from.vector() - east * west_rad.tan() + north * north_rad.tan();
    Direction::from_vector(moved.normalize())
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
        // A vector of angle 90° leads north.
        let [from, to] = [outlines[3][0], outlines[3][1]];
        assert!(from.position_angle_rad(&to).sin().abs() < 1e-6, "{}", from.position_angle_rad(&to));
        assert!(to.latitude_rad() > from.latitude_rad());
        assert!((from.separation_rad(&to).to_degrees() * 3600.0 - 60.0).abs() < 1e-3);
        // The long side of the box leads, turned by 30° anticlockwise, 30° from north to east.
        let angle_deg = outlines[2][1].position_angle_rad(&outlines[2][2]).to_degrees();
        assert!((angle_deg - 30.0).abs() < 0.01, "{angle_deg}");
    }

    #[test]
    fn what_is_not_read_is_told_with_its_line() {
        let said = |body: &str| parse_regions("a.reg", &format!("{HEAD}{body}")).unwrap_err().to_string();
        assert!(said("circle(1,2,3\")").starts_with("a.reg: line 4: 'circle' is not read"));
        assert!(said("polygon(1,2,3)").contains("polygon of 3 numbers"));
        assert!(said("line(400,2,3,4)").contains("\"400\" is not a right ascension"));
        assert!(said("box(1,2,x,3)").contains("'x' is no size"));
        assert!(said("image\nline(1,2,3,4)").starts_with("a.reg: line 5: coordinates are image"));
        assert!(said("-line(1,2,3,4)").contains("'-line' is not read"));
        assert_eq!(said(""), format!("a.reg: no region in it; {ALLOWED}"));
        let bare = parse_regions("a.reg", "line(1,2,3,4)").unwrap_err().to_string();
        assert!(bare.contains("before any system"), "{bare}");
    }
}
