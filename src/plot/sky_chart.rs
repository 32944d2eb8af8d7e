//! Chart of passes over the sky of a site: tracks from rise to set, with magnitudes and times.

use std::f64::consts::FRAC_PI_2;

use hifitime::TimeScale;
use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::colour_bar;
use super::error::PlotError;
use super::labels::Labels;
use super::picture::{INK, Picture, around, half_size};
use super::scale::{ColourScale, Quantity};
use super::sky_disk::{AZIMUTHS, disk_position};
use super::statistics::check;
use super::time_axis::LocalClock;
use super::tracks::{
    ListRow, MOST_LISTED, arrow, by_brightness, list, numbers, positions_beside, time_of_day, without_numbers,
};
use crate::frames::{EopTable, Orientation, bright_stars, epoch_from_mjd};
use crate::geometry::{Observer, Site};

const WIDTH: f64 = 1440.0;
const HEIGHT: usize = 846;
const MIDDLE: (f64, f64) = (408.0, 424.0);
const RADIUS: f64 = 330.0;
const BAR_LEFT: f64 = 796.0;
const LIST_LEFT: f64 = 912.0;
const TOP: f64 = 82.0;
/// Altitudes of the circles, degrees.
const CIRCLES_DEG: [f64; 2] = [30.0, 60.0];
/// Largest number of passes that have times along them; the times of more passes would overlap.
const MOST_TIMED: usize = 3;
const DAY_MIN: f64 = 1440.0;
/// Lowest accepted altitude, degrees. A rise at the horizon may be slightly below it because of rounding.
const LEAST_DEG: f64 = -0.01;
/// Smallest distance between two times along a pass, pixels.
const LABEL_GAP: f64 = 62.0;
const DARK: RGBColor = RGBColor(150, 150, 150);
const GROUND: RGBColor = RGBColor(240, 240, 240);
const STAR: RGBColor = RGBColor(140, 145, 165);
/// Radius of the faintest stars, pixels, and its growth with brightness, pixels per magnitude.
const STAR_RADIUS: f64 = 0.6;
const STAR_RADIUS_PER_MAG: f64 = 0.4;
const FAINTEST_STAR_MAG: f64 = 6.0;
const LONGEST_WITH_STARS_DAYS: f64 = 1.0 / 24.0;

/// Passes over a site.
#[derive(Clone, Debug)]
pub struct SkyChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Text that follows the caption of the chart.
    pub caption: &'a str,
    /// Passes. The brightest are drawn, as many as fit into the list, in the order given.
    pub tracks: &'a [SkyTrack],
    /// Clock of all times; `None` for UTC.
    pub local: Option<LocalClock>,
    /// Site of the passes. If it is given and all passes are within an hour, in which the sky turns by 15 degrees, the
    /// stars to V = 6 mag are drawn for the middle of this time.
    pub site: Option<&'a Site>,
}

/// One pass, with columns of equal length, of two points or more.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyTrack {
    /// Name of the satellite.
    pub name: String,
    /// Times, MJD (UTC), increasing; shape `(n_point)`.
    pub time_mjd: Vec<f64>,
    /// Azimuths from north through east, degrees; shape `(n_point)`.
    pub azimuth_deg: Vec<f64>,
    /// Altitudes, 0 to 90 degrees; shape `(n_point)`.
    pub altitude_deg: Vec<f64>,
    /// Magnitudes; NaN in the Earth's shadow; shape `(n_point)`.
    pub magnitude: Vec<f64>,
    /// Uncertainties (one sigma) of the magnitudes, mag; NaN if unknown; shape `(n_point)`.
    pub sigma_mag: Vec<f64>,
}

