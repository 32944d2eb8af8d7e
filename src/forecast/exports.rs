//! Export of passes to other formats: iCalendar, CCSDS Tracking Data Message (TDM), SCORE.

use std::fmt::Write as _;

use hifitime::{Epoch, TimeScale, Unit};

use super::pass_table::{PassRow, clock, utc_offset};
use crate::frames::{compass, seconds_after};
use crate::geometry::Site;
use crate::message::known_step_s;
use crate::output::{Provenance, csv_cell, format_utc};
use crate::passes::TrackPoint;
use crate::photometry::PhotometryOptions;

/// Longest content line of an iCalendar file, bytes, without the line break.
const LINE: usize = 75;

/// Night in which no pass is visible.
#[derive(Copy, Clone, Debug, PartialEq)]
pub struct EmptyNight<'a> {
    /// Start.
    pub start: Epoch,
    /// End.
    pub end: Epoch,
    /// Reason why no pass is visible, from [`Forecast::why_empty`](super::Forecast::why_empty).
    pub why: &'a str,
    /// True if there may be visible passes, from [`Forecast::may_have_passes`](super::Forecast::may_have_passes).
    pub is_unknown: bool,
}

/// Returns the visible passes as an iCalendar (RFC 5545) in UTC, one event for each pass. `made` is the time of
/// creation; `alarm_s` is the time from an alarm to its event, seconds. Times in descriptions are local;
/// `utc_offset_s` returns local time minus UTC at a time, seconds.
///
/// Lines end in CR LF and are folded at 75 bytes (section 3.1), and text is escaped (section 3.3.11). The UID of an
/// event does not depend on `made`, and seldom on errors of a few seconds (only if the culmination passes a half hour),
/// so that a calendar from newer elements replaces the events. An event starts at the last whole step before the
/// visible part begins, and ends at
/// the first one after it ends; the step is 1 s, 10 s, 1 min or 10 min, whichever is next above the error of the times.
/// A calendar must have at least one component (section 3.6): if `empty` is given, the night is written as one
/// transparent event with the reason.
pub fn calendar<'a>(
    rows: impl IntoIterator<Item = PassRow<'a>>,
    site: &Site,
    made: Epoch,
    alarm_s: Option<f64>,
    empty: Option<EmptyNight<'_>>,
    utc_offset_s: impl Fn(Epoch) -> f64,
) -> String {
    let mut text = String::new();
    let mut line = |content: String| fold(&mut text, &content);
    line("BEGIN:VCALENDAR".into());
    line("VERSION:2.0".into());
    line(format!("PRODID:-//streakcast//streakcast {}//EN", env!("CARGO_PKG_VERSION")));
    line("CALSCALE:GREGORIAN".into());
    line("METHOD:PUBLISH".into());
    for row in rows {
        let Some(seen) = &row.pass.visible else { continue };
        let step_s = known_step_s(row.pass.along_track_sigma_s);
        let step = step_s * Unit::Second;
        let utc = |epoch: Epoch| epoch.to_time_scale(TimeScale::UTC);
        let point = |what: &str, point: &TrackPoint| point_text(what, point, utc_offset_s(point.epoch), step_s);
        let light = row.peak().and_then(|peak| peak.brightness.as_ref());
        let magnitude = light.map_or("no magnitude".to_owned(), |light| {
            format!("mag {:.1} \u{b1} {:.1}", light.magnitude.0, light.sigma_mag)
        });
        line("BEGIN:VEVENT".into());
        // No satellite culminates twice in half an hour.
        let culmination = utc(row.pass.culmination.epoch).floor(30.0 * Unit::Minute);
        line(format!("UID:{}-{}@streakcast", row.pass.norad_id, stamp(culmination)));
        line(format!("DTSTAMP:{}", stamp(made)));
        line(format!("DTSTART:{}", stamp(utc(seen.begin.epoch).floor(step))));
        line(format!("DTEND:{}", stamp(utc(seen.end.epoch).ceil(step))));
        line(format!("SUMMARY:{}", escaped(&format!("{} {magnitude}", row.name()))));
        let ends_by = match row.ends_by() {
            Some("end") => "end of the forecast",
            other => other.unwrap_or_default(),
        };
        let mut facts: Vec<String> = row.peak().map(|peak| point("brightest", peak)).into_iter().collect();
        facts.extend([
            point("starts", &seen.begin),
            point("highest", &seen.highest),
            format!("{} ({ends_by})", point("ends", &seen.end)),
        ]);
        facts.extend(
            row.pass.p_brighter.map(|p| format!("brighter than the limit with probability {:.0} %", 100.0 * p)),
        );
        facts.extend(light.map(|light| format!("magnitude from {}", light.source)));
        let (age_days, sigma_s) = (row.pass.element_age_days, row.pass.along_track_sigma_s);
        facts.push(format!("elements {age_days:.1} days old, times \u{b1} {sigma_s:.1} s"));
        line(format!("DESCRIPTION:{}", escaped(&facts.join("\n"))));
        line(format!("LOCATION:{}", escaped(&site.name)));
        line(format!("GEO:{:.6};{:.6}", site.latitude_rad.to_degrees(), site.longitude_rad.to_degrees()));
        line("TRANSP:TRANSPARENT".into());
        if let Some(alarm_s) = alarm_s {
            line("BEGIN:VALARM".into());
            line("ACTION:DISPLAY".into());
            line(format!("TRIGGER:-PT{:.0}S", alarm_s.max(0.0)));
            line(format!("DESCRIPTION:{}", escaped(&row.name())));
            line("END:VALARM".into());
        }
        line("END:VEVENT".into());
    }
    if let Some(EmptyNight { start, end, why, is_unknown }) = empty {
        line("BEGIN:VEVENT".into());
        line(format!("UID:none-{}-{}@streakcast", stamp(start), stamp(end)));
        line(format!("DTSTAMP:{}", stamp(made)));
        line(format!("DTSTART:{}", stamp(start)));
        line(format!("DTEND:{}", stamp(seconds_after(end, 1.0))));
        let summary = if is_unknown { "Unknown satellite passes" } else { "No visible satellite pass" };
        line(format!("SUMMARY:{}", escaped(&format!("{summary} over {}", site.name))));
        line(format!("DESCRIPTION:{}", escaped(why)));
        line(format!("LOCATION:{}", escaped(&site.name)));
        line("TRANSP:TRANSPARENT".into());
        line("END:VEVENT".into());
    }
    line("END:VCALENDAR".into());
    text
}

