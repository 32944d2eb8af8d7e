//! Lines of equal right ascension and declination on the tangent plane of a field chart, with labels.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::labels::{Labels, clipped};
use super::picture::{INK, Picture, half_size};

const LINE: RGBColor = RGBColor(120, 140, 170);
const LABEL_SIZE: f64 = 15.0;
/// Largest distance of points from the centre, degrees. Positions on the tangent plane diverge at 90 degrees.
pub const FARTHEST_FIELD_DEG: f64 = 75.0;

/// Number of steps along a line.
const STEPS: usize = 240;
/// Number of intervals that a chart should have in each direction.
const INTERVALS: f64 = 5.5;
/// Possible steps of right ascension, milliseconds of time.
const RA_STEPS_MS: [i64; 25] = [
    10, 20, 50, 100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 30_000, 60_000, 120_000, 300_000, 600_000,
    1_200_000, 1_800_000, 3_600_000, 7_200_000, 10_800_000, 14_400_000, 21_600_000, 43_200_000, 86_400_000,
];
/// Possible steps of declination, milliarcseconds.
const DEC_STEPS_MAS: [i64; 20] = [
    100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 30_000, 60_000, 120_000, 300_000, 600_000, 1_200_000,
    1_800_000, 3_600_000, 7_200_000, 18_000_000, 36_000_000, 72_000_000,
];
const MS_PER_DEGREE: f64 = 240_000.0;
const MAS_PER_DEGREE: f64 = 3_600_000.0;

/// Area of a chart on the tangent plane.
pub(super) struct Plane<'a> {
    /// Right ascension and declination of the tangent point, degrees.
    pub centre: [f64; 2],
    /// Largest distance from the tangent point to the east and to the north, degrees of the plane.
    pub reach: f64,
    /// Position in the picture of a point of the plane.
    pub at: &'a dyn Fn([f64; 2]) -> (f64, f64),
    /// Left, top, right and bottom of the chart in the picture.
    pub sides: [f64; 4],
}

/// A line of the grid: its parts inside the chart, in the picture, and its label.
struct GridLine {
    parts: Vec<[(f64, f64); 2]>,
    label: String,
    is_meridian: bool,
}

/// Draws the grid.
pub(super) fn draw(picture: &mut Picture, plane: &Plane<'_>) {
    for line in lines(plane) {
        for part in &line.parts {
            picture.line(part, LINE.mix(0.55), 1.0);
        }
    }
}

/// Draws the labels: right ascensions below, and declinations on the left. Lines that end elsewhere are labelled inside
/// the chart, where there is room.
pub(super) fn label(picture: &mut Picture, plane: &Plane<'_>, labels: &mut Labels) {
    let [left, _, right, bottom] = plane.sides;
    let mut outside = Labels::new([left - 40.0, 0.0, right + 40.0, bottom + 40.0]);
    for line in lines(plane) {
        let (width, height) = half_size(&line.label, LABEL_SIZE);
        let mut ends = line.parts.iter().flatten().copied();
        if line.is_meridian {
            if let Some((x, _)) = ends.find(|(_, y)| (y - bottom).abs() < 1e-6) {
                if let Some(position) = outside.place((width + 3.0, height), [(x, bottom + 16.0)]) {
                    picture.line(&[(x, bottom), (x, bottom + 5.0)], INK.to_rgba(), 1.2);
                    picture.text(&line.label, position, LABEL_SIZE, HPos::Center);
                }
                continue;
            }
        } else if let Some((_, y)) = ends.find(|(x, _)| (x - left).abs() < 1e-6) {
            // The text runs upwards.
            if let Some(position) = outside.place((height, width + 3.0), [(left - 16.0, y)]) {
                picture.line(&[(left, y), (left - 5.0, y)], INK.to_rgba(), 1.2);
                picture.upright(&line.label, position, LABEL_SIZE);
            }
            continue;
        }
        let middles = line.parts.iter().step_by(7).map(|[from, to]| ((from.0 + to.0) / 2.0, (from.1 + to.1) / 2.0));
        if let Some(position) = labels.place((width, height), middles) {
            picture.note_of(&line.label, position, LABEL_SIZE);
        }
    }
}

