//! Cuts of a frame along measured tracks, with the profiles across them.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::{Axis, Frame};
use super::error;
use super::numbers::count;
use super::picture::{INK, Picture, Pixels};
use super::statistics::{check, mad_sigma, sorted};
use crate::error::{Error, ErrorKind};
use crate::math::quantile::quantile;

const WIDTH: f64 = 1120.0;
/// Top of the first panel, its height, and the distance from one panel to the next.
const TOP: f64 = 112.0;
const HEIGHT: f64 = 150.0;
const PITCH: f64 = 236.0;
/// Left and right sides of the cuts and of the profiles.
const CUT: [f64; 2] = [80.0, 740.0];
const PROFILE: [f64; 2] = [830.0, 1096.0];
/// Largest number of tracks in a picture.
const MOST: usize = 12;
/// Pixels are white from `WHITE_SIGMAS` sigmas below the sky. They are black from `BLACK_SIGMAS` sigmas or
/// `BLACK_PEAKS` times the fitted peak above the sky, whichever is more, so that a streak is visible beside brighter
/// stars.
const WHITE_SIGMAS: f64 = 2.0;
const BLACK_SIGMAS: f64 = 6.0;
const BLACK_PEAKS: f64 = 1.2;
/// Share of the length at each end over which the predicted track is drawn, so that it does not hide the streak.
const PREDICTED_SHARE: f64 = 0.06;
const MODEL: RGBColor = RGBColor(213, 94, 0);
const PREDICTED: RGBColor = RGBColor(0, 114, 178);

/// Pixels along one track, and their profile across it.
#[derive(Clone, Debug)]
pub struct CutPanel<'a> {
    /// Title of the panel.
    pub title: &'a str,
    /// Number of columns along the track.
    pub columns: usize,
    /// Length of the track, pixels.
    pub length_pix: f64,
    /// Distances across the track, pixels, increasing; shape `(n_row)`.
    pub across_pix: &'a [f64],
    /// Values of the pixels, less the sky, row by row; NaN without pixels; shape `(n_row * columns)`.
    pub values: &'a [f64],
    /// Profile across the track; NaN without pixels; shape `(n_row)`.
    pub profile: &'a [f64],
    /// Errors (one sigma) of the profile; shape `(n_row)`.
    pub profile_sigma: &'a [f64],
    /// Fitted streak; shape `(n_row)`.
    pub model: &'a [f64],
    /// Distance of the predicted track from the measured track, pixels, with the sign of `across_pix`.
    pub predicted_pix: f64,
}

