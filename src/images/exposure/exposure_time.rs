//! Start and length of an exposure, from the spellings of many observatories.

use hifitime::{Epoch, TimeScale, TimeUnits};

use crate::frames::{epoch_from_jd, epoch_from_mjd, seconds_after, seconds_between};

use super::super::header::Header;
use super::moment::{DateText, at, parse_date, parse_time};
use super::moment::{Keywords, resolution};

/// Keywords with date and time of the beginning, in the order in which they count.
const DATES: &[&str] = &["DATE-BEG", "DATE-OBS", "DATE-STR"];

/// Keywords with the time of the beginning, beside a date alone.
const TIMES: &[&str] =
    &["TIME-BEG", "UTC-OBS", "TIME-OBS", "UT-OBS", "UTSTART", "UT-STR", "UTC-STR", "UTSHUT", "TAIHMS"];

/// The same, but some observatories mean another moment by them: used where nothing better is there.
const LOOSE_TIMES: &[&str] = &["UT", "UTC", "UTIME"];

/// Days since 1858-11-17 of the beginning.
const MODIFIED_DATES: &[&str] = &["MJD-BEG", "MJD-OBS", "MJD-STR", "MJDSTART"];

/// Julian dates of the beginning.
const JULIAN_DATES: &[&str] = &["JDSTART", "JD-BEG", "JD-STR", "JD-OBS"];

/// Dates of which the comment alone says whether they are of the beginning, the middle or the end.
const LOOSE_DATES: &[&str] = &["MJD", "JD"];

/// Middle and end.
const MIDDLES: &[&str] = &["DATE-AVG", "MJD-AVG", "MJD-MID", "DATE-MID"];
const ENDS: &[&str] = &["DATE-END", "MJD-END", "JDEND"];

/// Keywords of the length, in the order in which they count.
const LENGTHS: &[&str] =
    &["EXPTIME", "XPOSURE", "EXPOSURE", "EXP-TIME", "ITIME", "TEXPTIME", "INTTIME", "ELAPTIME", "SHUTTIME"];

/// Moments that differ by more than this, beyond the digits they are given with, contradict one another, s.
const START_SLACK_S: f64 = 1.0;

/// Shutters and overheads shift the middle: this part of the length is allowed.
const MIDDLE_SLACK: f64 = 0.1;

/// Lengths that differ by more contradict one another: this part, and seconds.
const LENGTH_SLACK: f64 = 0.01;
const LENGTH_SLACK_S: f64 = 0.1;

/// When the shutter opened, and how long it was open.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureTime {
    /// When the shutter opened.
    pub start: Epoch,
    /// How long it was open, s.
    pub duration_s: f64,
    /// The keywords that said when (`DATE-OBS`, `DATE-OBS + TIME-OBS`, ...).
    pub start_from: String,
    /// The keyword that said how long.
    pub duration_from: String,
}

/// Longest exposure, s: 115 days, beyond any sum of exposures.
const LONGEST_S: f64 = 1e7;

/// A header that does not say when its exposure was, or says it twice and differently.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExposureError {
    /// Nothing that says when.
    #[error(
        "no start of the exposure (looked for DATE-BEG, DATE-OBS with a time in it or in TIME-OBS, UTC-OBS, UTSTART, ..., MJD-OBS, JD, ...); say it: --start"
    )]
    NoStart,
    /// A date without a time.
    #[error(
        "{keyword} is the date {value} without a time, and no other keyword has it (TIME-OBS, UTC-OBS, UTSTART, ..., MJD-OBS); say it: --start"
    )]
    NoTime {
        /// The keyword.
        keyword: String,
        /// Its value.
        value: String,
    },
    /// A date that can be read in several ways.
    #[error(
        "{keyword} is {value:?}: a year of two digits, or no yyyy-mm-dd, is not guessed at; say the start: --start"
    )]
    UnclearDate {
        /// The keyword.
        keyword: String,
        /// Its value.
        value: String,
    },
    /// Something that is no date, time or number.
    #[error("{keyword} is {value:?}: {allowed}")]
    Unreadable {
        /// The keyword.
        keyword: String,
        /// Its value.
        value: String,
        /// What may stand there.
        allowed: &'static str,
    },
    /// Two keywords that contradict one another.
    #[error(
        "{first} says that the exposure began at {first_start}, {second} says {second_start}: {difference_s:.1} s apart; say which: --start"
    )]
    StartConflict {
        /// One keyword, with what was reckoned from it.
        first: String,
        /// Its start.
        first_start: Epoch,
        /// The other one.
        second: String,
        /// Its start.
        second_start: Epoch,
        /// Second minus first, s.
        difference_s: f64,
    },
    /// Nothing that says how long.
    #[error("no length of the exposure (looked for EXPTIME, XPOSURE, EXPOSURE, ITIME, ...); say it: --exposure 30s")]
    NoLength,
    /// Two lengths that contradict one another.
    #[error("{first} says {first_s} s of exposure, {second} says {second_s} s; say which: --exposure 30s")]
    LengthConflict {
        /// One keyword.
        first: String,
        /// Its length, s.
        first_s: f64,
        /// The other one.
        second: String,
        /// Its length, s.
        second_s: f64,
    },
    /// A length of more than 1e7 s.
    #[error("{keyword} is {seconds} s: allowed are exposures of at most {LONGEST_S} s")]
    TooLong {
        /// The keyword.
        keyword: String,
        /// The length, s.
        seconds: f64,
    },
    /// A length of nothing or less.
    #[error("{keyword} is {seconds} s: a streak needs an exposure longer than 0 s (a bias frame?)")]
    NotPositive {
        /// The keyword.
        keyword: String,
        /// The length, s.
        seconds: f64,
    },
}

