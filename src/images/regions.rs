//! Regions of SAOImage DS9: boxes, polygons, lines and vectors on the sky or in pixels of a frame.
//!
//! Format (DS9 reference manual, "Regions"): a coordinate system (`image`, `physical`, `fk5`, `j2000`, `icrs`), then shapes with
//! their numbers in brackets or after blanks, separated by commas or blanks. Each shape is in the last system above it.
//! `;` separates statements, `#` starts a comment, `global` lines are ignored; an excluded shape (`-`) is an error. DS9
//! saves vectors, projections and segments behind `#`, because other programs do not know them; vectors, projections (a
//! line) and segments of two points are read. FK5 of equinox 2000 is read as ICRS: they differ by 0.02 arcsec. Pixels
//! are counted from 1, and sizes in `image` and `physical` are pixels. Physical pixels are those of the frame before it was cut or
//! binned ([`PixelPosition::of_physical`]).

use nalgebra::Vector3;

use super::pixels::PixelPosition;
use crate::error::Error;
use crate::frames::{Direction, Gcrs, parse_declination_deg, parse_right_ascension_deg};

const SKY_SYSTEMS: [&str; 3] = ["fk5", "j2000", "icrs"];
/// Coordinate systems of DS9 that are recognised but not supported.
const OTHER_SYSTEMS: [&str; 9] =
    ["linear", "amplifier", "detector", "fk4", "b1950", "galactic", "ecliptic", "wcs", "wcsa"];
/// Shapes that a caller uses, for errors: regions around a streak, and streaks.
pub const OUTLINES: &str = "polygon, box, line and vector";
#[cfg(all(feature = "fits", unix))]
pub(super) const STREAKS: &str = "line, vector, segment and projection";
/// Shapes that DS9 writes as comments.
const COMMENTED: [&str; 3] = ["vector", "projection", "segment"];

/// Region of a file: the corners of a polygon or box, or the two ends of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Line in the file, from 1.
    pub line: usize,
    /// Text at the region; empty if it has none.
    pub name: String,
    /// Corners or ends.
    pub outline: Outline,
}

/// Corners or ends of a region.
#[derive(Clone, Debug, PartialEq)]
pub enum Outline {
    /// Positions in a frame.
    Pixels(Vec<PixelPosition>),
    /// Positions in physical pixels.
    Physical(Vec<PixelPosition>),
    /// ICRS directions.
    Sky(Vec<Direction<Gcrs>>),
}

/// Coordinate system of a shape.
#[derive(Copy, Clone)]
enum System {
    Image,
    Physical,
    Sky,
}

/// Returns true for the name of a coordinate system of DS9.
#[cfg(all(feature = "fits", unix))]
pub(super) fn is_region_system(text: &str) -> bool {
    let name = text.to_ascii_lowercase();
    ["image", "physical"].contains(&name.as_str())
        || SKY_SYSTEMS.contains(&name.as_str())
        || OTHER_SYSTEMS.contains(&name.as_str())
}

/// Parses a region file; `path` is its name in errors, and `shapes` are the accepted ones in their words.
///
/// # Errors
/// A line has another coordinate system or shape, or invalid numbers.
pub fn parse_regions(path: &str, text: &str, shapes: &str) -> Result<Vec<Region>, Error> {
    let allowed = format!("allowed: {shapes} in fk5, icrs, image or physical");
    let mut regions = Vec::new();
    let mut system: Option<Result<System, String>> = None;
    for (number, line) in text.lines().enumerate() {
        let fail = |problem: String| Error::format(problem).in_line("", path, number + 1);
        for statement in statements_of(line) {
            let lower = statement.to_ascii_lowercase();
            if lower.starts_with("global") {
                continue;
            }
            let named = match lower.as_str() {
                "image" => Some(Ok(System::Image)),
                "physical" => Some(Ok(System::Physical)),
                name if SKY_SYSTEMS.contains(&name) => Some(Ok(System::Sky)),
                name if OTHER_SYSTEMS.contains(&name) => Some(Err(lower.clone())),
                _ => None,
            };
            if named.is_some() {
                system = named;
                continue;
            }
            let system = match &system {
                Some(Ok(known)) => *known,
                Some(Err(other)) => {
                    return Err(fail(format!(
                        "unsupported coordinate system {other}; {allowed} (in DS9, save the regions as fk5 in degrees)"
                    )));
                }
                None => return Err(fail(format!("'{statement}' has no preceding coordinate system; {allowed}"))),
            };
            let outline = outline(statement, system, &allowed).map_err(fail)?;
            regions.push(Region { line: number + 1, name: name_of(line).to_owned(), outline });
        }
    }
    Ok(regions)
}