/// Draws a row for each track: at the left the pixels along the track, dark where they are bright, at the right the
/// profile across it with its errors and the fitted streak. Dashed lines are the predicted track, if it is within the
/// cut. A picture has at most twelve rows.
///
/// # Errors
/// There is no track, or columns differ in length.
pub fn streak_cuts(title: &str, panels: &[CutPanel<'_>]) -> Result<Picture, Error> {
    if panels.is_empty() {
        return Err(Error::new(ErrorKind::TooFewData, "nothing to draw: no tracks"));
    }
    for panel in panels {
        let rows = panel.across_pix.len();
        check("distances across the track", panel.across_pix)?;
        if panel.columns == 0 {
            return Err(Error::new(ErrorKind::TooFewData, "nothing to draw: no columns of the cut"));
        }
        for (what, column, expected) in [
            ("values of the cut", panel.values, rows * panel.columns),
            ("profile", panel.profile, rows),
            ("errors of the profile", panel.profile_sigma, rows),
            ("fitted streak", panel.model, rows),
        ] {
            if column.len() != expected {
                return Err(error::length(what, column.len(), expected));
            }
        }
    }
    let drawn = &panels[..panels.len().min(MOST)];
    let height = TOP + PITCH * drawn.len() as f64 + 10.0;
    let mut picture = Picture::new(WIDTH as usize, height as usize);
    picture.set_title(title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    for (index, panel) in drawn.iter().enumerate() {
        draw(&mut picture, panel, TOP + PITCH * index as f64);
    }
    let omitted = panels.len() - drawn.len();
    let more = if omitted > 0 { format!(" Not drawn: {} more.", count(omitted)) } else { String::new() };
    let has_predicted = drawn.iter().any(|panel| across_axis(panel).holds(panel.predicted_pix));
    let predicted = if has_predicted { " Blue, dashed: predicted track." } else { "" };
    let caption = format!("Orange: fitted streak.{predicted} Points: median along the track.{more}");
    picture.text(&caption, (CUT[0], height - 16.0), 16.0, HPos::Left);
    Ok(picture)
}

/// Returns the axis of distances across the track. A predicted track beyond its ends is not drawn.
fn across_axis(panel: &CutPanel<'_>) -> Axis {
    let across = panel.across_pix;
    Axis::linear(across[0] - 0.5, across[across.len() - 1] + 0.5)
}

fn draw(picture: &mut Picture, panel: &CutPanel<'_>, top: f64) {
    let rows = panel.across_pix.len();
    picture.text(panel.title, (CUT[0], top - 18.0), 17.0, HPos::Left);
    let across = across_axis(panel);
    let frame = Frame { sides: [CUT[0], top, CUT[1], top + HEIGHT], x: Axis::linear(0.0, panel.length_pix), y: across };
    let finite: Vec<f64> = panel.values.iter().copied().filter(|value| value.is_finite()).collect();
    if !finite.is_empty() {
        let (sky, sigma) = (quantile(&sorted(&finite), 0.5), mad_sigma(&finite));
        let peak = panel.model.iter().copied().filter(|value| value.is_finite()).fold(0.0, f64::max);
        let (white, black) = (sky - WHITE_SIGMAS * sigma, sky + (BLACK_SIGMAS * sigma).max(BLACK_PEAKS * peak));
        let grey = |value: f64| {
            let share = ((value - white) / (black - white).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            value.is_finite().then_some([(255.0 * (1.0 - share)) as u8; 3])
        };
        // The first row of the picture is the uppermost one, with the greatest distance.
        let colours =
            panel.values.chunks_exact(panel.columns).rev().flat_map(|row| row.iter().map(|value| grey(*value)));
        let each = (frame.width() / panel.columns as f64, frame.height() / rows as f64);
        let colours = colours.collect();
        picture.paint(Pixels { corner: (CUT[0], top), each, columns: panel.columns, colours, within: None });
    }
    if across.holds(panel.predicted_pix) {
        for [from, to] in [[0.0, PREDICTED_SHARE], [1.0 - PREDICTED_SHARE, 1.0]] {
            let line = [from, to].map(|share| frame.at(share * panel.length_pix, panel.predicted_pix));
            picture.dashed(&line, [6.0, 4.0], PREDICTED.to_rgba(), 2.0);
        }
    }
    frame.draw(picture, [true, true]);
    frame.name_x(picture, "along the track, pix");
    frame.name_y(picture, "across, pix", 54.0);

    let (mut least, mut most) = (0.0f64, 0.0f64);
    let is_finite = |row: &usize| panel.profile[*row].is_finite() && panel.profile_sigma[*row].is_finite();
    for row in (0..rows).filter(is_finite) {
        least = least.min(panel.profile[row] - panel.profile_sigma[row]);
        most = most.max(panel.profile[row] + panel.profile_sigma[row]);
    }
    let most = panel.model.iter().copied().filter(|value| value.is_finite()).fold(most, f64::max);
    let margin = 0.06 * (most - least);
    let y = Axis::linear(least - margin, most + margin);
    let frame = Frame { sides: [PROFILE[0], top, PROFILE[1], top + HEIGHT], x: across, y };
    picture.line(&[frame.at(across.from, 0.0), frame.at(across.to, 0.0)], INK.mix(0.4), 1.0);
    if across.holds(panel.predicted_pix) {
        let line = [frame.at(panel.predicted_pix, y.from), frame.at(panel.predicted_pix, y.to)];
        picture.dashed(&line, [6.0, 4.0], PREDICTED.to_rgba(), 1.5);
    }
    for row in (0..rows).filter(is_finite) {
        let (at, value, sigma) = (panel.across_pix[row], panel.profile[row], panel.profile_sigma[row]);
        picture.line(&[frame.at(at, value - sigma), frame.at(at, value + sigma)], INK.mix(0.6), 1.2);
        let (x, y) = frame.at(at, value);
        picture.rectangle([x - 1.6, y - 1.6, x + 1.6, y + 1.6], INK.to_rgba());
    }
    let fitted: Vec<(f64, f64)> = (0..rows)
        .filter(|row| panel.model[*row].is_finite())
        .map(|row| frame.at(panel.across_pix[row], panel.model[row]))
        .collect();
    picture.line(&fitted, MODEL.to_rgba(), 2.0);
    frame.draw(picture, [true, true]);
    frame.name_x(picture, "across, pix");
    frame.name_y(picture, "counts", 66.0);
}

#[cfg(test)]
mod tests {
    use super::super::PictureFormat;
    use super::*;

    const ACROSS: [f64; 3] = [-1.0, 0.0, 1.0];

    fn panel<'a>(values: &'a [f64], profile: &'a [f64]) -> CutPanel<'a> {
        CutPanel {
            title: "A",
            columns: 2,
            length_pix: 40.0,
            across_pix: &ACROSS,
            values,
            profile,
            profile_sigma: &[0.1; 3],
            model: &[0.0, 1.0, 0.0],
            predicted_pix: 0.5,
        }
    }

    #[test]
    fn verif_bright_pixels_are_dark_and_missing_ones_transparent() {
        let values = [0.0, f64::NAN, 2.0, 2.0, 0.0, 0.0];
        let profile = [0.0, 2.0, f64::NAN];
        let mut picture = Picture::new(WIDTH as usize, 400);
        draw(&mut picture, &panel(&values, &profile), TOP);
        let canvas = super::super::picture::Canvas::for_picture(&picture, picture.size());
        let underlay = picture.underlay(&canvas);
        // Red of a pixel in the left or right half of a row, counted from the top.
        let red = |column: f64, row: f64| {
            let x = CUT[0] + (CUT[1] - CUT[0]) * column;
            let y = TOP + HEIGHT * (row + 0.5) / 3.0;
            underlay.rgb[3 * (y as usize * underlay.width + x as usize)]
        };
        assert_eq!((red(0.25, 1.0), red(0.75, 1.0)), (0, 0));
        assert_eq!((red(0.25, 0.0), red(0.25, 2.0), red(0.75, 2.0)), (255, 255, 255));
    }

    #[test]
    fn only_drawn_predictions_are_in_the_caption() {
        let values = [0.0, 0.0, 2.0, 2.0, 0.0, 0.0];
        let profile = [0.0, 2.0, 0.0];
        let caption = |predicted_pix: f64| {
            let panel = CutPanel { predicted_pix, ..panel(&values, &profile) };
            let svg = streak_cuts("", &[panel]).unwrap().to_bytes(PictureFormat::Svg).unwrap();
            String::from_utf8(svg).unwrap().contains("Blue, dashed: predicted track.")
        };
        assert!(caption(1.4) && caption(-1.4) && !caption(1.6) && !caption(-40.0) && !caption(f64::NAN));
    }

    #[test]
    fn invalid_panels_are_named() {
        let values = [0.0; 6];
        assert!(streak_cuts("", &[panel(&values, &[0.0; 3])]).is_ok());
        let message = |panels: &[CutPanel<'_>]| streak_cuts("", panels).err().unwrap().to_string();
        assert!(message(&[]).contains("no tracks"));
        assert!(message(&[panel(&values[..5], &[0.0; 3])]).contains("values of the cut: 5 values; allowed: 6"));
        assert!(message(&[panel(&values, &[0.0; 2])]).contains("profile: 2 values; allowed: 3"));
        assert!(message(&[CutPanel { columns: 0, ..panel(&[], &[0.0; 3]) }]).contains("no columns"));
    }
}