fn point_text(what: &str, point: &TrackPoint, utc_offset_s: f64, step_s: f64) -> String {
    let (altitude_rad, azimuth_rad) = (point.altitude_rad.unwrap_or(f64::NAN), point.azimuth_rad.unwrap_or(f64::NAN));
    let clock = clock(point.epoch, utc_offset_s, step_s);
    let zone = utc_offset(utc_offset_s);
    let direction = compass(azimuth_rad);
    format!("{what} {clock} {zone}, altitude {:.0}\u{b0}, {direction}", altitude_rad.to_degrees())
}

/// Formats a time as `20240814T003000Z`; fractions of a second are dropped.
fn stamp(epoch: Epoch) -> String {
    format_utc(epoch, 9).chars().take(19).filter(|mark| !matches!(mark, '-' | ':')).chain(['Z']).collect()
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for mark in text.chars() {
        match mark {
            '\\' | ';' | ',' => out.extend(['\\', mark]),
            '\n' => out.push_str("\\n"),
            mark if mark.is_control() => out.push(' '),
            mark => out.push(mark),
        }
    }
    out
}

/// Appends a content line, folded between characters into lines of at most 75 bytes. Continuation lines begin with a
/// blank, which is included in the 75 bytes.
fn fold(text: &mut String, content: &str) {
    let mut free = LINE;
    for mark in content.chars() {
        if mark.len_utf8() > free {
            text.push_str("\r\n ");
            free = LINE - 1;
        }
        text.push(mark);
        free -= mark.len_utf8();
    }
    text.push_str("\r\n");
}

/// Longest comment of a TDM, characters. The format limits lines, including their keyword, to 254.
const LONGEST_COMMENT: usize = 240;

/// Pair of angles in a TDM.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum AngleType {
    /// Right ascension and declination: topocentric astrometric position, ICRS.
    #[default]
    RaDec,
    /// Azimuth from north through east, and altitude without refraction.
    AzEl,
}

impl AngleType {
    /// Returns the angle type with this name: `radec` or `azel`; case is ignored.
    pub fn by_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "radec" => Some(Self::RaDec),
            "azel" => Some(Self::AzEl),
            _ => None,
        }
    }

    /// Returns the value of the keyword `ANGLE_TYPE`.
    pub fn name(self) -> &'static str {
        match self {
            Self::RaDec => "RADEC",
            Self::AzEl => "AZEL",
        }
    }
}

