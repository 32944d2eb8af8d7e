//! Chart of a field with the streaks that cross it, in gnomonic projection with north up and east left.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame, colour_bar};
use super::graticule::{self, Plane, gnomonic};
use super::labels::Labels;
use super::numbers::{fixed, many};
use super::picture::{INK, Picture, width_of};
use super::scale::{ColourScale, Quantity};
use super::tracks::{MOST_LISTED, arrow, by_brightness, list, magnitude_text, numbers, time_of_day, without_numbers};
use crate::error::{Error, ErrorKind};

const WIDTH: f64 = 1440.0;
const SIDES: [f64; 4] = [92.0, 72.0, 772.0, 752.0];
const BAR_LEFT: f64 = 796.0;
const LIST_LEFT: f64 = 912.0;
const OUTLINE: RGBColor = RGBColor(60, 60, 60);
const DARK: RGBColor = RGBColor(150, 150, 150);
const INSIDE: RGBColor = RGBColor(240, 240, 240);

/// A field and the streaks that cross it.
#[derive(Clone, Debug)]
pub struct FieldChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Text that follows the caption of the chart.
    pub caption: &'a str,
    /// Right ascension of the centre, degrees.
    pub ra_deg: f64,
    /// Declination of the centre, degrees.
    pub dec_deg: f64,
    /// Outlines of the field, each closed implicitly. Corners are right ascension and declination, degrees, so close
    /// that they can be joined by straight lines.
    pub outlines: &'a [Vec<[f64; 2]>],
    /// Streaks in the field.
    pub streaks: &'a [FieldStreak],
}

/// One streak of a field chart.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldStreak {
    /// Name of the satellite.
    pub name: String,
    /// Two or more points from entry to exit: right ascension and declination, degrees.
    pub track_deg: Vec<[f64; 2]>,
    /// Entry, MJD (UTC); NaN if unknown.
    pub enter_mjd: f64,
    /// Exit, MJD (UTC); NaN if unknown.
    pub exit_mjd: f64,
    /// Brightest magnitude along the streak; NaN if unknown.
    pub magnitude: f64,
    /// Uncertainty of the magnitude (one sigma), mag; NaN if unknown.
    pub sigma_mag: f64,
}

