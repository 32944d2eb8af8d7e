//! Metadata of one segment of an OEM: satellite, frame, time system and end.

use std::sync::Arc;

use hifitime::{Epoch, TimeScale, Unit};

use super::super::element_set::NoradId;
use super::super::epoch::{parse_iso, parse_iso_with_time};
use super::super::record::excerpt;
use super::builder::{Builder, Problem};
use super::data::{CovarianceAxes, EphemerisFrame, EphemerisObject};

const FRAMES: &str = "EME2000, J2000, GCRF, ICRF, TEME or ITRF with its year";
const TIME: &str = "a date and time such as 2026-07-08T17:37:14.092";
const TIME_SYSTEMS: &str = "UTC, TAI, TT or GPS";

/// Keywords of the metadata of an OEM (CCSDS 502.0-B).
const KEYWORDS: [&str; 13] = [
    "OBJECT_NAME",
    "OBJECT_ID",
    "CENTER_NAME",
    "REF_FRAME",
    "REF_FRAME_EPOCH",
    "TIME_SYSTEM",
    "START_TIME",
    "USEABLE_START_TIME",
    "USEABLE_STOP_TIME",
    "STOP_TIME",
    "INTERPOLATION",
    "INTERPOLATION_DEGREE",
    "COMMENT",
];

/// Values of the metadata keywords of a segment.
#[derive(Default)]
pub(super) struct Metadata {
    name: String,
    object: Option<EphemerisObject>,
    frame: Option<EphemerisFrame>,
    /// Name of the frame as written in the file.
    frame_name: String,
    /// TAI minus the time system of the segment, seconds; `None` for UTC.
    tai_lag_s: Option<f64>,
    has_time_system: bool,
    stated: [Option<(usize, String)>; 2],
    frame_epoch: Option<(usize, String)>,
    usable: [Option<(usize, String)>; 2],
}

impl Metadata {
    /// Stores the value of a keyword.
    pub fn set(&mut self, line: usize, keyword: &str, value: &str) -> Result<(), Problem> {
        let value = value.trim();
        match keyword {
            "OBJECT_NAME" => self.name = value.to_owned(),
            "OBJECT_ID" => self.object = Some(object(line, value)?),
            "CENTER_NAME" if !value.eq_ignore_ascii_case("EARTH") => {
                return Err(Problem::new(line, "CENTER_NAME", value, "EARTH"));
            }
            "REF_FRAME" => {
                self.frame = Some(frame(value).ok_or_else(|| Problem::new(line, "REF_FRAME", value, FRAMES))?);
                self.frame_name = value.to_ascii_uppercase();
            }
            "TIME_SYSTEM" => {
                self.has_time_system = true;
                self.tai_lag_s = match value.to_ascii_uppercase().as_str() {
                    "UTC" => None,
                    "TAI" => Some(0.0),
                    "TT" => Some(-32.184),
                    "GPS" => Some(19.0),
                    _ => return Err(Problem::new(line, "TIME_SYSTEM", value, TIME_SYSTEMS)),
                };
            }
            "REF_FRAME_EPOCH" => self.frame_epoch = Some((line, value.to_owned())),
            "USEABLE_START_TIME" => self.usable[0] = Some((line, value.to_owned())),
            "USEABLE_STOP_TIME" => self.usable[1] = Some((line, value.to_owned())),
            "START_TIME" => self.stated[0] = Some((line, value.to_owned())),
            "STOP_TIME" => self.stated[1] = Some((line, value.to_owned())),
            known if KEYWORDS.contains(&known) => {}
            // A misspelt limit of the usable interval must not be ignored.
            unknown => {
                let nearest = KEYWORDS.iter().min_by_key(|known| strsim::levenshtein(known, unknown));
                let allowed = format!("{}, the most similar of {}", nearest.unwrap_or(&""), KEYWORDS.join(", "));
                return Err(Problem::new(line, "keyword in the metadata", excerpt(unknown.as_bytes()), allowed));
            }
        }
        Ok(())
    }