/// Returns the visible passes as a CCSDS Tracking Data Message (503.0-B-2, version 2.0) in keyword-value notation, with
/// angles and magnitudes and one segment for each pass. `made` is the time of creation.
///
/// A segment contains the samples of the visible part; for a pass without samples, its begin, highest point, brightest
/// point and end. The provenance is in comments of the header.
pub fn tdm<'a>(
    rows: impl IntoIterator<Item = PassRow<'a>>,
    site: &Site,
    made: Epoch,
    angles: AngleType,
    provenance: &Provenance,
) -> String {
    let mut text = String::from("CCSDS_TDM_VERS = 2.0\n");
    text += "COMMENT Predictions from element sets and brightness models, not observations.\n";
    for (name, value) in provenance.entries() {
        comment(&mut text, &format!("{name}: {value}"));
    }
    let _ = writeln!(text, "CREATION_DATE = {}", calendar_time(made));
    text += "ORIGINATOR = STREAKCAST\n";
    for row in rows {
        segment(&mut text, &row, site, angles);
    }
    text
}

/// Appends a comment, on several lines if it is long.
fn comment(text: &mut String, content: &str) {
    let printable = |mark: char| if mark.is_control() { ' ' } else { mark };
    let marks: Vec<char> = content.chars().map(printable).collect();
    for line in marks.chunks(LONGEST_COMMENT) {
        let _ = writeln!(text, "COMMENT {}", line.iter().collect::<String>());
    }
}

fn segment(text: &mut String, row: &PassRow<'_>, site: &Site, angles: AngleType) {
    let points = points(row);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    let station = site.mpc_code.as_deref().unwrap_or(&site.name);
    let designator = &row.elements.international_designator;
    let satellite = if designator.is_empty() { row.pass.norad_id.to_string() } else { designator.to_string() };
    let light = row.peak().and_then(|peak| peak.brightness.as_ref());
    text.push_str("\nMETA_START\n");
    let _ = writeln!(text, "COMMENT {} NORAD {}", row.name(), row.pass.norad_id);
    if let Some(light) = light {
        let sigma = light.sigma_mag;
        let _ = writeln!(text, "COMMENT MAG predicted by {}, one sigma {sigma:.2} mag at the peak", light.source);
    }
    if angles == AngleType::RaDec {
        text.push_str("COMMENT Astrometric: light time and annual aberration as for catalogue stars\n");
    }
    text.push_str("TIME_SYSTEM = UTC\n");
    let _ = writeln!(text, "START_TIME = {}\nSTOP_TIME = {}", calendar_time(first.epoch), calendar_time(last.epoch));
    let _ = writeln!(text, "PARTICIPANT_1 = {station}\nPARTICIPANT_2 = {satellite}");
    text.push_str("MODE = SEQUENTIAL\nPATH = 2,1\n");
    let _ = writeln!(text, "ANGLE_TYPE = {}", angles.name());
    if angles == AngleType::RaDec {
        text.push_str("REFERENCE_FRAME = ICRF\n");
    }
    text.push_str("META_STOP\n\nDATA_START\n");
    for point in points {
        let time = calendar_time(point.epoch);
        let (one_rad, other_rad) = match angles {
            AngleType::RaDec => (Some(point.direction.longitude_rad()), Some(point.direction.latitude_rad())),
            AngleType::AzEl => (point.azimuth_rad, point.altitude_rad),
        };
        for (name, angle_rad) in [("ANGLE_1", one_rad), ("ANGLE_2", other_rad)] {
            if let Some(angle_rad) = angle_rad {
                let _ = writeln!(text, "{name} = {time} {:.6}", angle_rad.to_degrees());
            }
        }
        if let Some(light) = &point.brightness {
            let _ = writeln!(text, "MAG = {time} {:.3}", light.magnitude.0);
        }
    }
    text.push_str("DATA_STOP\n");
}

/// Returns the distinct points of the visible part in time order.
fn points<'a>(row: &PassRow<'a>) -> Vec<&'a TrackPoint> {
    let Some(seen) = &row.pass.visible else { return Vec::new() };
    let within = |point: &&TrackPoint| point.epoch > seen.begin.epoch && point.epoch < seen.end.epoch;
    let mut points: Vec<&TrackPoint> = vec![&seen.begin, &seen.end];
    if row.pass.samples.is_empty() {
        points.extend([Some(&seen.highest), seen.peak.as_ref()].into_iter().flatten().filter(within));
    } else {
        points.extend(row.pass.samples.iter().filter(within));
    }
    points.sort_by_key(|point| point.epoch);
    points.dedup_by(|a, b| a.epoch == b.epoch);
    points
}

