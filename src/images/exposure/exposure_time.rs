//! Start and duration of an exposure, from the keywords of many observatories.

use hifitime::{Epoch, TimeScale, TimeUnits};

use crate::constants::LONGEST_EXPOSURE_S;
use crate::frames::{epoch_from_jd, epoch_from_mjd, seconds_after, seconds_between};

use super::super::error::ImagesError;
use super::super::header::Header;
use super::moment::{DateText, at, parse_date, parse_time};
use super::moment::{Keywords, resolution};

/// Keywords with the date and time of the start, in order of precedence.
const DATES: &[&str] = &["DATE-BEG", "DATE-OBS", "DATE-STR"];

/// Keywords with the time of day of the start, used together with a date.
const TIMES: &[&str] =
    &["TIME-BEG", "UTC-OBS", "TIME-OBS", "UT-OBS", "UTSTART", "UT-STR", "UTC-STR", "UTSHUT", "TAIHMS"];

/// Keywords with a time of day that is not the start at some observatories. They are used only if no keyword of
/// [`TIMES`] exists.
const LOOSE_TIMES: &[&str] = &["UT", "UTC", "UTIME"];

/// Keywords with the modified Julian date of the start.
const MODIFIED_DATES: &[&str] = &["MJD-BEG", "MJD-OBS", "MJD-STR", "MJDSTART"];

/// Keywords with the Julian date of the start.
const JULIAN_DATES: &[&str] = &["JDSTART", "JD-BEG", "JD-STR", "JD-OBS"];

/// Keywords of dates whose comment states whether they refer to the start, the middle or the end.
const LOOSE_DATES: &[&str] = &["MJD", "JD"];

/// Keywords of the middle and of the end of the exposure.
const MIDDLES: &[&str] = &["DATE-AVG", "MJD-AVG", "MJD-MID", "DATE-MID"];
const ENDS: &[&str] = &["DATE-END", "MJD-END", "JDEND"];

/// Keywords of the exposure time, in order of precedence.
const LENGTHS: &[&str] =
    &["EXPTIME", "XPOSURE", "EXPOSURE", "EXP-TIME", "ITIME", "TEXPTIME", "INTTIME", "ELAPTIME", "SHUTTIME"];

/// Largest difference between start times that are taken as consistent, in addition to their rounding, seconds.
const START_SLACK_S: f64 = 1.0;

/// Accepted shift of the middle of the exposure by shutters and overheads, as a fraction of the exposure time.
const MIDDLE_SLACK: f64 = 0.1;

/// Largest difference between exposure times that are taken as consistent: a fraction of the exposure time, and
/// seconds.
const LENGTH_SLACK: f64 = 0.01;
const LENGTH_SLACK_S: f64 = 0.1;

/// Start and duration of an exposure.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureTime {
    /// Time at which the shutter opened.
    pub start: Epoch,
    /// Time for which the shutter was open, seconds.
    pub duration_s: f64,
    /// Keywords that gave the start (`DATE-OBS`, `DATE-OBS + TIME-OBS`, ...).
    pub start_from: String,
    /// Keyword that gave the duration.
    pub duration_from: String,
}

/// Keywords that can give the start, for errors.
const START_KEYWORDS: &str =
    "DATE-BEG, DATE-OBS with a time in it or in TIME-OBS, UTC-OBS, UTSTART, ..., MJD-OBS, JD, ..., or --start";

fn unreadable(keyword: String, value: &str, allowed: &str) -> ImagesError {
    ImagesError::invalid(keyword, format!("{value:?}"), allowed)
}

/// Start with the keyword that gave it, and the rounding error of its digits.
struct Start {
    epoch: Epoch,
    from: String,
    slack_s: f64,
}