/// Returns the statements of a line without its comment. A comment at the beginning of a statement that is a shape of
/// DS9 is a statement; `xpaget ds9 regions -strip yes` writes all regions in one line, as `fk5;# vector(...)
/// vector=1;`.
fn statements_of(line: &str) -> Vec<&str> {
    let mut statements = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() {
        let (statement, after) = if let Some(comment) = rest.strip_prefix('#') {
            let shape = comment.trim_start();
            if !COMMENTED.iter().any(|name| is_shape(shape, name)) {
                break;
            }
            let (shape, properties) = shape.split_at(shape.find(')').map_or(shape.len(), |at| at + 1));
            // A text may contain semicolons.
            let next = properties.split_once(';').filter(|(before, _)| !before.contains(['{', '"', '\'']));
            (shape, next.map_or("", |(_, next)| next))
        } else {
            let end = rest.find([';', '#']).unwrap_or(rest.len());
            (&rest[..end], rest[end..].strip_prefix(';').unwrap_or_default())
        };
        if !statement.trim().is_empty() {
            statements.push(statement.trim());
        }
        rest = after.trim_start();
    }
    statements
}

/// Returns the text in the properties of a region.
fn name_of(line: &str) -> &str {
    let marks = [("text={", '}'), ("text=\"", '"'), ("text='", '\'')];
    let text = |(start, end): (&str, char)| line.split_once(start)?.1.split(end).next();
    marks.into_iter().find_map(text).unwrap_or_default()
}

/// Returns true if a text is a shape of this name with its numbers in brackets.
fn is_shape(text: &str, name: &str) -> bool {
    let head = text.get(..name.len()).is_some_and(|head| head.eq_ignore_ascii_case(name));
    head && text[name.len()..].trim_start().starts_with('(')
}

/// Returns the corners or ends of a shape.
fn outline(statement: &str, system: System, allowed: &str) -> Result<Outline, String> {
    let shape_end = statement.find(|mark: char| mark == '(' || mark.is_whitespace()).unwrap_or(statement.len());
    let (shape, rest) = statement.split_at(shape_end);
    let inside = rest.trim().trim_start_matches('(');
    let inside = inside.split(')').next().unwrap_or_default();
    let numbers: Vec<&str> =
        inside.split(|mark: char| mark == ',' || mark.is_whitespace()).filter(|number| !number.is_empty()).collect();
    let shape = shape.trim_start_matches('+').to_ascii_lowercase();
    match system {
        System::Image | System::Physical => {
            let outline = if matches!(system, System::Image) { Outline::Pixels } else { Outline::Physical };
            corners(&shape, &numbers, pixel, length_pix, moved_pix).map(|corners| corners.map(outline))
        }
        System::Sky => corners(&shape, &numbers, position, size_rad, moved).map(|corners| corners.map(Outline::Sky)),
    }?
    .ok_or_else(|| format!("unsupported shape '{shape}'; {allowed}"))
}

/// Returns the corners or ends of a shape, `None` for an unknown one, in a coordinate system, which `position`, `size`
/// and `moved` define.
fn corners<P>(
    shape: &str,
    numbers: &[&str],
    position: fn(&str, &str) -> Result<P, String>,
    size: fn(&str) -> Result<f64, String>,
    moved: fn(&P, f64, f64) -> P,
) -> Result<Option<Vec<P>>, String> {
    let wrong_count = |count: &str| format!("{shape} has {} numbers; allowed: {count}", numbers.len());
    let corners = match shape {
        "polygon" if numbers.len() >= 4 && numbers.len().is_multiple_of(2) => {
            numbers.chunks(2).map(|pair| position(pair[0], pair[1])).collect()
        }
        "polygon" => Err(wrong_count("two or more pairs of coordinates")),
        "segment" if numbers.len() != 4 => Err(wrong_count("4: the positions of two points")),
        // A projection also has a width.
        "line" | "projection" | "segment" if numbers.len() >= 4 => {
            numbers[..4].chunks(2).map(|pair| position(pair[0], pair[1])).collect()
        }
        "line" | "projection" => Err(wrong_count("4: the positions of both ends")),
        "vector" if numbers.len() == 4 => {
            let (from, length, angle) = (position(numbers[0], numbers[1])?, size(numbers[2])?, angle_rad(numbers[3])?);
            let to = moved(&from, length * angle.cos(), length * angle.sin());
            Ok(vec![from, to])
        }
        "vector" => Err(wrong_count("4: a position, a length and an angle")),
        "box" if numbers.len() == 4 || numbers.len() == 5 => {
            let centre = position(numbers[0], numbers[1])?;
            let (width, height) = (0.5 * size(numbers[2])?, 0.5 * size(numbers[3])?);
            let (sin, cos) = numbers.get(4).map_or(Ok(0.0), |angle| angle_rad(angle))?.sin_cos();
            let corners = [(-width, -height), (width, -height), (width, height), (-width, height)];
            Ok(corners.map(|(x, y)| moved(&centre, x * cos - y * sin, x * sin + y * cos)).into())
        }
        "box" => Err(wrong_count("4 or 5: a position, a width, a height, and an angle")),
        _ => return Ok(None),
    };
    corners.map(Some)
}

fn pixel(x: &str, y: &str) -> Result<PixelPosition, String> {
    let number = |text: &str| {
        let number = text.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or_else(|| format!("invalid pixel '{text}'; allowed: a number, counted from 1"))
    };
    Ok(PixelPosition::from_fits(number(x)?, number(y)?))
}