/// Draws the outlines of the field on the tangent plane with lines of right ascension and declination, and every streak
/// in the colour of its magnitude with an arrow at its exit, the brightest on top. A list gives entry, exit and
/// magnitude of the streaks, the brightest first; listed streaks are numbered in the chart where a number covers no
/// streak. If there are too many streaks for the list, its last line gives the number of omitted streaks. The caption
/// gives the number of listed streaks that have no number in the chart.
///
/// The chart covers the outlines or, if there are none, the streaks. A field without streaks must have an outline, and
/// is drawn with a note.
///
/// # Errors
/// There are neither outlines nor streaks; a streak has fewer than two points; or a position is invalid or more than
/// 75° from the centre.
pub fn field_chart(input: &FieldChart<'_>) -> Result<Picture, Error> {
    let out = |what: &str, given: String, allowed| Error::invalid(what, given, allowed);
    let is_position = |[ra, dec]: [f64; 2]| ra.is_finite() && (-90.0..=90.0).contains(&dec);
    let centre = [input.ra_deg, input.dec_deg];
    if !is_position(centre) {
        return Err(out("the centre of the field", format!("{centre:?}"), "right ascension and declination, degrees"));
    }
    if input.outlines.is_empty() && input.streaks.is_empty() {
        return Err(Error::new(ErrorKind::TooFewData, "nothing to draw: no streaks and no outline of the field"));
    }
    let project = |position: [f64; 2]| {
        let far = || out("a position of the chart", format!("{position:?} deg"), "at most 75° from the centre");
        if is_position(position) { gnomonic(centre, position).ok_or_else(far) } else { Err(far()) }
    };
    let outlines = (input.outlines.iter())
        .map(|outline| outline.iter().map(|position| project(*position)).collect::<Result<Vec<_>, _>>())
        .collect::<Result<Vec<_>, _>>()?;
    let order = by_brightness(input.streaks.iter().map(|streak| streak.magnitude));
    let streaks: Vec<&FieldStreak> = order.into_iter().map(|number| &input.streaks[number]).collect();
    let tracks = (streaks.iter())
        .map(|streak| streak.track_deg.iter().map(|position| project(*position)).collect::<Result<Vec<_>, _>>())
        .collect::<Result<Vec<_>, _>>()?;
    if let Some(short) = streaks.iter().find(|streak| streak.track_deg.len() < 2) {
        return Err(Error::new(
            ErrorKind::TooFewData,
            format!("nothing to draw: no two points of the track of {}", short.name),
        ));
    }
    let sized = if outlines.is_empty() { &tracks } else { &outlines };
    let reach = sized.iter().flatten().map(|[x, y]| x.abs().max(y.abs())).fold(1e-5, f64::max) * 1.1;
    let (unit, per_degree) = match reach {
        reach if reach >= 1.0 => ("°", 1.0),
        reach if reach >= 1.0 / 60.0 => ("′", 60.0),
        _ => ("″", 3600.0),
    };
    let half = reach * per_degree;
    let frame = Frame { sides: SIDES, x: Axis::linear(half, -half), y: Axis::linear(-half, half) };
    let at = |[x, y]: [f64; 2]| frame.at(x * per_degree, y * per_degree);
    let plane = Plane { centre, reach, at: &at, sides: SIDES };

    let mut picture = Picture::new(WIDTH as usize, 846);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    let borders: Vec<Vec<(f64, f64)>> = outlines
        .iter()
        .map(|outline| outline.iter().chain(outline.first()).map(|position| at(*position)).collect())
        .collect();
    borders.iter().for_each(|border: &Vec<_>| picture.patch(border.clone(), INSIDE.to_rgba()));
    graticule::draw(&mut picture, &plane);
    borders.iter().for_each(|border| picture.line(border, OUTLINE.to_rgba(), 1.6));
    let (x, y) = at([0.0, 0.0]);
    picture.line(&[(x - 7.0, y), (x + 7.0, y)], INK.mix(0.6), 1.2);
    picture.line(&[(x, y - 7.0), (x, y + 7.0)], INK.mix(0.6), 1.2);
    let mut labels = Labels::new([SIDES[0] + 3.0, SIDES[1] + 3.0, SIDES[2] - 3.0, SIDES[3] - 3.0]);
    labels.add_box(compass(&mut picture));
    labels.add_box(scale_bar(&mut picture, &frame, unit));
    let magnitudes = || streaks.iter().map(|streak| streak.magnitude).filter(|magnitude| magnitude.is_finite());
    let scale = ColourScale::from_values(Quantity::Magnitude, magnitudes());
    let colour = |streak: &FieldStreak| match streak.magnitude.is_finite() {
        true => {
            let [red, green, blue] = scale.colour(streak.magnitude);
            RGBColor(red, green, blue)
        }
        false => DARK,
    };
    let lines: Vec<Vec<(f64, f64)>> =
        tracks.iter().map(|track| track.iter().map(|position| at(*position)).collect()).collect();
    // The brightest streaks are drawn last, over the others.
    for (streak, line) in streaks.iter().zip(&lines).rev() {
        picture.line(line, INK.to_rgba(), 5.0);
        picture.line(line, colour(streak).to_rgba(), 3.4);
        arrow(&mut picture, line, colour(streak));
    }
    lines.iter().enumerate().for_each(|(number, line)| labels.add_line(number, line));
    let listed: Vec<usize> = (0..lines.len().min(MOST_LISTED)).collect();
    let without = numbers(&mut picture, &mut labels, &lines, &listed);
    graticule::label(&mut picture, &plane, &mut labels);
    picture.border(SIDES, 1.4);
    frame.name_x(&mut picture, "right ascension (ICRS)");
    frame.name_y(&mut picture, "declination (ICRS)", 44.0);
    if input.streaks.is_empty() {
        picture.note("no streak crosses this field", ((SIDES[0] + SIDES[2]) / 2.0, (SIDES[1] + SIDES[3]) / 2.0 + 60.0));
    }
    if magnitudes().next().is_some() {
        let sides = [BAR_LEFT, SIDES[1] + 40.0, BAR_LEFT + 24.0, SIDES[3] - 40.0];
        colour_bar(&mut picture, &scale, sides, &scale.label());
    }
    if !input.streaks.is_empty() {
        let listed = |streak: &&FieldStreak| {
            let [enter, exit] = [streak.enter_mjd, streak.exit_mjd].map(|mjd| time_of_day(mjd, 1));
            vec![streak.name.clone(), enter, exit, magnitude_text(streak.magnitude, streak.sigma_mag)]
        };
        let rows: Vec<Vec<String>> = streaks.iter().map(listed).collect();
        let columns = [("satellite", 28.0), ("enter UTC", 246.0), ("exit UTC", 339.0), ("mag", 432.0)];
        list(&mut picture, [LIST_LEFT, WIDTH - 20.0], SIDES[1] + 10.0, &columns, &rows);
    }
    picture.set_scales(vec![scale]);
    let caption = format!(
        "Centre RA {:.4}°, Dec {}°, ICRS; gnomonic (TAN), north up, east left. {}, {} with a magnitude: the brightest along each track. {}{}",
        input.ra_deg,
        fixed(input.dec_deg, 4),
        many(streaks.len(), "streak", "streaks"),
        magnitudes().count(),
        without_numbers(without),
        input.caption
    );
    picture.paragraph(caption.trim_end(), [SIDES[0], WIDTH - 24.0], 816.0, 16.0);
    Ok(picture)
}

