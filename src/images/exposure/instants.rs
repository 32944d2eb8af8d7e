//! Instants in a header: start, middle or end of the exposure, by the name of the keyword and by its comment.

use hifitime::{Epoch, TimeScale};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{epoch_from_jd, epoch_from_mjd, seconds_after, seconds_between};

use super::super::card::{Card, CardValue};
use super::comment::{AFTER_EXPOSURE, Comment, FRAMES, Role};
use super::instant_keywords::{
    CLOCKS, DATES, END_TIMES, ENDS, JULIAN_DATES, LOCAL_TIMES, LOOSE_DATES, LOOSE_TIMES, MIDDLES, MODIFIED_DATES,
    OTHER_DATES, OTHER_STARTS, OUTERMOST, SHUTTER, TIMES, UNIVERSAL_DATES, names_start,
};
use super::moment::{
    DateText, Keywords, at, bare, date_and_time, has_zone, is_spelling, parse_date, parse_date_of, parse_time,
    resolution, without_offset,
};
use super::relative::relative_instants;

/// Keywords of devices, and a device whose DATE-OBS is the time at which its image was created, the end of the exposure
/// (so read by the Seestar Photometry Stack for Siril, <https://gitlab.com/Aquarius58/siril-seestar-stack>; its maker
/// documents nothing), in lower case. The ASIAIR has the same comment, but nothing is published about its time; its
/// Autorun_Log has the times of captures (so read by <https://github.com/metalglove/astro-guiding-performance>).
const DEVICES: &[&str] = &["CREATOR", "INSTRUME"];
const CREATES_AT_END: &str = "seestar";
const WITH_LOG: &str = "asiair";
const CREATED: &str = "image created";

/// Telescope whose dates are those of the middle of the exposure (Explanatory Supplement to the NEOWISE Data Release
/// Products, section III.1.b).
const WITH_MIDDLES: &str = "WISE";

/// Telescope whose ends are those of the observation, with the readout.
const WITH_READOUT: &str = "CFHT";

/// Keyword of the start in headers of Andor, also that of the coordinates.
const FRAME: &str = "FRAME";

/// Reason why an instant of another scale is not used.
const OTHER_SCALE: &str = "in another time scale than TIMESYS";

/// Rounding error of a time without seconds, seconds.
const MINUTE_S: f64 = 60.0;

/// Rounding error of one reading of a clock in two forms, seconds.
const SAME_READING_S: f64 = 0.01;

/// Largest difference between two instants that are computed from the same clock, seconds.
const SAME_CLOCK_S: f64 = 1.0;

/// One instant of a header.
pub struct Instant {
    pub epoch: Epoch,
    /// Keyword, or several keywords joined.
    pub from: String,
    /// Its value as written.
    pub value: String,
    /// Rounding error of its digits, or the uncertainty that its comment states, seconds.
    pub slack_s: f64,
    pub role: Role,
    /// True for keywords that are used only if no other keyword gives the start.
    pub is_loose: bool,
    /// True for a time in [`LOOSE_TIMES`] beside a date, whose comment does not state the start. It may be later than
    /// the start in another keyword.
    pub is_loose_clock: bool,
    /// Beginning of the day of a date in another keyword, and the part of the exposure to which the date belongs by its
    /// comment.
    pub day: Option<(Epoch, Option<Role>)>,
    /// True if the name of the keyword or its comment states the part of the exposure.
    pub is_role_stated: bool,
    /// Whether an end includes the readout.
    pub readout: Readout,
}

/// Statement about the readout of the detector before an end.
#[derive(Copy, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Readout {
    Unknown,
    /// The comment states the end of the observation.
    Possible,
    /// Included in all ends of the observatory.
    Included,
}

impl Instant {
    /// Returns the last digit of the seconds of a date and time or a time of day, seconds; 0 for a number of days.
    pub fn step_s(&self) -> f64 {
        // "031500" is a time.
        let whole = self.value.split('.').next().unwrap_or_default();
        if self.value.parse::<f64>().is_ok() && whole.len() != 6 {
            return 0.0;
        }
        let (day, clock) = date_and_time(without_offset(&self.value).0);
        let clock = clock.unwrap_or(day);
        let clock = clock.trim_end_matches(|c: char| !c.is_ascii_digit());
        let decimals = clock.rsplit_once(['.', ',']).map_or("", |(_, decimals)| decimals);
        // "03.15.00"
        let is_fraction = clock.matches(['.', ',']).count() == 1 && decimals.bytes().all(|byte| byte.is_ascii_digit());
        if is_fraction { 10f64.powi(-(decimals.len() as i32)) } else { 1.0 }
    }
}

