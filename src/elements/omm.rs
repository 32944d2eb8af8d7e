//! Orbit mean-elements messages (CCSDS 502.0-B, OMM) as keywords with text values, common to JSON, CSV, XML and KVN.
//!
//! Numbers are kept as text and parsed once, correctly rounded, so that the four syntaxes and a TLE with the same
//! decimals give the same bits. Only elements for SGP4 are supported: theory SGP4 (or TLE), frame TEME, time system
//! UTC. These three keywords are optional, since CelesTrak's JSON and CSV omit them. B* and the mean motion are
//! required; the derivatives of the mean motion are optional.
//!
//! A record that contains the two lines of a TLE (Space-Track's `TLE_LINE1`, `Line1` in other tables) instead of mean
//! elements is read from these lines.

use std::borrow::Cow;
use std::sync::Arc;

use super::element_set::{ElementSet, NoradId, Origin};
use super::epoch;
use super::on_station::{DAY_MIN, semi_major_axis_km};
use super::record::{Parsed, checked, excerpt};
use super::tle::{Checksums, parse_lines};
use super::tle_fields::parse_five_characters;
use crate::error::Error;
use crate::message::Quoted;

/// Supported keywords. All others in a record are ignored.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Keyword {
    ObjectName,
    ObjectId,
    NoradCatId,
    Epoch,
    MeanMotion,
    Eccentricity,
    Inclination,
    RaOfAscNode,
    ArgOfPericenter,
    MeanAnomaly,
    Bstar,
    MeanMotionDot,
    MeanMotionDdot,
    RevAtEpoch,
    EphemerisType,
    MeanElementTheory,
    RefFrame,
    TimeSystem,
    CenterName,
    DecayDate,
    Decayed,
    Period,
    SemimajorAxis,
    TleLine1,
    TleLine2,
}

/// Number of keywords.
const KEYWORDS: usize = Keyword::TleLine2 as usize + 1;

impl Keyword {
    /// Returns the keyword for a CCSDS keyword, column title or JSON key; case is ignored, common spellings are read.
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        if text.len() > 20 {
            return None;
        }
        let mut buffer = [0_u8; 20];
        for (to, from) in buffer.iter_mut().zip(text.bytes()) {
            *to = from.to_ascii_uppercase();
        }
        Some(match buffer.get(..text.len())? {
            b"OBJECT_NAME" | b"OBJECTNAME" | b"NAME" | b"SATNAME" | b"SAT_NAME" => Self::ObjectName,
            b"OBJECT_ID" | b"OBJECTID" | b"INTLDES" | b"COSPAR_ID" => Self::ObjectId,
            b"NORAD_CAT_ID" | b"NORADID" | b"NORAD_ID" | b"SATELLITEID" => Self::NoradCatId,
            b"EPOCH" => Self::Epoch,
            b"MEAN_MOTION" => Self::MeanMotion,
            b"ECCENTRICITY" => Self::Eccentricity,
            b"INCLINATION" => Self::Inclination,
            b"RA_OF_ASC_NODE" => Self::RaOfAscNode,
            b"ARG_OF_PERICENTER" => Self::ArgOfPericenter,
            b"MEAN_ANOMALY" => Self::MeanAnomaly,
            b"BSTAR" => Self::Bstar,
            b"MEAN_MOTION_DOT" => Self::MeanMotionDot,
            b"MEAN_MOTION_DDOT" => Self::MeanMotionDdot,
            b"REV_AT_EPOCH" => Self::RevAtEpoch,
            b"EPHEMERIS_TYPE" => Self::EphemerisType,
            b"MEAN_ELEMENT_THEORY" => Self::MeanElementTheory,
            b"REF_FRAME" => Self::RefFrame,
            b"TIME_SYSTEM" => Self::TimeSystem,
            b"CENTER_NAME" => Self::CenterName,
            b"DECAY_DATE" | b"DECAYDATE" => Self::DecayDate,
            b"DECAYED" => Self::Decayed,
            b"PERIOD" => Self::Period,
            b"SEMIMAJOR_AXIS" | b"SEMI_MAJOR_AXIS" => Self::SemimajorAxis,
            b"TLE_LINE1" | b"LINE1" | b"LINE_1" | b"TLE1" => Self::TleLine1,
            b"TLE_LINE2" | b"LINE2" | b"LINE_2" | b"TLE2" => Self::TleLine2,
            _ => return None,
        })
    }

    /// Returns the keyword for a user-defined parameter of XML (the attribute `parameter`) or KVN (without its prefix
    /// `USER_DEFINED_`). Only those that Space-Track adds to the keywords of the standard are read.
    pub fn of_user(parameter: &str) -> Option<Self> {
        let added = [Self::DecayDate, Self::Decayed, Self::Period, Self::SemimajorAxis, Self::TleLine1, Self::TleLine2];
        Self::parse(parameter).filter(|keyword| added.contains(keyword))
    }

    /// Returns the spellings of the unit in which the value is read; `None` for a value that has no unit or is ignored.
    fn units(self) -> Option<&'static [&'static str]> {
        Some(match self {
            Self::MeanMotion => &["rev/day", "revs/day", "rev/d"],
            Self::Eccentricity => &["1", "none", "n/a", "-"],
            Self::Inclination | Self::RaOfAscNode | Self::ArgOfPericenter | Self::MeanAnomaly => {
                &["deg", "degree", "degrees"]
            }
            Self::Bstar => &["1/ER", "ER**-1", "1/earth radii"],
            Self::MeanMotionDot => &["rev/day**2", "rev/day^2", "rev/day2", "rev/d**2"],
            Self::MeanMotionDdot => &["rev/day**3", "rev/day^3", "rev/day3", "rev/d**3"],
            _ => return None,
        })
    }
}