/// Draws the sky as seen from below, north up and east left. Every pass is drawn in the colours of its magnitudes, grey
/// where it is dark, with an arrow where it sets. A list gives the times of the ends and the brightest magnitude of
/// each pass. If there are at most three passes, times are written along them. A sky without a pass gets a note.
///
/// # Errors
/// A pass has fewer than two points; columns differ in length; times do not increase; or an altitude is invalid.
pub fn sky_chart(input: &SkyChart<'_>) -> Result<Picture, PlotError> {
    input.tracks.iter().try_for_each(check_track)?;
    let mut drawn = by_brightness(input.tracks.iter().map(SkyTrack::brightest_magnitude));
    drawn.truncate(MOST_LISTED);
    drawn.sort_unstable();
    let tracks: Vec<&SkyTrack> = drawn.into_iter().map(|number| &input.tracks[number]).collect();
    let lines: Vec<Vec<(f64, f64)>> = tracks.iter().map(|track| track.line()).collect();
    let ahead_days = input.local.as_ref().map_or(0.0, |clock| clock.ahead_of_utc_h / 24.0);
    let mut picture = Picture::new(WIDTH as usize, HEIGHT);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    draw_ground(&mut picture);
    let stars_mjd = input.site.and_then(|site| {
        let mjd = middle_mjd(&tracks)?;
        draw_stars(&mut picture, site, mjd).then_some(mjd)
    });
    draw_circles(&mut picture);
    let magnitudes = || tracks.iter().flat_map(|track| track.magnitude.iter().copied());
    let scale = ColourScale::of(Quantity::Magnitude, magnitudes());
    let colour = |magnitude: f64| match magnitude.is_finite() {
        true => {
            let [red, green, blue] = scale.colour(magnitude);
            RGBColor(red, green, blue)
        }
        false => DARK,
    };
    // The brightest passes are drawn last, over the others.
    let order = by_brightness(tracks.iter().map(|track| track.brightest_magnitude()));
    for &number in order.iter().rev() {
        let (track, line) = (tracks[number], &lines[number]);
        picture.line(line, INK.to_rgba(), 5.0);
        for (step, pair) in line.windows(2).enumerate() {
            // A step of which one end is in the shadow has no magnitude and is drawn dark.
            picture.line(pair, colour(0.5 * (track.magnitude[step] + track.magnitude[step + 1])).to_rgba(), 3.4);
        }
        arrow(&mut picture, line, colour(track.magnitude[line.len() - 1]));
    }
    let mut labels = Labels::new([30.0, TOP - 20.0, BAR_LEFT - 10.0, MIDDLE.1 + RADIUS + 30.0]);
    lines.iter().enumerate().for_each(|(number, line)| labels.add_line(number, line));
    for (azimuth_deg, text) in AZIMUTHS {
        labels.add_box(around(rim_position(azimuth_deg), half_size(text, 19.0)));
    }
    // Labels of the circles are where no pass is, if there is such a position.
    for altitude_deg in CIRCLES_DEG {
        let text = format!("{altitude_deg:.0}°");
        let candidates = (0..24).map(|part| at(112.5 + 15.0 * f64::from(part), altitude_deg));
        let position = labels.place(half_size(&text, 16.0), candidates);
        picture.note(&text, position.unwrap_or_else(|| at(112.5, altitude_deg)));
    }
    if tracks.is_empty() {
        picture.note("no pass", at(180.0, 80.0));
    }
    if tracks.len() <= MOST_TIMED {
        tracks.iter().for_each(|track| times_along(&mut picture, &mut labels, track, ahead_days));
    }
    let without = if tracks.len() > 1 { numbers(&mut picture, &mut labels, &lines, &order) } else { 0 };
    if magnitudes().any(f64::is_finite) {
        let sides = [BAR_LEFT, TOP + 60.0, BAR_LEFT + 24.0, MIDDLE.1 + RADIUS - 30.0];
        colour_bar(&mut picture, &scale, sides, &scale.label());
    }
    let rows: Vec<ListRow> = tracks
        .iter()
        .map(|track| {
            let brightest = track.brightest();
            let at = |column: &[f64]| brightest.map_or(f64::NAN, |point| column[point]);
            ListRow {
                name: track.name.clone(),
                times: [0, track.time_mjd.len() - 1].map(|point| time_of_day(track.time_mjd[point] + ahead_days, 0)),
                magnitude: at(&track.magnitude),
                sigma_mag: at(&track.sigma_mag),
                colour: colour(at(&track.magnitude)),
            }
        })
        .collect();
    let heads = if input.local.is_some() { ["rise", "set"] } else { ["rise UTC", "set UTC"] };
    list(&mut picture, [LIST_LEFT, WIDTH - 20.0], TOP, heads, &rows);
    picture.set_scales(vec![scale]);
    let mut caption = "Zenith in the middle, horizon at the rim, north up, east left; grey where not visible. Magnitudes in the list are the brightest of each pass. ".to_owned();
    if tracks.len() < input.tracks.len() {
        caption += &format!("The {} brightest of {} passes. ", tracks.len(), input.tracks.len());
    }
    caption += &without_numbers(without);
    if let Some(mjd) = stars_mjd {
        let zone = if input.local.is_some() { "" } else { " UTC" };
        caption += &format!("Dots: stars to V = 6 mag at {}{zone}. ", &time_of_day(mjd + ahead_days, 0)[..5]);
    }
    if let Some(clock) = &input.local {
        caption += &format!("Times: {}. ", clock.name);
    }
    caption += input.caption;
    picture.paragraph(caption.trim_end(), [48.0, WIDTH - 24.0], 804.0, 16.0);
    Ok(picture)
}