/// Returns the lines of the grid that cross the chart.
fn lines(plane: &Plane<'_>) -> Vec<GridLine> {
    let [ra0, dec0] = plane.centre;
    let reach = plane.reach;
    // Ranges of right ascension, relative to that of the centre, and of declination along the border of the chart.
    let border = (0..=64).flat_map(|part| {
        let along = reach * (f64::from(part) / 32.0 - 1.0);
        [[along, reach], [along, -reach], [reach, along], [-reach, along]]
    });
    let (mut ra, mut dec) = ([0.0_f64, 0.0_f64], [dec0, dec0]);
    for point in border {
        let [east, north] = inverse_gnomonic(plane.centre, point);
        ra = [ra[0].min(east), ra[1].max(east)];
        dec = [dec[0].min(north), dec[1].max(north)];
    }
    let has_pole =
        |pole: f64| gnomonic(plane.centre, [ra0, pole]).is_some_and(|[x, y]| x.abs() < reach && y.abs() < reach);
    for (pole, end) in [(90.0, 1), (-90.0, 0)] {
        if has_pole(pole) {
            dec[end] = pole;
            ra = [-180.0, 180.0];
        }
    }
    let step_of = |steps: &[i64], rough: f64| steps.iter().copied().find(|step| *step as f64 >= rough);
    let mut all = Vec::new();
    if let Some(step) = step_of(&RA_STEPS_MS, (ra[1] - ra[0]) / INTERVALS * MS_PER_DEGREE) {
        let number = |degrees: f64| (ra0 + degrees) * MS_PER_DEGREE / step as f64;
        let (first, last) = (number(ra[0]).ceil() as i64, number(ra[1]).floor() as i64);
        // The meridian of 180 degrees from the centre would be drawn twice.
        let last = if ra[1] - ra[0] >= 360.0 { first + 86_400_000 / step - 1 } else { last };
        for k in first..=last {
            let degrees = (k * step) as f64 / MS_PER_DEGREE;
            let point = |share: f64| [degrees, dec[0] + share * (dec[1] - dec[0])];
            all.push(GridLine { parts: parts(plane, point), label: ra_label(k * step, step), is_meridian: true });
        }
    }
    if let Some(step) = step_of(&DEC_STEPS_MAS, (dec[1] - dec[0]) / INTERVALS * MAS_PER_DEGREE) {
        let number = |degrees: f64| degrees * MAS_PER_DEGREE / step as f64;
        for k in number(dec[0]).ceil() as i64..=number(dec[1]).floor() as i64 {
            let degrees = (k * step) as f64 / MAS_PER_DEGREE;
            // The poles are points.
            if degrees.abs() < 90.0 {
                let point = |share: f64| [ra0 + ra[0] + share * (ra[1] - ra[0]), degrees];
                all.push(GridLine { parts: parts(plane, point), label: dec_label(k * step, step), is_meridian: false });
            }
        }
    }
    all
}

/// Returns the parts of a line inside the chart; `point` is the position on the sky at a fraction of the line, degrees.
fn parts(plane: &Plane<'_>, point: impl Fn(f64) -> [f64; 2]) -> Vec<[(f64, f64); 2]> {
    let reach = plane.reach;
    let at = |step: usize| gnomonic(plane.centre, point(step as f64 / STEPS as f64)).map(|[x, y]| (x, y));
    let inside = |step: usize| clipped(at(step)?, at(step + 1)?, [-reach, -reach, reach, reach]);
    (0..STEPS).filter_map(inside).map(|part| part.map(|(x, y)| (plane.at)([x, y]))).collect()
}

/// Formats a right ascension in milliseconds of time with the units that the step needs.
fn ra_label(ms: i64, step: i64) -> String {
    let ms = ms.rem_euclid(86_400_000);
    let (hours, minutes) = (ms / 3_600_000, ms / 60_000 % 60);
    match step {
        3_600_000.. => format!("{hours}h"),
        60_000.. => format!("{hours}h{minutes:02}m"),
        _ => format!("{hours}h{minutes:02}m{}s", seconds(ms % 60_000, step)),
    }
}

/// Formats a declination in milliarcseconds with the units that the step needs.
fn dec_label(mas: i64, step: i64) -> String {
    let sign = match mas {
        0 => "",
        1.. => "+",
        _ => "−",
    };
    let size = mas.abs();
    let (degrees, minutes) = (size / 3_600_000, size / 60_000 % 60);
    match step {
        3_600_000.. => format!("{sign}{degrees}°"),
        60_000.. => format!("{sign}{degrees}°{minutes:02}′"),
        _ => format!("{sign}{degrees}°{minutes:02}′{}″", seconds(size % 60_000, step)),
    }
}

/// Formats thousandths of a second with two digits and the decimals that the step needs.
fn seconds(thousandths: i64, step: i64) -> String {
    let whole = thousandths / 1000;
    match step {
        1000.. => format!("{whole:02}"),
        100.. => format!("{whole:02}.{}", thousandths % 1000 / 100),
        _ => format!("{whole:02}.{:02}", thousandths % 1000 / 10),
    }
}