/// Largest difference of the period and the semi-major axis from those of the mean motion, relative.
const LARGEST_DISAGREEMENT: f64 = 0.01;

/// Text values of one record, by keyword; keywords without text are absent.
#[derive(Debug, Default)]
pub(super) struct Fields<'a> {
    texts: [Cow<'a, str>; KEYWORDS],
    /// Reason for the rejection of the record: a value in a unit that is not read.
    wrong_unit: Option<String>,
}

impl<'a> Fields<'a> {
    /// Stores a text. If a keyword is repeated, the last value is used.
    pub fn set(&mut self, keyword: Keyword, text: Cow<'a, str>) {
        self.texts[keyword as usize] = text;
    }

    /// Checks the unit that the file states for the value of a keyword; `name` is the keyword in the file.
    pub fn check_unit(&mut self, keyword: Keyword, name: &str, unit: &str) {
        let unit = unit.trim();
        if let Some(units) = keyword.units()
            && !unit.is_empty()
            && !units.iter().any(|known| known.eq_ignore_ascii_case(unit))
        {
            let given = Quoted::new(excerpt(unit.as_bytes()));
            self.wrong_unit = Some(format!("unsupported unit {given:?} of {}: allowed {}", name.trim(), units[0]));
        }
    }

    /// Returns the trimmed text; `None` if it is absent or empty.
    pub fn get(&self, keyword: Keyword) -> Option<&str> {
        let text = self.texts[keyword as usize].trim();
        (!text.is_empty() && text != "null").then_some(text)
    }

    /// Removes all texts.
    pub fn clear(&mut self) {
        self.texts.fill(Cow::Borrowed(""));
        self.wrong_unit = None;
    }

    /// Returns true if there are no texts.
    pub fn is_empty(&self) -> bool {
        self.texts.iter().all(|text| text.is_empty())
    }

    /// Returns true if the texts describe an orbit. A JSON object with only a name may describe a list of records.
    pub fn is_record(&self) -> bool {
        let describing =
            [Keyword::NoradCatId, Keyword::Epoch, Keyword::MeanMotion, Keyword::TleLine1, Keyword::TleLine2];
        describing.iter().any(|keyword| self.get(*keyword).is_some())
    }

    /// Returns the catalogue number and the name as far as the record has them, for error messages.
    pub fn object(&self) -> String {
        let text = |keyword| self.get(keyword).map(|text| Quoted::new(excerpt(text.as_bytes())));
        match (text(Keyword::NoradCatId), text(Keyword::ObjectName)) {
            (Some(number), Some(name)) => format!(", object {number}, {name}"),
            (Some(number), None) => format!(", object {number}"),
            (None, Some(name)) => format!(", {name}"),
            (None, None) => String::new(),
        }
    }

