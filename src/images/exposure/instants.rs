//! Instants in a header: start, middle or end of the exposure, by the name of the keyword and by its comment.

use hifitime::{Epoch, TimeScale};

use crate::constants::DAY_S;
use crate::error::Error;
use crate::frames::{epoch_from_jd, epoch_from_mjd, seconds_between};

use super::comment::{Comment, Role};
use super::instant::Instant;
use super::instant_keywords::{
    DATES, END_TIMES, ENDS, JULIAN_DATES, LAST_TIMES, LOCAL_TIMES, LOOSE_DATES, LOOSE_TIMES, MIDDLES, MODIFIED_DATES,
    OTHER_DATES, OTHER_STARTS, TIMES, UNIVERSAL_DATES,
};
use super::instant_part::{OTHER_SCALE, Part, hint_of_device, is_named, part_of};
use super::moment::{
    DateText, Keywords, at, date_and_time, has_zone, late_day, near, parse_date, parse_date_of, parse_time, resolution,
    unreadable, without_offset,
};
use super::other_instants::other_instants;
use super::relative::relative_instants;
use super::scale::DateScale;

/// Keyword of the start in headers of Andor, also that of the coordinates.
const FRAME: &str = "FRAME";

/// Rounding error of a time without seconds, seconds.
const MINUTE_S: f64 = 60.0;

/// Rounding error of one reading of a clock in two forms, seconds.
const SAME_READING_S: f64 = 0.01;
/// Largest error of days, seconds, that show that they are computed from a date: that of five decimals.
const SAME_DAYS_S: f64 = 0.5;

/// Largest difference between two instants that are computed from the same clock, seconds.
const SAME_CLOCK_S: f64 = 1.0;

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
    /// Dates of which days with the same value are the middle by their comment, with the keyword of the days.
    pub middles: Vec<(String, String)>,
    /// Keywords that are read in another way than usual, with a sentence each.
    pub readings: Vec<(String, String)>,
}

