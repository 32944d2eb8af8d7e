//! Chart of passes over the sky of a site: tracks from rise to set, with magnitudes and times.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::axes::colour_bar;
use super::error;
use super::labels::Labels;
use super::picture::{INK, Picture};
use super::scale::{ColourScale, Quantity};
use super::star_field::{SkyDisk, StarField, StarStyle};
use super::statistics::check;
use super::time_axis::LocalClock;
use super::tracks::{
    MOST_LISTED, arrow, by_brightness, clock, list, magnitude_text, minutes_along, numbers, without_numbers,
};
use crate::constants::DAY_S;
use crate::error::Error;
use crate::geometry::Site;
use crate::message::known_step_s;

const WIDTH: f64 = 1580.0;
const HEIGHT: usize = 846;
const DISK: SkyDisk = SkyDisk { middle: (408.0, 424.0), radius: 330.0 };
const BAR_LEFT: f64 = 796.0;
const LIST_LEFT: f64 = 912.0;
const TOP: f64 = 82.0;
/// Largest number of passes that have times along them; the times of more passes would overlap.
const MOST_TIMED: usize = 3;
/// Lowest accepted altitude, degrees. A rise at the horizon may be slightly below it because of rounding.
const LEAST_DEG: f64 = -0.01;
const DARK: RGBColor = RGBColor(150, 150, 150);
const GROUND: RGBColor = RGBColor(246, 246, 246);
const STARS: StarStyle = StarStyle {
    faintest_mag: 6.0,
    radius: 0.6,
    radius_per_mag: 0.4,
    stars: RGBColor(140, 145, 165),
    lines: RGBColor(196, 202, 222),
    names: RGBColor(104, 110, 140),
    name_size: 12.5,
};
pub(super) const LONGEST_WITH_STARS_DAYS: f64 = 1.0 / 24.0;

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
    /// stars to V = 6 mag and the constellations are drawn for the middle of this time.
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
    /// One sigma of all times of the pass, seconds; NaN if unknown. Times are written to 1 s, 10 s, 1 min or 10 min,
    /// whichever is next above it, and to 1 min if it is unknown. Those of events between the ends of the pass are
    /// known to the interval between the points, and written to the step above it if it is longer.
    pub time_sigma_s: f64,
}