impl ExposureTime {
    /// Reads the exposure from the headers of a frame, given in the order of precedence: first the header of the image,
    /// then the primary header.
    ///
    /// Dates are in the scale of TIMESYS (by default UTC). The first of several keywords is used, and dates with times
    /// take precedence over Julian dates. All start keywords must agree within a second plus their rounding, and the
    /// middle (DATE-AVG) within a tenth of the exposure time.
    ///
    /// # Errors
    /// Keywords are missing, invalid or contradictory; a year has two digits; or the exposure time is 0 or less.
    pub fn from_headers(headers: &[&Header]) -> Result<Self, ImagesError> {
        let keywords = Keywords(headers);
        let (duration_s, duration_from) = duration(keywords)?;
        let start = start(keywords, duration_s)?;
        Ok(Self { start: start.epoch, duration_s, start_from: start.from, duration_from })
    }

    /// Reads only the exposure time, in seconds, for frames whose start comes from another source.
    ///
    /// # Errors
    /// The errors of [`from_headers`](ExposureTime::from_headers) that concern the exposure time.
    pub fn duration_from_headers(headers: &[&Header]) -> Result<f64, ImagesError> {
        duration(Keywords(headers)).map(|(seconds, _)| seconds)
    }

    /// Reads only the start, for an exposure whose duration (seconds) comes from another source. The duration is needed
    /// because a header may give only the middle or the end.
    ///
    /// # Errors
    /// The errors of [`from_headers`](ExposureTime::from_headers) that concern the start.
    pub fn start_from_headers(headers: &[&Header], duration_s: f64) -> Result<Epoch, ImagesError> {
        start(Keywords(headers), duration_s).map(|start| start.epoch)
    }
}

/// Returns the exposure time, seconds, and its keyword.
fn duration(keywords: Keywords<'_>) -> Result<(f64, String), ImagesError> {
    let mut lengths = Vec::new();
    for keyword in LENGTHS {
        let Some((header, name)) = keywords.find(keyword) else { continue };
        let Some(number) = header.number(&name) else {
            let value = header.text(&name).unwrap_or_default();
            return Err(unreadable(name, &value, "a number of seconds"));
        };
        lengths.push((number * unit_s(&header.comment(&name)), name));
    }
    let mut lengths = lengths.into_iter();
    let (seconds, name) = lengths.next().ok_or_else(|| {
        let allowed = "EXPTIME, XPOSURE, EXPOSURE, ITIME, ..., or for example --exposure 30s";
        ImagesError::invalid("length of the exposure", "missing", allowed)
    })?;
    if !(seconds > 0.0 && seconds <= LONGEST_EXPOSURE_S) {
        let allowed = format!("above 0 s, at most {LONGEST_EXPOSURE_S} s (a bias frame has no exposure)");
        return Err(ImagesError::invalid(name, format!("{seconds} s"), allowed));
    }
    match lengths.find(|(other, _)| (other - seconds).abs() > LENGTH_SLACK_S + LENGTH_SLACK * seconds) {
        Some((second_s, second)) => {
            let given = format!("{seconds} s and {second} is {second_s} s");
            Err(ImagesError::invalid(name, given, "one length; specify it, for example --exposure 30s"))
        }
        None => Ok((seconds, name)),
    }
}

/// Returns the number of seconds in the unit that a comment states; 1 if it states none.
fn unit_s(comment: &str) -> f64 {
    let comment = comment.to_ascii_lowercase();
    let contains_any = |words: &[&str]| words.iter().any(|word| comment.contains(word));
    if contains_any(&["[ms]", "millisec", "msec"]) {
        1e-3
    } else if contains_any(&["[min]", "minutes", "[minute"]) {
        60.0
    } else {
        1.0
    }
}

/// Returns the time scale of dates, which is given by TIMESYS.
fn scale(keywords: Keywords<'_>) -> Result<TimeScale, ImagesError> {
    let Some((keyword, value)) = keywords.text(&["TIMESYS"]) else { return Ok(TimeScale::UTC) };
    let name = value.to_ascii_uppercase();
    let name = name.split('(').next().unwrap_or_default().trim();
    match name {
        "UTC" | "UT" | "UT1" | "GMT" => Ok(TimeScale::UTC),
        "TAI" | "IAT" => Ok(TimeScale::TAI),
        "TT" | "TDT" | "ET" => Ok(TimeScale::TT),
        "TDB" => Ok(TimeScale::TDB),
        "GPS" => Ok(TimeScale::GPST),
        _ => Err(unreadable(keyword, &value, "UTC, TAI, TT, TDB or GPS")),
    }
}

