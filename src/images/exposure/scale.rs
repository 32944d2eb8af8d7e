//! Time scale of the dates of a header.

use hifitime::TimeScale;

use crate::error::Error;

use super::comment::Comment;
use super::instant_keywords::{DATES, MODIFIED_DATES};
use super::moment::{Keywords, unreadable};

/// Word of TIMESYS for a clock that is not exactly in the scale (`UTC approximate` in the keyword dictionary of NOAO,
/// <https://iraf.noao.edu/projects/mosaic/imagedef/mosaic/MosaicV1.dic>).
pub const APPROXIMATE: &str = "APPROXIMATE";

/// Keywords of the time scale.
const SCALES: &[&str] = &["TIME-SYS", "TIMESCAL"];

/// Time scale of the dates of a header.
#[derive(Copy, Clone)]
pub struct DateScale {
    /// The scale of TIMESYS; UTC without it.
    pub scale: TimeScale,
    /// True if TIMESYS states it.
    pub is_stated: bool,
}

impl DateScale {
    /// Returns the scale of a date: that of TIMESYS, or else the one that its comment states. A date of which the
    /// comment states that it was converted to UTC is in UTC (files of HEASARC, whose TIMESYS is that of TSTART).
    pub fn of(self, comment: &Comment) -> TimeScale {
        if !self.is_stated {
            comment.scale().ok().flatten().unwrap_or(self.scale)
        } else if comment.is_converted_to_universal() {
            TimeScale::UTC
        } else {
            self.scale
        }
    }
}

/// Returns the time scale of dates, which is given by TIMESYS.
pub fn scale(keywords: Keywords<'_>) -> Result<DateScale, Error> {
    let stated = scales(keywords);
    let Some((keyword, value)) = stated.first() else {
        return Ok(DateScale { scale: TimeScale::UTC, is_stated: false });
    };
    let scale = known_scale(value).ok_or_else(|| unreadable(keyword.clone(), value, "UTC, TAI, TT, TDB or GPS"))?;
    if let Some((other, name)) = stated.iter().find(|(_, name)| known_scale(name).is_some_and(|other| other != scale)) {
        let given = format!("{value:?}, and {other} is {name:?}");
        return Err(Error::invalid(keyword.clone(), given, "one time scale, or --start"));
    }
    Ok(DateScale { scale, is_stated: true })
}

fn known_scale(value: &str) -> Option<TimeScale> {
    match scale_name(value).as_str() {
        "UTC" | "UT" | "UT1" | "GMT" => Some(TimeScale::UTC),
        "TAI" | "IAT" => Some(TimeScale::TAI),
        "TT" | "TDT" | "ET" => Some(TimeScale::TT),
        "TDB" => Some(TimeScale::TDB),
        "GPS" => Some(TimeScale::GPST),
        // "Coordinated Universal Time"
        _ => (Comment::new(value).is_universal() && !Comment::new(value).is_local()).then_some(TimeScale::UTC),
    }
}

/// Returns the keywords of the scale with their values, from the header with the dates if it has some there. TIMESCAL
/// may have another meaning ("linear").
fn scales(keywords: Keywords<'_>) -> Vec<(String, String)> {
    let of = |keywords: Keywords<'_>| -> Vec<(String, String)> {
        let names = SCALES.iter().flat_map(|name| keywords.spellings(name));
        let texts = names.filter_map(|name| keywords.text(&[&name]));
        texts.filter(|(name, text)| name != SCALES[1] || known_scale(text).is_some()).collect()
    };
    let mut headers = keywords.0.iter().map(|header| Keywords(std::slice::from_ref(header)));
    let of_dates = headers.find(|header| DATES.iter().chain(MODIFIED_DATES).any(|name| header.find(name).is_some()));
    of_dates.map(of).filter(|scales| !scales.is_empty()).unwrap_or_else(|| of(keywords))
}

/// Returns TIMESYS and its value.
pub fn timesys(keywords: Keywords<'_>) -> Option<(String, String)> {
    scales(keywords).into_iter().next()
}

/// Returns the name of a time scale without its realisation, as in `TT(TAI)`, and without `approximate` (NOAO).
pub fn scale_name(value: &str) -> String {
    let (before, note) = value.split_once('(').unwrap_or((value, ""));
    // "UTC (+7 h)" is no UTC.
    let is_shift = |pair: &[u8]| matches!(pair[0], b'+' | b'-') && (pair[1].is_ascii_digit() || pair[1] == b' ');
    let is_shifted = note.as_bytes().windows(2).any(is_shift);
    let name = if is_shifted { value } else { before }.trim().to_ascii_uppercase();
    name.strip_suffix(APPROXIMATE).unwrap_or(&name).trim_end().to_owned()
}