/// Instants of a header in order of precedence, and the reasons why others are not used.
#[derive(Default)]
pub struct Instants {
    pub found: Vec<Instant>,
    /// Middles, ends, and times of the first and last of several exposures, in keywords of other names, such as OBS-END
    /// and UTC-LAST, which are only compared.
    pub others: Vec<Instant>,
    /// Error of an ambiguous date.
    pub unclear: Option<Error>,
    /// Error of a date without a time, or of a text without digits, such as "unknown".
    pub day_alone: Option<Error>,
    /// Error of an instant that its comment or its zone makes unusable, such as a local time.
    unusable: Option<Error>,
    /// Instants in local time or in another scale than TIMESYS, read as if they were in that scale.
    local: Vec<Epoch>,
    /// Local times of day, seconds, with their keywords.
    pub local_clocks: Vec<(String, f64)>,
    /// Keyword and comment of a time of creation that is read as the end of the exposure.
    pub created: Option<(String, String)>,
    /// Keywords that are read in another way than usual, with a sentence each.
    pub readings: Vec<(String, String)>,
}

impl Instants {
    /// Reads all instants. Dates are in `scale`; `is_stated` is true if TIMESYS states it.
    ///
    /// # Errors
    /// A date or a time that cannot be parsed, or that is twice in the header.
    pub fn read(keywords: Keywords<'_>, scale: TimeScale, is_stated: bool) -> Result<Self, Error> {
        let lists = [DATES, TIMES, MODIFIED_DATES, JULIAN_DATES, OTHER_STARTS, MIDDLES, ENDS];
        // FRAME is also the system of the coordinates.
        keywords.are_unique(lists.into_iter().flatten().copied().filter(|keyword| *keyword != FRAME))?;
        let mut reader = Reader { keywords, scale, is_stated, tried: Vec::new(), instants: Self::default() };
        for keyword in DATES.iter().flat_map(|keyword| keywords.spellings(keyword)) {
            reader.date(&keyword)?;
        }
        // "UTDATE" of the AAT
        if DATES.iter().all(|keyword| keywords.find(keyword).is_none()) {
            for keyword in UNIVERSAL_DATES.iter().chain(OTHER_DATES) {
                let text = keywords.text(&[keyword]).map(|(_, text)| text);
                let date = text.map(|text| parse_date(&text, scale));
                if matches!(date, Some(DateText::Day(_) | DateText::Moment(_))) {
                    reader.date(keyword)?;
                }
            }
        }
        for keyword in MODIFIED_DATES.iter().chain(JULIAN_DATES) {
            reader.days(keyword, Role::Start, false)?;
        }
        // SDSS writes the seconds of TAI since MJD 0.
        if let Some((from, seconds, comment)) = keywords.number(&["TAI"], |seconds| seconds > 1e9)
            && let Ok(epoch) = epoch_from_mjd(seconds / DAY_S, TimeScale::TAI)
        {
            reader.add(instant(epoch, from, Role::Start), &seconds.to_string(), &[Comment::new(&comment)]);
        }
        for keyword in OTHER_STARTS {
            reader.any_form(keyword, Role::Start)?;
        }
        for keyword in TIMES.iter().chain(LOOSE_TIMES) {
            reader.clock(keyword, Role::Start, LOOSE_TIMES.contains(keyword));
        }
        for keyword in LOOSE_DATES {
            reader.days(keyword, Role::Start, true)?;
        }
        for (names, role) in [(MIDDLES, Role::Middle), (ENDS, Role::End)] {
            for keyword in names {
                reader.any_form(keyword, role)?;
            }
        }
        for keyword in END_TIMES {
            reader.clock(keyword, Role::End, true);
        }
        reader.other_parts();
        let relative = relative_instants(keywords, scale).into_iter();
        reader.instants.others.extend(relative.map(|(epoch, name, role)| instant(epoch, name.to_owned(), role)));
        for keyword in LOCAL_TIMES {
            let clock = keywords.text_and_comment(keyword).and_then(|(name, text, _)| Some((name, clock_in(&text)?)));
            reader.instants.local_clocks.extend(clock);
        }
        Ok(reader.instants)
    }