/// Returns the start with the highest precedence, after checking that all start keywords in the header agree.
fn start(keywords: Keywords<'_>, duration_s: f64) -> Result<Start, ImagesError> {
    let scale = scale(keywords)?;
    let mut starts = Vec::new();
    let mut unclear = None;
    let mut day_alone = None;
    for keyword in DATES {
        let Some((name, value)) = keywords.text(&[keyword]) else { continue };
        match parse_date(&value, scale) {
            DateText::Moment(epoch) => starts.push(Start { epoch, from: name, slack_s: 0.0 }),
            DateText::Day(day) => match time_of(keywords, day, &name, scale)? {
                Some(start) => starts.push(start),
                None => day_alone = day_alone.or(Some((name, value))),
            },
            DateText::Unclear => {
                unclear = unclear.or_else(|| {
                    Some(ImagesError::invalid(name, format!("the ambiguous date {value:?}"), "yyyy-mm-dd, or --start"))
                })
            }
            DateText::Unreadable => {
                let allowed = "a date such as 2024-08-14T00:30:00.5, or 2024-08-14 with a time in another keyword";
                return Err(unreadable(name, &value, allowed));
            }
        }
    }
    for (names, is_julian) in [(MODIFIED_DATES, false), (JULIAN_DATES, true)] {
        for keyword in names {
            starts.extend(days(keywords, keyword, is_julian, scale)?);
        }
    }
    // SDSS writes the seconds of TAI since MJD 0.
    if let Some((name, seconds, _)) = keywords.number(&["TAI"], |seconds| seconds > 1e9) {
        let epoch = epoch_from_mjd(seconds / crate::constants::DAY_S, TimeScale::TAI).ok();
        starts.extend(epoch.map(|epoch| Start { epoch, from: name, slack_s: 0.01 }));
    }
    let middles = starts_before(keywords, MIDDLES, duration_s / 2.0, "half of the exposure", scale)?;
    let Some(first) = starts.first() else {
        if let Some(error) = unclear {
            return Err(error);
        }
        let mut loose = Vec::new();
        for keyword in LOOSE_DATES {
            loose.extend(start_by_comment(keywords, keyword, duration_s, scale)?);
        }
        loose.extend(middles);
        loose.extend(starts_before(keywords, ENDS, duration_s, "the exposure", scale)?);
        return loose.into_iter().next().ok_or_else(|| match day_alone {
            None => ImagesError::invalid("start of the exposure", "missing", START_KEYWORDS),
            Some((keyword, value)) => ImagesError::invalid(
                keyword,
                format!("the date {value} without a time"),
                "also the time, in TIME-OBS, UTC-OBS, UTSTART, ..., or MJD-OBS, or --start",
            ),
        });
    };
    let slack_of = |other: &Start, is_middle: bool| {
        START_SLACK_S + first.slack_s + other.slack_s + if is_middle { MIDDLE_SLACK * duration_s } else { 0.0 }
    };
    let others = starts[1..].iter().map(|other| (other, false)).chain(middles.iter().map(|other| (other, true)));
    for (other, is_middle) in others {
        let difference_s = seconds_between(first.epoch, other.epoch);
        if difference_s.abs() > slack_of(other, is_middle) {
            let [first_start, second_start] = [first, other].map(|start| start.epoch.round(1.milliseconds()));
            return Err(ImagesError::invalid(
                format!("start of {} ({scale})", first.from),
                format!("{first_start}, and {} ({scale}) gives {second_start}: {difference_s:.1} s apart", other.from),
                "one start; specify --start",
            ));
        }
    }
    Ok(starts.swap_remove(0))
}

