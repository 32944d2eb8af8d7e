//! Finder chart of one pass for printing: the sky with stars and constellations, and a table of positions.

use plotters::prelude::RGBColor;
use plotters::style::Color;
use plotters::style::text_anchor::HPos;

use super::labels::Labels;
use super::picture::{INK, Picture, half_size};
use super::sky_chart::{LONGEST_WITH_STARS_DAYS, SkyTrack, check_track};
use super::star_field::{SkyDisk, StarField, StarStyle};
use super::time_axis::LocalClock;
use super::tracks::{arrow, clock, magnitude_text, minutes_along, place_with_line, positions_beside};
use crate::error::Error;
use crate::frames::compass;
use crate::geometry::Site;
use crate::message::known_step_s;

const WIDTH: f64 = 1000.0;
const HEIGHT: usize = 1414;
const DISK: SkyDisk = SkyDisk { middle: (500.0, 500.0), radius: 400.0 };
const LABELS: [f64; 4] = [12.0, 72.0, 988.0, 928.0];
const LABEL_SIZE: f64 = 21.0;
const STARS: StarStyle = StarStyle {
    faintest_mag: 5.0,
    radius: 0.9,
    radius_per_mag: 0.75,
    stars: INK,
    lines: RGBColor(176, 176, 176),
    names: RGBColor(90, 90, 90),
    name_size: 15.0,
};
const DARK: RGBColor = RGBColor(130, 130, 130);
const TABLE_TOP: f64 = 962.0;
const TABLE_SIDES: [f64; 2] = [90.0, 910.0];
const ROW: f64 = 27.0;
const ROW_SIZE: f64 = 19.0;
/// Positions of the columns of the table.
const COLUMNS: [(&str, f64); 5] =
    [("time", 90.0), ("", 230.0), ("altitude", 440.0), ("azimuth", 580.0), ("magnitude", 760.0)];
/// Possible steps between the rows of the table, minutes.
const STEPS_MIN: [f64; 9] = [0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0];
/// Largest number of rows at equal steps; the events of the pass have rows too.
const MOST_STEPS: f64 = 8.0;
const DAY_MIN: f64 = 1440.0;

/// One pass over a site.
#[derive(Clone, Debug)]
pub struct FinderChart<'a> {
    /// Title.
    pub title: &'a str,
    /// Text that follows the caption of the chart.
    pub caption: &'a str,
    /// The pass.
    pub track: &'a SkyTrack,
    /// Clock of all times; `None` for UTC.
    pub local: Option<LocalClock>,
    /// Site of the pass; stars and constellations are drawn if it is given.
    pub site: Option<&'a Site>,
}

/// Position of the satellite at one time.
struct Moment {
    mjd: f64,
    /// Events of the pass, separated by commas; empty for a row at a round time.
    event: String,
    /// Step to which the time is rounded, seconds.
    step_s: f64,
    altitude_deg: f64,
    azimuth_deg: f64,
    magnitude: f64,
    sigma_mag: f64,
}