    /// Creates the element set, and adds it or the reason for its rejection to `parsed`.
    pub fn finish(&self, offset: usize, checksums: Checksums, parsed: &mut Parsed) {
        // Mean elements take precedence over TLE lines, because they have more digits.
        if self.get(Keyword::MeanMotion).is_none()
            && let (Some(line1), Some(line2)) = (self.get(Keyword::TleLine1), self.get(Keyword::TleLine2))
        {
            let name = self.get(Keyword::ObjectName).unwrap_or_default();
            match parse_lines(name.as_bytes(), line1.as_bytes(), line2.as_bytes(), checksums) {
                Ok((set, overlooked)) => {
                    parsed.take(offset, self.decayed(set.epoch).map(|decayed| ElementSet { decayed, ..set }));
                    parsed.bad_checksums_accepted += usize::from(overlooked);
                }
                Err((_, reason)) => parsed.take(offset, Err(reason)),
            }
            return;
        }
        parsed.take(offset, self.element_set());
    }

    fn element_set(&self) -> Result<ElementSet, Error> {
        self.check_theory()?;
        if let Some(reason) = &self.wrong_unit {
            return Err(Error::format(reason.clone()));
        }
        let norad_id = self.text(Keyword::NoradCatId, "NORAD_CAT_ID")?;
        let norad_id = parse_norad_id(norad_id).ok_or_else(|| {
            Error::format(format!(
                "invalid NORAD_CAT_ID {:?}: expected 1 to 999999999, or Alpha-5",
                Quoted::new(excerpt(norad_id.as_bytes()))
            ))
        })?;
        let epoch_text = self.text(Keyword::Epoch, "EPOCH")?;
        // A date alone is not an epoch: a satellite in a low orbit makes 16 revolutions a day.
        let epoch = epoch::parse_iso_with_time(epoch_text).ok_or_else(|| {
            Error::format(format!(
                "invalid epoch {:?}: expected UTC as YYYY-MM-DDThh:mm:ss.ssssss or YYYY-DDDThh:mm:ss.ssssss",
                Quoted::new(excerpt(epoch_text.as_bytes()))
            ))
        })?;
        let revolution = self.optional(Keyword::RevAtEpoch, "REV_AT_EPOCH")?;
        let set = ElementSet {
            norad_id,
            name: self.shared(Keyword::ObjectName),
            international_designator: self.shared(Keyword::ObjectId),
            epoch,
            mean_motion_rev_day: self.number(Keyword::MeanMotion, "MEAN_MOTION")?,
            eccentricity: self.number(Keyword::Eccentricity, "ECCENTRICITY")?,
            inclination_deg: self.number(Keyword::Inclination, "INCLINATION")?,
            right_ascension_of_node_deg: self.number(Keyword::RaOfAscNode, "RA_OF_ASC_NODE")?,
            argument_of_perigee_deg: self.number(Keyword::ArgOfPericenter, "ARG_OF_PERICENTER")?,
            mean_anomaly_deg: self.number(Keyword::MeanAnomaly, "MEAN_ANOMALY")?,
            bstar_per_earth_radius: self.number(Keyword::Bstar, "BSTAR")?,
            mean_motion_dot_rev_day2: self.optional(Keyword::MeanMotionDot, "MEAN_MOTION_DOT")?,
            mean_motion_ddot_rev_day3: self.optional(Keyword::MeanMotionDdot, "MEAN_MOTION_DDOT")?,
            // `as` saturates and converts NaN to 0.
            revolution_at_epoch: revolution as u32,
            decayed: self.decayed(epoch)?,
            origin: Origin::Published,
        };
        let set = checked(set)?;
        self.check_period(&set)?;
        Ok(set)
    }

    /// Checks that the period, min, and the semi-major axis, km, of Space-Track agree with the mean motion.
    fn check_period(&self, set: &ElementSet) -> Result<(), Error> {
        let motion = set.mean_motion_rev_day;
        for (keyword, field, expected) in [
            (Keyword::Period, "PERIOD", DAY_MIN / motion),
            (Keyword::SemimajorAxis, "SEMIMAJOR_AXIS", semi_major_axis_km(set)),
        ] {
            let value = self.get(keyword).and_then(|text| text.parse::<f64>().ok());
            // 0 is unknown.
            if let Some(value) =
                value.filter(|value| *value > 0.0 && (value / expected - 1.0).abs() > LARGEST_DISAGREEMENT)
            {
                return Err(Error::format(format!(
                    "MEAN_MOTION is {motion} and {field} is {value}: they contradict each other; allowed: {field} within \
                     1 % of {expected:.3}"
                )));
            }
        }
        Ok(())
    }