    /// Returns the error that concerns the first unusable instant, unless `chosen` comes from another clock.
    pub fn unusable(&mut self, chosen: Option<Epoch>) -> Option<Error> {
        let is_same =
            |chosen: Epoch| self.local.iter().any(|local| seconds_between(*local, chosen).abs() < SAME_CLOCK_S);
        if chosen.is_some_and(|chosen| !is_same(chosen)) { None } else { self.unusable.take() }
    }
}

struct Reader<'a> {
    keywords: Keywords<'a>,
    scale: TimeScale,
    is_stated: bool,
    /// Keywords of times of day that were combined with a date.
    tried: Vec<String>,
    instants: Instants,
}

impl Reader<'_> {
    /// Reads a keyword of [`DATES`], with a time of day in another keyword if it has none.
    fn date(&mut self, keyword: &str) -> Result<(), Error> {
        let Some((from, value, comment)) = self.keywords.text_and_comment(keyword).or_else(|| self.basic(keyword))
        else {
            return if self.keywords.number(&[keyword], is_day_number).is_some() {
                self.days(keyword, Role::Start, false)
            } else {
                Ok(())
            };
        };
        let scale = self.scale_of(&comment);
        match parse_date_of(keyword, &value, scale) {
            DateText::Moment(epoch) => self.add(instant(epoch, from, Role::Start), &value, &[comment]),
            DateText::Day(day) => {
                if !self.time_of(day, &from, &value, &comment)? && self.instants.day_alone.is_none() {
                    let loose = self.keywords.number(LOOSE_TIMES, |_| true);
                    let beside = loose.map(|(name, number, _)| format!(" ({name} is {number} without a unit)"));
                    self.instants.day_alone = Some(Error::invalid(
                        from,
                        format!("the date {value} without a time{}", beside.unwrap_or_default()),
                        "also the time, in TIME-OBS, UTC-OBS, UTSTART, ..., or MJD-OBS, or --start",
                    ));
                }
            }
            DateText::Unclear if self.instants.unclear.is_none() => {
                let given = format!("the ambiguous date {value:?}");
                self.instants.unclear =
                    Some(Error::invalid(from, given, "yyyy-mm-dd (dd/mm/yy until 1999), or --start"));
            }
            DateText::Unclear => {}
            DateText::Unreadable => {
                let allowed = "a date such as 2024-08-14T00:30:00.5, or 2024-08-14 with a time in another keyword";
                let error = unreadable(from, &value, allowed);
                // "unknown" beside another start
                if value.contains(|c: char| c.is_ascii_digit()) {
                    return Err(error);
                }
                self.instants.day_alone.get_or_insert(error);
            }
        }
        Ok(())
    }

    /// Returns a date that is written as a number, such as 20260822, as text.
    fn basic(&self, keyword: &str) -> Option<(String, String, Comment)> {
        let is_date = |number: f64| number.fract() == 0.0 && (19_000_101.0..22_000_101.0).contains(&number);
        let (name, number, comment) = self.keywords.number(&[keyword], is_date)?;
        Some((name, number.to_string(), Comment::new(&comment)))
    }

    /// Reads dates, times and day numbers in other keywords whose name or comment states the middle, the end, or the
    /// first or last of several exposures, such as OBS-END, MIDMJD and UTC-LAST.
    fn other_parts(&mut self) {
        let known = [
            DATES,
            TIMES,
            LOOSE_TIMES,
            MODIFIED_DATES,
            JULIAN_DATES,
            OTHER_STARTS,
            LOOSE_DATES,
            MIDDLES,
            ENDS,
            END_TIMES,
        ]
        .concat();
        let may_be_date = |card: &&Card| match card.value() {
            Some(CardValue::Text(text)) => text.contains([':', '-', '/']),
            // Modified Julian dates since 1930.
            Some(CardValue::Real(days)) => days > 26_000.0,
            _ => false,
        };
        for card in self.keywords.cards().filter(may_be_date) {
            let name = card.keyword();
            let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
            let named = if has(&["MID"]) || (has(&["MEAN", "AVG"]) && has(&["JD", "DATE", "TIME", "UT", "OBS"])) {
                Some(Role::Middle)
            } else {
                has(&["END", "STOP", "CLOS", "FIN"]).then_some(Role::End)
            };
            let bare = bare(&name);
            let outermost = OUTERMOST.iter().find(|(_, word)| {
                let rest = bare.strip_prefix(word).or_else(|| bare.strip_suffix(word));
                rest.is_some_and(|rest| CLOCKS.contains(&rest))
            });
            let comment = Comment::new(&card.comment());
            // "UTC of the last frame"
            let is_of_other = ["GUID", "PREV", "CAL"].iter().any(|word| bare.contains(word))
                || comment.has("guide guider guiding previous calibration");
            let is_last = comment.has_pair("last final", FRAMES) && !is_of_other;
            let outermost = outermost.map(|(role, _)| *role).or((bare == SHUTTER).then_some(Role::Start));
            let outermost = outermost.or(is_last.then_some(Role::End));
            let role = match (outermost, if is_last { Ok(None) } else { comment.role(named) }) {
                (Some(role), Ok(_)) if comment.scale().is_ok() => role,
                (None, Ok(Some(role))) if role != Role::Start && comment.scale().is_ok() => role,
                _ => continue,
            };
            // Times of the processing, BJD_TDB, JD_TT
            let in_name = Comment::new(&name);
            let is_of_processing = name.contains("TREND")
                || comment.has("processing reduction proprietary release")
                || (named.is_none()
                    && outermost.is_none()
                    && !comment.has("exposure exp observation obs frame integration shutter"));
            if is_of_processing || in_name.role(Some(role)).is_err() || in_name.scale() != Ok(None) {
                continue;
            }
            if known.iter().any(|keyword| is_spelling(keyword, &name)) {
                continue;
            }
            let scale = self.scale_of(&comment);
            let (epoch, slack_s) = match card.value() {
                Some(CardValue::Text(text)) => match parse_date(&text, scale) {
                    DateText::Moment(epoch) => (Some(epoch), 0.0),
                    DateText::Day(day) if role == Role::End => (self.late_day(day, scale), 0.0),
                    _ if bare.contains("UT") || bare.contains("TIME") || comment.has("ut utc time") => {
                        (self.near_start(&text, scale), 0.0)
                    }
                    _ => continue,
                },
                Some(CardValue::Real(days)) if days > 1e6 => {
                    (epoch_from_jd(days, scale).ok(), resolution(card) * DAY_S)
                }
                Some(CardValue::Real(days)) if name.contains("MJD") || comment.has("mjd") => {
                    (epoch_from_mjd(days, scale).ok(), resolution(card) * DAY_S)
                }
                _ => continue,
            };
            let other = epoch.map(|epoch| Instant { slack_s, ..instant(epoch, name, role) });
            self.instants.others.extend(other);
        }
    }

    /// Returns the beginning of a day that is after the first start, such as the last night of a stack.
    fn late_day(&self, day: [u32; 3], scale: TimeScale) -> Option<Epoch> {
        let start = self.first_start()?;
        at(day, [0, 0], 0.0, scale).filter(|midnight| *midnight > start)
    }

    fn first_start(&self) -> Option<Epoch> {
        self.instants.found.iter().find(|instant| instant.role == Role::Start).map(|instant| instant.epoch)
    }

    /// Returns the epoch of a time of day that is within half a day of the first start.
    fn near_start(&self, time: &str, scale: TimeScale) -> Option<Epoch> {
        let (start, (clock, seconds)) = (self.first_start()?, parse_time(time)?);
        let (year, month, day, ..) = start.to_gregorian(scale);
        let epoch = at([u32::try_from(year).ok()?, month.into(), day.into()], clock, seconds, scale)?;
        let late_days = (seconds_between(epoch, start) / DAY_S).round();
        Some(seconds_after(epoch, late_days * DAY_S))
    }

    /// Combines a date with the time of day in another keyword. Returns false if there is none.
    fn time_of(&mut self, day: [u32; 3], date: &str, text: &str, of_date: &Comment) -> Result<bool, Error> {
        if let Some((name, other, _)) = UNIVERSAL_DATES.iter().find_map(|name| self.keywords.text_and_comment(name))
            && let DateText::Day(other_day) = parse_date(&other, self.scale)
            && other_day != day
        {
            let given = format!("{text}, and {name} is {other}");
            // A Julian date may give the start.
            let error = Error::invalid(date.to_owned(), given, "one date in universal time; specify --start");
            self.instants.unusable.get_or_insert(error);
            return Ok(true);
        }
        if of_date.has("night nights evening") {
            let given = format!("{text:?}, perhaps the date of the evening, by its comment {:?}", of_date.text());
            let error = Error::invalid(date.to_owned(), given, "the date of the start in UTC, or --start");
            self.instants.unusable.get_or_insert(error);
            return Ok(true);
        }
        let mut has_time = false;
        for keyword in TIMES.iter().chain(LOOSE_TIMES).chain(OTHER_STARTS).chain(MIDDLES) {
            let Some((name, value, comment, slack_s)) = self.time(keyword) else { continue };
            let is_middle = MIDDLES.contains(keyword);
            // These keywords may also have a date or a number of days.
            let is_other = is_middle || OTHER_STARTS.contains(keyword);
            if is_other && (self.keywords.number(&[keyword], |_| true).is_some() || parse_time(&value).is_none()) {
                continue;
            }
            let usual = if is_middle { Role::Middle } else { Role::Start };
            let scale = if name == "TAIHMS" { TimeScale::TAI } else { self.scale_of(&comment) };
            let known = self.instants.found.len();
            self.tried.push(name.clone());
            // Some observatories write date and time in these keywords.
            if let DateText::Moment(epoch) = parse_date(&value, scale) {
                self.add(instant(epoch, name, Role::Start), &value, &[comment]);
            } else {
                let (clock, seconds) =
                    parse_time(&value).ok_or_else(|| unreadable(name.clone(), &value, "a time such as 00:30:00.5"))?;
                let epochs = at(day, clock, seconds, scale).zip(at(day, [0, 0], 0.0, scale));
                let (epoch, midnight) =
                    epochs.ok_or_else(|| unreadable(name.clone(), &value, "a time such as 00:30:00.5"))?;
                let day = Some((midnight, of_date.role(None).ok().flatten()));
                // The comment of the time determines the role, and that of the date if it states none.
                let is_loose_clock = LOOSE_TIMES.contains(keyword) && !states_start(&comment);
                let comments = [comment, of_date.clone()];
                let from = format!("{date} + {name}");
                let found = Instant { day, slack_s, is_loose_clock, ..instant(epoch, from, usual) };
                self.add(found, &value, &comments);
            }
            has_time = true;
            // If the time is unusable, for example local, another keyword may give it.
            if self.instants.found.len() > known {
                // If the local time is on the other side of midnight, the date may be the local one.
                let found = self.instants.found[known].epoch;
                let is_far = |local: &Epoch| seconds_between(*local, found).abs() > 0.5 * DAY_S;
                if self.instants.local.iter().any(is_far) {
                    self.instants.found.truncate(known);
                }
                break;
            }
        }
        Ok(has_time)
    }

    /// Returns the keyword, the text, the comment and the rounding error (seconds) of a time of day. A number is
    /// converted to a text if its comment states the unit, as in `UT = 11699.0 / [s]`.
    fn time(&self, keyword: &str) -> Option<(String, String, Comment, f64)> {
        let (header, name) = self.keywords.find(keyword)?;
        let comment = self.keywords.comment(header, &name);
        let unit_s = comment.unit_s().ok().flatten();
        let (text, slack_s) = match header.number(&name).zip(unit_s) {
            Some((number, unit_s)) => {
                let seconds = number * unit_s;
                let (hours, minutes) = ((seconds / 3600.0).floor(), (seconds / 60.0).floor() % 60.0);
                let text = format!("{hours:02}:{minutes:02}:{:06.3}", seconds.rem_euclid(60.0));
                (text, header.card(&name).map_or(0.0, resolution) * unit_s)
            }
            None => (header.text(&name)?, 0.0),
        };
        Some((name, text, comment, slack_s))
    }

    /// Reads a keyword with a date and time, a Julian date, or a time of day. A date without a time is ignored.
    fn any_form(&mut self, keyword: &str, role: Role) -> Result<(), Error> {
        let Some((header, from)) = self.keywords.find(keyword) else { return Ok(()) };
        if let Some(number) = header.number(&from) {
            if let Some(epoch) = unix_time(number) {
                self.instants.others.push(instant(epoch, from, role));
                return Ok(());
            }
            // The number of a frame
            if keyword == FRAME {
                return Ok(());
            }
            // Other numbers in EXPSTART and EXPEND count from another instant, and those of times of day are hours.
            let read = self.days(keyword, role, false);
            let is_days = ["DATE", "MJD", "JD"].iter().any(|name| keyword.starts_with(name));
            return if is_days { read } else { Ok(()) };
        }
        if let Some((from, value, comment)) = self.keywords.text_and_comment(keyword)
            && let DateText::Moment(epoch) = parse_date(&value, self.scale_of(&comment))
        {
            self.add(instant(epoch, from, role), &value, &[comment]);
        } else {
            let late_day = self.keywords.text_and_comment(keyword).and_then(|(name, text, comment)| {
                let DateText::Day(day) = parse_date(&text, self.scale) else { return None };
                let epoch = self.late_day(day, self.scale_of(&comment)).filter(|_| role == Role::End)?;
                Some(instant(epoch, name, role))
            });
            self.instants.others.extend(late_day);
            self.clock(keyword, role, role == Role::End);
        }
        Ok(())
    }

    /// Reads a time of day, which is within half a day of the first instant of the start. One that is loose is not
    /// loose if its comment states the start.
    fn clock(&mut self, keyword: &str, role: Role, is_loose: bool) {
        let Some((from, value, comment, slack_s)) = self.time(keyword) else { return };
        if self.tried.contains(&from) {
            return;
        }
        let is_loose = is_loose && (role == Role::End || !states_start(&comment));
        let scale = if from == "TAIHMS" { TimeScale::TAI } else { self.scale_of(&comment) };
        if let DateText::Moment(epoch) = parse_date(&value, scale) {
            return self.add(Instant { is_loose, ..instant(epoch, from, role) }, &value, &[comment]);
        }
        let Some(epoch) = self.near_start(&value, scale) else { return };
        self.add(Instant { is_loose, slack_s, ..instant(epoch, from, role) }, &value, &[comment]);
    }

    /// Reads a Julian date or a modified Julian date. One that is loose is not loose if its comment states the start.
    fn days(&mut self, keyword: &str, role: Role, is_loose: bool) -> Result<(), Error> {
        let Some((header, from)) = self.keywords.find(keyword) else { return Ok(()) };
        let comment = self.keywords.comment(header, &from);
        let scale = self.scale_of(&comment);
        let number = header.number(&from);
        let is_julian = keyword.starts_with("JD") || keyword == "OBSJD" || number.is_some_and(|days| days > 1e6);
        let value = header.card(&from).map(|card| card.text()[9..].trim().to_owned()).unwrap_or_default();
        let epoch = number.and_then(|number| {
            if is_julian { epoch_from_jd(number, scale).ok() } else { epoch_from_mjd(number, scale).ok() }
        });
        let Some(epoch) = epoch else {
            let allowed = if is_julian {
                "a Julian date between 1900 and 2200"
            } else {
                "a modified Julian date between 1900 and 2200"
            };
            return Err(unreadable(from, &value, allowed));
        };
        // A whole number beside a date is the number of the night.
        if is_loose
            && number.is_some_and(|days| days.fract() == 0.0)
            && self.instants.found.iter().any(|instant| !instant.is_loose)
        {
            return Ok(());
        }
        let text = value.split(['/', ' ']).next().unwrap_or_default();
        let least = number.map_or(0.0, |number| single_precision(number, text));
        let slack_s = header.card(&from).map_or(0.0, |card| resolution(card).max(least)) * DAY_S;
        let value = number.map_or(value, |number| number.to_string());
        let is_loose = is_loose && !states_start(&comment);
        self.add(Instant { slack_s, is_loose, ..instant(epoch, from, role) }, &value, &[comment]);
        Ok(())
    }

    /// Returns the scale of a date: that of TIMESYS, or else the one that its comment states. A date of which the
    /// comment states that it was converted to UTC is in UTC (files of HEASARC, whose TIMESYS is that of TSTART).
    fn scale_of(&self, comment: &Comment) -> TimeScale {
        if !self.is_stated {
            comment.scale().ok().flatten().unwrap_or(self.scale)
        } else if comment.is_converted_to_universal() {
            TimeScale::UTC
        } else {
            self.scale
        }
    }

    /// Adds an instant, with the role that the first comment with a role states, or else its own, the usual one.
    /// Instants that a comment, or a zone beside another scale than UTC, makes unusable are kept as errors.
    fn add(&mut self, instant: Instant, value: &str, comments: &[Comment]) {
        if instant.epoch.time_scale != TimeScale::UTC && has_zone(value) {
            let given = format!("{value:?}, which has a zone as in UTC, and its scale is {}", instant.epoch.time_scale);
            let error = Error::invalid(instant.from, given, "a time without Z or offset, TIMESYS = 'UTC', or --start");
            self.instants.unusable.get_or_insert(error);
            return;
        }
        let usual = instant.role;
        let is_named = usual != Role::Start || instant.from.split(" + ").any(names_start);
        let role = comments.iter().enumerate().try_fold(None, |role: Option<Role>, (at, comment)| {
            let of_comment = || {
                if !self.is_stated {
                    comment.scale()?;
                } else if instant.epoch.time_scale == self.scale && comment.contradicts(self.scale) {
                    return Err(OTHER_SCALE);
                }
                // The second comment is that of a date.
                comment.role((is_named && at == 0).then_some(usual))
            };
            of_comment().map(|stated| role.or(stated)).map_err(|problem| (comment, problem))
        });
        let is_of_device = |device: &str| {
            let devices = DEVICES.iter().filter_map(|keyword| self.keywords.text(&[keyword]));
            devices.into_iter().any(|(_, text)| text.to_ascii_lowercase().contains(device))
        };
        let starts = [DATES, TIMES, MODIFIED_DATES, JULIAN_DATES, OTHER_STARTS];
        let has_named_start = || {
            let mut named = starts.into_iter().flatten().filter(|name| names_start(name));
            named.any(|name| self.keywords.find(name).is_some())
        };
        let role = match role {
            Err((comment, AFTER_EXPOSURE))
                if instant.from == "DATE-OBS"
                    && comment.text().to_ascii_lowercase().contains(CREATED)
                    && is_of_device(CREATES_AT_END)
                    && !has_named_start() =>
            {
                self.instants.created.get_or_insert((instant.from.clone(), comment.text().to_owned()));
                Ok(Some(Role::End))
            }
            role => role,
        };
        let is_of_wise = || self.keywords.text(&["TELESCOP"]).is_some_and(|(_, name)| name == WITH_MIDDLES);
        let role = match role {
            Ok(None) if !is_named && is_of_wise() => {
                let sentence =
                    format!("{} is read as the middle of the exposure, as {WITH_MIDDLES} writes it", instant.from);
                self.instants.readings.push((instant.from.clone(), sentence));
                Ok(Some(Role::Middle))
            }
            role => role,
        };
        match role {
            Ok(role) => {
                if self.is_stated && instant.epoch.time_scale != self.scale {
                    let sentence =
                        format!("{} is read as UTC, by its comment, and not as {}", instant.from, self.scale);
                    self.instants.readings.push((instant.from.clone(), sentence));
                }
                let (_, clock) = date_and_time(without_offset(value).0);
                let is_without_seconds = clock.is_some_and(|clock| clock.matches(':').count() == 1);
                let slack_s = if is_without_seconds { MINUTE_S } else { instant.slack_s };
                let stated_s = comments.iter().filter_map(Comment::uncertainty_s);
                let slack_s = stated_s.fold(slack_s, f64::max);
                // A number of days that is computed from a date concerns the same part.
                let is_same =
                    |known: &&Instant| seconds_between(known.epoch, instant.epoch).abs() <= SAME_READING_S + slack_s;
                let same = || self.instants.found.iter().find(is_same).filter(|_| !is_named).map(|known| known.role);
                let of_same = role.or_else(same);
                let is_with_readout =
                    || self.keywords.text(&["TELESCOP"]).is_some_and(|(_, name)| name.starts_with(WITH_READOUT));
                let is_of_observation = |comment: &Comment| comment.has("end") && comment.has("observation obs");
                let readout = match usual {
                    Role::End if is_with_readout() => Readout::Included,
                    Role::End if comments.iter().any(is_of_observation) => Readout::Possible,
                    _ => Readout::Unknown,
                };
                // The comment of days also states that the date from which they are computed is the middle.
                let is_middle = role == Some(Role::Middle) && value.parse::<f64>().is_ok_and(|days| days > 1e4);
                for known in self.instants.found.iter_mut().filter(|_| is_middle && !is_named) {
                    if !known.is_role_stated && is_same(&&*known) {
                        known.role = Role::Middle;
                        let sentence =
                            format!("{} is read as the middle, by the comment of {}", known.from, instant.from);
                        self.instants.readings.push((known.from.clone(), sentence));
                    }
                }
                let is_role_stated = is_named || role.is_some();
                let (role, value) = (of_same.unwrap_or(usual), value.to_owned());
                self.instants.found.push(Instant { role, value, slack_s, is_role_stated, readout, ..instant });
            }
            Err((comment, problem)) => {
                if comment.is_local() || problem == OTHER_SCALE {
                    self.instants.local.push(instant.epoch);
                }
                let given = format!("{value:?}, {problem} by its comment {:?}", comment.text());
                let allowed =
                    "the start of the exposure in UTC, in this or another keyword (DATE-BEG, MJD-OBS, ...), or --start";
                let is_in_log = problem == AFTER_EXPOSURE && is_of_device(WITH_LOG);
                let allowed = format!(
                    "{allowed}{}",
                    if is_in_log { " (see the times of captures in Autorun_Log of the ASIAIR)" } else { "" }
                );
                self.instants.unusable.get_or_insert(Error::invalid(instant.from, given, allowed));
            }
        }
    }
}