/// Draws the sky as seen from below, north up and east left, in black on white, with the stars to V = 5 mag at the
/// middle of the pass. Times are written along the track, which is dashed where the satellite is not visible. A table
/// has time, altitude, azimuth and magnitude at round times and at start, end, highest and brightest point.
///
/// # Errors
/// The pass has fewer than two points; columns differ in length; times do not increase; or an altitude is invalid.
pub fn finder_chart(input: &FinderChart<'_>) -> Result<Picture, Error> {
    let track = input.track;
    check_track(track)?;
    let ahead_days = input.local.as_ref().map_or(0.0, |clock| clock.ahead_of_utc_h / 24.0);
    let (first, last) = (track.time_mjd[0], track.time_mjd[track.time_mjd.len() - 1]);
    let line = track.line(&DISK);
    let mut picture = Picture::new(WIDTH as usize, HEIGHT);
    picture.set_title(input.title, (WIDTH / 2.0, 26.0), 24.0, HPos::Center);
    let is_short = last - first < LONGEST_WITH_STARS_DAYS;
    let field = input.site.filter(|_| is_short).and_then(|site| StarField::new(site, 0.5 * (first + last)));
    if let Some(field) = &field {
        field.draw(&mut picture, &DISK, &STARS);
    }
    DISK.draw_circles(&mut picture);
    let points: Vec<usize> = (0..line.len()).collect();
    let is_lit = |point: usize| track.magnitude[point].is_finite();
    for run in points.chunk_by(|a, b| is_lit(*a) == is_lit(*b)) {
        // A run of dark points begins and ends at its visible neighbours.
        let part = match is_lit(run[0]) {
            true => run[0]..run[run.len() - 1] + 1,
            false => run[0].saturating_sub(1)..(run[run.len() - 1] + 2).min(line.len()),
        };
        match is_lit(run[0]) {
            true => picture.line(&line[part], INK.to_rgba(), 4.0),
            false => picture.dashed(&line[part], [9.0, 7.0], DARK.to_rgba(), 2.5),
        }
    }
    arrow(&mut picture, &line, if is_lit(line.len() - 1) { INK } else { DARK });
    let mut labels = Labels::new(LABELS);
    labels.add_line(0, &line);
    DISK.label_circles(&mut picture, &mut labels);
    let step_s = known_step_s(track.time_sigma_s);
    if let Some(point) = track.brightest() {
        mark_brightest(&mut picture, &mut labels, track, &line, point);
    }
    minutes_along(&mut picture, &mut labels, 0, &track.time_mjd, &line, ahead_days, LABEL_SIZE);
    if let Some(field) = &field {
        field.draw_names(&mut picture, &mut labels, &DISK, &STARS);
    }
    let bottom = draw_table(&mut picture, &moments(track, ahead_days, step_s), ahead_days);
    let clock_name = input.local.as_ref().map_or("UTC", |clock| &clock.name);
    let mut caption = format!(
        "Zenith in the middle, horizon at the rim, north up, east left: hold the chart overhead. Times: {clock_name}, "
    );
    caption += &match track.time_sigma_s.is_finite() {
        true => format!("known to {} (one sigma). ", seconds(track.time_sigma_s)),
        false => "of unknown error. ".to_owned(),
    };
    let interval_s = track.longest_interval_s();
    if known_step_s(interval_s) > step_s {
        caption +=
            &format!("Events between start and end: within {} (the step of the light curve). ", seconds(interval_s));
    }
    if track.magnitude.iter().any(|magnitude| !magnitude.is_finite()) {
        caption += "Dashed: not visible. ";
    }
    if field.is_some() {
        caption += "Stars to V = 5 mag. ";
    }
    caption += input.caption;
    picture.paragraph(caption.trim_end(), [60.0, WIDTH - 60.0], bottom + 12.0, 16.0);
    Ok(picture)
}

/// Formats seconds with two decimals below 1 s and one below 10 s, at least 0.01 s.
fn seconds(seconds: f64) -> String {
    let seconds = seconds.max(0.01);
    let decimals = if seconds < 1.0 { 2 } else { usize::from(seconds < 10.0) };
    format!("{seconds:.decimals$} s")
}

/// Draws a mark at the brightest point of a pass, with its magnitude.
fn mark_brightest(picture: &mut Picture, labels: &mut Labels, track: &SkyTrack, line: &[(f64, f64)], point: usize) {
    let (x, y) = line[point];
    picture.disk((x, y), 9.0, INK);
    let text = format!("{} mag", magnitude_text(track.magnitude[point], f64::NAN));
    let half = half_size(&text, LABEL_SIZE);
    let from = point.saturating_sub(1);
    let pair = &line[from..(from + 2).min(line.len())];
    let share = if from < point { 1.0 } else { 0.0 };
    let beside = positions_beside(pair, share, half);
    if let Some(position) = place_with_line(picture, labels, 0, (x, y), beside, half) {
        picture.note_of(&text, position, LABEL_SIZE);
    }
}