    /// Returns the time of DECAY_DATE, or the end of its day if it has no time. Midnight is that of a date without a
    /// time. A satellite that has decayed (DECAYED is 1, of Space-Track) without a date has decayed at an unknown time
    /// after its epoch: its positions are unknown from `epoch` on.
    fn decayed(&self, epoch: hifitime::Epoch) -> Result<Option<hifitime::Epoch>, Error> {
        let Some(text) = self.get(Keyword::DecayDate) else {
            let has_decayed = self
                .get(Keyword::Decayed)
                .is_some_and(|text| ["1", "Y", "YES", "TRUE"].iter().any(|word| word.eq_ignore_ascii_case(text)));
            return Ok(has_decayed.then_some(epoch));
        };
        let (date, time) = text.trim().split_once(['T', ' ']).unwrap_or((text.trim(), ""));
        let has_time = time.contains(|c: char| matches!(c, '1'..='9'));
        let decayed = epoch::parse_iso(if has_time { text } else { date }).ok_or_else(|| {
            Error::format(format!(
                "invalid epoch {:?}: expected DECAY_DATE as YYYY-MM-DD or YYYY-MM-DDThh:mm:ss",
                Quoted::new(excerpt(text.as_bytes()))
            ))
        })?;
        Ok(Some(if has_time { decayed } else { decayed + hifitime::Unit::Day * 1 }))
    }

    /// Accepts only elements for SGP4. Elements of another theory have the same form, but give errors of kilometres.
    fn check_theory(&self) -> Result<(), Error> {
        let allowed: [(Keyword, &str, &[&str], &str); 5] = [
            (
                Keyword::MeanElementTheory,
                "MEAN_ELEMENT_THEORY",
                &["SGP4", "TLE", "SGP", "SDP4", "SGP/SGP4", "SGP4/SDP4"],
                "SGP4",
            ),
            (Keyword::RefFrame, "REF_FRAME", &["TEME", "TEMEOFDATE", "TEME OF DATE"], "TEME"),
            (Keyword::TimeSystem, "TIME_SYSTEM", &["UTC"], "UTC"),
            (Keyword::CenterName, "CENTER_NAME", &["EARTH"], "EARTH"),
            (
                Keyword::EphemerisType,
                "EPHEMERIS_TYPE",
                &["0", "0.0", "1", "2", "3", "5", "SGP", "SGP4", "SDP4"],
                "0 (SGP4); 4 means SGP4-XP elements, which require another propagator",
            ),
        ];
        for (keyword, field, values, words) in allowed {
            if let Some(text) = self.get(keyword)
                && !values.iter().any(|value| value.eq_ignore_ascii_case(text))
            {
                return Err(Error::format(format!(
                    "unsupported {field} {:?}: allowed {words}",
                    Quoted::new(excerpt(text.as_bytes()))
                )));
            }
        }
        Ok(())
    }

    fn text(&self, keyword: Keyword, field: &'static str) -> Result<&str, Error> {
        self.get(keyword).ok_or_else(|| Error::format(format!("{field} is missing")))
    }

    fn number(&self, keyword: Keyword, field: &'static str) -> Result<f64, Error> {
        parse_number(self.text(keyword, field)?, field)
    }

    fn optional(&self, keyword: Keyword, field: &'static str) -> Result<f64, Error> {
        self.get(keyword).map_or(Ok(0.0), |text| parse_number(text, field))
    }

    fn shared(&self, keyword: Keyword) -> Arc<str> {
        self.get(keyword).map(Arc::from).unwrap_or_default()
    }
}

/// Parses a finite number, correctly rounded.
fn parse_number(text: &str, field: &'static str) -> Result<f64, Error> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| Error::format(format!("{field} {:?} is not a number", Quoted::new(excerpt(text.as_bytes())))))
}

/// Parses one to nine digits, also as a float (`28485.0`, as written by data frames with missing values), or Alpha-5.
fn parse_norad_id(text: &str) -> Option<NoradId> {
    let whole = match text.split_once('.') {
        Some((whole, fraction)) if fraction.bytes().all(|byte| byte == b'0') => whole,
        Some(_) => return None,
        None => text,
    };
    epoch::digits(whole.as_bytes()).or_else(|| parse_five_characters(whole.as_bytes())).map(NoradId)
}