/// A start and the keyword it came from, with how far off the digits allow it to be.
struct Start {
    epoch: Epoch,
    from: String,
    slack_s: f64,
}

impl ExposureTime {
    /// From the headers of a frame in the order in which they count: that of the image, then the primary one.
    ///
    /// Dates are in the scale of TIMESYS (UTC where there is none). Of several spellings the first is taken (dates with times before numbers of days);
    /// the others must agree to a second and to the digits that they are given with, the middle (DATE-AVG) to a tenth of the length.
    ///
    /// # Errors
    /// [`ExposureError`]: nothing there, not readable, a year of two digits, two keywords that contradict one another, a length of 0 or less.
    pub fn from_headers(headers: &[&Header]) -> Result<Self, ExposureError> {
        let keywords = Keywords(headers);
        let (duration_s, duration_from) = duration(keywords)?;
        let start = start(keywords, duration_s)?;
        Ok(Self { start: start.epoch, duration_s, start_from: start.from, duration_from })
    }

    /// The length alone, s: for frames whose start is known from elsewhere.
    ///
    /// # Errors
    /// As [`from_headers`](ExposureTime::from_headers), of the length.
    pub fn duration_from_headers(headers: &[&Header]) -> Result<f64, ExposureError> {
        duration(Keywords(headers)).map(|(seconds, _)| seconds)
    }

    /// The start alone, of an exposure of a length known from elsewhere, s (a header may give the middle or the end alone).
    ///
    /// # Errors
    /// As [`from_headers`](ExposureTime::from_headers), of the start.
    pub fn start_from_headers(headers: &[&Header], duration_s: f64) -> Result<Epoch, ExposureError> {
        start(Keywords(headers), duration_s).map(|start| start.epoch)
    }
}

/// The length and its keyword.
fn duration(keywords: Keywords<'_>) -> Result<(f64, String), ExposureError> {
    let mut lengths = Vec::new();
    for keyword in LENGTHS {
        let Some((header, name)) = keywords.find(keyword) else { continue };
        let Some(number) = header.number(&name) else {
            let value = header.text(&name).unwrap_or_default();
            return Err(ExposureError::Unreadable { keyword: name, value, allowed: "a number of seconds" });
        };
        lengths.push((number * unit_s(&header.comment(&name)), name));
    }
    let mut lengths = lengths.into_iter();
    let (seconds, name) = lengths.next().ok_or(ExposureError::NoLength)?;
    if !(seconds > 0.0 && seconds.is_finite()) {
        return Err(ExposureError::NotPositive { keyword: name, seconds });
    }
    if seconds > LONGEST_S {
        return Err(ExposureError::TooLong { keyword: name, seconds });
    }
    match lengths.find(|(other, _)| (other - seconds).abs() > LENGTH_SLACK_S + LENGTH_SLACK * seconds) {
        Some((second_s, second)) => {
            Err(ExposureError::LengthConflict { first: name, first_s: seconds, second, second_s })
        }
        None => Ok((seconds, name)),
    }
}

/// Seconds in the unit that a comment names, else 1.
fn unit_s(comment: &str) -> f64 {
    let comment = comment.to_ascii_lowercase();
    let says = |words: &[&str]| words.iter().any(|word| comment.contains(word));
    if says(&["[ms]", "millisec", "msec"]) {
        1e-3
    } else if says(&["[min]", "minutes", "[minute"]) {
        60.0
    } else {
        1.0
    }
}

/// The scale of dates: TIMESYS.
fn scale(keywords: Keywords<'_>) -> Result<TimeScale, ExposureError> {
    let Some((keyword, value)) = keywords.text(&["TIMESYS"]) else { return Ok(TimeScale::UTC) };
    let name = value.to_ascii_uppercase();
    let name = name.split('(').next().unwrap_or_default().trim();
    match name {
        "UTC" | "UT" | "UT1" | "GMT" => Ok(TimeScale::UTC),
        "TAI" | "IAT" => Ok(TimeScale::TAI),
        "TT" | "TDT" | "ET" => Ok(TimeScale::TT),
        "TDB" => Ok(TimeScale::TDB),
        "GPS" => Ok(TimeScale::GPST),
        _ => Err(ExposureError::Unreadable { keyword, value, allowed: "UTC, TAI, TT, TDB or GPS" }),
    }
}