/// Parses a size in `image`: a number of pixels.
fn length_pix(text: &str) -> Result<f64, String> {
    let length = text.parse().ok().filter(|length: &f64| length.is_finite() && *length > 0.0);
    length.ok_or_else(|| format!("invalid size '{text}'; allowed: a number of pixels above 0"))
}

fn moved_pix(from: &PixelPosition, x: f64, y: f64) -> PixelPosition {
    PixelPosition { x: from.x + x, y: from.y + y }
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

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# Region file format: DS9 version 4.1\nglobal color=green dashlist=8 3\nfk5\n";

    /// Returns the corners of regions on the sky.
    fn on_sky(text: &str) -> Vec<Vec<Direction<Gcrs>>> {
        let regions = parse_regions("a.reg", text, OUTLINES).unwrap().into_iter();
        let corners = regions.map(|region| match region.outline {
            Outline::Sky(corners) => corners,
            pixels => panic!("{pixels:?}"),
        });
        corners.collect()
    }

    #[test]
    fn shapes_of_ds9() {
        let text = format!(
            "{HEAD}polygon(232.0174027,8.9284745,232.0161734,8.9252280,232.0695267,8.9023292)\n\
             line(15:28:04.2,+8:55:42,15:28:16.7,+8:54:08) # line=0 0\nbox 232 9 20\" 2' 30; vector(232,9,60\",90)\n"
        );
        let outlines = on_sky(&text);
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
        let outlines = on_sky(&text);
        assert_eq!(outlines.iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2]);
        assert_eq!(outlines[0], on_sky(&format!("{HEAD}vector(232,9,60\",90)"))[0]);
        // `xpaget ds9 regions -strip yes` writes one line.
        for line in
            ["fk5;# vector(232,9,60\",90) vector=1", "fk5;line(1,2,3,4);# vector(232,9,60\",90) vector=1;box(1,2,3,4)"]
        {
            assert!(on_sky(line).contains(&outlines[0]), "{line}");
            assert_eq!(on_sky(line).len(), line.matches('(').count(), "{line}");
        }
        let message = parse_regions("a.reg", &format!("{HEAD}# vector(232,9)\n"), OUTLINES).unwrap_err().to_string();
        assert!(message.starts_with("a.reg: line 4: vector has 2 numbers"), "{message}");
    }

    #[test]
    fn unsupported_statements_are_reported_with_their_line() {
        let message = |body: &str| parse_regions("a.reg", &format!("{HEAD}{body}"), OUTLINES).unwrap_err().to_string();
        assert!(message("circle(1,2,3\")").starts_with("a.reg: line 4: unsupported shape 'circle'"));
        assert!(message("polygon(1,2,3)").contains("polygon has 3 numbers"));
        assert!(message("line(400,2,3,4)").contains("\"400\" is not a right ascension"));
        assert!(message("box(1,2,x,3)").contains("invalid size 'x'"));
        assert!(
            message("amplifier\nline(1,2,3,4)").starts_with("a.reg: line 5: unsupported coordinate system amplifier")
        );
        assert!(message("image\nline(1,2,3,x)").contains("invalid pixel 'x'"));
        assert!(message("image\nvector(1,2,3\",4)").contains("invalid size '3\"'; allowed: a number of pixels"));
        assert!(message("-line(1,2,3,4)").contains("unsupported shape '-line'"));
        let bare = parse_regions("a.reg", "line(1,2,3,4)", OUTLINES).unwrap_err().to_string();
        assert!(bare.contains("has no preceding coordinate system"), "{bare}");
    }

    /// Each shape is in the last system above it, and has its line and its text.
    #[test]
    fn pixels_and_sky_in_one_file() {
        let text = format!(
            "{HEAD}image;line(1,2,3.5,4) # text={{a;b #3}}\n# vector(10,20,5,90) vector=1 text='two'\n\
             icrs\nline(10,20,11,21)\nimage\nbox(5,5,4,2,90)\nphysical;# vector(10,20,5,90) vector=1\n"
        );
        let regions = parse_regions("a.reg", &text, OUTLINES).unwrap();
        let of = |region: &Region| (region.line, region.name.clone());
        let expected =
            [(4, "a;b #3"), (5, "two"), (7, ""), (9, ""), (10, "")].map(|(line, name)| (line, name.to_owned()));
        assert_eq!(regions.iter().map(of).collect::<Vec<_>>(), expected);
        let pixels = |index: usize| match &regions[index].outline {
            Outline::Pixels(corners) => corners.iter().map(|corner| corner.fits()).collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        };
        assert_eq!(pixels(0), [[1.0, 2.0], [3.5, 4.0]]);
        let [x, y] = pixels(1)[1];
        assert!((x - 10.0).abs() < 1e-9 && (y - 25.0).abs() < 1e-9, "{x} {y}");
        let [x, y] = pixels(3)[0];
        assert!((x - 6.0).abs() < 1e-9 && (y - 3.0).abs() < 1e-9, "{x} {y}");
        assert!(matches!(&regions[2].outline, Outline::Sky(ends) if ends.len() == 2));
        let Outline::Physical(ends) = &regions[4].outline else { panic!("{:?}", regions[4]) };
        assert_eq!(ends[0].fits(), [10.0, 20.0]);
    }
}