/// Returns the position on the tangent plane, degrees, x to the east and y to the north; `None` if the direction is too
/// far from the centre.
///
/// cos c = sin δ₀ sin δ + cos δ₀ cos δ cos Δα; ξ = cos δ sin Δα / cos c;
/// η = (cos δ₀ sin δ − sin δ₀ cos δ cos Δα) / cos c (Calabretta & Greisen 2002, A&A 395, 1077, section 5.1.3,
/// in right ascension and declination).
pub(super) fn gnomonic([ra0, dec0]: [f64; 2], [ra, dec]: [f64; 2]) -> Option<[f64; 2]> {
    let ((sin0, cos0), (sin, cos)) = (dec0.to_radians().sin_cos(), dec.to_radians().sin_cos());
    let (sin_ra, cos_ra) = (ra - ra0).to_radians().sin_cos();
    let depth = sin0 * sin + cos0 * cos * cos_ra;
    let plane = [cos * sin_ra / depth, (cos0 * sin - sin0 * cos * cos_ra) / depth];
    (depth > FARTHEST_FIELD_DEG.to_radians().cos()).then(|| plane.map(f64::to_degrees))
}

/// Returns the right ascension minus that of the centre, -180 to 180 degrees, and the declination, degrees, of a point
/// of the tangent plane, degrees.
///
/// tan c = ρ = hypot(ξ, η); sin δ = cos c (sin δ₀ + η cos δ₀); tan Δα = ξ / (cos δ₀ − η sin δ₀)
pub(super) fn inverse_gnomonic([_, dec0]: [f64; 2], plane: [f64; 2]) -> [f64; 2] {
    let [xi, eta] = plane.map(f64::to_radians);
    let (sin0, cos0) = dec0.to_radians().sin_cos();
    let cos = 1.0 / (1.0 + xi * xi + eta * eta).sqrt();
    let sin_dec = cos * (sin0 + eta * cos0);
    [xi.atan2(cos0 - eta * sin0).to_degrees(), sin_dec.clamp(-1.0, 1.0).asin().to_degrees()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(centre: [f64; 2], reach: f64) -> Vec<GridLine> {
        let at = |[x, y]: [f64; 2]| (100.0 - 100.0 * x / reach, 100.0 - 100.0 * y / reach);
        lines(&Plane { centre, reach, at: &at, sides: [0.0, 0.0, 200.0, 200.0] })
    }

    #[test]
    fn verif_labels_of_positions() {
        assert_eq!(ra_label(-3_600_000, 3_600_000), "23h");
        assert_eq!(ra_label(47_760_000, 60_000), "13h16m");
        assert_eq!(ra_label(47_761_250, 50), "13h16m01.25s");
        assert_eq!(dec_label(-5_400_000, 600_000), "−1°30′");
        assert_eq!(dec_label(-1_800_000, 600_000), "−0°30′");
        assert_eq!((dec_label(0, 3_600_000), dec_label(27_000_500, 500)), ("0°".into(), "+7°30′00.5″".into()));
    }

    /// The lines lie at their coordinates: the plane is inverted at both ends of each part.
    #[test]
    fn valid_lines_have_the_coordinates_of_their_labels() {
        for (centre, reach) in [([198.9, 7.7], 2.0), ([0.1, -45.0], 0.3), ([359.9, 60.0], 5.0), ([10.0, 0.0], 30.0)] {
            let lines = found(centre, reach);
            for is_meridian in [true, false] {
                let n = lines.iter().filter(|line| line.is_meridian == is_meridian && !line.parts.is_empty()).count();
                assert!((2..=8).contains(&n), "{centre:?} {reach}: {n} lines");
            }
            for line in &lines {
                for (x, y) in line.parts.iter().flatten() {
                    let point = [(100.0 - x) / 100.0 * reach, (100.0 - y) / 100.0 * reach];
                    let [east, north] = inverse_gnomonic(centre, point);
                    let ms = ((centre[0] + east) * MS_PER_DEGREE).round() as i64;
                    let mas = (north * MAS_PER_DEGREE).round() as i64;
                    // Ends that are cut at the border lie on the chord of a step, not on the line itself.
                    let label = |step| if line.is_meridian { ra_label(ms, step) } else { dec_label(mas, step) };
                    let is_cut = [*x, *y].iter().any(|side| !(1e-6..=200.0 - 1e-6).contains(side));
                    let has_label = [60_000, 3_600_000].into_iter().any(|step| label(step) == line.label);
                    assert!(is_cut || has_label, "{}: {ms} {mas}", line.label);
                }
            }
        }
    }

    #[test]
    fn verif_a_pole_is_inside_its_circles() {
        let lines = found([30.0, 89.5], 2.0);
        let circles: Vec<&GridLine> = lines.iter().filter(|line| !line.is_meridian).collect();
        assert!(circles.iter().any(|line| line.label == "+89°" && line.parts.len() == STEPS), "a whole circle");
        let meridians = lines.iter().filter(|line| line.is_meridian && !line.parts.is_empty()).count();
        assert!((4..=8).contains(&meridians), "{meridians}");
    }
}