/// Combines a date with the time of day in another keyword.
fn time_of(keywords: Keywords<'_>, day: [u32; 3], date: &str, scale: TimeScale) -> Result<Option<Start>, ImagesError> {
    let Some((name, value)) = keywords.text(TIMES).or_else(|| keywords.text(LOOSE_TIMES)) else { return Ok(None) };
    let scale = if name == "TAIHMS" { TimeScale::TAI } else { scale };
    // Some observatories write date and time in these keywords.
    if let DateText::Moment(epoch) = parse_date(&value, scale) {
        return Ok(Some(Start { epoch, from: name, slack_s: 0.0 }));
    }
    let epoch = parse_time(&value).and_then(|(clock, seconds)| at(day, clock, seconds, scale));
    let allowed = "a time such as 00:30:00.5";
    let epoch = epoch.ok_or_else(|| unreadable(name.clone(), &value, allowed))?;
    Ok(Some(Start { epoch, from: format!("{date} + {name}"), slack_s: 0.0 }))
}

/// Returns a start from a Julian date.
fn days(
    keywords: Keywords<'_>,
    keyword: &str,
    is_julian: bool,
    scale: TimeScale,
) -> Result<Option<Start>, ImagesError> {
    let Some((header, name)) = keywords.find(keyword) else { return Ok(None) };
    let epoch = header.number(&name).and_then(|number| {
        if is_julian { epoch_from_jd(number, scale).ok() } else { epoch_from_mjd(number, scale).ok() }
    });
    let Some(epoch) = epoch else {
        let value = header.card(&name).map(|card| card.text()[9..].trim().to_owned()).unwrap_or_default();
        let allowed = if is_julian {
            "a Julian date between 1900 and 2200"
        } else {
            "a modified Julian date between 1900 and 2200"
        };
        return Err(unreadable(name, &value, allowed));
    };
    let slack_s = header.card(&name).map_or(0.0, resolution) * crate::constants::DAY_S;
    Ok(Some(Start { epoch, from: name, slack_s }))
}

/// Returns a start computed from MJD or JD. If their comment mentions the end or the middle of the exposure, they refer
/// to that time, otherwise to its start.
fn start_by_comment(
    keywords: Keywords<'_>,
    keyword: &str,
    duration_s: f64,
    scale: TimeScale,
) -> Result<Option<Start>, ImagesError> {
    let Some((header, name)) = keywords.find(keyword) else { return Ok(None) };
    let comment = header.comment(&name).to_ascii_lowercase();
    let (back_s, what) = if comment.contains("end") {
        (duration_s, " - the exposure")
    } else if comment.contains("mid") {
        (duration_s / 2.0, " - half of the exposure")
    } else {
        (0.0, "")
    };
    let start = days(keywords, keyword, keyword == "JD", scale)?;
    Ok(start.map(|start| Start {
        epoch: seconds_after(start.epoch, -back_s),
        from: format!("{}{what}", start.from),
        ..start
    }))
}

/// Returns starts computed from the keywords of the middle or the end.
fn starts_before(
    keywords: Keywords<'_>,
    names: &[&str],
    back_s: f64,
    what: &str,
    scale: TimeScale,
) -> Result<Vec<Start>, ImagesError> {
    let mut found = Vec::new();
    for keyword in names {
        let start = if keyword.starts_with("DATE") {
            keywords.text(&[keyword]).and_then(|(name, value)| match parse_date(&value, scale) {
                DateText::Moment(epoch) => Some(Start { epoch, from: name, slack_s: 0.0 }),
                _ => None,
            })
        } else {
            days(keywords, keyword, keyword.starts_with("JD"), scale)?
        };
        found.extend(start.map(|start| Start {
            epoch: seconds_after(start.epoch, -back_s),
            from: format!("{} - {what}", start.from),
            ..start
        }));
    }
    Ok(found)
}