impl SkyTrack {
    /// Returns the points of the track in the picture.
    fn line(&self) -> Vec<(f64, f64)> {
        self.azimuth_deg.iter().zip(&self.altitude_deg).map(|(azimuth, altitude)| at(*azimuth, *altitude)).collect()
    }

    /// Returns the index of the brightest magnitude.
    fn brightest(&self) -> Option<usize> {
        let lit = (0..self.magnitude.len()).filter(|point| self.magnitude[*point].is_finite());
        lit.min_by(|a, b| self.magnitude[*a].total_cmp(&self.magnitude[*b]))
    }

    /// Returns the brightest magnitude; NaN if the track has none.
    fn brightest_magnitude(&self) -> f64 {
        self.brightest().map_or(f64::NAN, |point| self.magnitude[point])
    }
}

/// Returns the position of a direction in the picture, right and down.
fn at(azimuth_deg: f64, altitude_deg: f64) -> (f64, f64) {
    let (right, below) = disk_position(azimuth_deg.to_radians(), FRAC_PI_2 - altitude_deg.to_radians());
    (MIDDLE.0 + RADIUS * right, MIDDLE.1 + RADIUS * below)
}

/// Rejects a pass that cannot be drawn.
fn check_track(track: &SkyTrack) -> Result<(), PlotError> {
    let n = track.time_mjd.len();
    let of = |what: &str| format!("{what} of {}", track.name);
    check(&of("the points along the pass"), &track.time_mjd)?;
    for (what, column) in [
        ("azimuths", &track.azimuth_deg),
        ("altitudes", &track.altitude_deg),
        ("magnitudes", &track.magnitude),
        ("sigmas", &track.sigma_mag),
    ] {
        if column.len() != n {
            return Err(PlotError::Length { what: of(what), given: column.len(), expected: n });
        }
    }
    check(&of("the azimuths"), &track.azimuth_deg)?;
    if let Some(altitude) = track.altitude_deg.iter().find(|altitude| !(LEAST_DEG..=90.0).contains(*altitude)) {
        let given = format!("{altitude} deg");
        return Err(PlotError::OutOfRange { what: of("an altitude"), given, allowed: "0 to 90 deg" });
    }
    if n < 2 || track.time_mjd.windows(2).any(|pair| pair[0] >= pair[1]) {
        let (what, given) = (of("the list of times"), format!("not increasing ({n} values)"));
        return Err(PlotError::OutOfRange { what, given, allowed: "two or more, each later than the one before" });
    }
    Ok(())
}

/// Returns the time halfway between the first and the last point of all passes, MJD (UTC); `None` without a pass or if
/// the passes are not within [`LONGEST_WITH_STARS_DAYS`].
fn middle_mjd(tracks: &[&SkyTrack]) -> Option<f64> {
    let times = || tracks.iter().flat_map(|track| track.time_mjd.iter().copied());
    let (first, last) = (times().reduce(f64::min)?, times().reduce(f64::max)?);
    (last - first < LONGEST_WITH_STARS_DAYS).then_some(0.5 * (first + last))
}