    /// Creates the ephemeris of the segment after the end of its metadata at `line`. `created` is the creation time of
    /// the message.
    pub fn builder(&self, line: usize, created: Option<Epoch>) -> Result<Builder, Problem> {
        let missing = |what: &str, allowed: &str| Problem::new(line, what, "missing", allowed);
        let object = self.object.clone().ok_or_else(|| missing("OBJECT_ID", OBJECTS))?;
        let frame = self.frame.ok_or_else(|| missing("REF_FRAME", FRAMES))?;
        if !self.has_time_system {
            return Err(missing("TIME_SYSTEM", TIME_SYSTEMS));
        }
        // EME2000 and GCRF do not depend on a frame epoch.
        if let (EphemerisFrame::Teme | EphemerisFrame::Itrf, Some((line, epoch))) = (frame, &self.frame_epoch) {
            let allowed = format!("omitted with {}, which is that of the time of each state", self.frame_name);
            return Err(Problem::new(*line, "REF_FRAME_EPOCH", epoch, allowed));
        }
        let times = |names: [&str; 2], texts: &[Option<(usize, String)>; 2]| -> Result<[Option<Epoch>; 2], Problem> {
            let mut epochs = [None; 2];
            for ((to, name), from) in epochs.iter_mut().zip(names).zip(texts) {
                *to = from.as_ref().map(|(line, text)| self.epoch(*line, name, text)).transpose()?;
            }
            Ok(epochs)
        };
        let stated = times(["START_TIME", "STOP_TIME"], &self.stated)?;
        let names = ["USEABLE_START_TIME", "USEABLE_STOP_TIME"];
        let usable = times(names, &self.usable)?;
        if let ([Some(from), Some(to)], Some((line, text))) = (usable, &self.usable[1])
            && to < from
        {
            return Err(Problem::new(*line, names[1], text, format!("a time after that of {}, {from}", names[0])));
        }
        Ok(Builder::new(object, &self.name, frame, created).usable(usable).stated(stated))
    }

    /// Parses a time in the time system of the segment.
    pub fn epoch(&self, line: usize, what: &str, text: &str) -> Result<Epoch, Problem> {
        if parse_iso_with_time(text).is_none() {
            return Err(Problem::new(line, what, format!("{:?}", text.trim()), TIME));
        }
        let epoch = time(line, what, text)?;
        Ok(match self.tai_lag_s {
            None => epoch,
            Some(lag_s) => Epoch::from_duration(epoch.duration + lag_s * Unit::Second, TimeScale::TAI)
                .to_time_scale(TimeScale::UTC),
        })
    }

    /// Returns the axes of a covariance; those of the states if the keyword is omitted.
    pub fn axes(&self, line: usize, name: Option<&str>) -> Result<CovarianceAxes, Problem> {
        let Some(name) = name else { return Ok(CovarianceAxes::States) };
        match name.to_ascii_uppercase().as_str() {
            "RTN" | "RSW" | "UVW" => Ok(CovarianceAxes::Radial),
            "TNW" => Ok(CovarianceAxes::Tangential),
            other if other == self.frame_name => Ok(CovarianceAxes::States),
            _ => {
                let allowed = format!("RTN, RSW, UVW, TNW or the frame of the states, {}", self.frame_name);
                Err(Problem::new(line, "COV_REF_FRAME", name, allowed))
            }
        }
    }
}

/// Parses a date and time without conversion from the time system. CREATION_DATE is always UTC.
pub(super) fn time(line: usize, what: &str, text: &str) -> Result<Epoch, Problem> {
    parse_iso(text.trim()).ok_or_else(|| Problem::new(line, what, format!("{:?}", text.trim()), TIME))
}

const OBJECTS: &str = "a designator such as 1998-067A, or a NORAD catalogue number";

fn object(line: usize, text: &str) -> Result<EphemerisObject, Problem> {
    if let Ok(norad_id) = text.parse::<u32>() {
        return Ok(EphemerisObject::Norad(NoradId(norad_id)));
    }
    // The designator may also be written as 1998-067-A.
    let mut parts = text.splitn(2, '-');
    let (year, rest) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default().replace('-', ""));
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let is_designator = year.len() == 4
        && year.bytes().all(|byte| byte.is_ascii_digit())
        && digits == 3
        && (4..=6).contains(&rest.len())
        && rest[digits..].bytes().all(|byte| byte.is_ascii_uppercase());
    if !is_designator {
        return Err(Problem::new(line, "OBJECT_ID", format!("{text:?}"), OBJECTS));
    }
    Ok(EphemerisObject::Designator(Arc::from(format!("{year}-{rest}"))))
}

fn frame(name: &str) -> Option<EphemerisFrame> {
    match name.to_ascii_uppercase().as_str() {
        "EME2000" | "J2000" => Some(EphemerisFrame::Eme2000),
        "GCRF" | "ICRF" => Some(EphemerisFrame::Gcrf),
        "TEME" => Some(EphemerisFrame::Teme),
        name if name.starts_with("ITRF") => Some(EphemerisFrame::Itrf),
        _ => None,
    }
}