fn instant(epoch: Epoch, from: String, role: Role) -> Instant {
    Instant {
        epoch,
        from,
        value: String::new(),
        slack_s: 0.0,
        role,
        is_loose: false,
        is_loose_clock: false,
        day: None,
        is_role_stated: false,
        readout: Readout::Unknown,
    }
}

/// Returns true for Julian dates and modified Julian dates of this century.
fn is_day_number(number: f64) -> bool {
    (51_544.0..88_069.0).contains(&number) || (2_451_544.5..2_488_069.5).contains(&number)
}

/// Returns the error of a number of days in single precision, days: half of its spacing, or the last digit of a number
/// such as 56990.8984375, which is that of 56990.9 and perhaps cut; 0 for other numbers.
fn single_precision(number: f64, text: &str) -> f64 {
    let decimals = |text: &str| text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let single = number as f32;
    // Fewer decimals, or zeros at the end, are those of a number that is exact.
    let is_exact = text.ends_with('0') || decimals(text) < 5;
    if f64::from(single) != number || is_exact {
        0.0
    } else if decimals(&single.to_string()) == 1 {
        0.1
    } else {
        f64::from(single.next_up() - single) / 2.0
    }
}

/// Returns the epoch of a number of seconds or milliseconds since 1970, for years from 2001 to 2096.
fn unix_time(number: f64) -> Option<Epoch> {
    let seconds = if number > 1e11 { number / 1e3 } else { number };
    (1e9..4e9).contains(&seconds).then(|| Epoch::from_unix_seconds(seconds))
}

fn states_start(comment: &Comment) -> bool {
    matches!(comment.role(None), Ok(Some(Role::Start)))
}

/// Returns the time of day in a text such as `8/21/2026 08:14:59 PM DST`, seconds.
fn clock_in(text: &str) -> Option<f64> {
    let (_, time) = date_and_time(without_offset(text).0);
    let ([hours, minutes], seconds) = parse_time(&time?)?;
    Some(f64::from(3600 * hours + 60 * minutes) + seconds)
}

pub(super) fn unreadable(keyword: String, value: &str, allowed: &str) -> Error {
    Error::invalid(keyword, format!("{value:?}"), allowed)
}
