//! Predictions as a CCSDS Tracking Data Message (503.0-B-2, version 2.0) in keyword-value notation: angles and magnitude, a segment a pass.

use std::fmt::Write as _;

use hifitime::Epoch;

use super::pass_table::PassRow;
use crate::geometry::Site;
use crate::output::{Provenance, format_utc};
use crate::passes::TrackPoint;

/// A line holds 254 characters at most in this notation, with its keyword.
const LONGEST_COMMENT: usize = 240;

/// Which two angles a message holds.
#[derive(Copy, Clone, Debug, Default, PartialEq, Eq)]
pub enum AngleType {
    /// Right ascension and declination, ICRS astrometric topocentric.
    #[default]
    RaDec,
    /// Azimuth from north through east, and altitude without refraction.
    AzEl,
}

impl AngleType {
    /// By name: `radec` or `azel`, in any case.
    pub fn by_name(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "radec" => Some(Self::RaDec),
            "azel" => Some(Self::AzEl),
            _ => None,
        }
    }

    /// As the message spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::RaDec => "RADEC",
            Self::AzEl => "AZEL",
        }
    }
}

/// The visible passes as a message that was made at `made`; each has the points of its samples that can be seen, or without samples its begin, highest,
/// brightest and end.
///
/// The provenance stands in comments of the header. Magnitudes stand where the model sees anything.
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

/// A comment, on as many lines as its length needs.
fn comment(text: &mut String, words: &str) {
    let printable = |mark: char| if mark.is_control() { ' ' } else { mark };
    let marks: Vec<char> = words.chars().map(printable).collect();
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

/// Points of the visible part in order of time, none twice.
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

/// `2024-08-14T00:30:00.000000`, without the Z, which the message leaves out where the time system says UTC.
fn calendar_time(epoch: Epoch) -> String {
    format_utc(epoch, 6).trim_end_matches('Z').to_owned()
}