impl Instants {
    /// Reads all instants.
    ///
    /// # Errors
    /// A date or a time that cannot be parsed, or that is twice in the header.
    pub fn read(keywords: Keywords<'_>, dates: DateScale) -> Result<Self, Error> {
        let lists = [DATES, TIMES, MODIFIED_DATES, JULIAN_DATES, OTHER_STARTS, MIDDLES, ENDS];
        // FRAME is also the system of the coordinates.
        keywords.are_unique(lists.into_iter().flatten().copied().filter(|keyword| *keyword != FRAME))?;
        let mut reader = Reader { keywords, dates, tried: Vec::new(), instants: Self::default() };
        for keyword in DATES.iter().flat_map(|keyword| keywords.spellings(keyword)) {
            reader.date(&keyword)?;
        }
        // "UTDATE" of the AAT
        if DATES.iter().all(|keyword| keywords.find(keyword).is_none()) {
            for keyword in UNIVERSAL_DATES.iter().chain(OTHER_DATES) {
                // "2026:08:21 20:15:00" of EXIF is a local time.
                let is_of_exif = |text: &String| OTHER_DATES.contains(keyword) && text.as_bytes().get(4) == Some(&b':');
                let text = keywords.text(&[keyword]).map(|(_, text)| text).filter(|text| !is_of_exif(text));
                let date = text.map(|text| parse_date(&text, dates.scale));
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
            reader.add(Instant::new(epoch, from, Role::Start), &seconds.to_string(), &[Comment::new(&comment)]);
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
        let others = other_instants(keywords, dates, reader.first_start());
        reader.instants.others.extend(others);
        let relative = relative_instants(keywords, dates.scale).into_iter();
        reader.instants.others.extend(relative.map(|(epoch, name, role)| Instant::new(epoch, name.to_owned(), role)));
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
    dates: DateScale,
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
        let scale = self.dates.of(&comment);
        match parse_date_of(keyword, &value, scale) {
            DateText::Moment(epoch) => self.add(Instant::new(epoch, from, Role::Start), &value, &[comment]),
            DateText::Day(day) => {
                if !self.time_of(day, &from, &value, &comment)?
                    && !self.full_date(keyword, day)
                    && self.instants.day_alone.is_none()
                {
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

    /// Reads the date with a time of a date without one: the same keyword in another header, or a keyword of
    /// [`UNIVERSAL_DATES`] or [`OTHER_DATES`]. Returns false if there is none of this day.
    fn full_date(&mut self, keyword: &str, day: [u32; 3]) -> bool {
        let Some(midnight) = at(day, [0, 0], 0.0, self.dates.scale) else { return false };
        let names = [keyword].into_iter().chain(UNIVERSAL_DATES.iter().chain(OTHER_DATES).copied());
        let full = names.flat_map(|name| self.keywords.0.iter().map(move |header| (name, header))).find_map(
            |(name, header)| {
                let (from, text, comment) = Keywords(std::slice::from_ref(header)).text_and_comment(name)?;
                let DateText::Moment(epoch) = parse_date_of(name, &text, self.dates.of(&comment)) else { return None };
                let is_of_day = (0.0..=DAY_S).contains(&seconds_between(midnight, epoch));
                is_of_day.then_some((Instant::new(epoch, from, Role::Start), text, comment))
            },
        );
        let Some((instant, text, comment)) = full else { return false };
        self.add(instant, &text, &[comment]);
        true
    }

    /// Returns a date that is written as a number, such as 20260822, as text.
    fn basic(&self, keyword: &str) -> Option<(String, String, Comment)> {
        let is_date = |number: f64| number.fract() == 0.0 && (19_000_101.0..22_000_101.0).contains(&number);
        let (name, number, comment) = self.keywords.number(&[keyword], is_date)?;
        Some((name, number.to_string(), Comment::new(&comment)))
    }

    fn first_start(&self) -> Option<Epoch> {
        self.instants.found.iter().find(|instant| instant.role == Role::Start).map(|instant| instant.epoch)
    }

    /// Combines a date with the time of day in another keyword. Returns false if there is none.
    fn time_of(&mut self, day: [u32; 3], date: &str, text: &str, of_date: &Comment) -> Result<bool, Error> {
        if let Some((name, other, _)) = UNIVERSAL_DATES.iter().find_map(|name| self.keywords.text_and_comment(name))
            && let DateText::Day(other_day) = parse_date(&other, self.dates.scale)
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
        for keyword in TIMES.iter().chain(LOOSE_TIMES).chain(OTHER_STARTS).chain(MIDDLES).chain(LAST_TIMES) {
            let Some((name, value, comment, slack_s)) = self.time(keyword) else { continue };
            let is_middle = MIDDLES.contains(keyword);
            let is_last = LAST_TIMES.contains(keyword);
            // These keywords may also have a date or a number of days.
            let is_other = is_middle || is_last || OTHER_STARTS.contains(keyword);
            // "TIME = '00:01:00' / exposure time"
            let is_length =
                is_last && comment.has("exposure exp integration length duration") && !states_start(&comment);
            if is_length
                || is_other && (self.keywords.number(&[keyword], |_| true).is_some() || parse_time(&value).is_none())
            {
                continue;
            }
            let usual = if is_middle { Role::Middle } else { Role::Start };
            let scale = if name == "TAIHMS" { TimeScale::TAI } else { self.dates.of(&comment) };
            let known = self.instants.found.len();
            self.tried.push(name.clone());
            // Some observatories write date and time in these keywords.
            if let DateText::Moment(epoch) = parse_date(&value, scale) {
                self.add(Instant::new(epoch, name, Role::Start), &value, &[comment]);
            } else {
                let (clock, seconds) =
                    parse_time(&value).ok_or_else(|| unreadable(name.clone(), &value, "a time such as 00:30:00.5"))?;
                let epochs = at(day, clock, seconds, scale).zip(at(day, [0, 0], 0.0, scale));
                let (epoch, midnight) =
                    epochs.ok_or_else(|| unreadable(name.clone(), &value, "a time such as 00:30:00.5"))?;
                let day = Some((midnight, of_date.role(None).ok().flatten()));
                // The comment of the time determines the role, and that of the date if it states none.
                let is_loose_clock = (is_last || LOOSE_TIMES.contains(keyword)) && !states_start(&comment);
                let comments = [comment, of_date.clone()];
                let from = format!("{date} + {name}");
                let found = Instant { day, slack_s, is_loose_clock, ..Instant::new(epoch, from, usual) };
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
                self.instants.others.push(Instant::new(epoch, from, role));
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
            && let DateText::Moment(epoch) = parse_date(&value, self.dates.of(&comment))
        {
            self.add(Instant::new(epoch, from, role), &value, &[comment]);
        } else {
            let late_day = self.keywords.text_and_comment(keyword).and_then(|(name, text, comment)| {
                let DateText::Day(day) = parse_date(&text, self.dates.scale) else { return None };
                let scale = self.dates.of(&comment);
                let epoch = late_day(self.first_start()?, day, scale).filter(|_| role == Role::End)?;
                Some(Instant::new(epoch, name, role))
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
        let scale = if from == "TAIHMS" { TimeScale::TAI } else { self.dates.of(&comment) };
        if let DateText::Moment(epoch) = parse_date(&value, scale) {
            return self.add(Instant { is_loose, ..Instant::new(epoch, from, role) }, &value, &[comment]);
        }
        let Some(epoch) = self.first_start().and_then(|start| near(start, &value, scale)) else { return };
        self.add(Instant { is_loose, slack_s, ..Instant::new(epoch, from, role) }, &value, &[comment]);
    }

    /// Reads a Julian date or a modified Julian date. One that is loose is not loose if its comment states the start.
    fn days(&mut self, keyword: &str, role: Role, is_loose: bool) -> Result<(), Error> {
        let Some((header, from)) = self.keywords.find(keyword) else { return Ok(()) };
        let comment = self.keywords.comment(header, &from);
        let scale = self.dates.of(&comment);
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
        let text = value.split(['/', ' ']).next().unwrap_or_default();
        let least = number.map_or(0.0, |number| single_precision(number, text));
        let slack_s = header.card(&from).map_or(0.0, |card| resolution(card).max(least)) * DAY_S;
        // Beside a date, a whole number is that of the night, and days equal to DATE are those of the file.
        let is_of_other = number.is_some_and(|days| days.fract() == 0.0) || self.is_of_file(epoch, slack_s);
        if is_loose && is_of_other && self.instants.found.iter().any(|instant| !instant.is_loose) {
            return Ok(());
        }
        let value = number.map_or(value, |number| number.to_string());
        let is_loose = is_loose && !states_start(&comment);
        self.add(Instant { slack_s, is_loose, ..Instant::new(epoch, from, role) }, &value, &[comment]);
        Ok(())
    }

    /// Returns true for the time in DATE, at which the file was written.
    fn is_of_file(&self, epoch: Epoch, slack_s: f64) -> bool {
        let written = self.keywords.text_and_comment("DATE").map(|(_, text, of)| parse_date(&text, self.dates.of(&of)));
        matches!(written, Some(DateText::Moment(written))
            if seconds_between(written, epoch).abs() <= SAME_READING_S + slack_s)
    }

    /// Adds an instant, with the part that its comments state, or else its own, the usual one. One that a comment, or a
    /// zone beside another scale than UTC, makes unusable is kept as an error.
    fn add(&mut self, instant: Instant, value: &str, comments: &[Comment]) {
        if instant.epoch.time_scale != TimeScale::UTC && has_zone(value) {
            let given = format!("{value:?}, which has a zone as in UTC, and its scale is {}", instant.epoch.time_scale);
            let error = Error::invalid(instant.from, given, "a time without Z or offset, TIMESYS = 'UTC', or --start");
            self.instants.unusable.get_or_insert(error);
            return;
        }
        let Part { role, reading } = match part_of(self.keywords, self.dates, &instant, comments) {
            Ok(part) => part,
            Err((comment, problem)) => return self.reject(instant, value, comment, problem),
        };
        self.instants.readings.extend(reading.map(|sentence| (instant.from.clone(), sentence)));
        let (_, clock) = date_and_time(without_offset(value).0);
        let is_without_seconds = clock.is_some_and(|clock| clock.matches(':').count() == 1);
        let slack_s = if is_without_seconds { MINUTE_S } else { instant.slack_s };
        let slack_s = comments.iter().filter_map(Comment::uncertainty_s).fold(slack_s, f64::max);
        let is_named = is_named(&instant);
        // A number of days that is computed from a date concerns the same part.
        let is_same = |known: &&Instant| seconds_between(known.epoch, instant.epoch).abs() <= SAME_READING_S + slack_s;
        let same = || self.instants.found.iter().find(is_same).filter(|_| !is_named).map(|known| known.role);
        let is_role_stated = is_named || role.is_some();
        let usual = instant.role;
        let is_of_observation =
            usual == Role::End && comments.iter().any(|comment| comment.has("end") && comment.has("observation obs"));
        // The comment of days also states that the date from which they are computed is the middle. Coarse days may be
        // computed from the middle and agree with the start.
        let is_fine = slack_s <= SAME_DAYS_S;
        if role == Some(Role::Middle) && is_fine && !is_named && value.parse::<f64>().is_ok_and(|days| days > 1e4) {
            let dates = self.instants.found.iter().filter(is_same).filter(|known| !known.is_role_stated);
            let middles = dates.map(|known| (known.from.clone(), instant.from.clone()));
            self.instants.middles.extend(middles.collect::<Vec<_>>());
        }
        let (role, value) = (role.or_else(same).unwrap_or(usual), value.to_owned());
        self.instants.found.push(Instant { role, value, slack_s, is_role_stated, is_of_observation, ..instant });
    }

    /// Keeps the error of an unusable instant.
    fn reject(&mut self, instant: Instant, value: &str, comment: &Comment, problem: &str) {
        if comment.is_local() || problem == OTHER_SCALE {
            self.instants.local.push(instant.epoch);
        }
        let given = format!("{value:?}, {problem} by its comment {:?}", comment.text());
        let hint = hint_of_device(self.keywords, problem);
        let allowed = format!(
            "the start of the exposure in UTC, in this or another keyword (DATE-BEG, MJD-OBS, ...), or --start{hint}"
        );
        self.instants.unusable.get_or_insert(Error::invalid(instant.from, given, allowed));
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