/// All starts that are said, the one that counts first; then whether they agree.
fn start(keywords: Keywords<'_>, duration_s: f64) -> Result<Start, ExposureError> {
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
            DateText::Unclear => unclear = unclear.or(Some(ExposureError::UnclearDate { keyword: name, value })),
            DateText::Unreadable => {
                let allowed = "a date as 2024-08-14T00:30:00.5, or 2024-08-14 with a time in another keyword";
                return Err(ExposureError::Unreadable { keyword: name, value, allowed });
            }
        }
    }
    for (names, is_julian) in [(MODIFIED_DATES, false), (JULIAN_DATES, true)] {
        for keyword in names {
            starts.extend(days(keywords, keyword, is_julian, scale)?);
        }
    }
    // SDSS: seconds of TAI since MJD 0.
    if let Some((name, seconds, _)) = keywords.number(&["TAI"], |seconds| seconds > 1e9) {
        let epoch = epoch_from_mjd(seconds / crate::constants::DAY_S, TimeScale::TAI).ok();
        starts.extend(epoch.map(|epoch| Start { epoch, from: name, slack_s: 0.01 }));
    }
    let middles = reckoned(keywords, MIDDLES, duration_s / 2.0, "half of the exposure", scale)?;
    let Some(first) = starts.first() else {
        if let Some(error) = unclear {
            return Err(error);
        }
        let mut loose = Vec::new();
        for keyword in LOOSE_DATES {
            loose.extend(loose_day(keywords, keyword, duration_s, scale)?);
        }
        loose.extend(middles);
        loose.extend(reckoned(keywords, ENDS, duration_s, "the exposure", scale)?);
        let nothing =
            day_alone.map_or(ExposureError::NoStart, |(keyword, value)| ExposureError::NoTime { keyword, value });
        return loose.into_iter().next().ok_or(nothing);
    };
    let slack_of = |other: &Start, is_middle: bool| {
        START_SLACK_S + first.slack_s + other.slack_s + if is_middle { MIDDLE_SLACK * duration_s } else { 0.0 }
    };
    let others = starts[1..].iter().map(|other| (other, false)).chain(middles.iter().map(|other| (other, true)));
    for (other, is_middle) in others {
        let difference_s = seconds_between(first.epoch, other.epoch);
        if difference_s.abs() > slack_of(other, is_middle) {
            return Err(ExposureError::StartConflict {
                first: format!("{} ({scale})", first.from),
                first_start: first.epoch.round(1.milliseconds()),
                second: format!("{} ({scale})", other.from),
                second_start: other.epoch.round(1.milliseconds()),
                difference_s,
            });
        }
    }
    starts.into_iter().next().ok_or(ExposureError::NoStart)
}

/// A date alone with the time of another keyword.
fn time_of(
    keywords: Keywords<'_>,
    day: [u32; 3],
    date: &str,
    scale: TimeScale,
) -> Result<Option<Start>, ExposureError> {
    let Some((name, value)) = keywords.text(TIMES).or_else(|| keywords.text(LOOSE_TIMES)) else { return Ok(None) };
    let scale = if name == "TAIHMS" { TimeScale::TAI } else { scale };
    // Some write the whole moment here.
    if let DateText::Moment(epoch) = parse_date(&value, scale) {
        return Ok(Some(Start { epoch, from: name, slack_s: 0.0 }));
    }
    let epoch = parse_time(&value).and_then(|(clock, seconds)| at(day, clock, seconds, scale));
    let allowed = "a time as 00:30:00.5";
    let epoch = epoch.ok_or_else(|| ExposureError::Unreadable { keyword: name.clone(), value, allowed })?;
    Ok(Some(Start { epoch, from: format!("{date} + {name}"), slack_s: 0.0 }))
}

/// A start from a number of days.
fn days(
    keywords: Keywords<'_>,
    keyword: &str,
    is_julian: bool,
    scale: TimeScale,
) -> Result<Option<Start>, ExposureError> {
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
        return Err(ExposureError::Unreadable { keyword: name, value, allowed });
    };
    let slack_s = header.card(&name).map_or(0.0, resolution) * crate::constants::DAY_S;
    Ok(Some(Start { epoch, from: name, slack_s }))
}

/// MJD and JD without a word: their comment says what they are of.
fn loose_day(
    keywords: Keywords<'_>,
    keyword: &str,
    duration_s: f64,
    scale: TimeScale,
) -> Result<Option<Start>, ExposureError> {
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

/// Starts reckoned back from later moments.
fn reckoned(
    keywords: Keywords<'_>,
    names: &[&str],
    back_s: f64,
    what: &str,
    scale: TimeScale,
) -> Result<Vec<Start>, ExposureError> {
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