/// Returns the rows of the table in time order: events, and round times that are not close to an event.
fn moments(track: &SkyTrack, ahead_days: f64, step_s: f64) -> Vec<Moment> {
    let n = track.time_mjd.len();
    let (first, last) = (track.time_mjd[0], track.time_mjd[n - 1]);
    let mut rows: Vec<Moment> = Vec::new();
    let mut add = |point: usize, event: &'static str| {
        // Events at the same point have one row.
        match rows.iter_mut().find(|row| row.mjd == track.time_mjd[point]) {
            Some(row) => row.event += &format!(", {event}"),
            None => rows.push(track.moment(track.time_mjd[point], event.to_owned(), track.event_step_s(point))),
        }
    };
    add(0, "start");
    add(n - 1, "end");
    let is_lit = |point: &usize| track.magnitude[*point].is_finite();
    for point in (1..n).filter(|point| is_lit(point) && !is_lit(&(point - 1))) {
        add(point, "becomes visible");
    }
    for point in (0..n - 1).filter(|point| is_lit(point) && !is_lit(&(point + 1))) {
        add(point, "last visible");
    }
    if let Some(highest) = (0..n).max_by(|a, b| track.altitude_deg[*a].total_cmp(&track.altitude_deg[*b])) {
        add(highest, "highest");
    }
    if let Some(brightest) = track.brightest() {
        add(brightest, "brightest");
    }
    let span_min = (last - first) * DAY_MIN;
    let is_coarse = |step: &f64| span_min / step <= MOST_STEPS && step * 60.0 >= step_s;
    let step_days = STEPS_MIN.into_iter().find(is_coarse).unwrap_or(span_min / MOST_STEPS) / DAY_MIN;
    let count = |mjd: f64| (mjd + ahead_days) / step_days;
    let events: Vec<f64> = rows.iter().map(|row| row.mjd).collect();
    for round in count(first).ceil() as i64..=count(last).floor() as i64 {
        let mjd = round as f64 * step_days - ahead_days;
        if (first..=last).contains(&mjd) && events.iter().all(|event| (event - mjd).abs() > 0.25 * step_days) {
            rows.push(track.moment(mjd, String::new(), step_s));
        }
    }
    rows.sort_by(|a, b| a.mjd.total_cmp(&b.mjd));
    rows
}

impl SkyTrack {
    /// Returns the position at a time between the first and the last point, interpolated along a great circle.
    fn moment(&self, mjd: f64, event: String, step_s: f64) -> Moment {
        let step = self.time_mjd.windows(2).position(|pair| mjd <= pair[1]).unwrap_or(self.time_mjd.len() - 2);
        let share = (mjd - self.time_mjd[step]) / (self.time_mjd[step + 1] - self.time_mjd[step]);
        let between = |column: &[f64]| match share {
            // A point without magnitude beside one with a magnitude does not hide it.
            0.0 => column[step],
            1.0 => column[step + 1],
            share => (1.0 - share) * column[step] + share * column[step + 1],
        };
        let ray = |point: usize| {
            let (sin, cos) = self.altitude_deg[point].to_radians().sin_cos();
            let (east, north) = self.azimuth_deg[point].to_radians().sin_cos();
            [cos * east, cos * north, sin]
        };
        let (from, to) = (ray(step), ray(step + 1));
        let [east, north, up] = [0, 1, 2].map(|axis| (1.0 - share) * from[axis] + share * to[axis]);
        Moment {
            mjd,
            event,
            step_s,
            altitude_deg: up.atan2(east.hypot(north)).to_degrees(),
            azimuth_deg: east.atan2(north).to_degrees().rem_euclid(360.0),
            magnitude: between(&self.magnitude),
            sigma_mag: between(&self.sigma_mag),
        }
    }
}

/// Draws the table; returns the y position below it.
fn draw_table(picture: &mut Picture, rows: &[Moment], ahead_days: f64) -> f64 {
    for (heading, x) in COLUMNS {
        picture.text(heading, (x, TABLE_TOP), ROW_SIZE, HPos::Left);
    }
    let rule = |picture: &mut Picture, y: f64| {
        picture.line(&[(TABLE_SIDES[0], y), (TABLE_SIDES[1], y)], INK.to_rgba(), 1.2);
    };
    rule(picture, TABLE_TOP + 16.0);
    let mut y = TABLE_TOP + 36.0;
    for row in rows {
        let azimuth = format!("{:.0}° {}", row.azimuth_deg.round() % 360.0, compass(row.azimuth_deg.to_radians()));
        let magnitude = magnitude_text(row.magnitude, row.sigma_mag);
        let magnitude = if row.magnitude.is_finite() { magnitude } else { "not visible".to_owned() };
        let time = clock(row.mjd + ahead_days, row.step_s);
        let altitude = format!("{:.0}°", row.altitude_deg.max(0.0));
        for (text, (_, x)) in [&time, &row.event, &altitude, &azimuth, &magnitude].into_iter().zip(COLUMNS) {
            picture.text(text, (x, y), ROW_SIZE, HPos::Left);
        }
        y += ROW;
    }
    rule(picture, y - 10.0);
    y + 12.0
}