/// Draws the stars above the horizon, without refraction, aberration and proper motion. The positions are accurate to
/// half a degree at the horizon, and to 0.01 degrees high above it. Returns false for a time outside the range of
/// dates.
fn draw_stars(picture: &mut Picture, site: &Site, mjd: f64) -> bool {
    let Ok(moment) = epoch_from_mjd(mjd, TimeScale::UTC) else { return false };
    let horizon = Observer::new(site.clone()).state(&Orientation::at(moment, &EopTable::embedded())).horizon;
    for star in bright_stars() {
        let seen = horizon * star.direction;
        if seen.latitude_rad() > 0.0 {
            let radius = STAR_RADIUS + STAR_RADIUS_PER_MAG * (FAINTEST_STAR_MAG - star.v_mag);
            picture.disk(at(seen.longitude_rad().to_degrees(), seen.latitude_rad().to_degrees()), radius, STAR);
        }
    }
    true
}

fn draw_ground(picture: &mut Picture) {
    let rim = (0..180).map(|part| at(2.0 * f64::from(part), 0.0)).collect();
    picture.patch(rim, GROUND.mix(0.6));
}

/// Draws circles of altitude, the meridian and the horizon with its labels.
fn draw_circles(picture: &mut Picture) {
    for altitude_deg in CIRCLES_DEG {
        picture.circle(MIDDLE, RADIUS * (90.0 - altitude_deg) / 90.0, INK.mix(0.45), 1.0);
    }
    for azimuth_deg in [0.0, 90.0] {
        picture.line(&[at(azimuth_deg, 0.0), at(azimuth_deg + 180.0, 0.0)], INK.mix(0.25), 1.0);
    }
    picture.circle(MIDDLE, RADIUS, INK.to_rgba(), 1.6);
    for (azimuth_deg, text) in AZIMUTHS {
        let size = if text.len() > 1 { 16.0 } else { 19.0 };
        picture.text(text, rim_position(azimuth_deg), size, HPos::Center);
        picture.line(&[at(azimuth_deg, 0.0), at(azimuth_deg, 1.5)], INK.to_rgba(), 1.2);
    }
}

/// Returns the position of a label outside the horizon.
fn rim_position(azimuth_deg: f64) -> (f64, f64) {
    let (x, y) = at(azimuth_deg, 0.0);
    let away = |from: f64, to: f64| (to - from) / RADIUS * 18.0;
    // Labels of azimuths are wider than high.
    let aside = if azimuth_deg % 90.0 == 0.0 { 1.0 } else { 1.5 };
    (x + aside * away(MIDDLE.0, x), y + away(MIDDLE.1, y))
}

/// Draws a dot at every full minute of a pass, with the time if its label fits. `ahead_days` is the clock's difference
/// to UTC.
fn times_along(picture: &mut Picture, labels: &mut Labels, track: &SkyTrack, ahead_days: f64) {
    let (first, last) = (track.time_mjd[0], track.time_mjd[track.time_mjd.len() - 1]);
    let line = track.line();
    let mut labelled: Option<(f64, f64)> = None;
    for minute in (first * DAY_MIN).ceil() as i64..=(last * DAY_MIN).floor() as i64 {
        let mjd = minute as f64 / DAY_MIN;
        let Some(step) = track.time_mjd.windows(2).position(|pair| (pair[0]..=pair[1]).contains(&mjd)) else {
            continue;
        };
        let part = (mjd - track.time_mjd[step]) / (track.time_mjd[step + 1] - track.time_mjd[step]);
        let ((x0, y0), (x1, y1)) = (line[step], line[step + 1]);
        let (x, y) = (x0 + part * (x1 - x0), y0 + part * (y1 - y0));
        picture.circle((x, y), 4.0, INK.to_rgba(), 2.0);
        if labelled.is_none_or(|(x_before, y_before): (f64, f64)| (x - x_before).hypot(y - y_before) > LABEL_GAP) {
            // The label is next to the track, at a right angle to it.
            let text = &time_of_day(mjd + ahead_days, 0)[..5];
            let half = half_size(text, 16.0);
            if let Some(position) = labels.place(half, positions_beside(&[line[step], line[step + 1]], part, half)) {
                picture.note(text, position);
                labelled = Some((x, y));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verif_the_sky_has_north_up_and_east_left() {
        let near = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1) < 1e-9;
        assert!(near(at(0.0, 90.0), MIDDLE) && near(at(123.0, 90.0), MIDDLE));
        assert!(near(at(0.0, 0.0), (MIDDLE.0, MIDDLE.1 - RADIUS)));
        assert!(near(at(90.0, 45.0), (MIDDLE.0 - RADIUS / 2.0, MIDDLE.1)));
    }
}