/// Draws a compass in the upper right corner: north up, east left. Returns its sides.
fn compass(picture: &mut Picture) -> [f64; 4] {
    let (x, y) = (SIDES[2] - 26.0, SIDES[1] + 72.0);
    for (tip, text, position) in [((x, y - 42.0), "N", (x, y - 54.0)), ((x - 42.0, y), "E", (x - 54.0, y))] {
        picture.line(&[(x, y), tip], INK.to_rgba(), 2.0);
        let (across, up) = ((tip.0 - x) / 42.0, (tip.1 - y) / 42.0);
        let side = |back: f64, side: f64| (tip.0 - back * across - side * up, tip.1 - back * up + side * across);
        picture.patch(vec![tip, side(9.0, 4.0), side(9.0, -4.0)], INK.to_rgba());
        picture.text(text, position, 17.0, HPos::Center);
    }
    [x - 64.0, y - 64.0, x + 6.0, y + 6.0]
}

/// Draws a scale bar of a round length in the lower left corner. Its length is exact in the middle of the chart.
/// Returns its sides.
fn scale_bar(picture: &mut Picture, frame: &Frame, unit: &str) -> [f64; 4] {
    let whole = (frame.x.from - frame.x.to).abs();
    let decade = 10_f64.powf((0.3 * whole).log10().floor());
    let length = [5.0, 2.0, 1.0].map(|step| step * decade).into_iter().find(|length| *length <= 0.3 * whole);
    let length = length.unwrap_or(decade);
    let pixels = length / whole * frame.width();
    let (x, y) = (SIDES[0] + 20.0, SIDES[3] - 20.0);
    let text = format!("{length}{unit}");
    let sides = [x - 8.0, y - 30.0, x + pixels.max(width_of(&text, 16.0)) + 8.0, y + 8.0];
    picture.rectangle(sides, RGBColor(255, 255, 255).mix(0.8));
    picture.line(&[(x, y), (x + pixels, y)], INK.to_rgba(), 3.0);
    for end in [x, x + pixels] {
        picture.line(&[(end, y - 5.0), (end, y + 5.0)], INK.to_rgba(), 1.6);
    }
    picture.text(&text, (x + pixels / 2.0, y - 17.0), 16.0, HPos::Center);
    sides
}

#[cfg(test)]
mod tests {
    use super::super::graticule::inverse_gnomonic;
    use super::*;

    /// Centre and position, both in degrees, and degrees of the plane: astropy 8.0.2, `WCS` with `RA---TAN`,
    /// `DEC--TAN`, cdelt 1, `wcs_world2pix`, 2026-11-22.
    const TAN: &[[[f64; 2]; 3]] = &[
        [[10.0, 20.0], [11.5, 21.0], [1.400_845_158_4, 1.006_674_328_3]],
        [[350.2, -89.9], [200.0, -89.5], [-0.248_496_951_4, -0.533_900_899_2]],
        [[0.1, 45.0], [359.2, 44.0], [-0.647_518_449_7, -0.996_568_187_5]],
        [[188.5, -30.5], [190.1, -28.9], [1.401_519_814_4, 1.590_954_421_9]],
        [[30.0, 0.0], [75.0, 35.0], [57.295_779_513_1, 56.736_744_421_2]],
    ];

    #[test]
    fn valid_the_plane_is_that_of_tan() {
        for [centre, position, plane] in TAN {
            let projected = gnomonic(*centre, *position).unwrap();
            assert!(
                (0..2).all(|k| (projected[k] - plane[k]).abs() < 1e-9),
                "{centre:?} {position:?}: {projected:?} {plane:?}"
            );
            let [east, dec] = inverse_gnomonic(*centre, *plane);
            let turn = (centre[0] + east - position[0] + 180.0).rem_euclid(360.0) - 180.0;
            assert!(turn.abs() < 1e-7 && (dec - position[1]).abs() < 1e-9, "{plane:?}: {east} {dec}");
        }
        // Behind the tangent plane, and more than 75 degrees from the centre.
        assert!(gnomonic([0.0, 0.0], [180.0, 0.0]).is_none() && gnomonic([0.0, 0.0], [76.0, 0.0]).is_none());
    }
}