/// Draws the sky as seen from below, north up and east left. Every pass is drawn in the colours of its magnitudes, grey
/// where it is dark, with an arrow where it sets. A list gives the times of the ends of each pass, and time, altitude
/// and magnitude of its brightest point. If there are at most three passes, times are written along them. A sky without
/// a pass gets a note.
///
/// # Errors
/// A pass has fewer than two points; columns differ in length; times do not increase; or an altitude is invalid.
pub fn sky_chart(input: &SkyChart<'_>) -> Result<Picture, Error> {
    input.tracks.iter().try_for_each(check_track)?;
    let mut drawn = by_brightness(input.tracks.iter().map(SkyTrack::brightest_magnitude));
    drawn.truncate(MOST_LISTED);
    drawn.sort_unstable();
    let tracks: Vec<&SkyTrack> = drawn.into_iter().map(|number| &input.tracks[number]).collect();
    let lines: Vec<Vec<(f64, f64)>> = tracks.iter().map(|track| track.line(&DISK)).collect();
    let ahead_days = input.local.as_ref().map_or(0.0, |clock| clock.ahead_of_utc_h / 24.0);
    let mut picture = Picture::new(WIDTH as usize, HEIGHT);
    picture.set_title(input.title, (WIDTH / 2.0, 28.0), 22.0, HPos::Center);
    DISK.fill(&mut picture, GROUND);
    let stars = input.site.and_then(|site| {
        let mjd = middle_mjd(&tracks)?;
        Some((mjd, StarField::new(site, mjd)?))
    });
    if let Some((_, field)) = &stars {
        field.draw(&mut picture, &DISK, &STARS);
    }
    DISK.draw_circles(&mut picture);
    let magnitudes = || tracks.iter().flat_map(|track| track.magnitude.iter().copied());
    let scale = ColourScale::from_values(Quantity::Magnitude, magnitudes());
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
    let mut labels = Labels::new([30.0, TOP - 20.0, BAR_LEFT - 10.0, DISK.middle.1 + DISK.radius + 30.0]);
    lines.iter().enumerate().for_each(|(number, line)| labels.add_line(number, line));
    DISK.label_circles(&mut picture, &mut labels);
    if tracks.is_empty() {
        picture.note("no pass", DISK.at(180.0, 80.0));
    }
    if tracks.len() <= MOST_TIMED {
        for (number, track) in tracks.iter().enumerate() {
            minutes_along(&mut picture, &mut labels, number, &track.time_mjd, &lines[number], ahead_days, 16.0);
        }
    }
    let without = if tracks.len() > 1 { numbers(&mut picture, &mut labels, &lines, &order) } else { 0 };
    if let Some((_, field)) = &stars {
        field.draw_names(&mut picture, &mut labels, &DISK, &STARS);
    }
    if magnitudes().any(f64::is_finite) {
        let sides = [BAR_LEFT, TOP + 60.0, BAR_LEFT + 24.0, DISK.middle.1 + DISK.radius - 30.0];
        colour_bar(&mut picture, &scale, sides, &scale.label());
    }
    let rows: Vec<Vec<String>> = tracks.iter().map(|track| track.list_row(ahead_days)).collect();
    let [rise, set] = if input.local.is_some() { ["rise", "set"] } else { ["rise UTC", "set UTC"] };
    let columns =
        [("satellite", 28.0), (rise, 228.0), (set, 318.0), ("brightest", 408.0), ("alt", 504.0), ("mag", 554.0)];
    list(&mut picture, [LIST_LEFT, WIDTH - 20.0], TOP, &columns, &rows);
    picture.set_scales(vec![scale]);
    let mut caption = "Zenith in the middle, horizon at the rim, north up, east left; arrows where passes end; grey where not visible. The list has rise and set of the whole pass, and time, altitude and magnitude of its brightest point. ".to_owned();
    if tracks.len() < input.tracks.len() {
        caption += &format!("The {} brightest of {} passes. ", tracks.len(), input.tracks.len());
    }
    caption += &without_numbers(without);
    if let Some((mjd, _)) = stars {
        let zone = if input.local.is_some() { "" } else { " UTC" };
        caption += &format!("Stars to V = 6 mag and constellations at {}{zone}. ", clock(mjd + ahead_days, 60.0));
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
    pub(super) fn line(&self, disk: &SkyDisk) -> Vec<(f64, f64)> {
        let points = self.azimuth_deg.iter().zip(&self.altitude_deg);
        points.map(|(azimuth, altitude)| disk.at(*azimuth, *altitude)).collect()
    }

    /// Returns the index of the brightest magnitude.
    pub(super) fn brightest(&self) -> Option<usize> {
        let lit = (0..self.magnitude.len()).filter(|point| self.magnitude[*point].is_finite());
        lit.min_by(|a, b| self.magnitude[*a].total_cmp(&self.magnitude[*b]))
    }

    /// Returns the brightest magnitude; NaN if the track has none.
    fn brightest_magnitude(&self) -> f64 {
        self.brightest().map_or(f64::NAN, |point| self.magnitude[point])
    }

    /// Returns the step to which the time of an event at a point is rounded. An event inside the track is known to the
    /// interval between the points.
    pub(super) fn event_step_s(&self, point: usize) -> f64 {
        let step_s = known_step_s(self.time_sigma_s);
        match point == 0 || point + 1 == self.time_mjd.len() {
            true => step_s,
            false => step_s.max(known_step_s(self.longest_interval_s())),
        }
    }

    /// Returns the longest interval between two points, seconds.
    pub(super) fn longest_interval_s(&self) -> f64 {
        self.time_mjd.windows(2).map(|pair| (pair[1] - pair[0]) * DAY_S).fold(0.0, f64::max)
    }

    /// Returns name, times of rise, set and the brightest point, its altitude and magnitude.
    fn list_row(&self, ahead_days: f64) -> Vec<String> {
        let brightest = self.brightest();
        let at = |column: &[f64]| brightest.map_or(f64::NAN, |point| column[point]);
        let (first, last) = (self.time_mjd[0], self.time_mjd[self.time_mjd.len() - 1]);
        let [rise, set] = [first, last].map(|mjd| clock(mjd + ahead_days, known_step_s(self.time_sigma_s)));
        let peak = brightest
            .map_or_else(String::new, |point| clock(self.time_mjd[point] + ahead_days, self.event_step_s(point)));
        let altitude = brightest.map_or_else(String::new, |point| format!("{:.0}°", self.altitude_deg[point]));
        vec![self.name.clone(), rise, set, peak, altitude, magnitude_text(at(&self.magnitude), at(&self.sigma_mag))]
    }
}

/// Rejects a pass that cannot be drawn.
pub(super) fn check_track(track: &SkyTrack) -> Result<(), Error> {
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
            return Err(error::length(&of(what), column.len(), n));
        }
    }
    check(&of("the azimuths"), &track.azimuth_deg)?;
    if let Some(altitude) = track.altitude_deg.iter().find(|altitude| !(LEAST_DEG..=90.0).contains(*altitude)) {
        let given = format!("{altitude} deg");
        return Err(Error::invalid(of("an altitude"), given, "0 to 90 deg"));
    }
    if n < 2 || track.time_mjd.windows(2).any(|pair| pair[0] >= pair[1]) {
        let (what, given) = (of("the list of times"), format!("not increasing ({n} values)"));
        return Err(Error::invalid(what, given, "two or more, each later than the one before"));
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
