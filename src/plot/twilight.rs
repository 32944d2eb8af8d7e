//! Day, the three twilights and night as bands behind a chart.

use plotters::prelude::RGBColor;
use plotters::style::Color;

use super::axes::Frame;
use super::picture::Picture;

/// A band: the Sun stands above this, degrees; what it is called; its paint. Dark bands for a light sky would hide what is drawn over them: the
/// brighter the sky, the more of a warm grey.
const BANDS: [(f64, &str, RGBColor); 4] = [
    (-0.833, "day", RGBColor(250, 214, 140)),
    (-6.0, "civil", RGBColor(251, 228, 180)),
    (-12.0, "nautical", RGBColor(253, 239, 212)),
    (-18.0, "astronomical twilight", RGBColor(254, 248, 236)),
];

/// Which band an altitude of the Sun lies in; `None` at night.
fn band(altitude_deg: f64) -> Option<usize> {
    BANDS.iter().position(|(least, ..)| altitude_deg > *least)
}

/// Bands between moments of the x axis at which the Sun's altitude, degrees, is known; between them it goes straight. Says which bands there are.
pub(super) fn bands_in_time(picture: &mut Picture, frame: &Frame, sun: &[(f64, f64)]) -> Vec<usize> {
    let mut shown = Vec::new();
    for pair in sun.windows(2) {
        let ((from, first), (to, last)) = (pair[0], pair[1]);
        // Where the altitude goes through a band's border, the stretch is cut.
        let mut cuts = vec![from, to];
        for (border, ..) in BANDS {
            let share = (border - first) / (last - first);
            if share > 0.0 && share < 1.0 {
                cuts.push(from + share * (to - from));
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for cut in cuts.windows(2) {
            let middle = (cut[0] + cut[1]) / 2.0;
            let altitude = first + (last - first) * (middle - from) / (to - from);
            paint(picture, frame, [cut[0], cut[1]], altitude, &mut shown);
        }
    }
    shown.sort_unstable();
    shown
}

/// Bands of an x axis that is the Sun's altitude itself, degrees.
pub(super) fn bands_in_altitude(picture: &mut Picture, frame: &Frame) -> Vec<usize> {
    let mut shown = Vec::new();
    let mut upper = 90.0;
    for (border, ..) in BANDS {
        paint(picture, frame, [upper, border], (upper + border) / 2.0, &mut shown);
        upper = border;
    }
    shown
}

fn paint(picture: &mut Picture, frame: &Frame, [from, to]: [f64; 2], altitude_deg: f64, shown: &mut Vec<usize>) {
    let (Some(band), [_, top, _, bottom]) = (band(altitude_deg), frame.sides) else { return };
    let (left, right) = (frame.at(from, frame.y.from).0, frame.at(to, frame.y.from).0);
    if (right - left).abs() > 1e-6 {
        picture.rectangle([left.min(right), top, left.max(right), bottom], BANDS[band].2.to_rgba());
        if !shown.contains(&band) {
            shown.push(band);
        }
    }
}

/// The bands that were shown, side by side; says where the next sign may begin.
pub(super) fn legend(picture: &mut Picture, shown: &[usize], mut x: f64, y: f64) -> f64 {
    for &band in shown {
        let (_, words, colour) = BANDS[band];
        picture.rectangle([x, y - 8.0, x + 24.0, y + 8.0], colour.to_rgba());
        picture.border([x, y - 8.0, x + 24.0, y + 8.0], 1.0);
        x = picture.words(words, x + 31.0, y) - 8.0;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::super::axes::Axis;
    use super::*;

    #[test]
    fn verif_twilights_begin_where_they_are_defined() {
        let of = |altitude: f64| band(altitude).map(|band| BANDS[band].1);
        assert_eq!(
            [1.0, -0.84, -5.99, -6.01, -12.01, -18.01].map(of),
            [Some("day"), Some("civil"), Some("civil"), Some("nautical"), Some("astronomical twilight"), None]
        );
        let frame = Frame { sides: [0.0, 0.0, 100.0, 50.0], x: Axis::linear(0.0, 1.0), y: Axis::linear(0.0, 1.0) };
        let mut picture = Picture::new(100, 50);
        assert_eq!(bands_in_time(&mut picture, &frame, &[(0.0, -10.0), (1.0, -20.0)]), [2, 3]);
        let bytes = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgb8();
        // Nautical to −12°, a fifth of the way; night from −18° on.
        let colours = [10, 30, 90].map(|x| bytes.get_pixel(x, 25).0);
        assert_eq!(colours, [[253, 239, 212], [254, 248, 236], [255, 255, 255]]);
    }
}