/// Formats a time as `2024-08-14T00:30:00.000000`, without the Z, which a TDM does not use.
fn calendar_time(epoch: Epoch) -> String {
    format_utc(epoch, 6).trim_end_matches('Z').to_owned()
}

/// Header line of a SCORE file.
const SCORE_HEADER: &str = "satellite_name,norad_cat_id,observation_time_utc,observation_time_uncertainty_sec,apparent_magnitude,apparent_magnitude_uncertainty,observer_latitude_deg,observer_longitude_deg,observer_altitude_m,limiting_magnitude,instrument,observing_mode,observing_filter,observer_email,observer_orcid,satellite_right_ascension_deg,satellite_declination_deg,sigma_2_ra,sigma_ra_sigma_dec,sigma_2_dec,range_to_satellite_km,range_to_satellite_uncertainty_km,range_rate_of_satellite_km_per_sec,range_rate_of_satellite_uncertainty_km_per_sec,comments,data_archive_link,mpc_code";

/// Returns the passes in the columns of SCORE, the archive of satellite photometry of the IAU's Centre for the
/// Protection of the Dark and Quiet Sky (CPS), for comparison with measurements.
///
/// Each pass with a magnitude has one row, at its brightest point. Passes without a magnitude are omitted, because in
/// SCORE a row without a magnitude is a non-detection.
///
/// Columns that describe a measurement (time error, instrument, mode, observer, limiting magnitude) are empty, and the
/// comment states that the row is predicted. Do not upload such a file to SCORE.
pub fn score_report<'a>(
    rows: impl IntoIterator<Item = PassRow<'a>>,
    site: &Site,
    photometry: &PhotometryOptions,
) -> String {
    let mut text = format!("{SCORE_HEADER}\n");
    for row in rows {
        let Some((peak, light)) = row.peak().and_then(|peak| Some((peak, peak.brightness.as_ref()?))) else { continue };
        let comment = format!(
            "predicted by streakcast {}, not observed: {} {} by {}, elements {:.1} days old",
            env!("CARGO_PKG_VERSION"),
            photometry.band,
            photometry.system,
            light.source,
            row.pass.element_age_days,
        );
        let cells = [
            row.name(),
            row.pass.norad_id.to_string(),
            format_utc(peak.epoch, 3),
            String::new(),
            format!("{:.3}", light.magnitude.0),
            format!("{:.3}", light.sigma_mag),
            format!("{:.6}", site.latitude_rad.to_degrees()),
            format!("{:.6}", site.longitude_rad.to_degrees()),
            format!("{:.1}", site.height_m),
            String::new(),
            String::new(),
            String::new(),
            photometry.band.to_string(),
            String::new(),
            String::new(),
            format!("{:.6}", peak.direction.longitude_rad().to_degrees()),
            format!("{:.6}", peak.direction.latitude_rad().to_degrees()),
            String::new(),
            String::new(),
            String::new(),
            format!("{:.3}", peak.range_km),
            String::new(),
            String::new(),
            String::new(),
            comment,
            String::new(),
            site.mpc_code.clone().unwrap_or_default(),
        ];
        let cells: Vec<String> = cells.iter().map(|cell| csv_cell(cell)).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_folded_between_characters_and_unfold_to_themselves() {
        for content in ["short".to_owned(), "x".repeat(75), "x".repeat(76), "\u{b0}".repeat(200), "a\u{b1}".repeat(60)]
        {
            let mut text = String::new();
            fold(&mut text, &content);
            assert!(text.ends_with("\r\n"));
            assert!(text.split("\r\n").all(|line| line.len() <= LINE), "{text:?}");
            assert_eq!(text.trim_end().replace("\r\n ", ""), content);
        }
    }

    #[test]
    fn text_is_escaped_and_seconds_are_cut() {
        assert_eq!(escaped("a;b,c\\d\ne\u{7}"), "a\\;b\\,c\\\\d\\ne ");
        assert_eq!(stamp(Epoch::from_gregorian_utc(2024, 8, 14, 23, 59, 59, 999_000_000)), "20240814T235959Z");
    }
}
